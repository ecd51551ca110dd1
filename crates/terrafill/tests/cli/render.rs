// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render`: whose pixel is whose, what the statistics hold, and every switch.

use crate::harness::{Desk, collection, has_device, polygon, rectangle};
use image::DynamicImage;
use serde_json::Value;
use std::collections::BTreeSet;

/// Region 0 in the west, 1 in the east, a gap of 2° between them, 2 far off; from 3,000 km up a
/// view of 60° reaches 17° from the middle to the edge of the picture.
fn write_squares(desk: &Desk) {
    desk.write_scene(
        "squares",
        &collection(&[
            ("west", polygon(&rectangle(-9.0, -8.0, -1.0, 8.0))),
            ("east", polygon(&rectangle(1.0, -8.0, 9.0, 8.0))),
            ("far", polygon(&rectangle(170.0, -8.0, 190.0, 8.0))),
        ]),
    );
}

const SCENE: [&str; 10] = [
    "render",
    "squares.toml",
    "--view",
    "above",
    "--data",
    "data",
    "--size",
    "96x64",
    "--out",
    "a.png",
];

fn render(desk: &Desk, more: &[&str]) {
    let text = desk.run(&[&SCENE[..], more].concat()).succeeded();
    assert_eq!(text, "");
}

fn ids(desk: &Desk) -> Vec<u16> {
    match image::open(desk.path("ids.png")).expect("a picture") {
        DynamicImage::ImageLuma16(ids) => {
            assert_eq!(ids.dimensions(), (96, 64));
            ids.into_raw()
        }
        other => panic!("{:?} instead of 16-bit grey", other.color()),
    }
}

/// At the middle of each square, between them, and outside.
fn probes(ids: &[u16]) -> [u16; 5] {
    [(39, 32), (57, 32), (48, 32), (48, 2), (2, 32)].map(|(x, y)| ids[y * 96 + x])
}

fn statistics(desk: &Desk) -> Value {
    serde_json::from_slice(&desk.read("s.json")).expect("JSON")
}

fn keys(value: &Value) -> BTreeSet<&str> {
    let object = value.as_object().expect("an object");
    object.keys().map(String::as_str).collect()
}

const STATISTICS_KEYS: [&str; 13] = [
    "scene",
    "view",
    "backend",
    "variant",
    "width",
    "height",
    "filled_px",
    "non_finite",
    "counters",
    "memory",
    "regions_drawn",
    "left_out",
    "cap_acmr",
];

#[test]
fn the_reference_gives_each_pixel_its_regions_index_plus_one() {
    let desk = Desk::new();
    write_squares(&desk);
    let outputs = ["--ids", "ids.png", "--stats", "s.json"];
    render(&desk, &[&["--backend", "reference"][..], &outputs].concat());
    let ids = ids(&desk);
    assert_eq!(probes(&ids), [1, 2, 0, 0, 0]);
    assert_eq!(
        ids.iter().filter(|id| **id > 2).count(),
        0,
        "3 is out of sight"
    );
    let statistics = statistics(&desk);
    assert_eq!(keys(&statistics), BTreeSet::from(STATISTICS_KEYS));
    let filled = ids.iter().filter(|id| **id > 0).count();
    assert_eq!(statistics["filled_px"], filled);
    assert_eq!(statistics["backend"], "reference");
    assert_eq!(
        (&statistics["width"], &statistics["height"]),
        (&96.into(), &64.into())
    );
    // What the reference does not have is null, not 0.
    assert_eq!(
        (&statistics["counters"], &statistics["memory"]),
        (&Value::Null, &Value::Null)
    );
    // The picture shows what the ids say: two colours beside that of the bare surface.
    let picture = image::open(desk.path("a.png"))
        .expect("a picture")
        .into_rgb8();
    assert_eq!(picture.dimensions(), (96, 64));
    let colour = |x, y| *picture.get_pixel(x, y);
    assert_ne!(colour(39, 32), colour(57, 32));
    assert_ne!(colour(39, 32), colour(48, 32));
}

#[test]
fn the_reference_takes_no_switches() {
    let desk = Desk::new();
    write_squares(&desk);
    let more = ["--backend", "reference", "--variant", "layout=pulled"];
    desk.run(&[&SCENE[..], &more].concat()).refused(&[&[
        "--variant",
        "\"layout=pulled\"",
        "allowed: none with",
    ]]);
    assert!(!desk.path("a.png").exists());
}

#[test]
fn every_switch_of_the_vertex_backend_draws_what_the_reference_does() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    write_squares(&desk);
    let outputs = ["--ids", "ids.png", "--stats", "s.json"];
    render(&desk, &[&["--backend", "reference"][..], &outputs].concat());
    let expected = ids(&desk);
    let switches: [(&[&str], &str); 20] = [
        (&[], "doubled"),
        (&["layout=doubled"], "doubled"),
        (&["layout=pulled"], "pulled"),
        (&["positions=fixed"], "doubled"),
        (&["positions=local-f32"], "doubled,positions=local-f32"),
        (&["colour=xor"], "doubled"),
        (&["colour=rectangle"], "doubled,colour=rectangle"),
        (&["boundary-tolerance-m=1"], "doubled"),
        (
            &["layout=pulled", "colour=rectangle", "positions=local-f32"],
            "pulled,colour=rectangle,positions=local-f32",
        ),
        (&["layout=separate"], "separate"),
        (&["layout=per-triangle"], "per-triangle"),
        (&["walls=list"], "doubled,walls=list"),
        (&["index-order=cache"], "doubled,index-order=cache"),
        (&["vertex-bytes=20"], "doubled,vertex-bytes=20"),
        (
            &["opacity=60", "colour=volume"],
            "doubled,colour=volume,opacity=60",
        ),
        (
            &["colour=id-accumulation"],
            "doubled,colour=id-accumulation",
        ),
        (
            &["depth-rule=automatic", "bottom-cap=where-needed"],
            "doubled,bottom-cap=where-needed,depth-rule=automatic",
        ),
        (&["frustum-culling=off", "horizon-culling=off"], "doubled"),
        (&["too-small-culling=off"], "doubled"),
        (&["boundary-lod-px=0.5"], "doubled"),
    ];
    for (values, name) in switches {
        let mut more = vec!["--backend", "vertex"];
        more.extend(values.iter().flat_map(|value| ["--variant", value]));
        more.extend(outputs);
        render(&desk, &more);
        let statistics = statistics(&desk);
        assert_eq!(statistics["variant"], name, "{values:?}");
        let ids = ids(&desk);
        assert_eq!(probes(&ids), [1, 2, 0, 0, 0], "{values:?}");
        let pairs = ids.iter().zip(&expected);
        let mismatches = pairs.filter(|(found, expected)| found != expected).count();
        assert!(mismatches <= 20, "{mismatches} pixels, {values:?}");
        let filled = ids.iter().filter(|id| **id > 0).count();
        assert_eq!(statistics["filled_px"], filled);
    }
}

#[test]
fn statistics_hold_counters_bytes_and_what_was_left_out() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    write_squares(&desk);
    // Vertex is the default.
    render(&desk, &["--stats", "s.json"]);
    let statistics = statistics(&desk);
    assert_eq!(keys(&statistics), BTreeSet::from(STATISTICS_KEYS));
    assert_eq!(statistics["backend"], "vertex");
    assert_eq!(
        keys(&statistics["counters"]),
        BTreeSet::from([
            "draws",
            "vertices",
            "upload_bytes",
            "vertex_shader_invocations",
            "clipper_invocations",
            "clipper_primitives_out",
            "fragment_shader_invocations",
            "stencil_fragments",
            "buffer_creations",
            "pipeline_creations",
            "uploads",
        ])
    );
    assert_eq!(
        keys(&statistics["memory"]),
        BTreeSet::from([
            "buffers",
            "vertex_bytes",
            "index_bytes",
            "constant_bytes",
            "geometry_bytes",
        ])
    );
    let number = |value: &Value| value.as_u64().expect("a count");
    let memory = &statistics["memory"];
    assert_eq!(
        number(&memory["geometry_bytes"]),
        number(&memory["vertex_bytes"]) + number(&memory["index_bytes"])
    );
    assert!(number(&statistics["counters"]["draws"]) > 0);
    // Each filled pixel lies under a top and over a bottom.
    let filled = number(&statistics["filled_px"]);
    assert!(number(&statistics["counters"]["stencil_fragments"]) >= 2 * filled);
    let acmr = statistics["cap_acmr"].as_f64().expect("a ratio");
    assert!((0.5..=3.0).contains(&acmr), "{acmr}");
    assert_eq!(statistics["regions_drawn"], 2);
    let left_out = statistics["left_out"].as_array().expect("a list");
    assert_eq!(left_out.len(), 1);
    assert_eq!(
        (&left_out[0]["index"], &left_out[0]["name"]),
        (&2.into(), &"far".into())
    );
    assert!(
        left_out[0]["reason"]
            .as_str()
            .is_some_and(|reason| !reason.is_empty())
    );
}

#[test]
fn wrong_switches_are_refused_and_nothing_is_written() {
    let desk = Desk::new();
    write_squares(&desk);
    let before = desk.names();
    // Unknown keys are answered with all keys, unknown values with the values of their key.
    let keys = "layout=doubled|separate|per-triangle|pulled, positions=fixed|local-f32";
    for (wrong, allowed) in [
        ("layout=tripled", "layout=doubled, separate"),
        ("layout", "layout=doubled, separate"),
        ("layout=", "layout=doubled, separate"),
        ("colour=", "colour=xor, rectangle"),
        ("colour=red", "colour=xor, rectangle"),
        ("positions=f64", "positions=fixed, local-f32"),
        ("walls=fan", "walls=strip, list"),
        ("index-order=random", "index-order=mesh, cache"),
        ("vertex-bytes=12", "vertex-bytes=16, 20"),
        ("opacity=0", "opacity=whole percent, 1 to 100"),
        ("frustum-culling=maybe", "on, off"),
        ("Layout=pulled", keys),
        ("speed=fast", keys),
        ("", keys),
    ] {
        let more = ["--ids", "ids.png", "--variant", wrong];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&[&format!("--variant: found {wrong:?}, allowed: {allowed}")]]);
    }
    // What is right alone and wrong together is refused with what it does not go with.
    for (together, message) in [
        (["layout=pulled", "walls=list"], "walls: found list with"),
        (
            ["layout=separate", "vertex-bytes=20"],
            "vertex-bytes: found 20",
        ),
        (
            ["colour=xor", "opacity=50"],
            "opacity: found 50 with colour=xor",
        ),
    ] {
        let more = ["--variant", together[0], "--variant", together[1]];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&["--variant", message]]);
    }
    for wrong in ["0", "-1", "wide", "NaN", "inf", ""] {
        let wrong = format!("boundary-tolerance-m={wrong}");
        desk.run(&[&SCENE[..], &["--variant", &wrong]].concat())
            .refused(&[&["--variant", &wrong, "allowed: boundary-tolerance-m=METRES"]]);
    }
    assert_eq!(desk.names(), before);
}

#[test]
fn an_older_picture_is_replaced_whole_and_kept_when_drawing_fails() {
    let desk = Desk::new();
    write_squares(&desk);
    desk.write("a.png", vec![0; 100_000]);
    let ran = desk.run_without_device(&SCENE);
    assert_eq!(ran.code, 5, "{}", ran.stderr);
    assert_eq!(desk.read("a.png").len(), 100_000);
    render(&desk, &["--backend", "reference"]);
    assert!(image::open(desk.path("a.png")).is_ok());
    assert_eq!(desk.names(), ["a.png", "data", "squares.toml"]);
}
