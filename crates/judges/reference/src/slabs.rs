// SPDX-License-Identifier: MIT OR Apache-2.0
//! Intervals of a line, found by a point: equal slabs, each with the intervals that touch it.
//!
//! Which slab a number belongs to never decreases with the number, rounding included. So a point
//! within an interval always lies in one of the slabs that the interval was entered in, and
//! nothing needs padding.

/// An index over intervals.
#[derive(Debug, Clone)]
pub(crate) struct Slabs {
    low: f64,
    per_unit: f64,
    /// Where each slab's items begin; one more than there are slabs.
    starts: Vec<usize>,
    items: Vec<u32>,
}

impl Slabs {
    /// - `low`, `high`: what the slabs cover; whatever lies beyond goes to the first or last
    /// - `intervals`: item, first and last number; an item may have several intervals, one after
    ///   the other, and still stands once in each slab
    pub(crate) fn new(low: f64, high: f64, intervals: &[(u32, f64, f64)]) -> Self {
        // Half as many slabs as intervals keeps short edges in one or two slabs each.
        let count = (intervals.len() / 2).clamp(1, 1 << 16);
        let width = high - low;
        let mut slabs = Self {
            low,
            per_unit: if width > 0.0 {
                count as f64 / width
            } else {
                0.0
            },
            starts: vec![0; count + 1],
            items: Vec::new(),
        };
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); count];
        for &(item, first, last) in intervals {
            for list in &mut lists[slabs.slab_of(first)..=slabs.slab_of(last)] {
                if list.last() != Some(&item) {
                    list.push(item);
                }
            }
        }
        for (slab, list) in lists.iter().enumerate() {
            slabs.items.extend_from_slice(list);
            slabs.starts[slab + 1] = slabs.items.len();
        }
        slabs
    }

    /// Items whose intervals may hold `x`; all that do are among them.
    pub(crate) fn at(&self, x: f64) -> &[u32] {
        let slab = self.slab_of(x);
        &self.items[self.starts[slab]..self.starts[slab + 1]]
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the cast saturates, and the number of slabs bounds it from above"
    )]
    fn slab_of(&self, x: f64) -> usize {
        (((x - self.low) * self.per_unit) as usize).min(self.starts.len() - 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_interval_that_holds_the_point_is_found_once(
            ends in proptest::collection::vec((-10.0..10.0_f64, 0.0..8.0_f64), 1..40),
            points in proptest::collection::vec(-12.0..20.0_f64, 1..20),
        ) {
            let intervals: Vec<(u32, f64, f64)> = ends
                .iter()
                .zip(0..)
                .map(|(&(low, length), item)| (item, low, low + length))
                .collect();
            let slabs = Slabs::new(-10.0, 10.0, &intervals);
            let corners = intervals.iter().flat_map(|i| [i.1, i.2]);
            for x in points.into_iter().chain(corners) {
                let found = slabs.at(x);
                for &(item, low, high) in &intervals {
                    let times = found.iter().filter(|&&other| other == item).count();
                    prop_assert!(times <= 1);
                    prop_assert!(times == 1 || x < low || x > high, "{} not found at {}", item, x);
                }
            }
        }
    }

    #[test]
    fn an_interval_far_from_the_point_is_left_out() {
        // Negative control: an index that returns everything would pass the test above.
        let intervals: Vec<(u32, f64, f64)> = (0..100)
            .map(|i| (i, f64::from(i), f64::from(i) + 0.5))
            .collect();
        let slabs = Slabs::new(0.0, 100.0, &intervals);
        assert!(slabs.at(50.2).len() < 5);
    }

    #[test]
    fn an_item_of_two_intervals_in_one_slab_stands_there_once() {
        let slabs = Slabs::new(-1.0, 1.0, &[(7, -1.0, -0.9), (7, 0.9, 1.0)]);
        assert_eq!(slabs.at(0.0), [7]);
    }
}
