// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lowest and highest samples of blocks of a raster, each level of blocks twice as wide.
//!
//! A bilinear value is a weighted mean of four samples, so it lies between the lowest and the highest
//! of all samples around it: bounds of samples bound the values between them.

/// Heights between which something lies, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heights {
    /// No point lies lower.
    pub lowest_m: f64,
    /// No point lies higher.
    pub highest_m: f64,
}

impl Heights {
    /// The smallest range that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            lowest_m: self.lowest_m.min(other.lowest_m),
            highest_m: self.highest_m.max(other.highest_m),
        }
    }

    pub(crate) fn of(height_m: f64) -> Self {
        Self {
            lowest_m: height_m,
            highest_m: height_m,
        }
    }
}

/// Samples of a side of the finest blocks: below that many, samples are read one by one.
const FINEST_BLOCK: usize = 8;
/// A range is put together from at most about this many blocks a side.
const BLOCKS_A_SIDE: usize = 4;

#[derive(Debug, Clone)]
pub(crate) struct Pyramid {
    /// Finest first: blocks a row, and the blocks.
    levels: Vec<(usize, Vec<[f32; 2]>)>,
}

impl Pyramid {
    /// - `samples`: `rows` of `columns`, none of them NaN
    pub(crate) fn new(samples: &[f32], columns: usize, rows: usize) -> Self {
        let (mut across, mut down) = (columns.div_ceil(FINEST_BLOCK), rows.div_ceil(FINEST_BLOCK));
        let mut blocks = vec![[f32::INFINITY, f32::NEG_INFINITY]; across * down];
        for (index, &sample) in samples.iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            widen(
                &mut blocks[row / FINEST_BLOCK * across + column / FINEST_BLOCK],
                [sample; 2],
            );
        }
        let mut levels = vec![(across, blocks)];
        while across > 1 || down > 1 {
            let (wider, taller) = (across.div_ceil(2), down.div_ceil(2));
            let mut above = vec![[f32::INFINITY, f32::NEG_INFINITY]; wider * taller];
            if let Some((_, below)) = levels.last() {
                for (index, &block) in below.iter().enumerate() {
                    let (row, column) = (index / across, index % across);
                    widen(&mut above[row / 2 * wider + column / 2], block);
                }
            }
            levels.push((wider, above));
            (across, down) = (wider, taller);
        }
        Self { levels }
    }

    /// Bounds of the samples from `first` to `last`, both included: column and row.
    pub(crate) fn range(
        &self,
        samples: &[f32],
        columns: usize,
        first: [usize; 2],
        last: [usize; 2],
    ) -> Heights {
        let mut found = [f32::INFINITY, f32::NEG_INFINITY];
        let span = (last[0] - first[0]).max(last[1] - first[1]);
        if span < FINEST_BLOCK {
            for row in first[1]..=last[1] {
                for &sample in &samples[row * columns + first[0]..=row * columns + last[0]] {
                    widen(&mut found, [sample; 2]);
                }
            }
        } else {
            let fits = |level: &usize| span >> level < FINEST_BLOCK * BLOCKS_A_SIDE;
            let level = (0..self.levels.len()).find(fits);
            let level = level.unwrap_or(self.levels.len() - 1);
            let (across, blocks) = &self.levels[level];
            let block = |sample: usize| (sample / FINEST_BLOCK) >> level;
            for row in block(first[1])..=block(last[1]) {
                for &range in
                    &blocks[row * across + block(first[0])..=row * across + block(last[0])]
                {
                    widen(&mut found, range);
                }
            }
        }
        Heights {
            lowest_m: f64::from(found[0]),
            highest_m: f64::from(found[1]),
        }
    }

    /// Of all samples.
    pub(crate) fn all(&self) -> Heights {
        let top = self.levels.last().map_or([0.0; 2], |(_, blocks)| blocks[0]);
        Heights {
            lowest_m: f64::from(top[0]),
            highest_m: f64::from(top[1]),
        }
    }
}

fn widen(range: &mut [f32; 2], by: [f32; 2]) {
    *range = [range[0].min(by[0]), range[1].max(by[1])];
}
