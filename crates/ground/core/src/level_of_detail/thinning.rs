// SPDX-License-Identifier: MIT OR Apache-2.0
//! Taking vertices out of arcs, one at a time, the one whose loss deviates least first.
//!
//! Degrees and metres. What stands in the way of a vertex's loss is decided exactly for planar edges; of arcs, what
//! rounding could change counts as in the way.

use super::arcs::{Arcs, BorderArc, Entry, in_order};
use super::deviation::LONGEST_EDGE_DEG;
use super::grid::VertexGrid;
use super::shared::SharedBoundaries;
use crate::EdgeRule;
use crate::edge::Degrees;
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashSet};
use terrafill_planar::index_u32;
use terrafill_planar::intersection::orient;

/// Vertices that every ring keeps.
const FEWEST_VERTICES: u32 = 3;

/// A vertex that may go, by what its loss would cost.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    deviation_m: f64,
    /// Decides between equals, so that the order of rings in their file does not.
    position: Degrees,
    /// Of its arc's entries.
    entry: u32,
    version: u32,
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |candidate: &Self| {
            let [longitude, latitude] = candidate.position;
            [candidate.deviation_m, longitude, latitude]
        };
        let by_key = key(self).into_iter().zip(key(other));
        by_key
            .map(|(a, b)| a.total_cmp(&b))
            .find(|order| order.is_ne())
            .unwrap_or_else(|| (self.entry, self.version).cmp(&(other.entry, other.version)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Arcs on their way down.
pub(super) struct Thinning<'a> {
    shared: &'a SharedBoundaries,
    chains: Vec<Chain<'a>>,
    /// Vertices that each ring still has.
    ring_size: Vec<u32>,
    node_edges: HashSet<[u32; 2]>,
    around: Surroundings<'a>,
}

impl<'a> Thinning<'a> {
    pub(super) fn new(shared: &'a SharedBoundaries) -> Self {
        let arcs = &shared.arcs;
        let sizes = arcs.rings.iter().map(|ring| index_u32(ring.vertices.len()));
        Self {
            shared,
            chains: arcs.arcs.iter().map(|arc| Chain::new(arc, arcs)).collect(),
            ring_size: sizes.collect(),
            node_edges: arcs.node_edges.clone(),
            around: Surroundings {
                shared,
                grid: VertexGrid::new(&arcs.vertices),
            },
        }
    }

    /// Of each region, a bound on how far its boundary is from what it was.
    pub(super) fn deviations_m(&self) -> Vec<f64> {
        let mut deviations_m = vec![0.0_f64; self.shared.regions.len()];
        for chain in &self.chains {
            for &ring in &chain.arc.rings {
                let of_region = &mut deviations_m[self.shared.arcs.rings[ring as usize].region];
                *of_region = of_region.max(chain.largest_m);
            }
        }
        deviations_m
    }

    /// Of each vertex, whether it is still there.
    fn kept(&self) -> Vec<bool> {
        let mut kept = vec![true; self.shared.arcs.vertices.len()];
        for chain in &self.chains {
            for (entry, link) in chain.entries.iter().zip(&chain.links) {
                kept[entry.vertex as usize] &= link.is_there;
            }
        }
        kept
    }

    /// Takes out what the tolerance allows; returns of each vertex whether it is still there.
    ///
    /// Each arc for itself: to it the others stay as they are now. They can only lose vertices: a
    /// triangle that holds none of theirs now holds none in whatever order the arcs come. So what is
    /// left does not depend on the number of threads.
    pub(super) fn run(&mut self, tolerance_m: f64) -> Vec<bool> {
        let around = &self.around;
        let thinned = self.chains.par_iter_mut();
        let lost: Vec<u32> = thinned
            .map(|chain| chain.thin(around, tolerance_m))
            .collect();
        for (chain, lost) in self.chains.iter().zip(lost) {
            for &ring in &chain.arc.rings {
                self.ring_size[ring as usize] -= lost;
            }
        }
        self.straighten(tolerance_m);
        let kept = self.kept();
        self.around.grid.retain(|vertex| kept[vertex as usize]);
        kept
    }

    /// Arcs with one vertex left between their ends become edges where they may; one after the other,
    /// since two between the same nodes cannot both, nor all arcs of a ring.
    fn straighten(&mut self, tolerance_m: f64) {
        let around = &self.around;
        let chains = self.chains.iter_mut().enumerate();
        let mut last: Vec<(Candidate, usize)> = chains
            .filter(|(_, chain)| chain.inside == 1)
            .filter_map(|(k, chain)| {
                let entry = chain.links[0].after as usize;
                Some((chain.candidate(around, entry, tolerance_m)?, k))
            })
            .collect();
        last.sort_unstable();
        for (candidate, k) in last {
            let chain = &mut self.chains[k];
            let ends = chain.end_vertices();
            let rings = &chain.arc.rings;
            let leaves_enough = rings
                .iter()
                .all(|&ring| self.ring_size[ring as usize] > FEWEST_VERTICES);
            let entry = candidate.entry as usize;
            if leaves_enough
                && ends[0] != ends[1]
                && !self.node_edges.contains(&ends)
                && !chain.is_in_the_way(around, entry)
            {
                chain.take_out(candidate);
                for &ring in rings {
                    self.ring_size[ring as usize] -= 1;
                }
                self.node_edges.insert(ends);
            }
        }
    }
}

/// What an arc must not come to cross.
struct Surroundings<'a> {
    shared: &'a SharedBoundaries,
    /// Vertices that were there when the step began.
    grid: VertexGrid,
}

/// What is left of an arc.
struct Chain<'a> {
    arc: &'a BorderArc,
    entries: &'a [Entry],
    /// Of each entry.
    links: Vec<Link>,
    /// Entries between the ends that are still there.
    inside: u32,
    /// Largest deviation of an edge that it has had, metres.
    largest_m: f64,
}

/// An entry of a chain.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Entries before and after it that are still there; never read beyond the ends.
    before: u32,
    after: u32,
    /// Grows when its neighbours change, and what was queued before is stale.
    version: u32,
    is_there: bool,
    /// What its loss would cost, metres; infinite where that cannot be judged, not a number before it is asked for.
    deviation_m: f64,
}

impl<'a> Chain<'a> {
    fn new(arc: &'a BorderArc, arcs: &'a Arcs) -> Self {
        let entries = &arcs.entries[arc.first..arc.past];
        let link = |k: usize| Link {
            before: index_u32(k.saturating_sub(1)),
            after: index_u32(k + 1),
            version: 0,
            is_there: true,
            deviation_m: f64::NAN,
        };
        Self {
            arc,
            entries,
            links: (0..entries.len()).map(link).collect(),
            inside: index_u32(entries.len() - 2),
            largest_m: 0.0,
        }
    }

    /// The vertices of its ends, the lower first.
    fn end_vertices(&self) -> [u32; 2] {
        in_order([0, self.entries.len() - 1].map(|k| self.entries[k].vertex))
    }

    /// Takes out what the tolerance allows, but for the last entry; returns how many.
    fn thin(&mut self, around: &Surroundings<'_>, tolerance_m: f64) -> u32 {
        let before = self.inside;
        let candidates: Vec<Reverse<Candidate>> = (1..self.entries.len() - 1)
            .filter_map(|entry| self.candidate(around, entry, tolerance_m).map(Reverse))
            .collect();
        let mut queue: BinaryHeap<Reverse<Candidate>> = candidates.into();
        while self.inside > 1
            && let Some(Reverse(candidate)) = queue.pop()
        {
            let entry = candidate.entry as usize;
            let link = self.links[entry];
            let is_stale = candidate.version != link.version || !link.is_there;
            if is_stale || self.is_edge(entry) || self.is_in_the_way(around, entry) {
                continue;
            }
            for side in self.take_out(candidate) {
                self.links[side].version += 1;
                self.links[side].deviation_m = f64::NAN;
                queue.extend(self.candidate(around, side, tolerance_m).map(Reverse));
            }
        }
        before - self.inside
    }

    fn candidate(
        &mut self,
        around: &Surroundings<'_>,
        entry: usize,
        tolerance_m: f64,
    ) -> Option<Candidate> {
        if self.entries[entry].is_end
            || !self.links[entry].is_there
            || tolerance_m > self.arc.largest_tolerance_m
        {
            return None;
        }
        let [from, to] = self.beside(entry);
        let vertices = &around.shared.arcs.vertices;
        let judge = &around.shared.judge;
        let link = &mut self.links[entry];
        if link.deviation_m.is_nan() {
            let found_m = judge.deviation_m(vertices, &self.entries[from..=to]);
            link.deviation_m = found_m.unwrap_or(f64::INFINITY);
        }
        (link.deviation_m <= tolerance_m).then(|| Candidate {
            deviation_m: link.deviation_m,
            position: vertices[self.entries[entry].vertex as usize].position,
            entry: index_u32(entry),
            version: link.version,
        })
    }

    fn beside(&self, entry: usize) -> [usize; 2] {
        let link = self.links[entry];
        [link.before as usize, link.after as usize]
    }

    /// Whether the chain has an edge already between the entries beside this one: a ring of three
    /// vertices.
    fn is_edge(&self, entry: usize) -> bool {
        let [from, to] = self.beside(entry);
        let (a, c) = (&self.entries[from], &self.entries[to]);
        match (a.is_end, c.is_end) {
            (true, true) => a.vertex == c.vertex,
            (true, false) => self.entries[self.links[to].after as usize].vertex == a.vertex,
            (false, true) => self.entries[self.links[from].before as usize].vertex == c.vertex,
            (false, false) => false,
        }
    }

    /// Whether another vertex lies in the triangle that would be cut off.
    fn is_in_the_way(&self, around: &Surroundings<'_>, entry: usize) -> bool {
        let [from, to] = self.beside(entry);
        let corners = [from, entry, to].map(|k| &self.entries[k]);
        let arcs = &around.shared.arcs;
        let is_gone = |vertex: u32| {
            let own = (arcs.entry_of[vertex as usize] as usize).checked_sub(self.arc.first);
            let own = own.and_then(|entry| self.links.get(entry));
            own.is_some_and(|link| !link.is_there)
        };
        holds_vertex(arcs, around.shared.rule, corners, &around.grid, is_gone)
    }

    /// Returns the entries whose candidates this changes.
    fn take_out(&mut self, candidate: Candidate) -> [usize; 2] {
        let entry = candidate.entry as usize;
        self.largest_m = self.largest_m.max(candidate.deviation_m);
        let [from, to] = self.beside(entry);
        self.links[entry].is_there = false;
        self.links[from].after = index_u32(to);
        self.links[to].before = index_u32(from);
        self.inside -= 1;
        [from, to]
    }
}

/// Whether any vertex but its corners lies in the closed triangle, or the triangle is too wide to
/// say.
fn holds_vertex(
    arcs: &Arcs,
    rule: EdgeRule,
    corners: [&Entry; 3],
    grid: &VertexGrid,
    is_gone: impl Fn(u32) -> bool,
) -> bool {
    let at = corners.map(|entry| arcs.vertices[entry.vertex as usize]);
    if at.iter().any(|vertex| vertex.position[1].abs() == 90.0) {
        return true;
    }
    // Great ellipses have no turns: longitudes within half a turn of the first corner.
    let turned = |k: usize| {
        let [longitude, latitude] = at[k].position;
        let turn = ((longitude - at[0].position[0]) / 360.0).round();
        [longitude - 360.0 * turn, latitude]
    };
    let positions = match rule {
        EdgeRule::Planar => corners.map(|entry| entry.position),
        EdgeRule::GreatEllipse => [turned(0), turned(1), turned(2)],
    };
    let [mut low, mut high] = [positions[0]; 2];
    for position in positions {
        for axis in 0..2 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    let width_deg = high[0] - low[0];
    if width_deg > LONGEST_EDGE_DEG {
        return true;
    }
    if rule == EdgeRule::GreatEllipse {
        // A great circle rises above the straight line by Δλ² sin φ cos φ / 8 at most to second
        // order, half of Δλ²/8; twice that covers the rest up to 30°.
        let bulge_deg = width_deg * width_deg.to_radians() / 8.0;
        low[1] -= bulge_deg;
        high[1] += bulge_deg;
    }
    let ids = corners.map(|entry| entry.vertex);
    let normals = at.map(|vertex| vertex.normal);
    grid.any_in_box(low, high, &mut |vertex, position| {
        let is_other = !ids.contains(&vertex) && !is_gone(vertex);
        is_other
            && match rule {
                EdgeRule::Planar => in_triangle(positions, position),
                EdgeRule::GreatEllipse => {
                    in_spherical_triangle(normals, arcs.vertices[vertex as usize].normal)
                }
            }
    })
}

/// Whether a closed triangle, of either winding or none, holds a point. Exact.
fn in_triangle([a, b, c]: [Degrees; 3], point: Degrees) -> bool {
    let side = |from, to| orient(from, to, point);
    same_side([side(a, b), side(b, c), side(c, a)])
}

/// The same of great circles. Sides that rounding could change count as met.
fn in_spherical_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> bool {
    let side = |from: DVec3, to: DVec3| {
        let (along, beside) = (to - from, point - from);
        let volume = from.dot(along.cross(beside));
        let uncertain = 8.0 * f64::EPSILON * (along.length() + beside.length());
        if volume.abs() > uncertain {
            volume
        } else {
            0.0
        }
    };
    same_side([side(a, b), side(b, c), side(c, a)])
}

fn same_side(sides: [f64; 3]) -> bool {
    sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_triangles_hold_their_rims_and_nothing_beyond() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
        let reversed = [corners[2], corners[1], corners[0]];
        for triangle in [corners, reversed] {
            for inside in [[1.0, 1.0], [2.0, 2.0], [2.0, 0.0], [0.0, 0.0]] {
                assert!(in_triangle(triangle, inside));
            }
            for outside in [[2.0, 2.0 + 4e-16 * 4.0], [-1e-300, 1.0], [3.0, 3.0]] {
                assert!(!in_triangle(triangle, outside));
            }
            let on_sphere = |at: Degrees| crate::edge::normal(at);
            let triangle = triangle.map(on_sphere);
            assert!(in_spherical_triangle(triangle, on_sphere([1.0, 1.0])));
            assert!(in_spherical_triangle(triangle, on_sphere([2.0, 0.0])));
            assert!(!in_spherical_triangle(triangle, on_sphere([2.1, 2.1])));
        }
    }
}
