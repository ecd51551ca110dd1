// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings taken apart into arcs: the runs of vertices that every ring passes in the same way.
//!
//! Vertices are the same when they are the same place on the body, to the bit. A *node* is a vertex
//! with other than two neighbours over all rings together, such as the end of a shared border or a
//! place where rings touch; one on the antimeridian or at a pole, where files cut their rings; an
//! end of an edge too wide to be judged; and one vertex of each ring that has no other. Between
//! nodes every ring that passes passes the same vertices, so what is decided once for the arc is
//! decided for all of them.

use crate::edge::{Degrees, normal};
use crate::pieces::ANTIMERIDIAN_SNAP_DEG;
use crate::{EdgeRule, Ellipsoid, Region, Ring};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use terrafill_planar::index_u32;

/// Planar edges that span more longitude than this keep both ends, degrees: from there on two
/// spellings of one place can mean two edges.
const WIDE_EDGE_DEG: f64 = 90.0;
/// Great ellipses between normals whose cosine is less keep both ends: 60°.
const WIDE_ARC_COSINE: f64 = 0.5;
/// A ring of fewer tolerances in size than this stays as it is, or is left out whole
/// ([`super::small_rings`]). A lake or island of less than a pixel that moved could appear where there was nothing
/// to be seen. No boundary would be near that a comparison could put it down to. A level is drawn where its
/// tolerance is between an eighth of a pixel and half a pixel, so that this many are a pixel or more.
const SMALLEST_SIZE: f64 = 8.0;
const NONE: u32 = u32::MAX;

/// A place that rings have a vertex at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    /// Longitude above −180, at most 180.
    pub(super) position: Degrees,
    pub(super) normal: DVec3,
    /// Of longitude and of latitude here.
    pub(super) metres_per_deg: [f64; 2],
    pub(super) is_node: bool,
}

/// A vertex of an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) vertex: u32,
    pub(super) is_end: bool,
    /// Longitude as the ring writes it, going on past ±180.
    pub(super) position: Degrees,
    /// Of longitude and of latitude here.
    pub(super) metres_per_deg: [f64; 2],
}

/// A run of vertices between two nodes with at least one vertex between them.
#[derive(Debug, Clone)]
pub(super) struct BorderArc {
    /// Range of [`Arcs::entries`].
    pub(super) first: usize,
    pub(super) past: usize,
    /// Rings that pass it, once for each time they do.
    pub(super) rings: Vec<u32>,
    /// Largest tolerance for which it may change, metres.
    pub(super) largest_tolerance_m: f64,
}

/// A ring by its vertices.
#[derive(Debug)]
pub(super) struct RingVertices {
    pub(super) region: usize,
    polygon: usize,
    /// The shell is 0.
    place: usize,
    /// In file order.
    pub(super) vertices: Vec<u32>,
}

impl RingVertices {
    /// The ring itself.
    ///
    /// - `regions`: those that were taken apart
    pub(super) fn ring<'a>(&self, regions: &'a [Region]) -> &'a Ring {
        let polygon = &regions[self.region].polygons[self.polygon];
        match self.place.checked_sub(1) {
            None => &polygon.shell,
            Some(hole) => &polygon.holes[hole],
        }
    }
}

/// All rings of a set of regions, taken apart.
#[derive(Debug)]
pub(super) struct Arcs {
    pub(super) vertices: Vec<Vertex>,
    /// In the order of the regions.
    pub(super) rings: Vec<RingVertices>,
    pub(super) arcs: Vec<BorderArc>,
    /// Arc by arc.
    pub(super) entries: Vec<Entry>,
    /// Of each vertex between the ends of an arc, its entry; of others, no entry's number.
    pub(super) entry_of: Vec<u32>,
    /// Edges from node to node, lower vertex first.
    pub(super) node_edges: HashSet<[u32; 2]>,
}

impl Arcs {
    pub(super) fn new(regions: &[Region], body: &Ellipsoid, rule: EdgeRule) -> Self {
        let mut places = Places::with_room_for(regions.iter().map(Region::vertex_count).sum());
        let mut rings = Vec::new();
        for (region, found) in regions.iter().enumerate() {
            for (polygon, found) in found.polygons.iter().enumerate() {
                let of_polygon = std::iter::once(&found.shell).chain(&found.holes);
                rings.extend(of_polygon.enumerate().map(|(place, ring)| {
                    RingVertices {
                        region,
                        polygon,
                        place,
                        vertices: ring
                            .vertices_deg()
                            .iter()
                            .map(|position| places.vertex(*position))
                            .collect(),
                    }
                }));
            }
        }
        let found = places.positions.into_par_iter();
        let mut vertices: Vec<Vertex> = found.map(|at| Vertex::new(body, at)).collect();
        mark_nodes(rule, &mut vertices, regions, &rings);
        let mut arcs = Self {
            vertices,
            rings,
            arcs: Vec::new(),
            entries: Vec::new(),
            entry_of: Vec::new(),
            node_edges: HashSet::new(),
        };
        arcs.collect(regions, body);
        arcs
    }

    fn collect(&mut self, regions: &[Region], body: &Ellipsoid) {
        let rings = std::mem::take(&mut self.rings);
        let mut arc_of_vertex = vec![NONE; self.vertices.len()];
        for (index, ring) in rings.iter().enumerate() {
            let count = ring.vertices.len();
            let is_node = |k: usize| self.vertices[ring.vertices[k % count] as usize].is_node;
            let size_m = self.size_m(body, ring);
            let Some(start) = (0..count).find(|&k| is_node(k)) else {
                continue;
            };
            let mut from = start;
            while from < start + count {
                let mut to = from + 1;
                while !is_node(to) {
                    to += 1;
                }
                if to - from > 1 {
                    let inside = ring.vertices[(from + 1) % count] as usize;
                    if arc_of_vertex[inside] == NONE {
                        let arc = index_u32(self.arcs.len());
                        for k in from + 1..to {
                            arc_of_vertex[ring.vertices[k % count] as usize] = arc;
                        }
                        let entries = entries_of(
                            &self.vertices,
                            (ring.ring(regions), &ring.vertices),
                            from..=to,
                        );
                        self.arcs.push(BorderArc {
                            first: self.entries.len(),
                            past: self.entries.len() + entries.len(),
                            rings: Vec::new(),
                            largest_tolerance_m: f64::INFINITY,
                        });
                        self.entries.extend(entries);
                    }
                    let arc = &mut self.arcs[arc_of_vertex[inside] as usize];
                    arc.rings.push(index_u32(index));
                    arc.largest_tolerance_m = arc.largest_tolerance_m.min(size_m / SMALLEST_SIZE);
                } else {
                    let ends = [from, to].map(|k| ring.vertices[k % count]);
                    self.node_edges.insert(in_order(ends));
                }
                from = to;
            }
        }
        self.rings = rings;
        self.entry_of = vec![NONE; self.vertices.len()];
        for (k, entry) in self.entries.iter().enumerate().filter(|(_, of)| !of.is_end) {
            self.entry_of[entry.vertex as usize] = index_u32(k);
        }
    }

    /// Diagonal of a box around the ring's normals, in metres where the body is most curved.
    pub(super) fn size_m(&self, body: &Ellipsoid, ring: &RingVertices) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &vertex in &ring.vertices {
            let normal = self.vertices[vertex as usize].normal;
            low = low.min(normal);
            high = high.max(normal);
        }
        (high - low).length() * body.smallest_curvature_radius_m()
    }

    /// Every two regions that have a vertex in common, the lower index first. Borders that are
    /// shared end in such a vertex.
    pub(super) fn neighbours(&self) -> Vec<[usize; 2]> {
        let mut at_nodes: Vec<(u32, usize)> = Vec::new();
        for ring in &self.rings {
            let nodes = ring.vertices.iter().copied();
            let nodes = nodes.filter(|&vertex| self.vertices[vertex as usize].is_node);
            at_nodes.extend(nodes.map(|vertex| (vertex, ring.region)));
        }
        at_nodes.sort_unstable();
        at_nodes.dedup();
        let mut pairs = Vec::new();
        for at_node in at_nodes.chunk_by(|a, b| a.0 == b.0) {
            for (k, (_, region)) in at_node.iter().enumerate() {
                pairs.extend(at_node[..k].iter().map(|(_, lower)| [*lower, *region]));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}

pub(super) fn in_order([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Numbers places in the order in which they are seen.
struct Places {
    positions: Vec<Degrees>,
    by_bits: HashMap<[u64; 2], u32, foldhash::fast::FixedState>,
}

impl Places {
    fn with_room_for(count: usize) -> Self {
        Self {
            positions: Vec::with_capacity(count),
            by_bits: HashMap::with_capacity_and_hasher(count, Default::default()),
        }
    }

    fn vertex(&mut self, position: Degrees) -> u32 {
        let position = on_body(position);
        let next = index_u32(self.positions.len());
        let found = *self
            .by_bits
            .entry(position.map(f64::to_bits))
            .or_insert(next);
        if found == next {
            self.positions.push(position);
        }
        found
    }
}

impl Vertex {
    fn new(body: &Ellipsoid, position: Degrees) -> Self {
        Self {
            position,
            normal: normal(position),
            metres_per_deg: metres_per_deg(body, position[1]),
            is_node: position[1].abs() == 90.0 || position[0] == 180.0,
        }
    }
}

/// The same place in the same bits, whichever turn it was written in.
fn on_body([longitude, latitude]: Degrees) -> Degrees {
    if latitude.abs() == 90.0 {
        return [0.0, latitude];
    }
    let turned = longitude - 360.0 * (longitude / 360.0).round();
    let is_antimeridian = turned.abs() >= 180.0 - ANTIMERIDIAN_SNAP_DEG;
    // Adding zero turns −0 into 0.
    [
        if is_antimeridian { 180.0 } else { turned + 0.0 },
        latitude + 0.0,
    ]
}

fn mark_nodes(rule: EdgeRule, vertices: &mut [Vertex], regions: &[Region], rings: &[RingVertices]) {
    let mut beside = vec![[NONE; 2]; vertices.len()];
    for ring in rings {
        for (k, (start, end)) in ring.ring(regions).edges_deg().enumerate() {
            let a = ring.vertices[k] as usize;
            let b = ring.vertices[(k + 1) % ring.vertices.len()] as usize;
            let is_wide = match rule {
                EdgeRule::Planar => (end[0] - start[0]).abs() > WIDE_EDGE_DEG,
                EdgeRule::GreatEllipse => {
                    vertices[a].normal.dot(vertices[b].normal) < WIDE_ARC_COSINE
                }
            };
            for [at, other] in [[a, b], [b, a]] {
                let is_third = note_neighbour(&mut beside[at], index_u32(other));
                vertices[at].is_node |= a == b || is_wide || is_third;
            }
        }
    }
    for (vertex, beside) in vertices.iter_mut().zip(&beside) {
        vertex.is_node |= beside[1] == NONE;
    }
    for ring in rings {
        let of_ring = || ring.vertices.iter().copied();
        if of_ring().any(|vertex| vertices[vertex as usize].is_node) {
            continue;
        }
        // The same one for every ring that runs here.
        let anchor = of_ring().min_by(|a, b| {
            let [a, b] = [a, b].map(|vertex| vertices[*vertex as usize].position);
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
        });
        if let Some(anchor) = anchor {
            vertices[anchor as usize].is_node = true;
        }
    }
}

/// Whether `other` is a third neighbour.
fn note_neighbour(beside: &mut [u32; 2], other: u32) -> bool {
    if beside.contains(&other) {
        return false;
    }
    match beside.iter_mut().find(|place| **place == NONE) {
        Some(place) => {
            *place = other;
            false
        }
        None => true,
    }
}

/// The arc over these vertices of the ring, from the end that comes first by its position.
fn entries_of(
    vertices: &[Vertex],
    (ring, of_ring): (&Ring, &[u32]),
    range: std::ops::RangeInclusive<usize>,
) -> Vec<Entry> {
    let written = ring.vertices_deg();
    let (first, last) = (*range.start(), *range.end());
    let mut entries: Vec<Entry> = range
        .map(|k| {
            let [longitude, latitude] = written[k % written.len()];
            let turn = if k < written.len() {
                0.0
            } else {
                ring.winding_deg()
            };
            let vertex = of_ring[k % written.len()];
            Entry {
                vertex,
                is_end: k == first || k == last,
                position: [longitude + turn, latitude],
                metres_per_deg: vertices[vertex as usize].metres_per_deg,
            }
        })
        .collect();
    let key = |entry: &Entry| vertices[entry.vertex as usize].position;
    let forward = entries.iter().map(key);
    let backward = entries.iter().rev().map(key);
    if forward.partial_cmp(backward) == Some(std::cmp::Ordering::Greater) {
        entries.reverse();
    }
    entries
}

/// Metres per degree of longitude (along the parallel) and of latitude (along the meridian).
pub(super) fn metres_per_deg(body: &Ellipsoid, latitude_deg: f64) -> [f64; 2] {
    let latitude_rad = latitude_deg.to_radians();
    let [prime_vertical, meridian] = body.curvature_radii_m(latitude_rad);
    [prime_vertical * latitude_rad.cos(), meridian].map(f64::to_radians)
}
