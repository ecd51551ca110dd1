// Study `balls`: one vertex invocation places a ball, wherever its step left it, as a point. Fragments write its
// number, from 1.
#import shared/balls.wgsl

struct PointConstants {
    // Columns of the matrix from metres to clip space.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    origin: vec4<f32>,
};

@group(0) @binding(0) var<uniform> constants: PointConstants;
@group(0) @binding(1) var<storage, read> balls: array<Ball>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

@vertex
fn vertex_main(@builtin(vertex_index) ball: u32) -> Varying {
    let place = balls[ball].place;
    // By fused steps, so that no compiler has a choice.
    let level = fma(constants.z, vec4<f32>(place.z), constants.origin);
    let row = fma(constants.y, vec4<f32>(place.y), level);
    return Varying(fma(constants.x, vec4<f32>(place.x), row), ball + 1u);
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return unpack4x8unorm(number | 0xff000000u);
}
