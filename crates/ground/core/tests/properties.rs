// SPDX-License-Identifier: MIT OR Apache-2.0
//! Round trips that must hold for any input: geodetic ↔ ECEF, region → GeoJSON → region.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::fmt::Write;
use terrafill_core::{Ellipsoid, Geodetic, Region, parse_regions};

/// The same cases on every run; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` ask for more and others.
fn configuration() -> ProptestConfig {
    let mut configuration = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    if std::env::var_os("PROPTEST_CASES").is_none() {
        configuration.cases = 2000;
    }
    if std::env::var_os("PROPTEST_RNG_SEED").is_none() {
        configuration.rng_seed = RngSeed::Fixed(2007);
    }
    configuration
}

/// The named bodies, and any other that is at most as flat as a coin is thick.
fn body() -> impl Strategy<Value = Ellipsoid> {
    prop_oneof![
        prop::sample::select(Ellipsoid::ALL.to_vec()),
        (1.0..1e8_f64, 0.7..=1.0_f64).prop_map(|(equatorial_m, ratio)| {
            Ellipsoid::new("random", equatorial_m, equatorial_m * ratio).expect("oblate")
        }),
    ]
}

fn degrees() -> impl Strategy<Value = [f64; 2]> {
    let longitude = prop_oneof![
        -180.0..=180.0_f64,
        Just(180.0),
        Just(-180.0),
        Just(0.0),
        -1e-9..1e-9_f64
    ];
    let latitude = prop_oneof![
        -90.0..=90.0_f64,
        Just(90.0),
        Just(-90.0),
        Just(0.0),
        (0.0..1e-9_f64).prop_map(|off| 90.0 - off),
    ];
    (longitude, latitude).prop_map(|(longitude, latitude)| [longitude, latitude])
}

/// Rings as a file may hold them: closed or not, points repeated, far round, at the poles.
fn ring() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let place = (degrees(), prop::sample::select(vec![0.0, 360.0, -360.0]))
        .prop_map(|([longitude, latitude], turn)| [longitude + turn, latitude]);
    (prop::collection::vec(place, 3..9), 0..3_u8).prop_map(|(mut ring, ending)| {
        match ending {
            0 => ring.push(ring[0]),
            1 => ring.insert(1, ring[0]),
            _ => {}
        }
        ring
    })
}

fn list<T>(items: &[T], write: impl Fn(&T) -> String) -> String {
    let written: Vec<String> = items.iter().map(write).collect();
    format!("[{}]", written.join(","))
}

fn file(polygons: &[Vec<Vec<[f64; 2]>>]) -> String {
    let coordinates = list(polygons, |rings| {
        list(rings, |ring| list(ring, |[x, y]| format!("[{x},{y}]")))
    });
    format!(r#"{{"type":"MultiPolygon","coordinates":{coordinates}}}"#)
}

/// The region's own numbers as a file; rings round the axis with their end one turn on.
fn file_of(region: &Region) -> String {
    let mut text = String::from(r#"{"type":"MultiPolygon","coordinates":["#);
    for (i, polygon) in region.polygons.iter().enumerate() {
        text.push_str(if i == 0 { "[" } else { ",[" });
        for (j, ring) in polygon.rings().enumerate() {
            text.push_str(if j == 0 { "[" } else { ",[" });
            for [longitude, latitude] in ring.vertices_deg() {
                let _ = write!(text, "[{longitude},{latitude}],");
            }
            let [longitude, latitude] = ring.vertices_deg()[0];
            let _ = write!(text, "[{},{latitude}]]", longitude + ring.winding_deg());
        }
        text.push(']');
    }
    text.push_str("]}");
    text
}

/// Largest distance after geodetic → ECEF → geodetic → ECEF, as a share of the radius.
fn round_trip_error(there: &Ellipsoid, back: &Ellipsoid, position: Geodetic) -> f64 {
    let ecef = there.geodetic_to_ecef(position);
    let again = there.geodetic_to_ecef(back.ecef_to_geodetic(ecef));
    (again - ecef).length() / there.equatorial_radius_m()
}

/// What the inverse may lose, as a share of the radius: 0.04 µm on the Earth.
const LARGEST_ERROR: f64 = 6e-15;

proptest! {
    #![proptest_config(configuration())]

    #[test]
    fn geodetic_to_ecef_and_back_is_the_same_place(
        body in body(),
        degrees in degrees(),
        height in -0.1..3.0_f64,
    ) {
        let height_m = height * body.equatorial_radius_m();
        let position = Geodetic::from_degrees(degrees[0], degrees[1], height_m);
        let error = round_trip_error(&body, &body, position);
        prop_assert!(error <= LARGEST_ERROR * (1.0 + height), "{:e}", error);
        let found = body.ecef_to_geodetic(body.geodetic_to_ecef(position));
        let latitude = (found.latitude_rad - position.latitude_rad).abs();
        prop_assert!(latitude <= 2e-14, "latitude off by {:e} rad", latitude);
        let height_error = (found.height_m - height_m).abs();
        prop_assert!(height_error <= LARGEST_ERROR * (1.0 + height) * body.equatorial_radius_m());
    }

    #[test]
    fn a_region_written_as_geojson_is_read_as_itself(
        polygons in prop::collection::vec(prop::collection::vec(ring(), 1..4), 1..3),
    ) {
        let Ok(regions) = parse_regions(file(&polygons).as_bytes(), "random") else {
            return Ok(());
        };
        let region = &regions[0];
        // A ring may be unrolled to where no file reaches, and at a pole no longitude says where
        // a ring that goes round starts.
        let writable = region.rings().all(|ring| {
            let near = ring.edges_deg().all(|(start, end)| start[0].abs().max(end[0].abs()) <= 540.0);
            near && (ring.winding_deg() == 0.0 || ring.vertices_deg()[0][1].abs() < 90.0)
        });
        prop_assume!(writable);
        let text = file_of(region);
        let again = parse_regions(text.as_bytes(), "again");
        prop_assert!(again.is_ok(), "{:?}", again);
        prop_assert_eq!(&again.expect("checked")[0].polygons, &region.polygons);
    }
}

#[test]
fn a_wrong_body_and_a_moved_vertex_break_the_round_trips() {
    // Negative controls of the two properties.
    let sphere = Ellipsoid::new("mutant", 6_378_137.0, 6_378_137.0).expect("a sphere");
    let position = Geodetic::from_degrees(10.0, 45.0, 0.0);
    let error = round_trip_error(&Ellipsoid::WGS84, &sphere, position);
    assert!(error > 1e6 * LARGEST_ERROR, "{error:e}");

    let square = vec![vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]]];
    let regions = parse_regions(file(&square).as_bytes(), "square").expect("valid");
    let moved = file_of(&regions[0]).replacen("[1,1]", "[1,1.0000000000000002]", 1);
    let again = parse_regions(moved.as_bytes(), "moved").expect("valid");
    assert_ne!(again[0].polygons, regions[0].polygons);
}
