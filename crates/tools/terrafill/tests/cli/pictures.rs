// SPDX-License-Identifier: MIT OR Apache-2.0
//! `render --style map`: README's pictures and one of a scene that ships show sky, relief and regions.

use crate::harness::Desk;
use image::RgbImage;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use terrafill_fixtures::data;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn page(name: &str) -> String {
    std::fs::read_to_string(repository().join(name)).expect(name)
}

/// The lines of docs/using.md that make README's pictures, as arguments.
fn commands(using: &str) -> Vec<Vec<&str>> {
    let lines = using.lines();
    let lines = lines.filter_map(|line| line.strip_prefix("terrafill render "));
    lines
        .map(|line| line.split(' ').collect::<Vec<_>>())
        .filter(|words| words.contains(&"map"))
        .collect()
}

fn value<'a>(command: &[&'a str], option: &str) -> &'a str {
    let place = command.iter().position(|word| *word == option);
    command[place.unwrap_or_else(|| panic!("{option}: {command:?}")) + 1]
}

/// Draws scene and view in a small size: for people, and as it is judged.
fn drawn(scene: &str, view: &str, more: &[&str]) -> [RgbImage; 2] {
    let desk = Desk::new();
    let styles = [&["--style", "map"][..], &["--technique", "reference"]];
    styles.map(|style| {
        let scene = ["render", scene, "--view", view, "--size", "160x90"];
        let arguments = [&scene[..], &["--out", "a.png"], style, more].concat();
        desk.run(&arguments).succeeded();
        let picture = image::open(desk.path("a.png")).expect("a picture");
        picture.into_rgb8()
    })
}

/// Share of a picture that sky, ground and regions must have each, so that it shows them.
const MIN_SHARE: f64 = 0.03;
/// Colours of ground that has relief; without light there are as many as regions.
const MIN_COLOURS: usize = 100;
/// Least step across the horizon, of 255 in a channel: the median over the columns.
const MIN_STEP: u8 = 20;

/// What a picture does not show that one for people shows.
///
/// - `judged`: the same view as it is judged, whose colours say what each pixel shows
fn faults(picture: &RgbImage, judged: &RgbImage) -> Vec<&'static str> {
    // Without the corner that the inset covers.
    let reach = picture.height() * 2 / 5;
    let is_inset = |x: u32, y: u32| x + reach >= picture.width() && y < reach;
    let pixels = || {
        let all = picture.enumerate_pixels().zip(judged.pixels());
        let shown = all.filter(|((x, y, _), _)| !is_inset(*x, *y));
        shown.map(|((_, _, pixel), judged)| (pixel, judged))
    };
    let of = |is_it: fn([u8; 3]) -> bool| -> Vec<[u8; 3]> {
        let those = pixels().filter(|(_, judged)| is_it(judged.0));
        those.map(|(pixel, _)| pixel.0).collect()
    };
    let sky = of(|judged| judged == [5, 5, 10]);
    let ground = of(|judged| judged != [5, 5, 10]);
    let regions = of(|judged| ![[5, 5, 10], [92, 117, 148]].contains(&judged));
    let share = |of: &[[u8; 3]]| of.len() as f64 / pixels().count() as f64;
    let colours = |of: &[[u8; 3]]| of.iter().collect::<BTreeSet<_>>().len();
    let is_sky = |x: u32, y: u32| judged.get_pixel(x, y).0 == [5, 5, 10];
    let last = picture.height().saturating_sub(2);
    let places = (0..picture.width()).flat_map(|x| (0..last).map(move |y| (x, y)));
    let edge = places.filter(|&(x, y)| !is_inset(x, y) && is_sky(x, y) && !is_sky(x, y + 1));
    let steps = edge.filter_map(|(x, y)| {
        let [above, below] = [y, y + 2].map(|y| picture.get_pixel(x, y).0);
        above.iter().zip(below).map(|(a, b)| a.abs_diff(b)).max()
    });
    let mut steps: Vec<u8> = steps.collect();
    steps.sort_unstable();
    let step = steps.get(steps.len() / 2).copied().unwrap_or(0);
    let is_missing = [
        ("sky", share(&sky) < MIN_SHARE),
        ("ground", share(&ground) < MIN_SHARE),
        ("regions", share(&regions) < MIN_SHARE),
        ("relief", colours(&ground) < MIN_COLOURS),
        ("light in the sky", colours(&sky) < 10),
        ("a horizon", step < MIN_STEP),
    ];
    let missing = is_missing.into_iter().filter(|(_, missing)| *missing);
    missing.map(|(what, _)| what).collect()
}

#[test]
fn a_map_shows_sky_relief_and_regions_and_a_judged_picture_shows_no_relief() {
    let [map, judged] = drawn("hills", "globe", &[]);
    assert_eq!(faults(&map, &judged), [""; 0]);
    assert_eq!(faults(&judged, &judged), ["relief", "light in the sky"]);
    let mut grey = map.clone();
    grey.pixels_mut().for_each(|pixel| pixel.0 = [128; 3]);
    assert!(faults(&grey, &judged).contains(&"a horizon"));
    // A view of nothing but ground.
    let [map, judged] = drawn("hills", "top-down", &[]);
    assert!(faults(&map, &judged).contains(&"sky"));
}

#[test]
#[ignore = "needs data: all scenes"]
fn the_pictures_of_the_readme_show_sky_relief_and_regions() {
    let folder = data::folder();
    let folder = folder.to_str().expect("UTF-8");
    for command in commands(&page("docs/using.md")) {
        let view = value(&command, "--view");
        let [map, judged] = drawn(command[0], view, &["--data", folder]);
        assert_eq!(faults(&map, &judged), [""; 0], "{command:?}");
    }
}

#[test]
fn each_picture_of_terrain_in_the_readme_has_its_command() {
    let using = page("docs/using.md");
    let made: BTreeSet<&str> = commands(&using)
        .iter()
        .map(|command| value(command, "--out"))
        .collect();
    let readme = page("README.md");
    let shown = readme.split("](").filter_map(|rest| rest.split_once(')'));
    let shown = shown.map(|(path, _)| path);
    // Pictures of reports are cut out of pages.
    let shown = shown.filter(|path| path.ends_with(".jpg") && !path.contains("report"));
    assert_eq!(shown.collect::<BTreeSet<_>>(), made);
    assert!(made.len() >= 3, "{made:?}");
}

#[test]
fn the_judged_style_is_the_default_and_a_map_takes_no_technique() {
    let desk = Desk::new();
    let draw = |more: &[&str]| {
        let scene = ["render", "california", "--view", "horizon", "--size", "48"];
        desk.run(&[&scene[..], more].concat())
    };
    let reference = ["--technique", "reference", "--out", "a.png"];
    draw(&reference).succeeded();
    let judged = desk.read("a.png");
    draw(&[&reference[..], &["--style", "judged"]].concat()).succeeded();
    assert_eq!(desk.read("a.png"), judged);
    let said = draw(&["--style", "map", "--out", "a.png"]).succeeded();
    assert!(said.contains("\ninset: north up, "), "{said}");
    assert_ne!(desk.read("a.png"), judged);
    draw(&["--style", "map", "--out", "a.jpg"]).succeeded();
    assert_eq!(desk.read("a.jpg")[..3], [0xff, 0xd8, 0xff]);
    let with_technique = ["--style", "map", "--technique", "vertex", "--out", "b.png"];
    let judged_jpeg = ["--technique", "reference", "--out", "b.jpg"];
    let tiff = ["--style", "map", "--out", "b.tiff"];
    for (wrong, message) in [
        (&with_technique[..], "--style: found map"),
        (&judged_jpeg[..], "found .jpg, allowed: .png"),
        (&tiff[..], "allowed: .png, .jpg"),
    ] {
        let ran = draw(wrong);
        assert_eq!(ran.code, 2);
        assert!(ran.stderr.contains(message), "{}", ran.stderr);
    }
    assert!(!desk.names().iter().any(|name| name.starts_with('b')));
}
