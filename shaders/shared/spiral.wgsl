// The spiral about a focus (Gebbie and Bailey, with the focus-local form of position): from the focus to a place on the
// body, metres along ECEF axes.

struct SpiralConstants {
    // Columns: the focus's east, north and up on the body, metres.
    east: vec3<f32>,
    inner: f32,
    north: vec3<f32>,
    outer: f32,
    up: vec3<f32>,
    turns: f32,
    // The focus from the eye.
    focus: vec3<f32>,
    per_turn: u32,
    count: u32,
    // 0: radii grow by the same factor; 1: their roots by equal steps; 2: as stored, corrected by a square root.
    law: u32,
    // Of all stored vertices, the first of this view.
    first: u32,
};

// 1: Taylor's series of ninth and tenth order for sine and cosine of the radius, and angles by a table's exactness: the
// specification bounds native ones by 2^-11 alone.
override SERIES: u32 = 0u;

fn sine(x: f32) -> f32 {
    if SERIES == 0u {
        return sin(x);
    }
    let s = x * x;
    return x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0))));
}

// From the focus to a place on the body in a direction, by sine and cosine from the north, at an angle from the centre.
fn reached(spiral: SpiralConstants, direction: vec2<f32>, radius: f32) -> vec3<f32> {
    let half_sine = sine(0.5 * radius);
    let level = spiral.east * direction.x + spiral.north * direction.y;
    return level * sine(radius) - spiral.up * (2.0 * half_sine * half_sine);
}

// The same to a stored vertex. What lies before the first of the view is the fan's centre; what lies beyond the horizon
// ends on it.
fn stored_way(spiral: SpiralConstants, vertex: vec3<f32>) -> vec3<f32> {
    if vertex.z < spiral.inner {
        return vec3<f32>(0.0);
    }
    var radius = min(vertex.z, spiral.outer);
    if spiral.law == 2u {
        let span = spiral.outer - spiral.inner;
        radius = sqrt((radius - spiral.inner) / span) * span + spiral.inner;
    }
    return reached(spiral, vertex.xy, radius);
}
