// SPDX-License-Identifier: MIT OR Apache-2.0
//! A grid cut into blocks, and where they lie in what keeps them.

use crate::cache::keep::{Keep, Store};
use std::f64::consts::TAU;
use std::ops::Range;
use terrafill_contract::DeviceError;
use terrafill_shapes::grid::{Grid, GridConstants, nearest};

/// A grid whose heights lie in blocks.
#[derive(Debug, Clone)]
pub(crate) struct BlockGround {
    pub(crate) grid: Grid,
    /// Blocks a side.
    pub(crate) across: u32,
    /// Cells a side of a block.
    pub(crate) block_cells: u32,
}

impl BlockGround {
    pub(crate) fn new(across: u32, block_cells: u32) -> Self {
        let mut grid = Grid::new(across * block_cells);
        // The grid's own waves come again after 1 km: without others half of the blocks would be alike, and one in the
        // other's place could not be noticed.
        let side = grid.cells + 1;
        let step_m = grid.step_m();
        for (at, height) in (0..).zip(&mut grid.heights) {
            let [x, y] = [at % side, at / side].map(|of| f64::from(of) * step_m);
            let wave = (TAU * x / 1_730.0).sin() + (TAU * y / 1_370.0).sin();
            *height = nearest(f64::from(*height) + 20.0 * wave);
        }
        Self {
            grid,
            across,
            block_cells,
        }
    }

    pub(crate) fn blocks(&self) -> u32 {
        self.across * self.across
    }

    /// Samples a side of a block: those of borders are in both neighbours.
    pub(crate) fn samples(&self) -> u32 {
        self.block_cells + 1
    }

    /// Column and row of a block's first vertex.
    pub(crate) fn first_vertex(&self, block: u32) -> [u32; 2] {
        [block % self.across, block / self.across].map(|at| at * self.block_cells)
    }

    /// Heights of a block, row by row.
    pub(crate) fn heights(&self, block: u32) -> Vec<f32> {
        let [column, row] = self.first_vertex(block);
        let side = self.samples();
        let sample = |at: u32| self.grid.index(column + at % side, row + at / side);
        (0..side * side)
            .map(|at| self.grid.heights[sample(at)])
            .collect()
    }

    /// Vertices of a block's draw.
    pub(crate) fn vertices(&self, block: u32) -> Range<u32> {
        let each = 6 * self.block_cells * self.block_cells;
        block * each..(block + 1) * each
    }

    /// Vertices of the draws of a frame: of all blocks at once, unless each has a texture of its own.
    pub(crate) fn ranges(&self, keep: Keep) -> Vec<Range<u32>> {
        match keep {
            Keep::Rebound => (0..self.blocks())
                .map(|block| self.vertices(block))
                .collect(),
            _ => std::iter::once(0..self.vertices(self.blocks() - 1).end).collect(),
        }
    }

    pub(crate) fn constants(&self) -> GridConstants {
        GridConstants {
            block_cells: self.block_cells,
            ..GridConstants::new(&self.grid)
        }
    }

    /// Where a block begins in the texture that holds it.
    pub(crate) fn first_texel(&self, store: Store, block: u32) -> [u32; 3] {
        match store {
            Store::SideBySide => {
                let [x, y] = [block % self.across, block / self.across];
                [x * self.samples(), y * self.samples(), 0]
            }
            Store::Layers | Store::Slices => [0, 0, block],
            Store::Each | Store::Buffer => [0; 3],
        }
    }
}

/// WGSL that draws from what keeps the blocks.
pub(crate) fn shader(keep: Keep, adapter: &str) -> Result<&'static str, DeviceError> {
    match keep {
        Keep::Array => Ok("pipelines/blocks_array.wgsl"),
        Keep::Atlas => Ok("pipelines/blocks_atlas.wgsl"),
        Keep::Volume => Ok("pipelines/blocks_volume.wgsl"),
        Keep::Rebound => Ok("pipelines/blocks_each.wgsl"),
        Keep::Bindless => Ok("pipelines/blocks_bindless.wgsl"),
        other => {
            let what = format!("ground drawn from {}", other.name());
            Err(DeviceError::unsupported(&what, adapter))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_share_the_samples_of_their_borders_and_hold_the_grid() {
        let ground = BlockGround::new(3, 8);
        let side = ground.samples() as usize;
        let [one, right, below] = [4, 5, 7].map(|block| ground.heights(block));
        for at in 0..side {
            assert_eq!(one[at * side + side - 1], right[at * side]);
            assert_eq!(one[(side - 1) * side + at], below[at]);
        }
        let vertex = ground.grid.index(8 + 3, 8 + 5);
        assert_eq!(one[5 * side + 3], ground.grid.heights[vertex]);
        // Negative control: another block has something else there.
        assert_ne!(right[5 * side + 3], ground.grid.heights[vertex]);
    }

    #[test]
    fn no_two_blocks_are_alike() {
        let differ_m = |ground: &BlockGround, one: u32, other: u32| {
            let [one, other] = [one, other].map(|block| ground.heights(block));
            let differences = one
                .iter()
                .zip(&other)
                .map(|(a, b)| f64::from((a - b).abs()));
            differences.fold(0.0, f64::max)
        };
        let ground = BlockGround::new(4, 32);
        for (one, other) in (0..16).flat_map(|one| (0..one).map(move |other| (one, other))) {
            let differ_m = differ_m(&ground, one, other);
            assert!(differ_m > 10.0, "{one} and {other}: {differ_m} m");
        }
        // Negative control: blocks of the grid alone are alike.
        let plain = BlockGround {
            grid: Grid::new(128),
            ..ground
        };
        assert!(differ_m(&plain, 5, 10) < 1e-3);
    }
}
