// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two runs, and cases by device, as pages.

use super::{MAX_ROWS, first_rows, short, table, value};
use crate::compare::{CaseTimes, Comparison, StudyTimes, TimeStanding};
use crate::device::{DeviceCell, DeviceTable};
use terrafill_gate::{Finding, Severity};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Cell, CellClass, Row};

/// Two runs as a page.
#[must_use]
pub fn comparison_page(of: &Comparison) -> Vec<Block> {
    let mut blocks = Vec::new();
    let [base, new] = &of.sides;
    let counts = [
        (of.findings(Severity::Worse, false).count(), "figures worse"),
        (
            of.findings(Severity::Better, false).count(),
            "figures better",
        ),
        (
            of.findings(Severity::Worse, true).count(),
            "cases gone or no longer right",
        ),
    ];
    let counts: Vec<String> = counts
        .iter()
        .map(|(n, what)| format!("{n} {what}"))
        .collect();
    let (figures, cases) = (of.exact.figures, of.exact.compared.len());
    blocks.push(Block::Text(format!(
        "{figures} figures of {cases} cases compared exactly: {}.",
        counts.join(", ")
    )));
    // Backticks are Markdown's.
    let sentences = of.sentences().into_iter().map(|line| line.replace('`', ""));
    blocks.push(Block::List(sentences.collect()));
    let sides = [("base", base), ("new", new)].map(|(name, side)| {
        Row::new(vec![
            Cell::name(name),
            Cell::name(&side.path),
            Cell::plain(short(&side.commit)),
            Cell::plain(side.processes.to_string()),
            Cell::name(&side.machine),
        ])
    });
    let headings = [
        ("", ""),
        ("run", ""),
        ("commit", ""),
        ("processes", ""),
        ("machine", ""),
    ];
    blocks.push(table("", &headings, sides.to_vec()));

    let sections = [
        ("Regressions", Severity::Worse, TimeStanding::Slower),
        ("Improvements", Severity::Better, TimeStanding::Faster),
    ];
    for (title, severity, standing) in sections {
        blocks.push(Block::section(title));
        let is_bad = severity == Severity::Worse;
        let findings: Vec<&Finding> = of.findings(severity, false).collect();
        exact_table(&mut blocks, &findings, is_bad);
        times_table(&mut blocks, &of.standing(standing), Some(is_bad));
        if findings.is_empty() && of.standing(standing).is_empty() {
            blocks.push(Block::Text("None.".to_owned()));
        }
    }
    blocks.push(Block::section("Missing and new"));
    let status = [Severity::Worse, Severity::Unknown, Severity::Note].map(|severity| {
        let rows: Vec<&Finding> = of.findings(severity, true).collect();
        (severity == Severity::Worse, rows)
    });
    if status.iter().all(|(_, rows)| rows.is_empty()) {
        blocks.push(Block::Text("None.".to_owned()));
    } else {
        for (is_bad, rows) in &status {
            exact_table(&mut blocks, rows, *is_bad);
        }
    }
    let unknown: Vec<&Finding> = of.findings(Severity::Unknown, false).collect();
    let unsure = of.standing(TimeStanding::Inconclusive);
    if !unknown.is_empty() || !unsure.is_empty() {
        blocks.push(Block::section("Inconclusive"));
        exact_table(&mut blocks, &unknown, false);
        times_table(&mut blocks, &unsure, None);
    }
    blocks.push(Block::section("Unchanged"));
    let unchanged: Vec<String> = of.unchanged().into_iter().map(str::to_owned).collect();
    blocks.push(Block::Text(format!(
        "{} cases differ in nothing that counts.",
        unchanged.len()
    )));
    let shown: Vec<String> = unchanged.iter().take(10 * MAX_ROWS).cloned().collect();
    let summary = format!("{} of them by name", shown.len());
    blocks.extend((!shown.is_empty()).then(|| Block::Folded {
        summary,
        is_open: false,
        blocks: vec![Block::List(shown)],
    }));
    blocks
}

fn exact_table(blocks: &mut Vec<Block>, findings: &[&Finding], is_bad: bool) {
    if findings.is_empty() {
        return;
    }
    let row = |finding: &&Finding| {
        let mut case = Cell::name(&finding.case);
        case.command = finding.command().unwrap_or_default();
        let mut words = Cell::name(&finding.words);
        if is_bad {
            words.class = CellClass::Bad;
        }
        let or_none = |text: &str| Cell::or_absent((!text.is_empty()).then(|| text.to_owned()), "");
        Row::new(vec![
            case,
            Cell::plain(&finding.metric),
            or_none(&finding.from),
            or_none(&finding.to),
            words,
        ])
    };
    let headings = [
        ("case", ""),
        ("figure", ""),
        ("base", ""),
        ("new", ""),
        ("difference", ""),
    ];
    let rows = findings.iter().map(row);
    let more = "terrafill compare --csv lists all";
    first_rows(blocks, "", &headings, rows, (MAX_ROWS, more));
}

fn ratio(ratio: f64, interval: Option<[f64; 2]>) -> String {
    let interval = interval.map_or(String::new(), |[low, high]| {
        format!(" [{}, {}]", significant(low), significant(high))
    });
    format!("{}{interval}", significant(ratio))
}

fn times_table(blocks: &mut Vec<Block>, times: &[(&StudyTimes, &CaseTimes)], is_bad: Option<bool>) {
    if times.is_empty() {
        return;
    }
    let row = |(of, case): &(&StudyTimes, &CaseTimes)| {
        let mut change = Cell::plain(ratio(case.ratio, case.interval));
        change.class = match is_bad {
            Some(true) => CellClass::Bad,
            Some(false) => CellClass::Good,
            None => CellClass::Plain,
        };
        Row::new(vec![
            Cell::name(&case.case),
            Cell::plain(&of.metric),
            Cell::plain(value(case.from, &of.unit)),
            Cell::plain(value(case.to, &of.unit)),
            change,
        ])
    };
    let headings = [
        ("case", ""),
        ("time", ""),
        ("base", "median over processes"),
        ("new", "median over processes"),
        (
            "new ÷ base",
            "median over all pairs of processes, with its 95 % interval",
        ),
    ];
    let more = "terrafill compare --csv lists all";
    let rows = times.iter().map(row);
    let caption = "Times of two jobs: advice.";
    first_rows(blocks, caption, &headings, rows, (MAX_ROWS, more));
}

/// Cases by device as a page.
#[must_use]
pub fn device_page(of: &DeviceTable) -> Vec<Block> {
    let mut blocks = vec![Block::Text(format!(
        "Times over the {} of the same scene, view and run. A device's times are compared with its own \
         control alone, so a slow device is no regression.",
        of.control
    ))];
    let devices = of.devices.iter().map(|device| {
        let runs: Vec<String> = device
            .runs
            .iter()
            .map(|(path, commit)| format!("{path} ({})", short(commit)))
            .collect();
        let cells = [
            Cell::name(&device.name),
            Cell::plain(&device.clock),
            Cell::name(runs.join(", ")),
        ];
        Row::new(cells.to_vec())
    });
    let headings = [("device", ""), ("clock", ""), ("runs", "")];
    blocks.push(table("", &headings, devices.collect()));
    blocks.push(Block::section("Cases"));
    let cell = |cell: &DeviceCell| match cell {
        DeviceCell::Ratio {
            ratio: of,
            interval,
            time,
            unit,
        } => Cell {
            detail: value(*time, unit),
            ..Cell::plain(ratio(*of, *interval))
        },
        DeviceCell::None { outcome, reason } => {
            let known = ["", "ok"].contains(&outcome.as_str());
            Cell {
                text: if known {
                    "–".to_owned()
                } else {
                    outcome.clone()
                },
                ..Cell::absent(reason)
            }
        }
    };
    let rows = of.rows.iter().map(|row| {
        let cells = row.cells.iter().map(cell);
        Row::new(
            std::iter::once(Cell::name(&row.case))
                .chain(cells)
                .collect(),
        )
    });
    let mut headings = vec![("case", "")];
    headings.extend(
        of.devices
            .iter()
            .map(|device| (device.name.as_str(), device.clock.as_str())),
    );
    let more = "terrafill compare --by device --csv lists all";
    first_rows(&mut blocks, "", &headings, rows, (200, more));
    blocks
}
