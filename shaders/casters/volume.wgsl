// Volumes of objects' shadows: one invocation brings a homogeneous vertex to clip space, a place relative
// to the eye (w = 1) or a direction (w = 0).
#import shared/view.wgsl
#import shared/volume.wgsl

@vertex
fn vertex_main(
    // Bits of f32: x, y, z, and w.
    @location(0) along: vec3<i32>,
    @location(1) w: u32,
) -> @invariant @builtin(position) vec4<f32> {
    let clip = clip_from_eye_relative(bitcast<vec3<f32>>(along));
    // A direction lies at infinity, where reversed depth is 0.
    return vec4<f32>(clip.xy, clip.z * bitcast<f32>(w), clip.w);
}
