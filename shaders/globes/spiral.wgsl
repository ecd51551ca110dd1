// The spiral made on the GPU (Gebbie and Bailey, with the focus-local form of position): one compute invocation makes a
// vertex into a buffer, from nothing but its number; one vertex invocation reads it there, or makes it itself. One
// fragment writes the bits of its distance, so that two pictures can be held to each other exactly. Metres from the
// eye, ECEF axes. Workgroups of 64, the least that all devices have.
#import shared/view.wgsl

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
    // 0: radii grow by the same factor; 1: their roots by equal steps.
    law: u32,
};

// 1: Taylor's series of ninth and tenth order for sine and cosine of the radius, and angles by a table's exactness: the
// specification bounds native ones by 2^-11 alone.
override SERIES: u32 = 0u;

@group(1) @binding(0) var<uniform> spiral: SpiralConstants;
// Sine and cosine of each vertex of a turn.
@group(1) @binding(1) var<storage, read> directions: array<vec2<f32>>;
@group(1) @binding(2) var<storage, read_write> made: array<f32>;

const TAU: f32 = 6.2831853;

fn sine(x: f32) -> f32 {
    if SERIES == 0u {
        return sin(x);
    }
    let s = x * x;
    return x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0))));
}

// Vertex 0 is the centre of the fan.
fn place(number: u32) -> vec3<f32> {
    if number == 0u {
        return spiral.focus;
    }
    let k = number - 1u;
    let share = min(f32(k) / f32(spiral.per_turn) / spiral.turns, 1.0);
    var radius = spiral.inner * exp2(share * log2(spiral.outer / spiral.inner));
    if spiral.law == 1u {
        let root = sqrt(spiral.inner) + share * (sqrt(spiral.outer) - sqrt(spiral.inner));
        radius = root * root;
    }
    if share >= 1.0 {
        radius = spiral.outer;
    }
    let at = k % spiral.per_turn;
    var direction = directions[at];
    if SERIES == 0u {
        let angle = TAU * f32(at) / f32(spiral.per_turn);
        direction = vec2<f32>(sin(angle), cos(angle));
    }
    let half_sine = sine(0.5 * radius);
    let level = spiral.east * direction.x + spiral.north * direction.y;
    return (level * sine(radius) - spiral.up * (2.0 * half_sine * half_sine)) + spiral.focus;
}

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
};

@compute @workgroup_size(64)
fn make_main(@builtin(global_invocation_id) vertex: vec3<u32>) {
    if vertex.x >= spiral.count {
        return;
    }
    let at = place(vertex.x);
    made[3u * vertex.x] = at.x;
    made[3u * vertex.x + 1u] = at.y;
    made[3u * vertex.x + 2u] = at.z;
}

@vertex
fn read_main(@location(0) relative_m: vec3<f32>) -> Varying {
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@vertex
fn making_main(@builtin(vertex_index) number: u32) -> Varying {
    let relative_m = place(number);
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) u32 {
    return bitcast<u32>(length(in.relative_m));
}
