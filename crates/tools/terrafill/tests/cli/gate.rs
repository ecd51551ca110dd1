// SPDX-License-Identifier: MIT OR Apache-2.0
//! `gate`, `bless` and `compare`: what passes, what does not, and that nothing passes unmeasured.

use crate::harness::{Desk, Ran, has_device};
use std::io::Write as _;

/// A run of one technique that takes a moment, into `out`.
fn measure(desk: &Desk, out: &str) {
    let options = ["--technique", "vertex", "--size", "64", "--samples", "1"];
    let bench = ["bench", "california", "--quick", "--out", out];
    desk.run(&[&bench[..], &options].concat()).succeeded();
}

fn gate(desk: &Desk, arguments: &[&str]) -> Ran {
    desk.run(&[&["gate"][..], arguments].concat())
}

/// The gate over the run folders `a` and `b`.
fn of_runs(desk: &Desk) -> Ran {
    gate(desk, &["--base-run", "a", "--new-run", "b"])
}

/// The program under another name, with a byte more at its end: the same work of another file.
fn twin(desk: &Desk) {
    let path = desk.path("twin");
    std::fs::copy(env!("CARGO_BIN_EXE_terrafill"), &path).expect("copied");
    let file = std::fs::OpenOptions::new().append(true).open(&path);
    file.expect("writable").write_all(b"\n").expect("written");
}

const CASE: &str = "filling/california/globe/vertex/doubled";

/// Replaces the value of a counter of [`CASE`] in a run's table.
fn tamper(desk: &Desk, run: &str, metric: &str, value: &str) {
    let name = format!("{run}/measurements.csv");
    let text = desk.read_text(&name);
    let start = format!("{CASE},{metric},0,0,");
    assert!(text.contains(&start), "{start}");
    let lines = text.lines().map(|line| match line.strip_prefix(&start) {
        Some(_) => format!("{start}{value}\n"),
        None => format!("{line}\n"),
    });
    desk.write(&name, lines.collect::<String>());
}

#[test]
fn equal_work_passes_and_a_counter_that_changed_fails_until_it_is_blessed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    measure(&desk, "b");
    let passed = of_runs(&desk);
    assert_eq!(passed.code, 0, "{}{}", passed.stdout, passed.stderr);
    assert!(
        passed.stdout.starts_with("PASS (exit 0)"),
        "{}",
        passed.stdout
    );
    for file in ["gate.md", "gate.json", "gate.junit.xml"] {
        assert!(desk.path("out/gate").join(file).is_file(), "{file}");
    }

    tamper(&desk, "b", "draws", "999");
    let failed = of_runs(&desk);
    assert_eq!(failed.code, 1, "{}", failed.stdout);
    for words in [
        CASE,
        "→ 999",
        "draws ",
        "see: terrafill bench california --study filling",
    ] {
        assert!(failed.stdout.contains(words), "{words}: {}", failed.stdout);
    }
    let compared = desk.run(&["compare", "a", "b"]);
    assert_eq!(compared.code, 1);
    assert!(compared.stdout.contains("→ 999"), "{}", compared.stdout);

    desk.run(&["bless", CASE, "--reason", ""])
        .refused(&[&["--reason"]]);
    desk.run(&["bless", "filling/none", "--reason", "x"])
        .refused(&[&["filling/none", CASE]]);
    let blessed = desk
        .run(&["bless", CASE, "--reason", "a second cap"])
        .succeeded();
    assert!(blessed.contains("→ 999"), "{blessed}");
    assert!(desk.read_text("gate/blessed.csv").contains("a second cap"));
    assert_eq!(of_runs(&desk).code, 0);

    // Another value is not the blessed one, which is now stale.
    tamper(&desk, "b", "draws", "1000");
    let stale = of_runs(&desk);
    assert_eq!(stale.code, 1, "{}", stale.stdout);
    assert!(stale.stdout.contains("blessing stale"), "{}", stale.stdout);
}

#[test]
fn nothing_that_was_not_measured_passes() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    measure(&desk, "b");
    for (metric, value) in [("filled_px", "0"), ("filled_px", "NaN"), ("draws", "0")] {
        let before = desk.read("b/measurements.csv");
        tamper(&desk, "b", metric, value);
        assert_eq!(of_runs(&desk).code, 1, "{metric} {value}");
        desk.write("b/measurements.csv", before);
    }
    gate(&desk, &["--base-run", "a", "--new-run", "a"]).refused(&[&["one folder"]]);
    gate(&desk, &["--base-run", "a"]).refused(&[&["--new-run"]]);
    gate(&desk, &["--base-run", "a", "--new-run", "none"]).refused(&[&["none"]]);
    gate(&desk, &[]).refused(&[&["nothing to compare with"]]);

    let cases = desk.read_text("b/cases.csv");
    let without: String = cases
        .lines()
        .filter(|line| !line.starts_with(&format!("{CASE},")))
        .map(|line| format!("{line}\n"))
        .collect();
    desk.write("b/cases.csv", without);
    let missing = of_runs(&desk);
    assert_eq!(missing.code, 3, "{}", missing.stdout);
    assert!(
        missing.stdout.contains("INCONCLUSIVE"),
        "{}",
        missing.stdout
    );

    desk.write("b/cases.csv", cases.replace("status", "state"));
    of_runs(&desk).refused(&[&["b/cases.csv, column 3", "\"state\"", "\"status\""]]);
    std::fs::remove_file(desk.path("b/cases.csv")).expect("removed");
    of_runs(&desk).refused(&[&["b/cases.csv"]]);
    assert!(
        !desk.path("out/gate/gate.json").exists(),
        "no answer of an earlier gate"
    );
}

#[test]
fn a_baseline_is_saved_compared_with_and_missed() {
    if !has_device() {
        return;
    }
    let desk = Desk::new();
    measure(&desk, "a");
    let missing = gate(&desk, &["--new-run", "a", "--baseline", "main"]);
    assert_eq!(missing.code, 4, "{}", missing.stderr);
    assert!(
        missing.stderr.contains("--save-baseline main"),
        "{}",
        missing.stderr
    );
    gate(&desk, &["--new-run", "a", "--save-baseline", "main"]).succeeded();
    measure(&desk, "b");
    let compare = ["--new-run", "b", "--baseline", "main"];
    assert_eq!(gate(&desk, &compare).code, 0);
    tamper(&desk, "b", "mismatched_px", "1e6");
    assert_eq!(gate(&desk, &compare).code, 1);
}

#[test]
fn two_programs_are_compared_and_one_program_or_none_is_not() {
    let desk = Desk::new();
    twin(&desk);
    let quick = ["california", "--technique", "vertex", "--size", "48"];
    let with = |more: &[&'static str]| [&quick[..], more].concat();
    let this = env!("CARGO_BIN_EXE_terrafill");
    gate(&desk, &with(&["--base", this])).refused(&[&["one program"]]);
    gate(&desk, &with(&["--base", "no-such-revision"])).refused(&[&["no-such-revision"]]);
    std::fs::copy(this, desk.path("equal")).expect("copied");
    let equal = gate(&desk, &with(&["--base", "equal"]));
    assert_eq!(equal.code, 4, "{}", equal.stderr);

    let gate_it = [
        &["gate"][..],
        &with(&["--base", "twin", "--out", "nowhere"]),
    ]
    .concat();
    assert_eq!(desk.run_without_device(&gate_it).code, 5);
    if !has_device() {
        return;
    }
    let ran = gate(
        &desk,
        &with(&["--base", "twin", "--no-time", "--out", "exact"]),
    );
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(
        ran.stdout.contains("times were not compared"),
        "{}",
        ran.stdout
    );
    gate(&desk, &with(&["--base", "twin", "--out", "exact"])).refused(&[&["holds something"]]);
    // Times were asked for, and there was no time for them.
    let ran = gate(
        &desk,
        &with(&["--base", "twin", "--time-budget-s", "1", "--out", "late"]),
    );
    assert_eq!(ran.code, 4, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stderr.contains("time budget of 1 s"), "{}", ran.stderr);
}
