// SPDX-License-Identifier: MIT OR Apache-2.0
//! The buffers as a GPU reads them are closed solids: tests only.
//!
//! What is uploaded is expanded to triangles as input assembly and the shaders in `shaders/vertex`
//! do it, strips with their alternating winding and restarts included, for every layout and format.
//! A corner is the words of its position and which cap it goes to. All that follows on the GPU is a
//! function of those, so corners that agree in them agree in every later rounding as well; that is
//! tried with the shader's own `f32` arithmetic from eyes near and far. Different vertices may fall
//! together: the surface must stay closed by [`check_closed`].

#![allow(
    clippy::print_stdout,
    reason = "a skipped test says why; what falls together is worth reading"
)]

use crate::layout::{RegionSlice, SceneGeometry};
use crate::{Layout, VertexVariant};
use glam::{DVec3, IVec3, Vec3};
use std::path::PathBuf;
use terrafill_core::{
    ClosedSurface, EdgeRule, Ellipsoid, MeshOptions, RegionMesh, VolumeHeights, check_closed,
    parse_regions,
};
use terrafill_frame::PositionFormat;

const LAYOUTS: [Layout; 2] = [Layout::Doubled, Layout::Pulled];
const FORMATS: [PositionFormat; 2] = [PositionFormat::Fixed, PositionFormat::LocalF32];

/// The buffers of a variant with everything else as by default.
fn built(layout: Layout, positions: PositionFormat, meshes: &[RegionMesh]) -> SceneGeometry {
    let variant = VertexVariant {
        layout,
        positions,
        ..VertexVariant::default()
    };
    SceneGeometry::build(&variant, meshes)
}

/// What the vertex stage knows of a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Corner {
    words: [i32; 3],
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

/// Reads the buffers of one region.
struct Reader<'a> {
    geometry: &'a SceneGeometry,
    slice: &'a RegionSlice,
    format: PositionFormat,
}

impl Reader<'_> {
    /// What is read beyond a buffer's end is a fault, whatever a device would make of it.
    fn triangles(&self, layout: Layout) -> Result<Vec<[Corner; 3]>, String> {
        match layout {
            Layout::Doubled => self.doubled(),
            Layout::Pulled => self.pulled(),
            Layout::Separate | Layout::PerTriangle => Err("not read here".to_owned()),
        }
    }

    /// Vertex `vertex` of the buffer, `stride` words each. −0 is 0 to arithmetic.
    fn words(&self, vertex: u32, stride: usize) -> Result<&[i32], String> {
        let first = stride * vertex as usize;
        let words = self.geometry.vertices.get(first..first + stride);
        words.ok_or_else(|| format!("vertex {vertex} is beyond the buffer"))
    }

    fn corner(&self, words: &[i32], is_bottom: bool) -> Corner {
        let words = [words[0], words[1], words[2]];
        let words = match self.format {
            PositionFormat::LocalF32 => words.map(|word| if word == i32::MIN { 0 } else { word }),
            PositionFormat::Fixed => words,
        };
        Corner { words, is_bottom }
    }

    /// Indices of the region's width, from its own buffer.
    fn indices(&self, first: u32, count: u32) -> Result<Vec<u32>, String> {
        let range = first as usize..(first + count) as usize;
        let indices = if self.slice.short_indices {
            let short = self.geometry.short_indices.get(range.clone());
            short.map(|short| short.iter().map(|&index| u32::from(index)).collect())
        } else {
            let long = self.geometry.long_indices.get(range.clone());
            long.map(<[u32]>::to_vec)
        };
        indices.ok_or_else(|| format!("indices {range:?} are beyond the buffer"))
    }

    /// `doubled.wgsl`: 16-byte vertices at the base vertex; list of caps, strips of walls.
    fn doubled(&self) -> Result<Vec<[Corner; 3]>, String> {
        let slice = self.slice;
        let restart = if slice.short_indices {
            0xffff
        } else {
            u32::MAX
        };
        let fetch = |index: u32| -> Result<Corner, String> {
            let vertex = self.words(slice.first_vertex + index, 4)?;
            Ok(self.corner(vertex, vertex[3] != 0))
        };
        let caps = self.indices(slice.first_triangle_index, 6 * slice.triangle_count)?;
        let walls = self.indices(slice.first_loop_index, slice.loop_index_count)?;
        let caps = caps.chunks(3).map(|c| [c[0], c[1], c[2]]);
        caps.chain(strip(&walls, restart))
            .map(|[a, b, c]| Ok([fetch(a)?, fetch(b)?, fetch(c)?]))
            .collect()
    }

    /// `fetch_index` of `pulled.wgsl`: two 16-bit indices a word, low half first.
    fn fetch_index(&self, element: u32) -> Result<u32, String> {
        let beyond = || format!("index {element} is beyond the buffer");
        if !self.slice.short_indices {
            let found = self.geometry.long_indices.get(element as usize);
            return found.copied().ok_or_else(beyond);
        }
        let half = |element: u32| {
            let found = self.geometry.short_indices.get(element as usize);
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
        let words = self.words(self.slice.first_vertex.saturating_add(vertex), 3)?;
        Ok(self.corner(words, is_bottom))
    }

    /// `pulled.wgsl`, invocation by invocation.
    fn pulled(&self) -> Result<Vec<[Corner; 3]>, String> {
        let slice = self.slice;
        let cap = |vertex_index: u32| -> Result<Corner, String> {
            let is_bottom = vertex_index >= 3 * slice.triangle_count;
            let in_cap = vertex_index - u32::from(is_bottom) * 3 * slice.triangle_count;
            let corner = in_cap % 3;
            let slot = if is_bottom { (3 - corner) % 3 } else { corner };
            let element = slice.first_triangle_index + in_cap - corner + slot;
            self.fetch(self.fetch_index(element)?, is_bottom)
        };
        let nowhere = Corner {
            words: [0; 3],
            is_bottom: false,
        };
        let wall = |vertex_index: u32| -> Result<Corner, String> {
            let entry = slice.first_loop_index + vertex_index / 6;
            let corner = vertex_index % 6;
            let (start, end) = (self.fetch_index(entry)?, self.fetch_index(entry + 1)?);
            if start == u32::MAX || end == u32::MAX {
                return Ok(nowhere);
            }
            let is_end = [2, 3, 5].contains(&corner);
            let is_bottom = [1, 4, 5].contains(&corner);
            self.fetch(if is_end { end } else { start }, is_bottom)
        };
        let caps = (0..6 * slice.triangle_count).step_by(3);
        let caps = caps.map(|i| Ok([cap(i)?, cap(i + 1)?, cap(i + 2)?]));
        // A region without a boundary has no list to read.
        let walls = (0..6 * slice.loop_index_count.saturating_sub(1)).step_by(3);
        let walls = walls.map(|i| Ok([wall(i)?, wall(i + 1)?, wall(i + 2)?]));
        caps.chain(walls).collect()
    }

    /// Metres from the region's origin, at height 0.
    fn local_m(&self, corner: Corner) -> DVec3 {
        match self.format {
            PositionFormat::Fixed => {
                IVec3::from_array(corner.words).as_dvec3() * self.slice.fixed.unit_m
            }
            PositionFormat::LocalF32 => f32_words(corner).as_dvec3(),
        }
    }

    /// `eye_relative_m` of `shared/region.wgsl` with its caller's height, in `f32` throughout.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    fn eye_relative(&self, eye_ecef: DVec3, scene: &Scene, corner: Corner) -> Vec3 {
        let fixed = &self.slice.fixed;
        let origin = fixed.origin_ecef.as_vec3();
        let (relative, ecef) = match self.format {
            PositionFormat::LocalF32 => {
                let local = f32_words(corner);
                let eye = (eye_ecef - fixed.origin_ecef).as_vec3();
                (local - eye, origin + local)
            }
            PositionFormat::Fixed => {
                let eye = fixed.eye(eye_ecef);
                let stored = IVec3::from_array(corner.words);
                let difference = (stored >> eye.shift) - eye.eye;
                let scale = (fixed.unit_m * f64::from(eye.shift).exp2()) as f32;
                let relative = difference.as_vec3() * scale - eye.remainder_m.as_vec3();
                (relative, origin + stored.as_vec3() * fixed.unit_m as f32)
            }
        };
        let (a, b) = (
            scene.body.equatorial_radius_m(),
            scene.body.polar_radius_m(),
        );
        let normal_scale = Vec3::new(1.0, 1.0, (a / b).powi(2) as f32);
        let VolumeHeights { top_m, bottom_m } = scene.heights;
        let height_m = if corner.is_bottom { bottom_m } else { top_m };
        relative + (ecef * normal_scale).normalize() * height_m as f32
    }
}

#[allow(
    clippy::cast_sign_loss,
    reason = "the bits of a float are carried in an integer attribute"
)]
fn f32_words(corner: Corner) -> Vec3 {
    Vec3::from_array(corner.words.map(|word| f32::from_bits(word as u32)))
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
fn triangle_count(layout: Layout, mesh: &RegionMesh) -> usize {
    let drawn = 2 * (mesh.triangle_count() + mesh.boundary_edge_count());
    match layout {
        Layout::Doubled | Layout::Separate | Layout::PerTriangle => drawn,
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
            let report = mesh.check_volume_invariants(&body, heights);
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

    fn check(&self, layout: Layout, format: PositionFormat) -> Result<Count, String> {
        let geometry = built(layout, format, &self.meshes);
        self.check_built(&geometry, layout, format)
    }

    /// Closed by the words in the buffers, and of the volume that `core` finds.
    fn check_built(
        &self,
        geometry: &SceneGeometry,
        layout: Layout,
        format: PositionFormat,
    ) -> Result<Count, String> {
        let mut count = Count::default();
        let known = self.meshes.iter().zip(&self.volumes_m3);
        for (slice, (mesh, expected_m3)) in geometry.regions.iter().zip(known) {
            let fail = |what: String| format!("{} ({layout:?}, {format:?}): {what}", mesh.name);
            let reader = Reader {
                geometry,
                slice,
                format,
            };
            let triangles = reader.triangles(layout).map_err(fail)?;
            let closed =
                check_closed(triangles.iter().copied()).map_err(|open| fail(open.to_string()))?;
            let expected = triangle_count(layout, mesh);
            if closed.triangles != expected {
                let found = closed.triangles;
                return Err(fail(format!("{found} triangles, not {expected}")));
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
            let normal = ((reader.slice.fixed.origin_ecef + local) * normal_scale).normalize();
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
        let step_m = match reader.format {
            PositionFormat::Fixed => reader.slice.fixed.unit_m,
            PositionFormat::LocalF32 => reader.slice.fixed.unit_m * 128.0,
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
    fn check_from_eyes(&self, layout: Layout, format: PositionFormat) -> Result<Count, String> {
        let geometry = built(layout, format, &self.meshes);
        let mut count = Count::default();
        for (slice, mesh) in geometry.regions.iter().zip(&self.meshes) {
            let reader = Reader {
                geometry: &geometry,
                slice,
                format,
            };
            let triangles: Vec<[Corner; 3]> = reader
                .triangles(layout)?
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

fn shapes(body: Ellipsoid) -> Scene {
    let meshes = SHAPES.iter().enumerate().flat_map(|(i, shape)| {
        let text = format!(r#"{{"type":"Polygon","coordinates":{shape}}}"#);
        let mut meshes = meshes_of(text.as_bytes(), "shape", &body, EdgeRule::Planar);
        meshes
            .iter_mut()
            .for_each(|mesh| mesh.name = format!("shape {i}"));
        meshes
    });
    let meshes: Vec<RegionMesh> = meshes.collect();
    assert_eq!(meshes.len(), SHAPES.len());
    Scene::new(body, meshes)
}

#[test]
fn every_layout_and_format_of_hard_shapes_is_closed() {
    for body in Ellipsoid::ALL {
        let scene = shapes(body);
        for layout in LAYOUTS {
            for format in FORMATS {
                let count = scene.check(layout, format);
                let count = count.unwrap_or_else(|what| panic!("{}: {what}", body.name()));
                println!("{}, {layout:?}, {format:?}: {count:?}", body.name());
                // The layouts differ in how corners are found, not in what becomes of them.
                if layout == Layout::Doubled {
                    let from_eyes = scene.check_from_eyes(layout, format).expect("closed");
                    println!("from eyes: {from_eyes:?}");
                }
            }
        }
    }
}

#[test]
fn every_layout_and_format_of_the_countries_is_closed() {
    let Some(root) = std::env::var_os("TERRAFILL_DATA").map(PathBuf::from) else {
        println!("skipped: TERRAFILL_DATA is not set");
        return;
    };
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (name, rule) in [
        ("ne_110m_admin_0_countries.geojson", EdgeRule::Planar),
        ("ne_110m_admin_0_countries.geojson", EdgeRule::GreatEllipse),
        ("ne_50m_admin_0_countries.geojson", EdgeRule::Planar),
        ("us_counties_10m.geojson", EdgeRule::Planar),
        ("ne_10m_admin_0_countries.geojson", EdgeRule::Planar),
    ] {
        let path = workspace.join(&root).join("vectors").join(name);
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(error) => {
                println!("skipped: {}: {error}", path.display());
                return;
            }
        };
        let body = Ellipsoid::WGS84;
        let scene = Scene::new(body, meshes_of(&text, name, &body, rule));
        let mut widths = [0, 0];
        for layout in LAYOUTS {
            for format in FORMATS {
                // A million vertices once are enough.
                if name.starts_with("ne_10m") && format == PositionFormat::LocalF32 {
                    continue;
                }
                let count = scene
                    .check(layout, format)
                    .unwrap_or_else(|what| panic!("{name}, {rule:?}: {what}"));
                println!("{name}, {rule:?}, {layout:?}, {format:?}: {count:?}");
            }
            let geometry = built(layout, PositionFormat::Fixed, &scene.meshes);
            for slice in &geometry.regions {
                widths[usize::from(slice.short_indices)] += 1;
            }
        }
        // The largest file has regions with long indices in both layouts.
        let has_long = name.starts_with("ne_10m");
        assert_eq!(widths[0] > 0, has_long, "{name}: {widths:?}");
    }
}

// ---- what must be noticed ---------------------------------------------------------------------

/// Two regions, so that the second one's offsets count; the first has a hole.
fn pair() -> Scene {
    let body = Ellipsoid::WGS84;
    let mut scene = shapes(body);
    scene.meshes = vec![scene.meshes[0].clone(), scene.meshes[5].clone()];
    Scene::new(body, scene.meshes)
}

/// Applies `change` at each place below `count`; every result must be noticed, but where it says
/// that it changed nothing.
fn each_noticed(
    layout: Layout,
    count: &dyn Fn(&SceneGeometry) -> usize,
    change: &dyn Fn(&mut SceneGeometry, usize) -> bool,
) {
    let scene = pair();
    for format in FORMATS {
        let places = count(&built(layout, format, &scene.meshes));
        assert!(places > 50, "{places} places");
        for place in 0..places {
            let mut geometry = built(layout, format, &scene.meshes);
            if !change(&mut geometry, place) {
                continue;
            }
            let noticed = scene.check_built(&geometry, layout, format).is_err();
            assert!(noticed, "{layout:?}, {format:?}, {place}");
        }
    }
}

#[test]
fn every_index_that_is_another_is_noticed() {
    for layout in LAYOUTS {
        each_noticed(
            layout,
            &|geometry| geometry.short_indices.len(),
            &|geometry, place| {
                let index = &mut geometry.short_indices[place];
                // The next vertex; a restart becomes one, too, and no longer restarts. Vertex 0
                // would not do: a loop that ends there gets a wall of no length.
                let is_single = layout == Layout::Pulled && *index != 0xffff;
                *index = index.wrapping_add(if is_single { 1 } else { 2 });
                true
            },
        );
    }
    // The same vertex, but its copy in the other cap.
    each_noticed(
        Layout::Doubled,
        &|geometry| geometry.short_indices.len(),
        &|geometry, place| {
            // A restart becomes an index beyond the buffer.
            geometry.short_indices[place] ^= 1;
            true
        },
    );
}

#[test]
fn two_indices_that_have_changed_places_are_noticed() {
    for layout in LAYOUTS {
        each_noticed(
            layout,
            &|geometry| geometry.short_indices.len() - 1,
            &|geometry, place| {
                geometry.short_indices.swap(place, place + 1);
                geometry.short_indices[place] != geometry.short_indices[place + 1]
            },
        );
    }
}

#[test]
fn every_flag_that_is_wrong_is_noticed() {
    each_noticed(
        Layout::Doubled,
        &|geometry| geometry.vertices.len() / 4,
        &|geometry, place| {
            geometry.vertices[4 * place + 3] ^= 1;
            true
        },
    );
}

#[test]
fn offsets_of_another_region_are_noticed() {
    let scene = pair();
    for layout in LAYOUTS {
        let mutants: [fn(&mut RegionSlice); 6] = [
            |slice| slice.first_vertex -= 1,
            |slice| slice.first_triangle_index -= 1,
            |slice| slice.first_loop_index -= 1,
            |slice| slice.triangle_count -= 1,
            |slice| slice.loop_index_count -= 3,
            |slice| slice.fixed.unit_m *= 2.0,
        ];
        for (i, mutant) in mutants.iter().enumerate() {
            let mut geometry = built(layout, PositionFormat::Fixed, &scene.meshes);
            mutant(&mut geometry.regions[1]);
            let found = scene.check_built(&geometry, layout, PositionFormat::Fixed);
            assert!(found.is_err(), "{layout:?}, {i}");
        }
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
