// SPDX-License-Identifier: MIT OR Apache-2.0
//! How meshes lie in GPU buffers, and what that costs in bytes, by formula and as built.
//!
//! Indices are 16 bits where a region's vertices fit and 32 where they do not, region by region.

use std::borrow::Borrow;
use std::ops::Range;
use terrafill_contract::GeometryBytes;
use terrafill_core::{RegionMesh, index_u32};
use terrafill_plan::PartOrder;
use terrafill_stencil::{FixedPoint, IndexLists, VolumePlace};

/// A position in its region's units.
pub(crate) type Position = [i32; 3];

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges and *i*
/// bytes an index: 12·v + 24·e for positions of vertices and of edges' ends, and i·3t for the one
/// list that both caps are drawn from.
#[must_use]
pub fn instanced_bytes(mesh: &RegionMesh) -> GeometryBytes {
    let vertices = mesh.vertices_ecef.len();
    let is_short = IndexLists::are_short(vertices);
    let index_size = if is_short { 2 } else { 4 };
    GeometryBytes {
        vertex_bytes: (12 * vertices + 24 * mesh.boundary_edge_count()) as u64,
        index_bytes: (index_size * 3 * mesh.triangles.len()) as u64,
    }
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RegionSlice {
    pub(crate) place: VolumePlace,
    /// Its walls, as instances.
    pub(crate) walls: Range<u32>,
}

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct SceneGeometry {
    pub(crate) vertices: Vec<Position>,
    /// Triangles of the top caps.
    pub(crate) indices: IndexLists,
    /// Start and end of every boundary edge, inside on the left.
    pub(crate) walls: Vec<[Position; 2]>,
    pub(crate) regions: Vec<RegionSlice>,
}

impl SceneGeometry {
    /// Lays out every mesh.
    #[cfg(test)]
    pub(crate) fn build(meshes: &[impl Borrow<RegionMesh>]) -> Self {
        Self::in_parts(meshes, false)
    }

    /// Lays out every mesh, the triangles of large ones part by part where that is asked for.
    pub(crate) fn in_parts(meshes: &[impl Borrow<RegionMesh>], by_part: bool) -> Self {
        let mut geometry = Self::default();
        for mesh in meshes.iter().map(Borrow::borrow) {
            let order = by_part.then(|| PartOrder::of(mesh)).flatten();
            let ordered = order.map(|order| order.ordered(mesh));
            geometry.push(mesh, ordered.as_deref().unwrap_or(&mesh.triangles));
        }
        geometry
    }

    /// Puts what `other` has behind its own.
    pub(crate) fn append(&mut self, other: &Self) {
        let first_vertex = index_u32(self.vertices.len());
        let first_wall = index_u32(self.walls.len());
        let [long, short] = [false, true].map(|is_short| self.indices.count(is_short));
        self.vertices.extend(&other.vertices);
        self.walls.extend(&other.walls);
        self.indices.append(&other.indices);
        let moved = other.regions.iter().map(|slice| {
            let by = if slice.place.has_short_indices {
                short
            } else {
                long
            };
            RegionSlice {
                place: slice.place.moved(first_vertex, by, first_wall),
                walls: slice.walls.start + first_wall..slice.walls.end + first_wall,
            }
        });
        self.regions.extend(moved);
    }

    fn push(&mut self, mesh: &RegionMesh, triangles: &[[u32; 3]]) {
        let fixed = FixedPoint::for_mesh(mesh);
        let stored = |ecef| fixed.quantize(ecef).to_array();
        let positions: Vec<Position> = mesh.vertices_ecef.iter().copied().map(stored).collect();
        let is_short = IndexLists::are_short(mesh.vertices_ecef.len());
        let first_wall = index_u32(self.walls.len());
        let ends = |edge: [u32; 2]| edge.map(|vertex| positions[vertex as usize]);
        self.walls.extend(mesh.boundary_edges().map(ends));
        self.regions.push(RegionSlice {
            place: VolumePlace {
                fixed,
                first_vertex: index_u32(self.vertices.len()),
                first_triangle_index: self.indices.count(is_short),
                first_loop_index: first_wall,
                triangle_count: index_u32(mesh.triangles.len()),
                has_short_indices: is_short,
            },
            walls: first_wall..index_u32(self.walls.len()),
        });
        self.vertices.extend(positions);
        let corners = triangles.as_flattened().iter();
        self.indices.extend(is_short, corners.copied());
    }

    /// Bytes as built.
    pub(crate) fn bytes(&self) -> GeometryBytes {
        let vertices = size_of_val(self.vertices.as_slice());
        let walls = size_of_val(self.walls.as_slice());
        GeometryBytes {
            vertex_bytes: (vertices + walls) as u64,
            index_bytes: self.indices.bytes(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_fixtures::{by_hand::disc, check_held_layouts};

    #[test]
    fn what_a_view_before_held_is_not_laid_out_again_and_lies_as_if_it_were() {
        check_held_layouts(
            [5, 65_536, 7, 4].map(disc).to_vec(),
            SceneGeometry::in_parts,
            SceneGeometry::append,
            SceneGeometry::build(&[disc(9)]),
        );
    }

    #[test]
    fn the_formula_and_the_buffers_agree() {
        for count in [3, 100, 65_534, 65_535, 65_536] {
            let meshes = [disc(count), disc(7)];
            let geometry = SceneGeometry::build(&meshes);
            let formula: GeometryBytes = meshes.iter().map(instanced_bytes).sum();
            assert_eq!(geometry.bytes(), formula, "{count}");
            // The middle is one vertex more.
            let is_short = geometry.regions[0].place.has_short_indices;
            assert_eq!(is_short, count <= 65_535, "{count}");
        }
        // Negative control: a wall less is 24 bytes less.
        let mut geometry = SceneGeometry::build(&[disc(7)]);
        geometry.walls.pop();
        let missing = instanced_bytes(&disc(7)).total() - geometry.bytes().total();
        assert_eq!(missing, 24);
    }

    #[test]
    fn walls_are_the_boundarys_edges_once_each_and_lie_by_region() {
        let meshes = [disc(5), disc(9)];
        let geometry = SceneGeometry::build(&meshes);
        for (mesh, slice) in meshes.iter().zip(&geometry.regions) {
            let first = slice.place.first_vertex as usize;
            let walls = &geometry.walls[slice.walls.start as usize..slice.walls.end as usize];
            assert_eq!(walls.len(), mesh.boundary_edge_count());
            for ([start, end], found) in mesh.boundary_edges().zip(walls) {
                let at = |vertex: u32| geometry.vertices[first + vertex as usize];
                assert_eq!(*found, [at(start), at(end)]);
                // Negative control: the other way round it is another wall.
                assert_ne!(*found, [at(end), at(start)]);
            }
        }
    }
}
