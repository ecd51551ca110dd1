// Ground in tiles of patches, and the test whether a patch may be in view. Columns and rows count cells of the
// whole ground. Vertices are taken from the cell below the eye, whose numbers are small near it.
struct GroundConstants {
    // Columns of the matrix from (column, row, height in m, 1), each from the eye's cell, to clip space.
    column: vec4<f32>,
    row: vec4<f32>,
    height: vec4<f32>,
    origin: vec4<f32>,
    eye_cell: vec2<i32>,
    eye_height_m: f32,
    // A side of the ground.
    cells: u32,
    // A side of the ground.
    tiles: u32,
    // Tiles that are listed.
    listed: u32,
    // 0: everything, 1: a point in a range, 2: a box of least and greatest height.
    test: u32,
    // Of |x/w| and |y/w|.
    range: f32,
};

@group(0) @binding(0) var<uniform> ground: GroundConstants;
// Metres, one texel a vertex: a side has one more than cells.
@group(0) @binding(1) var heights: texture_2d<f32>;
// Least and greatest height of each patch, metres.
@group(0) @binding(2) var<storage, read> boxes: array<vec2<f32>>;
// Tiles that the CPU found in view.
@group(0) @binding(3) var<storage, read> tiles_in_view: array<u32>;

// A side of a patch, cells.
const PATCH_CELLS: u32 = 8u;
// Above the rounding of the four products and sums of a distance, of the sum of their sizes.
const ROUNDING: f32 = 0x1p-20;

// By fused steps, so that no compiler has a choice and every stage finds the same bits.
fn clip_from_ground(place: vec3<f32>) -> vec4<f32> {
    let level = fma(ground.height, vec4<f32>(place.z), ground.origin);
    return fma(ground.column, vec4<f32>(place.x), fma(ground.row, vec4<f32>(place.y), level));
}

fn clip_at(vertex: vec2<u32>) -> vec4<f32> {
    let height_m = textureLoad(heights, vec2<i32>(vertex), 0).r - ground.eye_height_m;
    let place = vec2<f32>(vec2<i32>(vertex) - ground.eye_cell);
    return clip_from_ground(vec3<f32>(place, height_m));
}

fn patches_a_side() -> u32 {
    return ground.cells / PATCH_CELLS;
}

fn patches_a_tile() -> u32 {
    let side = patches_a_side() / ground.tiles;
    return side * side;
}

// Number of a patch of the listed tiles, which have all their patches one after the other.
fn patch_of_tiles(number: u32) -> u32 {
    let side = patches_a_side() / ground.tiles;
    let tile = tiles_in_view[number / (side * side)];
    let inner = number % (side * side);
    let column = side * (tile % ground.tiles) + inner % side;
    let row = side * (tile / ground.tiles) + inner / side;
    return row * patches_a_side() + column;
}

fn first_cell(patch_number: u32) -> vec2<u32> {
    let side = patches_a_side();
    return PATCH_CELLS * vec2<u32>(patch_number % side, patch_number / side);
}

// Whether a box is wholly on the outer side of the plane whole + part = 0, rounding allowed for.
fn is_outside(whole: vec4<f32>, part: vec4<f32>, low: vec3<f32>, high: vec3<f32>) -> bool {
    let plane = whole + part;
    let inner = max(plane.xyz * low, plane.xyz * high);
    let size = (abs(whole.xyz) + abs(part.xyz)) * max(abs(low), abs(high));
    let scale = size.x + size.y + size.z + abs(whole.w) + abs(part.w);
    return inner.x + inner.y + inner.z + plane.w < -ROUNDING * scale;
}

fn box_is_kept(patch_number: u32) -> bool {
    let first = vec2<f32>(vec2<i32>(first_cell(patch_number)) - ground.eye_cell);
    let heights_m = boxes[patch_number] - ground.eye_height_m;
    let low = vec3<f32>(first, heights_m.x);
    let high = vec3<f32>(first + f32(PATCH_CELLS), heights_m.y);
    let x = vec4<f32>(ground.column.x, ground.row.x, ground.height.x, ground.origin.x);
    let y = vec4<f32>(ground.column.y, ground.row.y, ground.height.y, ground.origin.y);
    // The same everywhere: the distance of the near plane.
    let z = vec4<f32>(0.0, 0.0, 0.0, -ground.origin.z);
    let w = vec4<f32>(ground.column.w, ground.row.w, ground.height.w, ground.origin.w);
    let outside = is_outside(w, x, low, high) || is_outside(w, -x, low, high)
        || is_outside(w, y, low, high) || is_outside(w, -y, low, high)
        || is_outside(w, z, low, high);
    return !outside;
}

fn is_kept(patch_number: u32) -> bool {
    if ground.test == 1u {
        let clip = clip_at(first_cell(patch_number));
        return clip.w > 0.0 && all(abs(clip.xy) <= vec2<f32>(ground.range * clip.w));
    }
    return ground.test == 0u || box_is_kept(patch_number);
}

// From 1, since 0 is what is not drawn.
fn triangle_number(cell: vec2<u32>, half: u32) -> u32 {
    return 2u * (cell.y * ground.cells + cell.x) + half + 1u;
}

fn colour_of(number: u32) -> vec4<f32> {
    return unpack4x8unorm(number | 0xff000000u);
}
