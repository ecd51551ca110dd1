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

/// Draws a study, or not where there is no device.
fn drawn(study: &str, more: &[&str]) -> Option<Desk> {
    let desk = Desk::new();
    if !has_device() {
        return None;
    }
    desk.write(
        "hut.obj",
        include_str!("../../../../../bench-scenes/hut.obj"),
    );
    let size = SIDE.to_string();
    let options = ["bench", "--study", study, "--quick", "--samples", "1"];
    let to = ["--size", &size, "--out", "run"];
    let ran = desk.run(&[&options[..], &to, more].concat());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let line = "a quick run takes one process and decides nothing\n";
    assert!(ran.stdout.starts_with(line), "{}", ran.stdout);
    assert!(ran.stdout.contains(" 0 wrong, 0 failed"), "{}", ran.stdout);
    let (of_run, wrong) = pictures(&desk, "run");
    assert!(of_run > 0, "{study}: no picture of {SIDE} pixels");
    assert!(wrong.is_empty(), "{wrong:?}");
    Some(desk)
}

#[test]
fn balls_are_drawn_at_the_size_that_is_named() {
    let Some(desk) = drawn("balls", &[]) else {
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
fn moving_regions_are_drawn_at_the_size_that_is_named() {
    drawn("moving", &[]);
}

#[test]
fn pipelines_are_drawn_at_the_size_that_is_named() {
    drawn("pipelines", &[]);
}

#[test]
fn shadows_are_drawn_at_the_size_that_is_named() {
    drawn("shadows", &["--casters", "hut.obj,up=z"]);
}
