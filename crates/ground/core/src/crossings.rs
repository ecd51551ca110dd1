// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finding the places where edges cross, and splitting edges there.
//!
//! Degrees for planar edges, unit normals for great ellipses. Candidates come from a tree over the
//! edges' boxes: O(n log n + pairs whose boxes overlap). Where those are very many, straight edges are
//! swept instead (see `sweep`).

use crate::box_tree::{AxisBox, BoxTree};
use crate::edge::{Degrees, normal};
use crate::intersection::{Crossing, great_ellipse_crossing, planar_crossing};
use crate::pieces::OutlineEdge;
use crate::sweep::sweep_crossings;
use crate::{EdgePlace, EdgeRule};
use glam::DVec3;
use std::ops::ControlFlow;

/// Rounds after which the search gives up: a crossing is rounded to the nearest number, which can
/// bend an edge over another one close by, but only by the last bit. What is left of them then is
/// taken away by `snap` where the region is meshed.
pub(crate) const MAX_ROUNDS: usize = 8;

/// Overlapping boxes to an edge from which on straight edges are swept: a coast has about four.
const MAX_PAIRS_TO_AN_EDGE: usize = 32;

/// A box that holds the edge, in degrees or in unit normals.
fn box_of(rule: EdgeRule, [start, end]: [Degrees; 2]) -> AxisBox {
    let (a, b, bulge) = match rule {
        EdgeRule::Planar => {
            let point = |[x, y]: Degrees| DVec3::new(x, y, 0.0);
            (point(start), point(end), 0.0)
        }
        EdgeRule::GreatEllipse => {
            let (a, b) = (normal(start), normal(end));
            // An arc of chord c rises 1 − √(1 − c²/4) ≤ c²/4 above it.
            (a, b, 0.25 * (b - a).length_squared())
        }
    };
    AxisBox {
        low: a.min(b) - bulge,
        high: a.max(b) + bulge,
    }
}

/// Crossings in order of their edges, and whether these are all: the search ends at `most`.
pub(crate) fn find_crossings(
    rule: EdgeRule,
    edges: &[[Degrees; 2]],
    most: usize,
) -> (Vec<Crossing>, bool) {
    let boxes: Vec<AxisBox> = edges.iter().map(|ends| box_of(rule, *ends)).collect();
    let tree = BoxTree::new(&boxes);
    let pairs = match rule {
        EdgeRule::Planar => MAX_PAIRS_TO_AN_EDGE * edges.len(),
        EdgeRule::GreatEllipse => usize::MAX,
    };
    compare_pairs(rule, edges, &tree, most, pairs)
        .or_else(|| sweep_crossings(edges, most))
        .or_else(|| compare_pairs(rule, edges, &tree, most, usize::MAX))
        .unwrap_or_default()
}

/// `None` if there are more overlapping boxes than `most_pairs`.
fn compare_pairs(
    rule: EdgeRule,
    edges: &[[Degrees; 2]],
    tree: &BoxTree<'_>,
    most: usize,
    most_pairs: usize,
) -> Option<(Vec<Crossing>, bool)> {
    let mut found: Vec<Crossing> = Vec::new();
    let mut pairs_left = Some(most_pairs);
    let end = tree.overlapping_pairs(&mut |a, b| {
        pairs_left = pairs_left.and_then(|left| left.checked_sub(1));
        if pairs_left.is_none() {
            return ControlFlow::Break(());
        }
        let crossing = match rule {
            EdgeRule::Planar => planar_crossing(edges[a], edges[b]),
            EdgeRule::GreatEllipse => great_ellipse_crossing(edges[a], edges[b]),
        };
        let Some(at) = crossing else {
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
