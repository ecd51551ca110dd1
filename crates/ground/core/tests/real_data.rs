// SPDX-License-Identifier: MIT OR Apache-2.0
//! Real outlines: every region sound, borders shared, areas
//! right by arithmetic that shares nothing with the mesher.

use crate::outlines::{RULES, assert_sound, outline, repaired};
use std::collections::BTreeSet;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionMesh, Ring, parse_regions,
};

fn meshes(regions: &[Region], rule: EdgeRule) -> Vec<RegionMesh> {
    let body = Ellipsoid::WGS84;
    let meshes =
        RegionMesh::build_all(regions, &body, rule, &MeshOptions::default()).expect("meshes");
    for mesh in &meshes {
        assert_sound(mesh, &body);
    }
    meshes
}

/// `|∮ (Z − Z₀) dλ|` by Simpson's rule in 64 steps an edge, from the file's own vertices.
fn ring_area_m2(ring: &Ring) -> f64 {
    let body = Ellipsoid::WGS84;
    let z = |latitude_deg: f64| body.zone_area_per_radian(latitude_deg.to_radians());
    let reference = z(ring.vertices_deg()[0][1]);
    let mut sum = 0.0;
    for (start, end) in ring.edges_deg() {
        let width = (end[0] - start[0]).to_radians();
        let at = |k: u32| z(start[1] + (end[1] - start[1]) * f64::from(k) / 64.0) - reference;
        let simpson: f64 = (0..32)
            .map(|k| at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2))
            .sum();
        sum += width * simpson / (3.0 * 64.0);
    }
    let closed_over = |pole| (sum - ring.winding_deg().to_radians() * (z(pole) - reference)).abs();
    // Round a pole the smaller side.
    closed_over(90.0).min(closed_over(-90.0))
}

#[test]
#[ignore = "needs data: natural-earth-110m, us-10m, california-counties"]
fn every_region_of_the_small_files_is_sound_by_both_rules() {
    for name in [
        "ne_110m_admin_0_countries.geojson",
        "ne_110m_land.geojson",
        "ne_110m_admin_1_us_states.geojson",
        "us_states_10m.geojson",
        "california_counties.geojson",
    ] {
        for rule in RULES {
            let regions = repaired(name, rule);
            assert_eq!(meshes(&regions, rule).len(), regions.len());
        }
    }
}

/// Meshes every region of a file, those with crossings repaired, and compares areas with those of the
/// rings; of crossing rings these are not what even-odd fills. Returns how many of those differ.
fn compare_areas(name: &str, [count, crossing]: [usize; 2]) -> usize {
    let rule = EdgeRule::Planar;
    let mut regions = parse_regions(&outline(name), name).expect("valid");
    let crossings: Vec<usize> = regions
        .iter_mut()
        .map(|region| region.split_at_crossings(rule))
        .collect();
    let crossed = crossings.iter().filter(|&&crossings| crossings > 0).count();
    assert_eq!([regions.len(), crossed], [count, crossing], "{name}");
    let (mut worst, mut apart) = (0.0_f64, 0);
    let meshes = meshes(&regions, rule);
    for ((mesh, region), crossings) in meshes.iter().zip(&regions).zip(crossings) {
        let exact: f64 = region
            .polygons
            .iter()
            .map(|polygon| {
                let holes: f64 = polygon.holes.iter().map(ring_area_m2).sum();
                ring_area_m2(&polygon.shell) - holes
            })
            .sum();
        let error = (mesh.area_m2 / exact - 1.0).abs();
        if crossings == 0 {
            assert!(error < 1e-9, "{name}, {}: {error:e}", mesh.name);
            worst = worst.max(error);
        } else {
            apart += usize::from(error > 1e-9);
        }
    }
    eprintln!(
        "{name}: {count} regions sound; areas of the {} without crossings within {worst:.1e} of \
         their rings'",
        count - crossing
    );
    apart
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m"]
fn every_region_of_the_countries_has_the_area_of_its_rings() {
    for (scale, count) in [("110m", [177, 1]), ("50m", [241, 0])] {
        let name = format!("ne_{scale}_admin_0_countries.geojson");
        compare_areas(&name, count);
    }
}

#[test]
#[ignore = "needs data: natural-earth-10m"]
fn every_region_of_the_10m_countries_has_the_area_of_its_rings() {
    compare_areas("ne_10m_admin_0_countries.geojson", [258, 0]);
}

#[test]
#[ignore = "needs data: us-10m"]
fn every_county_has_the_area_of_its_rings() {
    let differ = compare_areas("us_counties_10m.geojson", [3197, 21]);
    // Negative control: where rings cross the comparison sees that areas differ.
    assert!(differ > 10, "{differ}");
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn antarctica_has_no_wall_at_the_antimeridian_or_the_pole() {
    // Cut at ±180 and run along −90.
    for name in ["ne_110m_admin_0_countries.geojson", "ne_110m_land.geojson"] {
        let regions = repaired(name, EdgeRule::Planar);
        let antarctica: Vec<Region> = regions
            .into_iter()
            .filter(|region| {
                region
                    .rings()
                    .any(|ring| ring.vertices_deg().iter().any(|v| v[1] == -90.0))
            })
            .collect();
        let meshes = meshes(&antarctica, EdgeRule::Planar);
        let holds_pole = |mesh: &&RegionMesh| mesh.vertices_deg.iter().any(|v| v[1] == -90.0);
        let mesh = meshes.iter().find(holds_pole).expect("holds the pole");
        let poles = mesh.vertices_deg.iter().filter(|vertex| vertex[1] == -90.0);
        assert_eq!(poles.count(), 1, "{name}");
        assert!(southernmost_border_deg(mesh) > -86.0, "{name}");
        assert_eq!(
            (mesh.extent.west_deg, mesh.extent.east_deg),
            (-180.0, 180.0)
        );
    }
}

#[test]
#[ignore = "needs data: natural-earth-50m"]
fn antarctica_at_50m_keeps_the_hole_that_its_file_leaves_round_the_pole() {
    // The ring goes back along the parallel of −89.9989°, 120 m from the pole.
    let regions = repaired("ne_50m_admin_0_countries.geojson", EdgeRule::Planar);
    let antarctica: Vec<Region> = regions
        .into_iter()
        .filter(|region| region.name == "Antarctica")
        .collect();
    let mesh = &meshes(&antarctica, EdgeRule::Planar)[0];
    assert!((southernmost_border_deg(mesh) + 89.998_925_781_25).abs() < 1e-9);
    let along_cut = |&&i: &&u32| {
        let [longitude, latitude] = mesh.vertices_deg[i as usize];
        longitude.abs() == 180.0 && (-89.9..-84.4).contains(&latitude)
    };
    assert_eq!(
        mesh.boundary_loops
            .iter()
            .flatten()
            .filter(along_cut)
            .count(),
        0
    );
}

fn southernmost_border_deg(mesh: &RegionMesh) -> f64 {
    let border = mesh.boundary_loops.iter().flatten();
    border
        .map(|&i| mesh.vertices_deg[i as usize][1])
        .fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "needs data: us-10m"]
fn neighbours_have_the_same_vertices_on_their_border() {
    for rule in RULES {
        let regions = repaired("us_states_10m.geojson", rule);
        let meshes = meshes(&regions, rule);
        let state = |name: &str| {
            let index = regions.iter().position(|region| region.name == name);
            let index = index.unwrap_or_else(|| panic!("no {name}"));
            let mesh = &meshes[index];
            let border: BTreeSet<[u64; 3]> = mesh
                .boundary_loops
                .iter()
                .flatten()
                .map(|&i| mesh.vertices_ecef[i as usize].to_array().map(f64::to_bits))
                .collect();
            let file: BTreeSet<[u64; 2]> = regions[index]
                .rings()
                .flat_map(Ring::vertices_deg)
                .map(|vertex| vertex.map(f64::to_bits))
                .collect();
            (border, file)
        };
        for (a, b) in [("Colorado", "Wyoming"), ("North Dakota", "South Dakota")] {
            let ((border_a, file_a), (border_b, file_b)) = (state(a), state(b));
            let in_file = file_a.intersection(&file_b).count();
            let in_mesh = border_a.intersection(&border_b).count();
            assert!(in_file >= 2);
            // Every shared file vertex, and the points that split the edges between them.
            assert!(in_mesh > in_file, "{a}, {b}: {in_mesh} of {in_file}");
        }
    }
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn outlines_that_cross_themselves_are_refused_until_repaired() {
    let name = "ne_110m_admin_0_countries.geojson";
    let regions = parse_regions(&outline(name), name).expect("valid");
    let errors = RegionMesh::build_all(
        &regions,
        &Ellipsoid::WGS84,
        EdgeRule::Planar,
        &MeshOptions::default(),
    )
    .expect_err("Sudan crosses itself");
    assert_eq!(errors.len(), 1);
    assert!(matches!(&errors[0], MeshError::SelfCrossing { name, .. } if name == "Sudan"));
}

#[test]
#[ignore = "needs data: earcut"]
fn rings_in_pixel_coordinates_are_refused_as_a_bare_list() {
    let message = parse_regions(&outline("tricky/earcut_dude.json"), "dude")
        .expect_err("no GeoJSON")
        .to_string();
    assert!(
        message.starts_with("dude: the file is a bare list"),
        "{message}"
    );
}
