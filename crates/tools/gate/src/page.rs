// SPDX-License-Identifier: MIT OR Apache-2.0
//! The report of a gate as a page of Markdown: the comment of a pull request, and a step's summary.
//!
//! The verdict comes first, then the largest changes of times, which stand there even where nothing fails, then
//! what decides. A page that nobody reads to its end is no page, so it is short; `gate.json` has everything.

use crate::output::{blessed, commands, headline, is_faster, scope, title};
use crate::time::milliseconds;
use crate::{CaseTime, Finding, GateReport, Severity, Verdict};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The first line: whoever posts the page finds the comment by it that it put there before.
const MARK: &str = "<!-- terrafill gate -->";

/// Bytes of a page. A comment may have 65,536 characters.
const MAX_BYTES: usize = 20_000;

/// Changes of times in the table.
const MAX_CHANGES: usize = 10;

/// Rows of each other table.
const MAX_ROWS: usize = 15;

/// Characters of a sentence, and of a case's name.
const MAX_SENTENCE: usize = 240;
const MAX_NAME: usize = 72;

/// A page of at most 20 kB.
#[must_use]
pub fn markdown(report: &GateReport) -> String {
    let names = Names::of(report);
    let mut head = format!(
        "{MARK}\n## Gate: {}\n\n{}: `{}` against `{}`, on {}, by {}.\n\n",
        title(report),
        headline(report),
        report.new,
        report.base,
        report.device,
        report.clock
    );
    for line in scope(report) {
        let _ = writeln!(head, "- {line}");
    }
    let mut blocks = vec![head];
    let mut lists: Vec<(&str, Vec<&Finding>)> =
        [Severity::Worse, Severity::Better, Severity::Unknown]
            .map(|severity| (severity.heading(), report.of(severity).collect()))
            .to_vec();

    let (faster, notes): (Vec<_>, Vec<_>) = report.of(Severity::Note).partition(is_faster);
    lists.extend([("faster", faster), (Severity::Note.heading(), notes)]);
    for (heading, findings) in lists {
        let rows = findings
            .iter()
            .map(|finding| row(&names, finding, ""))
            .collect();
        blocks.extend(table(heading, "finding", rows));
    }
    let accepted = blessed(report).map(|(finding, reason)| row(&names, finding, reason));
    blocks.extend(table(
        "blessed",
        "finding, and why it is accepted",
        accepted.collect(),
    ));
    // Behind the verdict, and before what it rests on.
    blocks.insert(1, pictures(report, &names));
    blocks.insert(2, changes(report, &names));
    let mut idle: Vec<String> = report
        .idle_blessings
        .iter()
        .take(MAX_ROWS)
        .map(|words| format!("- blessing {}", short(words, MAX_SENTENCE)))
        .collect();
    if report.idle_blessings.len() > MAX_ROWS {
        idle.push(format!(
            "- {} more blessings cover nothing; `terrafill bless --prune` takes them out",
            report.idle_blessings.len() - MAX_ROWS
        ));
    }
    if !idle.is_empty() {
        blocks.push(format!("\n{}\n", idle.join("\n")));
    }
    if report.verdict != Verdict::Pass {
        blocks.extend(
            commands(report)
                .iter()
                .map(|command| format!("\n```sh\n{command}\n```\n")),
        );
    }
    let mut page = String::new();
    const REST: &str = "\nThe rest is in `gate.json`.\n";
    for block in blocks {
        if page.len() + block.len() + REST.len() > MAX_BYTES {
            page += REST;
            break;
        }
        page += &block;
    }
    page
}

/// What is wrong, beside what is right.
fn pictures(report: &GateReport, names: &Names) -> String {
    let mut text = String::new();
    for shown in &report.pictures {
        let what = shown.pictures.iter().map(|(what, _)| what.as_str());
        let images = shown
            .pictures
            .iter()
            .map(|(what, path)| match path.as_str() {
                "" => "–".to_owned(),
                path => format!("![{what}]({path})"),
            });
        let _ = write!(
            text,
            "\n`{}`\n\n| {} |\n|{}\n| {} |\n",
            names.short(&shown.case),
            what.collect::<Vec<_>>().join(" | "),
            "---|".repeat(shown.pictures.len()),
            images.collect::<Vec<_>>().join(" | ")
        );
    }
    text
}

/// The largest changes of times, each over the smallest that fails.
fn changes(report: &GateReport, names: &Names) -> String {
    let Some(time) = &report.time else {
        return String::new();
    };
    let mut cases: Vec<(f64, &CaseTime)> = time
        .cases
        .iter()
        .filter_map(|case| Some((case.of_floor?, case)))
        .collect();
    cases.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let rows = cases.iter().take(MAX_CHANGES).map(|(of_floor, case)| {
        let interval = case.interval_percent.map_or(String::new(), |[low, high]| {
            format!(" [{low:+.1} … {high:+.1}]")
        });
        format!(
            "| `{}` | {} | {} → {} | {:+.1} %{interval} | {of_floor:.2} | {} |\n",
            names.short(&case.case),
            case.span.name(),
            milliseconds(case.base_ms),
            milliseconds(case.new_ms),
            case.percent.unwrap_or_default(),
            case.split()
        )
    });
    let rows: String = rows.collect();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "\n### Largest changes of times\n\n| case | time of | base → new | change | ÷ its floor | where |\n|---|---|---|---|---|---|\n{rows}"
    )
}

fn row(names: &Names, finding: &Finding, reason: &str) -> String {
    let mut sentence = finding.sentence();
    if !reason.is_empty() {
        sentence += "; ";
        sentence += reason;
    }
    let sentence = short(&sentence.replace('\n', " "), MAX_SENTENCE).replace('|', "\\|");
    format!("| `{}` | {sentence} |\n", names.short(&finding.case))
}

/// A table of its first rows; `None` without any.
fn table(heading: &str, column: &str, rows: Vec<String>) -> Option<String> {
    if rows.is_empty() {
        return None;
    }
    let mut text = format!(
        "\n### {heading} ({})\n\n| case | {column} |\n|---|---|\n",
        rows.len()
    );
    text.extend(rows.iter().take(MAX_ROWS).map(String::as_str));
    if rows.len() > MAX_ROWS {
        let _ = writeln!(text, "\n{} more in `gate.json`.", rows.len() - MAX_ROWS);
    }
    Some(text)
}

/// Cases as the page calls them: without their study, where there is but one.
struct Names(Option<String>);

impl Names {
    fn of(report: &GateReport) -> Self {
        let study = |case: &str| case.split_once('/').map(|(study, _)| format!("{study}/"));
        let cases = report
            .compared
            .iter()
            .chain(report.findings.iter().map(|finding| &finding.case));
        let studies: BTreeSet<String> = cases.filter_map(|case| study(case)).collect();
        Self(studies.first().filter(|_| studies.len() == 1).cloned())
    }

    fn short(&self, case: &str) -> String {
        let study = self.0.as_deref().unwrap_or_default();
        short(case.strip_prefix(study).unwrap_or(case), MAX_NAME)
    }
}

/// At most so many characters: the middle of a longer text is left out, since names differ at both ends.
fn short(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let (start, end) = (most / 2, most - most / 2 - 1);
    let first: String = text.chars().take(start).collect();
    let last: String = text.chars().skip(count - end).collect();
    format!("{first}…{last}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up_report::{finding, report};
    use crate::{Floors, Gate, Pace, ShownCase, Span, Stage, TimeGate};
    use terrafill_results::Clock;

    fn timed(case: &str, span: Span, percent: f64) -> CaseTime {
        CaseTime {
            case: case.to_owned(),
            metric: "fill_cpu_ms".to_owned(),
            span,
            pace: Pace::Same,
            base_ms: Some(10.0),
            new_ms: Some(10.0 + 0.1 * percent),
            percent: Some(percent),
            stages: vec![Stage {
                metric: "stencil_gpu_ms".to_owned(),
                base_ms: 5.0,
                new_ms: 5.2,
            }],
            ..CaseTime::default()
        }
    }

    fn timed_by(floors: Floors, cases: Vec<CaseTime>) -> TimeGate {
        let mut time = TimeGate {
            cases,
            ..TimeGate::default()
        };
        time.measure_by(&floors);
        time
    }

    #[test]
    fn a_pass_shows_its_ten_largest_changes_with_their_stage() {
        let mut pass = report(Vec::new());
        let cases = (0..30).map(|at| {
            timed(
                &format!("filling/a/globe/{at:02}"),
                Span::Frame,
                0.05 * f64::from(at),
            )
        });
        let mut cases: Vec<CaseTime> = cases.collect();
        // 10 % of preparation are less than 1 % of a frame, by what fails.
        cases.push(timed("filling/a/globe/setup", Span::Preparation, 10.0));
        // Half of nothing.
        cases.push(CaseTime {
            base_ms: Some(0.002),
            ..timed("filling/a/globe/setup", Span::Planning, 50.0)
        });
        pass.time = Some(timed_by(Floors::new(Clock::ProcessCpu), cases));
        let page = markdown(&pass);
        assert!(
            page.starts_with(MARK) && page.contains("## Gate: PASS"),
            "{page}"
        );
        let rows: Vec<&str> = page
            .lines()
            .filter(|line| line.starts_with("| `a/globe/"))
            .collect();
        assert_eq!(rows.len(), 10, "{page}");
        assert_eq!(
            rows[0],
            "| `a/globe/29` | frame | 10.000 ms → 10.145 ms | +1.5 % | 0.49 | stencil +0.200 ms |"
        );
        assert!(rows.iter().all(|row| !row.contains("setup")), "{page}");
        // Negative control: without times there is no such table.
        assert!(!markdown(&report(Vec::new())).contains("Largest changes"));
    }

    #[test]
    fn changes_stand_by_how_near_they_are_to_the_floors_of_their_gate() {
        let order = |floors: Floors| {
            let mut pass = report(Vec::new());
            let setup = timed("filling/a/globe/setup", Span::Preparation, 28.0);
            let frame = timed("filling/a/globe/frame", Span::Frame, -2.7);
            pass.time = Some(timed_by(floors, vec![setup, frame]));
            let page = markdown(&pass);
            ["frame", "setup"].map(|name| page.find(&format!("| `a/globe/{name}`")))
        };
        let usual = Floors::new(Clock::ProcessCpu);
        let [frame, setup] = order(usual);
        assert!(
            frame.is_some() && frame < setup,
            "0.93 and 0.61 of the floors"
        );
        // Negative control: by a lower floor of preparation the same change is the nearest.
        let mut low = usual;
        low.preparation.percent = 20.0;
        let [frame, setup] = order(low);
        assert!(setup.is_some() && setup < frame);
    }

    #[test]
    fn a_wrong_picture_is_shown_beside_the_reference() {
        let mut wrong = report(vec![finding("filling/a", Severity::Worse, Gate::Status)]);
        assert!(!markdown(&wrong).contains("!["));
        let path = |what: &str| (what.to_owned(), format!("pictures/1-{what}.png"));
        wrong.pictures = vec![ShownCase {
            case: "filling/a".to_owned(),
            pictures: vec![path("reference"), path("difference")],
        }];
        let page = markdown(&wrong);
        let table = "`a`\n\n| reference | difference |\n|---|---|\n| ![reference](pictures/1-reference.png) | \
                     ![difference](pictures/1-difference.png) |\n";
        assert!(page.contains(table), "{page}");
    }

    #[test]
    fn what_is_only_better_is_no_regression() {
        let better = report(vec![finding("filling/a", Severity::Better, Gate::Counters)]);
        let page = markdown(&better);
        assert!(page.contains("## Gate: FASTER, NOT BLESSED"), "{page}");
        assert!(!page.to_lowercase().contains("regression"), "{page}");
        assert_eq!(better.exit_code, 1);
        let mut faster = finding("filling/a", Severity::Note, Gate::Time);
        faster.percent = Some(-8.0);
        let page = markdown(&report(vec![faster]));
        assert!(
            page.contains("## Gate: PASS") && page.contains("1 times are shorter"),
            "{page}"
        );
        assert!(page.contains("### faster (1)"), "{page}");
        // Negative control.
        let both =
            [Severity::Better, Severity::Worse].map(|s| finding("filling/a", s, Gate::Counters));
        assert!(markdown(&report(both.to_vec())).contains("## Gate: REGRESSION"));
    }

    #[test]
    fn a_page_stays_short_whatever_is_found_and_names_what_it_leaves_out() {
        let long = "x".repeat(200);
        let many = |severity, blessed: bool| {
            (0..800).map(move |at| {
                let mut finding = finding("", severity, Gate::Counters);
                finding.case = format!("filling/{at}/globe/{}", "y".repeat(100));
                finding.words = "ä".repeat(700);
                finding.blessed = blessed.then(|| "meant".repeat(90));
                finding
            })
        };
        let mut findings: Vec<Finding> = many(Severity::Worse, false).collect();
        findings.extend(many(Severity::Unknown, false));
        findings.extend(many(Severity::Better, false));
        findings.extend(many(Severity::Worse, true));
        let mut full = report(findings);
        full.idle_blessings = (0..800)
            .map(|at| format!("unused: filling/{at}/{long}, draws 1 → 2"))
            .collect();
        let page = markdown(&full);
        assert!(page.len() <= MAX_BYTES, "{} bytes", page.len());
        assert!(
            page.contains("more in `gate.json`") && page.contains("The rest is in"),
            "{page}"
        );
        // Old blessings alone leave room for the verdict and say how to be rid of them.
        full.findings.clear();
        let page = markdown(&full);
        assert!(page.len() < 6_000, "{} bytes", page.len());
        assert!(
            page.contains("785 more blessings") && page.contains("--prune"),
            "{page}"
        );
    }

    #[test]
    fn a_cell_keeps_its_bars_and_a_blessing_its_reason() {
        let mut accepted = finding("filling/a", Severity::Worse, Gate::Counters);
        accepted.blessed = Some("two caps".to_owned());
        let one = markdown(&report(vec![
            finding("filling/b", Severity::Better, Gate::Errors),
            accepted,
        ]));
        assert!(
            one.contains("| `b` | draws 3 → 6: +100 %, a \\| b |"),
            "{one}"
        );
        assert!(
            one.contains("| `a` | draws 3 → 6: +100 %, a \\| b; two caps |"),
            "{one}"
        );
        // Two studies: cases keep theirs.
        let two = [
            finding("filling/b", Severity::Worse, Gate::Errors),
            finding("moving/b", Severity::Worse, Gate::Errors),
        ];
        assert!(markdown(&report(two.to_vec())).contains("| `moving/b` |"));
        assert_eq!(short("abcdefghij", 5), "ab…ij");
        assert_eq!(short("abcde", 5), "abcde");
    }
}
