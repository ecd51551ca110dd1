// Study `pipelines`: one vertex invocation places a vertex of a geometry image, reads one that compute placed, or hands
// a texel's number on to a geometry shader. Fragments write the number of their triangle or point.
enable primitive_index;
#import shared/image.wgsl

// Clip positions that `pipelines/image_place.wgsl` made, row by row.
@group(0) @binding(2) var<storage, read> placed: array<vec4<f32>>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

// By the number of a texel.
fn texel_of(vertex: u32) -> vec2<u32> {
    let side = mesh.cells + 1u;
    return vec2<u32>(vertex % side, vertex / side);
}

// A vertex by its index, whose triangle the fragment knows.
@vertex
fn indexed(
    @builtin(vertex_index) vertex: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return image_clip(texel_of(vertex));
}

// A point a texel.
@vertex
fn fetched(@builtin(vertex_index) vertex: u32) -> Varying {
    return Varying(image_clip(texel_of(vertex)), vertex + 1u);
}

// A cell's number, for a geometry shader.
@vertex
fn numbered(@builtin(vertex_index) vertex: u32) -> Varying {
    return Varying(vec4<f32>(0.0, 0.0, 0.0, 1.0), vertex);
}

fn cell_of(vertex: u32) -> vec2<u32> {
    let number = vertex / 6u;
    return vec2<u32>(number % mesh.cells, number / mesh.cells);
}

// Six vertices a cell.
@vertex
fn no_buffer(@builtin(vertex_index) vertex: u32) -> Varying {
    let cell = cell_of(vertex);
    let at = cell + image_corner(cell, vertex % 6u);
    return Varying(image_clip(at), mesh_triangle(0u, cell, (vertex % 6u) / 3u));
}

@vertex
fn placed_before(@builtin(vertex_index) vertex: u32) -> Varying {
    let cell = cell_of(vertex);
    let at = cell + image_corner(cell, vertex % 6u);
    let clip = placed[at.y * (mesh.cells + 1u) + at.x];
    return Varying(clip, mesh_triangle(0u, cell, (vertex % 6u) / 3u));
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return colour_of(number);
}

@fragment
fn indexed_main(@builtin(primitive_index) triangle: u32) -> @location(0) vec4<f32> {
    return colour_of(triangle + 1u);
}
