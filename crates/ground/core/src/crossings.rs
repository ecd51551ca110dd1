// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finding the places where edges cross, and splitting edges there.
//!
//! Degrees for planar edges, unit normals for great ellipses. Candidates come from a tree over the
//! edges' boxes: O(n log n + pairs whose boxes overlap). Where those are very many, edges are swept
//! instead (see `sweep`), great ellipses in a chart in which they are straight.

use crate::edge::{Degrees, normal};
use crate::pieces::OutlineEdge;
use crate::{EdgePlace, EdgeRule};
use glam::DVec3;
use std::ops::ControlFlow;
use terrafill_planar::box_tree::{AxisBox, BoxTree};
use terrafill_planar::intersection::{Crossing, planar_crossing, unit_arcs_crossing};
use terrafill_planar::sweep::sweep_crossings;

/// Rounds after which the search gives up: a crossing is rounded to the nearest number, which can
/// bend an edge over another one close by, but only by the last bit. What is left of them then is
/// taken away by `snap` where the region is meshed.
pub(crate) const MAX_ROUNDS: usize = 8;

/// Overlapping boxes to an edge from which on edges are swept: a coast has about four.
const MAX_PAIRS_TO_AN_EDGE: usize = 32;

/// Cosine of the angle from the middle of arcs that are swept, 45°. Up to there rounding in the chart
/// moves a place by five units in the last place, a third of what `certain_side` takes for rounding:
/// arcs that cross for certain cross in the chart.
const MIN_CHART_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A box that holds the edge, in degrees or in unit normals.
fn box_of(rule: EdgeRule, [start, end]: [Degrees; 2]) -> AxisBox {
    match rule {
        EdgeRule::Planar => AxisBox::of([start, end]),
        EdgeRule::GreatEllipse => {
            let (a, b) = (normal(start), normal(end));
            // An arc of chord c rises 1 − √(1 − c²/4) ≤ c²/4 above it.
            let bulge = 0.25 * (b - a).length_squared();
            AxisBox {
                low: a.min(b) - bulge,
                high: a.max(b) + bulge,
            }
        }
    }
}

/// Crossings in order of their edges, and whether these are all: the search ends at `most`.
pub(crate) fn find_crossings(
    rule: EdgeRule,
    edges: &[[Degrees; 2]],
    most: usize,
) -> (Vec<Crossing>, bool) {
    let few = MAX_PAIRS_TO_AN_EDGE * edges.len();
    let boxes: Vec<AxisBox> = edges.iter().map(|ends| box_of(rule, *ends)).collect();
    let tree = BoxTree::new(&boxes);
    let found = match rule {
        EdgeRule::Planar => {
            let crossing = |a: usize, b: usize| planar_crossing(edges[a], edges[b]);
            compare_pairs(&tree, most, few, &crossing)
                .or_else(|| sweep_crossings(edges, &crossing, most))
                .or_else(|| compare_pairs(&tree, most, usize::MAX, &crossing))
        }
        EdgeRule::GreatEllipse => {
            let arcs: Vec<[DVec3; 2]> = edges.iter().map(|ends| ends.map(normal)).collect();
            let crossing = |a: usize, b: usize| unit_arcs_crossing(arcs[a], arcs[b]);
            compare_pairs(&tree, most, few, &crossing)
                .or_else(|| sweep_crossings(&central_chart(&arcs)?, &crossing, most))
                .or_else(|| compare_pairs(&tree, most, usize::MAX, &crossing))
        }
    };
    found.unwrap_or_default()
}

/// Arcs as straight lines: from the centre onto the plane that touches the unit sphere in their middle.
/// `None` where an end is more than 45° from there.
fn central_chart(arcs: &[[DVec3; 2]]) -> Option<Vec<[Degrees; 2]>> {
    let ends = arcs.iter().flatten();
    let middle = ends.sum::<DVec3>().try_normalize()?;
    let (east, north) = middle.any_orthonormal_pair();
    let place = |end: DVec3| {
        let up = end.dot(middle);
        (up >= MIN_CHART_COSINE).then(|| [end.dot(east) / up, end.dot(north) / up])
    };
    arcs.iter()
        .map(|[start, end]| Some([place(*start)?, place(*end)?]))
        .collect()
}

/// `None` if there are more overlapping boxes than `most_pairs`.
fn compare_pairs(
    tree: &BoxTree<'_>,
    most: usize,
    most_pairs: usize,
    crossing: &impl Fn(usize, usize) -> Option<Degrees>,
) -> Option<(Vec<Crossing>, bool)> {
    let mut found: Vec<Crossing> = Vec::new();
    let mut pairs_left = Some(most_pairs);
    let end = tree.overlapping_pairs(&mut |a, b| {
        pairs_left = pairs_left.and_then(|left| left.checked_sub(1));
        if pairs_left.is_none() {
            return ControlFlow::Break(());
        }
        let Some(at) = crossing(a, b) else {
            return ControlFlow::Continue(());
        };
        if found.len() == most {
            return ControlFlow::Break(());
        }
        found.push(([a, b], at));
        ControlFlow::Continue(())
    });
    found.sort_unstable_by_key(|crossing| crossing.0);
    pairs_left.map(|_| (found, end.is_continue()))
}

/// Splits straight edges where they cross.
///
/// Rounding can leave new crossings, so the caller tries again until there are none.
pub(crate) fn split_outline(edges: &[OutlineEdge], crossings: &[Crossing]) -> Vec<OutlineEdge> {
    let mut insertions: Vec<(usize, f64, Degrees)> = Vec::with_capacity(2 * crossings.len());
    for &(pair, at) in crossings {
        for index in pair {
            let along = distance(EdgeRule::Planar, edges[index].start, at);
            insertions.push((index, along, at));
        }
    }
    split_at(edges, insertions)
}

/// Splits edges at places: index of the edge, how far along it, place.
pub(crate) fn split_at(
    edges: &[OutlineEdge],
    mut insertions: Vec<(usize, f64, Degrees)>,
) -> Vec<OutlineEdge> {
    insertions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    insertions.dedup();
    let mut waiting = insertions.iter().peekable();
    let mut split = Vec::with_capacity(edges.len() + insertions.len());
    for (index, edge) in edges.iter().enumerate() {
        let mut rest = *edge;
        while let Some((_, _, at)) = waiting.next_if(|insertion| insertion.0 == index) {
            split.push(OutlineEdge { end: *at, ..rest });
            rest.start = *at;
        }
        split.push(rest);
    }
    split
}

/// Two ring edges that cross, the first of them in the file first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CrossingPlaces {
    pub(crate) first: EdgePlace,
    pub(crate) second: EdgePlace,
    pub(crate) at: Degrees,
}

impl CrossingPlaces {
    pub(crate) fn of([a, b]: [EdgePlace; 2], at: Degrees) -> Self {
        Self {
            first: a.min(b),
            second: a.max(b),
            at,
        }
    }
}

/// Crossings of ring edges, by those of the outline's edges that are parts of them.
pub(crate) fn crossing_places(
    edges: &[OutlineEdge],
    crossings: &[Crossing],
) -> Vec<CrossingPlaces> {
    let mut places: Vec<CrossingPlaces> = crossings
        .iter()
        .map(|&(pair, at)| {
            let [a, b] = pair.map(|index| edges[index].place);
            CrossingPlaces::of([a, b], at)
        })
        .collect();
    places.sort_by_key(|crossing| (crossing.first, crossing.second));
    // Rounding can bend neighbouring parts of one edge over the same other edge.
    places.dedup_by_key(|crossing| (crossing.first, crossing.second));
    places
}

/// Between two places, in the units of the rule's comparison: degrees, or chords of unit normals.
pub(crate) fn distance(rule: EdgeRule, a: Degrees, b: Degrees) -> f64 {
    match rule {
        EdgeRule::Planar => (b[0] - a[0]).hypot(b[1] - a[1]),
        EdgeRule::GreatEllipse => (normal(b) - normal(a)).length(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge::great_ellipse_crossing;
    use proptest::prelude::*;

    fn slow_crossings(edges: &[[Degrees; 2]]) -> Vec<Crossing> {
        let all = (0..edges.len()).flat_map(|a| (a + 1..edges.len()).map(move |b| [a, b]));
        let crossing =
            |[a, b]: [usize; 2]| Some(([a, b], great_ellipse_crossing(edges[a], edges[b])?));
        all.filter_map(crossing).collect()
    }

    fn swept(edges: &[[Degrees; 2]]) -> Option<(Vec<Crossing>, bool)> {
        let arcs: Vec<[DVec3; 2]> = edges.iter().map(|ends| ends.map(normal)).collect();
        let crossing = |a: usize, b: usize| unit_arcs_crossing(arcs[a], arcs[b]);
        sweep_crossings(&central_chart(&arcs)?, &crossing, usize::MAX)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        // Round a pole, and so near to one another that ends and crossings come to lie on edges.
        #[test]
        fn swept_arcs_cross_where_arcs_compared_do(
            edges in prop::collection::vec(prop::array::uniform2((0..12, 0..4)), 0..14),
            is_polar: bool,
        ) {
            let place = |(x, y): (i32, i32)| if is_polar { [30.0 * f64::from(x) - 180.0, 60.0 + 7.5 * f64::from(y)] } else { [179.0 + f64::from(x), f64::from(y) - 2.0] };
            let edges: Vec<[Degrees; 2]> = edges.into_iter().map(|ends| ends.map(place)).collect();
            // Far from one another, the middle of arcs is anywhere.
            if let Some(found) = swept(&edges) {
                prop_assert_eq!(found, (slow_crossings(&edges), true));
            }
        }
    }

    #[test]
    fn very_many_arcs_whose_boxes_overlap_are_swept() {
        // Lines side by side at 45°: each box overlaps those of most others.
        let line = |k: u32| {
            let x = 0.000_4 * f64::from(k);
            [[10.0 + x, 30.0 - x], [20.0 + x, 40.0 - x]]
        };
        let mut edges: Vec<[Degrees; 2]> = (0..12_000).map(line).collect();
        let boxes: Vec<AxisBox> = edges
            .iter()
            .map(|ends| box_of(EdgeRule::GreatEllipse, *ends))
            .collect();
        let tree = BoxTree::new(&boxes);
        let few = MAX_PAIRS_TO_AN_EDGE * edges.len();
        assert_eq!(compare_pairs(&tree, 9, few, &|_, _| None), None);
        assert_eq!(swept(&edges), Some((Vec::new(), true)));
        // Negative control: one across ten of them.
        let across = |k: u32, share: f64| {
            let [start, end] = line(k);
            [0, 1].map(|i| (1.0 - share) * start[i] + share * end[i])
        };
        edges.push([across(700, 0.5), across(711, 0.5)]);
        let last = edges[12_000];
        let crossed = (0..12_000).filter(|k| great_ellipse_crossing(edges[*k], last).is_some());
        let crossed: Vec<[usize; 2]> = crossed.map(|k| [k, 12_000]).collect();
        assert!(crossed.len() > 9, "{crossed:?}");
        let (found, is_whole) = find_crossings(EdgeRule::GreatEllipse, &edges, 100);
        let pairs: Vec<[usize; 2]> = found.into_iter().map(|(pair, _)| pair).collect();
        assert_eq!((pairs, is_whole), (crossed, true));
    }

    #[test]
    fn no_chart_holds_arcs_all_round() {
        let arcs = |reach_deg: f64| {
            [
                [[-reach_deg, 0.0], [0.0, 1.0]],
                [[0.0, 2.0], [reach_deg, 0.0]],
            ]
            .map(|ends: [Degrees; 2]| ends.map(normal))
        };
        assert!(central_chart(&arcs(44.0)).is_some());
        assert_eq!(central_chart(&arcs(46.0)), None);
        assert_eq!(central_chart(&arcs(180.0)), None);
    }
}
