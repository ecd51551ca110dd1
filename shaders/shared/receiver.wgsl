// What each pixel sees, as a place from the eye, and whether a triangle that faces the sun lies sunwards of it.

struct Receivers {
    // Axes of the view times the tangents of half its fields, and the direction ahead.
    right: vec4<f32>,
    up: vec4<f32>,
    ahead: vec4<f32>,
    to_light: vec4<f32>,
    // Pixels.
    size: vec2<u32>,
    triangles: u32,
    near_m: f32,
    // A place this far below a triangle, m a metre of depth, counts as on it: depths are no more exact.
    margin: f32,
};

@group(0) @binding(0) var<uniform> receivers: Receivers;
// Reversed depth of each pixel, row by row; 0 for the sky.
@group(0) @binding(1) var<storage, read> depths: array<f32>;
// Places of casters from the eye, m.
@group(0) @binding(2) var<storage, read> places: array<vec4<f32>>;
// Their triangles, counter-clockwise seen from outside.
@group(0) @binding(3) var<storage, read> triangles: array<vec4<u32>>;

// Direction through a place of the image in pixels, 1 m deep.
fn ray_through(pixel: vec2<f32>) -> vec3<f32> {
    let share = 2.0 * pixel / vec2<f32>(receivers.size) - 1.0;
    return receivers.ahead.xyz + share.x * receivers.right.xyz - share.y * receivers.up.xyz;
}

// How deep what a pixel sees is, m; 0 for the sky.
fn depth_m(at: u32) -> f32 {
    let depth = depths[at];
    return select(0.0, receivers.near_m / depth, depth > 0.0);
}

fn centre(pixel: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(pixel) + 0.5;
}

// Unit normal of a triangle, outwards.
fn outward(triangle: vec4<u32>) -> vec3<f32> {
    let first = places[triangle.x].xyz;
    return normalize(cross(places[triangle.y].xyz - first, places[triangle.z].xyz - first));
}

// Whether a place lies below the plane of a triangle.
fn is_below(place: vec3<f32>, depth: f32, triangle: vec4<u32>) -> bool {
    let height = dot(outward(triangle), place - places[triangle.x].xyz);
    return height < -receivers.margin * depth;
}
