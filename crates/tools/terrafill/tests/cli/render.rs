// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render`: whose pixel is whose, what the statistics hold, and every switch.

use crate::harness::{
    Desk, Ran, a_device, collection, exact_techniques, has_device, polygon, rectangle, techniques,
};
use image::DynamicImage;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

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
    assert!(is_written(&text, "a.png"), "{text}");
}

/// Whether it says that this file was written, after how many seconds, and nothing else.
fn is_written(text: &str, file: &str) -> bool {
    let seconds = text.strip_prefix(&format!("wrote {file}, "));
    let seconds = seconds.and_then(|text| text.strip_suffix(" s\n"));
    seconds.is_some_and(|seconds| seconds.parse::<f64>().is_ok())
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

#[test]
fn the_reference_fills_with_a_texture_where_the_scene_has_one() {
    let desk = Desk::new();
    let draw = |out: &str, more: &[&str]| {
        let scene = ["render", "california", "--view", "top-down", "--size", "48"];
        let rest = ["--technique", "reference", "--out", out];
        desk.run(&[&scene[..], &rest, more].concat())
    };
    draw("plain.png", &[]).succeeded();
    draw("off.png", &["--set", "texture=off"]).succeeded();
    draw("on.png", &["--set", "texture=on"]).succeeded();
    assert_eq!(desk.read("plain.png"), desk.read("off.png"));
    let colours = |path: &str| {
        let picture = image::open(desk.path(path)).expect("a picture").into_rgb8();
        picture.pixels().copied().collect::<Vec<_>>()
    };
    let distinct = |path: &str| {
        let all: BTreeSet<[u8; 3]> = colours(path).iter().map(|pixel| pixel.0).collect();
        all.len()
    };
    // One colour of land and one of sea, against a checker whose every cell has its own.
    assert_eq!(distinct("plain.png"), 2);
    assert!(distinct("on.png") > 20, "{}", distinct("on.png"));
    let ran = draw("no.png", &["--set", "texture=maybe"]);
    assert_eq!(ran.code, 2);
    let message = "found \"texture=maybe\", allowed: texture=on|off with --technique reference";
    assert!(ran.stderr.contains(message), "{}", ran.stderr);
    write_squares(&desk);
    let no_texture = ["--technique", "reference", "--set", "texture=on"];
    let ran = desk.run(&[&SCENE[..], &no_texture].concat());
    assert_eq!(ran.code, 2);
    assert!(
        ran.stderr.contains("which has no texture"),
        "{}",
        ran.stderr
    );
}

fn statistics(desk: &Desk) -> Value {
    serde_json::from_slice(&desk.read("s.json")).expect("JSON")
}

/// Those of every backend, and with them what the vertex backend says of its own.
fn statistics_keys(backend: &str) -> BTreeSet<&'static str> {
    let own = (backend == "vertex").then_some("cap_acmr");
    STATISTICS_KEYS.into_iter().chain(own).collect()
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
    "note",
];

#[test]
fn the_reference_gives_each_pixel_its_regions_index_plus_one() {
    let desk = Desk::new();
    write_squares(&desk);
    let outputs = ["--ids", "ids.png", "--stats", "s.json"];
    render(
        &desk,
        &[&["--technique", "reference"][..], &outputs].concat(),
    );
    let ids = ids(&desk);
    assert_eq!(probes(&ids), [1, 2, 0, 0, 0]);
    assert_eq!(
        ids.iter().filter(|id| **id > 2).count(),
        0,
        "3 is out of sight"
    );
    let statistics = statistics(&desk);
    assert_eq!(keys(&statistics), statistics_keys("reference"));
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
    let more = ["--technique", "reference", "--set", "layout=pulled"];
    desk.run(&[&SCENE[..], &more].concat()).refused(&[&[
        "--set",
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
    render(
        &desk,
        &[&["--technique", "reference"][..], &outputs].concat(),
    );
    let expected = ids(&desk);
    let switches: [(&[&str], &str); 22] = [
        // What a report calls so, and what gains most.
        (&["doubled"], "doubled"),
        (
            &[],
            "doubled,bottom-cap=where-needed,cover-area=tiles,depth-rule=uncut,draws=merged,held-meshes=drawn,index-order=cache",
        ),
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
        (
            &["walls=list", "full-plan", "cover-area=rectangle"],
            "doubled,bottom-cap=where-needed,depth-rule=uncut,draws=merged,held-meshes=drawn,index-order=cache",
        ),
        (&["boundary-lod-px=0.5"], "doubled"),
    ];
    for (values, name) in switches {
        let mut more = vec!["--technique", "vertex"];
        more.extend(values.iter().flat_map(|value| ["--set", value]));
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
    // Vertex is the default. Its bare variant counts each fragment of a volume.
    render(&desk, &["--set", "doubled", "--stats", "s.json"]);
    let statistics = statistics(&desk);
    assert_eq!(keys(&statistics), statistics_keys("vertex"));
    assert_eq!(statistics["backend"], "vertex");
    assert_eq!(
        keys(&statistics["counters"]),
        BTreeSet::from([
            "draws",
            "vertices",
            "upload_bytes",
            "vertex_shader_invocations",
            "geometry_shader_primitives",
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
            "target_bytes",
            "texture_bytes",
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
    let keys = "layout, positions, ";
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
        ("frustum-culling=maybe", "frustum-culling=on, off"),
        ("Layout=pulled", keys),
        ("speed=fast", keys),
        ("", keys),
    ] {
        let more = ["--ids", "ids.png", "--set", wrong];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&[&format!("--set: found {wrong:?}, allowed: {allowed}")]]);
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
        let more = ["--set", together[0], "--set", together[1]];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&["--set", message]]);
    }
    for wrong in ["0", "-1", "wide", "NaN", "inf", ""] {
        let wrong = format!("boundary-tolerance-m={wrong}");
        desk.run(&[&SCENE[..], &["--set", &wrong]].concat())
            .refused(&[&["--set", &wrong, "allowed: boundary-tolerance-m=METRES"]]);
    }
    assert_eq!(desk.names(), before);
}

/// Variants of every backend of volumes: switches and the name that they make.
const VARIANTS: [(&str, &[&str], &str); 25] = [
    ("vertex", &["doubled"], "doubled"),
    ("vertex", &["layout=pulled"], "pulled"),
    ("compute", &["per-frame"], "per-frame"),
    ("compute", &["expansion=cached"], "cached"),
    ("compute", &["gpu-culling=off"], "per-frame"),
    (
        "compute",
        &["gpu-culling=regions", "expansion=cached"],
        "cached,gpu-culling=regions",
    ),
    (
        "compute",
        &["gpu-culling=triangles", "transform=compute"],
        "per-frame,gpu-culling=triangles,transform=compute",
    ),
    ("compute", &["transform=vertex"], "per-frame"),
    (
        "compute",
        &["colour=volume", "faces=two-pass"],
        "per-frame,colour=volume,faces=two-pass",
    ),
    (
        "compute",
        &["boundary-tolerance-m=100", "frustum-culling=off"],
        "per-frame",
    ),
    ("compute", &["boundary-lod-px=0.5"], "per-frame"),
    ("native", &["gs-degenerate"], "gs-degenerate"),
    ("native", &["technique=vs-control"], "vs-control"),
    ("native", &["technique=gs-degenerate"], "gs-degenerate"),
    ("native", &["technique=gs-two-edges"], "gs-two-edges"),
    ("native", &["technique=gs-line"], "gs-line"),
    ("native", &["technique=gs-adjacency"], "gs-adjacency"),
    ("native", &["technique=gs-per-triangle"], "gs-per-triangle"),
    ("native", &["indices=strip"], "gs-degenerate"),
    ("native", &["indices=list"], "gs-degenerate,indices=list"),
    (
        "native",
        &["indices=list", "technique=gs-adjacency"],
        "gs-adjacency,indices=list",
    ),
    (
        "native",
        &["colour=bit-planes", "technique=gs-line"],
        "gs-line,colour=bit-planes",
    ),
    (
        "native",
        &["colour=id-accumulation"],
        "gs-degenerate,colour=id-accumulation",
    ),
    (
        "native",
        &["depth-copy=none", "horizon-culling=off"],
        "gs-degenerate",
    ),
    ("native", &["boundary-lod-px=0.5"], "gs-degenerate"),
];

#[test]
fn every_backend_writes_the_same_ids() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    write_squares(&desk);
    let outputs = ["--ids", "ids.png", "--stats", "s.json"];
    render(
        &desk,
        &[&["--technique", "reference"][..], &outputs].concat(),
    );
    let expected = desk.read("ids.png");
    for (backend, switches, name) in VARIANTS {
        let mut more = vec!["--technique", backend];
        more.extend(switches.iter().flat_map(|switch| ["--set", switch]));
        more.extend(outputs);
        render(&desk, &more);
        let case = format!("{backend} {switches:?}");
        assert!(desk.read("ids.png") == expected, "{case}");
        let statistics = statistics(&desk);
        assert_eq!(keys(&statistics), statistics_keys(backend), "{case}");
        assert_eq!(statistics["backend"], backend, "{case}");
        assert_eq!(statistics["variant"], name, "{case}");
        // Geometry shaders alone make primitives.
        let made = &statistics["counters"]["geometry_shader_primitives"];
        let has_shader = name.starts_with("gs-");
        assert_eq!(made.as_u64() > Some(0), has_shader, "{case}: {made}");
    }
    for technique in exact_techniques() {
        render(&desk, &["--technique", &technique, "--ids", "ids.png"]);
        assert!(desk.read("ids.png") == expected, "{technique}");
    }
    // Negative control: an edge moved by two pixels is another file.
    desk.write_scene(
        "squares",
        &collection(&[
            ("west", polygon(&rectangle(-9.0, -8.0, -1.0, 8.0))),
            ("east", polygon(&rectangle(1.0, -8.0, 8.0, 8.0))),
            ("far", polygon(&rectangle(170.0, -8.0, 190.0, 8.0))),
        ]),
    );
    for technique in exact_techniques()
        .into_iter()
        .chain(["reference".to_owned()])
    {
        render(&desk, &["--technique", &technique, "--ids", "ids.png"]);
        assert!(desk.read("ids.png") != expected, "{technique}");
    }
}

#[test]
fn a_coarser_boundary_spares_every_backend_vertices() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    let corner = |i: u32| {
        let angle = (f64::from(i) / 20.0).to_radians();
        [5.0 * angle.cos(), 5.0 * angle.sin()]
    };
    // So many that a scene has levels without asking for them.
    let ring: Vec<[f64; 2]> = (0..7_200).map(corner).collect();
    desk.write_scene("squares", &collection(&[("disc", polygon(&ring))]));
    let drawn = |backend: &str, switches: &[&str]| {
        let outputs = [
            "--technique",
            backend,
            "--ids",
            "ids.png",
            "--stats",
            "s.json",
        ];
        render(&desk, &[&outputs, switches].concat());
        let vertices = statistics(&desk)["counters"]["vertices"].as_u64();
        (vertices.expect("a count"), ids(&desk))
    };
    for backend in &exact_techniques() {
        let (full, expected) = drawn(backend, &["--set", "boundary-lod-px=off"]);
        let (coarse, found) = drawn(backend, &["--set", "boundary-lod-px=0.5"]);
        assert!(2 * coarse < full, "{backend}: {coarse} of {full}");
        let filled = expected.iter().filter(|id| **id > 0).count();
        let mismatches = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        // A disc of 10 pixels' radius has a rim of 65, which has moved by half of one at most.
        assert!(filled > 300 && mismatches <= 33, "{mismatches} of {filled}");
        // Negative control: where a thousandth of a pixel counts nothing is spared.
        let (fine, found) = drawn(backend, &["--set", "boundary-lod-px=0.001"]);
        assert_eq!((fine, found), (full, expected), "{backend}");
    }
}

#[test]
fn switches_of_another_backend_are_refused_with_the_backends_own() {
    let desk = Desk::new();
    write_squares(&desk);
    let before = desk.names();
    let compute = "expansion, gpu-culling, ";
    let native = "technique, ";
    for (backend, wrong, allowed) in [
        ("compute", "layout=pulled", compute),
        ("compute", "technique=gs-line", compute),
        ("compute", "expansion=once", "expansion=per-frame, cached"),
        ("compute", "expansion", "expansion=per-frame, cached"),
        (
            "compute",
            "gpu-culling=all",
            "gpu-culling=off, regions, triangles",
        ),
        ("compute", "transform=cpu", "transform=vertex, compute"),
        ("native", "layout=pulled", native),
        ("native", "expansion=cached", native),
        (
            "native",
            "technique=gs",
            "technique=vs-control, gs-degenerate",
        ),
        ("native", "indices=fan", "indices=list, strip"),
        ("native", "depth-copy=maybe", "depth-copy=none, made"),
        ("native", "faces=three", "faces=two-sided, two-pass"),
        ("vertex", "technique=gs-line", "layout, "),
        ("vertex", "expansion=cached", "layout, "),
    ] {
        let more = ["--technique", backend, "--set", wrong];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&[&format!("--set: found {wrong:?}, allowed: {allowed}")]]);
    }
    // Every list is longer than what is shown of it, and says what shows all.
    for backend in &techniques() {
        let more = ["--technique", backend, "--set", "speed=fast"];
        desk.run(&[&SCENE[..], &more].concat())
            .refused(&[&[" more (all: --list-switches)"]]);
    }
    let more = [
        "--technique",
        "compute",
        "--set",
        "expansion=cached",
        "--set",
        "gpu-culling=triangles",
    ];
    desk.run(&[&SCENE[..], &more].concat())
        .refused(&[&["--set: gpu-culling: found triangles"]]);
    let more = [
        "--technique",
        "native",
        "--set",
        "technique=gs-line",
        "--set",
        "indices=strip",
    ];
    desk.run(&[&SCENE[..], &more].concat())
        .refused(&[&["--set: indices: found strip with technique=gs-line"]]);
    // What has no ablation has no full plan.
    let more = ["--technique", "flat-mesh", "--set", "full-plan"];
    desk.run(&[&SCENE[..], &more].concat())
        .refused(&[&["--set: found \"full-plan\", allowed: "]]);
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
    render(&desk, &["--technique", "reference"]);
    assert!(image::open(desk.path("a.png")).is_ok());
    assert_eq!(desk.names(), ["a.png", "data", "squares.toml"]);
}

#[test]
fn the_old_names_of_options_mean_the_same() {
    let desk = Desk::new();
    let draw = |out: &str, technique: &str, set: &str| {
        let scene = ["render", "california", "--view", "top-down", "--size", "32"];
        let more = [technique, "reference", set, "texture=on", "--out", out];
        desk.run(&[&scene[..], &more].concat()).succeeded();
    };
    draw("new.png", "--technique", "--set");
    draw("old.png", "--backend", "--variant");
    assert_eq!(desk.read("new.png"), desk.read("old.png"));
}

#[test]
fn pictures_are_png_or_refused() {
    let desk = Desk::new();
    write_squares(&desk);
    let scene = [
        "render",
        "squares.toml",
        "--view",
        "above",
        "--data",
        "data",
    ];
    let draw = |more: &[&str]| {
        let fixed = ["--technique", "reference", "--size", "16"];
        desk.run(&[&scene[..], &fixed, more].concat())
    };
    for (more, line) in [
        (&["--out", "a.jpg"][..], "a.jpg: found .jpg, allowed: .png"),
        (&["--out", "a"], "a: found no extension, allowed: .png"),
        (
            &["--out", "a.png", "--ids", "ids.tiff"],
            "ids.tiff: found .tiff, allowed: .png",
        ),
    ] {
        draw(more).refused(&[&[line]]);
    }
    assert_eq!(desk.names(), ["data", "squares.toml"]);
    // Negative control.
    draw(&["--out", "A.PNG"]).succeeded();
    assert!(desk.read("A.PNG").starts_with(b"\x89PNG"));
    // Standard output takes one picture, and no file stays behind.
    let fixed = ["--technique", "reference", "--size", "16", "--out", "-"];
    let piped = Command::new(env!("CARGO_BIN_EXE_terrafill"))
        .args([&scene[..], &fixed].concat())
        .current_dir(desk.path(""))
        .output()
        .expect("starts");
    assert_eq!(piped.stdout, desk.read("A.PNG"));
    assert_eq!(desk.names(), ["A.PNG", "data", "squares.toml"]);
    draw(&["--out", "-", "--ids", "-"]).refused(&[&["two outputs have this path"]]);
}

#[test]
fn every_switch_is_listed_with_its_values_and_needs_no_scene() {
    let desk = Desk::new();
    write_squares(&desk);
    let text = desk.run(&["render", "--list-switches"]).succeeded();
    assert_eq!(desk.run(&["techniques"]).succeeded(), text);
    let json = desk.run(&["techniques", "--json"]).succeeded();
    let json: Value = serde_json::from_str(&json).expect("JSON");
    for technique in json["techniques"].as_array().expect("a list") {
        let name = technique["name"].as_str().expect("a name");
        let api = technique["api"].as_str().expect("a name");
        let more = if technique["approximate"] == true {
            ", approximate"
        } else {
            ""
        };
        assert!(text.contains(&format!("{name} ({api}{more})\n")), "{text}");
        // Each switch in the list is one that `render` knows; those of all are looked at once.
        for switch in technique["switches"].as_array().expect("a list") {
            let key = switch["key"].as_str().expect("a key");
            assert!(text.contains(&format!("    {key} ")), "{key}: {text}");
            if switch["own"] == true || name == "vertex" {
                let more = ["--technique", name, "--set", &format!("{key}=")];
                let allowed = format!("allowed: {key}=");
                desk.run(&[&SCENE[..], &more].concat())
                    .refused(&[&[&allowed]]);
            }
        }
    }
    // Beside any argument, and nothing is drawn.
    let beside = [&SCENE[..], &["--list-switches", "--technique", "native"]].concat();
    assert_eq!(desk.run(&beside).succeeded(), text);
    assert!(!desk.path("a.png").exists());
    // Negative control: without it both are asked for.
    let ran = desk.run(&["render", "california", "--view", "globe"]);
    assert!(ran.stderr.contains("--out"), "{}", ran.stderr);
}

#[test]
fn the_only_view_needs_no_name_and_several_are_named() {
    let desk = Desk::new();
    write_squares(&desk);
    let fixed = ["--technique", "reference", "--size", "16", "--out", "a.png"];
    let render = |scene: &[&str]| desk.run(&[&["render"][..], scene, &fixed].concat());
    let only = render(&["squares.toml", "--data", "data"]).succeeded();
    assert!(is_written(&only, "a.png"), "{only}");
    let unnamed = desk.read("a.png");
    render(&["squares.toml", "--data", "data", "--view", "above"]).succeeded();
    assert_eq!(desk.read("a.png"), unnamed);
    render(&["california"]).refused(&[&["--view: found none, allowed: globe, top-down, horizon"]]);
    // Negative control: a name that the only view has not.
    render(&["squares.toml", "--data", "data", "--view", "below"])
        .refused(&[&["--view: found \"below\", allowed: above"]]);
}

#[test]
fn scenes_in_folders_are_drawn_by_their_names() {
    let desk = Desk::new();
    let draw = |scene: &str, out: &str| {
        let fixed = [
            "--view",
            "over-north",
            "--technique",
            "reference",
            "--size",
            "32",
        ];
        let ran = desk.run(&[&["render", scene, "--out", out][..], &fixed].concat());
        ran.succeeded();
        desk.read(out)
    };
    let file = include_str!("../../../../../bench-scenes/extreme/poles.toml");
    desk.write("poles.toml", file);
    assert_eq!(
        draw("extreme/poles", "named.png"),
        draw("./poles.toml", "path.png")
    );
    // One that needs data says which, and is not taken for a path. Negative control: what is neither.
    let render =
        |scene: &'static str| desk.run(&["render", scene, "--view", "v", "--out", "a.png"]);
    render("terrain/everest").refused(&[&["needs vectors/ne_50m_admin_0_countries.geojson"]]);
    render("./extreme/poles").refused(&[&["\"./extreme/poles\" is not shipped"]]);
}

#[test]
fn what_was_written_is_said_where_no_output_is_read() {
    let desk = Desk::new();
    write_squares(&desk);
    let reference = [&SCENE[..], &["--technique", "reference"]].concat();
    let ran = desk.run(&[&reference[..], &["--stats", "-"]].concat());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    // Negative control: figures alone are on standard output.
    let figures: Result<Value, _> = serde_json::from_str(&ran.stdout);
    assert!(figures.is_ok(), "{}", ran.stdout);
    assert!(is_written(&ran.stderr, "a.png"), "{}", ran.stderr);
}

#[test]
fn a_picture_is_checked_and_a_wrong_one_ends_with_1() {
    let desk = Desk::new();
    write_squares(&desk);
    let reference = ["--technique", "reference", "--check"];
    desk.run(&[&SCENE[..], &reference].concat())
        .refused(&[&["--check: found --technique reference"]]);
    assert!(!desk.path("a.png").exists());
    if !has_device() {
        return;
    }
    let differing = |text: &str| {
        let line = text.lines().nth(1).unwrap_or_default();
        let px = line.strip_suffix(" px differ from the reference");
        px.and_then(|px| px.parse::<u32>().ok())
    };
    let text = desk.run(&[&SCENE[..], &["--check"]].concat()).succeeded();
    assert!(differing(&text).is_some_and(|px| px <= 20), "{text}");
    // Negative controls: regions overlap where the scene says that none do, which XOR colouring relies on. What is
    // approximate by nature may differ.
    let overlapping = collection(&[
        ("below", polygon(&rectangle(-8.0, -8.0, 4.0, 8.0))),
        ("above", polygon(&rectangle(-4.0, -8.0, 8.0, 8.0))),
    ]);
    desk.write_scene("squares", &overlapping);
    let wrong = desk.run(&[&SCENE[..], &["--check"]].concat());
    assert_eq!(wrong.code, 1, "{}{}", wrong.stdout, wrong.stderr);
    assert!(differing(&wrong.stdout) > Some(20), "{}", wrong.stdout);
    let words = " mismatched pixels outside the boundary band, allowed 0";
    assert!(wrong.stderr.contains(words), "{}", wrong.stderr);
    let flat = ["--check", "--technique", "flat-mesh"];
    let flat = desk.run(&[&SCENE[..], &flat].concat()).succeeded();
    assert!(differing(&flat).is_some(), "{flat}");
}

/// Draws a file so that its regions fill a picture, colour and ids.
fn fit(desk: &Desk, file: &str, size: &str) -> Ran {
    let line = ["render", file, "--fit", "--technique", "reference"];
    let outputs = ["--size", size, "--out", "a.png", "--ids", "ids.png"];
    desk.run(&[&line[..], &outputs].concat())
}

/// Ids of a fitted picture, 96 × 64; long edges are warned of.
fn fitted(desk: &Desk, file: &str) -> Vec<u16> {
    let ran = fit(desk, file, "96x64");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(is_written(&ran.stdout, "a.png"), "{}", ran.stdout);
    ids(desk)
}

/// Columns and rows between which pixels of a region lie.
fn bounds(ids: &[u16]) -> [usize; 4] {
    let filled = || (0..ids.len()).filter(|&i| ids[i] > 0);
    let columns = || filled().map(|i| i % 96);
    let rows = || filled().map(|i| i / 96);
    let bounds = [columns().min(), columns().max(), rows().min(), rows().max()];
    bounds.map(|bound| bound.expect("something to see"))
}

#[test]
fn a_file_of_regions_is_drawn_as_large_as_fits() {
    let desk = Desk::new();
    let square = |name: &str, half: f64, longitude: f64, latitude: f64| {
        let [west, east] = [longitude - half, longitude + half];
        let ring = rectangle(west, latitude - half, east, latitude + half);
        desk.write(name, polygon(&ring));
    };
    square("town.geojson", 0.01, 13.4, 52.5);
    square("country.geojson", 3.0, -100.0, 40.0);
    square("beyond.geojson", 4.0, 180.0, -10.0);
    desk.write(
        "cap.geojson",
        polygon(&rectangle(-180.0, 70.0, 180.0, 90.0)),
    );
    for file in [
        "town.geojson",
        "country.geojson",
        "beyond.geojson",
        "cap.geojson",
    ] {
        let [west, east, north, south] = bounds(&fitted(&desk, file));
        // Nothing touches the edge, and the larger of the two ways takes nine tenths of it.
        assert!(west > 0 && east < 95 && north > 0 && south < 63, "{file}");
        let filled = (south - north + 1).max((east - west + 1) * 64 / 96);
        assert!((50..=62).contains(&filled), "{file}: {filled} of 64");
    }
    // What is wider than a hemisphere is drawn from as far as one sees.
    desk.write(
        "wide.geojson",
        polygon(&rectangle(-170.0, -10.0, 170.0, 10.0)),
    );
    let [west, east, ..] = bounds(&fitted(&desk, "wide.geojson"));
    assert!((50..=62).contains(&(east - west + 1)), "{west} … {east}");
    desk.write("tie.geojson", polygon(&crate::harness::BOW_TIE));
    let ran = fit(&desk, "tie.geojson", "16");
    // What was filled, and the area before and after.
    assert_eq!(
        (ran.code, ran.stderr.lines().count()),
        (0, 2),
        "{}",
        ran.stderr
    );
    assert!(ran.stderr.starts_with("repaired: feature 0: 1 crossing"));
    // A jump is read the shorter way, which is said; a band that no eye sees whole is seen from its side.
    let jump = [[171.0, 14.0], [-171.0, 14.0], [-171.0, 15.0], [171.0, 15.0]];
    desk.write("jump.geojson", polygon(&jump));
    let [west, east, ..] = bounds(&fitted(&desk, "jump.geojson"));
    assert!(west > 0 && east < 95 && east - west > 40, "{west} … {east}");
    let band = rectangle(-171.0, 14.0, 171.0, 15.0);
    desk.write("band.geojson", polygon(&band));
    let [west, east, ..] = bounds(&fitted(&desk, "band.geojson"));
    assert!(east - west > 40, "{west} … {east}");
    for (file, words) in [
        ("jump.geojson", "read the shorter way"),
        ("band.geojson", "2 edges span more than 180° of longitude"),
    ] {
        let ran = fit(&desk, file, "32");
        let is_said = ran.stderr.contains(words);
        assert!(ran.code == 0 && is_said, "{}", ran.stderr);
    }
    // Negative control: what covers the middle of no pixel is refused, not drawn empty.
    let hair = [[0.0, 0.0], [40.0, 40.0], [40.0, 40.000_001]];
    desk.write("hair.geojson", polygon(&hair));
    std::fs::remove_file(desk.path("a.png")).expect("drawn before");
    let ran = fit(&desk, "hair.geojson", "8");
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(
        ran.stderr.contains("found no pixel of 8 × 8"),
        "{}",
        ran.stderr
    );
    assert!(!desk.path("a.png").exists());
    // Negative controls: what is no region cannot be fitted, and a view is none of a file's.
    desk.write(
        "none.geojson",
        r#"{"type":"FeatureCollection","features":[]}"#,
    );
    let ran = desk.run(&["render", "none.geojson", "--fit", "--out", "b.png"]);
    assert_eq!(ran.code, 2);
    assert!(ran.stderr.contains("found no regions"), "{}", ran.stderr);
    desk.run(&["render", "no-file.geojson", "--fit", "--out", "b.png"])
        .refused(&[&["no-file.geojson: no such file"]]);
    let ran = desk.run(&[
        "render",
        "tie.geojson",
        "--fit",
        "--view",
        "a",
        "--out",
        "b.png",
    ]);
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(!desk.path("b.png").exists());
}

#[test]
fn every_technique_draws_a_fitted_file_as_the_reference_does() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    desk.write(
        "r.geojson",
        collection(&[
            ("below", polygon(&rectangle(0.0, 40.0, 10.0, 50.0))),
            ("above", polygon(&rectangle(5.0, 45.0, 20.0, 46.0))),
        ]),
    );
    let expected = fitted(&desk, "r.geojson");
    for technique in exact_techniques() {
        let fit = ["render", "r.geojson", "--fit", "--technique", &technique];
        let outputs = ["--size", "96x64", "--out", "a.png", "--ids", "ids.png"];
        desk.run(&[&fit[..], &outputs].concat()).succeeded();
        let pairs = ids(&desk).into_iter().zip(expected.iter().copied());
        let mismatches = pairs.filter(|(found, expected)| found != expected).count();
        assert!(mismatches <= 20, "{technique}: {mismatches} pixels");
    }
}

#[test]
fn a_case_of_a_study_is_drawn_judged_and_named() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let render = |arguments: &[&str]| {
        let size = ["--size", "96", "--check", "--out", "a.png"];
        desk.run(&[&["render"], arguments, &size[..]].concat())
    };
    let drawn = render(&["decals/campus", "--view", "nadir"]);
    assert_eq!(drawn.code, 0, "{}", drawn.stderr);
    assert!(drawn.stderr.contains("view=nadir"), "{}", drawn.stderr);
    let picture = image::open(desk.path("a.png")).expect("a picture");
    assert_eq!((picture.width(), picture.height()), (96, 96));
    // Negative controls: what no case has, and what only scenes have.
    for (arguments, complaint) in [
        (
            ["decals/campos", "--view", "nadir"],
            "did you mean \"campus\"?",
        ),
        (["decals/campus", "--view", "cellar"], "nadir"),
        (
            ["decals/campus", "--picture", "pictur"],
            "did you mean \"picture\"?",
        ),
        (
            ["decals/campus", "--technique", "vertex"],
            "allowed: with a scene",
        ),
    ] {
        let refused = render(&arguments);
        assert_eq!(refused.code, 2, "{}", refused.stderr);
        assert!(refused.stderr.contains(complaint), "{}", refused.stderr);
    }
}
