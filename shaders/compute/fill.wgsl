// Volumes of `compute`: one invocation is one corner of a list that the compute pass wrote.
// The corner's number says which stored vertex it is, and on which cap: 2·vertex + 1 is the bottom.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

// x, y, z of vertex i at 3i, 3i + 1, 3i + 2.
@group(1) @binding(0) var<storage, read> positions: array<i32>;

fn extrude(corner: u32, region_index: u32) -> vec4<f32> {
    let first = 3u * (regions[region_index].first_vertex + (corner >> 1u));
    let position = vec3<i32>(positions[first], positions[first + 1u], positions[first + 2u]);
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        (corner & 1u) != 0u,
    );
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

@vertex
fn vertex_main(
    @builtin(vertex_index) corner: u32,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude(corner, region_index);
}

@vertex
fn coloured_main(
    @builtin(vertex_index) corner: u32,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(extrude(corner, region_index), regions[region_index].colour);
}

@vertex
fn numbered_main(
    @builtin(vertex_index) corner: u32,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude(corner, region_index), region_index);
}

// The same for corners that the compute pass has put into clip space.
@vertex
fn placed_main(@location(0) clip: vec4<f32>) -> @invariant @builtin(position) vec4<f32> {
    return clip;
}

@vertex
fn placed_coloured(
    @location(0) clip: vec4<f32>,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    return Coloured(clip, regions[region_index].colour);
}

@vertex
fn placed_numbered(
    @location(0) clip: vec4<f32>,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(clip, region_index);
}
