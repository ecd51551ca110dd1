// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions with fewer boundary vertices: all of a set together, so that neighbours that shared a
//! border still share it, vertex by vertex.
//!
//! Degrees in and out, deviations in metres on the body. Rings are taken apart into arcs (see
//! [`arcs`]), and vertices are taken out of each arc one at a time, always the one whose loss leaves
//! the smallest deviation (the order of Visvalingam & Whyatt, 1993, "Line generalisation by
//! repeated elimination of points", with a bound on distance in place of their area). Vertex `b`
//! between `a` and `c` may go if
//! - the edge `ac` deviates from everything it then stands for by no more than the tolerance, which
//!   is bounded in [`deviation`], not estimated;
//! - the triangle `abc` holds no other vertex, by exact predicates: no edge can then come to cross
//!   another, and none jumps over an island (Saalfeld, 1999, "Topologically consistent line
//!   simplification with the Douglas-Peucker algorithm");
//! - every ring keeps at least three vertices and no edge comes to lie on another.
//!
//! Rings of less than eight tolerances in size stay as they are: moving what is hardly to be seen makes it
//! seen. Those of less than half a tolerance are left out ([`small_rings`]).
//!
//! Regions that cross one another as they are written, and rounding at the antimeridian, escape the
//! second condition, so afterwards all edges are searched for crossings all the same; edges that
//! cross get back the vertex farthest from them until none does, or none that could be finer.

mod arcs;
mod deviation;
mod grid;
mod small_rings;

use crate::crossings::find_crossings;
use crate::edge::{Degrees, EdgeSplitter};
use crate::mesh::index_u32;
use crate::pieces::pieces_as_compared;
use crate::{EdgeRule, Ellipsoid, MeshOptions, Polygon, Region, Ring};
use arcs::{Arcs, BorderArc, Entry, RingVertices, in_order};
use deviation::{Judge, LONGEST_EDGE_DEG};
use glam::DVec3;
use grid::VertexGrid;
use rayon::prelude::*;
use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashSet};
use std::sync::Arc;

pub use small_rings::LeftOutRings;

/// Vertices that every ring keeps.
const FEWEST_VERTICES: u32 = 3;

/// Why regions cannot be simplified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplifyError {
    /// Tolerances must grow from one level to the next.
    #[error("tolerance {index} is {found} m; allowed is above {above} m and finite")]
    Tolerance {
        /// Place in the list.
        index: usize,
        /// Its value.
        found: f64,
        /// The one before it, or 0.
        above: f64,
    },
}

/// What simplifying did to a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simplification {
    /// The simplified boundary is nowhere farther than this from the original, nor the other way
    /// round, metres; at most the tolerance.
    pub deviation_m: f64,
    /// Vertices of the original rings.
    pub vertices_before: usize,
    /// Vertices of the simplified ones.
    pub vertices_after: usize,
}

/// A set of regions at one level of detail.
#[derive(Debug, Clone)]
pub struct SimplifiedRegions {
    /// Allowed deviation, metres.
    pub tolerance_m: f64,
    /// In the order of the originals; fewer vertices, and no rings that are too small.
    pub regions: Vec<Region>,
    /// Of each region.
    pub reports: Vec<Simplification>,
    /// Of each region, the rings that are too small.
    pub left_out: Vec<LeftOutRings>,
    /// Vertices put back because edges crossed without them.
    pub restored_vertices: usize,
}

impl SimplifiedRegions {
    /// Vertices of all rings.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.reports
            .iter()
            .map(|report| report.vertices_after)
            .sum()
    }
}

/// What is left of a set of regions at one level of detail; [`SharedBoundaries::finish`] makes regions of it.
#[derive(Debug, Clone)]
pub struct ThinnedLevel {
    /// Allowed deviation, metres.
    pub tolerance_m: f64,
    /// Of each region, a bound on [`Simplification::deviation_m`] if no vertex has to be put back, metres.
    pub deviation_m: Vec<f64>,
    /// Of each region, the rings that are too small.
    pub left_out: Vec<LeftOutRings>,
    /// Of each vertex, whether it stays.
    kept: Vec<bool>,
    /// Of each ring, whether it is too small.
    is_left_out: Vec<bool>,
}

/// The boundaries of a set of regions, each shared border once.
#[derive(Debug)]
pub struct SharedBoundaries {
    regions: Arc<[Region]>,
    rule: EdgeRule,
    body: Ellipsoid,
    judge: Judge,
    arcs: Arcs,
    /// Of each ring, which poles it holds.
    holds_poles: Vec<[bool; 2]>,
    /// Of each ring, its size where it may be left out.
    ring_sizes_m: Vec<f64>,
}

impl SharedBoundaries {
    /// Finds what the regions share.
    ///
    /// - cost: O(vertices)
    #[must_use]
    pub fn new(regions: impl Into<Arc<[Region]>>, body: &Ellipsoid, rule: EdgeRule) -> Self {
        let regions: Arc<[Region]> = regions.into();
        let arcs = || {
            let arcs = Arcs::new(&regions, body, rule);
            (small_rings::sizes_m(&arcs, body), arcs)
        };
        let ((ring_sizes_m, arcs), holds_poles) =
            rayon::join(arcs, || holds_poles(&regions, rule, body));
        Self {
            regions,
            rule,
            body: *body,
            judge: Judge::new(body, rule),
            ring_sizes_m,
            arcs,
            holds_poles,
        }
    }

    /// Every two regions that share a border or touch in a vertex, by index, the lower first.
    #[must_use]
    pub fn neighbours(&self) -> Vec<[usize; 2]> {
        self.arcs.neighbours()
    }

    /// The regions at each tolerance. Vertices of a level are among those of the level before,
    /// except where a crossing had to be undone.
    ///
    /// - `tolerances_m`: largest deviation of each level, growing
    ///
    /// # Errors
    /// [`SimplifyError`].
    pub fn simplify(&self, tolerances_m: &[f64]) -> Result<Vec<SimplifiedRegions>, SimplifyError> {
        let thinned = self.thin(tolerances_m)?;
        Ok(thinned.par_iter().map(|level| self.finish(level)).collect())
    }

    /// As [`SharedBoundaries::simplify`], with everything done that a coarser level needs, and nothing of what
    /// only the level itself does. So a program that draws some of the levels pays for these.
    ///
    /// # Errors
    /// [`SimplifyError`].
    pub fn thin(&self, tolerances_m: &[f64]) -> Result<Vec<ThinnedLevel>, SimplifyError> {
        check_growing(tolerances_m)?;
        let mut thinning = Thinning::new(self);
        let levels = tolerances_m.iter().map(|&tolerance_m| {
            let kept = thinning.run(tolerance_m);
            let (is_left_out, left_out) =
                small_rings::too_small(&self.ring_sizes_m, tolerance_m, &self.regions);
            let mut deviation_m = thinning.deviations_m();
            for (of_region, left_out) in deviation_m.iter_mut().zip(&left_out) {
                *of_region = of_region.max(left_out.size_m);
            }
            ThinnedLevel {
                tolerance_m,
                deviation_m,
                left_out,
                kept,
                is_left_out,
            }
        });
        Ok(levels.collect())
    }

    /// How many edges the boundaries of all regions are drawn with as they are written, by how fine their chords
    /// are to be; those cut at the antimeridian count once.
    ///
    /// - cost: O(vertices)
    #[must_use]
    pub fn edge_count(&self, options: &MeshOptions) -> usize {
        self.count_edges(|_| true, |_| true, options)
    }

    /// As [`SharedBoundaries::edge_count`], of a level.
    #[must_use]
    pub fn edge_count_of(&self, level: &ThinnedLevel, options: &MeshOptions) -> usize {
        let kept = |vertex: u32| level.kept[vertex as usize];
        self.count_edges(|ring| !level.is_left_out[ring], kept, options)
    }

    fn count_edges(
        &self,
        has_ring: impl Fn(usize) -> bool + Sync,
        has_vertex: impl Fn(u32) -> bool + Sync,
        options: &MeshOptions,
    ) -> usize {
        let of_ring = |ring: &RingVertices| {
            let mut splitter = EdgeSplitter::new(&self.body, self.rule, options);
            let written = ring.ring(&self.regions);
            let stays = ring.vertices.iter().zip(written.vertices_deg());
            let mut stays = stays.filter(|(vertex, _)| has_vertex(**vertex));
            let Some((_, first)) = stays.next() else {
                return 0;
            };
            let last = [first[0] + written.winding_deg(), first[1]];
            let whole_below_deg = splitter.whole_below_deg();
            let is_whole = |from: Degrees, to: Degrees| {
                let span_deg = (to[0] - from[0]).abs() + (to[1] - from[1]).abs();
                let is_at_pole = from[1].abs().max(to[1].abs()) == 90.0;
                span_deg <= whole_below_deg && !is_at_pole
            };
            let (mut count, mut from) = (0, *first);
            for to in stays.map(|(_, place)| *place).chain([last]) {
                count += 1;
                if !is_whole(from, to) {
                    splitter.split(from, to, &mut |_| count += 1);
                }
                from = to;
            }
            count
        };
        let rings = self.arcs.rings.par_iter().enumerate();
        let rings = rings.filter(|(place, _)| has_ring(*place));
        rings.map(|(_, ring)| of_ring(ring)).sum()
    }

    /// The regions of a level that [`SharedBoundaries::thin`] gave.
    ///
    /// - cost: O(n log n) of the vertices that are left
    #[must_use]
    pub fn finish(&self, level: &ThinnedLevel) -> SimplifiedRegions {
        let mut kept = level.kept.clone();
        let mut restored_vertices = 0;
        let mut regions = loop {
            let regions = self.rebuild(&kept);
            let restore = self.to_restore(&regions, &kept);
            if restore.is_empty() {
                break regions;
            }
            for vertex in restore {
                restored_vertices += usize::from(!kept[vertex as usize]);
                kept[vertex as usize] = true;
            }
        };
        small_rings::leave_out(&level.is_left_out, &mut regions);
        let mut reports = self.reports(&regions, &kept);
        for (report, left_out) in reports.iter_mut().zip(&level.left_out) {
            report.deviation_m = report.deviation_m.max(left_out.size_m);
        }
        SimplifiedRegions {
            tolerance_m: level.tolerance_m,
            regions,
            reports,
            left_out: level.left_out.clone(),
            restored_vertices,
        }
    }

    /// The regions with the kept vertices only.
    fn rebuild(&self, kept: &[bool]) -> Vec<Region> {
        let mut rings = self.arcs.rings.iter();
        let mut next = |original: &Ring| match rings.next() {
            Some(ring) => thinned(ring, original, kept),
            None => original.clone(),
        };
        let of_polygon = |polygon: &Polygon, next: &mut dyn FnMut(&Ring) -> Ring| Polygon {
            shell: next(&polygon.shell),
            holes: polygon.holes.iter().map(next).collect(),
        };
        self.regions
            .iter()
            .map(|region| Region {
                index: region.index,
                name: region.name.clone(),
                polygons: region
                    .polygons
                    .iter()
                    .map(|polygon| of_polygon(polygon, &mut next))
                    .collect(),
                warnings: region.warnings.clone(),
                repaired: region.repaired,
                inside: region.inside,
            })
            .collect()
    }

    /// Vertices that must come back: one of each edge that crosses another, and all of a ring that
    /// would hold other poles.
    fn to_restore(&self, regions: &[Region], kept: &[bool]) -> Vec<u32> {
        let mut restore = Vec::new();
        let mut edges: Vec<[Degrees; 2]> = Vec::new();
        // Ring, and which of its kept vertices the edge starts at.
        let mut places: Vec<(usize, usize)> = Vec::new();
        let simplified = regions.iter().flat_map(Region::rings);
        let held = holds_poles(regions, self.rule, &self.body);
        for (index, (ring, original)) in simplified.zip(&self.arcs.rings).enumerate() {
            if held[index] != self.holds_poles[index] {
                let lost = original.vertices.iter().copied();
                restore.extend(lost.filter(|&vertex| !kept[vertex as usize]));
            }
            for piece in pieces_as_compared(self.rule, ring) {
                edges.push([piece.start, piece.end]);
                places.push((index, piece.vertex));
            }
        }
        let (crossings, _) = find_crossings(self.rule, &edges, usize::MAX);
        let mut crossing: Vec<(usize, usize)> = crossings
            .iter()
            .flat_map(|(pair, _)| pair.map(|edge| places[edge]))
            .collect();
        crossing.sort_unstable();
        crossing.dedup();
        for of_ring in crossing.chunk_by(|a, b| a.0 == b.0) {
            let ring = &self.arcs.rings[of_ring[0].0];
            let written = ring.ring(&self.regions);
            let stays: Vec<usize> = (0..ring.vertices.len())
                .filter(|&k| kept[ring.vertices[k] as usize])
                .collect();
            restore.extend(
                of_ring
                    .iter()
                    .filter_map(|&(_, edge)| farthest_between(ring, written, &stays, edge)),
            );
        }
        restore
    }

    fn reports(&self, regions: &[Region], kept: &[bool]) -> Vec<Simplification> {
        let deviations: Vec<f64> = self
            .arcs
            .arcs
            .par_iter()
            .map(|arc| self.arc_deviation_m(&self.arcs.entries[arc.first..arc.past], kept))
            .collect();
        let mut reports: Vec<Simplification> = self
            .regions
            .iter()
            .zip(regions)
            .map(|(before, after)| Simplification {
                deviation_m: 0.0,
                vertices_before: before.vertex_count(),
                vertices_after: after.vertex_count(),
            })
            .collect();
        for (arc, deviation_m) in self.arcs.arcs.iter().zip(deviations) {
            for &ring in &arc.rings {
                let report = &mut reports[self.arcs.rings[ring as usize].region];
                report.deviation_m = report.deviation_m.max(deviation_m);
            }
        }
        reports
    }

    fn arc_deviation_m(&self, entries: &[Entry], kept: &[bool]) -> f64 {
        let stays: Vec<usize> = (0..entries.len())
            .filter(|&k| kept[entries[k].vertex as usize])
            .collect();
        stays
            .windows(2)
            .filter(|ends| ends[1] - ends[0] > 1)
            .filter_map(|ends| {
                let chain = &entries[ends[0]..=ends[1]];
                self.judge.deviation_m(&self.arcs.vertices, chain)
            })
            .fold(0.0, f64::max)
    }
}

fn check_growing(tolerances_m: &[f64]) -> Result<(), SimplifyError> {
    let mut above = 0.0;
    for (index, &found) in tolerances_m.iter().enumerate() {
        if !(found > above && found.is_finite()) {
            return Err(SimplifyError::Tolerance {
                index,
                found,
                above,
            });
        }
        above = found;
    }
    Ok(())
}

/// Of each ring, which poles it holds.
fn holds_poles(regions: &[Region], rule: EdgeRule, body: &Ellipsoid) -> Vec<[bool; 2]> {
    let of_polygon = |region: &Region, polygon: &Polygon| polygon.sides(rule, body, region.inside);
    let sides = regions.iter().flat_map(|region| {
        let polygons = region.polygons.iter();
        polygons.flat_map(move |polygon| of_polygon(region, polygon))
    });
    sides.map(|side| side.holds_poles).collect()
}

/// The ring with the kept vertices only.
fn thinned(ring: &RingVertices, original: &Ring, kept: &[bool]) -> Ring {
    let written = (0..ring.vertices.len()).map(|k| original.written_longitude_deg(k));
    let stays = ring.vertices.iter().zip(original.vertices_deg());
    let (vertices, written) = stays
        .zip(written)
        .filter(|((vertex, _), _)| kept[**vertex as usize])
        .map(|((_, position), written)| (*position, written))
        .unzip();
    Ring::from_checked(vertices, original.winding_deg())
        .with_written_longitudes(written)
        .after_dropped(original.file_ring(0))
}

/// Of the original vertices that edge `edge` of the simplified ring stands for, the one farthest
/// from it, in degrees, which is near enough for a choice; none where it is an original edge.
fn farthest_between(
    ring: &RingVertices,
    written: &Ring,
    stays: &[usize],
    edge: usize,
) -> Option<u32> {
    let count = ring.vertices.len();
    let from = stays[edge];
    let to = match stays.get(edge + 1) {
        Some(&to) => to,
        None => stays[0] + count,
    };
    let position = |k: usize| {
        let [longitude, latitude] = written.vertices_deg()[k % count];
        let turn = if k < count {
            0.0
        } else {
            written.winding_deg()
        };
        DVec3::new(longitude + turn, latitude, 0.0)
    };
    let along = position(to) - position(from);
    let distance = |k: usize| along.cross(position(k) - position(from)).length();
    (from + 1..to)
        .max_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        .map(|k| ring.vertices[k % count])
}

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
struct Thinning<'a> {
    shared: &'a SharedBoundaries,
    chains: Vec<Chain<'a>>,
    /// Vertices that each ring still has.
    ring_size: Vec<u32>,
    node_edges: HashSet<[u32; 2]>,
    around: Surroundings<'a>,
}

impl<'a> Thinning<'a> {
    fn new(shared: &'a SharedBoundaries) -> Self {
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
    fn deviations_m(&self) -> Vec<f64> {
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
    fn run(&mut self, tolerance_m: f64) -> Vec<bool> {
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
    let coord = |[x, y]: Degrees| robust::Coord { x, y };
    let side = |from, to| robust::orient2d(coord(from), coord(to), coord(point));
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
    use crate::parse_regions;

    const RULES: [EdgeRule; 2] = [EdgeRule::Planar, EdgeRule::GreatEllipse];

    fn regions(rings: &[&str]) -> Vec<Region> {
        let features: Vec<String> = rings
            .iter()
            .map(|ring| {
                let geometry = format!(r#"{{"type":"Polygon","coordinates":[[{ring}]]}}"#);
                format!(r#"{{"type":"Feature","geometry":{geometry}}}"#)
            })
            .collect();
        let joined = features.join(",");
        let text = format!(r#"{{"type":"FeatureCollection","features":[{joined}]}}"#);
        parse_regions(text.as_bytes(), "test").expect("valid")
    }

    fn crossing_count(rule: EdgeRule, regions: &[Region]) -> usize {
        let edges: Vec<[Degrees; 2]> = regions
            .iter()
            .flat_map(Region::rings)
            .flat_map(|ring| pieces_as_compared(rule, ring))
            .map(|piece| [piece.start, piece.end])
            .collect();
        find_crossings(rule, &edges, usize::MAX).0.len()
    }

    /// A square whose southern side goes deep round a second one that stands in its way.
    fn interlocked() -> Vec<Region> {
        regions(&[
            "[0,0],[4,0],[4,4],[6,4],[6,0],[10,0],[10,10],[0,10],[0,0]",
            "[4.5,-2],[5.5,-2],[5.5,3],[4.5,3],[4.5,-2]",
        ])
    }

    /// A level of these vertices, with all rings.
    fn finished(shared: &SharedBoundaries, tolerance_m: f64, kept: Vec<bool>) -> SimplifiedRegions {
        shared.finish(&ThinnedLevel {
            tolerance_m,
            deviation_m: vec![tolerance_m; shared.regions.len()],
            left_out: vec![LeftOutRings::default(); shared.regions.len()],
            kept,
            is_left_out: vec![false; shared.arcs.rings.len()],
        })
    }

    /// All vertices but those at these positions.
    fn kept_without(shared: &SharedBoundaries, without: &[Degrees]) -> Vec<bool> {
        let vertices = shared.arcs.vertices.iter();
        vertices
            .map(|vertex| !without.contains(&vertex.position))
            .collect()
    }

    #[test]
    fn edges_that_came_to_cross_get_vertices_back_until_none_does() {
        let original = interlocked();
        for rule in RULES {
            let shared = SharedBoundaries::new(&original[..], &Ellipsoid::WGS84, rule);
            let kept = kept_without(&shared, &[[4.0, 4.0], [6.0, 4.0]]);
            assert!(crossing_count(rule, &shared.rebuild(&kept)) > 0);
            let level = finished(&shared, 1e6, kept);
            assert_eq!(crossing_count(rule, &level.regions), 0);
            assert_eq!(level.restored_vertices, 2);
            assert_eq!(level.regions[0].polygons, original[0].polygons);
        }
    }

    #[test]
    fn what_crosses_nothing_gets_nothing_back() {
        let original = interlocked();
        for rule in RULES {
            let shared = SharedBoundaries::new(&original[..], &Ellipsoid::WGS84, rule);
            let kept = kept_without(&shared, &[[0.0, 10.0]]);
            let level = finished(&shared, 1e6, kept);
            assert_eq!((level.restored_vertices, level.vertex_count()), (0, 11));
        }
    }

    #[test]
    fn regions_that_cross_as_written_are_left_as_they_are() {
        let original = regions(&[
            "[0,0],[6,0],[6,6],[0,6],[0,0]",
            "[3,3],[9,3],[9,9],[3,9],[3,3]",
        ]);
        for rule in RULES {
            let shared = SharedBoundaries::new(&original[..], &Ellipsoid::WGS84, rule);
            let level = finished(&shared, 1.0, kept_without(&shared, &[]));
            assert_eq!(crossing_count(rule, &level.regions), 2);
            assert_eq!(level.vertex_count(), 8);
        }
    }

    #[test]
    fn a_ring_round_the_axis_never_changes_its_pole() {
        // Its northern side is the smaller one by one vertex.
        let original = regions(&["[-180,-1],[-90,-1],[0,-1],[45,9],[90,-1],[180,-1]"]);
        let rule = EdgeRule::Planar;
        let shared = SharedBoundaries::new(&original[..], &Ellipsoid::WGS84, rule);
        assert_eq!(shared.holds_poles, [[false, true]]);
        let level = finished(&shared, 1e7, kept_without(&shared, &[[45.0, 9.0]]));
        assert_eq!(level.restored_vertices, 1);
        let without = shared.rebuild(&kept_without(&shared, &[[45.0, 9.0]]));
        let held = holds_poles(&without, rule, &Ellipsoid::WGS84);
        assert_eq!(held, [[true, false]]);
        // Twin: one that does not go round may.
        let other = regions(&["[0,-1],[45,9],[90,-1],[60,-2],[0,-1]"]);
        let shared = SharedBoundaries::new(&other[..], &Ellipsoid::WGS84, rule);
        let level = finished(&shared, 1e7, kept_without(&shared, &[[45.0, 9.0]]));
        assert_eq!(level.restored_vertices, 0);
    }

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
