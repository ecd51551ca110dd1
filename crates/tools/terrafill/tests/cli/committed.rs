// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reports under `reports/` are what their tables give.

use crate::harness::Desk;
use std::fs;
use std::path::{Path, PathBuf};

/// A clone carries every report.
const MAX_BYTES: u64 = 2_000_000;

/// What `report` derives from the tables.
const DERIVED: [&str; 4] = ["index.html", "result.json", "summary.csv", "summary.md"];

/// Folders of `reports/` that hold a run.
fn committed() -> Vec<PathBuf> {
    let reports = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../reports");
    let entries = fs::read_dir(reports).expect("reports");
    let folders = entries.map(|entry| entry.expect("an entry").path());
    folders.filter(|path| path.is_dir()).collect()
}

/// Copies a folder to `to`, without what is derived; the bytes that it holds, all counted.
fn copied(from: &Path, to: &Path) -> u64 {
    fs::create_dir_all(to).expect("writable");
    let entries = fs::read_dir(from).expect("a folder");
    let copy = |entry: fs::DirEntry| {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            return copied(&path, &to);
        }
        if !DERIVED.iter().any(|name| entry.file_name() == *name) {
            fs::copy(&path, to).expect("writable");
        }
        entry.metadata().expect("there").len()
    };
    entries.map(|entry| copy(entry.expect("an entry"))).sum()
}

/// Files that differ from the committed ones once they are made anew.
fn differing(desk: &Desk, report: &Path) -> Vec<&'static str> {
    let ran = desk.run(&["report", "run", "--single-file"]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let differs = |name: &&str| {
        let committed = fs::read(report.join(name)).expect("committed");
        desk.read(&format!("run/{name}")) != committed
    };
    DERIVED.into_iter().filter(differs).collect()
}

#[test]
fn committed_reports_are_rebuilt_from_their_tables() {
    let reports = committed();
    assert!(!reports.is_empty(), "no report is committed");
    for report in reports {
        let name = report.display();
        let desk = Desk::new();
        let bytes = copied(&report, &desk.path("run"));
        assert!(bytes <= MAX_BYTES, "{name}: {bytes} bytes");
        let differing = differing(&desk, &report);
        assert!(
            differing.is_empty(),
            "{name}: {differing:?} are not what the tables give; run `terrafill report {name} \
             --single-file` and look at what changed"
        );
    }
}

#[test]
fn a_changed_figure_changes_a_committed_report() {
    let report = committed().remove(0);
    let desk = Desk::new();
    copied(&report, &desk.path("run"));
    let table = desk.path("run/measurements.csv");
    let text = fs::read_to_string(&table).expect("a table");
    let changed = text.replacen(",mismatched_px,0,0,0.0", ",mismatched_px,0,0,7.0", 1);
    assert_ne!(changed, text);
    fs::write(&table, changed).expect("writable");
    assert!(differing(&desk, &report).contains(&"index.html"));
}
