// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files of one's own: from GeoJSON and heights to a report in one command.

use crate::harness::{BOW_TIE, Desk, QUICK, collection, has_device, polygon, rectangle};
use terrafill_results::Run;

/// Heights that ship: plateaux of 0 and 5,000 m by turns round 0 N 0 E.
const HEIGHTS: &[u8] = include_bytes!("../../../../../bench-scenes/extreme/cliffs.tif");

fn desk() -> Desk {
    let desk = Desk::new();
    let square = |west: f64| polygon(&rectangle(west, 0.01, west + 0.02, 0.03));
    let squares = [("a", square(0.0)), ("b", square(0.02)), ("c", square(0.05))];
    desk.write("hoods.geojson", collection(&squares));
    desk.write("dem/cliffs.tif", HEIGHTS);
    desk
}

#[test]
fn regions_and_heights_become_a_report_with_every_alternative() {
    if !has_device() {
        return;
    }
    let desk = desk();
    let options = ["--quick", "--size", "64", "--samples", "1", "--out", "run"];
    let line = [
        &["bench", "hoods.geojson", "--terrain", "dem"][..],
        &options,
    ]
    .concat();
    let ran = desk.run(&line);
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.starts_with(QUICK), "{}", ran.stdout);
    let run = Run::load(&desk.path("run")).expect("a run");
    let of = |key: &str| {
        let own = run.cases.iter();
        let mut values: Vec<&str> = own.map(|case| case.condition_named(key)).collect();
        values.sort_unstable();
        values.dedup();
        values
    };
    assert_eq!(of("scene"), ["hoods"]);
    for technique in [
        "draped-mesh",
        "flat-mesh",
        "mask-texture",
        "vertex",
        "compute",
    ] {
        assert!(of("technique").contains(&technique), "{technique}");
    }
    for view in ["all", "filled", "horizon"] {
        assert!(of("view").contains(&view), "{view}: {:?}", of("view"));
    }
    // The report names what was read, by its hash.
    let hashes = ["hoods.geojson", "dem/cliffs.tif"].map(|file| {
        let hash = terrafill_scene::sha256_hex(&desk.read(file));
        (file, hash)
    });
    let page = desk.read_text("run/index.html");
    for (file, hash) in &hashes {
        let line = format!("{file}, SHA-256 {hash}");
        assert!(page.contains(&line), "{line}");
    }
    // Again into the same folder: nothing measured is lost, and the way on is named.
    let again = desk.run(&line);
    again.refused(&[&["run", "--resume"]]);
    // The scene that was measured is there to be edited, and is that of `scene init`.
    let kept = desk.read_text("run/scenes/hoods.toml");
    let made = desk.run(&[
        "scene",
        "init",
        "hoods.geojson",
        "--terrain",
        "dem",
        "--size",
        "64",
    ]);
    assert_eq!(made.succeeded(), kept);
    let picture = [
        "render",
        "run/scenes/hoods.toml",
        "--view",
        "horizon",
        "--out",
        "a.png",
    ];
    let same = [
        "render",
        "hoods.geojson",
        "--terrain",
        "dem",
        "--view",
        "horizon",
        "--out",
        "b.png",
    ];
    for line in [&picture[..], &same] {
        let line = [line, &["--size", "64"]].concat();
        desk.run(&line).succeeded();
    }
    assert_eq!(desk.read("a.png"), desk.read("b.png"));
}

#[test]
fn a_report_has_the_warnings_of_what_was_read_and_a_changed_file_ends_a_run() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    // A bow tie, which is filled by the even-odd rule.
    let bow = polygon(&BOW_TIE);
    desk.write("bow.geojson", collection(&[("bow", bow.clone())]));
    let line = "bench bow.geojson --quick --size 48 --samples 1 --technique vertex --out run";
    let line: Vec<&str> = line.split(' ').collect();
    let ran = desk.run(&line);
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    for file in ["run/index.html", "run/summary.md"] {
        let text = desk.read_text(file);
        assert!(
            text.contains("1 crossing of edges: filled by the even-odd rule"),
            "{file}: {text}"
        );
    }
    let again = [&line[..], &["--resume"]].concat();
    assert_eq!(desk.run(&again).code, 0);
    // Negative control: a blank behind the same regions is another file.
    desk.write("bow.geojson", collection(&[("bow", bow)]) + " ");
    desk.run(&again)
        .refused(&[&["bow.geojson: found sha256", "which the run began with"]]);
}

#[test]
fn one_line_of_options_fits_every_verb_and_what_decides_nothing_is_said() {
    let desk = desk();
    desk.write("points.csv", "lon,lat\n0.01,0.02\n");
    let line = "hoods.geojson --terrain dem --edges great-ellipse --repair even-odd --name own";
    let line: Vec<&str> = line.split(' ').collect();
    for verb in [&["mesh"][..], &["locate", "--points", "points.csv"]] {
        let ran = desk.run(&[verb, &line].concat());
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        for option in ["--terrain", "--name"] {
            let warning = format!("warning: {option} decides nothing");
            assert!(ran.stderr.contains(&warning), "{}", ran.stderr);
        }
        // Control: without them nothing is said.
        let ran = desk.run(&[verb, &line[..1], &line[3..7]].concat());
        ran.succeeded();
    }
    desk.run(&[&["scene", "init"][..], &line].concat())
        .succeeded();
}

#[test]
fn what_cannot_become_a_scene_is_refused() {
    let desk = desk();
    let refused = |line: &[&str], words: &[&str]| {
        desk.run(line).refused(&[words]);
    };
    refused(
        &["bench", "california", "--terrain", "dem"],
        &["--terrain: found with a scene", "(.geojson or .json)"],
    );
    refused(
        &["scene", "init", "hoods.geojson", "--terrain", "nothing.tif"],
        &["nothing.tif", "no such file"],
    );
    desk.write("empty/readme.txt", "");
    refused(
        &["scene", "init", "hoods.geojson", "--terrain", "empty"],
        &["--terrain: empty", "found no file of heights", "tif"],
    );
    refused(
        &[
            "render",
            "california",
            "--view",
            "globe",
            "--unwrap",
            "shortest",
            "--out",
            "x.png",
        ],
        &["--unwrap: found with a scene"],
    );
    refused(
        &["bench", "none.geojson"],
        &["none.geojson", "no such file"],
    );
}
