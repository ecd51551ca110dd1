// SPDX-License-Identifier: MIT OR Apache-2.0
//! Batch numbers for XOR colouring.
//!
//! Each region gets an 8-bit number and draws its volume with stencil operation `Invert` on depth
//! fail, write mask = number: a closed volume toggles those bits an odd number of times exactly inside, so
//! the stencil holds the number there. Two regions may share a number unless their screen
//! rectangles overlap, because the cover of one would then find the other's pixels. Right for
//! disjoint regions only: where two overlap, the stencil holds the XOR of their numbers.

use terrafill_scene::PlannedRegion;

/// Numbers an 8-bit stencil can tell apart from "no region".
pub const XOR_NUMBERS: usize = 255;

/// Regions by number, in passes of at most [`XOR_NUMBERS`] numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct XorBatches {
    /// Pass → number − 1 → indices into the plan's regions. Each pass clears the stencil.
    pub passes: Vec<Vec<Vec<usize>>>,
}

impl XorBatches {
    /// Greedy colouring of the rectangles' overlap graph, in plan order.
    #[must_use]
    pub fn new(regions: &[PlannedRegion]) -> Self {
        let mut classes: Vec<Vec<usize>> = Vec::new();
        for (index, region) in regions.iter().enumerate() {
            let is_free = |class: &&mut Vec<usize>| {
                class
                    .iter()
                    .all(|&other| !regions[other].screen_rect.overlaps(region.screen_rect))
            };
            match classes.iter_mut().find(is_free) {
                Some(class) => class.push(index),
                None => classes.push(vec![index]),
            }
        }
        Self {
            passes: classes
                .chunks(XOR_NUMBERS)
                .map(<[Vec<usize>]>::to_vec)
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::VolumeHeights;
    use terrafill_scene::PixelRect;

    fn region(left: u32, right: u32) -> PlannedRegion {
        PlannedRegion {
            mesh: 0,
            heights: VolumeHeights {
                top_m: 1.0,
                bottom_m: -1.0,
            },
            screen_rect: PixelRect {
                left,
                top: 0,
                right,
                bottom: 1,
            },
        }
    }

    #[test]
    fn overlapping_rectangles_get_different_numbers() {
        let regions = [region(0, 10), region(5, 15), region(10, 20), region(30, 40)];
        let batches = XorBatches::new(&regions);
        assert_eq!(batches.passes, vec![vec![vec![0, 2, 3], vec![1]]]);
    }

    #[test]
    fn more_numbers_than_the_stencil_has_take_another_pass() {
        let regions = vec![region(0, 10); XOR_NUMBERS + 3];
        let batches = XorBatches::new(&regions);
        let sizes: Vec<_> = batches.passes.iter().map(Vec::len).collect();
        assert_eq!(sizes, [XOR_NUMBERS, 3]);
        assert_eq!(
            batches.passes.iter().flatten().flatten().count(),
            regions.len()
        );
    }
}
