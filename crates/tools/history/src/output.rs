// SPDX-License-Identifier: MIT OR Apache-2.0
//! Comparisons and changes as CSV and lines of text.

use crate::compare::Comparison;
use crate::device::{DeviceCell, DeviceTable};
use crate::page::{Trends, common, followed_in_words};
use crate::{Change, HistoryError, Series};
use std::path::Path;
use terrafill_plot::number::significant;

/// Lines of what cannot be decided.
const MAX_ROWS: usize = 100;

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
