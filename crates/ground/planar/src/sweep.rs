// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which of many straight edges cross: a line swept over them from west to east.
//!
//! Degrees, or any plane in which the edges are straight. Edges side by side that are much longer than they are far apart, such as the teeth of a
//! comb, defeat every comparison of boxes. Each box overlaps as many others as the edge is longer. In
//! the order in which the line meets them only neighbours need to be compared (Shamos & Hoey 1976).
//! Sides are decided exactly (`robust::orient2d`), so the order is right whatever touches.

use crate::intersection::{Crossing, orient, planar_crossing, without_underflow};
use crate::{Degrees, in_order};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound::{Excluded, Unbounded};

/// Edges that cross another one before the sweep gives up: each of them is compared with all others.
const MAX_SET_ASIDE: usize = 256;

/// Crossings of straight edges, each strictly between the ends of both, in order of their edges.
///
/// - `crossing_at`: where two edges cross, by index, the lower first. Edges that cross by this have to
///   cross as straight lines; those that do only as such are compared with more others than need be
/// - `most`: with so many or more the list is cut short there
/// - returns: crossings, and whether these are all; `None` where more than 256 edges have to be set
///   aside for the others to cross nowhere
/// - cost: O(n log n), and n for each edge set aside
pub fn sweep_crossings(
    edges: &[[Degrees; 2]],
    crossing_at: &impl Fn(usize, usize) -> Option<Degrees>,
    most: usize,
) -> Option<(Vec<Crossing>, bool)> {
    let mut sweep = Sweep {
        edges,
        crossing_at,
        order: BTreeSet::new(),
        aside: Vec::new(),
        found: Vec::new(),
    };
    let is_whole = sweep.run(most.min(MAX_SET_ASIDE));
    let Sweep {
        aside, mut found, ..
    } = sweep;
    if !is_whole {
        found.sort_unstable_by_key(|crossing: &Crossing| crossing.0);
        found.truncate(most);
        return (found.len() == most).then_some((found, false));
    }
    let mut found = Vec::new();
    for (at, &a) in aside.iter().enumerate() {
        let others = (0..edges.len()).filter(|b| *b != a && !aside[..at].contains(b));
        for b in others {
            if let Some(crossing) = crossing_of(crossing_at, a, b) {
                if found.len() == most {
                    return Some((found, false));
                }
                found.push(crossing);
            }
        }
    }
    found.sort_unstable_by_key(|crossing: &Crossing| crossing.0);
    Some((found, true))
}

struct Sweep<'a, F> {
    edges: &'a [[Degrees; 2]],
    crossing_at: &'a F,
    /// Edges that the line meets, from south to north; none crosses its neighbours.
    order: BTreeSet<Segment>,
    /// Edges without which the others cross nowhere.
    aside: Vec<usize>,
    /// A crossing of each of them.
    found: Vec<Crossing>,
}

impl<F: Fn(usize, usize) -> Option<Degrees>> Sweep<'_, F> {
    /// Whether the line came to the end with at most so many edges set aside.
    fn run(&mut self, most_aside: usize) -> bool {
        let segments: Vec<Segment> = (0..).zip(self.edges).map(Segment::of).collect();
        let ends = |segment: &Segment| {
            let Segment { west, east, index } = *segment;
            [(west, true, index), (east, false, index)]
        };
        let mut events: Vec<(Degrees, bool, usize)> = segments.iter().flat_map(ends).collect();
        events.retain(|(_, _, index)| segments[*index].west != segments[*index].east);
        // What ends at a place is gone before others start there.
        events.sort_unstable_by(|a, b| by_place(a.0, b.0).then(a.1.cmp(&b.1)));
        for (_, starts, index) in events {
            let segment = segments[index];
            if starts {
                self.start(segment);
            } else if self.order.remove(&segment) {
                self.meet_round(segment);
            }
            if self.aside.len() > most_aside {
                return false;
            }
        }
        true
    }

    fn neighbours(&self, segment: &Segment) -> [Option<Segment>; 2] {
        let south = self.order.range(..segment).next_back();
        let north = self.order.range((Excluded(segment), Unbounded)).next();
        [south, north].map(Option::<&Segment>::copied)
    }

    fn start(&mut self, segment: Segment) {
        let mut neighbours = self.neighbours(&segment).into_iter().flatten();
        if !neighbours.any(|other| self.crosses(segment, other)) {
            self.order.insert(segment);
        }
    }

    /// Compares the edges that have become neighbours where one was.
    fn meet_round(&mut self, gone: Segment) {
        while let [Some(south), Some(north)] = self.neighbours(&gone) {
            if !self.crosses(north, south) {
                break;
            }
            self.order.remove(&north);
        }
    }

    /// Whether two edges cross, the first of which is set aside if they do.
    fn crosses(&mut self, segment: Segment, other: Segment) -> bool {
        let [a, b] = [segment.index, other.index];
        let crosses = planar_crossing(self.edges[a], self.edges[b]).is_some();
        if crosses {
            self.aside.push(a);
            self.found.extend(crossing_of(self.crossing_at, a, b));
        }
        crosses
    }
}

fn crossing_of(
    crossing_at: &impl Fn(usize, usize) -> Option<Degrees>,
    a: usize,
    b: usize,
) -> Option<Crossing> {
    let pair = [a.min(b), a.max(b)];
    Some((pair, crossing_at(pair[0], pair[1])?))
}

/// An edge, in the order of those that cross nowhere along a line across both. Edges along one line
/// are in order of their index.
#[derive(Debug, Clone, Copy)]
struct Segment {
    west: Degrees,
    east: Degrees,
    index: usize,
}

impl Segment {
    fn of((index, ends): (usize, &[Degrees; 2])) -> Self {
        // Adding zero turns −0 into 0, which sorts apart from it.
        let [start, end] = ends.map(|end| end.map(|x| without_underflow(x) + 0.0));
        let (west, east) = in_order(start, end);
        Self { west, east, index }
    }

    /// Whether another edge, which starts where the line meets this one, is north or south of it.
    fn side_of(&self, other: &Self) -> Ordering {
        let side = |place| {
            let side = orient(self.west, self.east, place);
            side.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
        };
        side(other.west).then_with(|| side(other.east))
    }
}

fn by_place(a: Degrees, b: Degrees) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

impl Ord for Segment {
    fn cmp(&self, other: &Self) -> Ordering {
        let sides = if by_place(self.west, other.west).is_le() {
            self.side_of(other).reverse()
        } else {
            other.side_of(self)
        };
        sides.then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Segment {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Segment {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Segment {}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn slow_crossings(edges: &[[Degrees; 2]]) -> Vec<Crossing> {
        let all = (0..edges.len()).flat_map(|a| (a + 1..edges.len()).map(move |b| [a, b]));
        let crossing = |[a, b]: [usize; 2]| Some(([a, b], planar_crossing(edges[a], edges[b])?));
        all.filter_map(crossing).collect()
    }

    fn swept(edges: &[[Degrees; 2]], most: usize) -> Option<(Vec<Crossing>, bool)> {
        let crossing_at = |a: usize, b: usize| planar_crossing(edges[a], edges[b]);
        sweep_crossings(edges, &crossing_at, most)
    }

    fn edges(side: i32, most: usize) -> impl Strategy<Value = Vec<[Degrees; 2]>> {
        let place = (0..side, 0..side).prop_map(|(x, y)| [f64::from(x), f64::from(y)]);
        let edge = (place.clone(), place).prop_map(|(start, end)| [start, end]);
        prop::collection::vec(edge, 0..most)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4_000))]

        // On a small grid edges touch, share ends and lie over one another all the time.
        #[test]
        fn a_sweep_finds_what_comparing_all_finds(edges in prop_oneof![edges(4, 9), edges(9, 9), edges(40, 30)]) {
            let found = swept(&edges, usize::MAX);
            prop_assert_eq!(found, Some((slow_crossings(&edges), true)));
        }

        #[test]
        fn edges_that_cross_nowhere_need_no_other(edges in edges(12, 40)) {
            let mut kept: Vec<[Degrees; 2]> = Vec::new();
            for edge in edges {
                if kept.iter().all(|other| planar_crossing(edge, *other).is_none()) {
                    kept.push(edge);
                }
            }
            prop_assert_eq!(swept(&kept, 1), Some((Vec::new(), true)));
        }
    }

    #[test]
    fn a_list_is_cut_short_and_too_many_are_left_to_others() {
        // Ten by ten, each of which crosses ten.
        let grid = |count: u32| -> Vec<[Degrees; 2]> {
            let across = |k: u32| f64::from(k) + 0.5;
            let span = f64::from(count) + 1.0;
            let east = (0..count).map(|k| [[0.0, across(k)], [span, across(k)]]);
            let north = (0..count).map(|k| [[across(k), 0.0], [across(k), span]]);
            east.chain(north).collect()
        };
        let (found, is_all) = swept(&grid(10), 1_000).expect("few");
        assert_eq!((found.len(), is_all), (100, true));
        for most in [99, 7] {
            let (found, is_all) = swept(&grid(10), most).expect("few");
            assert_eq!((found.len(), is_all), (most, false));
        }
        let too_many = u32::try_from(MAX_SET_ASIDE).expect("small") + 2;
        assert_eq!(swept(&grid(too_many), usize::MAX), None);
    }
}
