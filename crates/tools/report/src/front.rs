// SPDX-License-Identifier: MIT OR Apache-2.0
//! The first page: verdict, answers, requirements, and what a reader must know before any figure.

use crate::contents::Report;
use crate::glossary::of_drawing;
use crate::verdict::{Verdict, plural};
use crate::view::Renderer;
use askama::Template;
use std::collections::BTreeSet;
use terrafill_results::{Block, Finding, RunInput, Standing, with_figures};

/// Letters of a commit on the first screen; the whole name is under "Environment".
const SHORT_COMMIT: usize = 12;

/// What brackets mean on every page.
const NOTATION: &str = "A median; [a–b]: its 95 % interval over processes; (a–b): 5 to 95 % of the \
                        samples. Small dots: one for each process.";

#[derive(Template)]
#[template(path = "front.html")]
struct Front<'a> {
    /// Device, clock, size, processes and date.
    subtitle: String,
    /// Class of the verdict's bar.
    class: &'static str,
    sentences: &'a [String],
    facts: Vec<(&'static str, Vec<String>)>,
    answers: Vec<AnswerView>,
    requirements: Vec<Requirement<'a>>,
    /// What of them is not met or undecided, for the bar.
    open: Vec<String>,
    /// How many of them are met and are not; empty without any.
    tally: String,
    lists: String,
    environment: &'a [(&'static str, String)],
    inputs: &'a [RunInput],
}

struct AnswerView {
    id: String,
    title: &'static str,
    question: &'static str,
    html: String,
}

/// A line of the checklist.
struct Requirement<'a> {
    standing: Met,
    claim: &'a str,
    /// By which figures, or why it is open.
    because: &'a str,
    /// What decides it; empty for what is decided.
    command: &'a str,
}

/// Whether a requirement is met, in the order of the checklist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Met {
    No,
    Undecided,
    Yes,
}

impl Met {
    const ALL: [Self; 3] = [Self::Yes, Self::No, Self::Undecided];

    fn of(standing: Standing) -> Self {
        match standing {
            Standing::Holds => Self::Yes,
            Standing::DoesNotHold | Standing::NoDifference => Self::No,
            Standing::CannotTell | Standing::NotMeasured | Standing::CannotBeTested => {
                Self::Undecided
            }
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Yes => "met",
            Self::No => "not met",
            Self::Undecided => "undecided",
        }
    }

    fn mark(self) -> &'static str {
        match self {
            Self::Yes => "✓",
            Self::No => "✗",
            Self::Undecided => "?",
        }
    }

    /// Class in the style sheet: that of a run's verdict.
    fn class(self) -> &'static str {
        match self {
            Self::Yes => Verdict::Good.class(),
            Self::No => Verdict::Bad.class(),
            Self::Undecided => Verdict::Incomplete.class(),
        }
    }
}

/// The body of the first page.
///
/// - `absent`: pictures of other pages that are not in the run's folder
pub(crate) fn front(
    report: &Report<'_>,
    renderer: &mut Renderer<'_>,
    lists: String,
    mut absent: BTreeSet<String>,
) -> Result<String, askama::Error> {
    let answers = report.parts.iter().map(|(chapter, _, answers)| {
        Ok(AnswerView {
            id: renderer.id(&format!("answer-{}", chapter.study())),
            title: chapter.title(),
            question: chapter.question(),
            html: renderer.html(&explained(report, &answers.blocks))?,
        })
    });
    let answers: Vec<AnswerView> = answers.collect::<Result<_, askama::Error>>()?;
    let parts = report.parts.iter();
    let requirements = checklist(parts.flat_map(|(_, _, answers)| &answers.requirements));
    absent.append(&mut renderer.take_absent());
    let facts = facts(report, absent.len());
    Front {
        subtitle: subtitle(report, &facts),
        class: bar(report.verdict, &requirements),
        sentences: &report.said.verdict,
        facts,
        answers: answers
            .into_iter()
            .filter(|answer| !answer.html.trim().is_empty())
            .collect(),
        open: unmet(&requirements),
        tally: tally(&requirements),
        requirements,
        lists,
        environment: &report.environment,
        inputs: report.inputs,
    }
    .render()
}

/// An answer with the names in its sentence explained right below it, and the names in its first plot below the plot:
/// a first reader knows none of them.
fn explained(report: &Report<'_>, blocks: &[Block]) -> Vec<Block> {
    let names = |text: &str| Some(report.glossary.of_names(text)).filter(|all| !all.is_empty());
    let mut with_names = Vec::new();
    let mut has_plot = false;
    for block in blocks {
        with_names.push(block.clone());
        match block {
            Block::Lead(answer) => {
                with_names.extend(names(answer).map(|all| Block::Remark(all.join(" · "))));
            }
            Block::Plot(plot) if !has_plot => {
                has_plot = true;
                let texts: Vec<String> = of_drawing(&plot.svg).collect();
                with_names.extend(names(&texts.join("; ")).map(|all| Block::Folded {
                    summary: "What the names mean".to_owned(),
                    is_open: false,
                    blocks: vec![Block::List(all)],
                }));
            }
            _ => {}
        }
    }
    with_names
}

/// On what, by which clock, how large, how often and when; what was not recorded is left out.
fn subtitle(report: &Report<'_>, facts: &[(&str, Vec<String>)]) -> String {
    let device = facts.iter().find(|(name, _)| *name == "Device");
    let device = device.and_then(|(_, values)| values.first().cloned());
    let recorded = ["primary clock", "image", "processes", "started"].map(|wanted| {
        let mut all = report.environment.iter();
        let found = all.find(|(name, _)| *name == wanted)?;
        Some(found.1.clone()).filter(|value| !value.is_empty())
    });
    let all = std::iter::once(device).chain(recorded).flatten();
    all.collect::<Vec<_>>().join(" · ")
}

/// What a reader must know before any figure.
fn facts(report: &Report<'_>, absent: usize) -> Vec<(&'static str, Vec<String>)> {
    let e = &report.run.environment;
    let known = |text: &str| match text {
        "" => "not recorded".to_owned(),
        text => text.to_owned(),
    };
    let kind = match e.device_type.as_str() {
        "cpu" => "software: it runs on the CPU",
        "" => "whether software or hardware was not recorded",
        _ => "hardware",
    };
    let scope = report
        .parts
        .iter()
        .flat_map(|(_, _, answers)| &answers.scope);
    let mut facts = vec![
        ("Device", vec![format!("{} ({kind})", known(&e.gpu))]),
        ("Clock", vec![report.said.clock.clone()]),
        (
            "Commit",
            vec![known(
                &e.commit.chars().take(SHORT_COMMIT).collect::<String>(),
            )],
        ),
        ("Correctness", scope.cloned().collect()),
        ("Noise", report.said.noise.clone()),
        (
            "Replicates",
            report.said.replicates.iter().cloned().collect(),
        ),
        ("Figures", vec![NOTATION.to_owned()]),
        ("Pictures", left_out(report, absent).into_iter().collect()),
    ];
    facts.retain(|(_, values)| !values.is_empty());
    facts
}

/// How many pictures of the run are not in its folder, and what draws them anew; nothing where none is missing.
fn left_out(report: &Report<'_>, absent: usize) -> Option<String> {
    let options = &report.run.environment.options;
    let is_quick = options.iter().any(|option| option == "depth=quick");
    let quick = if is_quick { " --quick" } else { "" };
    let studies = report.parts.iter();
    let studies = studies.map(|(chapter, ..)| format!(" --study {}", chapter.study()));
    (absent > 0).then(|| {
        format!(
            "{} left out of this folder. To draw them anew: terrafill bench{}{quick}",
            plural(absent, "picture"),
            studies.collect::<String>()
        )
    })
}

/// Requirements as lines, what is not met first.
fn checklist<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> Vec<Requirement<'a>> {
    let mut checklist: Vec<Requirement<'_>> = findings.into_iter().map(requirement).collect();
    checklist.sort_by_key(|requirement| requirement.standing);
    checklist
}

fn requirement(finding: &Finding) -> Requirement<'_> {
    /// How a command begins; it ends the sentences before it.
    const BENCH: &str = "terrafill bench ";
    let begin = finding.because.find(BENCH);
    let (because, command) = finding
        .because
        .split_at(begin.unwrap_or(finding.because.len()));
    Requirement {
        standing: Met::of(finding.standing),
        claim: &finding.claim,
        because,
        command,
    }
}

/// The first of what is not met or undecided, and how many follow.
fn unmet(requirements: &[Requirement<'_>]) -> Vec<String> {
    /// As many as a reader takes in beside the verdict.
    const MAX_OPEN: usize = 2;
    let open = requirements.iter().filter(|of| of.standing != Met::Yes);
    let lines = open.map(|of| {
        // The sentence that leads to a command stands in the list.
        let because = match of.because.trim_end().rsplit_once(". ") {
            Some((because, _)) if !of.command.is_empty() => because,
            _ if of.command.is_empty() => of.because,
            _ => "",
        };
        let said = with_figures(of.claim, because);
        format!("{}: {said}", of.standing.name())
    });
    let mut lines: Vec<String> = lines.collect();
    let more = lines.len().saturating_sub(MAX_OPEN);
    lines.truncate(MAX_OPEN);
    lines.extend((more > 0).then(|| format!("and {more} more")));
    lines
}

/// `13 met, 1 not met`.
fn tally(requirements: &[Requirement<'_>]) -> String {
    let counts = Met::ALL.map(|standing| {
        let own = requirements.iter().filter(|of| of.standing == standing);
        (own.count(), standing.name())
    });
    let some = counts.iter().filter(|(count, _)| *count > 0);
    let some: Vec<String> = some
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    some.join(", ")
}

/// Class of the verdict's bar: that of a good run only where every requirement is met.
fn bar(verdict: Verdict, requirements: &[Requirement<'_>]) -> &'static str {
    let worst = requirements.iter().map(|of| of.standing).min();
    match (verdict, worst) {
        (Verdict::Good, Some(worst)) => worst.class(),
        _ => verdict.class(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_met_comes_first_and_what_is_open_names_its_command() {
        let finding = |standing, because: &str| Finding {
            claim: "It grows".to_owned(),
            standing,
            because: because.to_owned(),
        };
        let command = "terrafill bench --study balls --processes 5";
        let open = format!("No device. To measure it: {command}");
        let findings = [
            finding(Standing::Holds, "2 px"),
            finding(Standing::NotMeasured, &open),
            finding(Standing::NoDifference, "1.00 ×"),
        ];
        let lines: Vec<Requirement<'_>> = checklist(&findings);
        let words: Vec<[&str; 3]> = lines
            .iter()
            .map(|line| [line.standing.name(), line.because, line.command])
            .collect();
        assert_eq!(
            words,
            [
                ["not met", "1.00 ×", ""],
                ["undecided", "No device. To measure it: ", command],
                ["met", "2 px", ""],
            ]
        );
        assert_eq!(tally(&lines), "1 met, 1 not met, 1 undecided");
        assert_eq!(
            unmet(&lines),
            [
                "not met: It grows: 1.00 ×",
                "undecided: It grows. No device"
            ]
        );
        let four = [&findings[1..], &findings[1..]].concat();
        assert_eq!(unmet(&checklist(&four))[2], "and 2 more");
        assert!(unmet(&checklist(&findings[..1])).is_empty(), "control");
        // A bar is green only where all is met, and what is wrong is not mended by that.
        let bar_of = |findings: &[Finding]| bar(Verdict::Good, &checklist(findings));
        assert_eq!(bar_of(&findings), "bad");
        assert_eq!(bar_of(&findings[..2]), "incomplete");
        assert_eq!(bar_of(&findings[..1]), "good");
        assert_eq!(bar_of(&[]), "good");
        assert_eq!(bar(Verdict::Bad, &checklist(&findings[..1])), "bad");
    }
}
