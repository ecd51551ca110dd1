// SPDX-License-Identifier: MIT OR Apache-2.0
//! `locate`: known points, the form of its output, and what the edge rules change.

use crate::harness::{BOW_TIE, Desk, collection, polygon, rectangle};
use terrafill_fixtures::data;

fn locate(desk: &Desk, arguments: &[&str], points: &str) -> String {
    desk.write("points.csv", points);
    let all = [&["locate", "--points", "points.csv"][..], arguments].concat();
    desk.run(&all).succeeded()
}

/// With `--repair even-odd`, which says what it filled; those lines as well.
fn locate_repaired(desk: &Desk, arguments: &[&str], points: &str) -> (String, Vec<String>) {
    desk.write("points.csv", points);
    let fixed = ["locate", "--points", "points.csv", "--repair", "even-odd"];
    let ran = desk.run(&[&fixed[..], arguments].concat());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    (ran.stdout, ran.stderr.lines().map(str::to_owned).collect())
}

/// Regions found for each point, as printed.
fn found(text: &str) -> Vec<&str> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("lon,lat,regions"));
    lines
        .map(|line| line.splitn(3, ',').nth(2).expect("three cells"))
        .collect()
}

fn write_regions(desk: &Desk) {
    let shell = polygon(&rectangle(0.0, 40.0, 10.0, 50.0));
    let holed = shell.replace("]]}", "],[[2,42],[4,42],[4,44],[2,44],[2,42]]]}");
    desk.write(
        "r.geojson",
        collection(&[
            ("holed", holed),
            ("overlapping", polygon(&rectangle(8.0, 45.0, 20.0, 46.0))),
            ("far", polygon(&rectangle(178.0, -1.0, 182.0, 1.0))),
        ]),
    );
}

#[test]
fn indices_are_joined_by_semicolons_and_nowhere_is_empty() {
    let desk = Desk::new();
    write_regions(&desk);
    let points = "lon,lat\n1,41\n9,45.5\n15,45.5\n3,43\n30,30\n-179,0\n181.5,0\n-541e-1,0\n";
    let text = locate(&desk, &["r.geojson"], points);
    assert_eq!(
        text,
        "lon,lat,regions\n1,41,0\n9,45.5,0;1\n15,45.5,1\n3,43,\n30,30,\n-179,0,2\n181.5,0,2\n\
         -541e-1,0,\n"
    );
    assert_eq!(
        locate(&desk, &["r.geojson"], "lon,lat\n"),
        "lon,lat,regions\n"
    );
}

#[test]
fn every_column_of_the_points_comes_out_again() {
    let desk = Desk::new();
    write_regions(&desk);
    let points = "\u{feff}id,lat,name,lon\r\n7,41,\"a, \"\"b\"\"\", 1\r\n8,45.50,c,9.0\r\n";
    let text = locate(&desk, &["r.geojson"], points);
    assert_eq!(
        text,
        "id,lat,name,lon,regions\n7,41,\"a, \"\"b\"\"\", 1,0\n8,45.50,c,9.0,0;1\n"
    );
    // Cells that a row lacks at its end are empty ones.
    let text = locate(&desk, &["r.geojson"], "lon,lat,a,b\n1,41,x\n9,45.5\n");
    assert_eq!(text, "lon,lat,a,b,regions\n1,41,x,,0\n9,45.5,,,0;1\n");
    // Negative controls: a cell without a column, and columns that would stand twice.
    desk.write("points.csv", "lon,lat\n1,41\n1,41,x\n");
    let arguments = ["locate", "r.geojson", "--points", "points.csv"];
    desk.run(&arguments)
        .refused(&[&["points.csv: line 3: found 3 cells, allowed: 2 as in line 1"]]);
    desk.write("points.csv", "lon,lat,regions,names\n1,41,,\n");
    desk.run(&arguments)
        .refused(&[&["line 1: found a column regions, allowed: any other name"]]);
    desk.run(&[&arguments[..], &["--names"]].concat())
        .refused(&[
            &["line 1: found a column regions"],
            &["line 1: found a column names"],
        ]);
}

#[test]
fn names_stand_behind_indices() {
    let desk = Desk::new();
    write_regions(&desk);
    let points = "id,lon,lat\na,1,41\nb,9,45.5\nc,30,30\n";
    let text = locate(&desk, &["r.geojson", "--names"], points);
    assert_eq!(
        text,
        "id,lon,lat,regions,names\na,1,41,0,holed\nb,9,45.5,0;1,holed;overlapping\nc,30,30,,\n"
    );
}

#[test]
fn either_input_is_read_from_standard_input() {
    let desk = Desk::new();
    write_regions(&desk);
    let points = "lon,lat\n1,41\n";
    let expected = locate(&desk, &["r.geojson"], points);
    let from_points = ["locate", "r.geojson", "--points", "-"];
    let text = desk.run_with_input(&from_points, points).succeeded();
    assert_eq!(text, expected);
    let regions = desk.read_text("r.geojson");
    let from_regions = ["locate", "-", "--points", "points.csv"];
    let text = desk.run_with_input(&from_regions, &regions).succeeded();
    assert_eq!(text, expected);
    desk.run_with_input(&from_points, "lon,lat\n1,x\n")
        .refused(&[&["standard input: line 2, lat: found \"x\""]]);
    desk.run_with_input(&from_regions, "")
        .refused(&[&["standard input: the file is empty"]]);
    // Negative control: there is one standard input.
    desk.run_with_input(&["locate", "-", "--points", "-"], points)
        .refused(&[&["found - for both inputs, allowed: standard input for one of them"]]);
}

#[test]
fn longitudes_are_rounded_as_the_help_says() {
    let desk = Desk::new();
    let step = 2.0_f64.powi(-43);
    let help = desk.run(&["locate", "--help"]).succeeded();
    assert!(help.contains("multiples of 2^-43 degrees"), "{help}");
    // The western edge lies on a multiple; a point a quarter of a step to the west of it is rounded
    // onto the edge, which is inside, three quarters are not.
    desk.write("r.geojson", polygon(&rectangle(1.0, 0.0, 2.0, 1.0)));
    for (steps, found_in) in [(0.0, "0"), (0.25, "0"), (0.75, ""), (1.0, "")] {
        let longitude = 1.0 - steps * step;
        let points = format!("lon,lat\n{longitude},0.5\n");
        let text = locate(&desk, &["r.geojson"], &points);
        assert_eq!(found(&text), [found_in], "{steps} steps to the west");
    }
}

#[test]
fn the_edge_rules_differ_where_an_edge_bulges() {
    let desk = Desk::new();
    write_regions(&desk);
    // The great ellipse between the northern corners passes longitude 5 at latitude
    // atan(tan 50° / cos 5°) = 50.108°, that between the southern ones at 40.108°.
    let points = "lon,lat\n5,50.05\n5,40.05\n5,45\n5,50.2\n5,40.2\n";
    let planar = locate(&desk, &["r.geojson", "--edges", "planar"], points);
    let great = locate(&desk, &["r.geojson", "--edges", "great-ellipse"], points);
    assert_eq!(found(&planar), ["", "0", "0", "", "0"]);
    assert_eq!(found(&great), ["0", "", "0", "", "0"]);
    assert_eq!(locate(&desk, &["r.geojson"], points), planar);
}

#[test]
fn crossing_rings_are_judged_by_the_even_odd_rule_when_asked_for() {
    let desk = Desk::new();
    let squares = "[[[[0,0],[2,0],[2,2],[0,2],[0,0]]],[[[1,1],[3,1],[3,3],[1,3],[1,1]]]]";
    let text = format!(r#"{{"type":"MultiPolygon","coordinates":{squares}}}"#);
    desk.write(
        "r.geojson",
        collection(&[("tie", polygon(&BOW_TIE)), ("two", text)]),
    );
    let points = "lon,lat\n0.25,0.4\n0.5,0.25\n0.75,0.4\n1.5,1.5\n2.5,2.5\n";
    for edges in ["planar", "great-ellipse"] {
        let (text, repairs) = locate_repaired(&desk, &["r.geojson", "--edges", edges], points);
        // In order: the western wing; below the knot, in the square alone; the eastern wing; where
        // both squares are; in the second square.
        assert_eq!(found(&text), ["0;1", "1", "0;1", "", "1"], "{edges}");
        let expected = [
            "feature 0 (tie): 1 crossing of edges",
            "feature 1 (two): 2 crossings of edges",
            "feature 1 (two): 1 overlap of parts",
        ];
        let is_change = |text: &&String| !text.contains("area as repaired");
        let repairs: Vec<&String> = repairs.iter().filter(is_change).collect();
        assert_eq!(repairs.len(), expected.len(), "{repairs:?}");
        for (repair, expected) in repairs.iter().zip(expected) {
            assert!(repair.contains(expected), "{repair}");
        }
    }
    desk.run(&["locate", "r.geojson", "--points", "points.csv"])
        .refused(&[
            &["feature 0 (tie)", "latitude 0.5000000", "--repair even-odd"],
            &[
                "feature 1 (two)",
                "longitude 2.0000000",
                "--repair even-odd",
            ],
            &[
                "feature 1 (two)",
                "longitude 1.0000000",
                "--repair even-odd",
            ],
        ]);
}

#[test]
fn overlapping_parts_are_refused_until_even_odd_is_asked_for() {
    let desk = Desk::new();
    let outer = "[[0,0],[10,0],[10,10],[0,10],[0,0]]";
    let inner = "[[2,2],[8,2],[8,8],[2,8],[2,2]]";
    let beside = "[[20,0],[30,0],[30,10],[20,10],[20,0]]";
    let multi = |rings: [&str; 2]| {
        let [a, b] = rings;
        format!(r#"{{"type":"MultiPolygon","coordinates":[[{a}],[{b}]]}}"#)
    };
    desk.write(
        "over.geojson",
        collection(&[("over", multi([outer, inner]))]),
    );
    desk.write(
        "apart.geojson",
        collection(&[("apart", multi([outer, beside]))]),
    );
    let points = "lon,lat\n1,1\n5,5\n25,5\n";
    desk.write("points.csv", points);
    for edges in ["planar", "great-ellipse"] {
        let arguments = ["locate", "over.geojson", "--points", "points.csv"];
        desk.run(&[&arguments[..], &["--edges", edges]].concat())
            .refused(&[&[
                "feature 0 (over)",
                "polygon 0 and polygon 1 overlap",
                "--repair even-odd",
            ]]);
        let arguments = ["over.geojson", "--edges", edges];
        let (text, repairs) = locate_repaired(&desk, &arguments, points);
        assert_eq!(found(&text), ["0", "", ""], "{edges}");
        let listed = "repaired: feature 0 (over): 1 overlap of parts: filled by the even-odd rule";
        assert_eq!(repairs[0], listed, "{edges}");
        assert!(repairs[1].contains("area as repaired"), "{edges}");
        // Negative control: parts that do not overlap are located without being asked twice.
        let arguments = ["apart.geojson", "--edges", edges];
        assert_eq!(found(&locate(&desk, &arguments, points)), ["0", "0", "0"]);
        // Nor is anything said of them when it is asked for.
        let (text, repairs) = locate_repaired(&desk, &arguments, points);
        assert_eq!((found(&text), repairs.len()), (vec!["0", "0", "0"], 0));
    }
}

#[test]
fn knots_on_the_antimeridian_and_rings_beyond_a_hemisphere_are_located() {
    let desk = Desk::new();
    let tie = "[[170,0],[190,10],[170,10],[190,0],[170,0]]";
    let polygon = |ring: &str| format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#);
    desk.write("tie.geojson", collection(&[("tie", polygon(tie))]));
    let points = "lon,lat\n172,5\n-172,5\n180,1\n";
    desk.write("points.csv", points);
    desk.run(&["locate", "tie.geojson", "--points", "points.csv"])
        .refused(&[&[
            "feature 0 (tie)",
            "longitude 180.0000000, latitude 5.0000000",
            "--repair even-odd",
        ]]);
    let (text, repairs) = locate_repaired(&desk, &["tie.geojson"], points);
    assert_eq!(found(&text), ["", "", "0"]);
    let listed = "repaired: feature 0 (tie): 1 crossing of edges: filled by the even-odd rule";
    assert_eq!(repairs[0], listed);
    // Round the axis and over the equator: in no hemisphere.
    let wide = "[[0,30],[60,-10],[120,30],[180,-10],[240,30],[300,-10],[0,30]]";
    desk.write("wide.geojson", collection(&[("wide", polygon(wide))]));
    let points = "lon,lat\n0,90\n60,0\n0,20\n0,-90\n";
    let text = locate(&desk, &["wide.geojson", "--edges", "great-ellipse"], points);
    assert_eq!(found(&text), ["0", "0", "", ""]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn cities_lie_in_their_countries() {
    let file = data::file("vectors/ne_110m_admin_0_countries.geojson");
    let file = file.display().to_string();
    let desk = Desk::new();
    let json = desk
        .run(&["mesh", &file, "--json", "--repair", "even-odd"])
        .succeeded();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let places = [
        (2.35, 48.86, Some("France")),
        (-77.04, -12.05, Some("Peru")),
        (32.53, 15.5, Some("Sudan")),
        (149.13, -35.28, Some("Australia")),
        (179.9, 68.0, Some("Russia")),
        (-179.9, 68.0, Some("Russia")),
        (0.0, -89.9, Some("Antarctica")),
        (28.5, -29.5, Some("Lesotho")),
        (-30.0, 40.0, None),
    ];
    let mut points = "lon,lat\n".to_owned();
    for (longitude, latitude, _) in places {
        points += &format!("{longitude},{latitude}\n");
    }
    let (text, repairs) = locate_repaired(&desk, &[&file], &points);
    // What `mesh` lists of the same file.
    let regions = json["regions"].as_array().expect("regions");
    let warnings = regions
        .iter()
        .filter_map(|region| region["warnings"].as_array());
    let listed = warnings.flatten().filter_map(|warning| warning.as_str());
    let listed: Vec<&str> = listed.filter(|text| text.contains("even-odd")).collect();
    assert!(
        !listed.is_empty() && listed.len() == repairs.len(),
        "{repairs:?}"
    );
    for (repair, warning) in repairs.iter().zip(listed) {
        assert!(repair.starts_with("repaired: feature ") && repair.ends_with(warning));
    }
    for (cell, (longitude, latitude, name)) in found(&text).into_iter().zip(places) {
        let index: Option<usize> = cell.parse().ok();
        let found = index.and_then(|index| json["regions"][index]["name"].as_str());
        assert_eq!(found, name, "{longitude}, {latitude}: {cell:?}");
    }
}
