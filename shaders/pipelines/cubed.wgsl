// Study `pipelines`: one vertex invocation places one of six vertices of a cell of the grid; one fragment looks its place
// up in the face of a cube of depths that it lies before, and writes which face that is and whether the cube's middle
// sees it.
#import shared/lit.wgsl

@fragment
fn fragment_main(@location(0) place: vec3<f32>) -> @location(0) vec4<f32> {
    for (var face = 0u; face < 6u; face += 1u) {
        let seen = seen_by(face, place);
        if seen.w > 0.0 && max(abs(seen.x), abs(seen.y)) <= seen.w {
            let nearest = depth_at(texel_of(seen.xy / seen.w), face);
            let is_seen = nearest * seen.w <= seen.z * (1.0 + lights.bias);
            return colour_of(1u + 2u * face + select(0u, 1u, is_seen));
        }
    }
    // The middle itself.
    return colour_of(13u);
}
