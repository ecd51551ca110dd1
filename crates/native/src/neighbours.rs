// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangle of a mesh lies across which side of another.
//!
//! Side *k* of a triangle runs from its corner *k* to the next. Sides are sorted into buckets by the
//! vertex that they begin at, and there by the one they end at, so that the side back is found among
//! a handful without hashing, and among thousands around one vertex without looking at each.

use terrafill_core::RegionMesh;
use terrafill_frame::boundary_edges;

/// A side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Side {
    pub(crate) triangle: usize,
    /// 0, 1 or 2.
    pub(crate) number: usize,
}

/// What lies across a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Across {
    /// The boundary: a wall stands on the side.
    Wall,
    /// The same side, seen from a neighbour.
    Neighbour(Side),
    /// Neither, as in a mesh from which triangles were taken.
    Nothing,
}

/// A mesh's triangles with what lies across their sides.
#[derive(Debug)]
pub(crate) struct Neighbours<'a> {
    pub(crate) triangles: &'a [[u32; 3]],
    across: Vec<[Across; 3]>,
}

impl<'a> Neighbours<'a> {
    /// - cost: O(triangles), times the logarithm of how many of them meet at a vertex
    pub(crate) fn of(mesh: &'a RegionMesh) -> Self {
        let triangles = mesh.triangles.as_slice();
        let sides = Sides::of(triangles, mesh.vertex_count());
        let neighbour = |from: u32, to: u32| {
            let back = sides.between(to, from).last();
            back.map_or(Across::Nothing, Across::Neighbour)
        };
        let around = |&[a, b, c]: &[u32; 3]| [neighbour(a, b), neighbour(b, c), neighbour(c, a)];
        let mut across: Vec<_> = triangles.iter().map(around).collect();
        for [from, to] in boundary_edges(mesh) {
            for side in sides.between(from, to) {
                across[side.triangle][side.number] = Across::Wall;
            }
        }
        Self { triangles, across }
    }

    /// Corner `number` of a triangle, counted on around it.
    pub(crate) fn corner(&self, triangle: usize, number: usize) -> u32 {
        self.triangles[triangle][number % 3]
    }

    /// The corner opposite a side.
    fn opposite(&self, side: Side) -> u32 {
        self.corner(side.triangle, side.number + 2)
    }

    /// What `adjacency.geom` is told of a side: the neighbour's corner across it; where a wall stands
    /// on the side the triangle's own opposite corner, which no neighbour across it has; and where
    /// there is neither, as in no whole mesh, an end of the side, which says "no wall".
    pub(crate) fn told_across(&self, side: Side) -> u32 {
        match self.across[side.triangle][side.number] {
            Across::Wall => self.opposite(side),
            Across::Neighbour(back) => self.opposite(back),
            Across::Nothing => self.corner(side.triangle, side.number),
        }
    }

    /// The same side seen from the neighbour that a strip may go on to: one that has this triangle
    /// for its neighbour, with no wall between and another third corner.
    pub(crate) fn beyond(&self, side: Side) -> Option<Side> {
        let Across::Neighbour(back) = self.across[side.triangle][side.number] else {
            return None;
        };
        let is_mutual = self.across[back.triangle][back.number] == Across::Neighbour(side);
        (is_mutual && self.opposite(back) != self.opposite(side)).then_some(back)
    }
}

/// Sides in the order of the vertices that they begin at.
struct Sides<'a> {
    triangles: &'a [[u32; 3]],
    /// By vertex, where its sides begin in `sides`; one more at the end.
    first: Vec<usize>,
    sides: Vec<Side>,
}

impl<'a> Sides<'a> {
    fn of(triangles: &'a [[u32; 3]], vertex_count: usize) -> Self {
        let mut first = vec![0; vertex_count + 1];
        for &corner in triangles.as_flattened() {
            first[corner as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            first[vertex + 1] += first[vertex];
        }
        let mut next = first.clone();
        let none = Side {
            triangle: 0,
            number: 0,
        };
        let mut sides = vec![none; 3 * triangles.len()];
        for (triangle, corners) in triangles.iter().enumerate() {
            for (number, &corner) in corners.iter().enumerate() {
                let place = &mut next[corner as usize];
                sides[*place] = Side { triangle, number };
                *place += 1;
            }
        }
        for bucket in first.windows(2) {
            let end = |side: &Side| (end_of(triangles, *side), side.triangle);
            sides[bucket[0]..bucket[1]].sort_unstable_by_key(end);
        }
        Self {
            triangles,
            first,
            sides,
        }
    }

    /// Those from one vertex to another, of which a whole mesh has at most one.
    fn between(&self, from: u32, to: u32) -> impl Iterator<Item = Side> {
        let from = from as usize;
        let sides = &self.sides[self.first[from]..self.first[from + 1]];
        let end = |side: &Side| end_of(self.triangles, *side);
        let begin = sides.partition_point(|side| end(side) < to);
        let found = sides[begin..].iter().copied();
        found.take_while(move |side| end(side) == to)
    }
}

fn end_of(triangles: &[[u32; 3]], side: Side) -> u32 {
    triangles[side.triangle][(side.number + 1) % 3]
}
