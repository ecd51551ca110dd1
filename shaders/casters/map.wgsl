// A shadow map of casters. First one invocation a vertex of a caster, seen from the sun; then a vertex of sea or
// caster, seen from the eye, and a fragment that asks the texel that it lies in.

struct Asking {
    // Axes of the view over the tangents of half its fields, and the direction ahead.
    right: vec4<f32>,
    up: vec4<f32>,
    ahead: vec4<f32>,
    // Texels of the map along either axis.
    size: vec2<f32>,
    // Length of the map's depth along the light, m.
    depth_m: f32,
    // Metres of bias, and texels of bias times the slope, of so many metres.
    constant_m: f32,
    slope_m: f32,
    near_m: f32,
    unused: vec2<f32>,
};

@group(0) @binding(0) var<uniform> asking: Asking;
@group(0) @binding(1) var map: texture_depth_2d;

// `in_map`: column and row over the map's, and height along the light over its depth, 1 next to the sun.
@vertex
fn from_sun(@location(1) in_map: vec3<f32>) -> @builtin(position) vec4<f32> {
    return vec4<f32>(2.0 * in_map.x - 1.0, 1.0 - 2.0 * in_map.y, in_map.z, 1.0);
}

struct Seen {
    @builtin(position) clip: vec4<f32>,
    @location(0) in_map: vec3<f32>,
    // Cosine between the face and the sun.
    @location(1) @interpolate(flat) cosine: f32,
};

@vertex
fn from_eye(
    // From the eye, m.
    @location(0) relative: vec3<f32>,
    @location(1) in_map: vec3<f32>,
    @location(2) cosine: f32,
) -> Seen {
    let clip = vec4<f32>(
        dot(relative, asking.right.xyz),
        dot(relative, asking.up.xyz),
        asking.near_m,
        dot(relative, asking.ahead.xyz),
    );
    return Seen(clip, in_map, cosine);
}

@fragment
fn ask(seen: Seen) -> @location(0) f32 {
    // Faces turned away are dark without asking.
    if seen.cosine <= 0.0 {
        return 1.0;
    }
    let place = seen.in_map.xy * asking.size;
    if any(place < vec2<f32>(0.0)) || any(place >= asking.size) {
        return 0.0;
    }
    let nearest = textureLoad(map, vec2<u32>(place), 0);
    let slope = sqrt(max(1.0 - seen.cosine * seen.cosine, 0.0)) / seen.cosine;
    let above_m = (nearest - seen.in_map.z) * asking.depth_m;
    // 0 where nothing was drawn.
    let is_dark = nearest > 0.0 && above_m > asking.constant_m + asking.slope_m * slope;
    return select(0.0, 1.0, is_dark);
}
