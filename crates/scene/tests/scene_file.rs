// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files that are wrong: each gives one exact message, and the same file unbroken loads.

use sha2::{Digest, Sha256};
use terrafill_core::EdgeRule;
use terrafill_scene::{LevelChoice, Overlap, Scene, SceneError};

const GOOD: &str = r#"name = "test"
description = "One square"
body = "wgs84"

[regions]
embedded = "california.geojson"

[surface]
kind = "ellipsoid"

[[views]]
name = "a"
longitude_deg = 10
latitude_deg = 20
height_m = 5_000
heading_deg = 0
pitch_deg = -90
"#;

const SECOND_VIEW: &str = r#"
[[views]]
name = "a"
longitude_deg = 0
latitude_deg = 0
height_m = 1
heading_deg = 0
pitch_deg = 0
"#;

const FILE_SOURCE: &str = r#"file = "a.geojson"
sha256 = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
how = "draw it""#;

fn message(text: &str) -> String {
    match Scene::from_toml(text, "t.toml", None) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Replaces one part of the good scene; the part must be there.
fn broken(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    GOOD.replacen(from, to, 1)
}

#[test]
fn the_good_scene_loads_with_its_defaults() {
    let scene = Scene::from_toml(GOOD, "t.toml", None).expect("valid");
    assert_eq!(scene.edge_rule, EdgeRule::Planar);
    assert_eq!(scene.overlap, Overlap::Disjoint);
    assert_eq!(scene.surface_rows, 180);
    assert!(scene.sweep_boundary_tolerance_m.is_empty() && scene.sweep_cap_step_deg.is_empty());
    assert_eq!(scene.levels, LevelChoice::Automatic);
    let pose = scene.views[0].pose;
    assert_eq!(pose.near_m, 5.0);
    assert_eq!(pose.fov_y_rad, 60_f64.to_radians());
    assert_eq!(pose.eye.latitude_rad, 20_f64.to_radians());
}

#[test]
fn every_setting_arrives() {
    let text = broken(
        "body = \"wgs84\"",
        "body = \"moon\"\nedges = \"great-ellipse\"\noverlap = \"ordered\"",
    ) + "fov_deg = 45\nnear_m = 0.25\nnote = \"n\"\n\n[mesh]\nboundary_tolerance_m = 7\n\
         cap_step_deg = 2\n\n[levels]\ndeviation_m = [30, 400.5]\n\n[vary]\nboundary_tolerance_m = [1, 2.5]\n\
         cap_step_deg = [0.5, 10]\n";
    let scene = Scene::from_toml(&text, "t.toml", None).expect("valid");
    assert_eq!(scene.body.name(), "moon");
    assert_eq!(scene.edge_rule, EdgeRule::GreatEllipse);
    assert_eq!(scene.overlap, Overlap::Ordered);
    assert_eq!(scene.mesh.boundary_tolerance_m, 7.0);
    assert_eq!(scene.mesh.cap_step_deg, 2.0);
    assert_eq!(scene.levels, LevelChoice::Given(vec![30.0, 400.5]));
    assert_eq!(scene.sweep_boundary_tolerance_m, [1.0, 2.5]);
    assert_eq!(scene.sweep_cap_step_deg, [0.5, 10.0]);
    let view = &scene.views[0];
    assert_eq!(view.note.as_deref(), Some("n"));
    assert_eq!(
        (view.pose.near_m, view.pose.fov_y_rad),
        (0.25, 45_f64.to_radians())
    );
}

#[test]
fn values_outside_what_is_allowed() {
    let no_views = GOOD.split("[[views]]").next().expect("a head");
    let cases = [
        (
            broken("\"wgs84\"", "\"venus\""),
            "t.toml: body: found \"venus\", allowed: wgs84, moon, mars, saturn-like, unit-sphere, \
             asteroid-250m",
        ),
        (
            broken("body = \"wgs84\"", "body = \"wgs84\"\nedges = \"rhumb\""),
            "t.toml: edges: found \"rhumb\", allowed: planar, great-ellipse",
        ),
        (
            broken("name = \"test\"", "name = \"a/b\""),
            "t.toml: name: found \"a/b\", allowed: lower-case letters, digits and -",
        ),
        (
            broken("latitude_deg = 20", "latitude_deg = 91"),
            "t.toml: views[0].latitude_deg: found 91, allowed: -90 to 90",
        ),
        (
            broken("latitude_deg = 20", "latitude_deg = nan"),
            "t.toml: views[0].latitude_deg: found NaN, allowed: -90 to 90",
        ),
        (
            broken("height_m = 5_000", "height_m = inf"),
            "t.toml: views[0].height_m: found inf, allowed: greater than 0",
        ),
        (
            format!("views = []\n{no_views}"),
            "t.toml: views: found 0 views, allowed: at least 1",
        ),
        (
            format!("{GOOD}{SECOND_VIEW}"),
            "t.toml: views[1].name: found \"a\" again, allowed: a name of its own",
        ),
        (
            format!("{GOOD}\n[mesh]\nboundary_tolerance_m = -1\n"),
            "t.toml: mesh.boundary_tolerance_m: found -1, allowed: greater than 0",
        ),
        (
            format!("{GOOD}\n[mesh]\ncap_step_deg = 31\n"),
            "t.toml: mesh.cap_step_deg: found 31, allowed: greater than 0, at most 30",
        ),
        (
            format!("{GOOD}\n[levels]\ndeviation_m = [100, 100]\n"),
            "t.toml: levels.deviation_m[1]: found 100, allowed: greater than 100",
        ),
        (
            format!("{GOOD}\n[vary]\ncap_step_deg = [10, 31]\n"),
            "t.toml: vary.cap_step_deg[1]: found 31, allowed: greater than 0, at most 30",
        ),
        (
            format!("{GOOD}\n[vary]\nboundary_tolerance_m = [10, 0]\n"),
            "t.toml: vary.boundary_tolerance_m[1]: found 0, allowed: greater than 0",
        ),
        (
            broken("kind = \"ellipsoid\"", "kind = \"ellipsoid\"\nrows = 3"),
            "t.toml: surface.rows: found 3, allowed: 4 to 4096",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(message(&text), expected);
    }
}

#[test]
fn region_sources_that_are_not_exactly_one() {
    let embedded = "embedded = \"california.geojson\"";
    let cases = [
        (
            broken(embedded, &format!("{embedded}\n{FILE_SOURCE}")),
            "t.toml: regions: found file and embedded, allowed: exactly one of file, embedded, \
             procedural",
        ),
        (
            broken(embedded, ""),
            "t.toml: regions: found none, allowed: exactly one of file, embedded, procedural",
        ),
        (
            broken(embedded, "embedded = \"nevada.geojson\""),
            "t.toml: regions.embedded: found \"nevada.geojson\", allowed: california.geojson",
        ),
        (
            broken(embedded, &FILE_SOURCE.replace("a.geojson", "../a.geojson")),
            "t.toml: regions.file: found \"../a.geojson\", allowed: a path inside the data folder",
        ),
        (
            broken(embedded, &FILE_SOURCE.replace("e3b0", "E3B0")),
            "t.toml: regions.sha256: found \
             \"E3B0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855\", allowed: \
             64 lower-case hexadecimal digits",
        ),
        (
            broken(embedded, &format!("{embedded}\nhow = \"buy it\"")),
            "t.toml: regions.how: found a value, allowed: only together with file",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(message(&text), expected);
    }
}

#[test]
fn crossing_rings_stay_as_they_are_unless_the_scene_asks_for_repair() {
    // A bow tie of four vertices, crossing in the middle.
    let bow_tie = br#"{"type":"Polygon","coordinates":[[[0,0],[2,2],[2,0],[0,2],[0,0]]]}"#;
    let sha256: String = Sha256::digest(bow_tie)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::write(folder.path().join("a.geojson"), bow_tie).expect("writable");
    let source = format!("file = \"a.geojson\"\nsha256 = \"{sha256}\"\nhow = \"draw it\"");
    let vertices = |repair: &str| {
        let text = broken(
            "embedded = \"california.geojson\"",
            &format!("{source}\n{repair}"),
        );
        Scene::from_toml(&text, "t.toml", Some(folder.path()))
            .map(|scene| scene.regions[0].vertex_count())
            .map_err(|error| error.to_string())
    };
    assert_eq!(vertices(""), Ok(4));
    assert_eq!(vertices("repair = \"even-odd\""), Ok(6));
    assert_eq!(
        vertices("repair = \"buffer\""),
        Err("t.toml: regions.repair: found \"buffer\", allowed: even-odd".to_owned())
    );
}

#[test]
fn unknown_keys_missing_keys_and_wrong_types_name_their_line() {
    let cases = [
        (
            broken("description", "summary"),
            "t.toml:2:1: unknown field `summary`",
        ),
        (
            broken("pitch_deg = -90", "pitch = -90"),
            "t.toml:17:1: unknown field `pitch`",
        ),
        (broken("height_m = 5_000\n", ""), "missing field `height_m`"),
        (
            broken("height_m = 5_000", "height_m = \"low\""),
            "t.toml:15:12: invalid type",
        ),
        (broken("name = \"test\"", "name = "), "t.toml:1:"),
    ];
    for (text, expected) in cases {
        let found = message(&text);
        assert!(found.contains(expected), "{found}\nlacks {expected}");
        assert!(!found.contains('\n'), "more than a line: {found}");
    }
}

#[test]
fn a_wrong_scene_is_wrong_even_where_its_data_is_missing() {
    let with_file = broken("embedded = \"california.geojson\"", FILE_SOURCE);
    let error = Scene::from_toml(&with_file, "t.toml", None).expect_err("no data");
    assert!(matches!(error, SceneError::DataMissing { .. }), "{error}");
    let wrong = with_file.replace("latitude_deg = 20", "latitude_deg = 91");
    let error = Scene::from_toml(&wrong, "t.toml", None).expect_err("latitude");
    assert!(matches!(error, SceneError::Value { .. }), "{error}");
}

#[test]
fn a_scene_file_is_read_from_disk_and_its_path_is_in_the_message() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("s.toml");
    let missing = Scene::load(&path, None).expect_err("missing");
    assert!(
        matches!(missing, SceneError::Unreadable { .. }),
        "{missing}"
    );
    std::fs::write(&path, GOOD).expect("writable");
    assert_eq!(Scene::load(&path, None).expect("valid").name, "test");
    std::fs::write(&path, broken("= 20", "= 200")).expect("writable");
    let wrong = Scene::load(&path, None).expect_err("latitude");
    assert!(
        wrong.to_string().starts_with(&path.display().to_string()),
        "{wrong}"
    );
}
