// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures in a run's folder have the size that `--size` names, or the one that their case names.

use crate::harness::{Desk, has_device};
use terrafill_results::Run;

/// Pixels a side: no study's own size.
const SIDE: u32 = 96;

/// Pictures of the run's size, and lines of those that have another one than the run or their case names.
fn pictures(desk: &Desk, folder: &str) -> (usize, Vec<String>) {
    let run = Run::load(&desk.path(folder)).expect("a run");
    let (mut of_run, mut wrong) = (0, Vec::new());
    for case in &run.cases {
        let notes = case.notes().iter();
        for (_, path) in notes.filter(|(_, text)| text.ends_with(".png")) {
            let file = desk.path(folder).join(path);
            let (width, height) = image::image_dimensions(file).expect("a picture");
            let found = if width == height {
                width.to_string()
            } else {
                format!("{width}x{height}")
            };
            let named = match case.condition("size_px") {
                "" => SIDE.to_string(),
                named => named.to_owned(),
            };
            of_run += usize::from((width, height) == (SIDE, SIDE));
            if found != named {
                wrong.push(format!("{}: {path}: {found}, not {named}", case.id()));
            }
        }
    }
    (of_run, wrong)
}

/// The scene that flights go over, with fewer islands and tiles and one view, at which the eye rests: so much as
/// leaves a test its time.
fn islands() -> String {
    let hills = include_str!("../../../../../bench-scenes/hills.toml");
    let tiles = "kind = \"tiles\"\nbase = \"relief\"\nmax_triangles = 40_000\n";
    let few = hills.replace("kind = \"grid\"\nrows = 240\n", tiles);
    assert_ne!(few, hills);
    let (one_view, _) = few
        .split_once("\n[[views]]\nname = \"top-down\"")
        .expect("views");
    one_view.replace("count = 134", "count = 20")
}

/// Draws a study, or not where there is no device. Each case is drawn, verified and kept; none is drawn again to be
/// timed.
///
/// - `more`: what else is asked for, such as the shard of the groups that keep pictures
fn drawn(study: &str, more: &[&str]) -> Option<Desk> {
    let desk = Desk::new();
    if !has_device() {
        return None;
    }
    desk.write(
        "hut.obj",
        include_str!("../../../../../bench-scenes/hut.obj"),
    );
    desk.write("islands.toml", islands());
    desk.write("no-case.txt", "");
    let size = SIDE.to_string();
    let options = [
        "bench",
        "--study",
        study,
        "--quick",
        "--time-only",
        "no-case.txt",
    ];
    let to = ["--size", &size, "--out", "run"];
    let ran = desk.run(&[&options[..], &to, more].concat());
    // Not 0: no time was measured.
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    let line = "a quick run takes one process and decides nothing\n";
    assert!(ran.stdout.starts_with(line), "{}", ran.stdout);
    assert!(ran.stdout.contains(" 0 wrong, 0 failed"), "{}", ran.stdout);
    let run = Run::load(&desk.path("run")).expect("a run");
    let unverified = run.cases.iter().filter(|case| case.status().is_none());
    assert_eq!(unverified.count(), 0, "{study}");
    let (of_run, wrong) = pictures(&desk, "run");
    assert!(of_run > 0, "{study}: no picture of {SIDE} pixels");
    assert!(wrong.is_empty(), "{wrong:?}");
    Some(desk)
}

#[test]
fn balls_are_drawn_at_the_size_that_is_named() {
    let Some(desk) = drawn("balls", &["--shard", "4/4"]) else {
        return;
    };
    // Negative control: another picture in the place of one is noticed.
    let run = Run::load(&desk.path("run")).expect("a run");
    let mut notes = run.cases.iter().flat_map(|case| case.notes().values());
    let path = notes.find(|text| text.ends_with(".png")).expect("one");
    let other = image::GrayImage::new(SIDE, SIDE - 1);
    other.save(desk.path("run").join(path)).expect("written");
    let (_, wrong) = pictures(&desk, "run");
    assert_eq!(wrong.len(), 1, "{wrong:?}");
    assert!(wrong[0].contains("96x95, not 96"), "{wrong:?}");
}

#[test]
fn flights_are_drawn_at_the_size_that_is_named() {
    drawn("flight", &["islands.toml"]);
}

#[test]
fn moving_regions_are_drawn_at_the_size_that_is_named() {
    // One technique of each interface.
    drawn(
        "moving",
        &["--technique", "vertex", "--technique", "native"],
    );
}

#[test]
fn pipelines_are_drawn_at_the_size_that_is_named() {
    // Grids and shaded maps, whose cases name other sizes; then culling and lights.
    for shard in ["1/8", "4/4"] {
        drawn("pipelines", &["--shard", shard]);
    }
}

#[test]
fn shadows_are_drawn_at_the_size_that_is_named() {
    drawn("shadows", &["--casters", "hut.obj,up=z"]);
}
