// SPDX-License-Identifier: MIT OR Apache-2.0
//! How meshes lie in GPU buffers, and what that costs in bytes, by formula and as built.
//!
//! Indices are 16 bits where a region's vertices fit and 32 where they do not, region by region.

use crate::Technique;
use std::collections::{HashMap, HashSet};
use terrafill_core::RegionMesh;
use terrafill_frame::FixedPoint;

/// Bytes of one or more regions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NativeBytes {
    /// Positions and flags.
    pub vertex_bytes: u64,
    /// Indices.
    pub index_bytes: u64,
}

impl NativeBytes {
    /// Both.
    #[must_use]
    pub fn total(self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }
}

impl std::iter::Sum for NativeBytes {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            vertex_bytes: sum.vertex_bytes + part.vertex_bytes,
            index_bytes: sum.index_bytes + part.index_bytes,
        })
    }
}

/// Whether a region's indices fit 16 bits. Strips end with 0xffff, so that it is no vertex.
fn has_short_indices(technique: Technique, vertices: usize) -> bool {
    match technique {
        Technique::VsControl => 2 * vertices <= 0xffff,
        _ => vertices <= 0x1_0000,
    }
}

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges in *l*
/// loops and *i* bytes an index:
///
/// - `vs-control`: 2·16·v + i·(6t + 2(e + l) + l), as `vertex/doubled`;
/// - `gs-degenerate`: 12·v + i·(3t + 3e);
/// - `gs-line`: 12·v + i·(3t + 2e);
/// - `gs-adjacency`: 12·v + i·6t;
/// - `gs-per-triangle`: 12·v + i·3t.
#[must_use]
pub fn native_bytes(technique: Technique, mesh: &RegionMesh) -> NativeBytes {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangle_count());
    let (edges, loops) = (mesh.boundary_edge_count(), mesh.boundary_loops.len());
    let index_size = if has_short_indices(technique, vertices) {
        2
    } else {
        4
    };
    let vertex_size = if technique == Technique::VsControl {
        32
    } else {
        12
    };
    let indices = match technique {
        Technique::VsControl => 6 * triangles + 2 * (edges + loops) + loops,
        Technique::GsDegenerate => 3 * triangles + 3 * edges,
        Technique::GsLine => 3 * triangles + 2 * edges,
        Technique::GsAdjacency => 6 * triangles,
        Technique::GsPerTriangle => 3 * triangles,
    };
    NativeBytes {
        vertex_bytes: (vertex_size * vertices) as u64,
        index_bytes: (index_size * indices) as u64,
    }
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegionSlice {
    pub(crate) fixed: FixedPoint,
    /// In stored vertices: two per mesh vertex with `vs-control`.
    pub(crate) first_vertex: u32,
    pub(crate) short_indices: bool,
    /// In indices of the region's width: caps, or all there is.
    pub(crate) first_index: u32,
    pub(crate) index_count: u32,
    /// Walls, where they are drawn on their own.
    pub(crate) first_wall_index: u32,
    pub(crate) wall_index_count: u32,
}

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default)]
pub(crate) struct SceneGeometry {
    /// 16-byte vertices with `vs-control`, else 12-byte ones, as words.
    pub(crate) vertices: Vec<i32>,
    pub(crate) short_indices: Vec<u16>,
    pub(crate) long_indices: Vec<u32>,
    pub(crate) regions: Vec<RegionSlice>,
}

impl SceneGeometry {
    /// Lays out every mesh.
    pub(crate) fn build(technique: Technique, meshes: &[RegionMesh]) -> Self {
        let mut geometry = Self::default();
        for mesh in meshes {
            geometry.push(technique, mesh);
        }
        geometry
    }

    /// Stored vertices.
    pub(crate) fn vertex_count(&self, technique: Technique) -> usize {
        self.vertices.len() / words_per_vertex(technique)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn push(&mut self, technique: Technique, mesh: &RegionMesh) {
        let fixed = FixedPoint::for_mesh(mesh);
        let first_vertex = self.vertex_count(technique) as u32;
        for vertex in &mesh.vertices_ecef {
            let stored = fixed.quantize(*vertex).to_array();
            if technique == Technique::VsControl {
                for flag in [0, 1] {
                    self.vertices.extend(stored);
                    self.vertices.push(flag);
                }
            } else {
                self.vertices.extend(stored);
            }
        }
        let short = has_short_indices(technique, mesh.vertex_count());
        let first_index = self.index_count(short);
        match technique {
            Technique::VsControl => self.push_doubled_caps(short, mesh),
            Technique::GsAdjacency => {
                for index in with_neighbours(mesh) {
                    self.push_index(short, index);
                }
            }
            _ => {
                for &corner in mesh.triangles.as_flattened() {
                    self.push_index(short, corner);
                }
            }
        }
        if technique == Technique::GsDegenerate {
            for [a, b] in boundary_edges(mesh) {
                for corner in [a, b, b] {
                    self.push_index(short, corner);
                }
            }
        }
        let first_wall_index = self.index_count(short);
        match technique {
            Technique::VsControl => self.push_wall_strips(short, mesh),
            Technique::GsLine => {
                for index in boundary_edges(mesh).flatten() {
                    self.push_index(short, index);
                }
            }
            _ => {}
        }
        self.regions.push(RegionSlice {
            fixed,
            first_vertex,
            short_indices: short,
            first_index,
            index_count: first_wall_index - first_index,
            first_wall_index,
            wall_index_count: self.index_count(short) - first_wall_index,
        });
    }

    /// All of the top, then all of the bottom, so that the bottom may be left out of a draw.
    fn push_doubled_caps(&mut self, short: bool, mesh: &RegionMesh) {
        for corner in mesh.triangles.as_flattened() {
            self.push_index(short, 2 * corner);
        }
        for &[a, b, c] in &mesh.triangles {
            for corner in [a, c, b] {
                self.push_index(short, 2 * corner + 1);
            }
        }
    }

    fn push_wall_strips(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            for &vertex in ring.iter().chain(ring.first()) {
                self.push_index(short, 2 * vertex);
                self.push_index(short, 2 * vertex + 1);
            }
            self.push_index(short, u32::MAX);
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "short indices are below 2^16 by choice of width, or the restart value"
    )]
    fn push_index(&mut self, short: bool, index: u32) {
        if short {
            self.short_indices.push(index as u16);
        } else {
            self.long_indices.push(index);
        }
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn index_count(&self, short: bool) -> u32 {
        if short {
            self.short_indices.len() as u32
        } else {
            self.long_indices.len() as u32
        }
    }

    /// Bytes as built.
    pub(crate) fn bytes(&self) -> NativeBytes {
        NativeBytes {
            vertex_bytes: self.vertices.len() as u64 * 4,
            index_bytes: self.short_indices.len() as u64 * 2 + self.long_indices.len() as u64 * 4,
        }
    }
}

fn words_per_vertex(technique: Technique) -> usize {
    if technique == Technique::VsControl {
        4
    } else {
        3
    }
}

/// Edges of the boundary, inside on the left.
fn boundary_edges(mesh: &RegionMesh) -> impl Iterator<Item = [u32; 2]> {
    mesh.boundary_loops.iter().flat_map(|ring| {
        let ends = ring.iter().skip(1).chain(ring.first());
        ring.iter().zip(ends).map(|(&a, &b)| [a, b])
    })
}

/// Corners of each triangle, and after each the neighbour's corner across the side that follows.
/// Where a wall stands on the side there is the triangle's own opposite corner, which no neighbour
/// across it has.
fn with_neighbours(mesh: &RegionMesh) -> Vec<u32> {
    let mut opposite_of = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for [from, to, opposite] in [[a, b, c], [b, c, a], [c, a, b]] {
            opposite_of.insert([from, to], opposite);
        }
    }
    let walls: HashSet<[u32; 2]> = boundary_edges(mesh).collect();
    let across = |from: u32, to: u32, opposite: u32| {
        if walls.contains(&[from, to]) {
            return opposite;
        }
        // A side with neither wall nor neighbour is no mesh's; an end of the side says "no wall".
        opposite_of.get(&[to, from]).copied().unwrap_or(from)
    };
    mesh.triangles
        .iter()
        .flat_map(|&[a, b, c]| [a, across(a, b, c), b, across(b, c, a), c, across(c, a, b)])
        .collect()
}
