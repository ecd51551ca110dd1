// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which regions may share a stencil value, and how many may lie over one pixel.
//!
//! *XOR*: each region gets an 8-bit number and its volume flips those bits: a closed volume
//! toggles them an odd number of times exactly inside, so the stencil holds the number there. Two
//! regions may share a number unless their screen rectangles overlap, because the cover of one
//! would then find the other's pixels. Right for disjoint regions only: where two overlap, the
//! stencil holds the XOR of their numbers.
//!
//! *Bit planes*: each region gets a bit of its own among those whose rectangles it overlaps, so the
//! stencil holds any number of overlapping regions side by side, eight at a time.

use terrafill_scene::PlannedRegion;

/// Numbers an 8-bit stencil can tell apart from "no region".
pub const XOR_NUMBERS: usize = 255;

/// Regions by number, in passes of at most [`XOR_NUMBERS`] numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct XorBatches {
    /// Pass → number − 1 → indices into the plan's regions. Each pass clears the stencil.
    pub passes: Vec<Vec<Vec<usize>>>,
}

fn is_free(regions: &[PlannedRegion], class: &[usize], rect: terrafill_scene::PixelRect) -> bool {
    class
        .iter()
        .all(|&other| !regions[other].screen_rect.overlaps(rect))
}

impl XorBatches {
    /// Greedy colouring of the rectangles' overlap graph, in plan order.
    #[must_use]
    pub fn new(regions: &[PlannedRegion]) -> Self {
        let mut classes: Vec<Vec<usize>> = Vec::new();
        for (index, region) in regions.iter().enumerate() {
            let free = classes
                .iter_mut()
                .find(|class| is_free(regions, class, region.screen_rect));
            match free {
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

/// Regions in classes whose members do not overlap on the screen.
#[derive(Debug, Clone, Copy)]
pub struct RegionClasses;

impl RegionClasses {
    /// Pass → class → indices into the plan's regions, at most `classes` a pass. No region comes
    /// in an earlier pass than one before it in the plan, so passes drawn one after the other keep
    /// the order in which regions cover each other.
    #[must_use]
    pub fn in_order(regions: &[PlannedRegion], classes: usize) -> Vec<Vec<Vec<usize>>> {
        let mut passes: Vec<Vec<Vec<usize>>> = Vec::new();
        for (index, region) in regions.iter().enumerate() {
            let rect = region.screen_rect;
            let Some(pass) = passes.last_mut() else {
                passes.push(vec![vec![index]]);
                continue;
            };
            let free = pass.iter().position(|class| is_free(regions, class, rect));
            match free {
                Some(class) => pass[class].push(index),
                None if pass.len() < classes => pass.push(vec![index]),
                None => passes.push(vec![vec![index]]),
            }
        }
        passes
    }
}

/// Most screen rectangles over one pixel: no more regions than that can lie over it.
#[must_use]
pub fn overlap_depth(regions: &[PlannedRegion]) -> usize {
    // The deepest pixel may be taken where some rectangle starts, in both directions.
    let mut deepest = 0;
    for start in regions {
        let column = start.screen_rect.left;
        let mut ends: Vec<(u32, i32)> = regions
            .iter()
            .map(|region| region.screen_rect)
            .filter(|rect| rect.left <= column && column < rect.right && rect.height() > 0)
            .flat_map(|rect| [(rect.top, 1), (rect.bottom, -1)])
            .collect();
        ends.sort_unstable();
        let mut depth = 0_i32;
        for (_, step) in ends {
            depth += step;
            deepest = deepest.max(depth);
        }
    }
    usize::try_from(deepest).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::VolumeHeights;
    use terrafill_scene::PixelRect;

    fn region(left: u32, right: u32) -> PlannedRegion {
        PlannedRegion {
            region: 0,
            mesh: 0,
            near_plane_meets_volume: false,
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

    #[test]
    fn planes_keep_the_order_and_never_share_a_pixel() {
        let regions: Vec<_> = (0..30).map(|i| region(i * 3, i * 3 + 10)).collect();
        let passes = RegionClasses::in_order(&regions, 3);
        assert!(passes.len() > 1);
        let mut last = 0;
        for pass in &passes {
            assert!(pass.len() <= 3);
            let members: Vec<usize> = pass.iter().flatten().copied().collect();
            assert!(members.iter().all(|&member| member >= last));
            last = members.iter().copied().max().unwrap_or(last);
            for class in pass {
                for pair in class.windows(2) {
                    let [a, b] = [regions[pair[0]], regions[pair[1]]];
                    assert!(!a.screen_rect.overlaps(b.screen_rect));
                }
            }
        }
        assert_eq!(passes.iter().flatten().flatten().count(), 30);
    }

    #[test]
    fn depth_counts_the_rectangles_over_one_pixel() {
        assert_eq!(overlap_depth(&[]), 0);
        assert_eq!(overlap_depth(&vec![region(0, 10); 300]), 300);
        // Rectangles that only touch share no pixel.
        assert_eq!(overlap_depth(&[region(0, 10), region(10, 20)]), 1);
        assert_eq!(
            overlap_depth(&[region(0, 10), region(5, 20), region(9, 12), region(11, 30)]),
            3
        );
    }
}
