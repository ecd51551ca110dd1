// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blessings: differences that somebody accepted, with a reason, in a file that is reviewed.
//!
//! A blessing names case, metric and *both* values, so that it covers one change and no later one. Of a
//! time it names the largest change in percent, and what it is a change from: the base's commit, or the base's
//! time where both programs are of one commit. Once the base moves on it covers nothing, or a blessed +8 % would
//! let the next +8 % pass. One that covers nothing is reported.

use crate::replace::replace;
use crate::{Finding, Gate, GateError, table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;

const COLUMNS: [&str; 5] = ["case", "metric", "from", "to", "reason"];

/// What `from` of a time begins with where a commit follows.
const COMMIT: char = '@';

/// By how much the base's time may be off the one that is blessed: what the gate does not call a change.
const MAX_BASE_RATIO: f64 = 1.03;

/// One accepted difference.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Blessing {
    /// Key of the case.
    pub case: String,
    /// Metric, or `status`.
    pub metric: String,
    /// Value before; of a time the base's commit, `@4e23c86…`, or its time, `12.310 ms`.
    pub from: String,
    /// Value after; of a time the largest change that is accepted, `+12%`.
    pub to: String,
    /// Why it is accepted.
    pub reason: String,
}

impl Blessing {
    /// That accepts this finding, and of a time half as much again: the next run finds another value. `None` of
    /// a time without a change that could be accepted.
    ///
    /// - `base`: commit that tells the base from the new program, see [`crate::GateReport::base_commit`]
    #[must_use]
    pub fn of(finding: &Finding, base: Option<&str>, reason: &str) -> Option<Self> {
        let (from, to) = if finding.gate == Gate::Time {
            let percent = finding.percent.filter(|percent| percent.is_finite())?;
            let bound = (1.5 * percent.abs()).ceil() * percent.signum();
            let from = match base {
                Some(commit) => format!("{COMMIT}{commit}"),
                None => finding.from.clone(),
            };
            (from, format!("{bound:+}%"))
        } else {
            (finding.from.clone(), finding.to.clone())
        };
        Some(Self {
            case: finding.case.clone(),
            metric: finding.metric.clone(),
            from,
            to,
            reason: reason.to_owned(),
        })
    }

    fn is_about(&self, finding: &Finding) -> bool {
        self.case == finding.case && self.metric == finding.metric
    }

    pub(crate) fn covers(&self, finding: &Finding, base: Option<&str>) -> bool {
        if !self.is_about(finding) {
            return false;
        }
        if finding.gate != Gate::Time {
            return self.from == finding.from && self.to == finding.to;
        }
        // A time that is inconclusive has no change that could be accepted.
        let bound = self.to.strip_suffix('%').and_then(|to| to.parse().ok());
        let bound: Option<f64> = bound.filter(|_| self.is_from(&finding.from, base));
        bound.zip(finding.percent).is_some_and(|(bound, percent)| {
            percent.abs() <= bound.abs() && percent.signum().total_cmp(&bound.signum()).is_eq()
        })
    }

    /// Whether it accepts changes from this base.
    fn is_from(&self, time: &str, base: Option<&str>) -> bool {
        if let Some(commit) = self.from.strip_prefix(COMMIT) {
            return base == Some(commit);
        }
        let ms = |text: &str| {
            text.strip_suffix(" ms")
                .and_then(|ms| ms.parse::<f64>().ok())
        };
        let ratio = ms(time)
            .zip(ms(&self.from))
            .map(|(found, blessed)| found / blessed);
        ratio.is_some_and(|ratio| (1.0 / MAX_BASE_RATIO..=MAX_BASE_RATIO).contains(&ratio))
    }

    fn sentence(&self) -> String {
        let Self {
            case,
            metric,
            from,
            to,
            ..
        } = self;
        format!("{case}, {metric} {from} → {to}")
    }
}

/// Marks the findings that blessings cover. Returns a sentence for each blessing that covers none.
///
/// - `base`: see [`Blessing::of`]
#[must_use]
pub fn apply(blessings: &[Blessing], findings: &mut [Finding], base: Option<&str>) -> Vec<String> {
    let mut idle = Vec::new();
    for blessing in blessings {
        let mut is_used = false;
        for finding in findings
            .iter_mut()
            .filter(|finding| blessing.covers(finding, base))
        {
            finding.blessed = Some(blessing.reason.clone());
            is_used = true;
        }
        if !is_used {
            let about = findings.iter().find(|finding| blessing.is_about(finding));
            let blessed = blessing.sentence();
            idle.push(match about {
                Some(found) if found.gate == Gate::Time && !blessing.is_from(&found.from, base) => {
                    let from =
                        base.map_or(found.from.clone(), |commit| format!("{COMMIT}{commit}"));
                    format!("ended: {blessed} is blessed, and the base is {from} now")
                }
                Some(found) => format!("stale: {blessed} is blessed, found {}", found.sentence()),
                None => format!("unused: {blessed}: no such difference"),
            });
        }
    }
    idle
}

/// Reads blessings; none where there is no file.
///
/// # Errors
/// [`GateError::Row`] for a wrong column or a blessing without a reason; [`GateError::Io`].
pub fn read_blessings(path: &Path) -> Result<Vec<Blessing>, GateError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path).map_err(GateError::io(path))?;
    table::parse(path, &text, &COLUMNS, |blessing: &Blessing| {
        table::check_reason(&blessing.reason)
    })
}

/// Adds blessings to a file, in place of earlier ones of the same case and metric; sorted, so that a
/// review sees what changed.
///
/// # Errors
/// As [`read_blessings`].
pub fn add_blessings(path: &Path, new: &[Blessing]) -> Result<(), GateError> {
    let mut all = read_blessings(path)?;
    let of = |blessing: &Blessing| (blessing.case.clone(), blessing.metric.clone());
    let named: BTreeSet<_> = new.iter().map(of).collect();
    all.retain(|old| !named.contains(&of(old)));
    all.extend(new.iter().cloned());
    all.sort_by(|a, b| (&a.case, &a.metric).cmp(&(&b.case, &b.metric)));
    write_blessings(path, &all)
}

/// Writes the whole file anew.
pub(crate) fn write_blessings(path: &Path, all: &[Blessing]) -> Result<(), GateError> {
    let malformed = |error: csv::Error| GateError::BadInput(error.to_string());
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer.write_record(COLUMNS).map_err(malformed)?;
    for blessing in all {
        writer.serialize(blessing).map_err(malformed)?;
    }
    let bytes = writer.into_inner();
    let bytes = bytes.map_err(|error| GateError::BadInput(error.to_string()))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(GateError::io(folder))?;
    }
    replace(path, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GateReport, Severity, Verdict, prune_blessings, verdict};

    fn finding(gate: Gate, from: &str, to: &str, percent: Option<f64>) -> Finding {
        Finding {
            case: "filling/a".to_owned(),
            metric: "draws".to_owned(),
            gate,
            severity: Severity::Worse,
            from: from.to_owned(),
            to: to.to_owned(),
            percent,
            ..Finding::default()
        }
    }

    fn blessed(finding: &Finding, base: Option<&str>) -> Blessing {
        Blessing::of(finding, base, "two caps are drawn").expect("a change")
    }

    #[test]
    fn a_blessing_covers_its_change_and_no_other() {
        let change = finding(Gate::Counters, "3", "6", None);
        let blessing = blessed(&change, None);
        let mut findings = [change.clone()];
        assert!(apply(std::slice::from_ref(&blessing), &mut findings, None).is_empty());
        assert_eq!(findings[0].blessed.as_deref(), Some("two caps are drawn"));
        assert_eq!(verdict(&findings, 1), Verdict::Pass);
        // Negative controls: other values, the same ones the other way round, another case, nothing.
        for (from, to) in [("3", "7"), ("6", "3")] {
            let mut findings = [finding(Gate::Counters, from, to, None)];
            let idle = apply(std::slice::from_ref(&blessing), &mut findings, None);
            assert!(
                idle[0].starts_with("stale: filling/a, draws 3 → 6"),
                "{idle:?}"
            );
            assert_eq!(verdict(&findings, 1), Verdict::Regression);
        }
        let mut other = [Finding {
            case: "filling/b".to_owned(),
            ..change
        }];
        let idle = apply(std::slice::from_ref(&blessing), &mut other, None);
        assert!(idle[0].starts_with("unused"), "{idle:?}");
        assert_eq!(verdict(&other, 1), Verdict::Regression);
        assert_eq!(apply(&[blessing], &mut [], None).len(), 1);
    }

    #[test]
    fn a_blessed_time_has_a_bound_a_direction_and_a_base() {
        let of = |percent| finding(Gate::Time, "12.310 ms", "13.580 ms", percent);
        let blessing = blessed(&of(Some(9.6)), Some("4e23c86"));
        let fields = (blessing.from.as_str(), blessing.to.as_str());
        assert_eq!(fields, ("@4e23c86", "+15%"));
        let is_blessed = |percent: Option<f64>, base| {
            let mut findings = [of(percent)];
            let idle = apply(std::slice::from_ref(&blessing), &mut findings, base);
            assert_eq!(idle.is_empty(), findings[0].blessed.is_some());
            findings[0].blessed.is_some()
        };
        let base = Some("4e23c86");
        assert!(is_blessed(Some(11.0), base) && is_blessed(Some(15.0), base));
        for other in [Some(15.1), Some(-9.6), None, Some(f64::NAN)] {
            assert!(!is_blessed(other, base), "{other:?}");
        }
        assert!(!is_blessed(Some(9.6), Some("abcdef0")) && !is_blessed(Some(9.6), None));
        // What is inconclusive has no change to accept.
        assert_eq!(Blessing::of(&of(None), base, "why"), None);
    }

    #[test]
    fn a_blessed_slow_down_does_not_cover_the_next_one() {
        let slower = |from: f64| {
            let to = format!("{:.3} ms", 1.08 * from);
            finding(Gate::Time, &format!("{from:.3} ms"), &to, Some(8.0))
        };
        // Two builds of one commit, and two commits.
        for [then, next] in [[None, None], [Some("4e23c86"), Some("abcdef0")]] {
            let blessing = blessed(&slower(10.0), then);
            let gate = |from, base| {
                let mut findings = [slower(from)];
                let idle = apply(std::slice::from_ref(&blessing), &mut findings, base);
                (verdict(&findings, 1).exit_code(), idle)
            };
            assert_eq!(gate(10.0, then).0, 0);
            // The same machine a little slower; then what was blessed is the base.
            assert_eq!(gate(10.2, then).0, 0);
            let (code, idle) = gate(10.8, next);
            assert_eq!(code, 1);
            assert!(idle[0].starts_with("ended: filling/a, draws"), "{idle:?}");
        }
        // One that was written before bases were named covers nothing.
        let old = Blessing {
            from: "time".to_owned(),
            ..blessed(&slower(10.0), None)
        };
        let mut findings = [slower(10.0)];
        assert_eq!(apply(&[old], &mut findings, None).len(), 1);
        assert_eq!(verdict(&findings, 1), Verdict::Regression);
    }

    #[test]
    fn what_covers_nothing_is_pruned_where_the_gate_looked() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("blessed.csv");
        let blessing = |case: &str, to: &str| Blessing {
            case: case.to_owned(),
            metric: "draws".to_owned(),
            from: "3".to_owned(),
            to: to.to_owned(),
            reason: "meant".to_owned(),
        };
        let cases = ["filling/a/globe/x", "filling/a/gone/x", "filling/b/globe/x"];
        let mut all = cases.map(|case| blessing(case, "6")).to_vec();
        all.push(blessing("filling/a/near/x", "+12%"));
        add_blessings(&path, &all).expect("written");
        let report = GateReport {
            compared: vec![cases[0].to_owned()],
            findings: vec![Finding {
                case: cases[0].to_owned(),
                ..finding(Gate::Counters, "3", "6", None)
            }],
            ..GateReport::default()
        };
        let pruned = prune_blessings(&path, &report).expect("pruned");
        assert_eq!(pruned, [blessing(cases[1], "6")]);
        // Another scene was not measured, and no time was.
        let left = read_blessings(&path).expect("read");
        let left: Vec<&str> = left.iter().map(|blessing| blessing.case.as_str()).collect();
        assert_eq!(left, [cases[0], "filling/a/near/x", cases[2]]);
        let timed = GateReport {
            time: Some(crate::TimeGate::default()),
            findings: Vec::new(),
            ..report
        };
        assert_eq!(prune_blessings(&path, &timed).expect("pruned").len(), 2);
        assert_eq!(read_blessings(&path).expect("read").len(), 1);
    }

    #[test]
    fn blessings_are_written_sorted_once_each_and_read_back() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("gate/blessed.csv");
        assert!(read_blessings(&path).expect("none").is_empty());
        let blessing = |case: &str, to: &str| Blessing {
            case: case.to_owned(),
            metric: "draws".to_owned(),
            from: "3".to_owned(),
            to: to.to_owned(),
            reason: "meant, \"really\"".to_owned(),
        };
        add_blessings(&path, &[blessing("b", "4"), blessing("a", "5")]).expect("written");
        add_blessings(&path, &[blessing("b", "6")]).expect("written");
        let read = read_blessings(&path).expect("read");
        assert_eq!(read, [blessing("a", "5"), blessing("b", "6")]);
        for text in ["case,metric\n", "case,metric,from,to,reason\na,b,1,2, \n"] {
            std::fs::write(&path, text).expect("written");
            assert!(read_blessings(&path).is_err(), "{text}");
        }
    }
}
