// Stencil pass of `vertex/doubled`: one invocation moves one of a vertex's two copies along the
// geodetic normal, the unflagged one to the top cap, the flagged one to the bottom cap.
// Cozzi (2007) stored two copies and moved the flagged one down in the vertex shader.
#import shared/view.wgsl
#import shared/region.wgsl

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

// For passes that also hold a colour target: volumes leave it alone.
@fragment
fn no_colour() {}

// Colour pass by volumes: the same positions, and the region's colour.
struct Coloured {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
};

@vertex
fn coloured_main(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude(position, is_bottom, region_index), regions[region_index].colour);
}

@fragment
fn region_colour(in: Coloured) -> @location(0) vec4<f32> {
    return in.colour;
}
