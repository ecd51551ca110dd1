// SPDX-License-Identifier: MIT OR Apache-2.0
//! How meshes lie in GPU buffers, and what that costs in bytes, by formula and as built.
//!
//! Indices are 16 bits where a region's vertices fit and 32 where they do not, region by region.

use glam::{DVec3, IVec3};
use terrafill_core::RegionMesh;
use terrafill_frame::{FixedPoint, PositionFormat};

/// Where duplicated vertices come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Layout {
    /// Every vertex stored twice, 16 bytes each: position and a flag that sends the copy to the
    /// bottom cap. Both caps and the walls are indexed; walls are strips.
    #[default]
    Doubled,
    /// Every vertex stored once, 12 bytes; the shader works out the rest from `vertex_index`.
    Pulled,
}

impl Layout {
    /// Name in variants and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Doubled => "doubled",
            Self::Pulled => "pulled",
        }
    }
}

/// Bytes of one or more regions in one layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LayoutBytes {
    /// Positions and flags.
    pub vertex_bytes: u64,
    /// Indices.
    pub index_bytes: u64,
}

impl LayoutBytes {
    /// Both.
    #[must_use]
    pub fn total(self) -> u64 {
        self.vertex_bytes + self.index_bytes
    }
}

impl std::iter::Sum for LayoutBytes {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            vertex_bytes: sum.vertex_bytes + part.vertex_bytes,
            index_bytes: sum.index_bytes + part.index_bytes,
        })
    }
}

/// Largest number of distinct indices in 16 bits: 0xffff restarts strips and separates loops.
const MAX_SHORT_INDICES: usize = 0xffff;

/// Whether a region's indices fit 16 bits.
fn has_short_indices(layout: Layout, vertices: usize) -> bool {
    match layout {
        Layout::Doubled => 2 * vertices <= MAX_SHORT_INDICES,
        Layout::Pulled => vertices <= MAX_SHORT_INDICES,
    }
}

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges in *l*
/// loops and *i* bytes an index:
///
/// - `doubled`: 2·16·v + i·(6t + 2(e + l) + l), the strips closed and followed by a restart;
/// - `pulled`: 12·v + i·(3t + e + 2l), the loops closed and followed by a separator.
#[must_use]
pub fn layout_bytes(layout: Layout, mesh: &RegionMesh) -> LayoutBytes {
    let (vertices, triangles) = (mesh.vertices_ecef.len(), mesh.triangles.len());
    let (edges, loops) = (mesh.boundary_edge_count(), mesh.boundary_loops.len());
    let index_size: usize = if has_short_indices(layout, vertices) {
        2
    } else {
        4
    };
    let (vertex_bytes, indices) = match layout {
        Layout::Doubled => (32 * vertices, 6 * triangles + 2 * (edges + loops) + loops),
        Layout::Pulled => (12 * vertices, 3 * triangles + edges + 2 * loops),
    };
    LayoutBytes {
        vertex_bytes: vertex_bytes as u64,
        index_bytes: (indices * index_size) as u64,
    }
}

/// Bytes of a mesh whose vertices are shared by all its triangles: what a geometry shader reads.
/// Cozzi (2007): California with 1,056 vertices of 24 bytes and 3,321 16-bit indices, 31,986 bytes.
#[must_use]
pub fn shared_mesh_bytes(vertices: u64, vertex_size: u64, indices: u64, index_size: u64) -> u64 {
    vertices * vertex_size + indices * index_size
}

/// Bytes of one closed volume per triangle over doubled vertices. Per triangle 18 indices: two caps
/// of 3 and three walls of 4. Cozzi (2007): the same California, 90,540 bytes.
#[must_use]
pub fn per_triangle_volume_bytes(
    vertices: u64,
    vertex_size: u64,
    triangles: u64,
    index_size: u64,
) -> u64 {
    2 * vertices * vertex_size + triangles * (2 * 3 + 3 * 4) * index_size
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegionSlice {
    pub(crate) fixed: FixedPoint,
    /// In stored vertices: two per mesh vertex when doubled.
    pub(crate) first_vertex: u32,
    pub(crate) short_indices: bool,
    /// In indices of the region's width.
    pub(crate) first_triangle_index: u32,
    pub(crate) triangle_count: u32,
    pub(crate) first_loop_index: u32,
    /// Indices of the strips, or entries of the loop list.
    pub(crate) loop_index_count: u32,
}

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default)]
pub(crate) struct SceneGeometry {
    /// 16-byte vertices when doubled, 12-byte ones when pulled, as words.
    pub(crate) vertices: Vec<i32>,
    pub(crate) short_indices: Vec<u16>,
    pub(crate) long_indices: Vec<u32>,
    pub(crate) regions: Vec<RegionSlice>,
}

impl SceneGeometry {
    /// Lays out every mesh.
    pub(crate) fn build(layout: Layout, format: PositionFormat, meshes: &[RegionMesh]) -> Self {
        let mut geometry = Self::default();
        for mesh in meshes {
            geometry.push(layout, format, mesh);
        }
        geometry
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn push(&mut self, layout: Layout, format: PositionFormat, mesh: &RegionMesh) {
        let fixed = FixedPoint::for_mesh(mesh);
        let words_per_vertex = if layout == Layout::Doubled { 4 } else { 3 };
        let first_vertex = (self.vertices.len() / words_per_vertex) as u32;
        for vertex in &mesh.vertices_ecef {
            let stored = store(&fixed, format, *vertex).to_array();
            match layout {
                Layout::Doubled => {
                    for flag in [0, 1] {
                        self.vertices.extend(stored);
                        self.vertices.push(flag);
                    }
                }
                Layout::Pulled => self.vertices.extend(stored),
            }
        }
        let short_indices = has_short_indices(layout, mesh.vertices_ecef.len());
        let first_triangle_index = self.index_count(short_indices);
        self.push_caps(layout, short_indices, mesh);
        let first_loop_index = self.index_count(short_indices);
        self.push_loops(layout, short_indices, mesh);
        self.regions.push(RegionSlice {
            fixed,
            first_vertex,
            short_indices,
            first_triangle_index,
            triangle_count: mesh.triangles.len() as u32,
            first_loop_index,
            loop_index_count: self.index_count(short_indices) - first_loop_index,
        });
    }

    fn push_caps(&mut self, layout: Layout, short: bool, mesh: &RegionMesh) {
        // All of the top, then all of the bottom, so that the bottom may be left out of a draw.
        for corner in mesh.triangles.as_flattened() {
            self.push_index(
                short,
                match layout {
                    Layout::Doubled => 2 * corner,
                    Layout::Pulled => *corner,
                },
            );
        }
        if layout == Layout::Doubled {
            for &[a, b, c] in &mesh.triangles {
                for corner in [a, c, b] {
                    self.push_index(short, 2 * corner + 1);
                }
            }
        }
    }

    fn push_loops(&mut self, layout: Layout, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            for &vertex in ring.iter().chain(ring.first()) {
                match layout {
                    Layout::Doubled => {
                        self.push_index(short, 2 * vertex);
                        self.push_index(short, 2 * vertex + 1);
                    }
                    Layout::Pulled => self.push_index(short, vertex),
                }
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
    pub(crate) fn bytes(&self) -> LayoutBytes {
        LayoutBytes {
            vertex_bytes: self.vertices.len() as u64 * 4,
            index_bytes: self.short_indices.len() as u64 * 2 + self.long_indices.len() as u64 * 4,
        }
    }
}

#[allow(
    clippy::cast_possible_wrap,
    reason = "the bits of a float are carried in an integer attribute"
)]
fn store(fixed: &FixedPoint, format: PositionFormat, ecef: DVec3) -> IVec3 {
    match format {
        PositionFormat::Fixed => fixed.quantize(ecef),
        PositionFormat::LocalF32 => {
            let local = (ecef - fixed.origin_ecef).as_vec3();
            IVec3::from_array(local.to_array().map(|value| value.to_bits() as i32))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::{Ellipsoid, Extent, Geodetic};

    /// A fan of `count` boundary vertices around one interior vertex.
    fn disc(count: u32) -> RegionMesh {
        let body = Ellipsoid::WGS84;
        let place = |i: u32| {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            [10.0 + angle.cos(), 50.0 + angle.sin()]
        };
        let mut vertices_deg: Vec<_> = (0..count).map(place).collect();
        vertices_deg.push([10.0, 50.0]);
        RegionMesh {
            region_index: 0,
            name: "disc".to_owned(),
            vertices_ecef: vertices_deg
                .iter()
                .map(|d| body.geodetic_to_ecef(Geodetic::from_degrees(d[0], d[1], 0.0)))
                .collect(),
            vertices_deg,
            triangles: (0..count).map(|i| [i, (i + 1) % count, count]).collect(),
            boundary_loops: vec![(0..count).collect()],
            holes: 0,
            area_m2: 1.0,
            extent: Extent {
                west_deg: 9.0,
                south_deg: 49.0,
                east_deg: 11.0,
                north_deg: 51.0,
            },
            boundary_deviation_m: 0.0,
            cap_sagitta_m: 1000.0,
            warnings: Vec::new(),
        }
    }

    #[test]
    fn the_formula_and_the_buffers_agree() {
        for count in [3, 100, 32_765, 32_767, 40_000, 65_534, 65_600] {
            let mesh = disc(count);
            for layout in [Layout::Doubled, Layout::Pulled] {
                for format in [PositionFormat::Fixed, PositionFormat::LocalF32] {
                    let meshes = std::slice::from_ref(&mesh);
                    let built = SceneGeometry::build(layout, format, meshes).bytes();
                    assert_eq!(built, layout_bytes(layout, &mesh), "{layout:?} {count}");
                }
            }
        }
    }

    #[test]
    fn no_index_collides_with_the_restart_value() {
        for count in [32_766, 65_533, 65_534] {
            let mesh = disc(count);
            for layout in [Layout::Doubled, Layout::Pulled] {
                let meshes = std::slice::from_ref(&mesh);
                let geometry = SceneGeometry::build(layout, PositionFormat::Fixed, meshes);
                let restarts = geometry
                    .short_indices
                    .iter()
                    .filter(|&&i| i == 0xffff)
                    .count();
                let long = geometry
                    .long_indices
                    .iter()
                    .filter(|&&i| i == u32::MAX)
                    .count();
                assert_eq!(restarts + long, 1, "{layout:?} {count}");
            }
        }
    }

    #[test]
    fn the_2007_documents_arithmetic() {
        assert_eq!(shared_mesh_bytes(1_056, 24, 3_321, 2), 31_986);
        assert_eq!(per_triangle_volume_bytes(1_056, 24, 3_321 / 3, 2), 90_540);
        // Twins: another vertex size or index width does not reproduce the document.
        assert_ne!(shared_mesh_bytes(1_056, 20, 3_321, 2), 31_986);
        assert_ne!(per_triangle_volume_bytes(1_056, 24, 3_321 / 3, 4), 90_540);
    }

    #[test]
    fn a_doubled_vertex_is_stored_twice_and_flagged_once() {
        let meshes = [disc(3)];
        let geometry = SceneGeometry::build(Layout::Doubled, PositionFormat::Fixed, &meshes);
        for pair in geometry.vertices.chunks(8) {
            assert_eq!(pair[..3], pair[4..7]);
            assert_eq!((pair[3], pair[7]), (0, 1));
        }
    }
}
