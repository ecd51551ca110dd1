// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reports under `reports/` are what their tables give.

use crate::harness::Desk;
use crate::words::{elements, text};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A clone carries every report.
const MAX_BYTES: u64 = 2_500_000;

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

/// A layout's colour and marker on a page, by the layout's name: a fill's up to its first comma.
fn marks(page: &str) -> BTreeMap<String, String> {
    let cells = elements(page, "td").into_iter();
    let marks = cells.filter_map(|(_, cell)| {
        let (mark, name) = cell.split_once("</svg>")?;
        let (_, mark) = mark.split_once("<path ")?;
        let name = text(name);
        let layout = name.split(',').next()?.trim();
        Some((layout.to_owned(), mark.to_owned()))
    });
    marks.filter(|(layout, _)| layout.contains('/')).collect()
}

/// Layouts in the order of the page's first plot of fills.
fn order(page: &str) -> Vec<String> {
    let plots = elements(page, "figure").into_iter();
    let mut plots = plots.map(|(_, plot)| {
        let labels = elements(plot, "text")
            .into_iter()
            .map(|(_, label)| text(label));
        let layouts = labels.map(|label| label.split(',').next().unwrap_or_default().to_owned());
        let mut layouts: Vec<String> = layouts.filter(|name| name.contains('/')).collect();
        layouts.dedup();
        layouts
    });
    plots.find(|layouts| layouts.len() > 2).unwrap_or_default()
}

/// What of a page's colours and order is otherwise on another page.
fn otherwise(page: &str, other: &str) -> Vec<String> {
    let (own, others) = (marks(page), marks(other));
    let colours = own.into_iter().filter(|(layout, mark)| {
        let theirs = others.get(layout);
        theirs.is_some_and(|theirs| theirs != mark)
    });
    let mut found: Vec<String> = colours.map(|(layout, _)| layout).collect();
    let [own, others] = [page, other].map(order);
    let both = |from: &[String], of: &[String]| -> Vec<String> {
        let both = from.iter().filter(|name| of.contains(name));
        both.cloned().collect()
    };
    if both(&own, &others) != both(&others, &own) {
        found.push("the order".to_owned());
    }
    found
}

#[test]
fn a_technique_has_one_colour_and_one_place_in_all_committed_reports() {
    let pages = committed().into_iter().map(|report| {
        let page = fs::read_to_string(report.join("index.html")).expect("a page");
        (report, page)
    });
    let pages: Vec<(PathBuf, String)> = pages.filter(|(_, page)| order(page).len() > 2).collect();
    assert!(pages.len() > 2, "{}", pages.len());
    let (_, first) = &pages[0];
    assert!(marks(first).len() > 3);
    for (report, page) in &pages {
        let found = otherwise(page, first);
        assert!(found.is_empty(), "{}: {found:?}", report.display());
    }
    // Negative controls: two colours that changed places, and two rows.
    let [(one, colour), (_, other)] = {
        let mut marks = marks(first).into_iter();
        [marks.next(), marks.next()].map(|mark| mark.expect("a mark"))
    };
    let recoloured = first.replace(&colour, &other);
    assert!(otherwise(&recoloured, first).contains(&one));
    let [top, next] = [0, 1].map(|place| order(first)[place].clone());
    let swapped = first
        .replace(&top, "\u{0}")
        .replace(&next, &top)
        .replace('\u{0}', &next);
    assert!(otherwise(&swapped, first).contains(&"the order".to_owned()));
}
