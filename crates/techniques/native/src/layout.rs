// SPDX-License-Identifier: MIT OR Apache-2.0
//! How meshes lie in GPU buffers, and what that costs in bytes, by formula and as built.
//!
//! Indices are 16 bits where a region's vertices fit and 32 where they do not, region by region.

use crate::neighbours::{Neighbours, Side};
use crate::ring_order::RingOrder;
use crate::strips::{StripCorner, Strips};
use crate::{Extrusion, Indices, NativeVariant, StripCounts, strip_counts};
use std::borrow::{Borrow, Cow};
use terrafill_contract::GeometryBytes;
use terrafill_core::{RegionMesh, index_u32};
use terrafill_plan::PartOrder;
use terrafill_stencil::{FixedPoint, IndexLists, VolumePlace};

/// Whether a region's indices fit 16 bits. Strips end with 0xffff, so that it is no vertex.
fn has_short_indices(technique: Extrusion, indices: Indices, vertices: usize) -> bool {
    match (technique, indices) {
        (Extrusion::VsControl, _) => 2 * vertices <= 0xffff,
        (Extrusion::GsLine, _) | (_, Indices::Strip) => vertices <= 0xffff,
        _ => IndexLists::are_short(vertices),
    }
}

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges in *l*
/// loops and *i* bytes an index:
///
/// - `vs-control`: 2·16·v + i·(6t + 2(e + l) + l), as `vertex/doubled`;
/// - `gs-degenerate`: 12·v + i·(3t + 3e);
/// - `gs-two-edges`: 12·v + i·(3t + 3p), *p* the pairs and what is left over of each loop: from
///   ½e, where every loop pairs up, to e;
/// - `gs-line`: 12·v + i·(3t + e + 2l), the strips closed and followed by a restart;
/// - `gs-adjacency`: 12·v + i·6t;
/// - `gs-per-triangle`: 12·v + i·3t.
///
/// With *s* strips in which *w* corners are said again, each followed by a restart:
///
/// - `gs-degenerate` in strips: 12·v + i·(t + 2s + w + s + 2e + l + l), a triangle of the cap at
///   one index, an edge of the boundary at two;
/// - `gs-adjacency` in strips: 12·v + i·(2(t + 2s + w) + s), two indices a triangle, and none for
///   an edge.
#[must_use]
pub fn native_bytes(technique: Extrusion, indices: Indices, mesh: &RegionMesh) -> GeometryBytes {
    bytes_with(technique, indices, mesh, || strip_counts(mesh))
}

/// The same of every technique by its name, and with `/list` after it where lists are a choice that
/// is not its default. Strips are found once.
#[must_use]
pub fn native_layouts(mesh: &RegionMesh) -> Vec<(String, GeometryBytes)> {
    let counts = strip_counts(mesh);
    let bytes = |technique, indices| bytes_with(technique, indices, mesh, || counts);
    let mut layouts = Vec::new();
    for technique in Extrusion::ALL {
        let name = technique.name().to_owned();
        layouts.push((name, bytes(technique, technique.default_indices())));
        if technique.has_index_choice() {
            let name = format!("{}/{}", technique.name(), Indices::List.name());
            layouts.push((name, bytes(technique, Indices::List)));
        }
    }
    layouts
}

fn bytes_with(
    technique: Extrusion,
    indices: Indices,
    mesh: &RegionMesh,
    strips: impl FnOnce() -> StripCounts,
) -> GeometryBytes {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangle_count());
    let (edges, loops) = (mesh.boundary_edge_count(), mesh.boundary_loops.len());
    let indices = technique.indices(indices);
    let index_size = if has_short_indices(technique, indices, vertices) {
        2
    } else {
        4
    };
    let vertex_size = if technique == Extrusion::VsControl {
        32
    } else {
        12
    };
    let index_count = match (technique, indices) {
        (Extrusion::GsDegenerate, Indices::Strip) => {
            let counts = strips();
            counts.corners() + counts.strips + 2 * (edges + loops)
        }
        (Extrusion::GsAdjacency, Indices::Strip) => {
            let counts = strips();
            2 * counts.corners() + counts.strips
        }
        (Extrusion::VsControl, _) => 6 * triangles + 2 * (edges + loops) + loops,
        (Extrusion::GsDegenerate, _) => 3 * triangles + 3 * edges,
        (Extrusion::GsTwoEdges, _) => 3 * triangles + 3 * edges_in_pairs(mesh).count(),
        (Extrusion::GsLine, _) => 3 * triangles + edges + 2 * loops,
        (Extrusion::GsAdjacency, _) => 6 * triangles,
        (Extrusion::GsPerTriangle, _) => 3 * triangles,
    };
    GeometryBytes {
        vertex_bytes: (vertex_size * vertices) as u64,
        index_bytes: (index_size * index_count) as u64,
    }
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegionSlice {
    /// Vertices are counted as stored: two per mesh vertex with `vs-control`. Triangles, which no shader counts here,
    /// are not.
    pub(crate) place: VolumePlace,
    pub(crate) vertex_count: u32,
    /// Its bottom cap can be drawn: its indices are stored, or a geometry shader needs none.
    pub(crate) has_bottom: bool,
    /// Indices of caps, or all there is.
    pub(crate) index_count: u32,
    /// Those of walls, where they are drawn on their own.
    pub(crate) wall_index_count: u32,
}

impl RegionSlice {
    /// Where `other` lies when it takes this one's place; `None` where it has more or fewer vertices
    /// or indices.
    pub(crate) fn replaced_by(&self, other: &Self) -> Option<Self> {
        let counts = |slice: &Self| {
            let indices = [slice.index_count, slice.wall_index_count];
            let has = [slice.place.has_short_indices, slice.has_bottom];
            (slice.vertex_count, indices, has)
        };
        let place = VolumePlace {
            fixed: other.place.fixed,
            ..self.place
        };
        (counts(self) == counts(other)).then_some(Self { place, ..*self })
    }
}

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct SceneGeometry {
    /// 16-byte vertices with `vs-control`, else 12-byte ones, as words.
    pub(crate) vertices: Vec<i32>,
    pub(crate) indices: IndexLists,
    pub(crate) regions: Vec<RegionSlice>,
}

impl SceneGeometry {
    /// Lays out every mesh.
    ///
    /// - `has_bottom`: of which ones, by their place, bottom caps are stored, where a technique stores any
    pub(crate) fn build(
        variant: &NativeVariant,
        meshes: &[impl Borrow<RegionMesh>],
        has_bottom: impl Fn(usize) -> bool,
    ) -> Self {
        let technique = variant.technique;
        let mut geometry = Self::default();
        for (place, mesh) in meshes.iter().enumerate() {
            let mesh: &RegionMesh = mesh.borrow();
            let has_bottom = has_bottom(place) || technique.needs_geometry_shader();
            let order = variant.parts.then(|| PartOrder::of(mesh)).flatten();
            let mesh = order.map_or(Cow::Borrowed(mesh), |order| {
                let mut ordered = mesh.clone();
                ordered.triangles = order.ordered(mesh);
                Cow::Owned(ordered)
            });
            geometry.push(
                technique,
                technique.indices(variant.indices()),
                &mesh,
                has_bottom,
            );
        }
        geometry
    }

    /// Puts what `other` has behind its own.
    pub(crate) fn append(&mut self, technique: Extrusion, other: &Self) {
        let first_vertex = self.vertex_count(technique);
        let first_vertex = u32::try_from(first_vertex).unwrap_or(u32::MAX);
        let [long, short] = [false, true].map(|is_short| self.indices.count(is_short));
        self.vertices.extend(&other.vertices);
        self.indices.append(&other.indices);
        let moved = other.regions.iter().map(|slice| {
            let is_short = slice.place.has_short_indices;
            let by = if is_short { short } else { long };
            let place = slice.place.moved(first_vertex, by, by);
            RegionSlice { place, ..*slice }
        });
        self.regions.extend(moved);
    }

    /// Stored vertices.
    pub(crate) fn vertex_count(&self, technique: Extrusion) -> usize {
        self.vertices.len() / words_per_vertex(technique)
    }

    fn push(
        &mut self,
        technique: Extrusion,
        indices: Indices,
        mesh: &RegionMesh,
        has_bottom: bool,
    ) {
        let fixed = FixedPoint::for_mesh(mesh);
        let first_vertex = index_u32(self.vertex_count(technique));
        let ring_order = (technique == Extrusion::GsPerTriangle).then(|| RingOrder::new(mesh));
        for place in 0..mesh.vertex_count() {
            let vertex = ring_order
                .as_ref()
                .map_or(place, |order| order.vertices[place] as usize);
            let stored = fixed.quantize(mesh.vertices_ecef[vertex]).to_array();
            if technique == Extrusion::VsControl {
                for flag in [0, 1] {
                    self.vertices.extend(stored);
                    self.vertices.push(flag);
                }
            } else {
                self.vertices.extend(stored);
            }
        }
        let short = has_short_indices(technique, indices, mesh.vertex_count());
        let first_index = self.indices.count(short);
        match (technique, indices) {
            (Extrusion::GsDegenerate, Indices::Strip) => {
                self.push_strips(short, mesh, |corner| [Some(corner.vertex), None]);
                self.push_edge_strips(short, mesh);
            }
            (Extrusion::GsAdjacency, Indices::Strip) => {
                let with_beside = |corner: &StripCorner| [Some(corner.vertex), Some(corner.beside)];
                self.push_strips(short, mesh, with_beside);
            }
            (Extrusion::VsControl, _) => {
                let triangles = &mesh.triangles;
                self.indices.push_doubled_caps(short, triangles, has_bottom);
            }
            (Extrusion::GsAdjacency, _) => self.indices.extend(short, with_neighbours(mesh)),
            (Extrusion::GsTwoEdges, _) => {
                let caps = mesh
                    .triangles
                    .iter()
                    .map(|&corners| smallest_first(corners));
                let inputs = caps.chain(edges_in_pairs(mesh));
                self.indices.extend(short, inputs.flatten());
            }
            (Extrusion::GsDegenerate, _) => {
                let walls = mesh.boundary_edges().map(|[a, b]| [a, b, b]);
                let inputs = mesh.triangles.iter().copied().chain(walls);
                self.indices.extend(short, inputs.flatten());
            }
            (Extrusion::GsLine | Extrusion::GsPerTriangle, _) => {
                let triangles = ring_order
                    .as_ref()
                    .map_or(&mesh.triangles, |order| &order.triangles);
                let corners = triangles.as_flattened().iter();
                self.indices.extend(short, corners.copied());
            }
        }
        let first_wall_index = self.indices.count(short);
        match technique {
            Extrusion::VsControl => self.indices.push_doubled_strips(short, mesh),
            Extrusion::GsLine => self.indices.push_loops(short, mesh),
            _ => {}
        }
        self.regions.push(RegionSlice {
            place: VolumePlace {
                fixed,
                first_vertex,
                first_triangle_index: first_index,
                first_loop_index: first_wall_index,
                triangle_count: 0,
                has_short_indices: short,
            },
            vertex_count: index_u32(self.vertex_count(technique)) - first_vertex,
            has_bottom,
            index_count: first_wall_index - first_index,
            wall_index_count: self.indices.count(short) - first_wall_index,
        });
    }

    /// The caps' triangles in strips, each followed by a restart.
    fn push_strips(
        &mut self,
        short: bool,
        mesh: &RegionMesh,
        indices_of: impl Fn(&StripCorner) -> [Option<u32>; 2],
    ) {
        for strip in Strips::over(&Neighbours::of(mesh)).iter() {
            let corners = strip.iter().flat_map(&indices_of).flatten();
            self.indices.extend(short, corners.chain([u32::MAX]));
        }
    }

    /// Loops as strips a b b c c … a a. The triangle (a, b, b) is the edge from a to b, as in a list;
    /// in (b, b, c) between two of them, whichever way strips turn it, the last two differ.
    fn push_edge_strips(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            let Some((&first, others)) = ring.split_first() else {
                continue;
            };
            let twice = others
                .iter()
                .chain([&first])
                .flat_map(|&vertex| [vertex; 2]);
            let strip = std::iter::once(first).chain(twice).chain([u32::MAX]);
            self.indices.extend(short, strip);
        }
    }

    /// Bytes as built.
    pub(crate) fn bytes(&self) -> GeometryBytes {
        GeometryBytes {
            vertex_bytes: self.vertices.len() as u64 * 4,
            index_bytes: self.indices.bytes(),
        }
    }
}

/// Words of a stored vertex.
pub(crate) fn words_per_vertex(technique: Extrusion) -> usize {
    if technique == Extrusion::VsControl {
        4
    } else {
        3
    }
}

/// The same triangle, beginning with its smallest number.
fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Edges of the boundary: a → b → c as (b, c, a), or a → b as (a, b, b) where a pair would begin with
/// its smallest number like a triangle, or go back to where it came from, and where no second edge
/// is left.
fn edges_in_pairs(mesh: &RegionMesh) -> impl Iterator<Item = [u32; 3]> {
    mesh.boundary_loops.iter().flat_map(|ring| {
        let at = |place: usize| ring[place % ring.len()];
        let mut inputs = Vec::new();
        let mut place = 0;
        while place < ring.len() {
            let [a, b, c] = [at(place), at(place + 1), at(place + 2)];
            let is_pair = place + 1 < ring.len() && a != c && b > a.min(c);
            if is_pair {
                inputs.push([b, c, a]);
                place += 2;
            } else {
                inputs.push([a, b, b]);
                place += 1;
            }
        }
        inputs
    })
}

/// Corners of each triangle, and after each what lies across the side that follows.
fn with_neighbours(mesh: &RegionMesh) -> Vec<u32> {
    let neighbours = Neighbours::of(mesh);
    let sides = (0..mesh.triangles.len()).flat_map(|t| [0, 1, 2].map(|number| (t, number)));
    sides
        .flat_map(|(triangle, number)| {
            let side = Side { triangle, number };
            [
                neighbours.corner(triangle, number),
                neighbours.told_across(side),
            ]
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests;
