// SPDX-License-Identifier: MIT OR Apache-2.0
//! The gates without statistics: how cases ended, counters, bytes and errors of two runs, compared bit
//! by bit and in both directions, and committed limits.
//!
//! A case of the base that is gone, a figure that is gone, a figure that is no number and a figure
//! that got better all fail until they are blessed. What two drivers may count differently is compared
//! only where both runs used one driver.

use crate::{Finding, Gate, GateError, Limit, Severity};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use terrafill_results::{Case, Direction, Kind, MetricRow, Numbered, Outcome, Run, RunEnvironment};

/// What the exact gates found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exact {
    /// Differences.
    pub findings: Vec<Finding>,
    /// Cases of which at least one figure was compared.
    pub compared: BTreeSet<String>,
    /// Figures compared over all cases.
    pub figures: usize,
    /// Cases that neither run could run, with the reason.
    pub skipped: Vec<(String, String)>,
    /// Limits of the user's own that are about no figure of either run, in words.
    pub unmatched_limits: Vec<String>,
}

/// Compares two runs. repeats are left out: they repeat the work of other cases.
///
/// # Errors
/// [`GateError::BadInput`] for runs of other options, sizes or builds, for a folder compared with itself
/// and for a copy of a run.
pub fn compare_exactly(base: &Run, new: &Run, limits: &[Limit]) -> Result<Exact, GateError> {
    refuse_what_cannot_be_compared(base, new)?;
    let mut comparison = Comparison {
        is_same_driver: same_driver(&base.environment, &new.environment),
        kinds: kinds(base, new),
        limits,
        exact: Exact::default(),
    };
    let cases = by_key(base);
    let others = by_key(new);
    let keys: BTreeSet<&String> = cases.keys().chain(others.keys()).collect();
    for key in keys {
        comparison.compare(cases.get(key).copied(), others.get(key).copied());
    }
    comparison.exact.unmatched_limits = unmatched(limits, [&cases, &others]);
    if !comparison.is_same_driver && !comparison.exact.compared.is_empty() {
        let driver = |of: &RunEnvironment| format!("{}, {}", of.gpu, of.driver_info);
        comparison.exact.findings.push(Finding {
            metric: "driver".to_owned(),
            from: driver(&base.environment),
            to: driver(&new.environment),
            ..Finding::of_all_cases(
                Gate::Status,
                "pixels, pipeline statistics and errors were not compared",
            )
        });
    }
    Ok(comparison.exact)
}

/// Whether two runs used one device and driver, so that what a driver counts may be compared.
#[must_use]
pub fn same_driver(a: &RunEnvironment, b: &RunEnvironment) -> bool {
    driver_fingerprint(a) == driver_fingerprint(b)
}

/// Device and driver as a folder's name: no host, no clock rate.
#[must_use]
pub fn driver_fingerprint(of: &RunEnvironment) -> String {
    let text = format!(
        "{} {:04x} {:04x} {} {}",
        of.gpu, of.vendor_id, of.device_id, of.driver, of.driver_info
    );
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<String> = words
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    words.join("-")
}

/// Options that change how often things are measured, and no figure.
const FREE_OPTIONS: [&str; 4] = ["processes=", "samples=", "seed=", "frames="];

fn refuse_what_cannot_be_compared(base: &Run, new: &Run) -> Result<(), GateError> {
    let places = [&base.path, &new.path];
    let [a, b] = places.map(|path| path.canonicalize().unwrap_or_else(|_| path.clone()));
    if a == b {
        let message = format!("base and new are one folder: {}", a.display());
        return Err(GateError::BadInput(message));
    }
    if is_copy(base, new) {
        let message = format!(
            "{} and {} hold the same times to the last bit: one is a copy of the other",
            a.display(),
            b.display()
        );
        return Err(GateError::BadInput(message));
    }
    let options = |run: &Run| -> Vec<String> {
        let is_free = |option: &&String| !FREE_OPTIONS.iter().any(|key| option.starts_with(key));
        let options = run.environment.options.iter().filter(is_free);
        options.cloned().collect()
    };
    let of = |run: &Run| {
        let environment = &run.environment;
        [
            ("options", options(run).join(" ")),
            (
                "image size",
                format!("{}x{}", environment.width, environment.height),
            ),
            ("build", environment.profile.clone()),
        ]
    };
    for ((what, base), (_, new)) in of(base).into_iter().zip(of(new)) {
        if base != new {
            return Err(GateError::BadInput(format!(
                "{what}: found {new:?} in the new run, expected {base:?} as in the base"
            )));
        }
    }
    Ok(())
}

/// Whether two runs hold times, and the very same ones.
fn is_copy(base: &Run, new: &Run) -> bool {
    let times = |run: &Run| -> Vec<u64> {
        let times = run
            .metrics
            .iter()
            .filter(|metric| metric.kind == Kind::Time);
        let times: BTreeSet<&str> = times.map(|metric| metric.name.as_str()).collect();
        let figures = run.cases.iter().flat_map(Case::figures);
        let of_time = figures.filter(|(metric, _)| times.contains(&***metric));
        let values = of_time.flat_map(|(_, samples)| samples.values().flat_map(Numbered::values));
        values.map(|value| value.to_bits()).collect()
    };
    let times_of_base = times(base);
    !times_of_base.is_empty() && times_of_base == times(new)
}

fn by_key(run: &Run) -> BTreeMap<String, &Case> {
    let cases = run.cases.iter().filter(|case| !case.is_repeat());
    cases.map(|case| (case.id().key(), case)).collect()
}

/// A limit that is about nothing guards nothing: a misspelt one must not pass in silence.
fn unmatched(limits: &[Limit], runs: [&BTreeMap<String, &Case>; 2]) -> Vec<String> {
    let is_about_something = |limit: &Limit| {
        let mut cases = runs.into_iter().flatten();
        cases.any(|(key, case)| {
            case.figures()
                .keys()
                .any(|metric| limit.covers(key, metric))
        })
    };
    let own = limits.iter().filter(|limit| !limit.is_shipped);
    own.filter(|limit| !is_about_something(limit))
        .map(|Limit { case, metric, .. }| format!("case {case:?}, metric {metric:?}"))
        .collect()
}

/// Declarations by name; the new run's where both declare.
fn kinds(base: &Run, new: &Run) -> BTreeMap<String, MetricRow> {
    let all = base.metrics.iter().chain(&new.metrics);
    all.map(|row| (row.name.clone(), row.clone())).collect()
}

struct Comparison<'a> {
    is_same_driver: bool,
    kinds: BTreeMap<String, MetricRow>,
    limits: &'a [Limit],
    exact: Exact,
}

impl Comparison<'_> {
    fn compare(&mut self, base: Option<&Case>, new: Option<&Case>) {
        let (base, new) = match (base, new) {
            (Some(base), Some(new)) => (base, new),
            (Some(base), None) => {
                let states = [base.outcome.name(), "absent"];
                return self.status(base, Severity::Worse, states, "not planned any more");
            }
            (None, new) => return new.into_iter().for_each(|case| self.new_case(case)),
        };
        if let Some((key, conditions)) = planned_otherwise(base, new) {
            let words = format!("another {key} under the same name: its work is not compared");
            self.status(new, Severity::Unknown, conditions, &words);
        }
        let states = [base, new].map(|case| case.outcome.name());
        let is_result = |case: &Case| {
            matches!(case.outcome, Outcome::Ok | Outcome::DriverFault)
                || case.outcome == Outcome::Wrong && case.planned.may_be_wrong
        };
        match (base.outcome, new.outcome) {
            (Outcome::Skipped, Outcome::Skipped) => self.skip(new),
            (_, Outcome::Missing) => self.status(new, Severity::Unknown, states, &new.reason),
            (Outcome::Missing, _) => self.status(new, Severity::Unknown, states, &base.reason),
            _ if !is_result(new) => self.status(new, Severity::Worse, states, &new.reason),
            _ if !is_result(base) => {
                self.status(new, Severity::Note, states, "nothing to compare with");
                self.limits(new);
            }
            (then, now) => {
                if then != now {
                    let (severity, words) = match (then, now) {
                        (Outcome::DriverFault, _) => (Severity::Note, "no fault of the driver now"),
                        (_, Outcome::DriverFault) => (Severity::Worse, new.reason.as_str()),
                        _ => (
                            Severity::Worse,
                            "its error is the question, and the answer changed",
                        ),
                    };
                    self.status(new, severity, states, words);
                }
                self.figures(base, new);
                self.limits(new);
            }
        }
    }

    fn skip(&mut self, case: &Case) {
        let skipped = (case.id().key(), case.reason.clone());
        self.exact.skipped.push(skipped);
    }

    fn new_case(&mut self, case: &Case) {
        let states = ["", case.outcome.name()];
        match case.outcome {
            Outcome::Skipped => self.skip(case),
            Outcome::Ok | Outcome::DriverFault => {
                let words = "nothing to compare with";
                self.status(case, Severity::Note, ["", "new case"], words);
            }
            Outcome::Missing => self.status(case, Severity::Unknown, states, &case.reason),
            Outcome::Wrong if case.planned.may_be_wrong => {}
            _ => self.status(case, Severity::Worse, states, &case.reason),
        }
        self.limits(case);
    }

    fn figures(&mut self, base: &Case, new: &Case) {
        let names: BTreeSet<&Arc<str>> =
            base.figures().keys().chain(new.figures().keys()).collect();
        for name in names {
            let Some(metric) = self.kinds.get(&**name).cloned() else {
                continue;
            };
            let can_differ = !self.is_same_driver && metric.kind.depends_on_driver();
            if !metric.kind.is_exact() || can_differ {
                continue;
            }
            let (from, to) = (values(base, name), values(new, name));
            let is_number = from.iter().chain(&to).all(|value| value.is_finite());
            if !from.is_empty() && !to.is_empty() {
                self.exact.figures += 1;
                self.exact.compared.insert(new.id().key());
            }
            let bits =
                |values: &[f64]| -> Vec<u64> { values.iter().map(|v| v.to_bits()).collect() };
            if bits(&from) == bits(&to) && is_number && from.len() <= 1 {
                continue;
            }
            let (severity, words) = difference(&metric, &from, &to);
            let gate = if metric.kind == Kind::Error {
                Gate::Errors
            } else {
                Gate::Counters
            };
            let [from, to] = [&from, &to].map(|values| text(values));
            self.push(new, name, gate, severity, [&from, &to], &words);
        }
    }

    fn limits(&mut self, case: &Case) {
        if case.outcome != Outcome::Ok {
            return;
        }
        let key = case.id().key();
        for limit in self.limits {
            for name in case.figures().keys().filter(|n| limit.covers(&key, n)) {
                for value in values(case, name) {
                    if let Some(words) = limit.objection(value) {
                        self.over_limit(case, name, &value.to_string(), &words);
                    }
                }
            }
        }
        let is_something = |value: &f64| value.is_finite() && *value != 0.0;
        let mut all = case.figures().keys();
        // A full-screen pass has times only, and a study of formulas no times.
        if !all.any(|name| all_values(case, name).iter().any(is_something)) {
            let words = "right, and every figure is 0 or absent: it measured nothing";
            self.over_limit(case, "liveness", "0", words);
        }
    }

    fn over_limit(&mut self, case: &Case, metric: &str, value: &str, words: &str) {
        let severity = Severity::Worse;
        self.push(case, metric, Gate::Limits, severity, ["", value], words);
    }

    fn status(&mut self, case: &Case, severity: Severity, states: [&str; 2], words: &str) {
        self.push(case, "status", Gate::Status, severity, states, words);
    }

    fn push(
        &mut self,
        case: &Case,
        metric: &str,
        gate: Gate,
        severity: Severity,
        [from, to]: [&str; 2],
        words: &str,
    ) {
        self.exact.findings.push(Finding {
            case: case.id().key(),
            conditions: case.id().conditions.clone(),
            metric: metric.to_owned(),
            gate,
            severity,
            from: from.to_owned(),
            to: to.to_owned(),
            words: words.to_owned(),
            ..Finding::default()
        });
    }
}

/// A condition that both cases of one name have, with two values: a change of the plan, which says nothing of the
/// work.
fn planned_otherwise<'a>(base: &'a Case, new: &'a Case) -> Option<(&'a str, [&'a str; 2])> {
    let mut conditions = base.id().conditions.iter();
    conditions.find_map(|(key, from)| {
        let to = new.id().conditions.get(key)?;
        (from != to).then_some((key.as_str(), [from.as_str(), to.as_str()]))
    })
}

/// Every distinct value of a metric, in order. A figure of the probe has one.
fn values(case: &Case, metric: &str) -> Vec<f64> {
    let mut all = all_values(case, metric);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| a.to_bits() == b.to_bits());
    all
}

fn all_values(case: &Case, metric: &str) -> Vec<f64> {
    let samples = case.samples(metric).into_iter().flat_map(Numbered::values);
    samples.flat_map(|of| of.values().copied()).collect()
}

fn text(values: &[f64]) -> String {
    if values.is_empty() {
        return "absent".to_owned();
    }
    let values: Vec<String> = values.iter().map(ToString::to_string).collect();
    values.join(" or ")
}

/// How two sets of values of an exact figure differ, which they do.
fn difference(metric: &MetricRow, from: &[f64], to: &[f64]) -> (Severity, String) {
    match (from, to) {
        ([], _) => (Severity::Note, "not counted before".to_owned()),
        (_, []) => (Severity::Worse, "not counted any more".to_owned()),
        ([from], [to]) if from.is_finite() && to.is_finite() => {
            let change = if *from == 0.0 {
                format!("by {}", to - from)
            } else {
                format!("{:+.4} %", 100.0 * (to / from - 1.0))
            };
            let is_better = match metric.better {
                Direction::Less => to < from,
                Direction::More => to > from,
                Direction::Neither => false,
            };
            if is_better {
                (Severity::Better, change)
            } else {
                (Severity::Worse, change)
            }
        }
        ([_], [_]) => (Severity::Worse, "not a number".to_owned()),
        _ => {
            let words = "differs within one run: such a figure is no counter";
            (Severity::Worse, words.to_owned())
        }
    }
}

#[cfg(test)]
mod tests;
