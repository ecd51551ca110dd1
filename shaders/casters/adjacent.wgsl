// Casters for geometry shaders, which find the silhouette: one invocation a vertex of a triangle or an edge with
// adjacency, or a corner of a cap, which is drawn beside. What is read lies behind the volumes' constants, as words of 32 bits; the
// last five say where the table of volumes, the corners, the facing bits, the places and the caps begin.
#import shared/view.wgsl
#import shared/volume.wgsl

@group(0) @binding(2) var<storage, read> words: array<u32>;

struct Corner {
    @builtin(position) @invariant clip: vec4<f32>,
    // From the eye, and whether the triangle that this corner speaks for is lit.
    @location(0) place_and_lit: vec4<f32>,
    // The one end of all sides, in clip space.
    @location(1) end: vec4<f32>,
    // The direction towards it.
    @location(2) away: vec4<f32>,
};

fn part(number: u32) -> u32 {
    return words[arrayLength(&words) - 5u + number];
}

fn place(index: u32) -> vec3<f32> {
    let at = part(3u) + 3u * index;
    return bitcast<vec3<f32>>(vec3<u32>(words[at], words[at + 1u], words[at + 2u]));
}

fn bit(index: u32) -> bool {
    return ((words[part(2u) + (index >> 5u)] >> (index & 31u)) & 1u) == 1u;
}

fn corner(index: u32, is_lit: bool) -> Corner {
    let relative = place(index);
    // The first place is the direction.
    let away = place(0u);
    let end = clip_from_eye_relative(away);
    let lit = select(0.0, 1.0, is_lit);
    return Corner(
        clip_from_eye_relative(relative),
        vec4<f32>(relative, lit),
        vec4<f32>(end.xy, 0.0, end.w),
        vec4<f32>(away, 0.0),
    );
}

// Six a triangle: its corners, and behind each the one opposite to the edge that follows. Four bits: its own,
// and those of the neighbours.
@vertex
fn triangles(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) volume: u32,
) -> Corner {
    let at = 6u * words[part(0u) + 2u * volume] + vertex;
    let corner_of = at % 6u;
    let bit_of = select(0u, 1u + corner_of / 2u, (corner_of & 1u) == 1u);
    return corner(words[part(1u) + at], bit(4u * (at / 6u) + bit_of));
}

// Four an edge: its ends between the corners opposite to it, of the triangle that has it forwards first. Two
// bits: of either triangle.
@vertex
fn lines(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) volume: u32,
) -> Corner {
    let at = 4u * words[part(0u) + 2u * volume] + vertex;
    return corner(words[part(1u) + at], bit(2u * (at / 4u) + (at % 4u) / 2u));
}

// Caps are not made by the geometry shader: its triangles may begin with another corner than the surface's, and
// depths that must be equal then differ by a rounding. What is not lit collapses into a point.
fn cap(index: u32, is_lit: bool) -> vec4<f32> {
    if !is_lit {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return clip_from_eye_relative(place(index));
}

// Three a triangle: its corners, behind each other, and its bit in a word behind those of all edges.
@vertex
fn caps(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) volume: u32,
) -> @invariant @builtin(position) vec4<f32> {
    let at = 3u * words[part(0u) + 2u * volume + 1u] + vertex;
    let edges = (part(4u) - part(1u)) / 4u;
    let first_bit = 32u * ((2u * edges + 31u) / 32u);
    return cap(words[part(4u) + at], bit(first_bit + at / 3u));
}

fn corner_of(triangle: u32, number: u32) -> u32 {
    return words[part(1u) + 6u * triangle + 2u * (number % 3u)];
}

// The same from triangles with adjacency.
@vertex
fn triangle_caps(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) volume: u32,
) -> @invariant @builtin(position) vec4<f32> {
    let triangle = words[part(0u) + 2u * volume] + vertex / 3u;
    return cap(corner_of(triangle, vertex), bit(4u * triangle));
}

// The same where no bit is stored: the sign from the corners in their own order.
@vertex
fn corner_caps(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) volume: u32,
) -> @invariant @builtin(position) vec4<f32> {
    let triangle = words[part(0u) + 2u * volume] + vertex / 3u;
    let first = place(corner_of(triangle, 0u));
    let second = place(corner_of(triangle, 1u)) - first;
    let third = place(corner_of(triangle, 2u)) - first;
    let is_lit = dot(cross(second, third), -place(0u)) > 0.0;
    return cap(corner_of(triangle, vertex), is_lit);
}
