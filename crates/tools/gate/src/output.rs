// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report of a gate for people, as one screen of text, and for machines: JSON and GitHub annotations.
//! The page is in `page`, JUnit in `junit`.

use crate::threshold::MAX_ANNOTATIONS;
use crate::{
    Finding, GATE_SCHEMA, Gate, GateError, GateReport, Severity, Span, TimingOrder, Verdict,
};
use std::fmt::Write as _;
use std::path::Path;
use terrafill_results::Shard;

/// Findings of a severity on the first screen.
const MAX_LINES: usize = 6;

const SEVERITIES: [Severity; 4] = [
    Severity::Worse,
    Severity::Better,
    Severity::Unknown,
    Severity::Note,
];

/// What the gate says on a terminal.
#[must_use]
pub fn text(report: &GateReport) -> String {
    let mut text = format!(
        "{} (exit {}): {}\n  base {} · new {}\n  {} · {} · {:.0} s\n",
        title(report),
        report.exit_code,
        headline(report),
        report.base,
        report.new,
        report.device,
        report.clock,
        report.elapsed_s,
    );
    for line in scope(report) {
        let _ = writeln!(text, "  {line}");
    }
    for severity in SEVERITIES {
        let findings: Vec<&Finding> = report.of(severity).collect();
        if findings.is_empty() {
            continue;
        }
        let _ = writeln!(text, "\n{} ({}):", severity.heading(), findings.len());
        for finding in findings.iter().take(MAX_LINES) {
            let _ = writeln!(text, "  {}\n    {}", finding.case, finding.sentence());
        }
        rest(&mut text, findings.len());
    }
    let blessed: Vec<_> = blessed(report).collect();
    if !blessed.is_empty() {
        let _ = writeln!(text, "\nblessed ({}):", blessed.len());
    }
    for (finding, reason) in blessed.iter().take(MAX_LINES) {
        let sentence = finding.sentence();
        let _ = writeln!(text, "  {}\n    {sentence}; {reason}", finding.case);
    }
    rest(&mut text, blessed.len());
    for idle in report.idle_blessings.iter().take(MAX_LINES) {
        let _ = writeln!(text, "blessing {idle}");
    }
    rest(&mut text, report.idle_blessings.len());
    if report.verdict != Verdict::Pass {
        for command in commands(report) {
            let _ = writeln!(text, "see: {command}");
        }
    }
    text
}

/// Findings that are accepted, with the reason.
pub(crate) fn blessed(report: &GateReport) -> impl Iterator<Item = (&Finding, &str)> {
    let findings = report.findings.iter();
    findings.filter_map(|finding| Some((finding, finding.blessed.as_deref()?)))
}

/// Says how many of so many are not shown.
fn rest(text: &mut String, count: usize) {
    if count > MAX_LINES {
        let _ = writeln!(text, "  … and {} more in gate.json", count - MAX_LINES);
    }
}

/// The verdict in capitals. What is only better fails until it is blessed, and is no regression.
pub(crate) fn title(report: &GateReport) -> &'static str {
    let is_worse = report.of(Severity::Worse).next().is_some();
    match report.verdict {
        Verdict::Regression if !is_worse => "FASTER, NOT BLESSED",
        verdict => verdict.title(),
    }
}

/// Whether it is a time that is shorter.
pub(crate) fn is_faster(finding: &&Finding) -> bool {
    finding.gate == Gate::Time && finding.percent.is_some_and(|percent| percent < 0.0)
}

pub(crate) fn headline(report: &GateReport) -> String {
    let count = |severity| report.of(severity).count();
    let (worse, better) = (count(Severity::Worse), count(Severity::Better));
    match report.verdict {
        Verdict::Pass => match report.of(Severity::Note).filter(is_faster).count() {
            0 => "nothing differs that counts".to_owned(),
            faster => format!("nothing differs for the worse; {faster} times are shorter"),
        },
        Verdict::Regression => match (worse, better) {
            (worse, 0) => format!("{worse} differences for the worse"),
            (0, better) => format!("{better} differences for the better, to be blessed"),
            (worse, better) => {
                format!("{worse} differences for the worse, {better} for the better")
            }
        },
        Verdict::Inconclusive => format!("{} inconclusive", count(Severity::Unknown)),
        Verdict::NothingMeasured => "no case was compared".to_owned(),
    }
}

/// What was compared, and how sure it is.
pub(crate) fn scope(report: &GateReport) -> Vec<String> {
    let part = report.part.as_ref().map(|part| {
        let Shard { index, count } = part.shard;
        format!(
            "shard {index}/{count} of a gate: {}",
            part.scenes.join(", ")
        )
    });
    let mut lines: Vec<String> = part.into_iter().collect();
    lines.push(format!(
        "{} figures of {} cases compared exactly; {} cases ran on neither side",
        report.figures,
        report.compared.len(),
        report.skipped.len()
    ));
    match &report.time {
        None => lines.push("times were not compared".to_owned()),
        Some(time) => {
            let frames = || time.cases.iter().filter(|case| case.span == Span::Frame);
            let mut line = format!(
                "{} cases timed in {} blocks",
                frames().count(),
                time.screen.len()
            );
            if time.on_one_core {
                line += ", each on one core";
            }
            if !time.confirm.is_empty() {
                let decided: Vec<usize> = frames()
                    .filter(|c| c.interval_percent.is_some())
                    .map(|c| c.blocks)
                    .collect();
                let least = decided.iter().min().copied().unwrap_or(0);
                let _ = write!(
                    line,
                    ", {} of them again in {least} fresh ones",
                    decided.len()
                );
                let on = decided.iter().filter(|blocks| **blocks > least).count();
                if on > 0 {
                    let _ = write!(line, ", {on} in up to {}", time.confirm.len());
                }
            }
            if let Some(null) = report.null_percent() {
                let _ = write!(line, "; base against base differed by up to {null:.1} %");
            }
            lines.push(line);
            if let TimingOrder::Turns { why } = &time.way {
                lines.push(format!(
                    "whole processes by turns, not frames in lock-step, so noise weighs more: {why}"
                ));
            }
        }
    }
    lines
}

/// How to see the first finding, and everything.
pub(crate) fn commands(report: &GateReport) -> Vec<String> {
    let counted = report.findings.iter().find(|finding| finding.counts());
    let first = counted.and_then(Finding::command);
    let see = Some(report.see.clone()).filter(|see| !see.is_empty());
    first.into_iter().chain(see).collect()
}

/// Lines that GitHub shows beside a step: the worst findings, as many as it shows.
#[must_use]
pub fn annotations(report: &GateReport) -> Vec<String> {
    let counted: Vec<&Finding> = report.findings.iter().filter(|f| f.counts()).collect();
    let shown = if counted.len() > MAX_ANNOTATIONS {
        MAX_ANNOTATIONS - 1
    } else {
        counted.len()
    };
    let escape = |text: &str| {
        text.replace('%', "%25")
            .replace('\n', "%0A")
            .replace('\r', "%0D")
    };
    let property = |text: &str| escape(text).replace(':', "%3A").replace(',', "%2C");
    let mut lines: Vec<String> = counted[..shown]
        .iter()
        .map(|finding| {
            let level = match finding.severity {
                Severity::Worse | Severity::Better => "error",
                Severity::Unknown | Severity::Note => "warning",
            };
            let (case, sentence) = (property(&finding.case), escape(&finding.sentence()));
            format!("::{level} title={case}::{sentence}")
        })
        .collect();
    if shown < counted.len() {
        let more = counted.len() - shown;
        lines.push(format!(
            "::error title=gate::{more} more findings in the summary"
        ));
    }
    lines
}

/// Reads `gate.json`.
///
/// # Errors
/// [`GateError::Io`]; [`GateError::BadInput`] for another version or what is no report.
pub fn read_json(path: &Path) -> Result<GateReport, GateError> {
    let text = std::fs::read_to_string(path).map_err(GateError::io(path))?;
    let wrong = |message: String| GateError::BadInput(format!("{}: {message}", path.display()));
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let schema = &value["schema"];
    if *schema != GATE_SCHEMA {
        return Err(wrong(format!(
            "schema: found {schema}, expected {GATE_SCHEMA}"
        )));
    }
    serde_json::from_value(value).map_err(|error| wrong(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up_report::{finding, report};
    use crate::write_files;

    #[test]
    fn a_screen_says_what_how_much_and_where_to_look() {
        let worse = report(vec![finding("filling/a", Severity::Worse, Gate::Counters)]);
        let page = text(&worse);
        for words in [
            "REGRESSION (exit 1): 1 differences for the worse",
            "filling/a\n    draws 3 → 6: +100 %",
            "see: terrafill bench california --study filling --technique vertex",
            "blessing unused: filling/z",
        ] {
            assert!(page.contains(words), "{words:?} is not in:\n{page}");
        }
        let pass = text(&report(Vec::new()));
        assert!(
            pass.starts_with("PASS (exit 0)") && !pass.contains("see:"),
            "{pass}"
        );
        let many = (0..50).map(|_| finding("filling/a", Severity::Worse, Gate::Counters));
        let page = text(&report(many.collect()));
        assert!(page.lines().count() <= 24, "{page}");
        assert!(page.contains("… and 44 more"), "{page}");
    }

    #[test]
    fn annotations_stay_within_what_is_shown_and_escape() {
        let of = |count: usize| {
            let findings = (0..count).map(|_| finding("filling/a:b", Severity::Worse, Gate::Time));
            annotations(&report(findings.collect()))
        };
        assert_eq!(
            of(1),
            ["::error title=filling/a%3Ab::draws 3 → 6: +100 %25, a | b"]
        );
        assert_eq!((of(10).len(), of(11).len(), of(500).len()), (10, 10, 10));
        assert!(of(11)[9].contains("2 more findings"), "{:?}", of(11));
        let mut blessed = finding("filling/a", Severity::Worse, Gate::Counters);
        blessed.blessed = Some("meant".to_owned());
        assert!(annotations(&report(vec![blessed])).is_empty());
    }

    #[test]
    fn the_files_come_back_as_they_were() {
        let place = tempfile::tempdir().expect("a folder");
        let written = report(vec![finding("filling/a", Severity::Worse, Gate::Counters)]);
        write_files(&written, place.path()).expect("written");
        let path = place.path().join("gate.json");
        assert_eq!(read_json(&path).expect("read"), written);
        let text = std::fs::read_to_string(&path).expect("read");
        std::fs::write(&path, text.replace("\"schema\": 3", "\"schema\": 9")).expect("written");
        let error = read_json(&path).expect_err("another version").to_string();
        assert!(error.contains("found 9, expected 3"), "{error}");
    }
}
