// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs of many machines in one table: each case by device, as a ratio to that device's own control.
//!
//! A device that is slow in everything is no regression of anything. So a time is divided by that of the
//! control of the same scene and view in the same run, process by process, and no device's time is
//! compared with another's.

use crate::Primary;
use crate::primary::ranks;
use crate::record::Machine;
use serde::Serialize;
use std::collections::BTreeMap;
use terrafill_results::{Case, Estimate, Outcome, Run, median, ratio, typical};

/// The control where none is named: a full-screen pass that no technique has a part in.
pub const CONTROL: &str = "depth-pass";

/// Cases by device.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceTable {
    /// Technique that each time is divided by.
    pub control: String,
    /// Columns.
    pub devices: Vec<Device>,
    /// Rows, by case.
    pub rows: Vec<DeviceRow>,
}

/// A kind of machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Device {
    /// Device, driver, CPU and picture size.
    pub name: String,
    /// The clock of its times.
    pub clock: String,
    /// Its runs: folder and commit.
    pub runs: Vec<(String, String)>,
}

/// A case on every device.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceRow {
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// In the order of the devices.
    pub cells: Vec<DeviceCell>,
}

/// A case on a device.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DeviceCell {
    /// Its time over the control's.
    Ratio {
        /// Median over the runs of the device.
        ratio: f64,
        /// 95 % interval over processes, of a single run with enough of them.
        interval: Option<[f64; 2]>,
        /// Median time of the case.
        time: f64,
        /// Unit of the time.
        unit: String,
    },
    /// There is none.
    None {
        /// How the case ended there; empty where no run has it.
        outcome: String,
        /// Why.
        reason: String,
    },
}

/// Sets runs side by side by device; runs of one kind of machine share a column.
#[must_use]
pub fn by_device(runs: &[Run], control: &str, primary: Primary<'_>) -> DeviceTable {
    let mut groups: Vec<(String, Vec<&Run>)> = Vec::new();
    for run in runs {
        let name = Machine::of(&run.environment).label();
        match groups.iter_mut().find(|(known, _)| *known == name) {
            Some((_, of_device)) => of_device.push(run),
            None => groups.push((name, vec![run])),
        }
    }
    let mut rows: BTreeMap<String, Vec<DeviceCell>> = BTreeMap::new();
    for run in runs {
        for case in run.cases.iter().filter(|case| !case.is_repeat()) {
            rows.entry(case.id().key()).or_default();
        }
    }
    for (_, of_device) in &groups {
        let cases: Vec<BTreeMap<String, &Case>> = of_device
            .iter()
            .map(|run| {
                run.cases
                    .iter()
                    .map(|case| (case.id().key(), case))
                    .collect()
            })
            .collect();
        for (key, cells) in &mut rows {
            let found: Vec<DeviceCell> = of_device
                .iter()
                .zip(&cases)
                .filter_map(|(run, cases)| Some(cell(run, cases.get(key)?, control, primary)))
                .collect();
            cells.push(joined(found));
        }
    }
    // What no device times, such as a mesh's bytes, is no row of a table of times.
    rows.retain(|_, cells| cells.iter().any(|cell| !is_untimed(cell)));
    DeviceTable {
        control: control.to_owned(),
        devices: groups
            .into_iter()
            .map(|(name, runs)| device(name, &runs))
            .collect(),
        rows: rows
            .into_iter()
            .map(|(case, cells)| DeviceRow { case, cells })
            .collect(),
    }
}

fn device(name: String, runs: &[&Run]) -> Device {
    let facts = |run: &&Run| {
        (
            run.path.display().to_string(),
            run.environment.commit.clone(),
        )
    };
    Device {
        name,
        clock: runs.first().map_or("", |run| run.clock().name()).to_owned(),
        runs: runs.iter().map(facts).collect(),
    }
}

/// Reason of a case that is right and has no time.
const UNTIMED: &str = "it is not timed";

fn is_untimed(cell: &DeviceCell) -> bool {
    match cell {
        DeviceCell::None { outcome, reason } => outcome.is_empty() || reason == UNTIMED,
        DeviceCell::Ratio { .. } => false,
    }
}

fn cell(run: &Run, case: &Case, control: &str, primary: Primary<'_>) -> DeviceCell {
    let none = |reason: &str| DeviceCell::None {
        outcome: case.outcome.name().to_owned(),
        reason: reason.to_owned(),
    };
    if case.outcome != Outcome::Ok {
        return none(&case.reason);
    }
    let study = &case.id().study;
    let metric = ranks(run, study, primary);
    let Some((metric, time)) = metric.and_then(|m| Some((m, typical(case, m)?.middle))) else {
        return none(UNTIMED);
    };
    let is_control = |other: &&Case| {
        let same = |key: &str| other.condition(key) == case.condition(key);
        other.condition("technique") == control
            && same("scene")
            && same("view")
            && !other.is_repeat()
    };
    let over = run
        .of_study(study)
        .find(is_control)
        .filter(|control| control.counts());
    match over.and_then(|over| ratio(case, over, metric)) {
        Some(Estimate {
            middle, interval, ..
        }) => DeviceCell::Ratio {
            ratio: middle,
            interval,
            time,
            unit: run
                .metric(metric)
                .map_or_else(String::new, |row| row.unit.clone()),
        },
        None => none(&format!("no time of {control} in this scene and view")),
    }
}

/// Several runs of one device in a cell.
fn joined(cells: Vec<DeviceCell>) -> DeviceCell {
    let mut figures = (Vec::new(), Vec::new());
    let mut of_any = None;
    for cell in &cells {
        if let DeviceCell::Ratio { ratio, time, .. } = cell {
            figures.0.push(*ratio);
            figures.1.push(*time);
            of_any.get_or_insert(cell);
        }
    }
    match (of_any, median(&figures.0), median(&figures.1)) {
        (Some(DeviceCell::Ratio { unit, .. }), Some(ratio), Some(time)) if cells.len() > 1 => {
            DeviceCell::Ratio {
                ratio,
                interval: None,
                time,
                unit: unit.clone(),
            }
        }
        _ => cells.into_iter().next().unwrap_or(DeviceCell::None {
            outcome: String::new(),
            reason: "no run of this device has it".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests;
