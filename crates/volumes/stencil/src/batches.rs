// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which volumes may share a stencil value, and how many may lie over one pixel.
//!
//! *XOR*: each volume gets an 8-bit number and flips those bits: being closed, it toggles them an
//! odd number of times exactly inside, so the stencil holds the number there. Two volumes may share a number unless their screen rectangles overlap, because the cover of one
//! would then find the other's pixels. Right for disjoint volumes only: where two overlap, the
//! stencil holds the XOR of their numbers.
//!
//! *Bit planes*: each volume gets a bit of its own among those whose rectangles it overlaps, so the
//! stencil holds any number of overlapping volumes side by side, eight at a time.

use crate::Volume;
use terrafill_plan::PixelRect;

/// Passes → classes → indices into the list.
pub(crate) type Batches = Vec<Vec<Vec<usize>>>;

fn is_free(volumes: &[Volume], class: &[usize], rect: PixelRect) -> bool {
    class
        .iter()
        .all(|&other| !volumes[other].screen_rect.overlaps(rect))
}

/// Volumes by number less 1, in passes of at most so many numbers, each of which clears the stencil: a greedy
/// colouring of the rectangles' overlap graph, in their order.
#[must_use]
pub(crate) fn xor_batches(volumes: &[Volume], numbers: u8) -> Batches {
    let mut classes: Vec<Vec<usize>> = Vec::new();
    for (index, volume) in volumes.iter().enumerate() {
        let free = classes
            .iter_mut()
            .find(|class| is_free(volumes, class, volume.screen_rect));
        match free {
            Some(class) => class.push(index),
            None => classes.push(vec![index]),
        }
    }
    let passes = classes.chunks(usize::from(numbers.max(1)));
    passes.map(<[Vec<usize>]>::to_vec).collect()
}

/// Volumes in classes whose members do not overlap on the screen, at most `classes` a pass. No volume comes
/// in an earlier pass than one before it in the list, so passes drawn one after the other keep
/// the order in which volumes cover each other.
#[must_use]
pub(crate) fn ordered_batches(volumes: &[Volume], classes: usize) -> Batches {
    let mut passes = Batches::new();
    for (index, volume) in volumes.iter().enumerate() {
        let rect = volume.screen_rect;
        let Some(pass) = passes.last_mut() else {
            passes.push(vec![vec![index]]);
            continue;
        };
        let free = pass.iter().position(|class| is_free(volumes, class, rect));
        match free {
            Some(class) => pass[class].push(index),
            None if pass.len() < classes => pass.push(vec![index]),
            None => passes.push(vec![vec![index]]),
        }
    }
    passes
}

/// Most screen rectangles over one pixel: no more volumes than that can lie over it.
#[must_use]
pub(crate) fn overlap_depth(volumes: &[Volume]) -> usize {
    // The deepest pixel may be taken where some rectangle starts, in both directions.
    let mut deepest = 0;
    for start in volumes {
        let column = start.screen_rect.left;
        let mut ends: Vec<(u32, i32)> = volumes
            .iter()
            .map(|volume| volume.screen_rect)
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
    use crate::DepthRange;
    use terrafill_plan::{DrawnAs, NearRectangle};

    fn volume(left: u32, right: u32) -> Volume {
        Volume {
            geometry: 0,
            near_rectangle: NearRectangle::Outside,
            drawn_as: DrawnAs::Volume,
            depth: DepthRange::ANY,
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
        let volumes = [volume(0, 10), volume(5, 15), volume(10, 20), volume(30, 40)];
        assert_eq!(xor_batches(&volumes, 255), [[vec![0, 2, 3], vec![1]]]);
    }

    #[test]
    fn more_numbers_than_the_stencil_has_take_another_pass() {
        for numbers in [255, 3] {
            let volumes = vec![volume(0, 10); usize::from(numbers) + 3];
            let passes = xor_batches(&volumes, numbers);
            let sizes: Vec<_> = passes.iter().map(Vec::len).collect();
            assert_eq!(sizes, [usize::from(numbers), 3]);
            assert_eq!(passes.iter().flatten().flatten().count(), volumes.len());
        }
    }

    #[test]
    fn planes_keep_the_order_and_never_share_a_pixel() {
        let volumes: Vec<_> = (0..30).map(|i| volume(i * 3, i * 3 + 10)).collect();
        let passes = ordered_batches(&volumes, 3);
        assert!(passes.len() > 1);
        let mut last = 0;
        for pass in &passes {
            assert!(pass.len() <= 3);
            let members: Vec<usize> = pass.iter().flatten().copied().collect();
            assert!(members.iter().all(|&member| member >= last));
            last = members.iter().copied().max().unwrap_or(last);
            for class in pass {
                for pair in class.windows(2) {
                    let [a, b] = [volumes[pair[0]], volumes[pair[1]]];
                    assert!(!a.screen_rect.overlaps(b.screen_rect));
                }
            }
        }
        assert_eq!(passes.iter().flatten().flatten().count(), 30);
    }

    #[test]
    fn depth_counts_the_rectangles_over_one_pixel() {
        assert_eq!(overlap_depth(&[]), 0);
        assert_eq!(overlap_depth(&vec![volume(0, 10); 300]), 300);
        // Rectangles that only touch share no pixel.
        assert_eq!(overlap_depth(&[volume(0, 10), volume(10, 20)]), 1);
        assert_eq!(
            overlap_depth(&[volume(0, 10), volume(5, 20), volume(9, 12), volume(11, 30)]),
            3
        );
    }
}
