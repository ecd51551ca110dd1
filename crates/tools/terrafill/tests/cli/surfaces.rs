// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills over every kind of surface, by every backend, held against the reference over the same one.

use crate::harness::{
    Desk, a_device, collection, exact_techniques, has_device, polygon, rectangle,
};
use image::DynamicImage;
use std::collections::BTreeMap;
use terrafill_conformance::{compare, verdict};
use terrafill_fill::Frame;
use terrafill_scene::ImageSize;

const SIZE: ImageSize = ImageSize {
    width: 256,
    height: 256,
};

/// `[surface]` of scenes over terrain, as in `hills`.
const TERRAIN: &str = "kind = \"grid\"\nrows = 240\nseed = 2007\namplitude_m = 9_000\n";
/// The same terrain in tiles, coarse enough for skirts to be seen.
const TILES: &str =
    "kind = \"tiles\"\nerror_px = 8\nbase = \"relief\"\nseed = 2007\namplitude_m = 9_000\n";
const BARE: &str = "kind = \"ellipsoid\"\nrows = 240\n";

/// Name, longitude, latitude, height, heading and pitch. The terrain at (10°, 10°) is 1,090 m high.
const VIEWS: [(&str, [f64; 5]); 7] = [
    ("orbit", [10.0, 10.0, 3e6, 0.0, -90.0]),
    ("oblique", [10.0, 9.5, 9e3, 20.0, -20.0]),
    ("ridge", [10.0, 10.0, 1_120.0, 60.0, -3.0]),
    ("ridge-back", [10.0, 10.0, 1_120.0, 300.0, -3.0]),
    ("antimeridian", [178.0, 3.0, 3e6, 0.0, -90.0]),
    ("antimeridian-low", [-179.0, -10.5, 2e4, 350.0, -10.0]),
    ("pole", [20.0, 89.0, 4e6, 0.0, -90.0]),
];

/// Those in which tiles are looked at: they take their time in a build without optimisation.
const TILES_VIEWS: [&str; 3] = ["orbit", "ridge", "pole"];

/// Regions round a ridge, behind the horizon, across ±180° and over a pole.
fn write_scenes(desk: &Desk) {
    let regions = [
        ("here", rectangle(9.9, 9.9, 10.05, 10.05)),
        ("beside", rectangle(10.05, 9.9, 10.3, 10.1)),
        ("across", rectangle(9.0, 10.2, 9.8, 11.0)),
        ("beyond", rectangle(11.0, 8.0, 16.0, 14.0)),
        ("hidden", rectangle(20.0, 5.0, 30.0, 15.0)),
        ("strip", rectangle(170.0, -10.0, 190.0, 10.0)),
        ("cap", rectangle(-180.0, 80.0, 180.0, 90.0)),
    ];
    let features = regions.map(|(name, ring)| (name, polygon(&ring)));
    desk.write_scene("terrain", &collection(&features));
    let text = desk.read_text("terrain.toml");
    let (head, _) = text.split_once("[surface]").expect("a surface");
    for (name, surface) in [("terrain", TERRAIN), ("tiles", TILES), ("bare", BARE)] {
        let views = VIEWS.map(|(view, [longitude, latitude, height, heading, pitch])| {
            format!(
                "[[views]]\nname = \"{view}\"\nlongitude_deg = {longitude}\nlatitude_deg = {latitude}\n\
                 height_m = {height}\nheading_deg = {heading}\npitch_deg = {pitch}\n\
                 near_m = {}\n",
                height * 5e-4
            )
        });
        desk.write(
            &format!("{name}.toml"),
            format!("{head}[surface]\n{surface}{}", views.concat()),
        );
    }
}

/// What a backend fills.
fn drawn(desk: &Desk, scene: &str, view: &str, backend: &str, more: &[&str]) -> Frame {
    let arguments = [
        "render",
        scene,
        "--view",
        view,
        "--technique",
        backend,
        "--size",
        "256",
        "--out",
        "a.png",
        "--ids",
        "ids.png",
    ];
    let data: &[&str] = match more.contains(&"--data") {
        true => &[],
        false => &["--data", "data"],
    };
    desk.run(&[&arguments[..], data, more].concat()).succeeded();
    let DynamicImage::ImageLuma16(ids) = image::open(desk.path("ids.png")).expect("a picture")
    else {
        panic!("ids are 16-bit grey");
    };
    let ids: Vec<u32> = ids.into_raw().into_iter().map(u32::from).collect();
    Frame {
        size: SIZE,
        surface: vec![true; ids.len()],
        ids,
        non_finite: 0,
        counters: None,
        texture: None,
    }
}

fn is_right(reference: &Frame, frame: &Frame) -> Result<(), String> {
    let figures = compare(reference, frame).expect("same size");
    let verdict = verdict(&figures);
    match verdict.is_pass() {
        true => Ok(()),
        false => Err(format!("{verdict:?} {figures:?}")),
    }
}

/// The reference over each surface by scene and view.
fn references(desk: &Desk, scenes: &[&str]) -> BTreeMap<(String, &'static str), Frame> {
    let mut found = BTreeMap::new();
    for scene in scenes {
        let views = VIEWS
            .iter()
            .filter(|(view, _)| *scene != "tiles.toml" || TILES_VIEWS.contains(view));
        for &(view, _) in views {
            let frame = drawn(desk, scene, view, "reference", &[]);
            assert!(frame.filled_px() > 100, "{scene}/{view}: nothing to see");
            found.insert(((*scene).to_owned(), view), frame);
        }
    }
    found
}

#[test]
fn every_backend_fills_rightly_over_terrain_and_over_the_bare_body() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    write_scenes(&desk);
    let references = references(&desk, &["terrain.toml", "tiles.toml", "bare.toml"]);
    let techniques = exact_techniques();
    let mut over_the_other = 0;
    for ((scene, view), reference) in &references {
        for backend in &techniques {
            let frame = drawn(&desk, scene, view, backend, &[]);
            is_right(reference, &frame)
                .unwrap_or_else(|why| panic!("{scene}/{view}, {backend}: {why}"));
            if scene != "bare.toml" {
                // Twin: over the bare body the same regions cover other pixels.
                let bare = &references[&("bare.toml".to_owned(), *view)];
                over_the_other += usize::from(is_right(bare, &frame).is_err());
            }
        }
    }
    // From straight above, terrain moves what it carries by less than a pixel.
    assert!(over_the_other >= 5 * techniques.len(), "{over_the_other}");
}

#[test]
fn every_backend_fills_the_shipped_hills_rightly() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    for view in ["globe", "top-down", "horizon"] {
        let reference = drawn(&desk, "hills", view, "reference", &[]);
        let filled = reference.filled_px();
        assert!(filled > 1000 && filled < reference.ids.len() as u64 - 1000);
        for backend in &exact_techniques() {
            let frame = drawn(&desk, "hills", view, backend, &[]);
            is_right(&reference, &frame).unwrap_or_else(|why| panic!("{view}, {backend}: {why}"));
        }
    }
}

fn repository() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// Scenes over real elevation, each with a view from nearby and one from afar in which regions have an edge.
const REAL: [(&str, [&str; 2]); 4] = [
    ("san-francisco", ["street", "hundred-kilometres"]),
    ("everest", ["valley", "orbit"]),
    ("grand-canyon", ["rim", "orbit"]),
    ("countries-over-etopo", ["globe", "himalaya"]),
];

#[test]
fn every_backend_fills_rightly_over_real_elevation() {
    let Some(data) = std::env::var_os("TERRAFILL_DATA") else {
        return;
    };
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    let data = data.to_string_lossy().into_owned();
    let scenes = repository().join("bench-scenes/terrain");
    for (name, views) in REAL {
        let path = scenes.join(format!("{name}.toml")).display().to_string();
        for view in views {
            let more = ["--data", data.as_str()];
            let reference = drawn(&desk, &path, view, "reference", &more);
            let filled = reference.filled_px();
            assert!(filled > 0, "{name}/{view}: nothing to see");
            for backend in &exact_techniques() {
                let frame = drawn(&desk, &path, view, backend, &more);
                is_right(&reference, &frame)
                    .unwrap_or_else(|why| panic!("{name}/{view}, {backend}: {why}"));
            }
        }
    }
}

#[test]
fn culling_changes_no_pixel_over_terrain() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    write_scenes(&desk);
    let everything = [
        "--set",
        "horizon-culling=off",
        "--set",
        "frustum-culling=off",
        "--set",
        "too-small-culling=off",
    ];
    let shipped = ["globe", "top-down", "horizon"].map(|view| ("hills", view));
    let own = VIEWS.map(|(view, _)| ("terrain.toml", view));
    for (scene, view) in shipped.into_iter().chain(own) {
        let culled = drawn(&desk, scene, view, "vertex", &[]);
        let whole = drawn(&desk, scene, view, "vertex", &everything);
        assert_eq!(culled.ids, whole.ids, "{scene}/{view}");
    }
}

#[test]
fn what_is_wrong_with_a_surface_is_bad_input() {
    let desk = Desk::new();
    write_scenes(&desk);
    let right = desk.read_text("terrain.toml");
    for (from, to, phrases) in [
        (
            "kind = \"grid\"",
            "kind = \"plane\"",
            "found \"plane\", allowed: ellipsoid, grid, tiles",
        ),
        (
            "amplitude_m = 9_000",
            "amplitude_m = 12_000",
            "surface.amplitude_m: found 12000, allowed: 0 to 11000",
        ),
        (
            "amplitude_m",
            "height_m",
            "surface.height_m: found 9000, allowed: only the keys kind, rows, vertical_exaggeration, feather, base, seed, amplitude_m",
        ),
        (
            "height_m = 1120",
            "height_m = 500",
            "the eye is 500.0 m above the ellipsoid, allowed: above the grid surface",
        ),
    ] {
        assert!(right.contains(from), "{from}");
        desk.write("wrong.toml", right.replacen(from, to, 1));
        let render = ["render", "wrong.toml", "--view", "ridge", "--data", "data"];
        let bench = ["bench", "wrong.toml", "--quick", "--data", "data"];
        for arguments in [&render[..], &bench[..]] {
            let ran = desk.run(&[arguments, &["--out", "out.png"]].concat());
            assert_eq!(ran.code, 2, "{}", ran.stderr);
            assert!(ran.stderr.contains("wrong.toml"), "{}", ran.stderr);
            assert!(ran.stderr.contains(phrases), "{}", ran.stderr);
        }
    }
}
