// Volumes of `vertex/doubled`, `separate` and `per-triangle`: one invocation moves one of a vertex's
// two copies along a normal, the unflagged one to the top cap, the flagged one to the
// bottom cap. Cozzi (2007) stored two copies and moved the flagged one down in the vertex shader.
#import shared/view.wgsl
#import shared/region.wgsl
#import shared/volume.wgsl

// Pixels by which the bottom lies lower at the least, at the vertex's distance from the eye; 0: it lies
// where the plan has it. Cozzi (2007, 4.2) made room so for planets that are drawn coarser from afar.
override BOTTOM_PX: f32 = 0.0;

fn cap_height_m(is_bottom: u32, region_index: u32) -> f32 {
    return select(
        regions[region_index].top_m,
        regions[region_index].bottom_m,
        is_bottom != 0u,
    );
}

fn height_m(position: vec3<i32>, is_bottom: u32, region_index: u32) -> f32 {
    let planned_m = cap_height_m(is_bottom, region_index);
    if BOTTOM_PX > 0.0 && is_bottom != 0u {
        let distance_m = length(on_ellipsoid(position, region_index).relative_m);
        return min(planned_m, -distance_m * view.pixel_per_distance * BOTTOM_PX);
    }
    return planned_m;
}

fn extrude(position: vec3<i32>, is_bottom: u32, region_index: u32) -> vec4<f32> {
    let height_m = height_m(position, is_bottom, region_index);
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

// The same for positions of two floats, which need an attribute more.
fn extrude_two_float(
    high: vec3<i32>,
    low: vec3<i32>,
    is_bottom: u32,
    region_index: u32,
) -> vec4<f32> {
    return clip_from_eye_relative(two_float_relative_m(
        bitcast<vec3<f32>>(high),
        bitcast<vec3<f32>>(low),
        region_index,
        cap_height_m(is_bottom, region_index),
    ));
}

@vertex
fn two_float_main(
    @location(0) high: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(2) low: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude_two_float(high, low, is_bottom, region_index);
}

@vertex
fn coloured_two_float(
    @location(0) high: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(2) low: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    let clip = extrude_two_float(high, low, is_bottom, region_index);
    return Coloured(clip, regions[region_index].colour);
}

@vertex
fn numbered_two_float(
    @location(0) high: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(2) low: vec3<i32>,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    return numbered(extrude_two_float(high, low, is_bottom, region_index), region_index);
}

// The same along normals that are stored, an attribute more.
fn extrude_along(
    position: vec3<i32>,
    normal: vec3<f32>,
    is_bottom: u32,
    region_index: u32,
) -> vec4<f32> {
    let height_m = height_m(position, is_bottom, region_index);
    let relative_m = stored_normal_relative_m(position, normal, region_index, height_m);
    return clip_from_eye_relative(relative_m);
}

@vertex
fn normal_main(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(3) normal: vec3<f32>,
    @builtin(instance_index) region_index: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return extrude_along(position, normal, is_bottom, region_index);
}

@vertex
fn coloured_normal(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(3) normal: vec3<f32>,
    @builtin(instance_index) region_index: u32,
) -> Coloured {
    let clip = extrude_along(position, normal, is_bottom, region_index);
    return Coloured(clip, regions[region_index].colour);
}

@vertex
fn numbered_normal(
    @location(0) position: vec3<i32>,
    @location(1) is_bottom: u32,
    @location(3) normal: vec3<f32>,
    @builtin(instance_index) region_index: u32,
) -> Numbered {
    let clip = extrude_along(position, normal, is_bottom, region_index);
    return numbered(clip, region_index);
}
