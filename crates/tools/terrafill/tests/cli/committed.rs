// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reports under `reports/` are what their tables give.

use crate::harness::Desk;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A clone carries every report.
const MAX_BYTES: u64 = 2_000_000;

/// What `report` derives from the tables; the table of fills where there are any.
const DERIVED: [&str; 4] = ["index.html", "result.json", "summary.csv", "summary.md"];

fn reports() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../reports")
}

/// Folders of `reports/` that hold a run.
pub(crate) fn committed() -> Vec<PathBuf> {
    let entries = fs::read_dir(reports()).expect("reports");
    let folders = entries.map(|entry| entry.expect("an entry").path());
    folders.filter(|path| path.is_dir()).collect()
}

/// What a clone carries of a report.
fn bytes(report: &Path) -> u64 {
    let entries = fs::read_dir(report).expect("a folder");
    let length = |entry: fs::DirEntry| entry.metadata().expect("there").len();
    entries.map(|entry| length(entry.expect("an entry"))).sum()
}

/// The run that a report is made from, as `run` on a desk.
pub(crate) fn unpacked(report: &Path) -> Desk {
    let desk = Desk::new();
    fs::create_dir(desk.path("run")).expect("writable");
    let unpacked = Command::new("tar")
        .arg("-xzf")
        .arg(report.join("run.tar.gz"))
        .arg("-C")
        .arg(desk.path("run"))
        .status();
    assert!(unpacked.expect("tar").success());
    desk
}

/// Files that differ from the committed ones once they are made anew.
fn differing(desk: &Desk, report: &Path) -> Vec<&'static str> {
    let ran = desk.run(&["report", "run", "--single-file"]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let differs = |name: &&str| {
        let committed = fs::read(report.join(name)).ok();
        fs::read(desk.path(&format!("run/{name}"))).ok() != committed
    };
    DERIVED.into_iter().filter(differs).collect()
}

#[test]
fn committed_reports_are_rebuilt_from_their_tables() {
    let folders = committed();
    assert!(!folders.is_empty(), "no report is committed");
    for report in folders {
        let name = report.display();
        let bytes = bytes(&report);
        assert!(bytes <= MAX_BYTES, "{name}: {bytes} bytes");
        let differing = differing(&unpacked(&report), &report);
        assert!(
            differing.is_empty(),
            "{name}: {differing:?} are not what the tables give; run `ci/committed-report.sh rebuild \
             {name}` and look at what changed"
        );
    }
}

#[test]
fn a_changed_figure_changes_a_committed_report() {
    let report = reports().join("lavapipe-2-cores");
    let desk = unpacked(&report);
    let table = desk.path("run/measurements.csv");
    let text = fs::read_to_string(&table).expect("a table");
    let changed = text.replacen(",mismatched_px,0,0,0.0", ",mismatched_px,0,0,7.0", 1);
    assert_ne!(changed, text);
    fs::write(&table, changed).expect("writable");
    assert!(differing(&desk, &report).contains(&"index.html"));
}
