// SPDX-License-Identifier: MIT OR Apache-2.0
//! The buffers as a GPU reads them are closed solids: tests only.
//!
//! What is uploaded is expanded to triangles as input assembly and the shaders in `shaders/vertex`
//! do it, strips with their alternating winding and restarts included, for every way to store them.
//! A corner is the words of its position and which cap it goes to. All that follows on the GPU is a
//! function of those, so corners that agree in them agree in every later rounding as well; that is
//! tried with the shader's own `f32` arithmetic from eyes near and far. Different vertices may fall
//! together: the surface must stay closed by [`check_closed`], in `per-triangle` that of every
//! triangle's own volume. Walls are the boundary's and no others, whatever cancels on the way.

#![allow(
    clippy::print_stdout,
    reason = "a skipped test says why; what falls together is worth reading"
)]

use crate::layout::{RegionSlice, SceneGeometry};
use crate::{IndexOrder, Layout, VertexSize, VertexTechnique, VertexVariant, Walls};
use glam::{DVec3, IVec3, Vec3};
use std::collections::HashMap;
use terrafill_contract::Technique as _;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshOptions, RegionMesh, VolumeHeights, nearest_f32, parse_regions,
};
use terrafill_fixtures::{ClosedSurface, check_closed, check_volume, data};
use terrafill_scene::Overlap;
use terrafill_stencil::{PositionFormat, two_float, two_float_difference_m};
use terrafill_variant::Variant;

/// Every way to store geometry.
fn storages() -> Vec<VertexVariant> {
    let choices: [(&str, &[&str]); 5] = [
        ("layout", &["doubled", "separate", "per-triangle", "pulled"]),
        (
            "positions",
            &["fixed", "local-f32", "ecef-f32", "two-float"],
        ),
        ("walls", &["strip", "list"]),
        ("index-order", &["mesh", "cache"]),
        ("vertex-bytes", &["16", "20"]),
    ];
    let mut all = vec![VertexTechnique.main(Overlap::Disjoint)];
    for (key, values) in choices {
        let with = |variant: &Variant, value: &str| variant.clone().with(key, value);
        all = all
            .iter()
            .flat_map(|variant| values.iter().map(|value| with(variant, value)))
            .collect();
    }
    let mut all: Vec<VertexVariant> = all.iter().flat_map(VertexVariant::of).collect();
    all.retain(|variant| variant.check_layout().is_ok());
    assert_eq!(
        all.len(),
        // No vertex of 20 bytes has two floats.
        2 * (4 * (4 + 2 + 1 + 1) - 2),
        "a way to store is missing"
    );
    all
}

/// The storages in which little but what a test turns differs.
fn in_mesh_order() -> impl Iterator<Item = VertexVariant> {
    let in_order = |variant: &VertexVariant| variant.index_order == IndexOrder::Mesh;
    storages().into_iter().filter(in_order)
}

/// Whether the layout is one that takes the longer tests.
fn is_plain(variant: &VertexVariant) -> bool {
    let plain = VertexVariant {
        layout: variant.layout,
        positions: variant.positions,
        ..VertexVariant::default()
    };
    *variant == plain && matches!(variant.layout, Layout::Doubled | Layout::Pulled)
}

/// Whether vertex `v` is stored at 2v and again at 2v + 1.
fn is_stored_twice(variant: &VertexVariant) -> bool {
    variant.layout != Layout::Pulled
}

/// Whether walls are strips to the input assembly.
fn has_strips(variant: &VertexVariant) -> bool {
    let has_choice = matches!(variant.layout, Layout::Doubled | Layout::Separate);
    has_choice && variant.walls == Walls::Strip
}

/// What the vertex stage knows of a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Corner {
    /// Zeros beyond what the format has.
    words: [i32; 6],
    is_bottom: bool,
}

/// Triangles of a strip: every second one is turned, restarts begin anew (Vulkan 1.3 §21.1.4).
fn strip(indices: &[u32], restart: u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for run in indices.split(|&index| index == restart) {
        for (i, corners) in run.windows(3).enumerate() {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            triangles.push(if i % 2 == 0 { [a, b, c] } else { [a, c, b] });
        }
    }
    triangles
}

/// Triangles of a list.
fn list(indices: &[u32]) -> Result<Vec<[u32; 3]>, String> {
    let triangles = indices.chunks_exact(3);
    if triangles.remainder().is_empty() {
        Ok(triangles.map(|c| [c[0], c[1], c[2]]).collect())
    } else {
        Err(format!("{} indices are no list", indices.len()))
    }
}

/// Walls in the order of the triangles whose sides they stand on, two a wall.
///
/// - `caps`: top caps, then as many bottom caps
/// - `walls`: on the boundary, the first on inner edges, the second there, each in any order
fn by_triangle(caps: &[[u32; 3]], walls: [Vec<[u32; 3]>; 3]) -> Vec<[u32; 3]> {
    // By the side that they stand on, as the triangle has it.
    let mut standing: HashMap<[u32; 2], Vec<[u32; 3]>> = HashMap::new();
    for (kind, walls) in walls.iter().enumerate() {
        for wall in walls.chunks(2) {
            let ends = wall[0]
                .iter()
                .chain(&wall[wall.len() - 1])
                .map(|place| place / 2);
            let start = wall[0][0] / 2;
            let end = ends.clone().find(|end| *end != start).unwrap_or(start);
            let side = if kind == 2 {
                [end, start]
            } else {
                [start, end]
            };
            standing.entry(side).or_default().extend(wall);
        }
    }
    let mut ordered = Vec::new();
    for &[a, b, c] in &caps[..caps.len() / 2] {
        for side in [[a, b], [b, c], [c, a]].map(|side| side.map(|place| place / 2)) {
            ordered.extend(standing.remove(&side).unwrap_or_default());
        }
    }
    let mut left: Vec<[u32; 3]> = standing.into_values().flatten().collect();
    left.sort_unstable();
    ordered.extend(left);
    ordered
}

/// The same corners for both windings of a triangle, and which one it was: 1 or −1, or 0 where the
/// triangle is its own back. Begins with its own first corner if it `keeps_first`, else with the
/// least.
fn unwound(corners: [Corner; 3], keeps_first: bool) -> ([Corner; 3], i64) {
    let mut corners = corners;
    if !keeps_first {
        let least = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
        corners.rotate_left(least);
    }
    let [first, second, third] = corners;
    if first == second || second == third || third == first {
        return (corners, 0);
    }
    if second < third {
        (corners, 1)
    } else {
        ([first, third, second], -1)
    }
}

/// Reads the buffers of one region.
struct Reader<'a> {
    geometry: &'a SceneGeometry,
    slice: &'a RegionSlice,
    variant: VertexVariant,
}

impl Reader<'_> {
    /// Top caps, bottom caps, walls. What is read beyond a buffer's end is a fault, whatever a
    /// device would make of it.
    fn triangles(&self) -> Result<Vec<[Corner; 3]>, String> {
        if is_stored_twice(&self.variant) {
            self.indexed()
        } else {
            self.pulled()
        }
    }

    /// Bytes from one vertex to the next, in words.
    fn stride(&self) -> usize {
        let behind = match (self.variant.layout, self.variant.vertex_size) {
            (Layout::Separate | Layout::Pulled, _) => 0,
            (_, VertexSize::Bytes16) => 1,
            (_, VertexSize::Bytes20) => 2,
        };
        self.position_words() + behind
    }

    fn position_words(&self) -> usize {
        match self.variant.positions {
            PositionFormat::TwoFloat => 6,
            _ => 3,
        }
    }

    /// Vertex `index` of the region, counted from its first.
    fn words(&self, index: u32) -> Result<&[i32], String> {
        let vertex = u64::from(self.slice.place.first_vertex) + u64::from(index);
        let found = usize::try_from(vertex).ok().and_then(|vertex| {
            let first = self.stride() * vertex;
            self.geometry.vertices.get(first..first + self.stride())
        });
        found.ok_or_else(|| format!("vertex {vertex} is beyond the buffer"))
    }

    /// −0 is 0 to arithmetic.
    fn corner(&self, words: &[i32], is_bottom: bool) -> Corner {
        let mut stored = [0; 6];
        stored[..self.position_words()].copy_from_slice(&words[..self.position_words()]);
        let words = match self.variant.positions {
            PositionFormat::Fixed => stored,
            _ => stored.map(|word| if word == i32::MIN { 0 } else { word }),
        };
        Corner { words, is_bottom }
    }

    /// Indices of the region's width, from its own buffer.
    fn indices(&self, first: u32, count: u32) -> Result<Vec<u32>, String> {
        let range = first as usize..(first + count) as usize;
        let indices = if self.slice.place.has_short_indices {
            let short = self.geometry.indices.short.get(range.clone());
            short.map(|short| short.iter().map(|&index| u32::from(index)).collect())
        } else {
            let long = self.geometry.indices.long.get(range.clone());
            long.map(<[u32]>::to_vec)
        };
        indices.ok_or_else(|| format!("indices {range:?} are beyond the buffer"))
    }

    /// Indices of walls on the boundary, the first ones on inner edges, and the second ones.
    fn in_kinds<'b>(&self, walls: &'b [u32]) -> [&'b [u32]; 3] {
        let turned = self.slice.turned_index_count as usize;
        let second = walls.len().saturating_sub(turned);
        let first = second.saturating_sub(turned);
        [&walls[..first], &walls[first..second], &walls[second..]]
    }

    /// Whether every second wall is the first one turned over, which is drawn in its place.
    fn check_second_walls(&self) -> Result<(), String> {
        let slice = self.slice;
        let walls = self.indices(slice.place.first_loop_index, slice.loop_index_count)?;
        let [_, firsts, seconds] = self.in_kinds(&walls).map(list);
        let turned = seconds?.into_iter().map(|[a, b, c]| [a, c, b]);
        if turned.eq(firsts?) {
            Ok(())
        } else {
            Err("a second wall is not the first one turned over".to_owned())
        }
    }

    /// `doubled.wgsl`'s attributes: the flag lies behind the position, or in the buffer that every
    /// region reads from its start.
    fn fetch_stored(&self, index: u32) -> Result<Corner, String> {
        let words = self.words(index)?;
        let flag = if self.variant.layout == Layout::Separate {
            let flag = self.geometry.flags.get(index as usize);
            let flag = flag.ok_or_else(|| format!("flag {index} is beyond the buffer"))?;
            u32::from_le_bytes(*flag) != 0
        } else {
            words[self.position_words()] != 0
        };
        Ok(self.corner(words, flag))
    }

    /// A list of caps; strips or a list of walls.
    fn indexed(&self) -> Result<Vec<[Corner; 3]>, String> {
        let slice = self.slice;
        let mut triangles = list(&self.indices(
            slice.place.first_triangle_index,
            6 * slice.place.triangle_count,
        )?)?;
        let walls = self.indices(slice.place.first_loop_index, slice.loop_index_count)?;
        triangles.extend(if has_strips(&self.variant) {
            let restart = if slice.place.has_short_indices {
                0xffff
            } else {
                u32::MAX
            };
            strip(&walls, restart)
        } else if self.variant.layout == Layout::PerTriangle {
            let [outer, firsts, seconds] = self.in_kinds(&walls).map(list);
            let (outer, firsts, seconds) = (outer?, firsts?, seconds?);
            by_triangle(&triangles, [outer, firsts, seconds])
        } else {
            list(&walls)?
        });
        let fetch = |index| self.fetch_stored(index);
        triangles
            .into_iter()
            .map(|[a, b, c]| Ok([fetch(a)?, fetch(b)?, fetch(c)?]))
            .collect()
    }

    /// `fetch_index` of `pulled.wgsl`: two 16-bit indices a word, low half first.
    fn fetch_index(&self, element: u32) -> Result<u32, String> {
        let beyond = || format!("index {element} is beyond the buffer");
        if !self.slice.place.has_short_indices {
            let found = self.geometry.indices.long.get(element as usize);
            return found.copied().ok_or_else(beyond);
        }
        let half = |element: u32| {
            let found = self.geometry.indices.short.get(element as usize);
            found.map(|&index| u32::from(index))
        };
        half(element).ok_or_else(beyond)?;
        // The upload fills up the last word.
        let word = half(element & !1).unwrap_or(0) | half(element | 1).unwrap_or(0) << 16;
        let index = if element & 1 == 1 {
            word >> 16
        } else {
            word & 0xffff
        };
        Ok(if index == 0xffff { u32::MAX } else { index })
    }

    fn fetch(&self, vertex: u32, is_bottom: bool) -> Result<Corner, String> {
        Ok(self.corner(self.words(vertex)?, is_bottom))
    }

    /// The walls that a mesh's boundary has, every one with the diagonal from the bottom of its
    /// start to the top of its end.
    fn boundary_walls(&self, mesh: &RegionMesh) -> Result<Vec<[Corner; 3]>, String> {
        let copies = if is_stored_twice(&self.variant) { 2 } else { 1 };
        let mut walls = Vec::new();
        for ring in &mesh.boundary_loops {
            for (i, &start) in ring.iter().enumerate() {
                let end = ring[(i + 1) % ring.len()];
                let corner = |vertex: u32, is_bottom: bool| {
                    let copy = u32::from(is_bottom && copies == 2);
                    self.fetch(copies * vertex + copy, is_bottom)
                };
                let [top, bottom] = [corner(start, false)?, corner(start, true)?];
                let [far_top, far_bottom] = [corner(end, false)?, corner(end, true)?];
                walls.push([top, bottom, far_top]);
                walls.push([far_top, bottom, far_bottom]);
            }
        }
        Ok(walls)
    }

    /// Where every triangle has its own volume, each is closed by itself.
    fn check_own_volumes(&self, triangles: &[[Corner; 3]]) -> Result<(), String> {
        let (caps, walls) = triangles.split_at(2 * self.slice.place.triangle_count as usize);
        let (top, bottom) = caps.split_at(caps.len() / 2);
        for (i, walls) in walls.chunks(6).enumerate() {
            let (Some(top), Some(bottom)) = (top.get(i), bottom.get(i)) else {
                return Err(format!("walls of triangle {i}, which has no caps"));
            };
            let own = [*top, *bottom].into_iter().chain(walls.iter().copied());
            check_closed(own).map_err(|open| format!("volume {i}: {open}"))?;
        }
        Ok(())
    }

    /// Whether the walls are the boundary's once those that are each other turned over are left
    /// out. Walls that cancel do so to the bit only if they have the same corners in the same order,
    /// and so the same first one: see `push_inner_walls`.
    fn check_walls(&self, walls: &[[Corner; 3]], mesh: &RegionMesh) -> Result<(), String> {
        let keeps_first = self.variant.layout == Layout::PerTriangle;
        let expected = self.boundary_walls(mesh)?;
        let found = walls.iter().map(|corners| (corners, 1));
        let expected = expected.iter().map(|corners| (corners, -1));
        let mut uses: Vec<([Corner; 3], i64)> = found
            .chain(expected)
            .map(|(corners, uses)| {
                let (corners, sign) = unwound(*corners, keeps_first);
                (corners, sign * uses)
            })
            .collect();
        uses.sort_unstable();
        for same in uses.chunk_by(|a, b| a.0 == b.0) {
            let left: i64 = same.iter().map(|(_, uses)| uses).sum();
            if left != 0 {
                return Err(format!("{left} more than the boundary's: {:?}", same[0].0));
            }
        }
        Ok(())
    }

    /// `pulled.wgsl`, invocation by invocation.
    fn pulled(&self) -> Result<Vec<[Corner; 3]>, String> {
        let slice = self.slice;
        let cap = |vertex_index: u32| -> Result<Corner, String> {
            let is_bottom = vertex_index >= 3 * slice.place.triangle_count;
            let in_cap = vertex_index - u32::from(is_bottom) * 3 * slice.place.triangle_count;
            let corner = in_cap % 3;
            let slot = if is_bottom { (3 - corner) % 3 } else { corner };
            let element = slice.place.first_triangle_index + in_cap - corner + slot;
            self.fetch(self.fetch_index(element)?, is_bottom)
        };
        let nowhere = Corner {
            words: [0; 6],
            is_bottom: false,
        };
        let wall = |vertex_index: u32| -> Result<Corner, String> {
            let entry = slice.place.first_loop_index + vertex_index / 6;
            let corner = vertex_index % 6;
            let (start, end) = (self.fetch_index(entry)?, self.fetch_index(entry + 1)?);
            if start == u32::MAX || end == u32::MAX {
                return Ok(nowhere);
            }
            let is_end = [2, 3, 5].contains(&corner);
            let is_bottom = [1, 4, 5].contains(&corner);
            self.fetch(if is_end { end } else { start }, is_bottom)
        };
        let caps = (0..6 * slice.place.triangle_count).step_by(3);
        let caps = caps.map(|i| Ok([cap(i)?, cap(i + 1)?, cap(i + 2)?]));
        // A region without a boundary has no list to read.
        let walls = (0..6 * slice.loop_index_count.saturating_sub(1)).step_by(3);
        let walls = walls.map(|i| Ok([wall(i)?, wall(i + 1)?, wall(i + 2)?]));
        caps.chain(walls).collect()
    }

    /// Metres from the region's origin, at height 0.
    fn local_m(&self, corner: Corner) -> DVec3 {
        match self.variant.positions {
            PositionFormat::Fixed => integers(corner).as_dvec3() * self.slice.place.fixed.unit_m,
            PositionFormat::LocalF32 => floats(corner)[0].as_dvec3(),
            // What is not stored is 0.
            PositionFormat::EcefF32 | PositionFormat::TwoFloat => {
                let [high, low] = floats(corner).map(|part| part.as_dvec3());
                high + low - self.slice.place.fixed.origin_ecef
            }
        }
    }

    /// `eye_relative_m` of `shared/region.wgsl` with its caller's height, in `f32` throughout.
    fn eye_relative(&self, eye_ecef: DVec3, scene: &Scene, corner: Corner) -> Vec3 {
        let fixed = &self.slice.place.fixed;
        let origin = fixed.origin_ecef.as_vec3();
        let (relative, ecef) = match self.variant.positions {
            PositionFormat::EcefF32 => {
                let [ecef, _] = floats(corner);
                (ecef - eye_ecef.as_vec3(), ecef)
            }
            PositionFormat::TwoFloat => {
                let parts = floats(corner);
                let relative = two_float_difference_m(parts, two_float(eye_ecef));
                (relative, parts[0])
            }
            PositionFormat::LocalF32 => {
                let local = floats(corner)[0];
                let eye = (eye_ecef - fixed.origin_ecef).as_vec3();
                (local - eye, origin + local)
            }
            PositionFormat::Fixed => {
                let eye = fixed.eye(eye_ecef);
                let stored = integers(corner);
                let difference = (stored >> eye.shift) - eye.eye;
                let scale = nearest_f32(fixed.unit_m * f64::from(eye.shift).exp2());
                let relative = difference.as_vec3() * scale - eye.remainder_m.as_vec3();
                (
                    relative,
                    origin + stored.as_vec3() * nearest_f32(fixed.unit_m),
                )
            }
        };
        let (a, b) = (
            scene.body.equatorial_radius_m(),
            scene.body.polar_radius_m(),
        );
        let normal_scale = Vec3::new(1.0, 1.0, nearest_f32((a / b).powi(2)));
        let VolumeHeights { top_m, bottom_m } = scene.heights;
        let height_m = if corner.is_bottom { bottom_m } else { top_m };
        relative + (ecef * normal_scale).normalize() * nearest_f32(height_m)
    }
}

fn floats(corner: Corner) -> [Vec3; 2] {
    let [x, y, z, u, v, w] = corner.words.map(|word| f32::from_bits(word as u32));
    [Vec3::new(x, y, z), Vec3::new(u, v, w)]
}

fn integers(corner: Corner) -> IVec3 {
    let [x, y, z, ..] = corner.words;
    IVec3::new(x, y, z)
}

/// Meshes in one set of buffers.
struct Scene {
    body: Ellipsoid,
    heights: VolumeHeights,
    meshes: Vec<RegionMesh>,
    /// What `core` finds of each mesh.
    volumes_m3: Vec<f64>,
}

/// Sums over a scene.
#[derive(Debug, Default, PartialEq, Eq)]
struct Count {
    triangles: usize,
    collapsed: usize,
    vertices: usize,
    fallen_together: usize,
}

impl Count {
    fn add(&mut self, closed: ClosedSurface, vertices: usize, positions: usize) {
        self.triangles += closed.triangles;
        self.collapsed += closed.collapsed_triangles;
        self.vertices += vertices;
        self.fallen_together += vertices - positions;
    }
}

/// All corners of the pulled triangles at a separator are one.
fn is_somewhere([a, b, c]: &[Corner; 3]) -> bool {
    a != b || b != c
}

/// Two caps and two a wall. Pulled walls come for every entry of the loop list but the last one: for
/// those before and at a separator, two a loop, their corners are all nowhere.
/// Where triangles have volumes of their own, three walls each.
fn triangle_count(layout: Layout, mesh: &RegionMesh) -> usize {
    let drawn = 2 * (mesh.triangle_count() + mesh.boundary_edge_count());
    match layout {
        Layout::Doubled | Layout::Separate => drawn,
        Layout::PerTriangle => (2 + 3 * 2) * mesh.triangle_count(),
        Layout::Pulled => drawn + 2 * (2 * mesh.boundary_loops.len()).saturating_sub(1),
    }
}

fn positions<P: Ord + Copy>(triangles: &[[P; 3]]) -> usize {
    let mut corners: Vec<P> = triangles.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    corners.len()
}

impl Scene {
    fn new(body: Ellipsoid, meshes: Vec<RegionMesh>) -> Self {
        let radius_m = body.equatorial_radius_m();
        let heights = VolumeHeights {
            top_m: 0.0015 * radius_m,
            bottom_m: -0.002 * radius_m,
        };
        let volumes_m3 = meshes.iter().map(|mesh| {
            let report = check_volume(mesh, &body, heights);
            report
                .unwrap_or_else(|fault| panic!("{}: {fault}", mesh.name))
                .volume_m3
        });
        Self {
            body,
            heights,
            volumes_m3: volumes_m3.collect(),
            meshes,
        }
    }

    fn build(&self, variant: &VertexVariant) -> SceneGeometry {
        SceneGeometry::build(variant, &self.meshes, |_| true)
    }

    fn check(&self, variant: &VertexVariant) -> Result<Count, String> {
        self.check_built(&self.build(variant), variant)
    }

    /// Closed by the words in the buffers, and of the volume that `core` finds.
    fn check_built(
        &self,
        geometry: &SceneGeometry,
        variant: &VertexVariant,
    ) -> Result<Count, String> {
        let mut count = Count::default();
        let known = self.meshes.iter().zip(&self.volumes_m3);
        for (slice, (mesh, expected_m3)) in geometry.regions.iter().zip(known) {
            let fail = |what: String| format!("{} ({variant:?}): {what}", mesh.name);
            let reader = Reader {
                geometry,
                slice,
                variant: *variant,
            };
            let triangles = reader.triangles().map_err(fail)?;
            let closed =
                check_closed(triangles.iter().copied()).map_err(|open| fail(open.to_string()))?;
            let expected = triangle_count(variant.layout, mesh);
            if closed.triangles != expected {
                let found = closed.triangles;
                return Err(fail(format!("{found} triangles, not {expected}")));
            }
            if variant.layout == Layout::PerTriangle {
                reader.check_own_volumes(&triangles).map_err(fail)?;
            }
            let caps = 2 * slice.place.triangle_count as usize;
            reader.check_walls(&triangles[caps..], mesh).map_err(fail)?;
            if variant.layout == Layout::PerTriangle {
                reader.check_second_walls().map_err(fail)?;
            }
            let filled: Vec<[Corner; 3]> = triangles.into_iter().filter(is_somewhere).collect();
            self.check_volume(&reader, &filled, mesh, *expected_m3)
                .map_err(fail)?;
            let vertices = 2 * mesh.vertex_count();
            count.add(closed, vertices, positions(&filled));
        }
        Ok(count)
    }

    /// By the divergence theorem, from the words, in `f64`.
    fn check_volume(
        &self,
        reader: &Reader<'_>,
        triangles: &[[Corner; 3]],
        mesh: &RegionMesh,
        expected_m3: f64,
    ) -> Result<(), String> {
        let (a, b) = (self.body.equatorial_radius_m(), self.body.polar_radius_m());
        let normal_scale = DVec3::new(1.0, 1.0, (a / b).powi(2));
        let place = |corner: Corner| {
            let local = reader.local_m(corner);
            let normal =
                ((reader.slice.place.fixed.origin_ecef + local) * normal_scale).normalize();
            let VolumeHeights { top_m, bottom_m } = self.heights;
            local + normal * if corner.is_bottom { bottom_m } else { top_m }
        };
        let found_m3: f64 = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(place);
                a.dot((b - a).cross(c - a)) / 6.0
            })
            .sum();
        // Rounding moves each vertex by less than two steps; its column has a thickness.
        let step_m = match reader.variant.positions {
            PositionFormat::Fixed => reader.slice.place.fixed.unit_m,
            PositionFormat::LocalF32 => reader.slice.place.fixed.unit_m * 128.0,
            // Half a step of f32 at the body's radius; and of what that leaves.
            PositionFormat::EcefF32 => a * f64::from(f32::EPSILON) * 0.5,
            PositionFormat::TwoFloat => a * f64::from(f32::EPSILON).powi(2),
        };
        let thickness_m = self.heights.top_m - self.heights.bottom_m;
        let length_m: f64 = mesh
            .triangles
            .iter()
            .map(|&[i, j, _]| {
                let [a, b] = [i, j].map(|k| mesh.vertices_ecef[k as usize]);
                a.distance(b)
            })
            .sum();
        let rounding_m = 2.0 * step_m + 2e-14 * a;
        let allowed_m3 =
            1e-9 * expected_m3.abs() + rounding_m * (length_m + a * 1e-6) * thickness_m;
        let difference = (found_m3 - expected_m3).abs();
        if difference <= allowed_m3 {
            Ok(())
        } else {
            Err(format!(
                "{found_m3} m³ in the buffers, {expected_m3} m³ expected; allowed difference \
                 {allowed_m3}"
            ))
        }
    }

    /// Closed after the shader's arithmetic, seen from eyes over the first vertex of each region.
    fn check_from_eyes(&self, variant: &VertexVariant) -> Result<Count, String> {
        let geometry = self.build(variant);
        let mut count = Count::default();
        for (slice, mesh) in geometry.regions.iter().zip(&self.meshes) {
            let reader = Reader {
                geometry: &geometry,
                slice,
                variant: *variant,
            };
            let triangles: Vec<[Corner; 3]> = reader
                .triangles()?
                .into_iter()
                .filter(is_somewhere)
                .collect();
            let vertex = mesh.vertices_ecef[0];
            // On the Earth 1.5 m, 1 km and 32,000 km over it.
            for share in [2.4e-7, 1.6e-4, 5.0] {
                let eye_ecef = vertex * (1.0 + share);
                let seen: Vec<[[u32; 3]; 3]> = triangles
                    .iter()
                    .map(|corners| {
                        corners.map(|corner| {
                            let place = reader.eye_relative(eye_ecef, self, corner);
                            (place + Vec3::ZERO).to_array().map(f32::to_bits)
                        })
                    })
                    .collect();
                let closed = check_closed(seen.iter().copied()).map_err(|open| open.to_string())?;
                count.add(closed, 2 * mesh.vertex_count(), positions(&seen));
            }
        }
        Ok(count)
    }
}

fn meshes_of(text: &[u8], name: &str, body: &Ellipsoid, rule: EdgeRule) -> Vec<RegionMesh> {
    let regions = parse_regions(text, name).expect("valid");
    regions
        .iter()
        .filter_map(|region| RegionMesh::build(region, body, rule, &MeshOptions::default()).ok())
        .collect()
}

/// A hole, one that touches, both poles, the antimeridian, a band, the globe, 1 mm.
const SHAPES: [&str; 9] = [
    "[[[10,40],[14,40],[14,44],[10,44]],[[11,41],[13,41],[13,43],[11,43]]]",
    "[[[10,40],[14,40],[14,44],[10,44]],[[10,40],[12,41],[11,42]]]",
    "[[[0,80],[120,80],[240,80],[360,80]]]",
    "[[[10,-90],[10,0],[10,90],[40,90],[40,0],[40,-90]]]",
    "[[[0,80],[50,90],[60,90]]]",
    "[[[170,10],[190,12],[188,30],[172,28]]]",
    "[[[-180,-10],[180,-10],[180,10],[-180,10],[-180,-10]]]",
    "[[[-180,-90],[180,-90],[180,90],[-180,90],[-180,-90]]]",
    "[[[10,45],[10.00000001,45],[10.00000001,45.00000001],[10,45.00000001]]]",
];

fn shapes(body: Ellipsoid, shapes: &[&str]) -> Scene {
    let meshes = shapes.iter().enumerate().flat_map(|(i, shape)| {
        let text = format!(r#"{{"type":"Polygon","coordinates":{shape}}}"#);
        let mut meshes = meshes_of(text.as_bytes(), "shape", &body, EdgeRule::Planar);
        for mesh in &mut meshes {
            mesh.name = format!("shape {i}");
        }
        meshes
    });
    let meshes: Vec<RegionMesh> = meshes.collect();
    assert_eq!(meshes.len(), shapes.len());
    Scene::new(body, meshes)
}

#[test]
fn every_way_to_store_hard_shapes_is_closed() {
    for body in Ellipsoid::ALL {
        let scene = shapes(body, &SHAPES);
        // The body is nothing that a storage knows.
        let is_tried = |variant: &VertexVariant| body == Ellipsoid::WGS84 || is_plain(variant);
        for variant in storages().into_iter().filter(is_tried) {
            let count = scene.check(&variant);
            let count = count.unwrap_or_else(|what| panic!("{}: {what}", body.name()));
            println!("{}, {variant:?}: {count:?}", body.name());
            // The layouts differ in how corners are found, not in what becomes of them.
            if is_plain(&variant) && variant.layout == Layout::Doubled {
                let from_eyes = scene.check_from_eyes(&variant).expect("closed");
                println!("from eyes: {from_eyes:?}");
            }
        }
    }
}

/// Every sixteenth mesh, and the smallest one whose indices are long when vertices are stored
/// twice: what the storages share needs no second million of vertices.
fn thinned(meshes: &[RegionMesh]) -> Vec<RegionMesh> {
    let is_long = |mesh: &&RegionMesh| 2 * mesh.vertex_count() > 0xffff;
    let long = meshes.iter().filter(is_long);
    let smallest = long.min_by_key(|mesh| mesh.vertex_count());
    let short = meshes.iter().filter(|mesh| !is_long(mesh)).step_by(16);
    smallest.into_iter().chain(short).cloned().collect()
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m, natural-earth-10m, us-10m"]
fn every_way_to_store_the_countries_is_closed() {
    for (name, rule) in [
        ("ne_110m_admin_0_countries.geojson", EdgeRule::Planar),
        ("ne_110m_admin_0_countries.geojson", EdgeRule::GreatEllipse),
        ("ne_50m_admin_0_countries.geojson", EdgeRule::Planar),
        ("us_counties_10m.geojson", EdgeRule::Planar),
        ("ne_10m_admin_0_countries.geojson", EdgeRule::Planar),
    ] {
        let text = data::bytes(&format!("vectors/{name}"));
        let body = Ellipsoid::WGS84;
        let all = Scene::new(body, meshes_of(&text, name, &body, rule));
        let few = Scene::new(body, thinned(&all.meshes));
        // The largest file has regions with long indices, in every layout.
        let is_largest = name.starts_with("ne_10m");
        for variant in storages() {
            // A million vertices once are enough.
            let is_fixed = variant.positions == PositionFormat::Fixed;
            if is_largest && !is_fixed {
                continue;
            }
            // Floats about the planet's centre are found as those about a region's origin are; that
            // they leave nothing open shows in fewer meshes.
            let is_local = matches!(
                variant.positions,
                PositionFormat::Fixed | PositionFormat::LocalF32
            );
            let is_whole = is_plain(&variant) && is_local;
            let scene = if is_whole { &all } else { &few };
            let geometry = scene.build(&variant);
            let count = scene
                .check_built(&geometry, &variant)
                .unwrap_or_else(|what| panic!("{name}, {rule:?}: {what}"));
            println!("{name}, {rule:?}, {variant:?}: {count:?}");
            let has_long = geometry
                .regions
                .iter()
                .any(|slice| !slice.place.has_short_indices);
            let may_have = is_whole || is_stored_twice(&variant);
            assert_eq!(has_long, is_largest && may_have, "{name}, {variant:?}");
        }
    }
}

// ---- what must be noticed ---------------------------------------------------------------------

/// Two regions, so that the second one's offsets count; the first has a hole.
fn pair() -> Scene {
    shapes(Ellipsoid::WGS84, &[SHAPES[0], SHAPES[5]])
}

/// Applies `change` at places below `count`, one at a time; every result must be noticed, but where
/// it says that it changed nothing.
fn each_noticed(
    variants: impl Iterator<Item = VertexVariant>,
    count: &dyn Fn(&SceneGeometry) -> usize,
    change: &dyn Fn(&VertexVariant, &mut SceneGeometry, usize) -> bool,
) {
    let scene = pair();
    let mut layouts = 0;
    for variant in variants {
        layouts += 1;
        let places = count(&scene.build(&variant));
        assert!(places > 50, "{places} places");
        // All of them where the layout is plain; elsewhere some, other ones in every variant.
        let step = if is_plain(&variant) {
            1
        } else {
            places.div_ceil(32)
        };
        for place in (layouts % step..places).step_by(step) {
            let mut geometry = scene.build(&variant);
            if !change(&variant, &mut geometry, place) {
                continue;
            }
            let noticed = scene.check_built(&geometry, &variant).is_err();
            assert!(noticed, "{variant:?}, {place}");
        }
    }
    assert!(layouts > 0, "nothing was tried");
}

#[test]
fn every_index_that_is_another_is_noticed() {
    each_noticed(
        in_mesh_order(),
        &|geometry| geometry.indices.short.len(),
        &|variant, geometry, place| {
            let index = &mut geometry.indices.short[place];
            // The next vertex; a restart becomes one, too, and no longer restarts. Vertex 0 would
            // not do: a loop that ends there gets a wall of no length.
            let is_single = !is_stored_twice(variant) && *index != 0xffff;
            *index = index.wrapping_add(if is_single { 1 } else { 2 });
            true
        },
    );
    // The same vertex, but its copy in the other cap.
    each_noticed(
        in_mesh_order().filter(is_stored_twice),
        &|geometry| geometry.indices.short.len(),
        &|_, geometry, place| {
            // A restart becomes an index beyond the buffer.
            geometry.indices.short[place] ^= 1;
            true
        },
    );
}

#[test]
fn two_indices_that_have_changed_places_are_noticed() {
    each_noticed(
        in_mesh_order(),
        &|geometry| geometry.indices.short.len() - 1,
        &|_, geometry, place| {
            geometry.indices.short.swap(place, place + 1);
            geometry.indices.short[place] != geometry.indices.short[place + 1]
        },
    );
}

#[test]
fn every_flag_that_is_wrong_is_noticed() {
    let has_own =
        |variant: &VertexVariant| matches!(variant.layout, Layout::Doubled | Layout::PerTriangle);
    for size in [VertexSize::Bytes16, VertexSize::Bytes20] {
        for position_words in [3, 6] {
            let behind = if size == VertexSize::Bytes16 { 1 } else { 2 };
            let stride = position_words + behind;
            let is_so = |variant: &VertexVariant| {
                has_own(variant)
                    && variant.vertex_size == size
                    && variant.positions.words() == position_words
            };
            if position_words == 6 && size == VertexSize::Bytes20 {
                assert!(!in_mesh_order().any(|variant| is_so(&variant)));
                continue;
            }
            each_noticed(
                in_mesh_order().filter(is_so),
                &|geometry| geometry.vertices.len() / stride,
                &|_, geometry, place| {
                    geometry.vertices[stride * place + position_words] ^= 1;
                    true
                },
            );
        }
    }
    let separate = || in_mesh_order().filter(|variant| variant.layout == Layout::Separate);
    each_noticed(
        separate(),
        &|geometry| geometry.flags.len(),
        &|_, geometry, place| {
            geometry.flags[place][0] ^= 255;
            true
        },
    );
    // The largest region needs all of them.
    let scene = pair();
    for variant in separate() {
        let mut geometry = scene.build(&variant);
        geometry.flags.pop();
        let found = scene.check_built(&geometry, &variant);
        assert!(found.is_err_and(|what| what.contains("beyond")));
    }
}

#[test]
fn offsets_of_another_region_are_noticed() {
    let scene = pair();
    for variant in storages() {
        let mutants: [fn(&mut RegionSlice); 6] = [
            |slice| slice.place.first_vertex -= 1,
            |slice| slice.place.first_triangle_index -= 1,
            |slice| slice.place.first_loop_index -= 1,
            |slice| slice.place.triangle_count -= 1,
            |slice| slice.loop_index_count -= 3,
            |slice| slice.place.fixed.unit_m *= 2.0,
        ];
        for (i, mutant) in mutants.iter().enumerate() {
            // Floats have no unit.
            if i == 5 && variant.positions != PositionFormat::Fixed {
                continue;
            }
            let mut geometry = scene.build(&variant);
            mutant(&mut geometry.regions[1]);
            let found = scene.check_built(&geometry, &variant);
            assert!(found.is_err(), "{variant:?}, {i}");
        }
    }
}

#[test]
fn buffers_read_as_another_storage_are_noticed() {
    let scene = pair();
    for stored in storages() {
        let geometry = scene.build(&stored);
        for read in storages() {
            // The order of triangles is nothing that a reader knows.
            let is_same = VertexVariant {
                index_order: read.index_order,
                ..stored
            } == read;
            let found = scene.check_built(&geometry, &read);
            assert_eq!(found.is_ok(), is_same, "{stored:?} as {read:?}: {found:?}");
        }
    }
}

/// The two triangles at `walls[0..6]` with the other diagonal.
fn with_other_diagonal(walls: &[u16]) -> [u16; 6] {
    let (first, second) = walls.split_at(3);
    let alone = |of: &[u16], others: &[u16]| {
        let found = (0..3).find(|&k| !others.contains(&of[k]));
        found.expect("the triangles share two corners")
    };
    let (near, far) = (alone(first, second), alone(second, first));
    let opposite = second[far];
    let [a, b, c] = [near, (near + 1) % 3, (near + 2) % 3].map(|k| first[k]);
    [a, b, opposite, a, opposite, c]
}

#[test]
fn walls_with_another_diagonal_or_first_corner_are_noticed() {
    let scene = pair();
    let has_lists = |variant: &VertexVariant| {
        is_stored_twice(variant) && !has_strips(variant) && variant.index_order == IndexOrder::Mesh
    };
    for variant in storages().into_iter().filter(has_lists) {
        let geometry = scene.build(&variant);
        let has_inner = variant.layout == Layout::PerTriangle;
        let slice = geometry.regions[1];
        let first = slice.place.first_loop_index as usize;
        let count = slice.loop_index_count as usize;
        assert_eq!(count % 6, 0);
        for wall in (first..first + count).step_by(6) {
            let mut other = scene.build(&variant);
            let turned = with_other_diagonal(&geometry.indices.short[wall..wall + 6]);
            other.indices.short[wall..wall + 6].copy_from_slice(&turned);
            let reader = Reader {
                geometry: &other,
                slice: &other.regions[1],
                variant,
            };
            // Its volume is as closed as before, so nothing but the comparison of walls tells.
            let triangles = reader.triangles().expect("in the buffer");
            assert!(check_closed(triangles.iter().copied()).is_ok());
            assert!(!has_inner || reader.check_own_volumes(&triangles).is_ok());
            let found = scene.check_built(&other, &variant);
            let found = found.expect_err("another diagonal");
            assert!(found.contains("more than the boundary's"), "{found}");

            let mut other = scene.build(&variant);
            other.indices.short[wall..wall + 3].rotate_left(1);
            let found = scene.check_built(&other, &variant);
            assert_eq!(found.is_err(), has_inner, "{variant:?}: {found:?}");
        }
    }
}

#[test]
fn second_walls_that_are_not_the_first_ones_are_noticed() {
    let scene = pair();
    let per_triangle = |variant: &VertexVariant| variant.layout == Layout::PerTriangle;
    for variant in storages().into_iter().filter(per_triangle) {
        let turned = scene.build(&variant).regions[1].turned_index_count;
        assert!(turned > 0 && turned.is_multiple_of(6), "{turned}");
        for count in [0, turned - 6, turned + 6] {
            let mut geometry = scene.build(&variant);
            geometry.regions[1].turned_index_count = count;
            let found = scene.check_built(&geometry, &variant);
            assert!(found.is_err(), "{variant:?}: {count} of {turned}");
        }
        // Turned over in another order of corners: as closed, and as many walls.
        let mut geometry = scene.build(&variant);
        let slice = geometry.regions[1];
        let end = (slice.place.first_loop_index + slice.loop_index_count) as usize;
        geometry.indices.short[end - 3..end].rotate_left(1);
        assert!(scene.check_built(&geometry, &variant).is_err());
        // In another order of walls, which nothing else would tell.
        let mut geometry = scene.build(&variant);
        for k in 1..=6 {
            geometry.indices.short.swap(end - k, end - 6 - k);
        }
        let found = scene.check_built(&geometry, &variant);
        let found = found.expect_err("another order");
        assert!(found.contains("not the first one turned over"), "{found}");
    }
}

#[test]
fn volumes_of_triangles_must_each_be_closed() {
    // Two triangles that have changed the walls between them: together closed as before, none by itself.
    let scene = pair();
    let per_triangle = |variant: &VertexVariant| variant.layout == Layout::PerTriangle;
    for variant in storages().into_iter().filter(per_triangle) {
        let mut geometry = scene.build(&variant);
        let slice = geometry.regions[1];
        let turned = slice.turned_index_count as usize;
        let end = (slice.place.first_loop_index + slice.loop_index_count) as usize;
        for k in 0..6 {
            geometry
                .indices
                .short
                .swap(end - 2 * turned + k, end - turned + k);
        }
        let found = scene.check_built(&geometry, &variant);
        let found = found.expect_err("walls of another triangle");
        assert!(found.contains("volume "), "{found}");
    }
}

#[test]
fn strips_without_their_alternation_or_restarts_are_open() {
    // The expansion itself: a wall of three edges round a triangle, closed by its caps.
    let wall = [0, 1, 2, 3, 4, 5, 0, 1, 0xffff];
    let caps = [[0, 2, 4], [1, 5, 3]];
    let solid = |walls: Vec<[u32; 3]>| check_closed(walls.into_iter().chain(caps));
    assert_eq!(strip(&wall, 0xffff).len(), 6);
    assert!(solid(strip(&wall, 0xffff)).is_ok());
    let unturned: Vec<[u32; 3]> = wall[..8].windows(3).map(|w| [w[0], w[1], w[2]]).collect();
    assert!(solid(unturned).is_err());
    // Two loops, the second one's walls run on from the first one's.
    let mut two: Vec<u32> = wall.to_vec();
    two.extend(wall.map(|index| if index == 0xffff { index } else { index + 6 }));
    let both = |walls: Vec<[u32; 3]>| {
        let far = caps.map(|corners| corners.map(|i| i + 6));
        check_closed(walls.into_iter().chain(caps).chain(far))
    };
    assert!(both(strip(&two, 0xffff)).is_ok());
    two.remove(8);
    assert!(both(strip(&two, 0xffff)).is_err());
}
