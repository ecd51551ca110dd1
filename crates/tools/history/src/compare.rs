// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two runs side by side: exact figures as the gate compares them, and times as advice.
//!
//! Two run folders are two jobs. Nothing pairs their times, so a difference may be the machine's, and no
//! verdict rests on it. Each case has its ratio with an interval over processes. Beside it stand what
//! identical work differed by within each run, and what all cases differ by together. Times of two kinds
//! of machines are not compared at all; [`by_device`](crate::by_device) sets those side by side.

use crate::primary::ranks;
use crate::rank::{Cuts, difference};
use crate::record::Machine;
use crate::threshold::{COVERAGE, FLOOR_PERCENT};
use crate::{HistoryError, Primary};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_gate::threshold::floor_ms;
use terrafill_gate::{Finding, Gate, GateReport, Rules, Severity};
use terrafill_results::{Case, Noise, Run, median, process_medians};

/// Two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// How cases ended, counters, bytes, errors and limits.
    #[serde(flatten)]
    pub exact: GateReport,
    /// Commit and machine of each side.
    pub sides: [SideFacts; 2],
    /// Times by study.
    pub times: Vec<StudyTimes>,
    /// Why times were not compared; empty where they were.
    pub without_times: String,
}

/// Of which commit and machine a run is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SideFacts {
    /// Its folder.
    pub path: String,
    /// Its commit.
    pub commit: String,
    /// Its machine in a line.
    pub machine: String,
    /// Its replicates.
    pub processes: u32,
}

/// Times of a study in two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StudyTimes {
    /// Which study.
    pub study: String,
    /// The metric that it is ranked by.
    pub metric: String,
    /// Its unit.
    pub unit: String,
    /// By how much identical work differed at most in each run, percent; absent without a pair.
    pub noise_percent: [Option<f64>; 2],
    /// Median ratio over all cases: what differs everywhere is rather the machine's.
    pub common_ratio: f64,
    /// By name.
    pub cases: Vec<CaseTimes>,
}

/// A case's time in two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseTimes {
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Median over the processes of the base.
    pub from: f64,
    /// Median over the processes of the new run.
    pub to: f64,
    /// New over base: the median over all pairs of processes.
    pub ratio: f64,
    /// Its 95 % interval; absent with fewer than four processes on a side.
    pub interval: Option<[f64; 2]>,
    /// What that says.
    pub standing: TimeStanding,
}

/// What a ratio of two jobs says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeStanding {
    /// Longer, beyond floors and noise.
    Slower,
    /// Shorter, beyond floors and noise.
    Faster,
    /// Beyond floors and noise, and its interval holds 1, or there is none.
    Inconclusive,
    /// Within the floors, or within what identical work differs by.
    Unchanged,
}

impl TimeStanding {
    /// In tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Slower => "slower",
            Self::Faster => "faster",
            Self::Inconclusive => "inconclusive",
            Self::Unchanged => "unchanged",
        }
    }
}

/// Compares two runs.
///
/// - `primary`: the metric that a study is ranked by
///
/// # Errors
/// [`HistoryError::Compare`] for runs of other options, sizes or builds, for a folder compared with
/// itself and for a copy.
pub fn compare(
    base: &Run,
    new: &Run,
    rules: &Rules<'_>,
    primary: Primary<'_>,
) -> Result<Comparison, HistoryError> {
    let names = [base, new].map(|run| run.path.display().to_string());
    let exact = GateReport::of_runs(names, base, new, rules)?;
    let machines = [base, new].map(|run| Machine::of(&run.environment));
    let differences = machines[0].differences(&machines[1]);
    let without_times = match differences.as_slice() {
        [] => String::new(),
        some => format!(
            "times of different machines are not compared (--by device sets them side by side): {}",
            some.join("; ")
        ),
    };
    let times = if differences.is_empty() {
        times(base, new, primary)
    } else {
        Vec::new()
    };
    Ok(Comparison {
        exact,
        sides: [base, new].map(|run| SideFacts {
            path: run.path.display().to_string(),
            commit: run.environment.commit.clone(),
            machine: Machine::of(&run.environment).label(),
            processes: run.plan.processes,
        }),
        times,
        without_times,
    })
}

fn times(base: &Run, new: &Run, primary: Primary<'_>) -> Vec<StudyTimes> {
    let studies: BTreeSet<&str> = new
        .cases
        .iter()
        .map(|case| case.id().study.as_str())
        .collect();
    let mut cuts = Cuts::default();
    let of = |study: &str| {
        let metric = ranks(new, study, primary)?;
        let noises = [base, new].map(|run| {
            let cases = run.cases.iter().filter(|case| case.id().study == study);
            Noise::of(cases, metric)
        });
        let max_noise = noises
            .iter()
            .flatten()
            .map(|noise| noise.max)
            .fold(0.0, f64::max);
        let unit = new
            .metric(metric)
            .map_or(String::new(), |row| row.unit.clone());
        let floor = if unit == "ms" {
            floor_ms(new.clock())
        } else {
            0.0
        };
        let old: BTreeMap<String, &Case> = base
            .of_study(study)
            .filter(|case| case.counts() && !case.is_repeat())
            .map(|case| (case.id().key(), case))
            .collect();
        let cases = new
            .of_study(study)
            .filter(|case| case.counts() && !case.is_repeat());
        let cases = cases.filter_map(|case| {
            let key = case.id().key();
            case_times(
                key.clone(),
                old.get(&key)?,
                case,
                metric,
                [max_noise, floor],
                &mut cuts,
            )
        });
        let mut cases: Vec<CaseTimes> = cases.collect();
        cases.sort_by(|a, b| a.case.cmp(&b.case));
        let logs: Vec<f64> = cases.iter().map(|case| case.ratio.ln()).collect();
        Some(StudyTimes {
            study: study.to_owned(),
            metric: metric.to_owned(),
            unit,
            noise_percent: noises.map(|n| n.map(|n| 100.0 * (n.max_factor() - 1.0))),
            common_ratio: median(&logs)?.exp(),
            cases,
        })
    };
    studies.into_iter().filter_map(of).collect()
}

fn case_times(
    key: String,
    base: &Case,
    new: &Case,
    metric: &str,
    [noise, floor]: [f64; 2],
    cuts: &mut Cuts,
) -> Option<CaseTimes> {
    let [before, after] = [base, new].map(|case| {
        let medians = process_medians(case, metric).into_values();
        medians.map(f64::ln).collect::<Vec<f64>>()
    });
    let (shift, interval) = difference(&before, &after, COVERAGE, cuts)?;
    let [from, to] = [median(&before)?.exp(), median(&after)?.exp()];
    let is_small = shift.abs() < (FLOOR_PERCENT / 100.0).ln_1p()
        || shift.abs() <= noise
        || (to - from).abs() < floor;
    let standing = match interval {
        _ if is_small => TimeStanding::Unchanged,
        Some([low, _]) if low > 0.0 => TimeStanding::Slower,
        Some([_, high]) if high < 0.0 => TimeStanding::Faster,
        _ => TimeStanding::Inconclusive,
    };
    Some(CaseTimes {
        case: key,
        from,
        to,
        ratio: shift.exp(),
        interval: interval.map(|ends| ends.map(f64::exp)),
        standing,
    })
}

impl Comparison {
    /// Exact differences of one severity that are about a figure, or about whether there is a result.
    pub fn findings(&self, severity: Severity, is_status: bool) -> impl Iterator<Item = &Finding> {
        let all = self.exact.of(severity);
        all.filter(move |finding| (finding.gate == Gate::Status) == is_status)
    }

    /// Cases of a standing over all studies, those that moved furthest first.
    #[must_use]
    pub fn standing(&self, standing: TimeStanding) -> Vec<(&StudyTimes, &CaseTimes)> {
        let all = self
            .times
            .iter()
            .flat_map(|of| of.cases.iter().map(move |case| (of, case)));
        let mut found: Vec<_> = all.filter(|(_, case)| case.standing == standing).collect();
        found.sort_by(|(_, a), (_, b)| b.ratio.ln().abs().total_cmp(&a.ratio.ln().abs()));
        found
    }

    /// Cases that nothing was found of, exact or in times.
    #[must_use]
    pub fn unchanged(&self) -> Vec<&str> {
        let moved: BTreeSet<&str> = self
            .times
            .iter()
            .flat_map(|of| &of.cases)
            .filter(|case| case.standing != TimeStanding::Unchanged)
            .map(|case| case.case.as_str())
            .chain(
                self.exact
                    .findings
                    .iter()
                    .map(|finding| finding.case.as_str()),
            )
            .collect();
        let compared = self.exact.compared.iter().map(String::as_str);
        compared.filter(|case| !moved.contains(case)).collect()
    }

    /// What times say, a sentence each.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        if !self.without_times.is_empty() {
            return vec![self.without_times.clone()];
        }
        if self.times.is_empty() {
            return vec!["no time was measured in both runs".to_owned()];
        }
        let noise =
            |percent: Option<f64>| percent.map_or("unknown".to_owned(), |p| format!("{p:.1} %"));
        let of = |times: &StudyTimes| {
            let count = |standing| {
                times
                    .cases
                    .iter()
                    .filter(|case| case.standing == standing)
                    .count()
            };
            let [base, new] = times.noise_percent.map(noise);
            format!(
                "{}, {}: {} slower, {} faster, {} inconclusive, {} unchanged; all cases together × \
                 {:.3}; identical work differed by up to {base} in the base and {new} in the new run",
                times.study,
                times.metric,
                count(TimeStanding::Slower),
                count(TimeStanding::Faster),
                count(TimeStanding::Inconclusive),
                count(TimeStanding::Unchanged),
                times.common_ratio
            )
        };
        let mut lines: Vec<String> = self.times.iter().map(of).collect();
        let has_none = |of: &&StudyTimes| of.cases.iter().all(|case| case.interval.is_none());
        if self.times.iter().any(|of| has_none(&of)) {
            lines.push("fewer than four processes on a side give no interval".to_owned());
        }
        lines.push(
            "times are of two jobs, so they are advice; `terrafill gate` runs both by turns"
                .to_owned(),
        );
        lines
    }
}

#[cfg(test)]
mod tests;
