// SPDX-License-Identifier: MIT OR Apache-2.0
//! Run folders that are not what they should be: each is refused by its file and column.

use crate::harness::Desk;
use terrafill_results::RunEnvironment;
use terrafill_results::made_up::{MadeUpRun, case_id};

/// A run of one case, as a bench leaves it.
fn write_run(desk: &Desk) {
    let mut run = MadeUpRun {
        environment: RunEnvironment {
            commit: "abc".to_owned(),
            ..RunEnvironment::default()
        },
        ..MadeUpRun::default()
    };
    let conditions = [
        ("scene", "moon"),
        ("view", "globe"),
        ("technique", "vertex"),
        ("role", "main"),
    ];
    run.case(case_id("filling", "moon/globe/vertex/doubled", &conditions))
        .figure("mismatched_px", 3.0)
        .timed("fill_cpu_ms", &[1.5])
        .note("mask_hash", "00");
    run.write(&desk.path("run")).expect("written");
}

/// Refused by `report`, in one line with all of `phrases`.
fn refused(desk: &Desk, phrases: &[&str]) {
    desk.run(&["report", "run"]).refused(&[phrases]);
    assert!(!desk.path("run/index.html").exists());
}

/// A fresh run with a file of it changed.
fn changed(file: &str, from: &str, to: &str) -> Desk {
    let desk = Desk::new();
    write_run(&desk);
    let path = format!("run/{file}");
    let text = desk.read_text(&path);
    assert!(text.contains(from), "{file}: {text}");
    desk.write(&path, text.replacen(from, to, 1));
    desk
}

#[test]
fn a_run_that_fits_the_schema_is_reported() {
    let desk = Desk::new();
    write_run(&desk);
    let report = desk.run(&["report", "run"]).succeeded();
    assert_eq!(report, "report: run/index.html\n");
}

#[test]
fn renamed_and_missing_columns_are_named() {
    let cases = [
        ("measurements.csv", "process", "proces", "column 3"),
        ("cases.csv", "status", "state", "column 3"),
        ("cases.csv", "technique", "method", "column 9"),
        ("notes.csv", "text", "words", "column 3"),
        ("metrics.csv", "kind", "sort", "column 3"),
    ];
    for (file, from, to, place) in cases {
        let desk = changed(file, from, to);
        let found = format!("found {to:?}, expected {from:?}");
        refused(&desk, &[&format!("run/{file}"), place, &found]);
    }
    let desk = changed("measurements.csv", ",value", "");
    refused(
        &desk,
        &["run/measurements.csv, column 5", "expected \"value\""],
    );
}

#[test]
fn removed_tables_are_named_with_their_columns() {
    for (file, columns) in [
        ("measurements.csv", "case, metric, process, sample, value"),
        ("cases.csv", "case, study, status, reason, timed, commit"),
        ("notes.csv", "case, note, text"),
        ("metrics.csv", "name, unit, kind, better, meaning"),
    ] {
        let desk = Desk::new();
        write_run(&desk);
        std::fs::remove_file(desk.path(&format!("run/{file}"))).expect("removable");
        refused(
            &desk,
            &[&format!("run/{file}: found no such file"), columns],
        );
    }
}

#[test]
fn another_schema_and_another_commit_are_named() {
    for file in ["schema.json", "environment.json"] {
        let desk = changed(file, "\"schema\": 1", "\"schema\": 2");
        refused(
            &desk,
            &[&format!("run/{file}, \"schema\": found 2, expected 1")],
        );
    }
    let desk = changed("cases.csv", ",abc,", ",def,");
    refused(
        &desk,
        &[
            "run/cases.csv, row 2, column commit",
            "found \"def\", expected \"abc\", that of environment.json",
        ],
    );
}

#[test]
fn rows_that_do_not_fit_the_run_are_named() {
    let key = "filling/moon/globe/vertex/doubled";
    let metric = format!("{key},fill_cpu_ms");
    let cases = [
        (
            "measurements.csv",
            "mismatched_px",
            "wrong_px",
            "column metric: found \"wrong_px\"",
        ),
        (
            "measurements.csv",
            key,
            "filling/mars",
            "column case: found \"filling/mars\"",
        ),
        (
            "measurements.csv",
            metric.as_str(),
            "filling/mars,x",
            "row 3, column case",
        ),
        (
            "measurements.csv",
            ",3.0",
            ",three",
            "column value: found \"three\", expected a number",
        ),
        (
            "cases.csv",
            ",ok,",
            ",fine,",
            "column status: found \"fine\", expected ok, wrong",
        ),
        (
            "cases.csv",
            "moon,globe",
            "moon,horizon",
            "column view: found \"horizon\"",
        ),
        ("notes.csv", key, "filling/mars", "row 2, column case"),
    ];
    for (file, from, to, phrase) in cases {
        refused(
            &changed(file, from, to),
            &[&format!("run/{file}, row "), phrase],
        );
    }
}
