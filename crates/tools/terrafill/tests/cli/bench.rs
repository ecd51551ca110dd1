// SPDX-License-Identifier: MIT OR Apache-2.0
//! `bench` and `report`: what a run writes, and that a killed one goes on where it was.

use crate::harness::{Desk, Ran, collection, has_device, polygon, ran, rectangle};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Columns that scripts and the gate rely on, in this order.
const STABLE_COLUMNS: &str = "scene,view,backend,variant,status,reason,surface_gpu_ms,fill_gpu_ms,\
    fill_cpu_ms,bound_gpu_ms,bound_cpu_ms,floor_cpu_ms,fill_over_bound_cpu,geometry_bytes,\
    upload_bytes,draws,vertices,filled_px,mismatched_px,mismatched_px_outside_band,hausdorff_px,\
    left_out,";

const QUICK: [&str; 7] = [
    "bench",
    "--quick",
    "--size",
    "64",
    "california",
    "--out",
    "run",
];

/// Rows of a CSV file of the run.
fn rows(desk: &Desk, name: &str) -> Vec<Vec<String>> {
    let text = desk.read_text(name);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.records().map(|row| {
        let row = row.expect("a row");
        row.iter().map(str::to_owned).collect()
    });
    rows.collect()
}

/// Scene, view, backend and variant, joined as the program names a case.
fn case(row: &[String]) -> String {
    row[..4].join("/")
}

#[test]
fn a_quick_run_writes_every_file_and_ends_with_0() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let text = desk
        .run(&[&QUICK[..], &["--frames", "2"]].concat())
        .succeeded();
    assert!(
        text.starts_with("23 right, 0 wrong, 0 failed, 0 skipped"),
        "{text}"
    );
    assert!(text.ends_with("report: run/report.html\n"), "{text}");
    assert_eq!(desk.names(), ["run"]);
    for name in [
        "samples.csv",
        "environment.json",
        "plan.json",
        "report.html",
    ] {
        assert!(!desk.read(&format!("run/{name}")).is_empty(), "{name}");
    }
    let summary = desk.read_text("run/summary.csv");
    assert!(summary.starts_with(STABLE_COLUMNS), "{summary}");
    let cases: BTreeSet<String> = rows(&desk, "run/summary.csv")
        .iter()
        .map(|row| case(row))
        .collect();
    let mut expected = BTreeSet::new();
    for view in ["globe", "top-down", "horizon"] {
        for technique in [
            "bound/full-screen",
            "floor/full-screen",
            "vertex/doubled",
            "vertex/pulled",
            "compute/per-frame",
            "compute/cached",
            "native/vs-control",
            "native/gs-degenerate",
            "native/gs-line",
        ] {
            expected.insert(format!("california/{view}/{technique}"));
        }
    }
    for route in ["chosen", "atan2-native+bowring-1"] {
        expected.insert(format!(
            "california/top-down/vertex/doubled,texture={route}"
        ));
    }
    assert_eq!(cases, expected);
    assert_eq!(rows(&desk, "run/samples.csv").len(), 2 * expected.len());
    let html = desk.read_text("run/report.html");
    assert!(html.trim_end().ends_with("</html>") && html.contains("california"));
    // The report again, from the files alone and without a device.
    std::fs::remove_file(desk.path("run/report.html")).expect("removable");
    let ran = desk.run_without_device(&["report", "run"]);
    assert_eq!(ran.succeeded(), "report: run/report.html\n");
    assert_eq!(desk.read_text("run/report.html"), html);
    // A run in the same place is not mixed with this one.
    desk.run(&QUICK)
        .refused(&[&["run holds a run already", "--resume"]]);
}

#[test]
fn a_wrong_picture_ends_with_1() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let overlapping = collection(&[
        ("below", polygon(&rectangle(-8.0, -8.0, 4.0, 8.0))),
        ("above", polygon(&rectangle(-4.0, -8.0, 8.0, 8.0))),
    ]);
    desk.write_scene("overlap", &overlapping);
    let bench = |out: &str| {
        let options = ["--quick", "--size", "64", "--frames", "1", "--data", "data"];
        let arguments = [&["bench", "overlap.toml", "--out", out][..], &options].concat();
        desk.run(&arguments)
    };
    // Disjoint is what the scene says; XOR colouring relies on it.
    let ran = bench("wrong");
    assert_eq!(ran.code, 1, "{}", ran.stdout);
    assert!(ran.stdout.starts_with("0 right, 7 wrong"), "{}", ran.stdout);
    let truth = format!("overlap = \"ordered\"\n{}", desk.read_text("overlap.toml"));
    desk.write("overlap.toml", truth);
    assert!(bench("right").succeeded().starts_with("7 right, 0 wrong"));
}

#[test]
fn nothing_to_measure_ends_with_4() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    let ran = desk.run(&["bench", "countries-110m", "--out", "run"]);
    assert_eq!(ran.code, 4, "{}", ran.stderr);
    let skipped = "skipped: countries-110m: ";
    assert!(ran.stderr.starts_with(skipped), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("TERRAFILL_DATA is not set"),
        "{}",
        ran.stderr
    );
    let ran = desk.run(&["bench", "california", "--shard", "4/4", "--out", "shard"]);
    assert_eq!(ran.code, 4, "{}", ran.stderr);
}

#[test]
fn a_folder_without_a_run_has_no_report_and_cannot_be_resumed() {
    let desk = Desk::new();
    desk.write("folder/file", "");
    for folder in ["none", "folder"] {
        desk.run(&["report", folder])
            .refused(&[&[folder, "plan.json"]]);
        assert!(!desk.path("none").exists());
    }
    if has_device() {
        desk.run(&[&QUICK[..], &["--resume"]].concat())
            .refused(&[&["run/plan.json"]]);
        assert_eq!(desk.names(), ["folder"]);
    }
}

/// Frames of each case in the run that is killed: a few seconds of work on a software driver.
const FRAMES: u32 = 120;
/// Cases of the run: three views of two full-screen passes and seven techniques, and two textured fills.
const CASES: usize = 29;

fn long_run(desk: &Desk, more: &[&str]) -> std::process::Command {
    let frames = FRAMES.to_string();
    desk.command(&[&QUICK[..], &["--frames", &frames], more].concat())
}

/// Starts the run and kills it with SIGKILL once `samples.csv` holds `rows` rows.
fn kill_after(desk: &Desk, more: &[&str], rows: usize) {
    let mut child = long_run(desk, more).spawn().expect("the program starts");
    let started = Instant::now();
    let lines = || {
        let text = std::fs::read(desk.path("run/samples.csv")).unwrap_or_default();
        text.iter().filter(|byte| **byte == b'\n').count()
    };
    let mut ended = None;
    while lines() < rows + 1 && ended.is_none() && started.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
        ended = child.try_wait().expect("a child");
    }
    // Killed before anything is asserted, so that no failure leaves it running.
    child.kill().expect("killed");
    let status = child.wait().expect("a child");
    assert_eq!(status.code(), None, "ended by itself before it was killed");
    assert!(lines() > rows, "no rows came");
}

/// The file's finished lines: what a kill must not take away.
fn whole_lines(desk: &Desk, name: &str) -> Vec<u8> {
    let mut bytes = std::fs::read(desk.path(name)).unwrap_or_default();
    let end = bytes
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |at| at + 1);
    bytes.truncate(end);
    bytes
}

/// `report` on what is left: names the cases without a row in the summary.
fn check_report(desk: &Desk) -> Ran {
    let measured: BTreeSet<String> = if desk.path("run/summary.csv").exists() {
        rows(desk, "run/summary.csv")
            .iter()
            .map(|row| case(row))
            .collect()
    } else {
        BTreeSet::new()
    };
    let ran = desk.run(&["report", "run"]);
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (0, "report: run/report.html\n"),
        "{}",
        ran.stderr
    );
    let missing = CASES - measured.len();
    let mut lines = ran.stderr.lines();
    let heading = format!("{missing} planned cases are missing:");
    assert_eq!(lines.next(), Some(heading.as_str()));
    let named: BTreeSet<&str> = lines.map(str::trim).collect();
    assert_eq!(named.len(), missing);
    assert!(measured.iter().all(|case| !named.contains(case.as_str())));
    let html = desk.read_text("run/report.html");
    assert!(html.trim_end().ends_with("</html>"));
    ran
}

#[test]
fn a_killed_run_is_reported_and_resumed_without_measuring_anything_twice() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    // In the first view, before any case is finished.
    kill_after(&desk, &[], 40);
    let ran = check_report(&desk);
    assert!(
        ran.stderr.contains("  california/horizon/vertex/pulled\n"),
        "{}",
        ran.stderr
    );
    let first = whole_lines(&desk, "run/samples.csv");
    // In the second view: the first one is summed up.
    let view = 9 * FRAMES as usize;
    kill_after(&desk, &["--resume"], view + 60);
    let ran = check_report(&desk);
    assert!(!ran.stderr.contains("california/globe"), "{}", ran.stderr);
    let samples = whole_lines(&desk, "run/samples.csv");
    assert!(
        samples.starts_with(&first),
        "rows of the first part stay as they were"
    );
    let summary = whole_lines(&desk, "run/summary.csv");

    // Nothing but the same run goes on here.
    let others: [(&[&str], &str); 4] = [
        (&["--frames", "9"], "frames=9"),
        (&["--frames", "120", "--size", "65"], "size=65x65"),
        (
            &["--frames", "120", "planet-134"],
            "scenes=california+planet-134",
        ),
        (&["--frames", "120", "--shard", "1/2"], "shard=1/2"),
    ];
    for (more, phrase) in others {
        let base: Vec<&str> = QUICK
            .into_iter()
            .filter(|word| !more.contains(&"--size") || !["--size", "64"].contains(word))
            .collect();
        let arguments = [&base[..], more, &["--resume"]].concat();
        desk.run(&arguments)
            .refused(&[&["run holds a run already: cannot resume with", phrase]]);
        assert_eq!(whole_lines(&desk, "run/samples.csv"), samples, "{phrase}");
    }

    let text = ran_to_the_end(&desk);
    assert!(
        text.starts_with("23 right, 0 wrong, 0 failed, 0 skipped"),
        "{text}"
    );
    let all = desk.read("run/samples.csv");
    assert!(
        all.starts_with(&samples),
        "rows of both parts stay as they were"
    );
    assert!(desk.read("run/summary.csv").starts_with(&summary));
    let found: Vec<(String, String)> = rows(&desk, "run/samples.csv")
        .iter()
        .map(|row| (case(row), row[4].clone()))
        .collect();
    let distinct: BTreeSet<&(String, String)> = found.iter().collect();
    assert_eq!(found.len(), CASES * FRAMES as usize);
    assert_eq!(distinct.len(), found.len(), "no frame stands twice");
    assert_eq!(rows(&desk, "run/summary.csv").len(), CASES);
    // Once more: there is nothing left to do.
    ran_to_the_end(&desk);
    assert_eq!(desk.read("run/samples.csv"), all);
    assert_eq!(
        desk.run(&["report", "run"]).succeeded(),
        "report: run/report.html\n"
    );
}

fn ran_to_the_end(desk: &Desk) -> String {
    ran(&mut long_run(desk, &["--resume"])).succeeded()
}

#[test]
fn a_growth_sample_is_two_numbers_of_the_region_of_a_file() {
    let desk = Desk::new();
    let square = r#"{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,1],[0,0]]]}"#;
    desk.write("square.geojson", square);
    let sample = desk.run(&["growth-sample", "square.geojson"]).succeeded();
    let numbers: Vec<f64> = sample
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert!(
        matches!(numbers[..], [4.0, cpu_ms] if cpu_ms > 0.0),
        "{sample}"
    );
    // Twins: no file, and one whose region crosses itself.
    desk.write(
        "bow-tie.geojson",
        square.replace("[1,1],[0,1]", "[0,1],[1,1]"),
    );
    for (file, why) in [
        ("missing.geojson", "No such file"),
        ("bow-tie.geojson", "crosses"),
    ] {
        let wrong = desk.run(&["growth-sample", file]);
        assert_eq!(wrong.code, 2);
        assert!(
            wrong.stderr.contains(file) && wrong.stderr.contains(why),
            "{}",
            wrong.stderr
        );
    }
}
