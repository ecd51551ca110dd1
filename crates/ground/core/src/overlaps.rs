// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of a region that lie over one another, and holes outside of what they are holes of.
//!
//! Degrees. Rings that do not cross can still be nested in a way that says two things at once: a
//! part inside another, a hole outside its shell. Even-odd fills them, but hardly as meant, so they
//! are refused unless a repair was asked for. So are two holes that are one or overlap in part: even-odd
//! would fill them. A hole inside a hole of its own polygon is filled as an island, with a warning.
//!
//! Whether there is any is decided by areas: what the rings enclose one by one, shells less holes,
//! must be what they enclose together. That costs a multiplication an edge, by the chords that the
//! triangulation sees, and is exact up to the rounding of a sum. Only where the two differ is it
//! looked for where: in a triangulation of all edges, from triangle to triangle, counting in which
//! rings each of them lies.

use crate::edge::area::Sum;
use crate::edge::{Degrees, along_pole};
use crate::pieces::{OutlineEdge, bounds};
use crate::snap::snap_rounded;
use crate::triangulate::GroupMesh;
use crate::{EdgePlace, EdgeRule};
use std::collections::BTreeMap;
use terrafill_planar::delaunay::{Delaunay, FRAME_CORNERS};
use terrafill_planar::index_u32;
use terrafill_planar::intersection::{orient, without_underflow};

/// What two rings cover that they should not cover both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OverlapPlace {
    /// Two shells, a shell and a hole, or two holes; vertex 0.
    pub(crate) rings: [EdgePlace; 2],
    /// A place in the midst of it.
    pub(crate) at: Degrees,
}

/// Rings of a group that lie over one another.
#[derive(Debug, Default)]
pub(crate) struct Overlaps {
    /// What says two things at once.
    pub(crate) refused: Vec<OverlapPlace>,
    /// A hole that lies in another, and that other one; vertex 0.
    pub(crate) nested: Vec<[EdgePlace; 2]>,
}

/// What the rings of a group enclose, one by one, square degrees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RingAreas {
    sum: f64,
    /// Sizes of all terms of the sum.
    scale: f64,
}

/// Polygon and ring.
type RingKey = (usize, usize);

fn key(edge: &OutlineEdge) -> RingKey {
    (edge.place.polygon, edge.place.ring)
}

impl RingAreas {
    /// `None` for a single ring, which lies over nothing.
    pub(crate) fn of(edges: &[OutlineEdge]) -> Option<Self> {
        let first = edges.first()?;
        if edges.iter().all(|edge| key(edge) == key(first)) {
            return None;
        }
        let (mut sum, mut scale) = (Sum::default(), 0.0);
        for ring in edges.chunk_by(|a, b| key(a) == key(b)) {
            let reference = pole_held(ring).unwrap_or(ring[0].start[1]);
            let (area, terms) =
                signed_area(ring.iter().map(|edge| [edge.start, edge.end]), reference);
            sum += if ring[0].place.ring == 0 {
                area.abs()
            } else {
                -area.abs()
            };
            scale += terms;
        }
        Some(Self {
            sum: sum.value(),
            scale,
        })
    }

    /// Whether the rings together enclose another area than they do one by one.
    pub(crate) fn differ_from(&self, mesh: &GroupMesh) -> bool {
        let reference = mesh.vertices.first().map_or(0.0, |vertex| vertex[1]);
        let boundary = mesh
            .boundary
            .iter()
            .map(|ends| ends.map(|i| mesh.vertices[i as usize]));
        let (together, terms) = signed_area(boundary, reference);
        // Every term is rounded three times; the sums keep what they round away.
        (self.sum - together.abs()).abs() > 1e-14 * (self.scale + terms)
    }
}

/// The pole whose whole parallel belongs to a ring, latitude; it lies at the end.
fn pole_held(ring: &[OutlineEdge]) -> Option<f64> {
    ring.iter()
        .rev()
        .find_map(|edge| along_pole(edge.start, edge.end))
}

/// `−∮ (φ − φ₀) dλ` and the sum of its terms' sizes.
fn signed_area(edges: impl Iterator<Item = [Degrees; 2]>, reference: f64) -> (f64, f64) {
    let (mut area, mut scale) = (Sum::default(), 0.0);
    for [start, end] in edges {
        let height = 0.5 * ((start[1] - reference) + (end[1] - reference));
        let term = height * (end[0] - start[0]);
        area += -term;
        scale += term.abs();
    }
    (area.value(), scale)
}

/// Places where a polygon lies over another or a hole over what is outside its shell, one for each pair
/// of rings. Those that rounding or the chords of arcs within `tolerance_deg` can feign are left out.
/// `None` for a fault of this program.
pub(crate) fn find_overlaps(
    edges: Vec<OutlineEdge>,
    rule: EdgeRule,
    tolerance_deg: f64,
) -> Option<Overlaps> {
    if let Some(cover) = Cover::new(&edges) {
        return Some(cover.overlaps(&edges, rule, tolerance_deg));
    }
    // Chords cross where arcs do not, and what was split may cross by a rounding.
    let edges = snap_rounded(rule, &[edges]).swap_remove(0);
    let cover = Cover::new(&edges)?;
    Some(cover.overlaps(&edges, rule, tolerance_deg))
}

/// Border of what any polygon covers, each with the covered side on its left: a polygon covers its shell
/// less all of its holes. `None` for a fault of this program.
///
/// - `edges`: of a group that was closed along the antimeridian by [`crate::Repair::Union`]
pub(crate) fn union_border(edges: Vec<OutlineEdge>, rule: EdgeRule) -> Option<Vec<OutlineEdge>> {
    if let Some(cover) = Cover::new(&edges) {
        return Some(cover.union_border(&edges));
    }
    let edges = snap_rounded(rule, &[edges]).swap_remove(0);
    let cover = Cover::new(&edges)?;
    Some(cover.union_border(&edges))
}

/// How many edges of the file are edges of another polygon as well; the antimeridian, where cuts
/// are closed, and the poles left out.
pub(crate) fn shared_edges(edges: &[OutlineEdge]) -> usize {
    let bits = |place: Degrees| place.map(|x| (x + 0.0).to_bits());
    let mut ends: Vec<([[u64; 2]; 2], EdgePlace)> = edges
        .iter()
        .filter(|edge| {
            let along_cut = edge.start[0] == edge.end[0] && edge.start[0].abs() == 180.0;
            !along_cut && along_pole(edge.start, edge.end).is_none()
        })
        .map(|edge| {
            let (a, b) = (bits(edge.start), bits(edge.end));
            ([a.min(b), a.max(b)], edge.place)
        })
        .filter(|([a, b], _)| a != b)
        .collect();
    ends.sort_unstable();
    let mut places: Vec<EdgePlace> = ends
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0 && pair[0].1.polygon != pair[1].1.polygon)
        .map(|pair| pair[0].1)
        .collect();
    // An edge that was split is still one.
    places.sort_unstable();
    places.dedup();
    places.len()
}

/// All edges of a group, triangulated.
struct Cover {
    mesh: Delaunay,
    positions: Vec<Degrees>,
    /// Rings along each edge of the triangulation, by its ends, the lower first.
    rings: BTreeMap<[u32; 2], Vec<RingKey>>,
}

impl Cover {
    /// `None` where edges cross.
    fn new(edges: &[OutlineEdge]) -> Option<Self> {
        let mut mesh = Delaunay::new(bounds(edges), edges.len());
        let mut positions = vec![[0.0; 2]; FRAME_CORNERS];
        let mut ends = Vec::with_capacity(edges.len());
        for edge in edges {
            let mut pair = [0; 2];
            for (index, position) in pair.iter_mut().zip([edge.start, edge.end]) {
                // As the triangulation of the region does, for the sake of the predicates.
                let position = position.map(without_underflow);
                *index = mesh.insert(position).ok()?;
                if *index as usize == positions.len() {
                    positions.push(position);
                }
            }
            ends.push(pair);
        }
        for [from, to] in &ends {
            if from != to {
                mesh.constrain(*from, *to).ok()?;
            }
        }
        let mut cover = Self {
            mesh,
            positions,
            rings: BTreeMap::new(),
        };
        for (edge, [from, to]) in edges.iter().zip(ends) {
            cover.add_ring(key(edge), from, to)?;
        }
        Some(cover)
    }

    /// Notes the ring along every edge of the triangulation on the line between two vertices.
    fn add_ring(&mut self, ring: RingKey, mut from: u32, to: u32) -> Option<()> {
        while from != to {
            let next = match self.mesh.edge_between(from, to) {
                Ok(_) => to,
                Err(_) => self.next_on_line(from, to)?,
            };
            let along = self
                .rings
                .entry([from.min(next), from.max(next)])
                .or_default();
            match along.iter().position(|other| *other == ring) {
                // Twice along the same edge is not at all.
                Some(i) => drop(along.swap_remove(i)),
                None => along.push(ring),
            }
            from = next;
        }
        Some(())
    }

    fn next_on_line(&self, from: u32, to: u32) -> Option<u32> {
        let [a, b] = [from, to].map(|i| self.positions[i as usize]);
        let mut edges = self.mesh.edges_at(from);
        edges.find_map(|(triangle, i)| {
            let ends = self.mesh.ends(triangle, i);
            let other = if ends[0] == from { ends[1] } else { ends[0] };
            if !self.mesh.is_constraint(triangle, i) {
                return None;
            }
            let c = self.positions[other as usize];
            let ahead = (c[0] - a[0]) * (b[0] - a[0]) + (c[1] - a[1]) * (b[1] - a[1]) > 0.0;
            (ahead && orient(a, b, c) == 0.0).then_some(other)
        })
    }

    /// Rings that hold each triangle within the strip, sorted; `None` for those at the frame.
    ///
    /// A ring that is cut at ±180 is open there, so what lies beyond must not be gone through. Each
    /// patch of triangles that hang together without it is settled by one of them.
    fn rings_of_triangles(&self, edges: &[OutlineEdge]) -> Vec<Option<Vec<RingKey>>> {
        let count = self.mesh.triangle_count();
        let mut held: Vec<Option<Vec<RingKey>>> = vec![None; count];
        let at_frame = |triangle: u32| {
            let corners = self.mesh.corners(triangle);
            corners.iter().any(|i| (*i as usize) < FRAME_CORNERS)
        };
        for start in 0..index_u32(count) {
            if at_frame(start) || held[start as usize].is_some() {
                continue;
            }
            held[start as usize] = Some(Vec::new());
            let mut patch = vec![start];
            let mut next = 0;
            while let Some(&triangle) = patch.get(next) {
                next += 1;
                for i in 0..3 {
                    let across = self.mesh.neighbour(triangle, i);
                    let Some(across) = across.filter(|t| !at_frame(*t)) else {
                        continue;
                    };
                    if held[across as usize].is_none() {
                        let [a, b] = self.mesh.ends(triangle, i);
                        let crossed = self.rings.get(&[a.min(b), a.max(b)]);
                        let here = held[triangle as usize].clone().unwrap_or_default();
                        let there = toggled(here, crossed.map_or(&[], Vec::as_slice));
                        held[across as usize] = Some(there);
                        patch.push(across);
                    }
                }
            }
            let largest = patch
                .iter()
                .copied()
                .max_by(|a, b| self.area(*a).total_cmp(&self.area(*b)));
            let Some(largest) = largest else { continue };
            let known = rings_round(self.middle(largest), edges);
            let wrong = toggled(held[largest as usize].clone().unwrap_or_default(), &known);
            for triangle in patch {
                let found = held[triangle as usize].take().unwrap_or_default();
                held[triangle as usize] = Some(toggled(found, &wrong));
            }
        }
        held
    }

    fn overlaps(&self, edges: &[OutlineEdge], rule: EdgeRule, tolerance_deg: f64) -> Overlaps {
        let goes_round = rings_along_whole_poles(edges);
        let mut found = CommonAreas::new();
        let mut holes = CommonAreas::new();
        let mut of_holes: BTreeMap<RingKey, f64> = BTreeMap::new();
        for (triangle, held) in (0..).zip(self.rings_of_triangles(edges)) {
            let held = held.unwrap_or_default();
            let area = self.area(triangle) * self.middle(triangle)[1].to_radians().cos();
            if let Some(pair) = overlapping(&held, &goes_round) {
                add_common(&mut found, pair, area, triangle);
            }
            let plain = held
                .iter()
                .filter(|ring| ring.1 > 0 && !is_round(ring.0, &goes_round));
            let plain: Vec<RingKey> = plain.copied().collect();
            for (index, ring) in plain.iter().enumerate() {
                *of_holes.entry(*ring).or_default() += area;
                for other in plain[index + 1..].iter().filter(|other| other.0 == ring.0) {
                    add_common(&mut holes, [*ring, *other], area, triangle);
                }
            }
        }
        let allowed = |pair: &[RingKey; 2]| -> f64 {
            let of_pair = edges.iter().filter(|edge| pair.contains(&key(edge)));
            of_pair
                .map(|edge| feigned_area(rule, tolerance_deg, edge))
                .sum()
        };
        let place = |(polygon, ring): RingKey| EdgePlace {
            polygon,
            ring,
            vertex: 0,
        };
        let mut overlaps = Overlaps::default();
        for (pair, common) in found {
            if common.area > allowed(&pair) {
                overlaps.refused.push(OverlapPlace {
                    rings: pair.map(place),
                    at: self.middle(common.largest),
                });
            }
        }
        for (pair, common) in holes {
            let allowed = allowed(&pair);
            if common.area <= allowed {
                continue;
            }
            let is_within = pair.map(|ring| of_holes[&ring] - common.area <= allowed);
            match is_within {
                [true, false] => overlaps.nested.push([pair[0], pair[1]].map(place)),
                [false, true] => overlaps.nested.push([pair[1], pair[0]].map(place)),
                _ => overlaps.refused.push(OverlapPlace {
                    rings: pair.map(place),
                    at: self.middle(common.largest),
                }),
            }
        }
        overlaps
    }

    /// See [`union_border`].
    fn union_border(&self, edges: &[OutlineEdge]) -> Vec<OutlineEdge> {
        let goes_round = rings_along_whole_poles(edges);
        let covered: Vec<bool> = self
            .rings_of_triangles(edges)
            .into_iter()
            .map(|held| held.is_some_and(|held| is_covered(&held, &goes_round)))
            .collect();
        let mut border = Vec::new();
        for (triangle, _) in (0..).zip(&covered).filter(|(_, covered)| **covered) {
            for i in 0..3 {
                let across = self.mesh.neighbour(triangle, i);
                if across.is_some_and(|across| covered[across as usize]) {
                    continue;
                }
                let [a, b] = self.mesh.ends(triangle, i);
                let along = self.rings.get(&[a.min(b), a.max(b)]);
                let place = along.and_then(|rings| rings.first());
                border.push(OutlineEdge {
                    start: self.positions[a as usize],
                    end: self.positions[b as usize],
                    place: place.map_or(edges[0].place, |(polygon, ring)| EdgePlace {
                        polygon: *polygon,
                        ring: *ring,
                        vertex: 0,
                    }),
                });
            }
        }
        border
    }

    fn corners(&self, triangle: u32) -> [Degrees; 3] {
        let corners = self.mesh.corners(triangle);
        corners.map(|i| self.positions[i as usize])
    }

    fn middle(&self, triangle: u32) -> Degrees {
        let [a, b, c] = self.corners(triangle);
        [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0)
    }

    fn area(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corners(triangle);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }
}

/// What two rings cover both.
struct CommonArea {
    /// Square degrees of the equator.
    area: f64,
    /// Of its largest triangle.
    largest_area: f64,
    largest: u32,
}

type CommonAreas = BTreeMap<[RingKey; 2], CommonArea>;

fn add_common(areas: &mut CommonAreas, pair: [RingKey; 2], area: f64, triangle: u32) {
    let common = areas.entry(pair).or_insert(CommonArea {
        area: 0.0,
        largest_area: 0.0,
        largest: triangle,
    });
    common.area += area;
    if area > common.largest_area {
        (common.largest_area, common.largest) = (area, triangle);
    }
}

/// Whether any ring of a polygon goes round the axis.
fn is_round(polygon: usize, goes_round: &[RingKey]) -> bool {
    goes_round.iter().any(|ring| ring.0 == polygon)
}

/// Whether any polygon covers a place that these rings hold.
///
/// Of rings round the axis the larger may be shell or hole, so of a polygon that has some the parity
/// counts.
fn is_covered(held: &[RingKey], goes_round: &[RingKey]) -> bool {
    held.chunk_by(|a, b| a.0 == b.0).any(|rings| {
        if is_round(rings[0].0, goes_round) {
            rings.len() % 2 == 1
        } else {
            rings.len() == 1 && rings[0].1 == 0
        }
    })
}

/// What an edge's bow (at most a twentieth of its length) or rounding can feign of an overlap,
/// square degrees of the equator.
fn feigned_area(rule: EdgeRule, tolerance_deg: f64, edge: &OutlineEdge) -> f64 {
    let (x, y) = (edge.end[0] - edge.start[0], edge.end[1] - edge.start[1]);
    let cosine = edge.start[1]
        .to_radians()
        .cos()
        .max(edge.end[1].to_radians().cos());
    let length = (x * cosine).hypot(y);
    let width = match rule {
        EdgeRule::Planar => 0.0,
        EdgeRule::GreatEllipse => tolerance_deg.min(0.05 * length),
    };
    // A vertex that splits an edge lies within a last bit of 180 of it.
    length * (width + 1e-13)
}

/// Both or neither: rings in one of the lists only, sorted.
fn toggled(mut rings: Vec<RingKey>, others: &[RingKey]) -> Vec<RingKey> {
    for other in others {
        match rings.binary_search(other) {
            Ok(i) => drop(rings.remove(i)),
            Err(i) => rings.insert(i, *other),
        }
    }
    rings
}

/// Rings that an odd number of edges lie north of the point of.
fn rings_round(point: Degrees, edges: &[OutlineEdge]) -> Vec<RingKey> {
    let mut rings = Vec::new();
    for edge in edges {
        let (west, east) = if edge.start[0] < edge.end[0] {
            (edge.start, edge.end)
        } else {
            (edge.end, edge.start)
        };
        let spans = west[0] <= point[0] && point[0] < east[0];
        if spans && orient(west, east, point) < 0.0 {
            rings = toggled(rings, &[key(edge)]);
        }
    }
    rings
}

/// Rings that run along the whole parallel of a pole, sorted. One that runs along a part of it comes up
/// to the pole and goes back.
fn rings_along_whole_poles(edges: &[OutlineEdge]) -> Vec<RingKey> {
    let mut along: BTreeMap<(RingKey, bool), f64> = BTreeMap::new();
    for edge in edges {
        if let Some(pole) = along_pole(edge.start, edge.end) {
            let length = along.entry((key(edge), pole > 0.0)).or_default();
            *length += (edge.end[0] - edge.start[0]).abs();
        }
    }
    // Parts of a whole turn add up to it but for their rounding.
    let whole = along
        .into_iter()
        .filter(|(_, length)| *length > 360.0 - 1e-9);
    let mut rings: Vec<RingKey> = whole.map(|((ring, _), _)| ring).collect();
    rings.dedup();
    rings
}

/// Two of the rings that hold a place which say two things of it.
///
/// Of rings round the axis the larger may be shell or hole, so of those of a polygon only the parity
/// counts. Any other hole has to lie in one of them if the shell is one.
fn overlapping(held: &[RingKey], goes_round: &[RingKey]) -> Option<[RingKey; 2]> {
    let mut inside: Option<RingKey> = None;
    for rings in held.chunk_by(|a, b| a.0 == b.0) {
        let polygon = rings[0].0;
        let round = is_round(polygon, goes_round);
        let is_inside = match rings {
            _ if round => {
                let goes_round = |ring: &RingKey| goes_round.binary_search(ring).is_ok();
                let outside = goes_round(&(polygon, 0)) && !rings.iter().any(goes_round);
                if outside {
                    return Some([(polygon, 0), rings[0]]);
                }
                rings.len() % 2 == 1
            }
            // What lies in a hole of a hole is inside again.
            [shell, holes @ ..] if shell.1 == 0 => holes.len() % 2 == 0,
            [hole, ..] => return Some([(polygon, 0), *hole]),
            [] => false,
        };
        if is_inside {
            match inside {
                Some(other) => return Some([other, rings[0]]),
                None => inside = Some(rings[0]),
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_keeps_what_each_addition_rounds_away() {
        let terms = || std::iter::once(1e16).chain([1.0; 1000]).chain([-1e16]);
        let mut sum = Sum::default();
        terms().for_each(|term| sum += term);
        assert_eq!(sum.value(), 1000.0);
        // The plain sum does not.
        assert_eq!(terms().sum::<f64>(), 0.0);
    }
}
