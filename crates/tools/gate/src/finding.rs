// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the gate found in one case, and the verdict over all of them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How a comparison ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Something was compared, and nothing differs that was not blessed.
    Pass,
    /// Something differs.
    Regression,
    /// Something is inconclusive.
    Inconclusive,
    /// Nothing was compared.
    #[default]
    NothingMeasured,
}

impl Verdict {
    /// The exit code of a command that ends with it.
    #[must_use]
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Pass => 0,
            Self::Regression => 1,
            Self::Inconclusive => 3,
            Self::NothingMeasured => 4,
        }
    }

    /// In capitals, for the first line.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Pass => "PASS",
            Self::Regression => "REGRESSION",
            Self::Inconclusive => "INCONCLUSIVE",
            Self::NothingMeasured => "NOTHING MEASURED",
        }
    }
}

/// What a finding does to the verdict.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Worse, wrong or gone.
    Worse,
    /// Better by a figure that must not change without a word: fails until it is blessed.
    Better,
    /// Inconclusive.
    #[default]
    Unknown,
    /// Worth a line, and no more.
    Note,
}

impl Severity {
    /// Heading of its list.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Self::Worse => "regressions",
            Self::Better => "changed for the better and not blessed",
            Self::Unknown => "inconclusive",
            Self::Note => "notes",
        }
    }
}

/// Which gate found it.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Gate {
    /// Whether the case ended as it did before.
    #[default]
    Status,
    /// Counters and bytes.
    Counters,
    /// Differences from the reference.
    Errors,
    /// Committed limits: liveness, steady state.
    Limits,
    /// Paired times.
    Time,
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Finding {
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Of the case, for the command that shows it.
    pub conditions: BTreeMap<String, String>,
    /// Metric, or `status`.
    pub metric: String,
    /// Which gate.
    pub gate: Gate,
    /// What it does to the verdict.
    pub severity: Severity,
    /// Value in the base, as text; empty where there is none.
    pub from: String,
    /// Value in the new version.
    pub to: String,
    /// How much and how sure, in words.
    pub words: String,
    /// Relative change in percent, of times.
    pub percent: Option<f64>,
    /// Why it is accepted, where a blessing covers it.
    pub blessed: Option<String>,
}

impl Finding {
    /// Of no single case, and inconclusive.
    pub(crate) fn of_all_cases(gate: Gate, words: &str) -> Self {
        Self {
            case: "(all cases)".to_owned(),
            gate,
            words: words.to_owned(),
            ..Self::default()
        }
    }

    /// Whether the verdict rests on it.
    #[must_use]
    pub fn counts(&self) -> bool {
        self.blessed.is_none() && self.severity != Severity::Note
    }

    /// `draws 134 → 268 (+100 %)`.
    #[must_use]
    pub fn sentence(&self) -> String {
        let values = match (self.from.as_str(), self.to.as_str()) {
            ("", "") => String::new(),
            ("", to) => format!(" {to}"),
            (from, to) => format!(" {from} → {to}"),
        };
        let words = if self.words.is_empty() {
            String::new()
        } else {
            format!(": {}", self.words)
        };
        format!("{}{values}{words}", self.metric)
    }

    /// The command that measures this case again; `None` without a scene.
    #[must_use]
    pub fn command(&self) -> Option<String> {
        let scene = self.conditions.get("scene").filter(|s| !s.is_empty())?;
        let study = self.case.split('/').next().unwrap_or_default();
        let technique = self.conditions.get("technique").filter(|t| !t.is_empty());
        let technique = technique.map_or(String::new(), |t| format!(" --technique {t}"));
        Some(format!(
            "terrafill bench {scene} --study {study}{technique} --out out/look"
        ))
    }
}

/// The verdict over all findings.
///
/// - `compared`: cases of which anything was compared; without one nothing passes
#[must_use]
pub fn verdict(findings: &[Finding], compared: usize) -> Verdict {
    let any = |severities: &[Severity]| {
        findings
            .iter()
            .any(|finding| finding.counts() && severities.contains(&finding.severity))
    };
    if any(&[Severity::Worse, Severity::Better]) {
        Verdict::Regression
    } else if compared == 0 {
        Verdict::NothingMeasured
    } else if any(&[Severity::Unknown]) {
        Verdict::Inconclusive
    } else {
        Verdict::Pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(severity: Severity, blessed: bool) -> Finding {
        Finding {
            severity,
            blessed: blessed.then(|| "meant".to_owned()),
            ..Finding::default()
        }
    }

    #[test]
    fn the_worst_finding_decides_and_nothing_compared_never_passes() {
        use Severity::{Better, Note, Unknown, Worse};
        type Row<'a> = (&'a [(Severity, bool)], usize, Verdict);
        let cases: [Row<'_>; 9] = [
            (&[], 3, Verdict::Pass),
            (&[], 0, Verdict::NothingMeasured),
            (&[(Note, false)], 0, Verdict::NothingMeasured),
            (&[(Note, false)], 1, Verdict::Pass),
            (&[(Unknown, false)], 1, Verdict::Inconclusive),
            (&[(Unknown, false), (Better, false)], 1, Verdict::Regression),
            (&[(Worse, false)], 0, Verdict::Regression),
            (&[(Worse, true), (Better, true)], 1, Verdict::Pass),
            (&[(Worse, true)], 0, Verdict::NothingMeasured),
        ];
        for (findings, compared, expected) in cases {
            let findings: Vec<Finding> = findings.iter().map(|&(s, b)| finding(s, b)).collect();
            assert_eq!(verdict(&findings, compared), expected, "{findings:?}");
        }
        let codes = [
            Verdict::Pass,
            Verdict::Regression,
            Verdict::Inconclusive,
            Verdict::NothingMeasured,
        ];
        assert_eq!(codes.map(Verdict::exit_code), [0, 1, 3, 4]);
    }
}
