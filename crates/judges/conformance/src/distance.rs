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

/// A picture's boundary as a distance is measured by it.
#[derive(Debug)]
pub(crate) struct Measured {
    /// Pixels whose distance counts.
    pub(crate) counted: Vec<bool>,
    /// What the other picture's pixels may be near: these, and what does not count itself.
    pub(crate) all: Vec<bool>,
}

/// Symmetric Hausdorff distance of two pixel sets: the farthest that a pixel of either that counts is from
/// the other. `None` when none counts; infinite when there is nothing to be near.
pub(crate) fn hausdorff_px(grid: Grid, a: &Measured, b: &Measured) -> Option<f64> {
    let directed = |from: &Measured, to: &Measured| {
        let is_empty = |set: &[bool]| !set.contains(&true);
        match (is_empty(&from.counted), is_empty(&to.all)) {
            (true, _) => None,
            (false, true) => Some(f64::INFINITY),
            (false, false) => Some(farthest_squared(grid, &from.counted, &to.all)),
        }
    };
    let [there, back] = [directed(a, b), directed(b, a)];
    let farthest = there.into_iter().chain(back).reduce(f64::max)?;
    Some(farthest.sqrt())
}

/// The largest squared distance of a pixel of `from` to the nearest one of `to`, which is not empty.
fn farthest_squared(grid: Grid, from: &[bool], to: &[bool]) -> f64 {
    let alone = || (0..from.len()).filter(|&index| from[index] && !to[index]);
    // Sets that hardly differ are searched around what differs; the transform takes some twenty steps a
    // pixel.
    let mut budget = 4 * from.len();
    let nearest = alone().map(|index| nearest_squared(grid, to, index, &mut budget));
    let searched = nearest.collect::<Option<Vec<usize>>>();
    if let Some(searched) = searched {
        return searched.into_iter().max().unwrap_or(0) as f64;
    }
    let squared = squared_distances(grid, to);
    alone().map(|index| squared[index]).fold(0.0, f64::max)
}

/// Squared distance of a pixel to the nearest one of `to`, by squares that grow around it; `None` when
/// they hold more pixels than `budget`, which is what is left of it afterwards.
fn nearest_squared(grid: Grid, to: &[bool], index: usize, budget: &mut usize) -> Option<usize> {
    let (column, row) = (index % grid.width, index / grid.width);
    let mut nearest = usize::MAX;
    // Beyond the square of that radius everything is farther.
    let mut radius = 1;
    while nearest > radius * radius {
        *budget = budget.checked_sub(8 * radius)?;
        let rows = row.saturating_sub(radius)..=(row + radius).min(grid.height - 1);
        let columns = column.saturating_sub(radius)..=(column + radius).min(grid.width - 1);
        let mut look = |x: usize, y: usize| {
            if to[y * grid.width + x] {
                nearest = nearest.min(column.abs_diff(x).pow(2) + row.abs_diff(y).pow(2));
            }
        };
        // The rim of the square; what is inside was looked at before.
        for y in rows {
            if row.abs_diff(y) == radius {
                columns.clone().for_each(|x| look(x, y));
                continue;
            }
            for x in [column.checked_sub(radius), Some(column + radius)] {
                if let Some(x) = x.filter(|&x| x < grid.width) {
                    look(x, y);
                }
            }
        }
        radius += 1;
    }
    Some(nearest)
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

    fn hausdorff(grid: Grid, a: &[bool], b: &[bool]) -> Option<f64> {
        let [a, b] = [a, b].map(|set| Measured {
            counted: set.to_vec(),
            all: set.to_vec(),
        });
        hausdorff_px(grid, &a, &b)
    }

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
        fn sets_that_hardly_differ_are_as_far_apart_as_the_transform_says(
            width in 1_usize..40,
            height in 1_usize..40,
            bits in proptest::collection::vec(0_u8..40, 40 * 40),
            moved in 0_u8..3,
        ) {
            let grid = Grid { width, height };
            let set = |odd: u8| -> Vec<bool> {
                bits[..width * height].iter().map(|&bit| bit <= 1 || bit == 2 + odd).collect()
            };
            let (a, b) = (set(0), set(moved));
            prop_assume!(a.contains(&true) && b.contains(&true));
            let by_transform = |from: &[bool], to: &[bool]| {
                let squared = squared_distances(grid, to);
                let here = from.iter().zip(squared).filter(|(set, _)| **set);
                here.map(|(_, squared)| squared).fold(0.0, f64::max)
            };
            prop_assert_eq!(farthest_squared(grid, &a, &b), by_transform(&a, &b));
            prop_assert_eq!(farthest_squared(grid, &b, &a), by_transform(&b, &a));
        }

        #[test]
        fn hausdorff_is_symmetric_and_zero_only_for_equal_sets(
            a in proptest::collection::vec(any::<bool>(), 64),
            b in proptest::collection::vec(any::<bool>(), 64),
        ) {
            let grid = Grid { width: 8, height: 8 };
            let there = hausdorff(grid, &a, &b);
            prop_assert_eq!(there, hausdorff(grid, &b, &a));
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
        assert_eq!(hausdorff(grid, &at(0, 0), &at(4, 3)), Some(5.0));
        let mut both = at(0, 0);
        both[19] = true;
        // One direction is 0, the other 5: a one-sided distance would miss the extra pixel.
        assert_eq!(hausdorff(grid, &at(0, 0), &both), Some(5.0));
        assert_eq!(hausdorff(grid, &both, &at(0, 0)), Some(5.0));
        let none = vec![false; 20];
        assert_eq!(hausdorff(grid, &none, &none), None);
        assert_eq!(hausdorff(grid, &none, &both), Some(f64::INFINITY));
    }
}
