// A picture that looks layers up, and whose pixels are the bits of a number each.
#import shared/layers.wgsl

@group(0) @binding(3) var maps: texture_2d_array<f32>;
// Of each pixel.
@group(0) @binding(4) var<storage, read> values: array<f32>;

// One triangle covers the picture.
fn whole_picture(vertex: u32) -> vec4<f32> {
    let at = vec2<f32>(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    return vec4<f32>(2.0 * at - 1.0, 0.5, 1.0);
}

fn bits(number: f32) -> vec4<f32> {
    return unpack4x8unorm(bitcast<u32>(number));
}
