// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings that cross themselves or one another: finding the crossings, and making them vertices.
//!
//! Degrees for planar edges, unit normals for great ellipses. A crossing that is a vertex of both
//! edges is no crossing any more but a touch, which the even-odd rule fills without ambiguity.
//! Real files need this: at 1:110m a vertex of Sudan's outline that was meant to lie on another of
//! its edges lies 5.7e-14° (6 nm) beyond it, and by exact arithmetic that is a crossing.
//!
//! Candidates come from a sweep over the edges' boxes: O(n log n + pairs whose boxes overlap).

use crate::edge::{Degrees, normal};
use crate::outline::OutlineEdge;
use crate::{EdgeRule, Region, Ring};
use glam::DVec3;

/// Rounds after which the search gives up: a crossing is rounded to the nearest number, which can
/// bend an edge over another one close by, but only by the last bit.
pub(crate) const MOST_ROUNDS: usize = 8;

impl Region {
    /// Makes a vertex of every place where two edges cross, so that the region can be meshed and is
    /// filled by the even-odd rule; returns how many there were and notes them in
    /// [`Region::warnings`].
    ///
    /// Planar edges are compared as written: a crossing between a ring written past ±180 and one
    /// written within is not found, and meshing refuses it.
    pub fn split_at_crossings(&mut self, rule: EdgeRule) -> usize {
        let mut total = 0;
        for _ in 0..MOST_ROUNDS {
            let found = self.split_once(rule);
            total += found;
            if found == 0 {
                break;
            }
        }
        if total > 0 {
            let plural = if total == 1 { "" } else { "s" };
            self.warnings.push(format!(
                "{total} crossing{plural} of edges: filled by the even-odd rule"
            ));
        }
        total
    }

    fn split_once(&mut self, rule: EdgeRule) -> usize {
        let mut edges: Vec<BoxedEdge> = Vec::with_capacity(self.vertex_count());
        let mut lengths = Vec::new();
        for (ring_index, ring) in self.rings().enumerate() {
            lengths.push(ring.vertices_deg().len());
            for (vertex, (start, end)) in ring.edges_deg().enumerate() {
                edges.push(BoxedEdge::new(rule, [ring_index, vertex], start, end));
            }
        }
        let crossings = find_crossings(rule, &mut edges);
        if crossings.is_empty() {
            return 0;
        }
        let mut inserted: Vec<Vec<Insertion>> = lengths.iter().map(|_| Vec::new()).collect();
        for (pair, at) in &crossings {
            for edge in pair {
                let [ring, vertex] = edges[*edge].place;
                let along = distance(rule, edges[*edge].start, *at);
                inserted[ring].push((vertex, along, *at));
            }
        }
        let rings = self
            .polygons
            .iter_mut()
            .flat_map(|polygon| std::iter::once(&mut polygon.shell).chain(&mut polygon.holes));
        for (ring, mut insertions) in rings.zip(inserted) {
            if !insertions.is_empty() {
                insertions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
                *ring = with_insertions(ring, &insertions);
            }
        }
        crossings.len()
    }
}

/// Vertex that the edge starts at, distance from there, position.
type Insertion = (usize, f64, Degrees);

fn with_insertions(ring: &Ring, insertions: &[Insertion]) -> Ring {
    let mut waiting = insertions.iter().peekable();
    let mut vertices = Vec::with_capacity(ring.vertices_deg().len() + insertions.len());
    for (vertex, start) in ring.vertices_deg().iter().enumerate() {
        vertices.push(*start);
        while let Some((_, _, at)) = waiting.next_if(|insertion| insertion.0 == vertex) {
            vertices.push(*at);
        }
    }
    // Rounding may put a crossing on the end of its edge.
    vertices.dedup();
    let winding_deg = ring.winding_deg();
    while vertices.len() > 1
        && vertices[vertices.len() - 1] == [vertices[0][0] + winding_deg, vertices[0][1]]
    {
        vertices.pop();
    }
    Ring::from_checked(vertices, winding_deg)
}

struct BoxedEdge {
    start: Degrees,
    end: Degrees,
    low: DVec3,
    high: DVec3,
    /// Ring of the region and vertex of the ring.
    place: [usize; 2],
}

impl BoxedEdge {
    fn new(rule: EdgeRule, place: [usize; 2], start: Degrees, end: Degrees) -> Self {
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
        Self {
            start,
            end,
            low: a.min(b) - bulge,
            high: a.max(b) + bulge,
            place,
        }
    }
}

/// Makes vertices of the crossings of straight edges.
///
/// Rounding can leave new ones, so the caller tries again until there are none.
pub(crate) fn split_outline(edges: &[OutlineEdge]) -> SplitOutline {
    let mut boxed: Vec<BoxedEdge> = edges
        .iter()
        .enumerate()
        .map(|(index, edge)| BoxedEdge::new(EdgeRule::Planar, [0, index], edge.start, edge.end))
        .collect();
    let crossings = find_crossings(EdgeRule::Planar, &mut boxed);
    let mut insertions: Vec<Insertion> = Vec::with_capacity(2 * crossings.len());
    let mut pairs = Vec::with_capacity(crossings.len());
    for (pair, at) in crossings {
        let pair = pair.map(|sorted| boxed[sorted].place[1]);
        for index in pair {
            let along = distance(EdgeRule::Planar, edges[index].start, at);
            insertions.push((index, along, at));
        }
        pairs.push(pair);
    }
    insertions.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
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
    SplitOutline {
        edges: split,
        pairs,
    }
}

/// Edges split where they crossed.
pub(crate) struct SplitOutline {
    pub(crate) edges: Vec<OutlineEdge>,
    /// Which crossed, by index before splitting.
    pub(crate) pairs: Vec<[usize; 2]>,
}

/// Pairs of edges, by index after sorting, and where they cross.
fn find_crossings(rule: EdgeRule, edges: &mut [BoxedEdge]) -> Vec<([usize; 2], Degrees)> {
    edges.sort_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.place.cmp(&b.place)));
    let mut open: Vec<usize> = Vec::new();
    let mut found = Vec::new();
    for (index, edge) in edges.iter().enumerate() {
        open.retain(|&other| edges[other].high.x >= edge.low.x);
        for &other in &open {
            let earlier = &edges[other];
            let boxes_overlap = earlier.low.y <= edge.high.y
                && edge.low.y <= earlier.high.y
                && earlier.low.z <= edge.high.z
                && edge.low.z <= earlier.high.z;
            if !boxes_overlap {
                continue;
            }
            let a = [earlier.start, earlier.end];
            let b = [edge.start, edge.end];
            let crossing = match rule {
                EdgeRule::Planar => planar_crossing(a, b),
                EdgeRule::GreatEllipse => great_ellipse_crossing(a, b),
            };
            found.extend(crossing.map(|at| ([other, index], at)));
        }
        open.push(index);
    }
    found
}

/// Where two straight edges cross, each strictly between its ends. The decision is exact.
pub(crate) fn planar_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    let coord = |[x, y]: Degrees| robust::Coord { x, y };
    let side = |[p, q]: [Degrees; 2], r| robust::orient2d(coord(p), coord(q), coord(r));
    let (a0, a1) = (side(b, a[0]), side(b, a[1]));
    let (b0, b1) = (side(a, b[0]), side(a, b[1]));
    (opposite(a0, a1) && opposite(b0, b1)).then(|| {
        let along = a0 / (a0 - a1);
        [0, 1].map(|i| a[0][i] + (a[1][i] - a[0][i]) * along)
    })
}

/// Where two arcs cross, each strictly between its ends and by more than rounding can feign.
pub(crate) fn great_ellipse_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    let (a, b) = (a.map(normal), b.map(normal));
    let apart = opposite(certain_side(b, a[0]), certain_side(b, a[1]))
        && opposite(certain_side(a, b[0]), certain_side(a, b[1]));
    if !apart {
        return None;
    }
    let line = a[0].cross(a[1] - a[0]).cross(b[0].cross(b[1] - b[0]));
    let point = if line.dot(a[0] + a[1]) < 0.0 {
        -line
    } else {
        line
    };
    // The planes also meet on the far side of the body.
    (point.dot(b[0] + b[1]) > 0.0).then(|| {
        [
            point.y.atan2(point.x).to_degrees(),
            point.z.atan2(point.x.hypot(point.y)).to_degrees(),
        ]
    })
}

/// Side of the plane through the centre and an arc that a point lies on: positive to the left, 0
/// where moving the three unit vectors by their rounding could change the answer.
fn certain_side([from, to]: [DVec3; 2], point: DVec3) -> f64 {
    // Differences before products: the products of the unit vectors themselves would lose what
    // tells neighbours apart.
    let (along, beside) = (to - from, point - from);
    let volume = from.cross(along).dot(beside);
    let uncertain = 8.0 * f64::EPSILON * (along.length() + beside.length());
    if volume.abs() > uncertain {
        volume
    } else {
        0.0
    }
}

fn opposite(a: f64, b: f64) -> bool {
    a > 0.0 && b < 0.0 || a < 0.0 && b > 0.0
}

fn distance(rule: EdgeRule, a: Degrees, b: Degrees) -> f64 {
    match rule {
        EdgeRule::Planar => (b[0] - a[0]).hypot(b[1] - a[1]),
        EdgeRule::GreatEllipse => (normal(b) - normal(a)).length(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Ellipsoid, MeshError, MeshOptions, Polygon, RegionMesh};

    fn region(rings: &[&[Degrees]]) -> Region {
        let polygons = rings
            .iter()
            .map(|ring| Polygon {
                shell: Ring::from_checked(ring.to_vec(), 0.0),
                holes: Vec::new(),
            })
            .collect();
        Region {
            index: 0,
            name: "test".to_owned(),
            polygons,
            warnings: Vec::new(),
        }
    }

    fn build(region: &Region, rule: EdgeRule) -> Result<RegionMesh, MeshError> {
        let body = Ellipsoid::WGS84;
        let mesh = RegionMesh::build(region, &body, rule, &MeshOptions::default())?;
        assert_eq!(mesh.check_invariants(&body), Ok(()));
        Ok(mesh)
    }

    #[test]
    fn a_pentagram_is_refused_and_repaired_to_its_five_points() {
        let star: Vec<Degrees> = (0..5)
            .map(|k| {
                let angle = std::f64::consts::TAU * f64::from(2 * k) / 5.0;
                [10.0 + angle.cos(), 5.0 + angle.sin()]
            })
            .collect();
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&star]);
            assert!(matches!(
                build(&region, rule),
                Err(MeshError::SelfCrossing { .. })
            ));
            assert_eq!(region.split_at_crossings(rule), 5);
            assert_eq!(
                region.warnings,
                ["5 crossings of edges: filled by the even-odd rule"]
            );
            let mesh = build(&region, rule).expect("repaired");
            // Even-odd leaves the pentagon in the middle empty: one loop of ten would fill it.
            assert_eq!(mesh.triangle_count(), 5, "{}", rule.name());
            assert_eq!(mesh.boundary_edge_count(), 15);
        }
    }

    #[test]
    fn polygons_that_overlap_are_filled_where_an_odd_number_of_them_is() {
        let a = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let b = a.map(|[x, y]| [x + 1.0, y + 1.0]);
        let mut region = region(&[&a, &b]);
        assert_eq!(region.split_at_crossings(EdgeRule::Planar), 2);
        let mesh = build(&region, EdgeRule::Planar).expect("repaired");
        let square = |south: f64, width: f64| {
            Ellipsoid::WGS84.quadrangle_area_m2(
                width.to_radians(),
                south.to_radians(),
                (south + 1.0).to_radians(),
            )
        };
        let exact = square(0.0, 2.0) + 2.0 * square(1.0, 1.0) + square(2.0, 2.0);
        assert!((mesh.area_m2 / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_cross_is_left_alone() {
        let touching = [
            [0.0, 0.0],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let mut region = region(&[&touching]);
            let before = region.clone();
            assert_eq!(region.split_at_crossings(rule), 0);
            assert_eq!(region, before);
        }
    }
}
