// Placement by extents or by an anchor: one picture, linear in the angles.

fn place(region_index: u32, angles: vec2<f32>, steps: vec4<f32>, distance_m: f32) -> Place {
    let footprint = footprint_of(region_index, steps);
    return Place(uv_of(region_index, angles), log2(max(footprint, 1.0)), 0.0, footprint);
}

fn picture(at: Place) -> vec4<f32> {
    return textureSampleLevel(image, image_sampler, at.uv, at.level);
}
