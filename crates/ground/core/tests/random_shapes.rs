// SPDX-License-Identifier: MIT OR Apache-2.0
//! Random rings, tangled ones included: whatever meshes must be sound, and has to mesh once its
//! crossings are vertices.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionMesh, parse_regions,
};
use terrafill_fixtures::check_extruded;

/// GeoJSON of rings; each vertex at an angle and a distance from a centre.
fn region(centre: [f64; 2], rings: &[Vec<(f64, f64)>], stretch: f64) -> Option<Region> {
    let rings: Vec<String> = rings
        .iter()
        .map(|ring| {
            let vertices: Vec<String> = ring
                .iter()
                .map(|(angle, distance)| {
                    let longitude = centre[0] + stretch * distance * angle.cos();
                    let latitude = (centre[1] + distance * angle.sin()).clamp(-90.0, 90.0);
                    format!("[{longitude},{latitude}]")
                })
                .collect();
            format!("[{}]", vertices.join(","))
        })
        .collect();
    let text = format!(
        r#"{{"type":"Polygon","coordinates":[{}]}}"#,
        rings.join(",")
    );
    let regions = parse_regions(text.as_bytes(), "random").ok()?;
    regions.into_iter().next()
}

fn vertex(largest_deg: f64) -> impl Strategy<Value = (f64, f64)> {
    (0.0..std::f64::consts::TAU, 0.01 * largest_deg..largest_deg)
}

/// Rings of random vertices, in random order or sorted round their centre.
fn rings() -> impl Strategy<Value = Vec<Vec<(f64, f64)>>> {
    let sizes = prop_oneof![Just(1e-4), Just(0.1), Just(3.0), Just(20.0)];
    (sizes, any::<bool>()).prop_flat_map(|(size, sorted)| {
        let ring = prop::collection::vec(vertex(size), 3..12).prop_map(move |mut ring| {
            if sorted {
                ring.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            ring
        });
        prop::collection::vec(ring, 1..3)
    })
}

fn body() -> impl Strategy<Value = Ellipsoid> {
    prop::sample::select(Ellipsoid::ALL.to_vec())
}

fn centre() -> impl Strategy<Value = [f64; 2]> {
    let longitude = prop_oneof![-180.0..180.0_f64, Just(180.0), Just(-180.0), Just(0.0)];
    let latitude = prop_oneof![
        -90.0..90.0_f64,
        Just(0.0),
        Just(88.0),
        Just(-89.9),
        Just(90.0)
    ];
    [longitude.boxed(), latitude.boxed()]
}

/// The same shapes on every run, so that a failure can be looked at; `PROPTEST_CASES` and
/// `PROPTEST_RNG_SEED` ask for more and for others.
fn configuration() -> ProptestConfig {
    let mut configuration = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    if std::env::var_os("PROPTEST_CASES").is_none() {
        configuration.cases = 600;
    }
    if std::env::var_os("PROPTEST_RNG_SEED").is_none() {
        configuration.rng_seed = RngSeed::Fixed(2007);
    }
    configuration
}

proptest! {
    #![proptest_config(configuration())]

    #[test]
    fn whatever_meshes_is_sound_and_crossings_are_all_that_must_be_repaired(
        centre in centre(),
        rings in rings(),
        stretch in prop_oneof![Just(1.0), Just(5.0)],
        body in body(),
        great_ellipse in any::<bool>(),
        tolerance in prop_oneof![Just(1e-6), Just(1e-4)],
    ) {
        let rule = if great_ellipse { EdgeRule::GreatEllipse } else { EdgeRule::Planar };
        let options = MeshOptions {
            boundary_tolerance_m: tolerance * body.equatorial_radius_m(),
            cap_step_deg: 3.0,
        };
        let Some(mut region) = region(centre, &rings, stretch) else { return Ok(()) };
        if let Ok(mesh) = RegionMesh::build(&region, &body, rule, &options) {
            prop_assert_eq!(mesh.check_invariants(&body), Ok(()));
            prop_assert_eq!(check_extruded(&mesh, &body).err(), None);
        }
        region.split_at_crossings(rule);
        match RegionMesh::build(&region, &body, rule, &options) {
            Ok(mesh) => {
                prop_assert_eq!(mesh.check_invariants(&body), Ok(()));
                prop_assert_eq!(check_extruded(&mesh, &body).err(), None);
            }
            // Clamped to a pole a ring can lose its width; arcs can join opposite points.
            Err(MeshError::NoArea { .. } | MeshError::OppositeEnds { .. }) => {}
            Err(error) => prop_assert!(false, "{}", error),
        }
    }
}
