// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layouts of volumes: what is stored, and how many bytes of it.

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
        let [geodetic, stored, centric] = [Normals::Geodetic, Normals::Stored, Normals::Centric]
            .map(|normals| VertexVariant {
                layout,
                normals,
                ..VertexVariant::default()
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
        let wanted = terrafill_core::Ellipsoid::WGS84.geodetic_surface_normal(longitude, latitude);
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
