// Study `pipelines`: one vertex invocation places a vertex of a bicubic patch's cells, reads one that compute
// placed, or hands a patch's number on to stages that divide it. Fragments write the number of their triangle, or
// that of the first triangle of their cell.
#import shared/bezier.wgsl

// Clip positions that `pipelines/bezier_place.wgsl` made, patch by patch and row by row.
@group(0) @binding(2) var<storage, read> placed: array<vec4<f32>>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

struct Corner {
    square: u32,
    cell: vec2<u32>,
    at: vec2<u32>,
    half: u32,
};

// Six vertices a cell.
fn corner_of(vertex: u32) -> Corner {
    let number = vertex / 6u;
    let cells = mesh.cells;
    let cell = vec2<u32>(number % cells, (number / cells) % cells);
    return Corner(number / (cells * cells), cell, cell + corner(vertex % 6u), (vertex % 6u) / 3u);
}

@vertex
fn no_buffer(@builtin(vertex_index) vertex: u32) -> Varying {
    let given = corner_of(vertex);
    let clip = clip_from_metres(on_patch(given.square, given.at));
    return Varying(clip, mesh_triangle(given.square, given.cell, given.half));
}

@vertex
fn placed_before(@builtin(vertex_index) vertex: u32) -> Varying {
    let given = corner_of(vertex);
    let side = mesh.cells + 1u;
    let clip = placed[(given.square * side + given.at.y) * side + given.at.x];
    return Varying(clip, mesh_triangle(given.square, given.cell, given.half));
}

// Of a patch, or of a row of one.
@vertex
fn numbered(@builtin(vertex_index) vertex: u32) -> Varying {
    return Varying(vec4<f32>(0.0, 0.0, 0.0, 1.0), vertex);
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return colour_of(number);
}

// Which half of a cell it is, nobody says who divides patches: their cuts are the driver's.
@fragment
fn cell_main(
    @location(0) @interpolate(flat) square: u32,
    @location(1) at: vec2<f32>,
) -> @location(0) vec4<f32> {
    let cell = clamp(vec2<i32>(floor(at)), vec2<i32>(0), vec2<i32>(i32(mesh.cells) - 1));
    return colour_of(mesh_triangle(square, vec2<u32>(cell), 0u));
}
