// SPDX-License-Identifier: MIT OR Apache-2.0
//! What `parse_regions` accepts, puts right and refuses, with its exact words.

use terrafill_core::{Reading, Region, RegionFile, parse_regions, read_region_file};

fn regions(text: &str) -> Vec<Region> {
    parse_regions(text.as_bytes(), "t.json").expect("valid")
}

fn file(text: &str) -> RegionFile {
    read_region_file(text.as_bytes(), "t.json", Reading::default()).expect("valid")
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
    // Negative control: nothing to put right, nothing said.
    assert!(regions(&polygon(TRIANGLE))[0].warnings.is_empty());
}

#[test]
fn features_without_area_are_left_out_and_counted() {
    let text = collection(&[
        r#"{"type":"Point","coordinates":[1,2]}"#,
        &polygon(TRIANGLE),
        r#"{"type":"LineString","coordinates":[[0,0],[1,1]]}"#,
        "null",
        r#"{"type":"Point","coordinates":[1,2]}"#,
        r#"{"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[1,2]}]}"#,
        r#"{"type":"GeometryCollection","geometries":[]}"#,
        &format!(
            r#"{{"type":"GeometryCollection","geometries":[{}]}}"#,
            polygon(TRIANGLE)
        ),
    ]);
    let read = file(&text);
    let indices: Vec<usize> = read.regions.iter().map(|region| region.index).collect();
    assert_eq!(indices, [1, 7], "places in the file");
    assert_eq!(
        read.warnings,
        [
            "6 features without area were left out: 1 GeometryCollection of Point, 1 LineString, \
          2 Point, 1 empty collection, 1 null"
        ]
    );
    assert_eq!(regions(&text), read.regions);
    // Negative controls: nothing is left out of a file of areas; a file of nothing else is refused.
    assert!(file(&collection(&[&polygon(TRIANGLE)])).warnings.is_empty());
    let lines = r#"{"type":"MultiLineString","coordinates":[]}"#;
    assert_eq!(
        refusal(collection(&["null", lines, "null"]).as_bytes()),
        "t.json: no area: found 1 MultiLineString, 2 null; expected Polygon or MultiPolygon"
    );
    // A problem elsewhere in the file takes the warning along.
    let wrong = collection(&["null", &polygon("[[0,0],[1,1]]")]);
    let error = read_region_file(wrong.as_bytes(), "t.json", Reading::default())
        .expect_err("two positions");
    assert_eq!(
        error.warnings,
        ["1 feature without area was left out: 1 null"]
    );
    assert_eq!(error.problems.len(), 1);
}

#[test]
fn a_collection_of_no_features_is_read_where_no_region_is_needed() {
    let read = file(r#"{"type":"FeatureCollection","features":[]}"#);
    assert_eq!(read.regions, []);
    assert_eq!(read.warnings, ["the file has no features"]);
    // Negative control: scenes need one, see files_of_the_wrong_kind_are_refused.
}

#[test]
fn a_reference_system_that_is_not_wgs_84_is_named() {
    let with_crs = |crs: &str| {
        let text = polygon(TRIANGLE);
        let members = format!(r#""crs":{crs},"type""#);
        file(&text.replacen(r#""type""#, &members, 1)).warnings
    };
    let named = |name: &str| {
        with_crs(&format!(
            r#"{{"type":"name","properties":{{"name":"{name}"}}}}"#
        ))
    };
    for name in [
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "urn:ogc:def:crs:OGC::CRS84h",
        "urn:ogc:def:crs:EPSG::4326",
        "EPSG:4326",
        "http://www.opengis.net/def/crs/EPSG/0/4326",
        "CRS84",
    ] {
        assert_eq!(named(name), [""; 0], "{name}");
    }
    assert_eq!(with_crs("null"), [""; 0]);
    for name in ["urn:ogc:def:crs:EPSG::3857", "EPSG:25832", "EPSG:14326"] {
        let warning = format!(
            "crs is \"{name}\"; coordinates are read as longitude and latitude in degrees (RFC \
             7946: WGS 84)"
        );
        assert_eq!(named(name), [warning]);
    }
    let link = with_crs(r#"{"type":"link","properties":{"href":"http://a/3857"}}"#);
    assert!(link[0].starts_with("crs is \"http://a/3857\";"), "{link:?}");
    assert_eq!(with_crs("7").len(), 1);
    // Of a feature's geometry as well, once for all of them.
    let crs = r#"{"type":"Polygon","crs":{"properties":{"name":"EPSG:3857"}},"coordinates":["#;
    let text = collection(&[&polygon(TRIANGLE), &polygon(TRIANGLE)]);
    let text = text.replace(r#"{"type":"Polygon","coordinates":["#, crs);
    assert_eq!(file(&text).warnings.len(), 1);
}

#[test]
fn encodings_other_than_utf8_are_named() {
    let text = polygon(TRIANGLE);
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let message = "t.json: the file is UTF-16; expected UTF-8";
    assert_eq!(refusal(&wide), message);
    assert_eq!(refusal(&[&b"\xff\xfe"[..], &wide].concat()), message);
    // The zeros that a Shapefile begins with are no encoding.
    let shapefile = refusal(b"\0\0\x27\x0a\0\0\0\0");
    assert!(
        shapefile.starts_with("t.json: the file is a Shapefile; expected GeoJSON"),
        "{shapefile}"
    );
}

#[test]
fn coordinates_in_metres_are_called_projected() {
    let metres = polygon("[[0,0],[500000,4649776],[0,1]]");
    let expected = "it looks projected, expected degrees";
    let found = refusal(metres.as_bytes());
    assert_eq!(
        found
            .lines()
            .filter(|line| line.ends_with(expected))
            .count(),
        2,
        "{found}"
    );
    // Negative control: the two numbers of a position in the wrong order.
    let swapped = refusal(polygon("[[0,0],[48,120],[0,1]]").as_bytes());
    assert!(
        swapped.ends_with("in GeoJSON longitude comes first"),
        "{swapped}"
    );
}

#[test]
fn names_in_messages_hold_no_control_characters() {
    let text = polygon("[[0,0],[1,91],[0,1]]");
    let text = format!(
        r#"{{"type":"Feature","properties":{{"name":"a\u001b[2J\nb"}},"geometry":{text}}}"#
    );
    let message = refusal(text.as_bytes());
    assert!(
        message.contains(r"feature 0 (a\u{1b}[2J\nb), polygon 0"),
        "{message}"
    );
    assert!(!message.contains(char::is_control));
    let message = refusal(br#"{"type":"a\u001b[2J"}"#);
    assert!(message.contains(r#"type "a\u{1b}[2J""#), "{message}");
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
        "t.json: feature 0: no area: found 1 LineString; expected Polygon or MultiPolygon"
    );
}

#[test]
fn every_problem_of_a_file_is_listed_with_its_place() {
    let text = collection(&[
        &polygon(TRIANGLE),
        &polygon("[[0,0],[2,91],[541,-90.5],[0,0]]"),
        "null",
        r#"{"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[1,0]]],[[[0,0],[1,1],[0,0]]]]}"#,
        r#"{"type":"Polygon","coordinates":[]}"#,
        r#"{"type":"Polygon","coordinates":[[],[[0,0],[1,0],[0,1]]]}"#,
        r#"{"type":"Polygon","coordinates":[[0,0],[1,0],[0,1]]}"#,
        r#"{"type":"Polygon","coordinates":[[[0,0],["1",0],[2],[0,null]]]}"#,
        r#"{"type":"Polygon"}"#,
        r#"{"type":"Circle","coordinates":[0,0]}"#,
        &polygon("[[0,1],[120,1],[240,2],[360,1],[480,3],[-240,3],[-120,1],[0,1],[360,1],[0,1]]"),
        r#"{"type":"Point","coordinates":[0,0]}"#,
    ]);
    // Null is a geometry that is not known; without the member the feature is none.
    let text = text.replace(r#","geometry":null"#, "");
    let expected = [
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 1: latitude 91 is outside -90 … 90; in \
         GeoJSON longitude comes first",
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 2: longitude 541 is outside -540 … 540; \
         it looks projected, expected degrees",
        "t.json: feature 1 (A), polygon 0, ring 0, vertex 2: latitude -90.5 is outside -90 … 90; in \
         GeoJSON longitude comes first",
        "t.json: feature 2 (A): no \"geometry\" in a Feature",
        "t.json: feature 3 (A), polygon 0, ring 0: 2 distinct positions in the ring; needs at least 3",
        "t.json: feature 3 (A), polygon 1, ring 0: 2 distinct positions in the ring; needs at least 3",
        "t.json: feature 5 (A), polygon 0, ring 0: empty coordinates; expected at least 3 distinct \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 0: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 1: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 6 (A), polygon 0, ring 2: a position in the coordinates; expected a list of \
         positions",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 1: element 0 of the position is the text \
         \"1\"; expected a number",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 2: a position of 1 number in the \
         coordinates; expected a position of two or more numbers",
        "t.json: feature 7 (A), polygon 0, ring 0, vertex 3: element 1 of the position is null; \
         expected a number",
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

#[test]
fn what_is_empty_or_collapsed_is_left_out_and_counted() {
    let square = "[[[0,0],[10,0],[10,10],[0,10],[0,0]]]";
    let parts = |parts: &[&str]| {
        let list = parts.join(",");
        format!(r#"{{"type":"MultiPolygon","coordinates":[{list}]}}"#)
    };
    let text = collection(&[
        &parts(&[square]),
        r#"{"type":"Polygon","coordinates":[]}"#,
        r#"{"type":"MultiPolygon","coordinates":[]}"#,
        r#"{"type":"Polygon","coordinates":[[]]}"#,
    ]);
    let read = file(&text);
    assert_eq!(read.regions.len(), 1);
    assert_eq!(
        read.warnings,
        ["3 features without area were left out: 1 empty MultiPolygon, 2 empty Polygon"]
    );
    let tip = "[[[20,0],[21,0],[20,0]]]";
    let region = &regions(&parts(&[tip, "[]", square]))[0];
    assert_eq!(
        region.warnings,
        [
            "1 part without area was left out",
            "1 geometry without area was left out"
        ]
    );
    assert_eq!(region.polygons.len(), 1);
    assert_eq!(region.polygons[0].shell.file_polygon(0), 2);
    // Negative control: a part that is all there is has to have an area.
    let alone = refusal(parts(&[tip]).as_bytes());
    assert!(alone.contains("2 distinct positions"), "{alone}");
}

#[test]
fn lines_and_records_are_features_and_errors_name_their_lines() {
    let feature = |name: &str, ring: &str| {
        let geometry = polygon(ring);
        format!(r#"{{"type":"Feature","properties":{{"name":"{name}"}},"geometry":{geometry}}}"#)
    };
    let (a, b) = (feature("a", TRIANGLE), feature("b", TRIANGLE));
    let bare = polygon(TRIANGLE);
    let names = |text: &str| -> Vec<(usize, String)> {
        let regions = regions(text).into_iter();
        regions.map(|region| (region.index, region.name)).collect()
    };
    let expected: Vec<(usize, String)> = ["a", "b", "feature 2"]
        .into_iter()
        .enumerate()
        .map(|(index, name)| (index, name.to_owned()))
        .collect();
    assert_eq!(names(&format!("{a}\n\n{b}\r\n{bare}\n")), expected);
    assert_eq!(
        names(&format!("\u{1e}{a}\n\u{1e}{b}\n\u{1e}{bare}\n")),
        expected
    );
    // Negative controls: what is wrong with one line, by its number and its feature's.
    let outside = feature("c", "[[0,0],[1,91],[1,0],[0,0]]");
    assert_eq!(
        refusal(format!("{a}\n\n{outside}\n").as_bytes()),
        "t.json: line 3: feature 1 (c), polygon 0, ring 0, vertex 1: latitude 91 is outside -90 … 90; in \
         GeoJSON longitude comes first"
    );
    let broken = refusal(format!("{a}\n{{\"type\":\n{b}\n").as_bytes());
    assert!(broken.starts_with("t.json: line 2, column 8: "), "{broken}");
    assert_eq!(broken.lines().count(), 1, "{broken}");
    let pair = refusal(format!("{a} {b}").as_bytes());
    assert!(pair.starts_with("t.json: line 1, column "), "{pair}");
}

#[test]
fn one_step_outside_a_pole_or_the_antimeridian_is_on_it() {
    let ring = |east: &str, north: &str| {
        polygon(&format!(
            "[[-180,80],[{east},80],[{east},{north}],[-180,{north}],[-180,80]]"
        ))
    };
    let exact = regions(&ring("180", "90"));
    for (east, north) in [("180.00000000000003", "90"), ("180", "90.00000000000001")] {
        assert_eq!(regions(&ring(east, north)), exact, "{east} {north}");
    }
    // Negative control: a step of a thousandth of a millimetre is no rounding.
    let beyond = refusal(ring("180", "90.0000000001").as_bytes());
    assert!(
        beyond.contains("latitude 90.0000000001 is outside"),
        "{beyond}"
    );
}
