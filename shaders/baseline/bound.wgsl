// Bound pass: one fragment reads its pixel's depth and writes a constant colour; what any technique
// that looks at depth in a shader must pay. The colour depends on the depth in a way that no
// compiler can see through, so that the read stays: depth is never negative.

@group(0) @binding(0) var depth: texture_depth_2d;

@vertex
fn vertex_main(@builtin(vertex_index) vertex_index: u32) -> @builtin(position) vec4<f32> {
    let x = f32(i32(vertex_index & 1u) * 4 - 1);
    let y = f32(i32(vertex_index >> 1u) * 4 - 1);
    return vec4<f32>(x, y, 1.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let d = textureLoad(depth, vec2<i32>(pixel.xy), 0);
    return select(vec4<f32>(1.0, 0.8, 0.2, 1.0), vec4<f32>(0.0), d < 0.0);
}
