// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangle of a mesh lies across which side of another.
//!
//! Side *k* of a triangle runs from its corner *k* to the next. Sides are sorted into buckets by the
//! vertex that they begin at, so that the side back is found among a handful without hashing; where
//! a vertex has many they are in the order of their ends, and not each is looked at.

use terrafill_core::{RegionMesh, index_u32};

/// A side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Side {
    pub(crate) triangle: usize,
    /// 0, 1 or 2.
    pub(crate) number: usize,
}

/// A side in 4 bytes: large meshes have millions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Packed(u32);

/// What lies across a side: the same side, seen from a neighbour; or one of two constants.
type Across = Packed;

impl Packed {
    /// The boundary: a wall stands on the side.
    const WALL: Self = Self(u32::MAX);
    /// Neither a wall nor a neighbour, as in a mesh from which triangles were taken.
    const NOTHING: Self = Self(u32::MAX - 1);

    fn of(side: Side) -> Self {
        Self(index_u32(3 * side.triangle + side.number))
    }

    fn side(self) -> Side {
        let place = self.0 as usize;
        Side {
            triangle: place / 3,
            number: place % 3,
        }
    }
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
            back.unwrap_or(Across::NOTHING)
        };
        let around = |&[a, b, c]: &[u32; 3]| [neighbour(a, b), neighbour(b, c), neighbour(c, a)];
        let mut across: Vec<_> = triangles.iter().map(around).collect();
        for [from, to] in mesh.boundary_edges() {
            for side in sides.between(from, to) {
                let side = side.side();
                across[side.triangle][side.number] = Across::WALL;
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
            Across::WALL => self.opposite(side),
            Across::NOTHING => self.corner(side.triangle, side.number),
            back => self.opposite(back.side()),
        }
    }

    /// The same side seen from the neighbour that a strip may go on to: one that has this triangle
    /// for its neighbour, with no wall between and another third corner.
    pub(crate) fn beyond(&self, side: Side) -> Option<Side> {
        let back = match self.across[side.triangle][side.number] {
            Across::WALL | Across::NOTHING => return None,
            back => back.side(),
        };
        let is_mutual = self.across[back.triangle][back.number] == Across::of(side);
        (is_mutual && self.opposite(back) != self.opposite(side)).then_some(back)
    }
}

/// Sides that begin at a vertex up to which they are looked through one by one.
const FEW: usize = 16;

/// Sides in the order of the vertices that they begin at.
struct Sides {
    /// By vertex, where its sides begin in `sides`; one more at the end.
    first: Vec<u32>,
    /// The vertex that each ends at, and the side; in order where a vertex has more than [`FEW`].
    sides: Vec<(u32, Packed)>,
}

impl Sides {
    fn of(triangles: &[[u32; 3]], vertex_count: usize) -> Self {
        let mut first = vec![0; vertex_count + 1];
        for &corner in triangles.as_flattened() {
            first[corner as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            first[vertex + 1] += first[vertex];
        }
        let mut next = first.clone();
        let mut sides = vec![(0, Packed::NOTHING); 3 * triangles.len()];
        for (triangle, corners) in triangles.iter().enumerate() {
            for (number, end) in [1, 2, 0].into_iter().enumerate() {
                let place = &mut next[corners[number] as usize];
                let side = Packed::of(Side { triangle, number });
                sides[*place as usize] = (corners[end], side);
                *place += 1;
            }
        }
        for bucket in first.windows(2) {
            let bucket = &mut sides[bucket[0] as usize..bucket[1] as usize];
            if bucket.len() > FEW {
                bucket.sort_unstable_by_key(|&(end, side)| (end, side.0));
            }
        }
        Self { first, sides }
    }

    /// Those from one vertex to another, of which a whole mesh has at most one.
    fn between(&self, from: u32, to: u32) -> impl Iterator<Item = Packed> {
        let from = from as usize;
        let mut sides = &self.sides[self.first[from] as usize..self.first[from + 1] as usize];
        if sides.len() > FEW {
            let begin = sides.partition_point(|&(end, _)| end < to);
            let past = sides.partition_point(|&(end, _)| end <= to);
            sides = &sides[begin..past];
        }
        let found = sides.iter().filter(move |&&(end, _)| end == to);
        found.map(|&(_, side)| side)
    }
}
