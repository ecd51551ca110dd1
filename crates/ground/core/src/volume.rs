// SPDX-License-Identifier: MIT OR Apache-2.0
//! The closed solid that backends extrude from a mesh, written out triangle by triangle.
//!
//! ECEF metres, `f64`. The top cap is the mesh raised along the geodetic normals, the bottom cap
//! the same lowered and turned round, and each boundary edge carries a wall of two triangles.
//! Backends keep this implicit in strips and shaders. Here every corner has its own position, so
//! that a check can tell whether wall and cap agree on it rather than take it for granted.

use crate::edge::normal;
use crate::volume_invariants::VolumeFault;
use crate::{Ellipsoid, RegionMesh, VolumeHeights};
use glam::DVec3;

/// A face of the solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VolumePart {
    /// The mesh, raised.
    TopCap,
    /// The mesh, lowered and turned round.
    BottomCap,
    /// What stands on the boundary.
    Wall,
}

impl std::fmt::Display for VolumePart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::TopCap => "top cap",
            Self::BottomCap => "bottom cap",
            Self::Wall => "wall",
        })
    }
}

/// One triangle of the solid's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeTriangle {
    /// The face it belongs to.
    pub part: VolumePart,
    /// Counter-clockwise seen from outside the solid. Vertex *v* of the mesh is 2·v on top and
    /// 2·v + 1 at the bottom.
    pub vertices: [u32; 3],
    /// Where this triangle has them.
    pub corners_ecef: [DVec3; 3],
}

/// The closed solid of one mesh.
#[derive(Debug, Clone)]
pub struct RegionVolume<'a> {
    /// What is extruded.
    pub mesh: &'a RegionMesh,
    /// On which body.
    pub body: Ellipsoid,
    /// From where to where.
    pub heights: VolumeHeights,
    /// Top cap, bottom cap, then walls by two, loop after loop.
    pub triangles: Vec<VolumeTriangle>,
}

/// The copy of a mesh vertex on top.
pub(crate) fn top_of(vertex: u32) -> u32 {
    2 * vertex
}

/// The copy of a mesh vertex at the bottom.
pub(crate) fn bottom_of(vertex: u32) -> u32 {
    2 * vertex + 1
}

/// The two triangles of the wall from `from` to `to`; top start, bottom start, top end first, as
/// the strips of the vertex backend have them.
pub(crate) fn wall_of([from, to]: [u32; 2]) -> [[u32; 3]; 2] {
    [
        [top_of(from), bottom_of(from), top_of(to)],
        [top_of(to), bottom_of(from), bottom_of(to)],
    ]
}

/// Directed edges of the loops, in order.
pub(crate) fn ring_edges(mesh: &RegionMesh) -> impl Iterator<Item = [u32; 2]> + '_ {
    mesh.boundary_loops.iter().flat_map(|ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(&from, &to)| [from, to])
    })
}

impl<'a> RegionVolume<'a> {
    /// Writes the solid out. Cap positions are worked out once per vertex, wall positions again
    /// where a wall stands, as backends do.
    ///
    /// # Errors
    /// [`VolumeFault::Index`] when a triangle or a loop names a vertex that is not there, or there
    /// are too many for two copies each.
    pub fn new(
        mesh: &'a RegionMesh,
        body: &Ellipsoid,
        heights: VolumeHeights,
    ) -> Result<Self, VolumeFault> {
        let count = mesh.vertices_ecef.len().min(mesh.vertices_deg.len());
        let indices = mesh.triangles.iter().flatten();
        let largest = indices.chain(mesh.boundary_loops.iter().flatten()).max();
        if let Some(&vertex) = largest
            && (vertex as usize >= count || vertex > u32::MAX / 2 - 1)
        {
            return Err(VolumeFault::Index { vertex, count });
        }
        let mut volume = Self {
            mesh,
            body: *body,
            heights,
            triangles: Vec::with_capacity(2 * (mesh.triangles.len() + mesh.boundary_edge_count())),
        };
        volume.push_caps();
        volume.push_walls();
        Ok(volume)
    }

    fn push_caps(&mut self) {
        let mesh = self.mesh;
        for part in [VolumePart::TopCap, VolumePart::BottomCap] {
            let is_bottom = part == VolumePart::BottomCap;
            let copies: Vec<DVec3> = (0..)
                .take(mesh.vertices_ecef.len())
                .map(|vertex| self.position(2 * vertex + u32::from(is_bottom)))
                .collect();
            for &[a, b, c] in &mesh.triangles {
                let corners = if is_bottom { [a, c, b] } else { [a, b, c] };
                self.triangles.push(VolumeTriangle {
                    part,
                    vertices: corners.map(|v| 2 * v + u32::from(is_bottom)),
                    corners_ecef: corners.map(|v| copies[v as usize]),
                });
            }
        }
    }

    fn push_walls(&mut self) {
        for ends in ring_edges(self.mesh) {
            for vertices in wall_of(ends) {
                self.triangles.push(VolumeTriangle {
                    part: VolumePart::Wall,
                    vertices,
                    corners_ecef: vertices.map(|vertex| self.position(vertex)),
                });
            }
        }
    }

    /// Where the copy `vertex` belongs.
    fn position(&self, vertex: u32) -> DVec3 {
        let index = (vertex / 2) as usize;
        let height_m = if vertex.is_multiple_of(2) {
            self.heights.top_m
        } else {
            self.heights.bottom_m
        };
        self.mesh.vertices_ecef[index] + normal(self.mesh.vertices_deg[index]) * height_m
    }

    /// Longitude and latitude of a copy.
    pub(crate) fn degrees(&self, vertex: u32) -> [f64; 2] {
        self.mesh.vertices_deg[(vertex / 2) as usize]
    }

    /// Middle of the bounds: what the solid is measured and rounded from.
    #[must_use]
    pub fn center_ecef(&self) -> DVec3 {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for corner in self.triangles.iter().flat_map(|t| t.corners_ecef) {
            low = low.min(corner);
            high = high.max(corner);
        }
        if low.is_finite() && high.is_finite() {
            (low + high) * 0.5
        } else {
            DVec3::ZERO
        }
    }
}

/// What [`check_closed`] counted on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClosedSurface {
    /// All of them.
    pub triangles: usize,
    /// With two or three corners at one position: they cover nothing.
    pub collapsed_triangles: usize,
    /// Different pairs of positions that are joined.
    pub edges: usize,
    /// Sides of triangles with both ends at one position: they are no edges.
    pub collapsed_sides: usize,
    /// Edges used more than once each way.
    pub shared_edges: usize,
}

/// An edge whose uses do not cancel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an edge of triangle {triangle} is used {uses} times, its reverse {reverse_uses} times")]
pub struct OpenSurface {
    /// A triangle that has the edge, counted from 0; the last one.
    pub triangle: usize,
    /// As that triangle has it.
    pub uses: usize,
    /// The other way.
    pub reverse_uses: usize,
}

/// Whether triangles given by the positions of their corners enclose space without a gap.
///
/// A position is whatever the corners are compared by: an index, rounded coordinates, the bits that
/// a shader reads. Corners whose positions fall together are one; a side between such corners is no
/// edge. For every other pair of positions the uses one way must equal those the other way. That is
/// what stencil counting needs: a ray then meets as many front faces as back faces over its whole
/// length, whatever the triangles' shapes (a closed 2-chain has no boundary).
///
/// # Errors
/// The first [`OpenSurface`] in the order of positions.
pub fn check_closed<P: Ord + Copy>(
    triangles: impl IntoIterator<Item = [P; 3]>,
) -> Result<ClosedSurface, OpenSurface> {
    let mut counted = ClosedSurface::default();
    // Lower end, higher end, downwards?, triangle.
    let mut uses: Vec<(P, P, bool, usize)> = Vec::new();
    for corners in triangles {
        let before = uses.len();
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            match from.cmp(&to) {
                std::cmp::Ordering::Less => uses.push((from, to, false, counted.triangles)),
                std::cmp::Ordering::Greater => uses.push((to, from, true, counted.triangles)),
                std::cmp::Ordering::Equal => counted.collapsed_sides += 1,
            }
        }
        counted.collapsed_triangles += usize::from(uses.len() < before + 3);
        counted.triangles += 1;
    }
    uses.sort_unstable();
    for same in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (_, _, downwards, triangle) = same[same.len() - 1];
        let down = same.iter().filter(|entry| entry.2).count();
        let up = same.len() - down;
        if up != down {
            let (uses, reverse_uses) = if downwards { (down, up) } else { (up, down) };
            return Err(OpenSurface {
                triangle,
                uses,
                reverse_uses,
            });
        }
        counted.edges += 1;
        counted.shared_edges += usize::from(up > 1);
    }
    Ok(counted)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_closed_and_without_a_face_is_not() {
        let counted = check_closed(TETRAHEDRON).expect("closed");
        assert_eq!((counted.triangles, counted.edges), (4, 6));
        let open = check_closed(TETRAHEDRON[1..].iter().copied()).expect_err("open");
        assert_eq!((open.uses, open.reverse_uses), (1, 0));
        let mut turned = TETRAHEDRON;
        turned[2].swap(0, 1);
        let open = check_closed(turned).expect_err("turned");
        assert_eq!((open.uses, open.reverse_uses), (2, 0));
    }

    #[test]
    fn corners_that_fall_together_keep_a_surface_closed() {
        // 3 falls on 0: two triangles collapse to lines there and back, the others lie back to back.
        let fallen = TETRAHEDRON.map(|corners| corners.map(|i| i % 3));
        let counted = check_closed(fallen).expect("closed");
        assert_eq!(
            (counted.collapsed_triangles, counted.collapsed_sides),
            (2, 2)
        );
        assert_eq!((counted.edges, counted.shared_edges), (3, 2));
        // Twin: when one face alone has its corner moved, the surface is torn.
        let mut torn = TETRAHEDRON;
        torn[1][2] = 0;
        assert!(check_closed(torn).is_err());
    }
}
