// Volumes of `vertex/doubled` drawn many at a time (`draws=merged`): one invocation moves one of a vertex's
// two copies along a normal, as in doubled.wgsl. The word behind the position says which copy it is and
// of which region, so that one draw may hold the volumes of many regions.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

// By region: the index of its volume's constants in this view.
@group(1) @binding(0) var<storage, read> volume_of_region: array<u32>;

// `flags`: bit 0 sends the vertex to the bottom cap, the others are the number of its region.
fn extrude(position: vec3<i32>, flags: u32, region_index: u32) -> vec4<f32> {
    let height_m = select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        (flags & 1u) != 0u,
    );
    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));
}

@vertex
fn vertex_main(
    @location(0) position: vec3<i32>,
    @location(1) flags: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude(position, flags, volume_of_region[flags >> 1u]);
}

@vertex
fn coloured_main(@location(0) position: vec3<i32>, @location(1) flags: u32) -> Coloured {
    let region_index = volume_of_region[flags >> 1u];
    return Coloured(extrude(position, flags, region_index), regions[region_index].colour);
}

@vertex
fn numbered_main(@location(0) position: vec3<i32>, @location(1) flags: u32) -> Numbered {
    let region_index = volume_of_region[flags >> 1u];
    return numbered(extrude(position, flags, region_index), region_index);
}
