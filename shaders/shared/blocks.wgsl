// A grid whose heights lie in blocks, drawn block by block. A block has one sample a side more than cells, and shares
// those of its borders with its neighbours.
#import shared/cells.wgsl

struct Varying {
    @invariant @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

// A vertex of the ground: column and row of its block, and of its sample there; number of its triangle.
struct BlockVertex {
    block: vec2<u32>,
    texel: vec2<u32>,
    triangle: u32,
};

fn block_vertex(vertex: u32) -> BlockVertex {
    let side = grid.block_cells;
    let number = vertex / 6u;
    let inside = number % (side * side);
    let across = grid.cells / side;
    let of_block = number / (side * side);
    let block = vec2<u32>(of_block % across, of_block / across);
    let cell = vec2<u32>(inside % side, inside / side);
    let triangle = triangle_number(block * side + cell, (vertex % 6u) / 3u);
    return BlockVertex(block, cell + corner(vertex % 6u), triangle);
}

// The layer, slice or texture of a block.
fn layer_of(block: vec2<u32>) -> u32 {
    return block.y * (grid.cells / grid.block_cells) + block.x;
}

fn placed(vertex: BlockVertex, height_m: f32) -> Varying {
    let place = vec2<f32>(vertex.block * grid.block_cells + vertex.texel);
    return Varying(clip_from_grid(vec3<f32>(place, height_m)), vertex.triangle);
}

@fragment
fn fragment_main(@location(0) @interpolate(flat) number: u32) -> @location(0) vec4<f32> {
    return colour_of(number);
}
