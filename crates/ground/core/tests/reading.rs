// SPDX-License-Identifier: MIT OR Apache-2.0
//! What `parse_regions` accepts, puts right and refuses, with its exact words.

use terrafill_core::{Region, parse_regions};

fn regions(text: &str) -> Vec<Region> {
    parse_regions(text.as_bytes(), "t.json").expect("valid")
}

/// The message for a file that must be refused.
fn refusal(bytes: &[u8]) -> String {
    match parse_regions(bytes, "t.json") {
        Ok(regions) => panic!("accepted as {} regions", regions.len()),
        Err(error) => error.to_string(),
    }
}

fn polygon(ring: &str) -> String {
    format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#)
}

fn collection(geometries: &[&str]) -> String {
    let features: Vec<String> = geometries
        .iter()
        .map(|g| format!(r#"{{"type":"Feature","properties":{{"name":"A"}},"geometry":{g}}}"#))
        .collect();
    format!(
        r#"{{"type":"FeatureCollection","features":[{}]}}"#,
        features.join(",")
    )
}

const TRIANGLE: &str = "[[0,0],[2,0],[1,1],[0,0]]";

#[test]
fn every_way_to_write_an_area_is_read() {
    let plain = polygon(TRIANGLE);
    let expected = &regions(&plain)[0].polygons;
    let multi = format!(r#"{{"type":"MultiPolygon","coordinates":[[{TRIANGLE}]]}}"#);
    let gathered = format!(r#"{{"type":"GeometryCollection","geometries":[{plain}]}}"#);
    let feature = format!(r#"{{"type":"Feature","properties":null,"geometry":{plain}}}"#);
    let late = format!(r#"{{"coordinates":[{TRIANGLE}],"bbox":[0,0,2,1],"type":"Polygon"}}"#);
    let high = polygon("[[0,0,9],[2,0,9,7],[1,1,-3],[0,0,9]]");
    let bom = format!("\u{feff}{plain}");
    let crlf = plain.replace(',', ",\r\n");
    let all = collection(&[&plain, &multi]);
    for text in [&multi, &gathered, &feature, &late, &high, &bom, &crlf, &all] {
        for region in regions(text) {
            assert_eq!(&region.polygons, expected, "{text}");
            assert!(region.warnings.is_empty());
        }
    }
    assert_eq!(regions(&all).len(), 2);
}

#[test]
fn names_come_from_the_best_property() {
    let name = |properties: &str| {
        let geometry = polygon(TRIANGLE);
        let text = format!(
            r#"{{"type":"Feature","id":"x7","properties":{properties},"geometry":{geometry}}}"#
        );
        regions(&text)[0].name.clone()
    };
    assert_eq!(name(r#"{"name":"b","NAME":"a","id":3}"#), "a");
    assert_eq!(name(r#"{"ADMIN":"c","name":null}"#), "c");
    assert_eq!(name(r#"{"id":3}"#), "3");
    assert_eq!(name("{}"), "x7");
    assert_eq!(regions(&polygon(TRIANGLE))[0].name, "feature 0");
}

#[test]
fn what_is_put_right_is_said() {
    let open = &regions(&polygon("[[0,0],[2,0],[2,0],[1,1]]"))[0];
    assert_eq!(
        open.warnings,
        ["1 ring was not closed", "1 repeated position was dropped"]
    );
    assert_eq!(
        open.polygons[0].shell.vertices_deg(),
        [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0]]
    );
    let long = &regions(&polygon("[[179,0],[-179,0],[-179,1],[179,1],[179,0]]"))[0];
    assert_eq!((long.warnings.len(), long.long_edge_count()), (0, 2));
    let mixed = format!(
        r#"{{"type":"GeometryCollection","geometries":[{},{{"type":"Point","coordinates":[1,2]}}]}}"#,
        polygon(TRIANGLE)
    );
    assert_eq!(
        regions(&mixed)[0].warnings,
        ["1 geometry without area was left out"]
    );
    // Twin: nothing to put right, nothing said.
    assert!(regions(&polygon(TRIANGLE))[0].warnings.is_empty());
}

#[test]
fn a_ring_cut_open_at_the_antimeridian_goes_round() {
    let shell = |text: &str| regions(&polygon(text))[0].polygons[0].shell.clone();
    let cut = shell("[[-180,80],[-90,81],[0,82],[90,81],[180,80],[-180,80]]");
    assert_eq!(cut.winding_deg(), 360.0);
    assert_eq!(cut.vertices_deg().len(), 4);
    // The same ring from another vertex, and the other way.
    let later = shell("[[0,82],[90,81],[180,80],[-180,80],[-90,81],[0,82]]");
    assert_eq!(later.winding_deg(), 360.0);
    assert_eq!(
        later.vertices_deg(),
        [[0.0, 82.0], [90.0, 81.0], [180.0, 80.0], [270.0, 81.0]]
    );
    let west = shell("[[180,80],[90,81],[0,82],[-90,81],[-180,80],[180,80]]");
    assert_eq!(west.winding_deg(), -360.0);
    // Written on past the antimeridian and closed one turn later.
    assert_eq!(
        shell("[[0,80],[120,80],[240,80],[360,80]]").winding_deg(),
        360.0
    );
    // Jumps that cancel are edges along parallels; at a pole there is no jump.
    assert_eq!(
        shell("[[-180,-10],[180,-10],[180,10],[-180,10]]").winding_deg(),
        0.0
    );
    assert_eq!(
        shell("[[-180,-90],[180,-90],[180,-60],[0,-70],[-180,-60]]").winding_deg(),
        0.0
    );
}

#[test]
fn syntax_errors_name_their_place() {
    assert_eq!(refusal(b""), "t.json: the file is empty; expected GeoJSON");
    assert_eq!(
        refusal(b" \r\n"),
        "t.json: the file is empty; expected GeoJSON"
    );
    let truncated = &polygon(TRIANGLE)[..40];
    assert_eq!(
        refusal(truncated.as_bytes()),
        "t.json: line 1, column 40: EOF while parsing a value"
    );
    assert_eq!(
        refusal(polygon("[[0,0],\n[NaN,0],[1,1]]").as_bytes()),
        "t.json: line 2, column 2: expected value, found \"NaN\""
    );
    assert_eq!(
        refusal(polygon("[[0,0],[-Infinity,0],[1,1]]").as_bytes()),
        "t.json: line 1, column 43: invalid number, found \"-Infinity\""
    );
    assert_eq!(
        refusal(polygon("[[0,0],[1e999,0],[1,1]]").as_bytes()),
        "t.json: line 1, column 46: number out of range, found \"1e999\""
    );
    assert_eq!(
        refusal(b"[[[1,2],[3,4],[5,6]]]"),
        "t.json: the file is a bare list, such as rings in pixel coordinates; expected a GeoJSON \
         object with a \"type\""
    );
    assert_eq!(
        refusal(b"not json"),
        "t.json: line 1, column 2: expected ident, found \"not\""
    );
    assert_eq!(
        refusal(b"42"),
        "t.json: line 1, column 2: invalid type: integer `42`, expected a GeoJSON object, found \"42\""
    );
}

#[test]
fn files_of_the_wrong_kind_are_refused() {
    assert_eq!(
        refusal(b"{}"),
        "t.json: no \"type\"; expected FeatureCollection, Feature, Polygon, MultiPolygon or \
         GeometryCollection"
    );
    assert_eq!(
        refusal(br#"{"type":"Topology"}"#),
        "t.json: type \"Topology\"; expected FeatureCollection, Feature, Polygon, MultiPolygon or \
         GeometryCollection"
    );
    assert_eq!(
        refusal(br#"{"type":"FeatureCollection"}"#),
        "t.json: no \"features\" in a FeatureCollection"
    );
    assert_eq!(
        refusal(br#"{"type":"FeatureCollection","features":[]}"#),
        "t.json: no features; expected at least one"
    );
    assert_eq!(
        refusal(br#"{"type":"LineString","coordinates":[[0,0],[1,1]]}"#),
        "t.json: feature 0: no area: geometry is LineString; expected Polygon or \
         MultiPolygon"
    );
}

#[test]
fn every_problem_of_a_file_is_listed_with_its_place() {
    let text = collection(&[
        &polygon(TRIANGLE),
        &polygon("[[0,0],[2,91],[541,-90.5],[0,0]]"),
        "null",
        r#"{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[0,1]]],[[[0,0],[1,1],[0,0]]]]}"#,
        r#"{"type":"Polygon","coordinates":[]}"#,
        r#"{"type":"Polygon","coordinates":[[]]}"#,
        r#"{"type":"Polygon","coordinates":[[0,0],[1,0],[0,1]]}"#,
        r#"{"type":"Polygon","coordinates":[[[0,0],["1",0],[2],[0,null]]]}"#,
        r#"{"type":"Polygon"}"#,
        r#"{"type":"Circle","coordinates":[0,0]}"#,
        &polygon("[[0,1],[120,1],[240,2],[360,1],[480,3],[-240,3],[-120,1],[0,1],[360,1],[0,1]]"),
    ]);
    let expected = [
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 1: latitude 91 is outside -90 … 90",
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 2: longitude 541 is outside -540 … 540",
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 2: latitude -90.5 is outside -90 … 90",
        "t.json: feature 2 (A): no \"geometry\" in a Feature",
        "t.json: feature 3 (A), polygon 1, ring 0: 2 distinct positions in the ring; needs at least 3",
        "t.json: feature 4 (A), polygon 0: empty coordinates; expected at least 3 distinct positions",
        "t.json: feature 5 (A), polygon 0, ring 0: empty coordinates; expected at least 3 distinct \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 0: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 1: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 2: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 1: the text \"1\" in a list in the \
         coordinates; expected a position of two or more numbers",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 2: a position of 1 number in the \
         coordinates; expected a position of two or more numbers",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 3: null in a position in the coordinates; \
         expected a position of two or more numbers",
        "t.json: feature 8 (A): no \"coordinates\" in a Polygon",
        "t.json: feature 9 (A): type \"Circle\"; expected Polygon, MultiPolygon or \
         GeometryCollection",
    ];
    let found = refusal(text.as_bytes());
    let found: Vec<&str> = found.lines().collect();
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected);
    }
    assert_eq!(found.len(), expected.len(), "{found:#?}");
}

#[test]
fn a_ring_of_two_turns_is_refused() {
    let twice =
        "[[-180,80],[0,80],[180,80],[-180,81],[0,81],[180,81],[-180,81],[0,82],[180,82],[-180,82]]";
    let message = refusal(polygon(twice).as_bytes());
    assert!(message.contains("times; at most 1 is allowed"), "{message}");
}
