// The spiral made on the GPU (Gebbie and Bailey, with the focus-local form of position): one compute invocation makes a
// vertex into a buffer, from nothing but its number; one vertex invocation reads it there, or makes it itself. Over
// terrain it is moved up by a height that it looks up in a texture, which the paper leaves to the future. Or it is of
// one buffer for all views, of sine, cosine and radius, which is what the paper draws. One
// fragment writes the bits of its distance, so that two pictures can be held to each other exactly. Metres from the
// eye, ECEF axes. Workgroups of 64, the least that all devices have.
#import shared/view.wgsl
#import shared/spiral.wgsl

@group(1) @binding(0) var<uniform> spiral: SpiralConstants;
// Sine and cosine of each vertex of a turn.
@group(1) @binding(1) var<storage, read> directions: array<vec2<f32>>;
@group(1) @binding(4) var<storage, read> stored: array<f32>;
@group(1) @binding(5) var<storage, read_write> made: array<f32>;

const TAU: f32 = 6.2831853;

// 1: the compute shader reads stored vertices.
override STORED: u32 = 0u;

// From the focus to a vertex on the body.
fn way(number: u32) -> vec3<f32> {
    if STORED == 1u {
        // As drawn: the vertex before the first is the centre.
        let at = 3u * (spiral.first + number - 1u);
        return stored_way(spiral, vec3<f32>(stored[at], stored[at + 1u], stored[at + 2u]));
    }
    if number == 0u {
        return vec3<f32>(0.0);
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
    return reached(spiral, direction, radius);
}

// Vertex 0 is the centre of the fan.
fn place(number: u32) -> vec3<f32> {
    return way(number) + spiral.focus;
}

// Terrain: heights on the faces of a cube, whose neighbours share the samples of their edges.
struct Relief {
    // 1 / radii, per metre.
    per_metre: vec3<f32>,
    // Height of the ground below the eye, metres.
    base_m: f32,
    // The focus from the centre, in scaled space, where the body is the unit sphere.
    up: vec3<f32>,
    // Equatorial radius, metres.
    radius_m: f32,
    // Geodetic normal at the focus.
    normal: vec3<f32>,
    // Cells along a side of a face.
    side: u32,
    // The ground below the eye, from the eye.
    ground: vec3<f32>,
    // Face of the focus; where on it, -1 to 1; its cell, and where in that, 0 to 1.
    face: u32,
    on_face: vec2<f32>,
    within: vec2<f32>,
    cell: vec2<u32>,
};

@group(1) @binding(2) var<uniform> relief: Relief;
// A layer for each face.
@group(1) @binding(3) var heights: texture_2d_array<f32>;

// 1: heights and normals as differences from those below the eye.
override LOCAL: u32 = 0u;

fn height_at(face: u32, column: u32, row: u32) -> f32 {
    return textureLoad(heights, vec2<u32>(column, row), face, 0).x;
}

// Parts of a direction along a face's sides and out of it; faces in WebGPU's order.
fn along_face(face: u32, d: vec3<f32>) -> vec3<f32> {
    switch face {
        case 0u: { return vec3<f32>(-d.z, -d.y, d.x); }
        case 1u: { return vec3<f32>(d.z, -d.y, -d.x); }
        case 2u: { return vec3<f32>(d.x, d.z, d.y); }
        case 3u: { return vec3<f32>(d.x, -d.z, -d.y); }
        case 4u: { return vec3<f32>(d.x, -d.y, d.z); }
        default: { return vec3<f32>(-d.x, -d.y, -d.z); }
    }
}

fn face_of(d: vec3<f32>) -> u32 {
    let size = abs(d);
    if size.x >= size.y && size.x >= size.z {
        return select(0u, 1u, d.x < 0.0);
    }
    if size.y >= size.z {
        return select(2u, 3u, d.y < 0.0);
    }
    return select(4u, 5u, d.z < 0.0);
}

// Between the four samples of a cell, above `base_m`.
fn bilinear(face: u32, cell: vec2<u32>, t: vec2<f32>, base_m: f32) -> f32 {
    let a = height_at(face, cell.x, cell.y) - base_m;
    let b = height_at(face, cell.x + 1u, cell.y) - base_m;
    let c = height_at(face, cell.x, cell.y + 1u) - base_m;
    let d = height_at(face, cell.x + 1u, cell.y + 1u) - base_m;
    let south = a + t.x * (b - a);
    return south + t.y * (c + t.x * (d - c) - south);
}

// In a direction from the body's centre.
fn height_absolute(d: vec3<f32>, base_m: f32) -> f32 {
    let face = face_of(d);
    let q = along_face(face, d);
    let at = (q.xy / q.z + 1.0) * (0.5 * f32(relief.side));
    let cell = min(vec2<u32>(max(at, vec2<f32>(0.0))), vec2<u32>(relief.side - 1u));
    return bilinear(face, cell, at - vec2<f32>(cell), base_m);
}

// By the way from the focus: above the ground below the eye. `d` is that way in scaled space.
fn height_local(d: vec3<f32>) -> f32 {
    let out = along_face(relief.face, relief.up).z;
    let q = along_face(relief.face, d);
    if out + q.z > 0.25 {
        // (s + ds) / (m + dm) - s / m, without their difference.
        let moved = (q.xy - relief.on_face * q.z) / (out + q.z) * (0.5 * f32(relief.side));
        let at = relief.within + moved;
        let whole = floor(at);
        let cell = vec2<i32>(relief.cell) + vec2<i32>(whole);
        if all(whole == vec2<f32>(0.0)) {
            // In the cell of the focus, without the difference of two heights.
            let a = height_at(relief.face, relief.cell.x, relief.cell.y);
            let b = height_at(relief.face, relief.cell.x + 1u, relief.cell.y);
            let c = height_at(relief.face, relief.cell.x, relief.cell.y + 1u);
            let twist = height_at(relief.face, relief.cell.x + 1u, relief.cell.y + 1u) - c - (b - a);
            return moved.x * (b - a + at.y * twist) + moved.y * (c - a + relief.within.x * twist);
        }
        if all(cell >= vec2<i32>(0)) && all(cell < vec2<i32>(i32(relief.side))) {
            return bilinear(relief.face, vec2<u32>(cell), at - whole, relief.base_m);
        }
    }
    return height_absolute(relief.up + d, relief.base_m);
}

// - `on_body`: from the focus
fn displaced(on_body: vec3<f32>) -> vec3<f32> {
    let d = on_body * relief.per_metre;
    if LOCAL == 0u {
        let direction = relief.up + d;
        let normal = normalize(direction * relief.per_metre * relief.radius_m);
        return (on_body + spiral.focus) + normal * height_absolute(direction, 0.0);
    }
    // How the normal differs from that below the eye: w/|w| - v/|v| for w = v + dw.
    let v = relief.up * relief.per_metre * relief.radius_m;
    let dw = d * relief.per_metre * relief.radius_m;
    let longer = (2.0 * dot(v, dw) + dot(dw, dw)) / (length(v) + length(v + dw));
    let turned = (dw - relief.normal * longer) / length(v + dw);
    let rise = height_local(d);
    return (on_body + relief.ground) + (turned * relief.base_m + (relief.normal + turned) * rise);
}

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) relative_m: vec3<f32>,
};

fn keep(number: u32, at: vec3<f32>) {
    made[3u * number] = at.x;
    made[3u * number + 1u] = at.y;
    made[3u * number + 2u] = at.z;
}

@compute @workgroup_size(64)
fn make_main(@builtin(global_invocation_id) vertex: vec3<u32>) {
    if vertex.x < spiral.count {
        keep(vertex.x, place(vertex.x));
    }
}

@compute @workgroup_size(64)
fn make_displaced_main(@builtin(global_invocation_id) vertex: vec3<u32>) {
    if vertex.x < spiral.count {
        keep(vertex.x, displaced(way(vertex.x)));
    }
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

@vertex
fn making_displaced_main(@builtin(vertex_index) number: u32) -> Varying {
    let relative_m = displaced(way(number));
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@vertex
fn stored_main(@location(0) vertex: vec3<f32>) -> Varying {
    let relative_m = stored_way(spiral, vertex) + spiral.focus;
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@vertex
fn stored_displaced_main(@location(0) vertex: vec3<f32>) -> Varying {
    let relative_m = displaced(stored_way(spiral, vertex));
    return Varying(clip_from_eye_relative(relative_m), relative_m);
}

@fragment
fn fragment_main(in: Varying) -> @location(0) u32 {
    return bitcast<u32>(length(in.relative_m));
}
