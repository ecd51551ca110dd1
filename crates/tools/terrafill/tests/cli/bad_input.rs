// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that are wrong: exit code 2, one line per problem with its place, and nothing else.

use crate::harness::{BOW_TIE, Desk, collection, polygon, rectangle};

/// A wrong file of regions, and what the line about it must hold.
struct Wrong {
    name: &'static str,
    content: String,
    phrases: &'static [&'static str],
}

fn wrong_regions() -> Vec<Wrong> {
    let square = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    let wrong = |name, content: &str, phrases| Wrong {
        name,
        content: content.to_owned(),
        phrases,
    };
    vec![
        wrong(
            "truncated",
            &square[..square.len() - 9],
            &["line 1, column 57"],
        ),
        wrong(
            "nan",
            &square.replace("[1,1]", "[NaN,1]"),
            &["line 1, column", "found \"NaN\""],
        ),
        wrong(
            "infinite",
            &square.replace("[1,1]", "[1e999,1]"),
            &["line 1, column", "1e999"],
        ),
        wrong(
            "latitude",
            &collection(&[
                ("one", square.clone()),
                ("two", square.replace("[1,1]", "[1,91]")),
            ]),
            &[
                "feature 1 (two)",
                "ring 0",
                "vertex 2",
                "latitude 91",
                "-90 … 90",
            ],
        ),
        wrong(
            "longitude",
            &square.replace("[1,1]", "[4e6,1]"),
            &["vertex 2", "longitude 4000000", "-540 … 540"],
        ),
        wrong(
            "two-points",
            &polygon(&[[0.0, 0.0], [1.0, 1.0]]),
            &["ring 0", "2 distinct positions", "at least 3"],
        ),
        wrong("empty", "", &["the file is empty", "GeoJSON"]),
        wrong("blank", " \r\n", &["the file is empty", "GeoJSON"]),
        wrong(
            "no-coordinates",
            r#"{"type":"Polygon","coordinates":[]}"#,
            &["no area", "found 1 empty Polygon"],
        ),
        wrong(
            "no-features",
            r#"{"type":"FeatureCollection"}"#,
            &["no \"features\"", "FeatureCollection"],
        ),
        wrong(
            "text-in-a-position",
            &square.replace("[1,1]", "[1,1,\"x\"]"),
            &[
                "vertex 2",
                "element 2 of the position is the text \"x\"",
                "expected a number",
            ],
        ),
        wrong(
            "utf-16",
            &square.chars().flat_map(|c| [c, '\0']).collect::<String>(),
            &["the file is UTF-16; expected UTF-8"],
        ),
        wrong(
            "projected",
            &square.replace("[1,1]", "[4e6,1]"),
            &["longitude 4000000", "looks projected", "degrees"],
        ),
        wrong(
            "bare-list",
            "[[[0,0],[9,0],[9,9]]]",
            &["bare list", "\"type\""],
        ),
        wrong(
            "line",
            r#"{"type":"LineString","coordinates":[[0,0],[1,1]]}"#,
            &["no area", "LineString", "Polygon"],
        ),
        wrong("not-json", "lon,lat\n1,2\n", &["line 1, column 1"]),
        wrong(
            "bow-tie",
            &collection(&[("one", square.clone()), ("tie", polygon(&BOW_TIE))]),
            &[
                "feature 1 (tie)",
                "ring 0, vertex 0",
                "ring 0, vertex 2",
                "longitude 0.5000000, latitude 0.5000000",
                "--repair even-odd",
            ],
        ),
        wrong(
            "no-width",
            &polygon(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]),
            &["feature 0", "enclose no area"],
        ),
    ]
}

/// The verbs that read a file of regions.
fn readers(file: &str) -> [Vec<String>; 3] {
    [
        vec!["mesh", file],
        vec!["mesh", file, "--json"],
        vec!["locate", file, "--points", "points.csv"],
    ]
    .map(|arguments| arguments.into_iter().map(str::to_owned).collect())
}

#[test]
fn wrong_files_of_regions_are_refused_in_one_line_that_says_where() {
    let desk = Desk::new();
    desk.write("points.csv", "lon,lat\n0.5,0.25\n");
    for wrong in wrong_regions() {
        let file = format!("{}.geojson", wrong.name);
        desk.write(&file, &wrong.content);
        let mut phrases = vec![file.as_str()];
        phrases.extend(wrong.phrases);
        for arguments in readers(&file) {
            desk.run(&arguments).refused(&[&phrases]);
        }
    }
    // The same commands on a right file do what they say.
    desk.write("right.geojson", polygon(&rectangle(0.0, 0.0, 1.0, 1.0)));
    for arguments in readers("right.geojson") {
        assert!(!desk.run(&arguments).succeeded().is_empty());
    }
}

#[test]
fn what_is_no_file_is_refused() {
    let desk = Desk::new();
    desk.write("points.csv", "lon,lat\n0,0\n");
    desk.write("folder/file", "");
    desk.write("right.geojson", polygon(&rectangle(0.0, 0.0, 1.0, 1.0)));
    for arguments in readers("none.geojson") {
        desk.run(&arguments)
            .refused(&[&["none.geojson: no such file"]]);
    }
    for arguments in readers("folder") {
        desk.run(&arguments)
            .refused(&[&["folder: is a directory, allowed: a GeoJSON file"]]);
    }
    desk.run(&["locate", "right.geojson", "--points", "none.csv"])
        .refused(&[&["none.csv: no such file"]]);
    desk.run(&["locate", "right.geojson", "--points", "folder"])
        .refused(&[&["folder: is a directory, allowed: a CSV file"]]);
}

#[test]
fn every_problem_of_a_file_is_told_at_once_and_nothing_of_it_is_printed() {
    let desk = Desk::new();
    let square = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    desk.write(
        "f.geojson",
        collection(&[
            ("good", square.clone()),
            (
                "high",
                square
                    .replace("[1,1]", "[1,91]")
                    .replace("[0,1]", "[0,-95]"),
            ),
            ("tie", polygon(&BOW_TIE)),
            ("thin", polygon(&[[0.0, 0.0], [1.0, 1.0]])),
        ]),
    );
    for arguments in [&["mesh", "f.geojson", "--json"][..], &["mesh", "f.geojson"]] {
        desk.run(arguments).refused(&[
            &["f.geojson: feature 1 (high)", "vertex 2", "latitude 91"],
            &["f.geojson: feature 1 (high)", "vertex 3", "latitude -95"],
            &["f.geojson: feature 3 (thin)", "2 distinct positions"],
            &["f.geojson: feature 2 (tie)", "latitude 0.5000000"],
        ]);
    }
    // A repair of the crossing leaves the rest as wrong as it is.
    desk.run(&["mesh", "f.geojson", "--repair", "even-odd"])
        .refused(&[&["latitude 91"], &["latitude -95"], &["2 distinct"]]);
}

#[test]
fn wrong_points_are_refused_with_line_and_column() {
    let desk = Desk::new();
    desk.write("r.geojson", polygon(&rectangle(0.0, 0.0, 1.0, 1.0)));
    let longitude = "allowed: a number from -540 to 540";
    let latitude = "allowed: a number from -90 to 90";
    let cases: [(&str, &[&[&str]]); 11] = [
        ("", &[&["the file is empty", "lon and lat"]]),
        ("x,lat\n1,2\n", &[&["no column lon", "found: x, lat"]]),
        (
            "1,2\n3,4\n",
            &[&["line 1: no column lon"], &["line 1: no column lat"]],
        ),
        (
            "lon,lat\n1,2\nhere,4\n",
            &[&["line 3, lon", "found \"here\"", longitude]],
        ),
        (
            "lon,lat\n1,91\n",
            &[&["line 2, lat", "found \"91\"", latitude]],
        ),
        (
            "lon,lat\n541,2\n",
            &[&["line 2, lon", "found \"541\"", longitude]],
        ),
        (
            "lon,lat\nNaN,1e999\n",
            &[
                &["line 2, lon", "found \"NaN\"", longitude],
                &["line 2, lat", "found \"1e999\"", latitude],
            ],
        ),
        (
            "lon,lat\n,1\n",
            &[&["line 2, lon", "found \"\"", longitude]],
        ),
        (
            "lon,lat\n1\n",
            &[&["line 2, lat", "found no cell", latitude]],
        ),
        // Blank lines count as lines.
        (
            "lon,lat\n\n\n1,2\n\n1,x\n",
            &[&["line 6, lat", "found \"x\"", latitude]],
        ),
        (
            "id,lon,lat\na,1,2\nb,3,-100\nc,4,x\n",
            &[
                &["line 3, lat", "found \"-100\"", latitude],
                &["line 4, lat", "found \"x\"", latitude],
            ],
        ),
    ];
    for (content, problems) in cases {
        desk.write("p.csv", content);
        let ran = desk.run(&["locate", "r.geojson", "--points", "p.csv"]);
        ran.refused(problems);
        let named = ran.stderr.lines().all(|line| line.contains("p.csv: "));
        assert!(named, "{}", ran.stderr);
    }
    desk.write("p.csv", b"lon,lat\n1,2\n\xff,2\n");
    desk.run(&["locate", "r.geojson", "--points", "p.csv"])
        .refused(&[&["p.csv: line 3: not UTF-8"]]);
}

#[test]
fn wrong_scenes_are_refused_and_leave_no_folder_behind() {
    let desk = Desk::new();
    desk.write_scene("right", &polygon(&rectangle(-9.0, -9.0, 9.0, 9.0)));
    let right = desk.read_text("right.toml");
    let replace = |from: &str, to: &str| {
        assert!(right.contains(from), "{from} is in the scene");
        right.replace(from, to)
    };
    desk.write_scene("tie", &polygon(&BOW_TIE));
    desk.write_scene("high", &polygon(&rectangle(-9.0, -9.0, 9.0, 95.0)));
    desk.write(
        "latitude.toml",
        replace("latitude_deg = 0", "latitude_deg = 91"),
    );
    desk.write(
        "nan.toml",
        replace("latitude_deg = 0", "latitude_deg = nan"),
    );
    desk.write("key.toml", replace("heading_deg", "heding_deg"));
    desk.write("body.toml", replace("wgs84", "pluto"));
    // Half the globe in steps of a hundredth of a degree: hundreds of millions of triangles.
    desk.write_scene("half", &polygon(&rectangle(-80.0, -80.0, 80.0, 80.0)));
    let half = desk.read_text("half.toml");
    desk.write("fine.toml", format!("{half}[mesh]\ncap_step_deg = 0.01\n"));
    desk.write("broken.toml", &right[..right.len() / 2]);
    desk.write("empty.toml", "");
    desk.write("folder.toml/file", "");
    let cases: [(&str, &[&[&str]]); 13] = [
        (
            "fine.toml",
            &[&["feature 0", "cap_step_deg is 0.01", "allowed are 4e6"]],
        ),
        (
            "atlantis",
            &[&["atlantis", "allowed: planet-134, california"]],
        ),
        ("none.toml", &[&["none.toml: cannot be read"]]),
        ("folder.toml", &[&["folder.toml: cannot be read"]]),
        (
            "latitude.toml",
            &[&[
                "latitude.toml",
                "views[0].latitude_deg",
                "found 91",
                "-90 to 90",
            ]],
        ),
        ("nan.toml", &[&["nan.toml", "views[0].latitude_deg", "NaN"]]),
        ("key.toml", &[&["key.toml:16:", "heding_deg"]]),
        (
            "body.toml",
            &[&["body.toml", "\"pluto\"", "allowed: wgs84"]],
        ),
        ("broken.toml", &[&["broken.toml:"]]),
        ("empty.toml", &[&["empty.toml:1:1", "name"]]),
        ("tie.toml", &[&["tie", "feature 0", "latitude 0.5000000"]]),
        (
            "high.toml",
            &[
                &["high.geojson: feature 0", "vertex 2", "latitude 95"],
                &["high.geojson: feature 0", "vertex 3", "latitude 95"],
            ],
        ),
        // No device is asked before the scene is read.
        ("./none.toml", &[&["none.toml: cannot be read"]]),
    ];
    for (scene, problems) in cases {
        let data = ["--data", "data", "--out"];
        let bench = [&["bench", scene][..], &data, &["result"]].concat();
        desk.run(&bench).refused(problems);
        let render = ["render", scene, "--view", "above"];
        let render = [&render[..], &data, &["result.png"]].concat();
        desk.run(&render).refused(problems);
        for result in ["result", "result.png"] {
            assert!(!desk.path(result).exists(), "{scene}");
        }
    }
    desk.run(&["bench", "right.toml", "right.toml", "--data", "data"])
        .refused(&[&["scene \"right\" is given twice"]]);
    assert!(!desk.path("out").exists());
}

#[test]
fn pictures_that_cannot_be_written_are_refused_before_anything_is_drawn() {
    let desk = Desk::new();
    desk.write("folder/file", "kept");
    let render = ["render", "california", "--view", "globe", "--size", "8"];
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--out", "none/a.png"], &["none/a.png", "no folder none"]),
        (&["--out", "folder"], &["folder", "is a directory"]),
        (&["--out", "a.png", "--ids", "none/i.png"], &["none/i.png"]),
        (&["--out", "a.png", "--stats", "none/s"], &["none/s"]),
        (
            &["--out", "a.png", "--ids", "a.png"],
            &["a.png", "two outputs"],
        ),
        (&["--out", "folder/file/a.png"], &["no folder folder/file"]),
    ];
    for (outputs, phrases) in cases {
        for backend in ["reference", "vertex"] {
            let arguments = [&render[..], outputs, &["--technique", backend]].concat();
            desk.run(&arguments).refused(&[phrases]);
        }
    }
    desk.run(&["render", "california", "--view", "moon", "--out", "a.png"])
        .refused(&[&["--view: found \"moon\", allowed: globe, top-down, horizon"]]);
    assert_eq!(desk.names(), ["folder"], "nothing was written");
    assert_eq!(desk.read("folder/file"), b"kept");
}
