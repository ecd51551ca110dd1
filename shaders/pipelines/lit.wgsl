// Study `pipelines`: one vertex invocation places one of six vertices of a cell of the grid; one fragment looks
// its place up in the depth map of every light and writes which of them reach it.
#import shared/lit.wgsl

@fragment
fn fragment_main(@location(0) place: vec3<f32>) -> @location(0) vec4<f32> {
    var mask = 0u;
    for (var number = 0u; number < lights.count; number += 1u) {
        let seen = seen_by(number, place);
        if depth_at(texel_of(seen.xy), number) <= seen.z + lights.bias {
            mask |= 1u << number;
        }
    }
    // From 1, since 0 is what is not drawn.
    return colour_of(mask + 1u);
}
