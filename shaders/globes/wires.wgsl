// Edges of any surface's triangles as lines: one vertex invocation places a corner, one fragment is white.
#import shared/view.wgsl

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>) -> @builtin(position) vec4<f32> {
    return clip_from_eye_relative(relative_m);
}

@fragment
fn fragment_main() -> @location(0) vec4<f32> {
    return vec4<f32>(1.0);
}
