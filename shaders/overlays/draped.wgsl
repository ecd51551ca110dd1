// Draped mesh: one invocation is a corner of a piece of a region that lies in a triangle of the surface,
// metres from the eye. Its depth is greater than the surface's by a stated share, so that it wins the
// test. One fragment writes the region's colour.
#import shared/view.wgsl

@group(0) @binding(1) var<storage, read> colours: array<vec4<f32>>;

// x: 1 and the share.
@group(0) @binding(2) var<uniform> nearer: vec4<f32>;

struct Draped {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
};

@vertex
fn vertex_main(@location(0) from_eye_m: vec3<f32>, @location(1) region: u32) -> Draped {
    let clip = clip_from_eye_relative(from_eye_m);
    return Draped(vec4<f32>(clip.xy, clip.z * nearer.x, clip.w), colours[region]);
}

@fragment
fn fragment_main(in: Draped) -> @location(0) vec4<f32> {
    return in.colour;
}
