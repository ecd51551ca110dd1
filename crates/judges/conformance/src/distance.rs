// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact Euclidean distance transform, and the Hausdorff distance by it.
//!
//! Distances in pixels between pixel centres. Squared distances are whole numbers, so the only
//! rounding is in where two parabolas cut each other, and a tie there gives the same distance from
//! either. Source: Felzenszwalb and Huttenlocher (2012), "Distance Transforms of Sampled
//! Functions", Theory of Computing 8, algorithm 1: lower envelope of parabolas, one axis after
//! the other, O(pixels).

use crate::boundary::Grid;

/// Squared distance of every pixel to the nearest one of `set`; infinite when `set` is empty.
pub(crate) fn squared_distances(grid: Grid, set: &[bool]) -> Vec<f64> {
    let mut field: Vec<f64> = set
        .iter()
        .map(|&here| if here { 0.0 } else { f64::INFINITY })
        .collect();
    let mut envelope = Envelope::default();
    let mut line = vec![0.0; grid.height];
    for column in 0..grid.width {
        for (row, value) in line.iter_mut().enumerate() {
            *value = field[row * grid.width + column];
        }
        envelope.transform(&mut line);
        for (row, value) in line.iter().enumerate() {
            field[row * grid.width + column] = *value;
        }
    }
    if grid.width > 0 {
        for row in field.chunks_mut(grid.width) {
            envelope.transform(row);
        }
    }
    field
}

/// Symmetric Hausdorff distance of two pixel sets: the farthest that a pixel of either is from the
/// other. `None` when both are empty; infinite when one is.
pub(crate) fn hausdorff_px(grid: Grid, a: &[bool], b: &[bool]) -> Option<f64> {
    let farthest = |from: &[bool], to: &[bool]| {
        let squared = squared_distances(grid, to);
        let here = from.iter().zip(squared).filter(|(set, _)| **set);
        here.map(|(_, squared)| squared)
            .fold(None, |farthest: Option<f64>, squared| {
                Some(farthest.map_or(squared, |farthest| farthest.max(squared)))
            })
    };
    match (farthest(a, b), farthest(b, a)) {
        (None, None) => None,
        (there, back) => Some(there.unwrap_or(0.0).max(back.unwrap_or(0.0)).sqrt()),
    }
}

/// Lower envelope of unit parabolas over a line of samples.
#[derive(Debug, Default)]
struct Envelope {
    /// Position and height of each parabola's vertex, left to right.
    vertices: Vec<(f64, f64)>,
    /// Where each parabola becomes the lowest; the first one from −∞ on.
    starts: Vec<f64>,
}

impl Envelope {
    /// Replaces `line[i]` by the smallest `line[j] + (i − j)²`.
    fn transform(&mut self, line: &mut [f64]) {
        self.vertices.clear();
        self.starts.clear();
        for (index, &height) in line.iter().enumerate() {
            if height.is_finite() {
                self.push(index as f64, height);
            }
        }
        let mut k = 0;
        for (index, value) in line.iter_mut().enumerate() {
            let x = index as f64;
            while k + 1 < self.starts.len() && self.starts[k + 1] < x {
                k += 1;
            }
            if let Some(&(position, height)) = self.vertices.get(k) {
                *value = (x - position) * (x - position) + height;
            }
        }
    }

    /// Adds a parabola to the right of all others, dropping those that it covers.
    fn push(&mut self, position: f64, height: f64) {
        let start = loop {
            let (Some(&(last, last_height)), Some(&last_start)) =
                (self.vertices.last(), self.starts.last())
            else {
                break f64::NEG_INFINITY;
            };
            let cut = ((height + position * position) - (last_height + last * last))
                / (2.0 * (position - last));
            if cut > last_start {
                break cut;
            }
            self.vertices.pop();
            self.starts.pop();
        };
        self.vertices.push((position, height));
        self.starts.push(start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(grid: Grid, set: &[bool]) -> Vec<f64> {
        let place = |index: usize| ((index % grid.width) as f64, (index / grid.width) as f64);
        (0..set.len())
            .map(|p| {
                let (x, y) = place(p);
                (0..set.len())
                    .filter(|&q| set[q])
                    .map(|q| (place(q).0 - x).powi(2) + (place(q).1 - y).powi(2))
                    .fold(f64::INFINITY, f64::min)
            })
            .collect()
    }

    proptest! {
        #[test]
        fn the_transform_is_the_brute_force(
            width in 1_usize..24,
            height in 1_usize..24,
            bits in proptest::collection::vec(0_u8..12, 24 * 24),
        ) {
            let grid = Grid { width, height };
            let set: Vec<bool> = bits[..width * height].iter().map(|&bit| bit == 0).collect();
            prop_assert_eq!(squared_distances(grid, &set), brute(grid, &set));
        }

        #[test]
        fn hausdorff_is_symmetric_and_zero_only_for_equal_sets(
            a in proptest::collection::vec(any::<bool>(), 64),
            b in proptest::collection::vec(any::<bool>(), 64),
        ) {
            let grid = Grid { width: 8, height: 8 };
            let there = hausdorff_px(grid, &a, &b);
            prop_assert_eq!(there, hausdorff_px(grid, &b, &a));
            prop_assert_eq!(there.is_none_or(|px| px == 0.0), a == b);
        }
    }

    #[test]
    fn distances_by_hand() {
        let grid = Grid {
            width: 5,
            height: 4,
        };
        let at = |column: usize, row: usize| {
            let mut set = vec![false; 20];
            set[row * 5 + column] = true;
            set
        };
        assert_eq!(hausdorff_px(grid, &at(0, 0), &at(4, 3)), Some(5.0));
        let mut both = at(0, 0);
        both[19] = true;
        // One direction is 0, the other 5: a one-sided distance would miss the extra pixel.
        assert_eq!(hausdorff_px(grid, &at(0, 0), &both), Some(5.0));
        assert_eq!(hausdorff_px(grid, &both, &at(0, 0)), Some(5.0));
        let none = vec![false; 20];
        assert_eq!(hausdorff_px(grid, &none, &none), None);
        assert_eq!(hausdorff_px(grid, &none, &both), Some(f64::INFINITY));
    }
}
