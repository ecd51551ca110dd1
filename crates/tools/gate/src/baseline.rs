// SPDX-License-Identifier: MIT OR Apache-2.0
//! Named baselines: what counters, bytes and errors were, for a later run to be compared with. No time
//! is kept, since no time may be compared with a stored one.
//!
//! A baseline is a folder with a run folder for each driver, without its timed samples: plain tables that
//! a review can read. What drivers may count differently is compared with the own driver's alone.

use crate::{GateError, driver_fingerprint};
use std::path::{Path, PathBuf};
use terrafill_results::{Metric, MetricRow, PlannedCase, Run, RunFolder, RunPlan};

/// Writes `run` as the baseline `name` of its driver, in place of an earlier one.
///
/// - `folder`: of all baselines
/// - returns: where it is
///
/// # Errors
/// [`GateError::BadInput`] for a name that is no folder's, or a run without a right case;
/// [`GateError::Io`], [`GateError::Run`].
pub fn save_baseline(run: &Run, folder: &Path, name: &str) -> Result<PathBuf, GateError> {
    let place = folder
        .join(checked(name)?)
        .join(driver_fingerprint(&run.environment));
    if !run.cases.iter().any(terrafill_results::Case::counts) {
        let message = format!("{}: no case is right, nothing to save", run.path.display());
        return Err(GateError::BadInput(message));
    }
    if place.exists() {
        std::fs::remove_dir_all(&place).map_err(GateError::io(&place))?;
    }
    std::fs::create_dir_all(&place).map_err(GateError::io(&place))?;
    let cases = run.cases.iter().filter(|case| !case.is_repeat());
    let kept: Vec<_> = cases.clone().collect();
    let plan = RunPlan {
        cases: kept
            .iter()
            .map(|case| PlannedCase {
                samples: 0,
                ..case.planned.clone()
            })
            .collect(),
        processes: 1,
        ..run.plan.clone()
    };
    let rows: Vec<&MetricRow> = run.metrics.iter().filter(|m| m.kind.is_exact()).collect();
    let metrics: Vec<Metric> = rows.iter().map(|row| declaration(row)).collect();
    let written = RunFolder::create(&place, run.environment.clone(), plan, &metrics)?;
    for (case, planned) in kept.iter().zip(&written.plan().cases) {
        let mut values = case.measurements();
        values.retain(|value| rows.iter().any(|row| row.name == value.metric));
        written.append_measurements(&values)?;
        if let Some(status) = case.status() {
            written.append_case(planned, status, &case.reason)?;
        }
    }
    Ok(place)
}

/// Declarations have static texts: these live as long as the program, a few kilobytes once.
fn declaration(row: &MetricRow) -> Metric {
    let keep = |text: &str| -> &'static str { Box::leak(text.to_owned().into_boxed_str()) };
    // Exact figures cover no part of a frame's work.
    let [name, unit, meaning] = [&row.name, &row.unit, &row.meaning].map(|text| keep(text));
    Metric {
        better: row.better,
        ..Metric::neither(name, unit, row.kind, meaning).ranking(row.primary)
    }
}

/// The baseline `name` for a run: its own driver's, else another driver's, of which only what no driver
/// decides is compared.
///
/// # Errors
/// [`GateError::NothingMeasured`] where there is no such baseline: that is never a pass.
pub fn load_baseline(run: &Run, folder: &Path, name: &str) -> Result<Run, GateError> {
    let place = folder.join(checked(name)?);
    let own = place.join(driver_fingerprint(&run.environment));
    if own.exists() {
        return Ok(Run::load(&own)?);
    }
    let mut others: Vec<PathBuf> = std::fs::read_dir(&place)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.is_dir())
        .collect();
    others.sort();
    match others.first() {
        Some(other) => Ok(Run::load(other)?),
        None => Err(GateError::NothingMeasured(format!(
            "{}: no such baseline; `--save-baseline {name}` on a commit known to be good writes it",
            place.display()
        ))),
    }
}

fn checked(name: &str) -> Result<&str, GateError> {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_allowed) {
        return Err(GateError::BadInput(format!(
            "baseline: found {name:?}, allowed: letters, digits, -, _ and ."
        )));
    }
    Ok(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Severity, Verdict, compare_exactly, verdict};
    use terrafill_results::Kind;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    fn run_on(place: &Path, name: &str, driver: &str, figures: [f64; 2]) -> Run {
        let mut run = MadeUpRun {
            metrics: vec![
                Metric::less("draws", "", Kind::Counter, "Draws."),
                Metric::neither("filled_px", "px", Kind::DriverCounter, "Pixels."),
                Metric::less("fill_cpu_ms", "ms", Kind::Time, "Time."),
            ],
            ..MadeUpRun::default()
        };
        run.environment.driver_info = driver.to_owned();
        let case = run.case(case_id("filling", "a", &[]));
        case.figure("draws", figures[0]);
        case.figure("filled_px", figures[1]);
        case.timed("fill_cpu_ms", &[1.0, 2.0]);
        let path = place.join(name);
        std::fs::create_dir_all(&path).expect("a folder");
        run.write(&path).expect("a run")
    }

    #[test]
    fn a_baseline_keeps_counters_and_no_time_and_is_found_by_its_driver() {
        let place = tempfile::tempdir().expect("a folder");
        let baselines = place.path().join("baselines");
        let run = run_on(place.path(), "run", "Mesa 25", [3.0, 500.0]);
        let missing = load_baseline(&run, &baselines, "main").expect_err("none yet");
        assert_eq!(missing.exit_code(), 4);
        save_baseline(&run, &baselines, "main").expect("saved");
        save_baseline(&run, &baselines, "main").expect("saved again");
        let loaded = load_baseline(&run, &baselines, "main").expect("there");
        assert_eq!(loaded.cases[0].value("draws"), Some(3.0));
        assert_eq!(loaded.cases[0].value("fill_cpu_ms"), None);
        let compare = |new: &Run| {
            let base = load_baseline(new, &baselines, "main").expect("there");
            let exact = compare_exactly(&base, new, &[]).expect("comparable");
            let verdict = verdict(&exact.findings, exact.compared.len());
            (verdict, exact.findings)
        };
        let same = run_on(place.path(), "same", "Mesa 25", [3.0, 500.0]);
        assert_eq!(compare(&same).0, Verdict::Pass);
        let more = run_on(place.path(), "more", "Mesa 25", [3.0, 501.0]);
        assert_eq!(compare(&more).0, Verdict::Regression);
        // On another driver pixels are not compared, and that is no pass.
        let other = run_on(place.path(), "other", "Mesa 26", [3.0, 501.0]);
        let (verdict, findings) = compare(&other);
        assert_eq!(verdict, Verdict::Inconclusive);
        assert_eq!(findings[0].severity, Severity::Unknown);
        let worse = run_on(place.path(), "worse", "Mesa 26", [4.0, 501.0]);
        assert_eq!(compare(&worse).0, Verdict::Regression);
    }

    #[test]
    fn names_that_lead_elsewhere_are_refused() {
        let place = tempfile::tempdir().expect("a folder");
        let run = run_on(place.path(), "run", "Mesa 25", [3.0, 500.0]);
        for name in ["", "..", "a/b", ".hidden"] {
            let error = save_baseline(&run, place.path(), name).expect_err(name);
            assert_eq!(error.exit_code(), 2);
        }
    }
}
