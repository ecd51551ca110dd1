// SPDX-License-Identifier: MIT OR Apache-2.0
//! How meshes lie in GPU buffers, and what that costs in bytes, by formula and as built.
//!
//! Indices are 16 bits where a region's vertices fit and 32 where they do not, region by region.

use crate::parts::ordered_by_part;
use crate::{IndexOrder, Layout, Normals, VertexOrder, VertexVariant, cache_ordered};
use glam::{DVec3, IVec3, Vec3};
use std::borrow::{Borrow, Cow};
use std::collections::HashSet;
use std::ops::Range;
use terrafill_contract::GeometryBytes;
use terrafill_core::RegionMesh;
use terrafill_plan::{PartOrder, RegionSet};
use terrafill_stencil::{FixedPoint, IndexLists, LaidOut, PositionFormat, VolumePlace, two_float};

/// Largest number of distinct indices in 16 bits: 0xffff restarts strips and separates loops.
const MAX_SHORT_INDICES: usize = 0xffff;

/// Whether a region's indices fit 16 bits.
fn has_short_indices(layout: Layout, vertices: usize) -> bool {
    let copies = if layout.is_doubled() { 2 } else { 1 };
    copies * vertices <= MAX_SHORT_INDICES
}

/// Bytes of a stored flag in layout `separate`. One would do; WebGPU wants strides in multiples of four.
pub const FLAG_BYTES: usize = 4;

/// Bytes that `mesh` takes in a layout with nothing else chosen: see [`variant_bytes`].
#[must_use]
pub fn layout_bytes(layout: Layout, mesh: &RegionMesh) -> GeometryBytes {
    let variant = VertexVariant {
        layout,
        ..VertexVariant::default()
    };
    variant_bytes(&variant, mesh)
}

/// Bytes that `mesh` takes, by formula. With *v* vertices, *t* triangles, *e* boundary edges in *l*
/// loops and *i* bytes an index:
///
/// - `doubled`: 2·16·v + i·(6t + 2(e + l) + l), the strips closed and followed by a restart; with
///   walls as lists i·(6t + 6e); with vertices of 20 bytes 2·20·v;
/// - `separate`: 2·12·v and indices as `doubled`, plus what all regions share
///   ([`shared_flag_bytes`]);
/// - `per-triangle`: 2·16·v + i·24t, two caps of 3 and three walls of 6 indices a triangle. Strips
///   of 4 would be 18 without restarts (as the 2007 document's total
///   counts them, though its text says 24) and 21 with them;
/// - `pulled`: 12·v + i·(3t + e + 2l), the loops closed and followed by a separator.
///
/// Positions of two floats take 24 bytes for 12, and a stored normal takes 12: 12·v more where vertices
/// are stored once, 2·12·v where they are stored twice.
#[must_use]
pub fn variant_bytes(variant: &VertexVariant, mesh: &RegionMesh) -> GeometryBytes {
    let (vertices, triangles) = (mesh.vertices_ecef.len(), mesh.triangles.len());
    let (edges, loops) = (mesh.boundary_edge_count(), mesh.boundary_loops.len());
    let short = has_short_indices(variant.layout, vertices);
    let index_size = if short { 2 } else { 4 };
    let (copies, indices) = match variant.layout {
        Layout::Doubled | Layout::Separate if variant.has_strips() => {
            (2, 6 * triangles + 2 * (edges + loops) + loops)
        }
        Layout::Doubled | Layout::Separate => (2, 6 * triangles + 6 * edges),
        Layout::PerTriangle => (2, 24 * triangles),
        Layout::Pulled => (1, 3 * triangles + edges + 2 * loops),
    };
    GeometryBytes {
        vertex_bytes: (copies * variant.vertex_words() * 4 * vertices) as u64,
        index_bytes: (indices * index_size) as u64,
    }
}

/// Bytes of the flags that all regions share in layout `separate`: two for each vertex of the
/// largest; 0 in the others.
#[must_use]
pub fn shared_flag_bytes(layout: Layout, meshes: &[impl Borrow<RegionMesh>]) -> u64 {
    if layout != Layout::Separate {
        return 0;
    }
    let largest = meshes.iter().map(|mesh| mesh.borrow().vertex_count()).max();
    (2 * FLAG_BYTES * largest.unwrap_or(0)) as u64
}

/// Where one region lies in the scene's buffers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegionSlice {
    /// Vertices are counted as stored: two per mesh vertex when doubled.
    pub(crate) place: VolumePlace,
    /// Its bottom cap can be drawn: its indices are stored, or shaders need none.
    pub(crate) has_bottom: bool,
    pub(crate) vertex_count: u32,
    /// Indices of the strips, or entries of the loop list.
    pub(crate) loop_index_count: u32,
    /// Of those, the last ones: the second walls on inner edges. The first ones, as many, precede them.
    pub(crate) turned_index_count: u32,
}

impl RegionSlice {
    /// Where `other` lies when it takes this one's place; `None` where it has more or fewer vertices
    /// or indices.
    pub(crate) fn replaced_by(&self, other: &Self) -> Option<Self> {
        let place = VolumePlace {
            fixed: other.place.fixed,
            ..self.place
        };
        let moved = Self { place, ..*self };
        let unmoved = |slice: &Self| Self {
            place: VolumePlace {
                fixed: other.place.fixed,
                first_vertex: 0,
                first_triangle_index: 0,
                first_loop_index: slice.place.first_loop_index - slice.place.first_triangle_index,
                ..slice.place
            },
            ..*slice
        };
        (unmoved(self) == unmoved(other)).then_some(moved)
    }

    /// Its indices, caps and then walls, in the list of their width.
    pub(crate) fn indices(&self) -> Range<usize> {
        let end = self.place.first_loop_index + self.loop_index_count;
        self.place.first_triangle_index as usize..end as usize
    }
}

/// Bytes of indices by what they are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct IndexBytes {
    pub(crate) top_caps: u64,
    pub(crate) bottom_caps: u64,
    pub(crate) walls: u64,
    /// Bottom caps that are not stored.
    pub(crate) spared: u64,
}

impl IndexBytes {
    /// Of these regions.
    pub(crate) fn of(layout: Layout, regions: &[RegionSlice]) -> Self {
        let mut bytes = Self::default();
        for slice in regions {
            let index_size = if slice.place.has_short_indices { 2 } else { 4 };
            let cap = 3 * u64::from(slice.place.triangle_count) * index_size;
            bytes.top_caps += cap;
            bytes.walls += u64::from(slice.loop_index_count) * index_size;
            match (layout.is_doubled(), slice.has_bottom) {
                (false, _) => {}
                (true, true) => bytes.bottom_caps += cap,
                (true, false) => bytes.spared += cap,
            }
        }
        bytes
    }
}

/// Meshes as they were laid out, and whether with their bottoms.
pub(crate) type LaidOutMeshes = LaidOut<bool, SceneGeometry>;

/// Contents of a scene's geometry buffers.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct SceneGeometry {
    /// Vertices of [`VertexVariant::vertex_words`] words.
    pub(crate) vertices: Vec<i32>,
    /// Layout `separate`: 0 and 255 in turn, each in [`FLAG_BYTES`].
    pub(crate) flags: Vec<[u8; FLAG_BYTES]>,
    pub(crate) indices: IndexLists,
    pub(crate) regions: Vec<RegionSlice>,
}

impl SceneGeometry {
    /// Lays out every mesh.
    ///
    /// - `has_bottom`: of which ones, by their place, bottom caps are stored, where a layout stores any
    pub(crate) fn build(
        variant: &VertexVariant,
        meshes: &[impl Borrow<RegionMesh>],
        has_bottom: impl Fn(usize) -> bool,
    ) -> Self {
        let mut geometry = Self::build_from(variant, meshes, has_bottom, 0);
        geometry.push_flags(variant, meshes);
        geometry
    }

    /// As [`SceneGeometry::build`], of meshes whose first one is number `first` of its scene, and without the flags
    /// that all share.
    pub(crate) fn build_from(
        variant: &VertexVariant,
        meshes: &[impl Borrow<RegionMesh>],
        has_bottom: impl Fn(usize) -> bool,
        first: usize,
    ) -> Self {
        let mut geometry = Self::default();
        for (place, mesh) in meshes.iter().enumerate() {
            let mesh = ordered(variant, mesh.borrow());
            let stored = geometry.push_vertices(variant, &mesh, first + place);
            let slice = geometry.push_indices(variant, &mesh, has_bottom(place), &stored);
            geometry.regions.push(slice);
        }
        geometry
    }

    /// As [`SceneGeometry::build`], of the meshes that are held; what a set before held is not laid out again.
    pub(crate) fn of_held(
        variant: &VertexVariant,
        meshes: &RegionSet,
        has_bottom: impl Fn(usize) -> bool,
        laid_out: &mut LaidOutMeshes,
    ) -> Self {
        let mut geometry = Self::default();
        let lay_out = |mesh: usize| {
            let alone = &meshes[mesh..=mesh];
            Self::build_from(variant, alone, |_| has_bottom(mesh), mesh)
        };
        let append = |own: &Self| geometry.append(variant, own);
        laid_out.append_all(meshes, &has_bottom, lay_out, append);
        geometry.push_flags(variant, meshes);
        geometry
    }

    /// Puts what `own` has behind its own.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn append(&mut self, variant: &VertexVariant, own: &Self) {
        let first_vertex = (self.vertices.len() / variant.vertex_words()) as u32;
        let [long, short] = [false, true].map(|is_short| self.indices.count(is_short));
        self.vertices.extend(&own.vertices);
        self.indices.append(&own.indices);
        let moved = own.regions.iter().map(|slice| {
            let by = if slice.place.has_short_indices {
                short
            } else {
                long
            };
            let place = slice.place.moved(first_vertex, by, by);
            RegionSlice { place, ..*slice }
        });
        self.regions.extend(moved);
    }

    /// Layout `separate`: two flags for each vertex of the largest region.
    fn push_flags(&mut self, variant: &VertexVariant, meshes: &[impl Borrow<RegionMesh>]) {
        if variant.layout == Layout::Separate {
            let counts = meshes.iter().map(|mesh| mesh.borrow().vertex_count());
            let largest = counts.max().unwrap_or(0);
            let flag = |vertex: usize| [if vertex.is_multiple_of(2) { 0 } else { 255 }, 0, 0, 0];
            self.flags = (0..2 * largest).map(flag).collect();
        }
    }

    /// - `number`: of the mesh, which vertices carry where volumes share draws
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "buffers are refused by the device long before 2^31 elements"
    )]
    fn push_vertices(
        &mut self,
        variant: &VertexVariant,
        mesh: &RegionMesh,
        number: usize,
    ) -> StoredVertices {
        let fixed = FixedPoint::for_mesh(mesh);
        let first_vertex = (self.vertices.len() / variant.vertex_words()) as u32;
        let above_flag = if variant.merges_volumes() {
            2 * number as i32
        } else {
            0
        };
        for (vertex, degrees) in mesh.vertices_ecef.iter().zip(&mesh.vertices_deg) {
            let stored = store(&fixed, variant.positions, *vertex);
            let mut words = stored[..variant.positions.words()].to_vec();
            if variant.normals == Normals::Stored {
                words.extend(bits(geodetic_normal(*degrees).as_vec3()).to_array());
            }
            self.push_vertex(variant, &words, above_flag);
        }
        StoredVertices {
            fixed,
            first_vertex,
        }
    }

    /// Caps and walls.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "buffers are refused by the device long before 2^32 elements"
    )]
    fn push_indices(
        &mut self,
        variant: &VertexVariant,
        mesh: &RegionMesh,
        has_bottom: bool,
        stored: &StoredVertices,
    ) -> RegionSlice {
        let layout = variant.layout;
        let used = mesh.vertices_ecef.len();
        let has_bottom = has_bottom || !layout.is_doubled();
        let triangles = match (variant.index_order, variant.vertex_order) {
            // Ordered within their parts already.
            _ if variant.parts && PartOrder::has_several(mesh) => {
                Cow::Borrowed(mesh.triangles.as_slice())
            }
            (IndexOrder::Cache, VertexOrder::Mesh) => cache_ordered(&mesh.triangles, used),
            _ => Cow::Borrowed(mesh.triangles.as_slice()),
        };
        let short_indices = has_short_indices(layout, used);
        let first_triangle_index = self.indices.count(short_indices);
        self.push_caps(layout, short_indices, &triangles, has_bottom);
        let first_loop_index = self.indices.count(short_indices);
        let mut turned_index_count = 0;
        match layout {
            Layout::Pulled => self.push_loops(short_indices, mesh),
            Layout::PerTriangle => {
                turned_index_count = self.push_inner_walls(short_indices, mesh, &triangles);
            }
            _ if variant.has_strips() => self.push_strips(short_indices, mesh),
            _ => self.push_wall_list(short_indices, mesh),
        }
        let copies = if layout.is_doubled() { 2 } else { 1 };
        RegionSlice {
            place: VolumePlace {
                fixed: stored.fixed,
                first_vertex: stored.first_vertex,
                first_triangle_index,
                first_loop_index,
                triangle_count: mesh.triangles.len() as u32,
                has_short_indices: short_indices,
            },
            has_bottom,
            vertex_count: (copies * used) as u32,
            loop_index_count: self.indices.count(short_indices) - first_loop_index,
            turned_index_count,
        }
    }

    /// - `words`: position, and normal where that is stored
    /// - `above_flag`: what the flag's word holds beside it
    fn push_vertex(&mut self, variant: &VertexVariant, words: &[i32], above_flag: i32) {
        let padding = variant.vertex_words().saturating_sub(words.len() + 1);
        match variant.layout {
            Layout::Doubled | Layout::PerTriangle => {
                for flag in [0, 1] {
                    self.vertices.extend(words);
                    self.vertices.push(above_flag + flag);
                    self.vertices.extend(std::iter::repeat_n(0, padding));
                }
            }
            Layout::Separate => {
                self.vertices.extend(words);
                self.vertices.extend(words);
            }
            Layout::Pulled => self.vertices.extend(words),
        }
    }

    fn push_caps(&mut self, layout: Layout, short: bool, triangles: &[[u32; 3]], has_bottom: bool) {
        // All of the top, then all of the bottom, so that the bottom may be left out of a draw.
        let copies = if layout.is_doubled() { 2 } else { 1 };
        for corner in triangles.as_flattened() {
            self.indices.push(short, copies * corner);
        }
        if layout.is_doubled() && has_bottom {
            for &[a, b, c] in triangles {
                for corner in [a, c, b] {
                    self.indices.push(short, 2 * corner + 1);
                }
            }
        }
    }

    fn push_loops(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            for &vertex in ring.iter().chain(ring.first()) {
                self.indices.push(short, vertex);
            }
            self.indices.push(short, u32::MAX);
        }
    }

    fn push_strips(&mut self, short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            for &vertex in ring.iter().chain(ring.first()) {
                self.indices.push(short, 2 * vertex);
                self.indices.push(short, 2 * vertex + 1);
            }
            self.indices.push(short, u32::MAX);
        }
    }

    fn push_wall_list(&mut self, short: bool, mesh: &RegionMesh) {
        for [start, end] in mesh.boundary_edges() {
            self.push_wall(short, start, end);
        }
    }

    /// A wall along every edge of every triangle: those on the boundary, then one on each inner edge,
    /// then the second one there; gives the number of indices of the last. Two triangles see an
    /// inner edge in opposite directions, and both walls must cancel each other to the pixel.
    ///
    /// The second ones are stored, as the 2007 document counts them, but the first ones are drawn again in
    /// their place with front and back exchanged by the pipeline ([`crate::pipeline::VolumePart::TurnedWalls`]):
    /// nothing can tell the two apart then. Triangles turned over come close, but no closer: clipped, the
    /// rest begins at another corner and is split along another diagonal.
    ///
    /// Where faces are culled, the first ones have draws of their own, alike but for the pipeline. llvmpipe
    /// looks for rectangles in pairs of triangles, and drops the edge-on half of some pairs; where a long
    /// draw is cut decides which pairs there are, and a wall must fare alike both times.
    fn push_inner_walls(&mut self, short: bool, mesh: &RegionMesh, triangles: &[[u32; 3]]) -> u32 {
        let outer: HashSet<[u32; 2]> = mesh.boundary_edges().collect();
        let sides = || {
            let of_each = triangles.iter();
            of_each.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        };
        let all: HashSet<[u32; 2]> = sides().collect();
        let is_alone = |side: &[u32; 2]| outer.contains(side) || !all.contains(&[side[1], side[0]]);
        for [start, end] in sides().filter(is_alone) {
            self.push_wall(short, start, end);
        }
        let is_first = |side: &[u32; 2]| !is_alone(side) && side[0] < side[1];
        let ascending: Vec<_> = sides().filter(is_first).collect();
        for &[start, end] in &ascending {
            self.push_wall(short, start, end);
        }
        let first = self.indices.count(short);
        for [start, end] in ascending {
            for [first, second, third] in wall_triangles(start, end) {
                for index in [first, third, second] {
                    self.indices.push(short, index);
                }
            }
        }
        self.indices.count(short) - first
    }

    fn push_wall(&mut self, short: bool, start: u32, end: u32) {
        for index in wall_triangles(start, end).as_flattened() {
            self.indices.push(short, *index);
        }
    }

    /// Bytes as built.
    pub(crate) fn bytes(&self) -> GeometryBytes {
        GeometryBytes {
            vertex_bytes: (self.vertices.len() * 4 + self.flags.len() * FLAG_BYTES) as u64,
            index_bytes: self.indices.bytes(),
        }
    }
}

/// Where vertices of a region lie.
struct StoredVertices {
    fixed: FixedPoint,
    first_vertex: u32,
}

/// The mesh with its vertices in the order of the variant, and its triangles by part where it is drawn so.
fn ordered<'a>(variant: &VertexVariant, mesh: &'a RegionMesh) -> Cow<'a, RegionMesh> {
    if let Some(triangles) = ordered_by_part(variant, mesh) {
        return Cow::Owned(RegionMesh {
            triangles,
            ..mesh.clone()
        });
    }
    match variant.vertex_order {
        VertexOrder::Mesh => Cow::Borrowed(mesh),
        VertexOrder::FirstUse => Cow::Owned(first_use_ordered(mesh, variant.index_order)),
    }
}

/// The same mesh with its vertices in the order in which its triangles, then its loops, first use them;
/// what nothing uses comes last.
///
/// - `order`: of the triangles, as they will be stored
fn first_use_ordered(mesh: &RegionMesh, order: IndexOrder) -> RegionMesh {
    const NOT_YET: u32 = u32::MAX;
    let triangles = match order {
        IndexOrder::Mesh => Cow::Borrowed(mesh.triangles.as_slice()),
        IndexOrder::Cache => cache_ordered(&mesh.triangles, mesh.vertices_ecef.len()),
    };
    let mut place = vec![NOT_YET; mesh.vertices_ecef.len()];
    let mut ordered = RegionMesh {
        vertices_ecef: Vec::with_capacity(place.len()),
        vertices_deg: Vec::with_capacity(place.len()),
        ..mesh.clone()
    };
    let loops = mesh.boundary_loops.iter().flatten().copied();
    let used = triangles.as_flattened().iter().copied().chain(loops);
    let all = (0..).take(mesh.vertices_ecef.len());
    let mut next = 0;
    for vertex in used.chain(all) {
        if place[vertex as usize] == NOT_YET {
            place[vertex as usize] = next;
            next += 1;
            ordered
                .vertices_ecef
                .push(mesh.vertices_ecef[vertex as usize]);
            ordered
                .vertices_deg
                .push(mesh.vertices_deg[vertex as usize]);
        }
    }
    let moved = |vertex: u32| place[vertex as usize];
    ordered.triangles = triangles.iter().map(|corners| corners.map(moved)).collect();
    for vertex in ordered.boundary_loops.iter_mut().flatten() {
        *vertex = moved(*vertex);
    }
    ordered
}

/// The geodetic normal at a longitude and latitude, which by definition are its angles.
fn geodetic_normal([longitude_deg, latitude_deg]: [f64; 2]) -> DVec3 {
    let (sin_longitude, cos_longitude) = longitude_deg.to_radians().sin_cos();
    let (sin_latitude, cos_latitude) = latitude_deg.to_radians().sin_cos();
    DVec3::new(
        cos_latitude * cos_longitude,
        cos_latitude * sin_longitude,
        sin_latitude,
    )
}

/// How far at most a wall by centric normals is from one by geodetic normals, where it meets a surface that
/// reaches `height_m` above or below the ellipsoid, metres.
///
/// Both go through the same vertex. At height h they are |h| sin δ apart, with δ the angle between the two
/// normals: at most 0.192° on the Earth, at 45° of latitude, which is 37 m at a height of 11 km.
#[must_use]
pub fn centric_shift_m(mesh: &RegionMesh, height_m: f64) -> f64 {
    let vertices = mesh.vertices_ecef.iter().zip(&mesh.vertices_deg);
    let sines = vertices.map(|(ecef, degrees)| {
        let geodetic = geodetic_normal(*degrees);
        geodetic.cross(ecef.normalize_or_zero()).length()
    });
    height_m.abs() * sines.fold(0.0, f64::max)
}

/// The two triangles that a strip of 2·start, 2·start + 1, 2·end, 2·end + 1 has.
fn wall_triangles(start: u32, end: u32) -> [[u32; 3]; 2] {
    [
        [2 * start, 2 * start + 1, 2 * end],
        [2 * end, 2 * start + 1, 2 * end + 1],
    ]
}

/// A position's words; of those only the first [`PositionFormat::words`] are stored.
fn store(fixed: &FixedPoint, format: PositionFormat, ecef: DVec3) -> [i32; 6] {
    let (first, second) = match format {
        PositionFormat::Fixed => (fixed.quantize(ecef), IVec3::ZERO),
        PositionFormat::LocalF32 => (bits((ecef - fixed.origin_ecef).as_vec3()), IVec3::ZERO),
        PositionFormat::EcefF32 => (bits(ecef.as_vec3()), IVec3::ZERO),
        PositionFormat::TwoFloat => {
            let [high, low] = two_float(ecef);
            (bits(high), bits(low))
        }
    };
    let [[x, y, z], [u, v, w]] = [first.to_array(), second.to_array()];
    [x, y, z, u, v, w]
}

#[allow(
    clippy::cast_possible_wrap,
    reason = "the bits of a float are carried in an integer attribute"
)]
fn bits(value: Vec3) -> IVec3 {
    IVec3::from_array(value.to_array().map(|value| value.to_bits() as i32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{VertexSize, Walls};
    use terrafill_fixtures::by_hand::disc;

    #[test]
    fn what_a_view_before_held_is_not_laid_out_again_and_lies_as_if_it_were() {
        // One has long indices.
        let all = RegionSet::from([40, 40_000, 30, 20, 9, 8].map(disc).to_vec());
        for layout in [Layout::Doubled, Layout::Separate] {
            let variant = VertexVariant {
                layout,
                ..VertexVariant::default()
            };
            let of_held = |meshes: &RegionSet, has_bottom: bool, laid_out: &mut LaidOutMeshes| {
                SceneGeometry::of_held(&variant, meshes, |_| has_bottom, laid_out)
            };
            let mut laid_out = LaidOutMeshes::default();
            for (held, has_bottom) in [
                ([0, 1, 5], true),
                ([3, 1, 5], true),
                ([3, 4, 2], true),
                ([3, 4, 2], false),
                ([0, 1, 5], true),
            ] {
                let some = all.with_geometry_of(|mesh| held.contains(&mesh));
                let kept = of_held(&some, has_bottom, &mut laid_out);
                assert!(
                    kept == SceneGeometry::build(&variant, &some, |_| has_bottom),
                    "{held:?}"
                );
                assert_eq!(kept.regions.len(), 6);
            }
            // Negative control: what is laid out wrong stands as it is, until it is asked for otherwise or of
            // another scene.
            let same = all.with_geometry_of(|mesh| [0, 1, 5].contains(&mesh));
            let anew = SceneGeometry::build(&variant, &same, |_| true);
            let mut wrong = LaidOutMeshes::default();
            wrong.keep(&same, |_| true);
            wrong.part(5, true, || {
                SceneGeometry::build(&variant, &[disc(7)], |_| true)
            });
            assert!(of_held(&same, true, &mut wrong) != anew);
            let without = SceneGeometry::build(&variant, &same, |_| false);
            assert!(of_held(&same, false, &mut wrong) == without);
            wrong.keep(&same, |_| false);
            wrong.part(5, true, || {
                SceneGeometry::build(&variant, &[disc(7)], |_| true)
            });
            let other = RegionSet::from(same.to_vec());
            assert!(of_held(&other, true, &mut wrong) == anew);
        }
    }

    /// Every way to store geometry.
    fn every_storage() -> Vec<VertexVariant> {
        let mut all = Vec::new();
        for layout in Layout::ALL {
            for positions in PositionFormat::ALL {
                for walls in [Walls::Strip, Walls::List] {
                    for index_order in [IndexOrder::Mesh, IndexOrder::Cache] {
                        for vertex_size in [VertexSize::Bytes16, VertexSize::Bytes20] {
                            all.push(VertexVariant {
                                layout,
                                positions,
                                walls,
                                index_order,
                                vertex_size,
                                ..VertexVariant::default()
                            });
                        }
                    }
                }
            }
        }
        all.retain(|variant| variant.check_layout().is_ok());
        all
    }

    #[test]
    fn the_formula_and_the_buffers_agree() {
        // Orders, and with each the layouts' choices; none of 20 bytes has two floats.
        assert_eq!(every_storage().len(), 2 * (4 * (4 + 2 + 1 + 1) - 2));
        for count in [3, 100, 32_765, 32_767, 65_534, 65_600] {
            let meshes = [disc(count), disc(7)];
            for variant in every_storage() {
                // The order of indices changes no count, and its search is slow on large discs.
                if count > 100 && variant.index_order == IndexOrder::Cache {
                    continue;
                }
                let built = SceneGeometry::build(&variant, &meshes, |_| true).bytes();
                let mut formula: GeometryBytes = meshes
                    .iter()
                    .map(|mesh| variant_bytes(&variant, mesh))
                    .sum();
                formula.vertex_bytes += shared_flag_bytes(variant.layout, &meshes);
                assert_eq!(built, formula, "{variant:?} {count}");
            }
        }
    }

    #[test]
    fn vertices_in_the_order_of_their_use_are_the_same_mesh() {
        // Triangles that use the last vertex first.
        let mesh = disc(9);
        let ordered = first_use_ordered(&mesh, IndexOrder::Mesh);
        let mut next = 0;
        for &corner in ordered.triangles.as_flattened() {
            assert!(corner <= next, "{corner} after {next}");
            next = next.max(corner + 1);
        }
        // Negative control: as the mesher left them they are in no such order.
        assert!(mesh.triangles[0].iter().any(|&corner| corner > 2));
        let places = |mesh: &RegionMesh| -> Vec<DVec3> {
            let loops = mesh.boundary_loops.iter().flatten();
            let used = mesh.triangles.as_flattened().iter().chain(loops);
            used.map(|&vertex| mesh.vertices_ecef[vertex as usize])
                .collect()
        };
        assert_eq!(places(&ordered), places(&mesh));
        assert_eq!(ordered.vertices_ecef.len(), mesh.vertices_ecef.len());
        assert_eq!(ordered.vertices_deg.len(), mesh.vertices_deg.len());
    }

    #[test]
    fn every_edge_of_every_volume_is_used_once_each_way() {
        let mesh = disc(9);
        for variant in every_storage() {
            if !variant.layout.is_doubled() || variant.has_strips() {
                continue;
            }
            let meshes = std::slice::from_ref(&mesh);
            let geometry = SceneGeometry::build(&variant, meshes, |_| true);
            let short = &geometry.indices.short;
            assert!(is_closed(short), "{variant:?}");
            // Negative control: without its last triangle it is open.
            assert!(!is_closed(&short[..short.len() - 3]));
        }
    }

    fn is_closed(indices: &[u16]) -> bool {
        let mut uses = std::collections::BTreeMap::new();
        for corners in indices.chunks_exact(3) {
            for k in 0..3 {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                *uses.entry((from.min(to), from.max(to))).or_insert(0) +=
                    if from < to { 1 } else { -1 };
            }
        }
        uses.values().all(|&sum| sum == 0)
    }

    #[test]
    fn inner_walls_of_neighbours_are_the_same_triangles_turned_over() {
        let variant = VertexVariant {
            layout: Layout::PerTriangle,
            ..VertexVariant::default()
        };
        let mesh = disc(9);
        let geometry = SceneGeometry::build(&variant, std::slice::from_ref(&mesh), |_| true);
        let walls = &geometry.indices.short[6 * mesh.triangles.len()..];
        // Nine outer edges, nine inner ones seen twice, two triangles each.
        let turned = geometry.regions[0].turned_index_count as usize;
        assert_eq!((turned, walls.len()), (3 * 18, 3 * 3 * 18));
        let (first, second) = walls[walls.len() - 2 * turned..].split_at(turned);
        for (first, second) in first.chunks_exact(3).zip(second.chunks_exact(3)) {
            assert_eq!([second[0], second[2], second[1]], *first);
        }
        // Negative control: those on the boundary are none of them.
        let outer = &walls[..walls.len() - 2 * turned];
        let again = |corners: &[u16]| first.chunks_exact(3).any(|inner| inner == corners);
        assert_eq!(outer.len(), 3 * 18);
        assert!(!outer.chunks_exact(3).any(again));
    }

    #[test]
    fn no_index_collides_with_the_restart_value() {
        for count in [32_766, 65_533, 65_534] {
            let mesh = disc(count);
            let in_mesh_order = |v: &VertexVariant| v.index_order == IndexOrder::Mesh;
            for variant in every_storage().into_iter().filter(in_mesh_order) {
                let meshes = std::slice::from_ref(&mesh);
                let geometry = SceneGeometry::build(&variant, meshes, |_| true);
                let short = geometry.indices.short.iter().filter(|&&i| i == 0xffff);
                let long = geometry.indices.long.iter().filter(|&&i| i == u32::MAX);
                let separates = variant.has_strips() || variant.layout == Layout::Pulled;
                let expected = usize::from(separates);
                assert_eq!(short.count() + long.count(), expected, "{variant:?}");
            }
        }
    }

    /// Bytes of a mesh whose vertices are shared by all its triangles: what a geometry shader reads.
    /// Cozzi (2007): California with 1,056 vertices of 24 bytes and 3,321 16-bit indices, 31,986 bytes.
    fn shared_mesh_bytes(vertices: u64, vertex_size: u64, indices: u64, index_size: u64) -> u64 {
        vertices * vertex_size + indices * index_size
    }

    /// Bytes of one closed volume per triangle over doubled vertices. Per triangle 18 indices: two caps
    /// of 3 and three walls of 4. Cozzi (2007): the same California, 90,540 bytes; with the 24 indices that its text gives
    /// a volume it is 103,824.
    fn per_triangle_volume_bytes(
        vertices: u64,
        vertex_size: u64,
        triangles: u64,
        index_size: u64,
    ) -> u64 {
        2 * vertices * vertex_size + triangles * (2 * 3 + 3 * 4) * index_size
    }

    #[test]
    fn the_2007_documents_arithmetic() {
        assert_eq!(shared_mesh_bytes(1_056, 24, 3_321, 2), 31_986);
        assert_eq!(per_triangle_volume_bytes(1_056, 24, 3_321 / 3, 2), 90_540);
        // Negative controls: another vertex size or index width does not reproduce the document.
        assert_ne!(shared_mesh_bytes(1_056, 20, 3_321, 2), 31_986);
        assert_ne!(per_triangle_volume_bytes(1_056, 24, 3_321 / 3, 4), 90_540);
    }

    #[test]
    fn a_doubled_vertex_is_stored_twice_and_flagged_once() {
        let meshes = [disc(3)];
        for vertex_size in [VertexSize::Bytes16, VertexSize::Bytes20] {
            let variant = VertexVariant {
                vertex_size,
                ..VertexVariant::default()
            };
            let words = variant.vertex_words();
            let geometry = SceneGeometry::build(&variant, &meshes, |_| true);
            for pair in geometry.vertices.chunks(2 * words) {
                assert_eq!(pair[..3], pair[words..words + 3]);
                assert_eq!((pair[3], pair[words + 3]), (0, 1));
            }
        }
        let separate = VertexVariant {
            layout: Layout::Separate,
            ..VertexVariant::default()
        };
        let geometry = SceneGeometry::build(&separate, &meshes, |_| true);
        for pair in geometry.vertices.chunks(6) {
            assert_eq!(pair[..3], pair[3..]);
        }
        for pair in geometry.flags.chunks(2) {
            assert_eq!(pair, [[0, 0, 0, 0], [255, 0, 0, 0]]);
        }
        assert_eq!(geometry.flags.len(), 8);
    }

    #[test]
    fn a_stored_normal_takes_twelve_bytes_and_lies_behind_its_position() {
        let mesh = disc(5);
        let vertices = mesh.vertices_ecef.len() as u64;
        for layout in Layout::ALL {
            let [geodetic, stored, centric] =
                [Normals::Geodetic, Normals::Stored, Normals::Centric].map(|normals| {
                    VertexVariant {
                        layout,
                        normals,
                        ..VertexVariant::default()
                    }
                });
            let bytes = |variant: &VertexVariant| variant_bytes(variant, &mesh);
            assert_eq!(bytes(&centric), bytes(&geodetic));
            let copies = if layout.is_doubled() { 2 } else { 1 };
            let more = bytes(&stored).vertex_bytes - bytes(&geodetic).vertex_bytes;
            assert_eq!(more, 12 * copies * vertices);
            let meshes = [mesh.clone(), disc(7)];
            let built = SceneGeometry::build(&stored, &meshes, |_| true);
            let mut formula: GeometryBytes = meshes.iter().map(|m| variant_bytes(&stored, m)).sum();
            formula.vertex_bytes += shared_flag_bytes(layout, &meshes);
            assert_eq!(built.bytes(), formula, "{layout:?}");
            let plain = SceneGeometry::build(&geodetic, &meshes, |_| true);
            let (words, plain_words) = (stored.vertex_words(), geodetic.vertex_words());
            let both = built
                .vertices
                .chunks(words)
                .zip(plain.vertices.chunks(plain_words));
            for (with, without) in both {
                assert_eq!((&with[..3], &with[6..]), (&without[..3], &without[3..]));
            }
            // The normal itself, by the body's own formula.
            let part = |word: &i32| f64::from(f32::from_bits(word.cast_unsigned()));
            let found = DVec3::from_array([0, 1, 2].map(|i| part(&built.vertices[3 + i])));
            let place = terrafill_core::Ellipsoid::WGS84.ecef_to_geodetic(mesh.vertices_ecef[0]);
            let (longitude, latitude) = (place.longitude_rad, place.latitude_rad);
            let wanted =
                terrafill_core::Ellipsoid::WGS84.geodetic_surface_normal(longitude, latitude);
            assert!(found.distance(wanted) < 1e-7, "{found} {wanted}");
            // Negative control: the direction from the centre is farther off than rounding.
            assert!(found.distance(mesh.vertices_ecef[0].normalize()) > 1e-4);
        }
    }

    #[test]
    fn centric_walls_are_off_by_what_the_flattening_says() {
        use terrafill_core::Ellipsoid;
        let at = |body: &Ellipsoid, latitude: f64| {
            let place = terrafill_core::Geodetic::from_degrees(10.0, latitude, 0.0);
            RegionMesh {
                vertices_ecef: vec![body.geodetic_to_ecef(place)],
                vertices_deg: vec![[10.0, latitude]],
                ..disc(3)
            }
        };
        let earth = Ellipsoid::WGS84;
        // tan ψ = (1 − f)² tan φ gives the greatest difference of both latitudes.
        let ratio = (earth.polar_radius_m() / earth.equatorial_radius_m()).powi(2);
        let delta = 45_f64.to_radians() - ratio.atan();
        let found = centric_shift_m(&at(&earth, 45.0), -11_000.0);
        assert!((found - 11_000.0 * delta.sin()).abs() < 1e-3, "{found}");
        assert!((36.5..37.5).contains(&found), "{found}");
        assert!(centric_shift_m(&at(&earth, 0.0), 11_000.0) < 1e-6);
        assert!(centric_shift_m(&at(&earth, 45.0), 0.0) < 1e-9);
        // Negative control: a body that is more oblate is off by more.
        let saturn = centric_shift_m(&at(&Ellipsoid::SATURN_LIKE, 45.0), -11_000.0);
        assert!(saturn > 20.0 * found, "{saturn}");
    }

    #[test]
    fn two_floats_cost_twelve_bytes_a_stored_vertex_and_bring_back_the_position() {
        let mesh = disc(5);
        let vertices = mesh.vertices_ecef.len() as u64;
        for layout in Layout::ALL {
            let bytes = |positions| {
                let variant = VertexVariant {
                    layout,
                    positions,
                    ..VertexVariant::default()
                };
                variant_bytes(&variant, &mesh)
            };
            let fixed = bytes(PositionFormat::Fixed);
            assert_eq!(bytes(PositionFormat::LocalF32), fixed);
            assert_eq!(bytes(PositionFormat::EcefF32), fixed);
            let copies = if layout.is_doubled() { 2 } else { 1 };
            let two_float = bytes(PositionFormat::TwoFloat);
            let more = two_float.vertex_bytes - fixed.vertex_bytes;
            assert_eq!(more, 12 * copies * vertices);
            assert_eq!(two_float.index_bytes, fixed.index_bytes);
        }
        let fixed = FixedPoint::for_mesh(&mesh);
        let ecef = mesh.vertices_ecef[0];
        let error = |format| {
            let part = |word: i32| f64::from(f32::from_bits(word.cast_unsigned()));
            let [x, y, z, u, v, w] = store(&fixed, format, ecef).map(part);
            (DVec3::new(x + u, y + v, z + w) - ecef).length()
        };
        assert!(error(PositionFormat::TwoFloat) < 1e-7);
        // Negative control: one float is off by decimetres, and so would two be whose second is lost.
        assert!(error(PositionFormat::EcefF32) > 1e-3);
    }
}
