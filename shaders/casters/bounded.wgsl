// As `casters/volume.wgsl`, where a device has no depth-bounds test: a fragment reads the depth of what is seen in
// a copy, and is discarded where that lies outside of its volume's range.
#import shared/view.wgsl

@group(1) @binding(0) var depth: texture_depth_2d;
// Of each volume: least and greatest reversed depth.
@group(1) @binding(1) var<storage, read> ranges: array<vec2<f32>>;

struct Bounded {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) range: vec2<f32>,
};

@vertex
fn vertex_main(
    // Bits of f32: x, y, z, and w.
    @location(0) along: vec3<i32>,
    @location(1) w: u32,
    @builtin(instance_index) volume: u32,
) -> Bounded {
    let clip = clip_from_eye_relative(bitcast<vec3<f32>>(along));
    // A direction lies at infinity, where reversed depth is 0.
    let place = vec4<f32>(clip.xy, clip.z * bitcast<f32>(w), clip.w);
    return Bounded(place, ranges[volume]);
}

@fragment
fn no_colour(in: Bounded) {
    let seen = textureLoad(depth, vec2<u32>(in.clip.xy), 0);
    if seen < in.range.x || seen > in.range.y {
        discard;
    }
}

// For counting fragments, as `shared/volume.wgsl` has it.
@fragment
fn counted(in: Bounded) -> @location(0) vec4<f32> {
    return vec4<f32>(in.range, 1.0, 1.0);
}
