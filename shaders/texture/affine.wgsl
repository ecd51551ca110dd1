// Placement by extents or by an anchor: one picture, linear in the angles.

fn place(angles: vec2<f32>, steps: vec4<f32>, distance_m: f32) -> Place {
    let footprint = footprint_of(steps);
    return Place(uv_of(angles), log2(max(footprint, 1.0)), 0.0, footprint);
}

fn picture(at: Place) -> vec4<f32> {
    return textureSampleLevel(image, image_sampler, at.uv, at.level);
}
