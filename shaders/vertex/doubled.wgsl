// Volumes of `vertex/doubled`, `separate` and `per-triangle`: one invocation moves one of a vertex's
// two copies along the geodetic normal, the unflagged one to the top cap, the flagged one to the
// bottom cap. Cozzi (2007) stored two copies and moved the flagged one down in the vertex shader.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

fn extrude(position: vec3<i32>, is_bottom: u32, region_index: u32) -> vec4<f32> {
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        is_bottom != 0u,
    );
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

@vertex
fn vertex_main(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude(position, is_bottom, region_index);
}

@vertex
fn coloured_main(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude(position, is_bottom, region_index), regions[region_index].colour);
}

@vertex
fn numbered_main(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude(position, is_bottom, region_index), region_index);
}
