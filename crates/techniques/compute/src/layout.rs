// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a compute pass reads and writes, and what that costs in bytes, by formula and as built.
//!
//! Indices that are read are 16 bits where a region's vertices fit and 32 where they do not,
//! region by region; those that are written are 32 bits.

use std::borrow::Borrow;
use terrafill_core::{RegionMesh, index_u32};
use terrafill_plan::PartOrder;
use terrafill_stencil::{FixedPoint, IndexLists, VolumePlace};

/// Bytes of one or more regions, what is stored and what is made from it apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ComputeBytes {
    /// Positions, uploaded.
    pub input_vertex_bytes: u64,
    /// Triangles of one cap and the boundary, uploaded.
    pub input_index_bytes: u64,
    /// Caps and walls, written by the device.
    pub output_index_bytes: u64,
    /// Corners in clip space, written by the device; 0 where the vertex shader puts them there.
    pub output_vertex_bytes: u64,
}

impl ComputeBytes {
    /// What is uploaded.
    #[must_use]
    pub fn input(self) -> u64 {
        self.input_vertex_bytes + self.input_index_bytes
    }

    /// All of it.
    #[must_use]
    pub fn total(self) -> u64 {
        self.input() + self.output_index_bytes + self.output_vertex_bytes
    }
}

impl std::iter::Sum for ComputeBytes {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            input_vertex_bytes: sum.input_vertex_bytes + part.input_vertex_bytes,
            input_index_bytes: sum.input_index_bytes + part.input_index_bytes,
            output_index_bytes: sum.output_index_bytes + part.output_index_bytes,
            output_vertex_bytes: sum.output_vertex_bytes + part.output_vertex_bytes,
        })
    }
}

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges in *l*
/// loops and *i* bytes an index: 12·v + i·(3t + e + l) read, the loops closed and the last word
/// filled up, and 4·(6t + 6e) written.
#[must_use]
pub fn compute_bytes(mesh: &RegionMesh) -> ComputeBytes {
    let (vertices, triangles) = (mesh.vertices_ecef.len(), mesh.triangles.len());
    let (edges, loops) = (mesh.boundary_edge_count(), mesh.boundary_loops.len());
    let indices = 3 * triangles + edges + loops;
    let words = if IndexLists::are_short(vertices) {
        indices.div_ceil(2)
    } else {
        indices
    };
    ComputeBytes {
        input_vertex_bytes: 12 * vertices as u64,
        input_index_bytes: 4 * words as u64,
        output_index_bytes: 24 * (triangles + edges) as u64,
        output_vertex_bytes: 0,
    }
}

/// Bytes of the corners of `mesh` in clip space: two a vertex, of four floats.
#[must_use]
pub fn placed_bytes(mesh: &RegionMesh) -> u64 {
    32 * mesh.vertices_ecef.len() as u64
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeshSlice {
    /// Loops lie one after the other, each closed.
    pub(crate) place: VolumePlace,
    pub(crate) vertex_count: u32,
    /// Words of the list of indices.
    pub(crate) index_words: u32,
    pub(crate) edge_count: u32,
}

impl MeshSlice {
    /// Where `other` lies when it takes this one's place; `None` where it has more or fewer vertices
    /// or indices.
    pub(crate) fn replaced_by(&self, other: &Self) -> Option<Self> {
        let counts = |slice: &Self| {
            let triangles = slice.place.triangle_count;
            let counts = [
                triangles,
                slice.vertex_count,
                slice.index_words,
                slice.edge_count,
            ];
            (counts, slice.place.has_short_indices)
        };
        let place = VolumePlace {
            fixed: other.place.fixed,
            ..self.place
        };
        (counts(self) == counts(other)).then_some(Self { place, ..*self })
    }

    /// First word of its indices.
    pub(crate) fn first_index_word(&self) -> usize {
        let in_a_word = if self.place.has_short_indices { 2 } else { 1 };
        self.place.first_triangle_index as usize / in_a_word
    }

    /// Indices that the region's volume takes, with its bottom cap or without.
    pub(crate) fn output_indices(&self, has_bottom: bool) -> u64 {
        let caps = if has_bottom { 2 } else { 1 };
        3 * caps * u64::from(self.place.triangle_count) + 6 * u64::from(self.edge_count)
    }
}

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct SceneGeometry {
    /// Three words a vertex.
    pub(crate) positions: Vec<i32>,
    /// Indices of 32 bits, or two of 16 bits a word, low half first.
    pub(crate) indices: Vec<u32>,
    pub(crate) meshes: Vec<MeshSlice>,
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
        let first_vertex = index_u32(self.positions.len() / 3);
        let first_word = index_u32(self.indices.len());
        self.positions.extend(&other.positions);
        self.indices.extend(&other.indices);
        let moved = other.meshes.iter().map(|slice| {
            let in_a_word = if slice.place.has_short_indices { 2 } else { 1 };
            let by = in_a_word * first_word;
            let place = slice.place.moved(first_vertex, by, by);
            MeshSlice { place, ..*slice }
        });
        self.meshes.extend(moved);
    }

    fn push(&mut self, mesh: &RegionMesh, triangles: &[[u32; 3]]) {
        let fixed = FixedPoint::for_mesh(mesh);
        let first_vertex = index_u32(self.positions.len() / 3);
        for vertex in &mesh.vertices_ecef {
            self.positions.extend(fixed.quantize(*vertex).to_array());
        }
        let has_short_indices = IndexLists::are_short(mesh.vertices_ecef.len());
        let corners = triangles.as_flattened().iter().copied();
        let closed = mesh
            .boundary_loops
            .iter()
            .flat_map(|ring| ring.iter().chain(ring.first()).copied());
        let list: Vec<u32> = corners.chain(closed).collect();
        let first_word = index_u32(self.indices.len());
        let first_triangle_index = if has_short_indices {
            let word = |pair: &[u32]| pair[0] | pair.get(1).copied().unwrap_or(0) << 16;
            self.indices.extend(list.chunks(2).map(word));
            2 * first_word
        } else {
            self.indices.extend(list);
            first_word
        };
        self.meshes.push(MeshSlice {
            place: VolumePlace {
                fixed,
                first_vertex,
                first_triangle_index,
                first_loop_index: first_triangle_index + 3 * index_u32(mesh.triangles.len()),
                triangle_count: index_u32(mesh.triangles.len()),
                has_short_indices,
            },
            vertex_count: index_u32(mesh.vertices_ecef.len()),
            index_words: index_u32(self.indices.len()) - first_word,
            edge_count: index_u32(mesh.boundary_edge_count()),
        });
    }

    /// Bytes as built.
    pub(crate) fn bytes(&self) -> ComputeBytes {
        ComputeBytes {
            input_vertex_bytes: self.positions.len() as u64 * 4,
            input_index_bytes: self.indices.len() as u64 * 4,
            output_index_bytes: self.meshes.iter().map(|m| 4 * m.output_indices(true)).sum(),
            output_vertex_bytes: 0,
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
        for count in [3, 4, 100, 65_534, 65_535, 65_536, 70_000] {
            let mesh = disc(count);
            let built = SceneGeometry::build(std::slice::from_ref(&mesh)).bytes();
            assert_eq!(built, compute_bytes(&mesh), "{count}");
        }
    }

    #[test]
    fn indices_read_back_as_they_were_at_either_width() {
        let meshes = [disc(5), disc(65_536), disc(4), disc(65_535)];
        let geometry = SceneGeometry::build(&meshes);
        for (mesh, slice) in meshes.iter().zip(&geometry.meshes) {
            let read = |element: u32| {
                if slice.place.has_short_indices {
                    let word = geometry.indices[element as usize / 2];
                    word >> (16 * (element % 2)) & 0xffff
                } else {
                    geometry.indices[element as usize]
                }
            };
            let corners = mesh.triangles.as_flattened();
            for (element, &corner) in (slice.place.first_triangle_index..).zip(corners) {
                assert_eq!(read(element), corner);
            }
            let ring = &mesh.boundary_loops[0];
            for (element, &vertex) in
                (slice.place.first_loop_index..).zip(ring.iter().chain(&ring[..1]))
            {
                assert_eq!(read(element), vertex);
            }
        }
        let widths: Vec<bool> = geometry
            .meshes
            .iter()
            .map(|m| m.place.has_short_indices)
            .collect();
        assert_eq!(widths, [true, false, true, true]);
    }
}
