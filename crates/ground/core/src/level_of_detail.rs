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
mod shared;
mod small_rings;
mod thinning;

use crate::crossings::find_crossings;
use crate::edge::{Degrees, EdgeSplitter};
use crate::pieces::pieces_as_compared;
use crate::{EdgeRule, Ellipsoid, MeshOptions, Polygon, Region, Ring};
use arcs::{Arcs, Entry, RingVertices};
use deviation::Judge;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use thinning::Thinning;

pub use shared::SharedBoundaries;
pub use small_rings::LeftOutRings;

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

/// A set of regions at one level of detail.
#[derive(Debug, Clone)]
pub struct SimplifiedRegions {
    /// Allowed deviation, metres.
    pub tolerance_m: f64,
    /// In the order of the originals; fewer vertices, and no rings that are too small.
    pub regions: Vec<Region>,
    /// Of each region: the simplified boundary is nowhere farther than this from the original, nor the
    /// other way round, metres; at most the tolerance.
    pub deviation_m: Vec<f64>,
    /// Of each region, the rings that are too small.
    pub left_out: Vec<LeftOutRings>,
    /// Vertices put back because edges crossed without them.
    pub restored_vertices: usize,
}

/// What is left of a set of regions at one level of detail; [`SharedBoundaries::finish`] makes regions of it.
#[derive(Debug, Clone)]
pub struct ThinnedLevel {
    /// Allowed deviation, metres.
    pub tolerance_m: f64,
    /// Of each region, a bound on [`SimplifiedRegions::deviation_m`] if no vertex has to be put back, metres.
    pub deviation_m: Vec<f64>,
    /// Of each region, the rings that are too small.
    pub left_out: Vec<LeftOutRings>,
    /// Of each vertex, whether it stays.
    kept: Vec<bool>,
    /// Of each ring, whether it is too small.
    is_left_out: Vec<bool>,
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

    /// The level at each tolerance, with everything done that a coarser level needs; [`SharedBoundaries::finish`]
    /// does what only the level itself needs, so that a program pays for the levels that it draws. Vertices of a
    /// level are among those of the level before, except where a crossing has to be undone.
    ///
    /// - `tolerances_m`: largest deviation of each level, growing
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
        let mut deviation_m = self.deviations_m(&kept);
        for (deviation_m, left_out) in deviation_m.iter_mut().zip(&level.left_out) {
            *deviation_m = deviation_m.max(left_out.size_m);
        }
        SimplifiedRegions {
            tolerance_m: level.tolerance_m,
            regions,
            deviation_m,
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

    /// Of each region: how far its arcs are off without the vertices that are not kept.
    fn deviations_m(&self, kept: &[bool]) -> Vec<f64> {
        let deviations: Vec<f64> = self
            .arcs
            .arcs
            .par_iter()
            .map(|arc| self.arc_deviation_m(&self.arcs.entries[arc.first..arc.past], kept))
            .collect();
        let mut of_regions = vec![0.0_f64; self.regions.len()];
        for (arc, deviation_m) in self.arcs.arcs.iter().zip(deviations) {
            for &ring in &arc.rings {
                let of_region = &mut of_regions[self.arcs.rings[ring as usize].region];
                *of_region = of_region.max(deviation_m);
            }
        }
        of_regions
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

    fn vertex_count(level: &SimplifiedRegions) -> usize {
        level.regions.iter().map(Region::vertex_count).sum()
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
            assert_eq!((level.restored_vertices, vertex_count(&level)), (0, 11));
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
            assert_eq!(vertex_count(&level), 8);
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
        // Negative control: one that does not go round may.
        let other = regions(&["[0,-1],[45,9],[90,-1],[60,-2],[0,-1]"]);
        let shared = SharedBoundaries::new(&other[..], &Ellipsoid::WGS84, rule);
        let level = finished(&shared, 1e7, kept_without(&shared, &[[45.0, 9.0]]));
        assert_eq!(level.restored_vertices, 0);
    }
}
