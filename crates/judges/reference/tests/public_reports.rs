// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files as public bug reports have them: what the mesher and the reference make of each, against areas
//! that were computed apart from both.

use terrafill_core::{
    EdgeRule, Ellipsoid, Inside, MeshError, MeshOptions, Reading, Region, RegionFile, RegionMesh,
    Repair, Unwrap, read_regions_as,
};
use terrafill_reference::{Locator, LocatorError};

const BODY: Ellipsoid = Ellipsoid::WGS84;
const SQUARE: &str = "[[0,0],[10,0],[10,10],[0,10],[0,0]]";
const HOLE: &str = "[[3,3],[6,3],[6,6],[3,6],[3,3]]";

fn read(bytes: &[u8], unwrap: Unwrap) -> RegionFile {
    let reading = Reading {
        unwrap,
        inside: Inside::default(),
    };
    read_regions_as(bytes, "report", reading).expect("read")
}

fn region(kind: &str, coordinates: &str) -> Region {
    let text = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
    read(text.as_bytes(), Unwrap::Auto).regions.remove(0)
}

fn mesh(region: &Region, rule: EdgeRule) -> Result<RegionMesh, MeshError> {
    RegionMesh::build(region, &BODY, rule, &MeshOptions::default())
}

fn judged(region: &Region, rule: EdgeRule) -> Result<Locator, LocatorError> {
    Locator::new(std::slice::from_ref(region), rule, &BODY)
}

fn repaired(region: &Region, repair: Repair) -> Region {
    let mut repaired = region.clone();
    repaired.repair(repair, EdgeRule::Planar);
    repaired
}

fn holds(region: &Region, longitude: f64, latitude: f64) -> bool {
    let locator = judged(region, EdgeRule::Planar).expect("judged");
    !locator.locate(longitude, latitude).regions.is_empty()
}

/// To the digits that the reports' right answers have.
fn assert_area(region: &Region, expected_m2: f64, tolerance: f64) {
    let mesh = mesh(region, EdgeRule::Planar).expect("meshes");
    let error = (mesh.area_m2 / expected_m2 - 1.0).abs();
    assert!(error < tolerance, "{} m², not {expected_m2}", mesh.area_m2);
}

#[test]
fn equal_holes_are_refused_by_both_and_joined_by_a_union() {
    let twice = region("Polygon", &format!("[{SQUARE},{HOLE},{HOLE}]"));
    let error = mesh(&twice, EdgeRule::Planar).expect_err("equal holes");
    assert!(error.to_string().contains("rings 1 and 2"), "{error}");
    let union = repaired(&twice, Repair::Union);
    assert_area(&union, 1.114_395e12, 1e-6);
    assert!(!holds(&union, 4.5, 4.5) && holds(&union, 1.0, 1.0));
    // Even-odd fills the hole, in both programs alike: only the windings say that the file is wrong.
    let even_odd = repaired(&twice, Repair::EvenOdd);
    assert_area(&even_odd, 1.224_832e12, 1e-6);
    assert!(holds(&even_odd, 4.5, 4.5));
    for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
        let error = judged(&twice, rule).expect_err("equal holes");
        assert!(
            error
                .to_string()
                .contains("ring 2 is a hole over polygon 0, ring 1"),
            "{error}"
        );
        // Negative control: the hole once.
        let once = region("Polygon", &format!("[{SQUARE},{HOLE}]"));
        assert!(judged(&once, rule).is_ok() && mesh(&once, rule).is_ok());
    }
}

#[test]
fn the_reference_refuses_what_the_mesher_refuses() {
    let within = "[[4,4],[5,4],[5,5],[4,5],[4,4]]";
    let beside = "[[20,0],[22,0],[22,2],[20,2],[20,0]]";
    let halves = "[[3,3],[5,3],[5,6],[3,6],[3,3]],[[4,3],[6,3],[6,6],[4,6],[4,3]]";
    let wrong = [
        ("Polygon", format!("[{SQUARE},{beside}]")),
        ("Polygon", format!("[{SQUARE},{halves}]")),
        ("MultiPolygon", format!("[[{SQUARE}],[{SQUARE}]]")),
        ("MultiPolygon", format!("[[{SQUARE}],[{within}]]")),
        (
            "MultiPolygon",
            format!("[[{SQUARE},{HOLE}],[{beside}],[{beside}]]"),
        ),
        (
            "MultiPolygon",
            "[[[[170,0],[190,0],[190,9],[170,9]]],[[[-178,1],[-175,1],[-175,2],[-178,2]]]]"
                .to_owned(),
        ),
    ];
    for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
        for (kind, coordinates) in &wrong {
            let region = region(kind, coordinates);
            assert!(mesh(&region, rule).is_err(), "{coordinates}");
            let error = judged(&region, rule).map(drop).expect_err(coordinates);
            assert!(matches!(error, LocatorError::Overlap { .. }), "{error}");
            // With the mesher's check off, by a repair that the reference does not know of.
            let unchecked = Region {
                repaired: Some(Repair::EvenOdd),
                ..region.clone()
            };
            assert!(judged(&unchecked, rule).is_ok(), "{coordinates}");
        }
        // Negative controls: an island in a hole, as a part and as a ring; parts that share an edge.
        let touching = "[[10,0],[12,0],[12,10],[10,10],[10,0]]";
        for (kind, coordinates) in [
            ("MultiPolygon", format!("[[{SQUARE},{HOLE}],[{within}]]")),
            ("Polygon", format!("[{SQUARE},{HOLE},{within}]")),
            ("MultiPolygon", format!("[[{SQUARE}],[{touching}]]")),
            ("MultiPolygon", format!("[[{SQUARE}],[{beside}]]")),
        ] {
            let region = region(kind, &coordinates);
            assert!(mesh(&region, rule).is_ok(), "{coordinates}");
            judged(&region, rule).expect(&coordinates);
        }
    }
}

#[test]
fn a_hole_in_a_hole_is_warned_of() {
    let nested = region(
        "Polygon",
        &format!("[{SQUARE},{HOLE},[[4,4],[5,4],[5,5],[4,5],[4,4]]]"),
    );
    let warnings = mesh(&nested, EdgeRule::Planar).expect("meshes").warnings;
    assert!(
        warnings[0]
            .text
            .contains("ring 2 is a hole in the hole of ring 1"),
        "{warnings:?}"
    );
    assert!(holds(&nested, 4.5, 4.5));
    assert!(!holds(&repaired(&nested, Repair::Union), 4.5, 4.5));
}

#[test]
fn parts_that_overlap_are_joined_by_a_union() {
    let square = "[[[0,0],[2,0],[2,2],[0,2],[0,0]]]";
    let other = "[[[5,0],[7,0],[7,2],[5,2],[5,0]]]";
    let twice = region("MultiPolygon", &format!("[{square},{square},{other}]"));
    assert!(mesh(&twice, EdgeRule::Planar).is_err());
    let [width, south, north] = [4.0_f64, 0.0, 2.0].map(f64::to_radians);
    assert_area(
        &repaired(&twice, Repair::Union),
        BODY.quadrangle_area_m2(width, south, north),
        1e-9,
    );
    let locator = judged(
        &Region {
            repaired: Some(Repair::Union),
            ..twice
        },
        EdgeRule::Planar,
    )
    .expect("judged");
    assert_eq!(locator.locate(1.0, 1.0).regions, [0]);
    assert!(locator.locate(3.0, 1.0).regions.is_empty());
}

#[test]
fn a_collapsed_part_is_left_out_and_the_rest_is_drawn() {
    let island = region(
        "MultiPolygon",
        &format!("[[{SQUARE}],[[[20,0],[21,0],[20,0]]]]"),
    );
    assert_eq!(island.warnings, ["1 part without area was left out"]);
    assert_area(&island, 1.224_832e12, 1e-6);
    // One of three positions on a line, too.
    let line = region(
        "MultiPolygon",
        &format!("[[[[20,0],[21,0],[22,0],[20,0]]],[{SQUARE}]]"),
    );
    let mesh = mesh(&line, EdgeRule::Planar).expect("meshes");
    assert_eq!(mesh.warnings, ["1 part without area was left out"]);
}

#[test]
fn an_uncut_cap_and_a_band_beside_a_jump_are_read_as_meant() {
    let shell = "[[-160,80],[-120,80],[-80,80],[-40,80],[0,80],[40,80],[80,80],[120,80],[160,80],[-160,80]]";
    let holes = "[[0,81],[-1,82],[0,83],[1,82],[0,81]],[[10,81],[9,82],[10,83],[11,82],[10,81]]";
    let cap = region("Polygon", &format!("[{shell},{holes}]"));
    assert_area(&cap, 3.9016e12, 1e-4);
    assert!(
        cap.warnings[0].text.contains("--unwrap literal"),
        "{:?}",
        cap.warnings
    );
    let band = region(
        "Polygon",
        "[[[-180,30],[180,30],[180,38],[-180,38],[-180,30]]]",
    );
    assert_area(&band, 2.949e13, 1e-3);
    assert!(band.warnings.is_empty() && holds(&band, 0.0, 34.0));
    let jump = region(
        "Polygon",
        "[[[171,-20],[-172,-20],[-172,-6],[171,-6],[171,-20]]]",
    );
    assert_area(&jump, 2.849e12, 1e-3);
    assert!(holds(&jump, 180.0, -10.0) && !holds(&jump, 0.0, -10.0));
}

#[test]
fn an_edge_that_is_all_but_opposite_is_refused_by_both() {
    let arcs = EdgeRule::GreatEllipse;
    let nearly = region("Polygon", "[[[0,0],[179.99999999999,5e-12],[90,40],[0,0]]]");
    assert!(matches!(
        mesh(&nearly, arcs),
        Err(MeshError::OppositeEnds { .. })
    ));
    assert!(matches!(
        judged(&nearly, arcs),
        Err(LocatorError::OppositeEnds { .. })
    ));
    // On either side of the bound the two agree.
    for (degrees, is_ok) in [("179.99999995", false), ("179.99999993", true)] {
        let near = region("Polygon", &format!("[[[0,0],[{degrees},0],[90,40],[0,0]]]"));
        assert_eq!(
            [mesh(&near, arcs).is_ok(), judged(&near, arcs).is_ok()],
            [is_ok; 2],
            "{degrees}"
        );
    }
}

#[test]
fn a_latitude_one_step_above_90_is_the_pole() {
    let cap = region(
        "Polygon",
        "[[[-180,80],[180,80],[180,90.00000000000001],[-180,90.00000000000001],[-180,80]]]",
    );
    let [width, south, north] = [360.0_f64, 80.0, 90.0].map(f64::to_radians);
    assert_area(&cap, BODY.quadrangle_area_m2(width, south, north), 1e-12);
}

#[test]
fn empty_polygons_lines_and_gzip_are_read() {
    let feature = |name: &str, rings: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"name":"{name}"}},"geometry":{{"type":"Polygon","coordinates":{rings}}}}}"#
        )
    };
    let square = format!("[{SQUARE}]");
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{},{}]}}"#,
        feature("good", &square),
        feature("empty", "[]")
    );
    let file = read(text.as_bytes(), Unwrap::Auto);
    assert_eq!(file.regions.len(), 1);
    assert_eq!(
        file.warnings,
        ["1 feature without area was left out: 1 empty Polygon"]
    );
    let lines = format!(
        "{}\n{}\n",
        feature("a", &square),
        feature("b", "[[[20,0],[30,0],[30,10],[20,10],[20,0]]]")
    );
    let names: Vec<String> = read(lines.as_bytes(), Unwrap::Auto)
        .regions
        .into_iter()
        .map(|region| region.name)
        .collect();
    assert_eq!(names, ["a", "b"]);
    let packed = include_bytes!("gzipped.geojson");
    assert_eq!(read(packed, Unwrap::Auto).regions[0].name, "good");
}
