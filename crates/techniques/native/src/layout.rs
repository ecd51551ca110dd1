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
use terrafill_core::RegionMesh;
use terrafill_plan::{PartOrder, RegionSet};
use terrafill_stencil::{FixedPoint, IndexLists, LaidOut, VolumePlace};

/// Whether a region's indices fit 16 bits. Strips end with 0xffff, so that it is no vertex.
fn has_short_indices(technique: Extrusion, indices: Indices, vertices: usize) -> bool {
    match (technique, indices) {
        (Extrusion::VsControl, _) => 2 * vertices <= 0xffff,
        (Extrusion::GsLine, _) | (_, Indices::Strip) => vertices <= 0xffff,
        _ => vertices <= 0x1_0000,
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
    pub(crate) fixed: FixedPoint,
    /// In stored vertices: two per mesh vertex with `vs-control`.
    pub(crate) first_vertex: u32,
    pub(crate) vertex_count: u32,
    /// Its bottom cap can be drawn: its indices are stored, or a geometry shader needs none.
    pub(crate) has_bottom: bool,
    pub(crate) short_indices: bool,
    /// In indices of the region's width: caps, or all there is.
    pub(crate) first_index: u32,
    pub(crate) index_count: u32,
    /// Walls, where they are drawn on their own.
    pub(crate) first_wall_index: u32,
    pub(crate) wall_index_count: u32,
}

impl RegionSlice {
    /// Where `other` lies when it takes this one's place; `None` where it has more or fewer vertices
    /// or indices.
    pub(crate) fn replaced_by(&self, other: &Self) -> Option<Self> {
        let counts = |slice: &Self| {
            let indices = [slice.index_count, slice.wall_index_count];
            let has = [slice.short_indices, slice.has_bottom];
            (slice.vertex_count, indices, has)
        };
        let fixed = other.fixed;
        (counts(self) == counts(other)).then_some(Self { fixed, ..*self })
    }

    /// As shaders are told; none here counts triangles.
    pub(crate) fn place(&self) -> VolumePlace {
        VolumePlace {
            fixed: self.fixed,
            first_vertex: self.first_vertex,
            first_triangle_index: self.first_index,
            first_loop_index: self.first_wall_index,
            triangle_count: 0,
            has_short_indices: self.short_indices,
        }
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
            let order = PartOrder::of(mesh).filter(|_| variant.parts);
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

    /// As [`SceneGeometry::build`], of meshes of which a view brings some; those of the view before are not laid
    /// out again.
    pub(crate) fn of_held(
        variant: &NativeVariant,
        meshes: &RegionSet,
        has_bottom: impl Fn(usize) -> bool,
        laid_out: &mut LaidOut<bool, Self>,
    ) -> Self {
        let mut geometry = Self::default();
        let lay_out =
            |place: usize| Self::build(variant, &meshes[place..=place], |_| has_bottom(place));
        let append = |part: &Self| geometry.append(variant.technique, part);
        laid_out.append_all(meshes, &has_bottom, lay_out, append);
        geometry
    }

    /// Puts what `other` has behind its own.
    fn append(&mut self, technique: Extrusion, other: &Self) {
        let first_vertex = self.vertex_count(technique);
        let first_vertex = u32::try_from(first_vertex).unwrap_or(u32::MAX);
        let [long, short] = [false, true].map(|is_short| self.indices.count(is_short));
        self.vertices.extend(&other.vertices);
        self.indices.append(&other.indices);
        let moved = other.regions.iter().map(|slice| {
            let by = if slice.short_indices { short } else { long };
            RegionSlice {
                first_vertex: slice.first_vertex + first_vertex,
                first_index: slice.first_index + by,
                first_wall_index: slice.first_wall_index + by,
                ..*slice
            }
        });
        self.regions.extend(moved);
    }

    /// Stored vertices.
    pub(crate) fn vertex_count(&self, technique: Extrusion) -> usize {
        self.vertices.len() / words_per_vertex(technique)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn push(
        &mut self,
        technique: Extrusion,
        indices: Indices,
        mesh: &RegionMesh,
        has_bottom: bool,
    ) {
        let fixed = FixedPoint::for_mesh(mesh);
        let first_vertex = self.vertex_count(technique) as u32;
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
            (Extrusion::VsControl, _) => self.push_doubled_caps(short, mesh, has_bottom),
            (Extrusion::GsAdjacency, _) => {
                for index in with_neighbours(mesh) {
                    self.indices.push(short, index);
                }
            }
            (Extrusion::GsTwoEdges, _) => {
                let caps = mesh
                    .triangles
                    .iter()
                    .map(|&corners| smallest_first(corners));
                for corner in caps.chain(edges_in_pairs(mesh)).flatten() {
                    self.indices.push(short, corner);
                }
            }
            (Extrusion::GsDegenerate, _) => {
                let walls = mesh.boundary_edges().map(|[a, b]| [a, b, b]);
                for corner in mesh.triangles.iter().copied().chain(walls).flatten() {
                    self.indices.push(short, corner);
                }
            }
            (Extrusion::GsLine | Extrusion::GsPerTriangle, _) => {
                let triangles = ring_order
                    .as_ref()
                    .map_or(&mesh.triangles, |order| &order.triangles);
                for &corner in triangles.as_flattened() {
                    self.indices.push(short, corner);
                }
            }
        }
        let first_wall_index = self.indices.count(short);
        match technique {
            Extrusion::VsControl => self.push_wall_strips(short, mesh),
            Extrusion::GsLine => {
                for ring in &mesh.boundary_loops {
                    for &vertex in ring.iter().chain(ring.first()) {
                        self.indices.push(short, vertex);
                    }
                    self.indices.push(short, u32::MAX);
                }
            }
            _ => {}
        }
        self.regions.push(RegionSlice {
            fixed,
            first_vertex,
            vertex_count: self.vertex_count(technique) as u32 - first_vertex,
            has_bottom,
            short_indices: short,
            first_index,
            index_count: first_wall_index - first_index,
            first_wall_index,
            wall_index_count: self.indices.count(short) - first_wall_index,
        });
    }

    /// All of the top, then all of the bottom, so that the bottom may be left out of a draw.
    fn push_doubled_caps(&mut self, short: bool, mesh: &RegionMesh, has_bottom: bool) {
        for corner in mesh.triangles.as_flattened() {
            self.indices.push(short, 2 * corner);
        }
        if !has_bottom {
            return;
        }
        for &[a, b, c] in &mesh.triangles {
            for corner in [a, c, b] {
                self.indices.push(short, 2 * corner + 1);
            }
        }
    }

    fn push_wall_strips(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            for &vertex in ring.iter().chain(ring.first()) {
                self.indices.push(short, 2 * vertex);
                self.indices.push(short, 2 * vertex + 1);
            }
            self.indices.push(short, u32::MAX);
        }
    }

    /// The caps' triangles in strips, each followed by a restart.
    fn push_strips(
        &mut self,
        short: bool,
        mesh: &RegionMesh,
        indices_of: impl Fn(&StripCorner) -> [Option<u32>; 2],
    ) {
        for strip in Strips::over(&Neighbours::of(mesh)).iter() {
            for index in strip.iter().flat_map(&indices_of).flatten() {
                self.indices.push(short, index);
            }
            self.indices.push(short, u32::MAX);
        }
    }

    /// Loops as strips a b b c c … a a. The triangle (a, b, b) is the edge from a to b, as in a list;
    /// in (b, b, c) between two of them, whichever way strips turn it, the last two differ.
    fn push_edge_strips(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            let Some((&first, others)) = ring.split_first() else {
                continue;
            };
            self.indices.push(short, first);
            for &vertex in others.iter().chain([&first]) {
                self.indices.push(short, vertex);
                self.indices.push(short, vertex);
            }
            self.indices.push(short, u32::MAX);
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
pub(crate) mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use terrafill_fixtures::by_hand::{circle_deg, mesh};
    use terrafill_fixtures::check_held_layouts;
    use terrafill_scene::Scene;

    fn built(technique: Extrusion, indices: Indices, meshes: &[RegionMesh]) -> SceneGeometry {
        let variant = NativeVariant {
            technique,
            indices: Some(indices),
            ..NativeVariant::default()
        };
        SceneGeometry::build(&variant, meshes, |_| true)
    }

    /// A ring of `count` vertices on each of two circles, and the triangles between them: a disc
    /// with a hole, every vertex on the boundary.
    pub(crate) fn annulus(count: u32) -> RegionMesh {
        let vertices_deg = [circle_deg(count, 1.0), circle_deg(count, 0.5)].concat();
        let next = |i: u32| (i + 1) % count;
        let between = |i: u32| {
            [
                [i, next(i), count + i],
                [next(i), count + next(i), count + i],
            ]
        };
        let loops = vec![(0..count).collect(), (count..2 * count).rev().collect()];
        mesh(vertices_deg, (0..count).flat_map(between).collect(), loops)
    }

    /// Triangles and loops of which only the numbers matter.
    pub(crate) fn planar(triangles: &[[u32; 3]], loops: &[&[u32]]) -> RegionMesh {
        let corners = triangles.as_flattened().iter();
        let count = corners.max().map_or(3, |largest| largest + 1);
        let mut mesh = annulus(count);
        mesh.triangles = triangles.to_vec();
        mesh.boundary_loops = loops.iter().map(|ring| ring.to_vec()).collect();
        mesh
    }

    /// Of the scenes that need no data.
    pub(crate) fn real_meshes() -> Vec<RegionMesh> {
        let meshes = |name| {
            let scene = Scene::shipped(name, None).expect("it ships");
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
                .expect("it meshes")
        };
        let names = ["california", "planet-134"].into_iter();
        names.flat_map(meshes).collect()
    }

    /// Every technique with every kind of indices that it has.
    fn storages() -> Vec<(Extrusion, Indices)> {
        let kinds = |technique: Extrusion| {
            let own = Indices::ALL.into_iter();
            own.filter(move |&indices| technique.indices(indices) == indices)
                .map(move |indices| (technique, indices))
        };
        Extrusion::ALL.into_iter().flat_map(kinds).collect()
    }

    #[test]
    fn what_a_view_before_held_is_not_laid_out_again_and_lies_as_if_it_were() {
        let variant = NativeVariant::default();
        check_held_layouts(
            [5, 40_000, 7, 4].map(annulus).to_vec(),
            |meshes, has_bottom| SceneGeometry::build(&variant, meshes, |_| has_bottom),
            |meshes, has_bottom, laid_out| {
                SceneGeometry::of_held(&variant, meshes, |_| has_bottom, laid_out)
            },
            SceneGeometry::build(&variant, &[annulus(9)], |_| true),
        );
    }

    #[test]
    fn the_formula_and_the_buffers_agree() {
        // Around the limits of 16 bits as well: 2·count vertices, and twice that when doubled.
        for count in [3, 4, 101, 16_383, 16_384, 32_767, 32_768, 32_769] {
            let mesh = annulus(count);
            let layouts = native_layouts(&mesh);
            assert_eq!(layouts.len(), storages().len());
            for (technique, indices) in storages() {
                let meshes = std::slice::from_ref(&mesh);
                let built = built(technique, indices, meshes).bytes();
                let name = (technique.name(), indices);
                let formula = native_bytes(technique, indices, &mesh);
                let key = match technique.default_indices() == indices {
                    true => technique.name().to_owned(),
                    false => format!("{}/{}", technique.name(), indices.name()),
                };
                let mut of_key = layouts.iter().filter(|(name, _)| *name == key);
                let (_, listed) = of_key.next().expect("listed");
                assert_eq!((built, built), (formula, *listed), "{name:?} {count}");
            }
        }
    }

    #[test]
    fn a_restart_is_no_vertex() {
        for count in [16_383, 16_384, 32_767, 32_768] {
            let mesh = annulus(count);
            for technique in [Extrusion::VsControl, Extrusion::GsLine] {
                let meshes = std::slice::from_ref(&mesh);
                let geometry = built(technique, Indices::List, meshes);
                let short = geometry.indices.short.iter().filter(|&&i| i == u16::MAX);
                let long = geometry.indices.long.iter().filter(|&&i| i == u32::MAX);
                let found = short.count() + long.count();
                assert_eq!(found, 2, "{} {count}", technique.name());
            }
        }
    }

    #[test]
    fn a_restart_is_no_vertex_of_a_strip_and_follows_each() {
        for count in [3, 16_383, 16_384, 32_767, 32_768] {
            let mesh = annulus(count);
            let strips = strip_counts(&mesh).strips;
            for (technique, loops) in [(Extrusion::GsDegenerate, 2), (Extrusion::GsAdjacency, 0)] {
                let meshes = std::slice::from_ref(&mesh);
                let geometry = built(technique, Indices::Strip, meshes);
                let short = geometry.indices.short.iter().filter(|&&i| i == u16::MAX);
                let long = geometry.indices.long.iter().filter(|&&i| i == u32::MAX);
                let found = short.count() + long.count();
                assert_eq!(found, strips + loops, "{} {count}", technique.name());
                let is_short = geometry.indices.long.is_empty();
                assert_eq!(is_short, 2 * count <= 0xffff, "{count}");
            }
        }
        // Of 65,535 vertices the last is 0xfffe. Twin: of one more it is 0xffff, a vertex of a list
        // like any other and no vertex of a strip.
        let is_short = |indices, count| has_short_indices(Extrusion::GsAdjacency, indices, count);
        assert!(is_short(Indices::Strip, 0xffff) && is_short(Indices::List, 0x1_0000));
        assert!(!is_short(Indices::Strip, 0x1_0000));
    }

    /// Strips between restarts.
    fn between_restarts(indices: &[u32]) -> impl Iterator<Item = &[u32]> {
        indices.split(|&index| index == u32::MAX)
    }

    /// Inputs of a geometry shader by Vulkan's "Triangle Strips"; `odd` are the places of the last two
    /// corners in every second one.
    fn strip_inputs(indices: &[u32], odd: [usize; 2]) -> Vec<[u32; 3]> {
        let of_strip = |strip: &[u32]| -> Vec<[u32; 3]> {
            let windows = strip.windows(3).enumerate();
            let inputs = windows.map(|(i, window)| {
                let [second, third] = if i % 2 == 0 { [1, 2] } else { odd };
                [window[0], window[second], window[third]]
            });
            inputs.collect()
        };
        between_restarts(indices).flat_map(of_strip).collect()
    }

    /// The same by "Triangle Strips With Adjacency".
    fn adjacent_strip_inputs(indices: &[u32]) -> Vec<[u32; 6]> {
        let of_strip = |strip: &[u32]| -> Vec<[u32; 6]> {
            let count = (strip.len().max(4) - 4) / 2;
            let inputs = (0..count).map(|i| {
                let at = 2 * i;
                let before = if i == 0 { 1 } else { at - 2 };
                let ahead = if i + 1 == count { at + 5 } else { at + 6 };
                let places = if i % 2 == 0 {
                    [at, before, at + 2, ahead, at + 4, at + 3]
                } else {
                    [at + 2, before, at, at + 3, at + 4, ahead]
                };
                places.map(|place| strip[place])
            });
            inputs.collect()
        };
        between_restarts(indices).flat_map(of_strip).collect()
    }

    /// Triangles, each from its smallest corner on, and boundary edges, all sorted.
    #[derive(Debug, PartialEq)]
    struct Made {
        caps: Vec<[u32; 3]>,
        walls: Vec<[u32; 2]>,
    }

    impl Made {
        fn of(caps: impl Iterator<Item = [u32; 3]>, walls: impl Iterator<Item = [u32; 2]>) -> Self {
            let mut caps: Vec<_> = caps.map(smallest_first).collect();
            let mut walls: Vec<_> = walls.collect();
            caps.sort_unstable();
            walls.sort_unstable();
            Self { caps, walls }
        }

        fn of_mesh(mesh: &RegionMesh) -> Self {
            Self::of(mesh.triangles.iter().copied(), mesh.boundary_edges())
        }

        /// As `degenerate.geom` does.
        fn by_degenerate(inputs: &[[u32; 3]]) -> Self {
            let is_wall = |&&[_, b, c]: &&[u32; 3]| b == c;
            let is_cap = |&&[a, b, c]: &&[u32; 3]| b != c && a != b && a != c;
            let walls = inputs.iter().filter(is_wall).map(|&[a, b, _]| [a, b]);
            Self::of(inputs.iter().filter(is_cap).copied(), walls)
        }

        /// As `adjacency.geom` does.
        fn by_adjacency(inputs: &[[u32; 6]]) -> Self {
            let drawn = || {
                inputs
                    .iter()
                    .filter(|i| i[0] != i[2] && i[2] != i[4] && i[4] != i[0])
            };
            let caps = drawn().map(|input| [input[0], input[2], input[4]]);
            let walls = drawn().flat_map(|input| {
                let sides = [(0, 1, 2, 4), (2, 3, 4, 0), (4, 5, 0, 2)].into_iter();
                let stands =
                    sides.filter(|&(_, across, _, opposite)| input[across] == input[opposite]);
                stands.map(|(from, _, to, _)| [input[from], input[to]])
            });
            Self::of(caps, walls)
        }
    }

    /// A fan, a zigzag, a hole, branches, and triangles that touch in a corner only.
    fn meshes_for_strips() -> Vec<RegionMesh> {
        let fan: Vec<[u32; 3]> = (1..7).map(|i| [0, i, i + 1]).collect();
        let star = [
            [0, 1, 2],
            [0, 2, 3],
            [2, 1, 4],
            [1, 0, 5],
            [4, 1, 6],
            [0, 3, 7],
        ];
        let mut meshes = [3, 4, 5, 10, 11, 64].map(annulus).to_vec();
        meshes.push(planar(&fan, &[&[0, 1, 2, 3, 4, 5, 6, 7]]));
        meshes.push(planar(&star, &[&[0, 5, 1, 6, 4, 2, 3, 7]]));
        meshes.push(planar(&[[0, 1, 2], [2, 3, 4]], &[&[0, 1, 2, 3, 4, 2]]));
        // Without a loop, as at a cut that is no boundary.
        meshes.push(planar(&star, &[]));
        meshes
    }

    fn strip_indices(technique: Extrusion, mesh: &RegionMesh) -> Vec<u32> {
        let geometry = built(technique, Indices::Strip, std::slice::from_ref(mesh));
        let short = geometry.indices.short.iter();
        short
            .map(|&index| {
                if index == u16::MAX {
                    u32::MAX
                } else {
                    index.into()
                }
            })
            .collect()
    }

    #[test]
    fn strips_make_what_lists_make() {
        for mesh in meshes_for_strips().into_iter().chain(real_meshes()) {
            let expected = Made::of_mesh(&mesh);
            let list: Vec<[u32; 6]> = with_neighbours(&mesh)
                .chunks_exact(6)
                .map(|input| input.try_into().expect("six"))
                .collect();
            assert_eq!(Made::by_adjacency(&list), expected, "{:?}", mesh.triangles);
            let indices = strip_indices(Extrusion::GsDegenerate, &mesh);
            let made = Made::by_degenerate(&strip_inputs(&indices, [2, 1]));
            assert_eq!(made, expected, "{indices:?}");
            let indices = strip_indices(Extrusion::GsAdjacency, &mesh);
            let mut inputs = adjacent_strip_inputs(&indices);
            assert_eq!(Made::by_adjacency(&inputs), expected, "{indices:?}");
            // Whichever corner a driver begins every second one with.
            for input in inputs.iter_mut().skip(1).step_by(2) {
                input.rotate_left(2);
            }
            assert_eq!(Made::by_adjacency(&inputs), expected, "{indices:?}");
        }
    }

    #[test]
    fn broken_strips_are_noticed() {
        let mesh = annulus(10);
        let expected = Made::of_mesh(&mesh);
        let indices = strip_indices(Extrusion::GsDegenerate, &mesh);
        let made = |indices: &[u32]| Made::by_degenerate(&strip_inputs(indices, [2, 1]));
        assert_eq!(made(&indices), expected);
        // Every second triangle turned over.
        assert_ne!(
            Made::by_degenerate(&strip_inputs(&indices, [1, 2])),
            expected
        );
        // No restart after the caps, and none after the first loop.
        for place in (0..indices.len() - 1).filter(|&place| indices[place] == u32::MAX) {
            let mut joined = indices.clone();
            joined.remove(place);
            assert_ne!(made(&joined), expected, "{place}");
        }
        let indices = strip_indices(Extrusion::GsAdjacency, &mesh);
        let made = |indices: &[u32]| Made::by_adjacency(&adjacent_strip_inputs(indices));
        assert_eq!(made(&indices), expected);
        // A corner's neighbour in the place of the next one's.
        let mut noticed = 0;
        for place in (1..indices.len() - 2).step_by(2) {
            let mut swapped = indices.clone();
            swapped.swap(place, place + 2);
            noticed += usize::from(made(&swapped) != expected);
        }
        assert!(
            noticed > indices.len() / 4,
            "{noticed} of {}",
            indices.len()
        );
    }

    /// What `two_edges.geom` makes of an input: triangles, and edges.
    fn decode([x, y, z]: [u32; 3]) -> (Option<[u32; 3]>, Vec<[u32; 2]>) {
        if y == z {
            (None, vec![[x, y]])
        } else if x > y || x > z {
            (None, vec![[z, x], [x, y]])
        } else {
            (Some([x, y, z]), Vec::new())
        }
    }

    #[test]
    fn two_edges_in_a_row_are_told_from_triangles_whatever_the_numbers() {
        for count in [3, 4, 5, 10, 11] {
            let mut mesh = annulus(count);
            for turn in 0..count as usize {
                for ring in &mut mesh.boundary_loops {
                    ring.rotate_left(turn);
                }
                let inputs: Vec<[u32; 3]> = edges_in_pairs(&mesh).collect();
                let found: Vec<[u32; 2]> = inputs.iter().flat_map(|&i| decode(i).1).collect();
                assert!(inputs.iter().all(|&input| decode(input).0.is_none()));
                let edges: Vec<[u32; 2]> = mesh.boundary_edges().collect();
                assert_eq!(found, edges, "each once, in order");
                // An odd edge of each ring, and one more where the smallest number is in the way.
                assert!(inputs.len() <= count as usize + 4, "{}", inputs.len());
            }
            for &triangle in &mesh.triangles {
                let turned = smallest_first(triangle);
                let (kept, edges) = decode(turned);
                assert_eq!((kept, edges.len()), (Some(turned), 0));
                let sides = |[a, b, c]: [u32; 3]| BTreeSet::from([[a, b], [b, c], [c, a]]);
                assert_eq!(sides(turned), sides(triangle), "winding kept");
            }
        }
        // Twin: a pair that begins with its smallest number would pass for a triangle.
        assert!(decode([1, 2, 3]).0.is_some());
    }

    #[test]
    fn walls_stand_where_no_neighbour_is_and_nowhere_else() {
        let walls_of = |mesh: &RegionMesh| {
            let indices = with_neighbours(mesh);
            let mut walls = BTreeSet::new();
            for input in indices.chunks_exact(6) {
                for (from, across, to, opposite) in [(0, 1, 2, 4), (2, 3, 4, 0), (4, 5, 0, 2)] {
                    if input[across] == input[opposite] {
                        walls.insert([input[from], input[to]]);
                    }
                }
            }
            walls
        };
        let mut mesh = annulus(9);
        assert_eq!(walls_of(&mesh), mesh.boundary_edges().collect());
        // A cut that is no boundary, such as the antimeridian's, gets no wall.
        let without = mesh.triangles.remove(0);
        assert_eq!(walls_of(&mesh).len(), 17);
        mesh.triangles.push(without);
        mesh.boundary_loops.pop();
        assert_eq!(walls_of(&mesh).len(), 9);
    }

    #[test]
    fn a_doubled_vertex_is_stored_twice_and_flagged_once() {
        let meshes = [annulus(3)];
        let geometry = built(Extrusion::VsControl, Indices::List, &meshes);
        for pair in geometry.vertices.chunks(8) {
            assert_eq!(pair[..3], pair[4..7]);
            assert_eq!((pair[3], pair[7]), (0, 1));
        }
    }
}
