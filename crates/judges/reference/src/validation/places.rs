// SPDX-License-Identifier: MIT OR Apache-2.0
//! Known places of the Earth in Natural Earth's countries, and what a file's regions become.
//!
//! The places are chosen tens of kilometres away from every border, so that the edge rule and the
//! coarseness of the outlines do not matter. The pole itself is not among them: in the 1:50m file
//! Antarctica ends at 89.998926° S, and by the planar rule it does not hold the pole.

use crate::{Locator, LocatorError};
use terrafill_core::{EdgeRule, Ellipsoid, Region, parse_regions};
use terrafill_fixtures::{Random, data};

/// Regions of a file of the data folder.
fn real_regions(file: &str) -> Vec<Region> {
    let bytes = data::bytes(&format!("vectors/{file}"));
    parse_regions(&bytes, file).expect("the file is valid")
}

/// Places and the country that holds them; empty for the sea.
const PLACES: [(&str, [f64; 2], &str); 16] = [
    ("in the hole of South Africa", [28.25, -29.5], "Lesotho"),
    ("south of that hole", [26.0, -32.0], "South Africa"),
    ("Berlin", [13.4, 52.5], "Germany"),
    ("Kansas", [-98.5, 38.5], "United States of America"),
    (
        "Interior of Alaska",
        [-150.0, 66.0],
        "United States of America",
    ),
    ("west of the antimeridian", [178.0, 67.5], "Russia"),
    ("east of the antimeridian", [-176.5, 66.8], "Russia"),
    ("on the antimeridian, as +180", [180.0, 67.5], "Russia"),
    ("on the antimeridian, as −180", [-180.0, 67.5], "Russia"),
    ("one turn out", [538.0, 67.5], "Russia"),
    (
        "a kilometre from the south pole",
        [0.0, -89.99],
        "Antarctica",
    ),
    ("and on another side of it", [123.0, -89.99], "Antarctica"),
    (
        "Antarctica on the antimeridian",
        [180.0, -86.0],
        "Antarctica",
    ),
    ("north pole", [0.0, 90.0], ""),
    ("null island", [0.0, 0.0], ""),
    ("Bering Sea", [-178.0, 58.0], ""),
];

/// Names of the places where `ask` does not give the right country.
fn wrong_places(regions: &[Region], ask: impl Fn(f64, f64) -> Vec<usize>) -> Vec<&'static str> {
    PLACES
        .iter()
        .filter(|(_, [lon, lat], country)| {
            let names: Vec<&str> = ask(*lon, *lat)
                .into_iter()
                .map(|region| regions[region].name.as_str())
                .collect();
            names.join(" and ") != *country
        })
        .map(|(what, ..)| *what)
        .collect()
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m"]
fn known_places_lie_in_their_countries_and_mutants_misplace_them() {
    for file in [
        "ne_110m_admin_0_countries.geojson",
        "ne_50m_admin_0_countries.geojson",
    ] {
        let regions = real_regions(file);
        for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
            let located =
                Locator::new(&regions, rule, &Ellipsoid::WGS84).expect("countries can be judged");
            let found = wrong_places(&regions, |lon, lat| located.locate(lon, lat).regions);
            assert_eq!(found, [""; 0], "{file}, {rule:?}");

            let swapped = wrong_places(&regions, |lon, lat| {
                located.locate(lat, lon.clamp(-90.0, 90.0)).regions
            });
            assert!(swapped.len() > 8, "{swapped:?}");
            let mirrored = wrong_places(&regions, |lon, lat| located.locate(-lon, lat).regions);
            assert!(mirrored.len() >= 5, "{mirrored:?}");
            let flipped = wrong_places(&regions, |lon, lat| {
                let inside = located.locate(lon, lat).regions;
                (0..regions.len())
                    .filter(|region| !inside.contains(region))
                    .collect()
            });
            assert_eq!(flipped.len(), PLACES.len());
        }
    }
}

#[test]
#[ignore = "needs data: natural-earth-50m"]
fn real_borders_by_index_and_brute_force() {
    let regions = real_regions("ne_50m_admin_0_countries.geojson");
    for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
        let located =
            Locator::new(&regions, rule, &Ellipsoid::WGS84).expect("countries can be judged");
        let mut random = Random(3);
        let mut on_land = 0;
        for _ in 0..300 {
            let [lon, lat] = random.place();
            let found = located.locate(lon, lat);
            assert_eq!(
                found,
                located.locate_brute(lon, lat),
                "{rule:?} {lon} {lat}"
            );
            assert_eq!(found.disagree, [0; 0], "{rule:?} {lon} {lat}");
            on_land += found.regions.len();
        }
        // Land is 29 % of the Earth, and no two countries overlap.
        assert!((60..115).contains(&on_land), "{on_land}");
    }
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn every_planar_vertex_is_reported_or_decided_alike() {
    // Vertices are where half-open rules go wrong: a vertex counted twice or never turns whole
    // stretches south or west of it inside out. So places straight south and west of vertices
    // must be decided the same by both tests.
    let regions = real_regions("ne_110m_admin_0_countries.geojson");
    let located = Locator::new(&regions, EdgeRule::Planar, &Ellipsoid::WGS84)
        .expect("countries can be judged");
    let mut looked = 0;
    for ring in regions.iter().flat_map(Region::rings) {
        for &[lon, lat] in ring.vertices_deg() {
            // The same longitude to the bit, and the same latitude to the bit.
            for place in [[lon, (lat - 0.7).max(-90.0)], [lon - 0.7, lat]] {
                let found = located.locate(place[0], place[1]);
                assert!(found.regions.len() <= 1, "{place:?} {found:?}");
                assert_eq!(found.disagree, [0; 0], "{place:?}");
                looked += 1;
            }
        }
    }
    assert!(looked > 20_000, "{looked}");
}

fn parsed(coordinates: &str) -> Vec<Region> {
    let text = format!(
        r#"{{"type":"Feature","properties":{{"name":"x"}},
            "geometry":{{"type":"Polygon","coordinates":{coordinates}}}}}"#
    );
    parse_regions(text.as_bytes(), "test").expect("valid")
}

#[test]
fn the_hole_of_a_zone_is_closed_over_the_pole_of_its_shell() {
    // Between 20° S and 10° N, whose parallels lie on different sides of the equator.
    let ring = |latitude: i32| {
        let vertices: Vec<String> = (0..=12)
            .map(|i| format!("[{},{latitude}]", i * 30 - 180))
            .collect();
        format!("[{}]", vertices.join(","))
    };
    for (shell, hole) in [(-20, 10), (10, -20)] {
        let regions = parsed(&format!("[{},{}]", ring(shell), ring(hole)));
        let located = Locator::new(&regions, EdgeRule::Planar, &Ellipsoid::WGS84)
            .expect("a zone can be judged");
        for (lat, inside) in [
            (-60.0, false),
            (-19.0, true),
            (0.0, true),
            (11.0, false),
            (89.0, false),
        ] {
            let found = located.locate(33.0, lat);
            assert_eq!(!found.regions.is_empty(), inside, "{shell} {hole} {lat}");
            assert!(found.disagree.is_empty());
        }
    }
}

#[test]
fn a_ring_that_cannot_be_judged_is_named() {
    let regions = parsed("[[[0,0],[90,0],[-90,0],[270,10],[0,0]]]");
    let error = Locator::new(&regions, EdgeRule::GreatEllipse, &Ellipsoid::WGS84).err();
    assert!(
        matches!(error, Some(LocatorError::OppositeEnds { vertex: 1, .. })),
        "{error:?}"
    );
    let message = error.map(|error| error.to_string()).unwrap_or_default();
    assert!(
        message.starts_with("feature 0 (x), polygon 0, ring 0: the edge from vertex 1"),
        "{message}"
    );
}
