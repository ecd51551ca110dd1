// A grid of heights, every triangle of which has a number: cell by cell in rows, the half at the cell's
// first corner before the other. Cells are cut from (column + 1, row) to (column, row + 1).
#import shared/triangles.wgsl

struct GridConstants {
    // Columns of the matrix from (column, row, height in m, 1) to clip space.
    column: vec4<f32>,
    row: vec4<f32>,
    height: vec4<f32>,
    origin: vec4<f32>,
    // A side.
    cells: u32,
    // A side of a block, where heights lie in blocks.
    block_cells: u32,
};

@group(0) @binding(0) var<uniform> grid: GridConstants;
// By fused steps, so that no compiler has a choice and every stage finds the same bits.
fn clip_from_grid(place: vec3<f32>) -> vec4<f32> {
    let level = fma(grid.height, vec4<f32>(place.z), grid.origin);
    return fma(grid.column, vec4<f32>(place.x), fma(grid.row, vec4<f32>(place.y), level));
}

// From 1, since 0 is what is not drawn.
fn triangle_number(cell: vec2<u32>, half: u32) -> u32 {
    return 2u * (cell.y * grid.cells + cell.x) + half + 1u;
}
