// Study `pipelines`: one vertex invocation places a vertex of a height grid, by one of the ways in which
// vertices may come. Fragments write the number of their triangle or point.
#import shared/grid.wgsl

// Clip positions that `pipelines/expand.wgsl` made, row by row.
@group(0) @binding(2) var<storage, read> expanded: array<vec4<f32>>;

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

// Points whose heights the CPU sends: column, row, metres.
@vertex
fn sent_point(@builtin(vertex_index) vertex: u32, @location(0) place: vec3<f32>) -> Varying {
    return Varying(clip_from_grid(place), vertex + 1u);
}

// Strips that the CPU sends, one a row of cells: vertices of both rows in turn. Each begins a triangle.
@vertex
fn sent_strip(@builtin(vertex_index) vertex: u32, @location(0) place: vec3<f32>) -> Varying {
    let strip = 2u * (grid.cells + 1u);
    let cell = vec2<u32>((vertex % strip) / 2u, vertex / strip);
    return Varying(clip_from_grid(place), triangle_number(cell, vertex % 2u));
}

// Numbers of points in a buffer, heights fetched.
@vertex
fn fetched_point(@location(0) point: u32) -> Varying {
    let vertex = vec2<u32>(point % grid.cells, point / grid.cells);
    return Varying(clip_at(vertex), point + 1u);
}

// Hands a point's number on to a geometry shader.
@vertex
fn numbered_point(@location(0) point: u32) -> Varying {
    return Varying(vec4<f32>(0.0, 0.0, 0.0, 1.0), point);
}

// No buffer at all: six vertices a cell by their numbers.
@vertex
fn no_buffer(@builtin(vertex_index) vertex: u32) -> Varying {
    let number = vertex / 6u;
    let cell = vec2<u32>(number % grid.cells, number / grid.cells);
    let at = cell + corner(vertex % 6u);
    return Varying(clip_at(at), triangle_number(cell, (vertex % 6u) / 3u));
}

// As `no_buffer`, of vertices that were placed once.
@vertex
fn placed_before(@builtin(vertex_index) vertex: u32) -> Varying {
    let number = vertex / 6u;
    let cell = vec2<u32>(number % grid.cells, number / grid.cells);
    let at = cell + corner(vertex % 6u);
    let clip = expanded[at.y * (grid.cells + 1u) + at.x];
    return Varying(clip, triangle_number(cell, (vertex % 6u) / 3u));
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return colour_of(number);
}
