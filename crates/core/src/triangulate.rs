// SPDX-License-Identifier: MIT OR Apache-2.0
//! Closed edges in the plane of longitude and latitude → triangles of what they enclose.
//!
//! Degrees. Constrained Delaunay by `spade` (sweep circle bulk loading, exact predicates), inside
//! and outside by the even-odd rule, then interior points so that no cap facet is much longer than
//! the step asked for. Longitudes are scaled by the power of two nearest to the cosine of the
//! middle latitude: triangles come out well shaped on the body, and not one bit of a coordinate
//! changes, so predicates remain exact for the numbers of the file.

use crate::crossings::{
    self, CrossingPlaces, crossing_places, find_crossings, great_ellipse_crossing, split_outline,
};
use crate::edge::{Degrees, arc_rad};
use crate::outline::OutlineEdge;
use crate::{EdgeRule, MeshOptions};
use spade::handles::FixedVertexHandle;
use spade::{
    ConstrainedDelaunayTriangulation, Intersection, LineIntersectionIterator, Point2,
    PositionInTriangulation, Triangulation,
};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// The data of an undirected edge says whether an odd number of the file's edges runs along it.
type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>, (), bool>;

/// Interior edges longer than this many steps are halved.
const LONGEST_INTERIOR_EDGE_STEPS: f64 = 1.5;
/// Interior edges that span more longitude than this are halved: beyond it, close to a pole, a
/// triangle that is small on the body can still be turned over.
pub(crate) const WIDEST_INTERIOR_EDGE_DEG: f64 = 45.0;
/// Widest spacing of lattice points, degrees of longitude: twelve round a pole.
const WIDEST_LATTICE_STEP_DEG: f64 = 30.0;
/// Lattice points closer than this to the boundary, in steps, are left out: they make slivers.
const LATTICE_CLEARANCE_STEPS: f64 = 0.5;
/// Rounds of halving: the plane's width divided by 2¹⁶ is far below any step allowed.
const MOST_ROUNDS: usize = 16;
/// Coordinates below this are 0, since the exact predicates must not underflow. A billionth of an
/// atom, in degrees of the Earth.
const SMALLEST_COORDINATE_DEG: f64 = 1e-25;

/// Triangles of one group of edges.
pub(crate) struct GroupMesh {
    pub(crate) vertices: Vec<Degrees>,
    /// Counter-clockwise in longitude and latitude.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Directed edges with the inside on the left.
    pub(crate) boundary: Vec<[u32; 2]>,
}

/// Why a group could not be triangulated.
pub(crate) enum TriangulateError {
    /// Edges cross other than at a common vertex.
    Crossings {
        /// In order of their place in the file; at least one.
        found: Vec<CrossingPlaces>,
        /// Whether these are all.
        complete: bool,
    },
    /// The triangulation refused; a fault in this program rather than in the file.
    Refused(String),
}

/// Triangulates what `edges`, a closed chain modulo 2, enclose.
///
/// The plane sees straight lines for great-ellipse arcs, within the boundary tolerance of them;
/// where two of those lines cross although the arcs do not, the crossing becomes a vertex.
pub(crate) fn triangulate(
    edges: Vec<OutlineEdge>,
    rule: EdgeRule,
    options: &MeshOptions,
) -> Result<GroupMesh, TriangulateError> {
    let mut group = load_without_false_crossings(edges, rule)?;
    let mut inside = group.inside_faces();
    if group.reaches_beyond(options.cap_step_deg) {
        group.insert_lattice(&inside, options.cap_step_deg)?;
        inside = group.inside_faces();
        for _ in 0..MOST_ROUNDS {
            if !group.halve_long_edges(&inside, options.cap_step_deg)? {
                break;
            }
            inside = group.inside_faces();
        }
    }
    group.extract(&inside)
}

/// Crossings of one group that are looked for: a list that long helps nobody, and a ring that
/// crosses itself everywhere has as many as the square of its edges.
const MOST_CROSSINGS: usize = 10_000;

fn load_without_false_crossings(
    mut edges: Vec<OutlineEdge>,
    rule: EdgeRule,
) -> Result<Group, TriangulateError> {
    for round in 0..=crossings::MOST_ROUNDS {
        if let Some(group) = Group::load(&edges)? {
            return Ok(group);
        }
        let ends: Vec<[Degrees; 2]> = edges.iter().map(|edge| [edge.start, edge.end]).collect();
        let (found, complete) = find_crossings(EdgeRule::Planar, &ends, MOST_CROSSINGS);
        if found.is_empty() {
            return Err(TriangulateError::Refused(
                "a crossing edge crosses no edge".to_owned(),
            ));
        }
        let refused: Vec<_> = match rule {
            EdgeRule::Planar => found.clone(),
            EdgeRule::GreatEllipse => {
                let arcs = found.iter().filter_map(|&([a, b], _)| {
                    great_ellipse_crossing(ends[a], ends[b]).map(|at| ([a, b], at))
                });
                arcs.collect()
            }
        };
        let refused = match refused.is_empty() && round == crossings::MOST_ROUNDS {
            true => &found,
            false => &refused,
        };
        if !refused.is_empty() {
            return Err(TriangulateError::Crossings {
                found: crossing_places(&edges, refused),
                complete,
            });
        }
        edges = split_outline(&edges, &found);
    }
    Err(TriangulateError::Refused(
        "crossings of chords could not be resolved".to_owned(),
    ))
}

struct Group {
    cdt: Cdt,
    /// Power of two that longitudes are multiplied by.
    scale: f64,
    /// Degrees, by index of the vertex in the triangulation.
    vertices: Vec<Degrees>,
    /// `[west, south, east, north]`.
    bounds: [f64; 4],
}

impl Group {
    /// `None` where edges cross.
    fn load(edges: &[OutlineEdge]) -> Result<Option<Self>, TriangulateError> {
        let mut vertices: Vec<Degrees> = Vec::with_capacity(edges.len());
        let mut index_of: HashMap<[u64; 2], u32, BuildHasherDefault<PositionHasher>> =
            HashMap::with_capacity_and_hasher(edges.len(), BuildHasherDefault::default());
        let mut index = |position: Degrees| {
            let position = position.map(without_underflow);
            let key = position.map(f64::to_bits);
            *index_of.entry(key).or_insert_with(|| {
                vertices.push(position);
                index_u32(vertices.len() - 1)
            })
        };
        let ends: Vec<[u32; 2]> = edges
            .iter()
            .map(|edge| [index(edge.start), index(edge.end)])
            .collect();
        let kept = odd_edges(&ends);

        let mut bounds = [180.0_f64, 90.0_f64, -180.0_f64, -90.0_f64];
        for [longitude, latitude] in &vertices {
            bounds[0] = bounds[0].min(*longitude);
            bounds[1] = bounds[1].min(*latitude);
            bounds[2] = bounds[2].max(*longitude);
            bounds[3] = bounds[3].max(*latitude);
        }
        let cosine = (0.5 * (bounds[1] + bounds[3])).to_radians().cos();
        let scale = cosine.log2().round().clamp(-12.0, 0.0).exp2();
        let points = vertices
            .iter()
            .map(|[longitude, latitude]| Point2::new(longitude * scale, *latitude))
            .collect();
        let constraints = kept
            .iter()
            .map(|[a, b]| [*a as usize, *b as usize])
            .collect();
        let mut edges_cross = false;
        let cdt = Cdt::try_bulk_load_cdt(points, constraints, |_| edges_cross = true)
            .map_err(|error| TriangulateError::Refused(error.to_string()))?;
        if edges_cross {
            return Ok(None);
        }
        let mut group = Self {
            cdt,
            scale,
            vertices,
            bounds,
        };
        group.mark_odd_edges(&kept);
        Ok(Some(group))
    }

    /// Marks what an odd number of edges runs along. An edge that passes exactly through a vertex
    /// has become several, and several edges may share one of those.
    fn mark_odd_edges(&mut self, kept: &[[u32; 2]]) {
        let mut marked = vec![false; self.cdt.num_undirected_edges()];
        for ends in kept {
            let [from, to] = ends.map(|i| FixedVertexHandle::from_index(i as usize));
            if let Some(edge) = self.cdt.get_edge_from_neighbors(from, to) {
                marked[edge.as_undirected().fix().index()] ^= true;
                continue;
            }
            for crossed in LineIntersectionIterator::new_from_handles(&self.cdt, from, to) {
                if let Intersection::EdgeOverlap(edge) = crossed {
                    marked[edge.as_undirected().fix().index()] ^= true;
                }
            }
        }
        let handles: Vec<_> = self.cdt.fixed_undirected_edges().collect();
        for handle in handles {
            *self.cdt.undirected_edge_data_mut(handle).data_mut() = marked[handle.index()];
        }
    }

    /// By index of the face: whether an odd number of edges separates it from the outside.
    fn inside_faces(&self) -> Vec<bool> {
        let mut inside = vec![false; self.cdt.num_all_faces()];
        let mut seen = vec![false; self.cdt.num_all_faces()];
        let mut waiting = Vec::new();
        seen[self.cdt.outer_face().index()] = true;
        for edge in self.cdt.convex_hull() {
            // Hull edges have the outer face on one side; the other is where the walk starts.
            for side in [edge, edge.rev()] {
                let Some(face) = side.face().as_inner() else {
                    continue;
                };
                if !seen[face.index()] {
                    seen[face.index()] = true;
                    inside[face.index()] = *side.as_undirected().data().data();
                    waiting.push(face.fix());
                }
            }
        }
        while let Some(face) = waiting.pop() {
            let face = self.cdt.face(face);
            for edge in face.adjacent_edges() {
                let Some(neighbour) = edge.rev().face().as_inner() else {
                    continue;
                };
                if !seen[neighbour.index()] {
                    seen[neighbour.index()] = true;
                    let odd = *edge.as_undirected().data().data();
                    inside[neighbour.index()] = inside[face.index()] ^ odd;
                    waiting.push(neighbour.fix());
                }
            }
        }
        inside
    }

    /// Whether anything can be longer than the step; most islands are not.
    fn reaches_beyond(&self, step_deg: f64) -> bool {
        let [west, south, east, north] = self.bounds;
        (east - west).hypot(north - south) > step_deg
    }

    fn degrees(&self, point: Point2<f64>) -> Degrees {
        [point.x / self.scale, point.y]
    }

    fn insert(&mut self, position: Degrees) -> Result<(), TriangulateError> {
        let position = position.map(without_underflow);
        let point = Point2::new(position[0] * self.scale, position[1]);
        let handle = self
            .cdt
            .insert(point)
            .map_err(|error| TriangulateError::Refused(error.to_string()))?;
        if handle.index() == self.vertices.len() {
            self.vertices.push(position);
        }
        Ok(())
    }

    /// Points on parallels that are multiples of the step apart, about one step apart on each.
    fn insert_lattice(&mut self, inside: &[bool], step_deg: f64) -> Result<(), TriangulateError> {
        let [west, south, east, north] = self.bounds;
        let mut chosen = Vec::new();
        let mut row = (south / step_deg).ceil();
        while row * step_deg <= north.min(90.0 - 1e-9) {
            let latitude = row * step_deg;
            row += 1.0;
            let cosine = latitude.to_radians().cos();
            let wanted = (step_deg / cosine).clamp(step_deg, WIDEST_LATTICE_STEP_DEG);
            let spacing = 360.0 / (360.0 / wanted).ceil();
            let mut column = ((west + 180.0) / spacing).ceil();
            while column * spacing - 180.0 <= east {
                let longitude = column * spacing - 180.0;
                column += 1.0;
                let clearance = LATTICE_CLEARANCE_STEPS * step_deg;
                if self.is_clear([longitude, latitude], cosine, clearance, inside) {
                    chosen.push([longitude, latitude]);
                }
            }
        }
        for position in chosen {
            self.insert(position)?;
        }
        Ok(())
    }

    /// Whether a place is inside and far enough from the corners and marked edges of its face.
    fn is_clear(
        &self,
        position: Degrees,
        cosine: f64,
        clearance_deg: f64,
        inside: &[bool],
    ) -> bool {
        let point = Point2::new(position[0] * self.scale, position[1]);
        let PositionInTriangulation::OnFace(face) = self.cdt.locate(point) else {
            return false;
        };
        if !inside[face.index()] {
            return false;
        }
        let local = |point: Point2<f64>| {
            let [longitude, latitude] = self.degrees(point);
            Point2::new((longitude - position[0]) * cosine, latitude - position[1])
        };
        let origin = Point2::new(0.0, 0.0);
        self.cdt.face(face).adjacent_edges().iter().all(|edge| {
            let [from, to] = edge.positions().map(local);
            let near = if *edge.as_undirected().data().data() {
                distance_to_segment(from, to)
            } else {
                from.distance_2(origin).sqrt()
            };
            near >= clearance_deg
        })
    }

    /// Halves every interior edge that is too long; whether there was one.
    fn halve_long_edges(
        &mut self,
        inside: &[bool],
        step_deg: f64,
    ) -> Result<bool, TriangulateError> {
        let longest_deg = LONGEST_INTERIOR_EDGE_STEPS * step_deg;
        let mut middles = Vec::new();
        for edge in self.cdt.undirected_edges() {
            let directed = edge.as_directed();
            let face = directed.face().index();
            if *edge.data().data() || !inside[face] || edge.is_constraint_edge() {
                continue;
            }
            let [a, b] = directed.positions().map(|point| self.degrees(point));
            let (width, height) = ((b[0] - a[0]).abs(), b[1] - a[1]);
            if width.hypot(height) <= longest_deg {
                continue;
            }
            let long = arc_rad(a, b).to_degrees() > longest_deg;
            if long || width > WIDEST_INTERIOR_EDGE_DEG {
                middles.push([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            }
        }
        for middle in &middles {
            self.insert(*middle)?;
        }
        Ok(!middles.is_empty())
    }

    fn extract(self, inside: &[bool]) -> Result<GroupMesh, TriangulateError> {
        let mut new_index = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for face in self.cdt.inner_faces() {
            if !inside[face.index()] {
                continue;
            }
            triangles.push(face.vertices().map(|vertex| {
                let old = vertex.index();
                if new_index[old] == u32::MAX {
                    new_index[old] = index_u32(vertices.len());
                    vertices.push(self.vertices[old]);
                }
                new_index[old]
            }));
        }
        let mut boundary = Vec::new();
        for edge in self.cdt.undirected_edges() {
            if !*edge.data().data() {
                continue;
            }
            let directed = edge.as_directed();
            let left = inside[directed.face().index()];
            if left == inside[directed.rev().face().index()] {
                let message = "an edge has the same side twice".to_owned();
                return Err(TriangulateError::Refused(message));
            }
            let directed = if left { directed } else { directed.rev() };
            boundary.push([directed.from(), directed.to()].map(|end| new_index[end.index()]));
        }
        Ok(GroupMesh {
            vertices,
            triangles,
            boundary,
        })
    }
}

/// Edges that occur an odd number of times, whichever way they run.
fn odd_edges(ends: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut sorted: Vec<[u32; 2]> = ends
        .iter()
        .filter(|[a, b]| a != b)
        .map(|&[a, b]| [a.min(b), a.max(b)])
        .collect();
    sorted.sort_unstable();
    sorted
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() % 2 == 1)
        .map(|same| same[0])
        .collect()
}

fn without_underflow(coordinate: f64) -> f64 {
    if coordinate.abs() < SMALLEST_COORDINATE_DEG {
        0.0
    } else {
        coordinate
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "four billion vertices need 64 GiB for their positions alone"
)]
pub(crate) fn index_u32(index: usize) -> u32 {
    debug_assert!(index < u32::MAX as usize);
    index as u32
}

fn distance_to_segment(from: Point2<f64>, to: Point2<f64>) -> f64 {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let along = -(from.x * dx + from.y * dy) / (dx * dx + dy * dy);
    let along = along.clamp(0.0, 1.0);
    (from.x + along * dx).hypot(from.y + along * dy)
}

/// Hash of two coordinates' bits: the default hasher's protection against crafted keys costs more
/// than the whole lookup, and a file crafted against this one is slow, not wrong.
#[derive(Default)]
struct PositionHasher(u64);

impl Hasher for PositionHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, value: u64) {
        // Multiplication by 2⁶⁴ divided by the golden ratio, the rotation between the two words.
        self.0 = (self.0.rotate_left(29) ^ value).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_usize(&mut self, value: usize) {
        self.write_u64(value as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EdgePlace;

    fn closed(vertices: &[Degrees]) -> Vec<OutlineEdge> {
        let next = vertices.iter().cycle().skip(1);
        vertices
            .iter()
            .zip(next)
            .enumerate()
            .map(|(vertex, (start, end))| OutlineEdge {
                start: *start,
                end: *end,
                place: EdgePlace {
                    vertex,
                    ..EdgePlace::default()
                },
            })
            .collect()
    }

    fn area(mesh: &GroupMesh) -> f64 {
        let twice: f64 = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
                (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
            })
            .sum();
        twice / 2.0
    }

    fn mesh(edges: &[OutlineEdge], cap_step_deg: f64) -> GroupMesh {
        let options = MeshOptions {
            cap_step_deg,
            ..MeshOptions::default()
        };
        match triangulate(edges.to_vec(), EdgeRule::Planar, &options) {
            Ok(mesh) => mesh,
            Err(TriangulateError::Crossings { found, .. }) => panic!("crossings at {found:?}"),
            Err(TriangulateError::Refused(message)) => panic!("{message}"),
        }
    }

    #[test]
    fn edges_that_overlap_are_counted_modulo_two() {
        // A square whose right side is also the left side of half a square: the shared half cancels.
        let mut edges = closed(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        edges.extend(closed(&[[2.0, 0.0], [4.0, 0.0], [4.0, 1.0], [2.0, 1.0]]));
        let mesh = mesh(&edges, 180.0);
        assert_eq!(area(&mesh), 6.0);
        assert_eq!(mesh.boundary.len(), 7);
    }

    #[test]
    fn a_spike_there_and_back_leaves_no_boundary() {
        let spike = [
            [0.0, 0.0],
            [2.0, 0.0],
            [5.0, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [0.0, 2.0],
        ];
        let mesh = mesh(&closed(&spike), 180.0);
        assert_eq!(area(&mesh), 4.0);
        assert_eq!(mesh.boundary.len(), 4);
    }

    #[test]
    fn lattice_and_halving_keep_the_area_and_bound_the_edges() {
        let mut square = Vec::new();
        for (from, to) in [
            ([0, 0], [1, 0]),
            ([1, 0], [1, 1]),
            ([1, 1], [0, 1]),
            ([0, 1], [0, 0]),
        ] {
            for k in 0..10 {
                square.push([0, 1].map(|i| f64::from(2 * (from[i] * (10 - k) + to[i] * k))));
            }
        }
        let edges = closed(&square);
        let coarse = mesh(&edges, 180.0);
        let fine = mesh(&edges, 2.0);
        assert_eq!(area(&coarse), 400.0);
        assert!((area(&fine) - 400.0).abs() < 1e-10);
        assert_eq!((coarse.boundary.len(), fine.boundary.len()), (40, 40));
        let longest = |mesh: &GroupMesh| {
            let sides = mesh
                .triangles
                .iter()
                .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
            sides
                .map(|side| side.map(|i| mesh.vertices[i as usize]))
                .map(|[a, b]| arc_rad(a, b).to_degrees())
                .fold(0.0, f64::max)
        };
        assert!(longest(&fine) <= 3.0 && longest(&coarse) > 10.0);
    }

    #[test]
    fn a_crossing_is_placed_and_a_touch_is_not_a_crossing() {
        let bow_tie = closed(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
        match triangulate(bow_tie, EdgeRule::Planar, &MeshOptions::default()) {
            Err(TriangulateError::Crossings { found, complete }) => {
                assert_eq!((found.len(), complete), (1, true));
                assert_eq!((found[0].first.vertex, found[0].second.vertex), (0, 2));
                assert_eq!(found[0].at, [1.0, 1.0]);
            }
            _ => panic!("a bow-tie crosses itself"),
        }
        // Through a common vertex instead: both lobes, by even-odd.
        let touching = [
            [0.0, 0.0],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        assert_eq!(area(&mesh(&closed(&touching), 180.0)), 2.0);
    }
}
