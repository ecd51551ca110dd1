// `native` with a geometry shader: one invocation puts a stored vertex on the top cap and on the
// bottom cap of its volume, so that the geometry shader needs no matrices: it only chooses.
// Every clip position has the near plane's distance as its z, so the bottom cap's keeps that place
// free for the vertex's number: by it the geometry shader knows two corners to be one, exactly,
// where positions could agree by rounding.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

struct Extruded {
    @builtin(position) @invariant top: vec4<f32>,
    // x, y and w of the bottom's clip position, and the vertex's number.
    @location(0) bottom_and_number: vec4<f32>,
};

struct ColouredCorner {
    @builtin(position) @invariant top: vec4<f32>,
    @location(0) bottom_and_number: vec4<f32>,
    @location(1) @interpolate(flat) colour: vec4<f32>,
};

struct NumberedCorner {
    @builtin(position) @invariant top: vec4<f32>,
    @location(0) bottom_and_number: vec4<f32>,
    @location(1) @interpolate(flat) region_number: f32,
};

fn extrude(position: vec3<i32>, vertex_index: u32, region_index: u32) -> Extruded {
    let top_m = eye_relative_m(position, region_index, regions[region_index].top_m);
    let bottom_m = eye_relative_m(position, region_index, regions[region_index].bottom_m);
    let bottom = clip_from_eye_relative(bottom_m);
    return Extruded(clip_from_eye_relative(top_m), vec4<f32>(bottom.xyw, f32(vertex_index)));
}

@vertex
fn vertex_main(
    @location(0) position: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> Extruded {
    return extrude(position, vertex_index, region_index);
}

// For covers by volume.
@vertex
fn coloured_main(
    @location(0) position: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> ColouredCorner {
    let corner = extrude(position, vertex_index, region_index);
    return ColouredCorner(corner.top, corner.bottom_and_number, regions[region_index].colour);
}

// For the accumulation of numbers.
@vertex
fn numbered_main(
    @location(0) position: vec3<i32>,
    @builtin(vertex_index) vertex_index: u32,
    @builtin(instance_index) region_index: u32,
) -> NumberedCorner {
    let corner = extrude(position, vertex_index, region_index);
    return NumberedCorner(corner.top, corner.bottom_and_number, f32(region_index + 1u));
}
