// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blessings: differences that somebody accepted, with a reason, in a file that is reviewed.
//!
//! A blessing names case, metric and *both* values, so that it covers one change and no later one. Of a
//! time it names the largest change in percent. One that covers nothing is reported.

use crate::{Finding, Gate, GateError, table};
use serde::{Deserialize, Serialize};
use std::path::Path;

const COLUMNS: [&str; 5] = ["case", "metric", "from", "to", "reason"];

/// What `from` holds of a time.
const TIME: &str = "time";

/// One accepted difference.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Blessing {
    /// Key of the case.
    pub case: String,
    /// Metric, or `status`.
    pub metric: String,
    /// Value before; `time` for a time.
    pub from: String,
    /// Value after; of a time the largest change that is accepted, `+12%`.
    pub to: String,
    /// Why it is accepted.
    pub reason: String,
}

impl Blessing {
    /// That accepts this finding, and of a time half as much again: the next run finds another value.
    #[must_use]
    pub fn of(finding: &Finding, reason: &str) -> Self {
        let (from, to) = match (finding.gate, finding.percent) {
            (Gate::Time, Some(percent)) => {
                let bound = (1.5 * percent.abs()).ceil() * percent.signum();
                (TIME.to_owned(), format!("{bound:+}%"))
            }
            _ => (finding.from.clone(), finding.to.clone()),
        };
        Self {
            case: finding.case.clone(),
            metric: finding.metric.clone(),
            from,
            to,
            reason: reason.to_owned(),
        }
    }

    fn is_about(&self, finding: &Finding) -> bool {
        self.case == finding.case && self.metric == finding.metric
    }

    fn covers(&self, finding: &Finding) -> bool {
        if !self.is_about(finding) {
            return false;
        }
        if finding.gate != Gate::Time {
            return self.from == finding.from && self.to == finding.to;
        }
        // A time that is inconclusive has no change that could be accepted.
        let bound = self.to.strip_suffix('%').and_then(|to| to.parse().ok());
        let bound: Option<f64> = bound.filter(|_| self.from == TIME);
        bound.zip(finding.percent).is_some_and(|(bound, percent)| {
            percent.abs() <= bound.abs() && percent.signum().total_cmp(&bound.signum()).is_eq()
        })
    }
}

/// Marks the findings that blessings cover. Returns a sentence for each blessing that covers none.
#[must_use]
pub fn apply(blessings: &[Blessing], findings: &mut [Finding]) -> Vec<String> {
    let mut idle = Vec::new();
    for blessing in blessings {
        let mut is_used = false;
        for finding in findings
            .iter_mut()
            .filter(|finding| blessing.covers(finding))
        {
            finding.blessed = Some(blessing.reason.clone());
            is_used = true;
        }
        if !is_used {
            let about = findings.iter().find(|finding| blessing.is_about(finding));
            let Blessing {
                case,
                metric,
                from,
                to,
                ..
            } = blessing;
            idle.push(match about {
                Some(found) => format!(
                    "stale: {case}, {metric} {from} → {to} is blessed, found {}",
                    found.sentence()
                ),
                None => format!("unused: {case}, {metric} {from} → {to}: no such difference"),
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
    let same = |a: &Blessing, b: &Blessing| a.case == b.case && a.metric == b.metric;
    all.retain(|old| !new.iter().any(|new| same(old, new)));
    all.extend(new.iter().cloned());
    all.sort_by(|a, b| (&a.case, &a.metric).cmp(&(&b.case, &b.metric)));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let malformed = |error: csv::Error| GateError::BadInput(error.to_string());
    for blessing in &all {
        writer.serialize(blessing).map_err(malformed)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| GateError::BadInput(error.to_string()))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(GateError::io(folder))?;
    }
    std::fs::write(path, bytes).map_err(GateError::io(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Severity, Verdict, verdict};
    use std::collections::BTreeMap;

    fn finding(gate: Gate, from: &str, to: &str, percent: Option<f64>) -> Finding {
        Finding {
            case: "filling/a".to_owned(),
            conditions: BTreeMap::new(),
            metric: "draws".to_owned(),
            gate,
            severity: Severity::Worse,
            from: from.to_owned(),
            to: to.to_owned(),
            words: String::new(),
            percent,
            blessed: None,
        }
    }

    #[test]
    fn a_blessing_covers_its_change_and_no_other() {
        let change = finding(Gate::Counters, "3", "6", None);
        let blessing = Blessing::of(&change, "two caps are drawn");
        let mut findings = [change.clone()];
        assert!(apply(std::slice::from_ref(&blessing), &mut findings).is_empty());
        assert_eq!(findings[0].blessed.as_deref(), Some("two caps are drawn"));
        assert_eq!(verdict(&findings, 1), Verdict::Pass);
        // Twins: other values, the same ones the other way round, another case, nothing.
        for (from, to) in [("3", "7"), ("6", "3")] {
            let mut findings = [finding(Gate::Counters, from, to, None)];
            let idle = apply(std::slice::from_ref(&blessing), &mut findings);
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
        let idle = apply(std::slice::from_ref(&blessing), &mut other);
        assert!(idle[0].starts_with("unused"), "{idle:?}");
        assert_eq!(verdict(&other, 1), Verdict::Regression);
        assert_eq!(apply(&[blessing], &mut []).len(), 1);
    }

    #[test]
    fn a_blessed_time_has_a_bound_and_a_direction() {
        let blessing = Blessing::of(&finding(Gate::Time, "", "", Some(9.6)), "worth it");
        assert_eq!(
            (blessing.from.as_str(), blessing.to.as_str()),
            ("time", "+15%")
        );
        let is_blessed = |percent: Option<f64>| {
            let mut findings = [finding(Gate::Time, "", "", percent)];
            let _ = apply(std::slice::from_ref(&blessing), &mut findings);
            findings[0].blessed.is_some()
        };
        assert!(is_blessed(Some(11.0)) && is_blessed(Some(15.0)));
        for other in [Some(15.1), Some(-9.6), None, Some(f64::NAN)] {
            assert!(!is_blessed(other), "{other:?}");
        }
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
