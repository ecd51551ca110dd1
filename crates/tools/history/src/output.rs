// SPDX-License-Identifier: MIT OR Apache-2.0
//! Comparisons and changes as Markdown, CSV and lines of text.

use crate::compare::{CaseTimes, Comparison, StudyTimes, TimeStanding};
use crate::device::{DeviceCell, DeviceTable};
use crate::page::{Trends, common, followed_in_words};
use crate::{Change, HistoryError, Series};
use std::fmt::Write as _;
use std::path::Path;
use terrafill_gate::{Finding, Severity};
use terrafill_plot::number::significant;

/// Rows of a table of a step summary.
const MAX_ROWS: usize = 100;

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

fn section(page: &mut String, title: &str, rows: &[String]) {
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "\n### {title} ({})\n\n| case | what |\n|---|---|",
        rows.len()
    );
    for row in rows.iter().take(MAX_ROWS) {
        let _ = writeln!(page, "{row}");
    }
    if rows.len() > MAX_ROWS {
        let _ = writeln!(
            page,
            "\n{} more with `--json` or `--csv`.",
            rows.len() - MAX_ROWS
        );
    }
}

fn finding_rows<'a>(findings: impl Iterator<Item = &'a Finding>) -> Vec<String> {
    findings
        .map(|f| format!("| `{}` | {} |", f.case, cell(&f.sentence())))
        .collect()
}

fn time_rows(of: &Comparison, standing: TimeStanding) -> Vec<String> {
    let row = |(study, case): &(&StudyTimes, &CaseTimes)| {
        let interval = case
            .interval
            .map_or("no interval".to_owned(), |[low, high]| {
                format!("95 % interval {} … {}", significant(low), significant(high))
            });
        let figures = [case.from, case.to, case.ratio].map(significant);
        let [from, to, ratio] = figures;
        let (metric, unit) = (&study.metric, &study.unit);
        format!(
            "| `{}` | {metric} {from} → {to} {unit}: × {ratio}, {interval} |",
            case.case
        )
    };
    of.standing(standing).iter().map(row).collect()
}

/// Two runs as Markdown: regressions, improvements, missing and new cases, times, and what is unchanged.
#[must_use]
pub fn comparison_markdown(of: &Comparison) -> String {
    let [base, new] = &of.sides;
    let mut page = format!(
        "## Compared: `{}` against `{}`\n\n- {} figures of {} cases compared exactly\n",
        new.path,
        base.path,
        of.exact.figures,
        of.exact.compared.len()
    );
    for sentence in of.sentences() {
        let _ = writeln!(page, "- {sentence}");
    }
    let figures = |severity| finding_rows(of.findings(severity, false));
    let status = |severity| finding_rows(of.findings(severity, true));
    section(&mut page, "Regressions", &figures(Severity::Worse));
    section(&mut page, "Improvements", &figures(Severity::Better));
    section(
        &mut page,
        "Gone or no longer right",
        &status(Severity::Worse),
    );
    section(&mut page, "New or not comparable", &status(Severity::Note));
    let unknown = [figures(Severity::Unknown), status(Severity::Unknown)].concat();
    section(&mut page, "Inconclusive", &unknown);
    section(&mut page, "Notes", &figures(Severity::Note));
    section(
        &mut page,
        "Slower, as advice",
        &time_rows(of, TimeStanding::Slower),
    );
    section(
        &mut page,
        "Faster, as advice",
        &time_rows(of, TimeStanding::Faster),
    );
    section(
        &mut page,
        "Times inconclusive",
        &time_rows(of, TimeStanding::Inconclusive),
    );
    let _ = writeln!(page, "\nUnchanged: {} cases.", of.unchanged().len());
    page
}

fn csv_text(header: &[&str], rows: Vec<Vec<String>>) -> Result<String, HistoryError> {
    let encoded = || -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(header)?;
        rows.iter().try_for_each(|row| writer.write_record(row))?;
        writer
            .into_inner()
            .map_err(|e| csv::Error::from(std::io::Error::other(e.to_string())))
    };
    let text = encoded().map_err(|error| HistoryError::io(Path::new("CSV"))(error.into()))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// Two runs as CSV: every difference, and every compared time.
///
/// # Errors
/// [`HistoryError::Io`] when a row cannot be encoded.
pub fn comparison_csv(of: &Comparison) -> Result<String, HistoryError> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for finding in &of.exact.findings {
        let word = serde_json::to_value(finding.severity).unwrap_or_default();
        rows.push(vec![
            finding.case.clone(),
            finding.metric.clone(),
            word.as_str().unwrap_or_default().to_owned(),
            finding.from.clone(),
            finding.to.clone(),
            String::new(),
            String::new(),
            String::new(),
            finding.words.clone(),
        ]);
    }
    for (study, case) in of
        .times
        .iter()
        .flat_map(|of| of.cases.iter().map(move |c| (of, c)))
    {
        let end = |index: usize| {
            case.interval
                .map_or(String::new(), |ends| ends[index].to_string())
        };
        rows.push(vec![
            case.case.clone(),
            study.metric.clone(),
            case.standing.name().to_owned(),
            case.from.to_string(),
            case.to.to_string(),
            case.ratio.to_string(),
            end(0),
            end(1),
            String::new(),
        ]);
    }
    let header = [
        "case", "metric", "standing", "base", "new", "ratio", "low", "high", "words",
    ];
    csv_text(&header, rows)
}

/// Cases by device as Markdown.
#[must_use]
pub fn device_markdown(of: &DeviceTable) -> String {
    let mut page = format!(
        "## Time ÷ {} of the same scene and view, by device\n\n",
        of.control
    );
    for device in &of.devices {
        let runs: Vec<&str> = device.runs.iter().map(|(path, _)| path.as_str()).collect();
        let _ = writeln!(
            page,
            "- {} ({}): {}",
            device.name,
            device.clock,
            runs.join(", ")
        );
    }
    let names: Vec<String> = of.devices.iter().map(|device| cell(&device.name)).collect();
    let _ = writeln!(
        page,
        "\n| case | {} |\n|---|{}",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    for row in of.rows.iter().take(10 * MAX_ROWS) {
        let cells = row.cells.iter().map(|of| match of {
            DeviceCell::Ratio {
                ratio, interval, ..
            } => {
                let interval = interval.map_or(String::new(), |[low, high]| {
                    format!(" [{}, {}]", significant(low), significant(high))
                });
                format!("{}{interval}", significant(*ratio))
            }
            DeviceCell::None { outcome, .. } if ["", "ok"].contains(&outcome.as_str()) => {
                "–".to_owned()
            }
            DeviceCell::None { outcome, .. } => outcome.clone(),
        });
        let cells: Vec<String> = cells.collect();
        let _ = writeln!(page, "| `{}` | {} |", row.case, cells.join(" | "));
    }
    page
}

/// Cases by device as CSV, a row for each case and device.
///
/// # Errors
/// [`HistoryError::Io`] when a row cannot be encoded.
pub fn device_csv(of: &DeviceTable) -> Result<String, HistoryError> {
    let mut rows = Vec::new();
    for row in &of.rows {
        for (device, of_device) in of.devices.iter().zip(&row.cells) {
            let end = |interval: &Option<[f64; 2]>, index: usize| {
                interval.map_or(String::new(), |ends| ends[index].to_string())
            };
            let figures = match of_device {
                DeviceCell::Ratio {
                    ratio,
                    interval,
                    time,
                    unit,
                } => [
                    ratio.to_string(),
                    end(interval, 0),
                    end(interval, 1),
                    time.to_string(),
                    unit.clone(),
                    "ok".to_owned(),
                    String::new(),
                ],
                DeviceCell::None { outcome, reason } => [
                    String::new(),
                    String::new(),
                    String::new(),
                    String::new(),
                    String::new(),
                    outcome.clone(),
                    reason.clone(),
                ],
            };
            let names = [row.case.clone(), device.name.clone(), of.control.clone()];
            rows.push(names.into_iter().chain(figures).collect());
        }
    }
    let header = [
        "case", "device", "control", "ratio", "low", "high", "time", "unit", "outcome", "reason",
    ];
    csv_text(&header, rows)
}

/// A change in a line.
#[must_use]
pub fn change_line(change: &Change) -> String {
    let size = change
        .percent()
        .map_or(String::new(), |percent| format!(" ({percent:+.1} %)"));
    let word = match change.is_better {
        Some(true) => "better",
        Some(false) => "worse",
        None => "changed",
    };
    let kind = format!("{:?}", change.kind).to_lowercase();
    let p = change
        .probability
        .map_or(String::new(), |p| format!(", p {}", significant(p)));
    let unit = match change.unit.as_str() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let [from, to] = [change.from, change.to].map(|value| match change.probability {
        Some(_) => significant(value),
        None => value.to_string(),
    });
    format!(
        "{word}: machine {}, {}, {} {from} → {to}{unit}{size}, {kind} at {} (last before: {}){p}",
        change.machine, change.case, change.metric, change.bad, change.good
    )
}

/// Every change and everything that is missing, a line each, the worse ones first.
#[must_use]
pub fn trend_lines(of: &Trends<'_>) -> Vec<String> {
    let found = of.changes;
    let mut lines = vec![followed_in_words(found)];
    let mut changes: Vec<&Change> = found.changes.iter().collect();
    let order = |change: &Change| match change.is_better {
        Some(false) => 0,
        Some(true) => 1,
        None => 2,
    };
    changes.sort_by_key(|change| order(change));
    lines.extend(changes.into_iter().map(change_line));
    for absent in of.absent {
        lines.push(format!(
            "{}: machine {}, {}, last result at {}: {}",
            absent.outcome, absent.machine, absent.case, absent.last, absent.reason
        ));
    }
    for undecided in found.undecided.iter().take(MAX_ROWS) {
        lines.push(format!(
            "undecided: machine {}, {}, {}: {}",
            undecided.machine, undecided.case, undecided.metric, undecided.reason
        ));
    }
    if found.undecided.len() > MAX_ROWS {
        let more = found.undecided.len() - MAX_ROWS;
        lines.push(format!("undecided: {more} more, --json lists all"));
    }
    for number in of.overview.machines.keys() {
        let series: Vec<&Series> = of.series.iter().filter(|s| s.machine == *number).collect();
        let changes: Vec<&Change> = found
            .changes
            .iter()
            .filter(|c| c.machine == *number)
            .collect();
        let common = common(&series, &changes);
        lines.extend(
            common
                .into_iter()
                .map(|line| format!("machine {number}: {line}")),
        );
    }
    lines
}
