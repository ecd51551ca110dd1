// SPDX-License-Identifier: MIT OR Apache-2.0
//! Constrained Delaunay triangulation of a rectangle that knows inside from outside (crate `spade`).
//!
//! The plane, any unit. spade decides where points and edges lie exactly (Shewchuk 1997). What it does
//! not keep is kept here: along which edges an odd number of constraints run, and on which side of
//! them each triangle is. Four corners of a frame round everything that will come are inserted first:
//! points in a line, of which there is no triangle, then need no case of their own.

use crate::mesh::index_u32;
use spade::handles::{
    DirectedEdgeHandle, FixedDirectedEdgeHandle, FixedVertexHandle, VertexHandle,
};
use spade::{
    CdtEdge, ConstrainedDelaunayTriangulation, InsertionError, Point2, PositionInTriangulation,
    Triangulation,
};

/// Corners of the frame; they are the first vertices.
pub(crate) const FRAME_CORNERS: usize = 4;

/// An edge of a triangle, which lies on its left. Its mark: whether an odd number of constraints run
/// along it.
pub(crate) type Edge<'a> = DirectedEdgeHandle<'a, Point2<f64>, (), CdtEdge<bool>, Side>;

/// Of the constraints that a triangle lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Side {
    /// Before [`Constrained::find_inside`].
    #[default]
    Unknown,
    Outside,
    Inside,
}

impl Side {
    /// Across an edge along which so many constraints run.
    fn across(self, is_odd: bool) -> Self {
        match self {
            Self::Outside if is_odd => Self::Inside,
            Self::Inside if is_odd => Self::Outside,
            same => same,
        }
    }
}

/// The triangulation.
pub(crate) struct Constrained {
    pub(crate) cdt: ConstrainedDelaunayTriangulation<Point2<f64>, (), bool, Side>,
    /// Whether a vertex lies on a constraint, between its ends.
    touches: bool,
    /// Whether [`Constrained::find_inside`] has been called.
    has_sides: bool,
}

impl Constrained {
    /// An empty frame round `[west, south, east, north]`, with room for so many vertices.
    ///
    /// # Errors
    /// [`InsertionError`] for coordinates that are no finite numbers.
    pub(crate) fn new(
        [west, south, east, north]: [f64; 4],
        vertex_count: usize,
    ) -> Result<Self, InsertionError> {
        // As wide again on every side, so that no triangle between an outline and the frame is
        // much thinner than the outline itself makes it.
        let margin = (east - west).max(north - south).max(1.0);
        let (west, south) = (west - margin, south - margin);
        let (east, north) = (east + margin, north + margin);
        let count = vertex_count + FRAME_CORNERS;
        let mut empty = Self {
            cdt: ConstrainedDelaunayTriangulation::with_capacity(count, 3 * count, 2 * count),
            touches: false,
            has_sides: false,
        };
        for corner in [[west, south], [east, south], [east, north], [west, north]] {
            empty.insert(corner)?;
        }
        Ok(empty)
    }

    /// Tells inside from outside: whether an odd number of constraints separates a triangle from the
    /// frame. To be called when all constraints are in; points that are inserted later keep it, so
    /// that the triangles need to be gone through only once.
    pub(crate) fn find_inside(&mut self) {
        // Nothing is constrained at the frame, so the triangles there are outside.
        self.has_sides = true;
        let mut waiting = Vec::new();
        for edge in self.cdt.convex_hull() {
            waiting.extend(edge.rev().face().as_inner().map(|face| face.fix()));
        }
        for face in &waiting {
            *self.cdt.face_data_mut(*face) = Side::Outside;
        }
        while let Some(face) = waiting.pop() {
            let face = self.cdt.face(face);
            let side = *face.data();
            let across = face.adjacent_edges().map(|edge| {
                let across = edge.rev().face().as_inner();
                let across = across.filter(|face| *face.data() == Side::Unknown);
                across.map(|face| (face.fix(), side.across(is_odd(edge))))
            });
            for (face, side) in across.into_iter().flatten() {
                *self.cdt.face_data_mut(face) = side;
                waiting.push(face);
            }
        }
    }

    /// Those of the frame included.
    pub(crate) fn vertex_count(&self) -> usize {
        self.cdt.num_vertices()
    }

    pub(crate) fn point(&self, vertex: u32) -> [f64; 2] {
        let Point2 { x, y } = self.vertex(vertex).position();
        [x, y]
    }

    fn vertex(&self, vertex: u32) -> VertexHandle<'_, Point2<f64>, (), CdtEdge<bool>, Side> {
        self.cdt.vertex(handle(vertex))
    }

    /// Whether a vertex lies on a constraint, between its ends.
    pub(crate) fn has_touches(&self) -> bool {
        self.touches
    }

    /// Every edge once.
    pub(crate) fn edges(&self) -> impl Iterator<Item = Edge<'_>> + '_ {
        self.cdt.undirected_edges().map(|edge| edge.as_directed())
    }

    /// Every edge at a vertex, leading away from it.
    pub(crate) fn edges_at(&self, vertex: u32) -> impl Iterator<Item = Edge<'_>> + '_ {
        self.vertex(vertex).out_edges()
    }

    /// The triangle that a point lies strictly within, as one of its edges.
    pub(crate) fn triangle_round(&self, [x, y]: [f64; 2]) -> Option<Edge<'_>> {
        match self.cdt.locate(Point2::new(x, y)) {
            PositionInTriangulation::OnFace(face) => Some(self.cdt.face(face).adjacent_edge()),
            _ => None,
        }
    }

    /// The vertex at `point`, new if there was none.
    ///
    /// # Errors
    /// [`InsertionError`] for coordinates that are no finite numbers.
    pub(crate) fn insert(&mut self, [x, y]: [f64; 2]) -> Result<u32, InsertionError> {
        let (vertices, constraints) = (self.cdt.num_vertices(), self.cdt.num_constraints());
        let vertex = self.cdt.insert(Point2::new(x, y))?;
        if self.cdt.num_constraints() > constraints {
            self.touches = true;
            self.mark_halves(vertex);
        }
        if self.has_sides && self.cdt.num_vertices() > vertices {
            self.find_side_of_new(vertex);
        }
        Ok(index_u32(vertex.index()))
    }

    /// Of a constraint that a new vertex has split only one half has kept its mark.
    fn mark_halves(&mut self, vertex: FixedVertexHandle) {
        let edges = self.cdt.vertex(vertex).out_edges();
        let halves = edges.filter(|edge| edge.is_constraint_edge());
        let halves: Vec<_> = halves.map(|half| (half.fix(), is_odd(half))).collect();
        let mark = halves.iter().any(|(_, is_odd)| *is_odd);
        for (half, _) in halves {
            let half = half.as_undirected();
            *self.cdt.undirected_edge_data_mut(half).data_mut() = mark;
        }
    }

    /// Round a new vertex some triangles are new, and others have kept their side.
    fn find_side_of_new(&mut self, vertex: FixedVertexHandle) {
        let mut edges = self.cdt.vertex(vertex).out_edges();
        let Some(known) = edges.find(|edge| side_of(*edge) != Side::Unknown) else {
            return;
        };
        let mut side = side_of(known);
        let mut found = Vec::new();
        let mut edge = known.ccw();
        while edge != known {
            side = side.across(is_odd(edge));
            if side_of(edge) == Side::Unknown {
                found.extend(edge.face().as_inner().map(|face| (face.fix(), side)));
            }
            edge = edge.ccw();
        }
        for (face, side) in found {
            *self.cdt.face_data_mut(face) = side;
        }
    }

    /// The edge between two vertices. Both ends are searched in step: a vertex may have as many edges
    /// as there are others.
    pub(crate) fn edge_between(&self, [from, to]: [u32; 2]) -> Option<Edge<'_>> {
        let (there, back) = (self.edges_at(from), self.edges_at(to));
        there.zip(back).find_map(|(there, back)| {
            let ends_at = |edge: Edge<'_>, vertex| edge.to().fix() == handle(vertex);
            let there = ends_at(there, to).then_some(there);
            there.or(ends_at(back, from).then(|| back.rev()))
        })
    }

    /// Makes a constraint of the line between two vertices, or one more of those that run there, and
    /// returns its edges: where it passes exactly through vertices there are several. `None` where it
    /// crosses another constraint.
    pub(crate) fn constrain(
        &mut self,
        [from, to]: [u32; 2],
    ) -> Option<Vec<FixedDirectedEdgeHandle>> {
        if from == to {
            return Some(Vec::new());
        }
        let edges = self.cdt.try_add_constraint(handle(from), handle(to));
        for edge in &edges {
            let mark = self.cdt.undirected_edge_data_mut(edge.as_undirected());
            *mark.data_mut() ^= true;
        }
        self.touches |= edges.len() > 1;
        (!edges.is_empty()).then_some(edges)
    }
}

fn handle(vertex: u32) -> FixedVertexHandle {
    FixedVertexHandle::from_index(vertex as usize)
}

/// Whether an odd number of constraints run along an edge.
pub(crate) fn is_odd(edge: Edge<'_>) -> bool {
    *edge.as_undirected().data().data()
}

/// Whether the triangle of an edge is inside, once [`Constrained::find_inside`] has told.
pub(crate) fn is_inside(edge: Edge<'_>) -> bool {
    side_of(edge) == Side::Inside
}

fn side_of(edge: Edge<'_>) -> Side {
    *edge.face().data()
}

/// Both ends of an edge.
pub(crate) fn ends(edge: Edge<'_>) -> [u32; 2] {
    edge.vertices().map(|vertex| index_u32(vertex.index()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random points, the same every time.
    fn random_points(count: usize) -> Vec<[f64; 2]> {
        let mut state = 1_u64;
        let mut unit = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| [unit(), unit()]).collect()
    }

    fn triangulated(points: &[[f64; 2]]) -> Constrained {
        let mut mesh = Constrained::new([0.0, 0.0, 1.0, 1.0], points.len()).expect("finite");
        for point in points {
            mesh.insert(*point).expect("finite");
        }
        mesh
    }

    #[test]
    fn constraints_stay_and_are_counted_by_parity_through_vertices() {
        let mut mesh = triangulated(&random_points(500));
        let ends = [[-0.0625, 0.5], [0.25, 0.5], [0.75, 0.5], [1.0625, 0.5]];
        let [west, a, b, east] = ends.map(|point| mesh.insert(point).expect("finite"));
        assert!(!mesh.has_touches());
        assert_eq!(
            mesh.constrain([west, east]).map(|edges| edges.len()),
            Some(3)
        );
        assert_eq!(mesh.constrain([b, a]).map(|edges| edges.len()), Some(1));
        assert!(mesh.has_touches());
        let odd = |mesh: &Constrained, ends| {
            let edge = mesh.edge_between(ends).expect("an edge");
            assert!(edge.is_constraint_edge());
            is_odd(edge)
        };
        assert_eq!(
            [[west, a], [a, b], [b, east]].map(|ends| odd(&mesh, ends)),
            [true, false, true]
        );
        // A later point splits an edge into two of the same parity.
        let middle = mesh.insert([0.875, 0.5]).expect("finite");
        assert!(odd(&mesh, [b, middle]) && odd(&mesh, [middle, east]));
        let middle = mesh.insert([0.5, 0.5]).expect("finite");
        assert!(!odd(&mesh, [a, middle]) && !odd(&mesh, [middle, b]));
        let [south, north] = [[0.4, 0.0], [0.4, 1.0]].map(|end| mesh.insert(end).expect("finite"));
        assert_eq!(mesh.constrain([south, north]), None);
        // Twin: beside the line nothing crosses.
        let beside = mesh.insert([0.4, 0.25]).expect("finite");
        assert!(mesh.constrain([south, beside]).is_some());
        assert!(mesh.insert([f64::NAN, 0.0]).is_err());
    }

    #[test]
    fn points_that_come_late_keep_inside_and_outside() {
        // A square with a square hole, and a line through both that is there twice.
        let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]];
        let mut mesh = triangulated(&random_points(200));
        for [low, high] in [[0.1, 0.9], [0.3, 0.7]] {
            let corners = square(low, high).map(|corner| mesh.insert(corner).expect("finite"));
            for i in 0..4 {
                mesh.constrain([corners[i], corners[(i + 1) % 4]])
                    .expect("apart");
            }
        }
        let [from, to] = [[0.1, 0.1], [0.3, 0.3]].map(|end| mesh.insert(end).expect("finite"));
        for _ in 0..2 {
            mesh.constrain([from, to]).expect("apart");
        }
        mesh.find_inside();
        let on_edges = (1..40).map(|k| [0.1 + 0.02 * f64::from(k), 0.1]);
        let on_line = (1..10).map(|k| [0.1 + 0.02 * f64::from(k); 2]);
        for point in on_edges.chain(on_line).chain(random_points(900)) {
            mesh.insert(point).expect("finite");
        }
        let sides = |mesh: &Constrained| -> Vec<Side> {
            mesh.cdt.inner_faces().map(|face| *face.data()).collect()
        };
        let kept = sides(&mesh);
        let area = |side: Side| -> f64 {
            let faces = mesh.cdt.inner_faces();
            faces
                .filter(|face| *face.data() == side)
                .map(|face| face.area())
                .sum()
        };
        assert!((area(Side::Inside) - 0.48).abs() < 1e-12);
        // As they are found anew.
        let faces: Vec<_> = mesh.cdt.fixed_inner_faces().collect();
        for face in faces {
            *mesh.cdt.face_data_mut(face) = Side::Unknown;
        }
        assert_ne!(sides(&mesh), kept);
        mesh.find_inside();
        assert_eq!(sides(&mesh), kept);
    }
}
