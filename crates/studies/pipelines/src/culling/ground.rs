// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground of 8 × 8 tiles with relief of ten octaves, its views, and both as a device reads them.
//!
//! Metres; x along columns, y along rows, z up. A cell is 30 m.

use super::way::{Test, ViewKind};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, DVec4, IVec2};
use std::f64::consts::TAU;
use terrafill_shapes::grid::{Grid, GridCamera, nearest};

/// A side of the ground, tiles; the published number is not stated. In tiles of 256 cells there are 2²³ triangles, which
/// a picture tells apart by 24 bits.
pub(crate) const TILES: u32 = 8;
/// A side of a patch, cells, as `shared/ground.wgsl` has it.
pub(crate) const PATCH_CELLS: u32 = 8;
/// Two triangles a cell.
pub(crate) const PATCH_TRIANGLES: u32 = 2 * PATCH_CELLS * PATCH_CELLS;
const CELL_M: f64 = 30.0;
/// Octaves of relief: the first 30 km long and 1.6 km high, each next about half as long and as high, so that all are
/// as steep and the sum is within 3.2 km.
const OCTAVES: i32 = 10;
const LONGEST_M: f64 = 30_000.0;
const HIGHEST_M: f64 = 1_600.0;

/// Ground in tiles of patches.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    pub(crate) grid: Grid,
    /// Least and greatest height, row by row.
    pub(crate) patch_boxes: Vec<[f32; 2]>,
    pub(crate) tile_boxes: Vec<[f32; 2]>,
}

impl Ground {
    /// - `tile_cells`: a side of a tile, a multiple of [`PATCH_CELLS`]
    pub(crate) fn new(tile_cells: u32) -> Self {
        let cells = TILES * tile_cells;
        let grid = Grid {
            cells,
            side_m: f64::from(cells) * CELL_M,
            heights: heights(cells),
        };
        Self {
            patch_boxes: boxes(&grid, PATCH_CELLS),
            tile_boxes: boxes(&grid, tile_cells),
            grid,
        }
    }

    pub(crate) fn tile_cells(&self) -> u32 {
        self.grid.cells / TILES
    }

    pub(crate) fn patches_a_tile(&self) -> u32 {
        (self.tile_cells() / PATCH_CELLS).pow(2)
    }

    /// Patches of a tile in the order in which shaders number them.
    pub(crate) fn patches_of(&self, tile: u32) -> impl Iterator<Item = u32> + use<> {
        let side = self.tile_cells() / PATCH_CELLS;
        let all = self.grid.cells / PATCH_CELLS;
        let (column, row) = (side * (tile % TILES), side * (tile / TILES));
        (0..side * side).map(move |inner| (row + inner / side) * all + column + inner % side)
    }

    /// Bounds of a box with so many cells a side, metres.
    pub(crate) fn bounds(&self, number: u32, cells: u32, heights: [f32; 2]) -> [DVec3; 2] {
        let boxes = self.grid.cells / cells;
        let side = f64::from(cells) * CELL_M;
        let corner = DVec2::new(f64::from(number % boxes), f64::from(number / boxes)) * side;
        let [low, high] = heights.map(f64::from);
        [corner.extend(low), (corner + side).extend(high)]
    }

    /// From where it is seen.
    pub(crate) fn view(&self, kind: &ViewKind) -> GridCamera {
        let [down_deg, turn_deg, wide_deg] = kind.angles_deg;
        let cell = (kind.share * f64::from(self.grid.cells)).floor();
        let eye = ((cell + 0.5) * CELL_M).extend(self.highest_of(cell.as_ivec2()) + kind.above_m);
        let (down, turn) = (down_deg.to_radians(), turn_deg.to_radians());
        let ahead = DVec3::new(turn.cos(), turn.sin(), 0.0);
        let forward = ahead * down.cos() - DVec3::Z * down.sin();
        let right = DVec3::new(turn.sin(), -turn.cos(), 0.0);
        GridCamera {
            eye,
            right,
            up: right.cross(forward),
            forward,
            tan_half: (0.5 * wide_deg).to_radians().tan(),
        }
    }

    fn highest_of(&self, cell: IVec2) -> f64 {
        let cell = cell.clamp(IVec2::ZERO, IVec2::splat(self.grid.cells.cast_signed() - 1));
        let cell = cell.as_uvec2();
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let heights = corners
            .map(|(x, y)| f64::from(self.grid.heights[self.grid.index(cell.x + x, cell.y + y)]));
        heights.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Sums of products of waves along both axes, each looked up: a table a wave and axis.
fn heights(cells: u32) -> Vec<f32> {
    let wave = |octave: i32, axis: f64| {
        // Lengths of no common multiple, so that nothing repeats; phases without a pattern.
        let length_m = LONGEST_M * (1.0 + 0.17 * axis) / 2.03_f64.powi(octave);
        let phase = 1.7 * f64::from(octave) + 2.9 * axis;
        let along = move |vertex: u32| (TAU * f64::from(vertex) * CELL_M / length_m + phase).sin();
        (0..=cells).map(along).collect::<Vec<f64>>()
    };
    let waves: Vec<(f64, Vec<f64>, Vec<f64>)> = (0..OCTAVES)
        .map(|octave| {
            let height_m = HIGHEST_M / 2.0_f64.powi(octave);
            (height_m, wave(octave, 0.0), wave(octave, 1.0))
        })
        .collect();
    let mut heights = Vec::with_capacity((cells as usize + 1).pow(2));
    let mut row_m = vec![0.0_f64; cells as usize + 1];
    for row in 0..=cells as usize {
        row_m.fill(0.0);
        for (height_m, across, down) in &waves {
            let scale = height_m * down[row];
            for (sum, share) in row_m.iter_mut().zip(across) {
                *sum += scale * share;
            }
        }
        heights.extend(row_m.iter().copied().map(nearest));
    }
    heights
}

/// Least and greatest height of squares of so many cells a side, their borders included.
fn boxes(grid: &Grid, cells: u32) -> Vec<[f32; 2]> {
    let side = grid.cells / cells;
    let squares = (0..side).flat_map(|row| (0..side).map(move |column| (column, row)));
    let of = |(column, row): (u32, u32)| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for y in row * cells..=(row + 1) * cells {
            let first = grid.index(column * cells, y);
            for height in &grid.heights[first..=first + cells as usize] {
                low = low.min(*height);
                high = high.max(*height);
            }
        }
        [low, high]
    };
    squares.map(of).collect()
}

/// Twin of `GroundConstants` in `shared/ground.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GroundConstants {
    pub(crate) column: [f32; 4],
    pub(crate) row: [f32; 4],
    pub(crate) height: [f32; 4],
    pub(crate) origin: [f32; 4],
    pub(crate) eye_cell: [i32; 2],
    pub(crate) eye_height_m: f32,
    pub(crate) cells: u32,
    pub(crate) tiles: u32,
    pub(crate) listed: u32,
    pub(crate) test: u32,
    pub(crate) range: f32,
}

impl GroundConstants {
    /// - `listed`: tiles in view
    pub(crate) fn new(ground: &Ground, view: &GridCamera, listed: u32, test: Test) -> Self {
        let clip = view.clip_from_world();
        let eye_cell = (view.eye.truncate() / CELL_M).floor();
        // Whole metres, which f32 holds exactly.
        let eye_height_m = view.eye.z.floor();
        let from = (eye_cell * CELL_M).extend(eye_height_m);
        let column = |of: DVec4| of.as_vec4().to_array();
        let (test, range) = match test {
            Test::Nothing => (0, 0.0),
            Test::Point(range) => (1, range),
            Test::Box => (2, 0.0),
        };
        Self {
            column: column(clip.x_axis * CELL_M),
            row: column(clip.y_axis * CELL_M),
            height: column(clip.z_axis),
            origin: column(clip * from.extend(1.0)),
            eye_cell: eye_cell.as_ivec2().to_array(),
            eye_height_m: nearest(eye_height_m),
            cells: ground.grid.cells,
            tiles: TILES,
            listed,
            test,
            range,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn constants_lie_as_the_shader_reads_them() {
        let layout = struct_layout("pipelines/cull.wgsl", "GroundConstants").expect("a struct");
        let offset = |name: &str| layout.offset(name).expect(name);
        for (name, at) in [
            ("column", offset_of!(GroundConstants, column)),
            ("row", offset_of!(GroundConstants, row)),
            ("height", offset_of!(GroundConstants, height)),
            ("origin", offset_of!(GroundConstants, origin)),
            ("eye_cell", offset_of!(GroundConstants, eye_cell)),
            ("eye_height_m", offset_of!(GroundConstants, eye_height_m)),
            ("cells", offset_of!(GroundConstants, cells)),
            ("tiles", offset_of!(GroundConstants, tiles)),
            ("listed", offset_of!(GroundConstants, listed)),
            ("test", offset_of!(GroundConstants, test)),
            ("range", offset_of!(GroundConstants, range)),
        ] {
            assert_eq!(offset(name), at, "{name}");
        }
        assert_eq!(layout.stride as usize, size_of::<GroundConstants>());
        // Negative control: two members lie apart.
        assert_ne!(offset("row"), offset_of!(GroundConstants, height));
    }

    #[test]
    fn patches_of_all_tiles_are_all_patches_and_boxes_hold_their_heights() {
        let ground = Ground::new(32);
        let mut patches: Vec<u32> = (0..TILES * TILES)
            .flat_map(|tile| ground.patches_of(tile))
            .collect();
        assert_eq!(patches.len(), ground.patch_boxes.len());
        for &tile in &[0, 17, 63] {
            let [low, high] = ground.tile_boxes[tile as usize];
            let own = ground.patches_of(tile);
            let own: Vec<[f32; 2]> = own.map(|at| ground.patch_boxes[at as usize]).collect();
            let lowest = own.iter().map(|of| of[0]).fold(f32::INFINITY, f32::min);
            let highest = own.iter().map(|of| of[1]).fold(f32::NEG_INFINITY, f32::max);
            assert_eq!([low, high], [lowest, highest], "{tile}");
        }
        patches.sort_unstable();
        assert!((0..).zip(&patches).all(|(number, patch)| number == *patch));
        let highest = ground.grid.heights.iter().fold(0.0_f32, |a, b| a.max(*b));
        assert!(highest > 1_000.0 && highest < 3_200.0, "{highest}");
    }
}
