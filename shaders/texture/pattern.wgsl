// Placement of a pattern whose texels per pixel stay constant: a texel spans 2^k metres, k real per
// pixel. The pictures of the two whole k next to it are mixed, so that the pattern neither comes apart
// close up nor clumps far away. `u` and `v` hold the map for k = 0.

fn place(angles: vec2<f32>, steps: vec4<f32>, distance_m: f32) -> Place {
    let k = log2(distance_m * textured.texel_per_m);
    let footprint = footprint_of(steps);
    let level = log2(max(footprint * exp2(-floor(k)), 1.0));
    return Place(uv_of(angles), level, k, footprint);
}

fn picture(at: Place) -> vec4<f32> {
    let whole = floor(at.pattern_level);
    let uv = at.uv * exp2(-whole);
    let coarser_level = max(at.level - 1.0, 0.0);
    return mix(
        textureSampleLevel(image, image_sampler, uv, at.level),
        textureSampleLevel(image, image_sampler, uv * 0.5, coarser_level),
        at.pattern_level - whole,
    );
}
