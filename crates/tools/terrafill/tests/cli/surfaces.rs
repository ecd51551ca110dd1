// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills over terrain, by every backend, held against the reference over the same one; wrong surfaces.

use crate::harness::{
    Desk, a_device, collection, exact_techniques, has_device, polygon, rectangle,
};
use image::DynamicImage;
use terrafill_conformance::{compare, verdict};
use terrafill_contract::Frame;
use terrafill_scene::ImageSize;

const SIZE: ImageSize = ImageSize::new(256, 256);

/// What a backend fills.
fn drawn(desk: &Desk, scene: &str, view: &str, backend: &str) -> Frame {
    let render = ["render", scene, "--view", view, "--technique", backend];
    let out = ["--size", "256", "--out", "a.png", "--ids", "ids.png"];
    desk.run(&[&render[..], &out].concat()).succeeded();
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
    if verdict.is_pass() {
        Ok(())
    } else {
        Err(format!("{verdict:?} {figures:?}"))
    }
}

#[test]
fn every_backend_renders_the_shipped_hills_rightly() {
    if !has_device() || !a_device("native     runs, with geometry shaders") {
        return;
    }
    let desk = Desk::new();
    let reference = drawn(&desk, "hills", "horizon", "reference");
    let filled = reference.filled_px();
    assert!(filled > 1000 && filled < reference.ids.len() as u64 - 1000);
    for backend in &exact_techniques() {
        let frame = drawn(&desk, "hills", "horizon", backend);
        is_right(&reference, &frame).unwrap_or_else(|why| panic!("{backend}: {why}"));
    }
    // Negative control: another view is wrong.
    let other = drawn(&desk, "hills", "globe", "vertex");
    is_right(&reference, &other).expect_err("of another view");
}

/// On a ridge of 1,090 m.
const TERRAIN: &str = "[surface]\nkind = \"grid\"\nrows = 240\nseed = 2007\namplitude_m = 9_000\n\
    [[views]]\nname = \"ridge\"\nlongitude_deg = 10\nlatitude_deg = 10\nheight_m = 1120\n\
    heading_deg = 60\npitch_deg = -3\n";

#[test]
fn what_is_wrong_with_a_surface_is_bad_input() {
    let desk = Desk::new();
    let square = polygon(&rectangle(9.9, 9.9, 10.05, 10.05));
    desk.write_scene("terrain", &collection(&[("here", square)]));
    let bare = desk.read_text("terrain.toml");
    let (head, _) = bare.split_once("[surface]").expect("a surface");
    let right = [head, TERRAIN].concat();
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
