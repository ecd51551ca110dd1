// Surface pass: one vertex invocation places a vertex of the planet; one fragment shades it as if
// lit from the eye. Alpha stays 0, so that a pixel with alpha 1 was coloured by a fill.
#import shared/view.wgsl

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
};

@vertex
fn vertex_main(@location(0) relative_m: vec3<f32>) -> Varying {
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) vec4<f32> {
    let normal = normalize((in.relative_m + view.eye_ecef) * view.normal_scale);
    let facing = max(-dot(normal, normalize(in.relative_m)), 0.0);
    let shade = 0.35 + 0.65 * sqrt(facing);
    return vec4<f32>(vec3<f32>(0.36, 0.46, 0.58) * shade, 0.0);
}
