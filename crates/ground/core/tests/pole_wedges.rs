// SPDX-License-Identifier: MIT OR Apache-2.0
//! Planar edges that run slantwise into a pole: however narrow what they enclose, its area is kept.
//!
//! On the body every longitude at a pole is the same point, so near it such an edge turns round the
//! pole ever faster. Areas are compared with quadrature on the unit sphere in the distance from the
//! pole, which has no cancellation however close to it.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, InvariantViolation, MeshOptions, RegionMesh};
use terrafill_fixtures::{check_extruded, region};

/// From one vertex at `west_deg`, `height_deg` below the north pole, two edges to the pole, written
/// there at two longitudes.
struct Wedge {
    name: &'static str,
    height_deg: f64,
    west_deg: f64,
    ends_deg: [f64; 2],
}

const WEDGES: [Wedge; 9] = [
    wedge("wide", 10.0, 0.0, [50.0, 60.0]),
    wedge("narrow", 10.0, 0.0, [50.0, 50.001]),
    wedge("a hair", 10.0, 0.0, [50.0, 50.000_001]),
    wedge("one edge a meridian", 10.0, 50.0, [50.0, 50.01]),
    wedge("either side of a meridian", 5.0, 20.0, [19.9, 20.1]),
    wedge("within the tolerance", 0.001, 0.0, [50.0, 51.0]),
    wedge("a metre high", 1e-5, 0.0, [50.0, 80.0]),
    wedge("a metre high and almost round", 1e-5, 0.0, [-170.0, 170.0]),
    wedge("a millimetre high", 1e-8, 10.0, [20.0, 30.0]),
];

const fn wedge(name: &'static str, height_deg: f64, west_deg: f64, ends_deg: [f64; 2]) -> Wedge {
    Wedge {
        name,
        height_deg,
        west_deg,
        ends_deg,
    }
}

impl Wedge {
    fn ring(&self, pole_deg: f64) -> Vec<[f64; 2]> {
        let [a, b] = self.ends_deg;
        let vertex = (90.0 - self.height_deg).copysign(pole_deg);
        vec![[self.west_deg, vertex], [a, pole_deg], [b, pole_deg]]
    }

    /// On the unit sphere: `∫ sin d · w(d) dd`, the width w growing from nothing to all of it.
    fn area(&self) -> f64 {
        // What the file's number says, not what was meant.
        let height = (90.0 - (90.0 - self.height_deg)).to_radians();
        let width = (self.ends_deg[1] - self.ends_deg[0]).to_radians();
        simpson(|share| {
            let distance = share * height;
            distance.sin() * width * (1.0 - share) * height
        })
    }
}

/// `∫ f` over 0 … 1.
fn simpson(f: impl Fn(f64) -> f64) -> f64 {
    let at = |k: u32| f(f64::from(k) / 2048.0);
    let sum: f64 = (0..1024)
        .map(|k| at(2 * k) + 4.0 * at(2 * k + 1) + at(2 * k + 2))
        .sum();
    sum / (3.0 * 2048.0)
}

fn build(body: &Ellipsoid, tolerance: f64, rings: &[Vec<[f64; 2]>]) -> RegionMesh {
    let region = region(&format!("{rings:?}"));
    let options = MeshOptions {
        boundary_tolerance_m: tolerance * body.equatorial_radius_m(),
        ..MeshOptions::default()
    };
    RegionMesh::build(&region, body, EdgeRule::Planar, &options).expect("meshes")
}

#[test]
fn a_wedge_keeps_its_area_whatever_the_tolerance() {
    let body = Ellipsoid::UNIT_SPHERE;
    for wedge in &WEDGES {
        for pole_deg in [90.0, -90.0] {
            for tolerance in [1e-7, 1e-5, 1e-3, 0.1] {
                let mesh = build(&body, tolerance, &[wedge.ring(pole_deg)]);
                let error = (mesh.area_m2 / wedge.area() - 1.0).abs();
                // What splits the edges is rounded to some 1e-14°, out of the wedge's height and
                // width, and its area is a difference between what lies under its two sides.
                let width_deg = wedge.ends_deg[1] - wedge.ends_deg[0];
                let allowed = 1e-11 + 1e-13 / wedge.height_deg + 3e-14 / width_deg;
                let name = wedge.name;
                assert!(error < allowed, "{name} {pole_deg} {tolerance}: {error:e}");
                assert_eq!(mesh.check_invariants(&body), Ok(()), "{name} {tolerance}");
                let fault = check_extruded(&mesh, &body).err();
                assert_eq!(fault, None, "{name} {tolerance}");
                assert_eq!(mesh.boundary_loops.len(), 1, "{name}");
            }
        }
    }
}

#[test]
fn every_body_meshes_every_wedge_soundly() {
    for body in Ellipsoid::ALL {
        for wedge in &WEDGES {
            let mesh = build(&body, 1e-5, &[wedge.ring(90.0)]);
            let result = mesh.check_invariants(&body);
            assert_eq!(result, Ok(()), "{} {}", wedge.name, body.name());
            let fault = check_extruded(&mesh, &body).err();
            assert_eq!(fault, None, "{} {}", wedge.name, body.name());
        }
    }
}

#[test]
fn two_edges_from_one_vertex_drawn_as_one_are_noticed() {
    // Negative control: what used to happen, done to a sound mesh by hand.
    let body = Ellipsoid::UNIT_SPHERE;
    let wedge = &WEDGES[5];
    let mut mesh = build(&body, 1e-5, &[wedge.ring(90.0)]);
    for i in 0..mesh.vertices_deg.len() {
        let [_, latitude] = mesh.vertices_deg[i];
        if latitude < 90.0 && 90.0 - latitude < 0.5 * wedge.height_deg {
            // Half of the way into the wedge from either side.
            let share = (90.0 - latitude) / wedge.height_deg;
            let middle = 50.5 * (1.0 - share);
            let longitude = 0.5 * (mesh.vertices_deg[i][0] + middle);
            mesh.vertices_deg[i][0] = longitude;
            mesh.vertices_ecef[i] =
                body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, 0.0));
        }
    }
    let violation = mesh.check_invariants(&body).expect_err("must be caught");
    assert!(
        matches!(violation, InvariantViolation::Area { .. }),
        "{violation}"
    );
}

#[test]
fn wedges_side_by_side_have_the_same_vertices_on_the_edge_between_them() {
    let body = Ellipsoid::WGS84;
    let ring = |a: f64, b: f64| vec![[0.0, 80.0], [a, 90.0], [b, 90.0]];
    let (left, right) = (ring(50.0, 60.0), ring(60.0, 60.000_01));
    let [left, right] = [left, right].map(|ring| build(&body, 1e-5, &[ring]));
    let on_edge = |mesh: &RegionMesh| {
        let mut found: Vec<[u64; 2]> = mesh
            .vertices_deg
            .iter()
            .filter(|[longitude, latitude]| {
                let line = 60.0 * (latitude - 80.0) / 10.0;
                (longitude - line).abs() < 1e-9 * (90.0 - latitude).max(1e-3)
            })
            .map(|position| position.map(f64::to_bits))
            .collect();
        found.sort_unstable();
        found
    };
    // The hair's other edge is nearer than that to the edge between them only at its two ends.
    let (left, right) = (on_edge(&left), on_edge(&right));
    assert!(left.len() > 18);
    assert!(left.iter().all(|position| right.contains(position)));
}

/// Rings that touch a pole at several longitudes, with vertices at all distances from it.
fn ring_into_a_pole() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let wedge = (
        0.05..1.0_f64,
        prop_oneof![Just(1.0), Just(0.1), Just(1e-3), Just(1e-6)],
        -7.0..1.5_f64,
    );
    prop::collection::vec(wedge, 2..8).prop_map(|wedges| {
        // Along the pole and below it, both from west to east: nothing crosses.
        let total: f64 = wedges.iter().map(|(step, factor, _)| step * factor).sum();
        let mut longitude = -170.0;
        let mut ring: Vec<[f64; 2]> = Vec::new();
        let mut below: Vec<[f64; 2]> = Vec::new();
        for (step, factor, exponent) in wedges {
            ring.push([longitude, 90.0]);
            let slant = 150.0 / total * step * factor;
            below.push([0.3 * longitude, 90.0 - 10_f64.powf(exponent)]);
            longitude += slant;
        }
        ring.push([longitude, 90.0]);
        below.reverse();
        ring.extend(below);
        ring
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        cases: 300,
        rng_seed: RngSeed::Fixed(90),
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_runs_into_a_pole_and_meshes_is_sound(
        ring in ring_into_a_pole(),
        body in prop::sample::select(Ellipsoid::ALL.to_vec()),
        tolerance in prop_oneof![Just(1e-7), Just(1e-5), Just(1e-3)],
    ) {
        let mut region = region(&format!("[{ring:?}]"));
        region.split_at_crossings(EdgeRule::Planar);
        let options = MeshOptions {
            boundary_tolerance_m: tolerance * body.equatorial_radius_m(),
            ..MeshOptions::default()
        };
        let mesh = RegionMesh::build(&region, &body, EdgeRule::Planar, &options);
        let mesh = mesh.map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(mesh.check_invariants(&body), Ok(()));
        prop_assert_eq!(check_extruded(&mesh, &body).err(), None);
    }
}
