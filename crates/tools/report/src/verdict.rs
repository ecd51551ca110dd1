// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run says in a few sentences: how its cases ended, by which clock it compares, by how much
//! identical work differed, and how many replicates there are.

use serde::Serialize;
use terrafill_plot::number::{count, significant};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{
    Case, Chapter, Clock, Noise, Outcome, Run, UNSTEADY_CLOCK, has_two_groups,
};

/// How a run ended as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every case that could run is right.
    Good,
    /// A case is wrong or broke off.
    Bad,
    /// Cases are missing, and the others are right.
    Incomplete,
    /// No case is right, and none is wrong.
    Nothing,
}

impl Verdict {
    /// The exit code of a command that ends with this run.
    #[must_use]
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Good => 0,
            Self::Bad => 1,
            Self::Incomplete => 3,
            Self::Nothing => 4,
        }
    }

    /// Class in the style sheet.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad | Self::Nothing => "bad",
            Self::Incomplete => "incomplete",
        }
    }
}

/// How many cases ended how; repeats are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Counts {
    /// Right, and measured as often as planned.
    pub ok: usize,
    /// Of these, cases whose error is the question: they may be wrong, and are not.
    pub ok_as_result: usize,
    /// Wrong.
    pub wrong: usize,
    /// Of these, cases whose error is the question, so that a wrong answer is a result.
    pub wrong_as_result: usize,
    /// Not run, with a reason.
    pub skipped: usize,
    /// Broke off, with a reason.
    pub failed: usize,
    /// Wrong in exactly the pixels that a listed fault of the driver loses.
    pub driver_fault: usize,
    /// Planned, and without a result.
    pub missing: usize,
}

impl Counts {
    pub(crate) fn of(run: &Run) -> Self {
        let as_result = |outcome| {
            let is_one = |case: &Case| case.outcome == outcome && case.planned.may_be_wrong;
            that_are(run, is_one).count()
        };
        Self {
            ok: run.count(Outcome::Ok),
            ok_as_result: as_result(Outcome::Ok),
            wrong: run.count(Outcome::Wrong),
            wrong_as_result: as_result(Outcome::Wrong),
            skipped: run.count(Outcome::Skipped),
            failed: run.count(Outcome::Failed),
            driver_fault: run.count(Outcome::DriverFault),
            missing: run.count(Outcome::Missing),
        }
    }

    fn total(&self) -> usize {
        self.ok + self.wrong + self.skipped + self.failed + self.driver_fault + self.missing
    }

    pub(crate) fn verdict(&self) -> Verdict {
        match (
            self.wrong - self.wrong_as_result + self.failed,
            self.missing,
        ) {
            (1.., _) => Verdict::Bad,
            (0, 1..) => Verdict::Incomplete,
            (0, 0) if self.ok + self.wrong_as_result == 0 => Verdict::Nothing,
            (0, 0) => Verdict::Good,
        }
    }
}

/// Cases that are `so`, repeats left out.
pub(crate) fn that_are(run: &Run, so: impl Fn(&Case) -> bool) -> impl Iterator<Item = &Case> {
    let cases = run.cases.iter();
    cases.filter(move |case| !case.is_repeat() && so(case))
}

/// Their names.
pub(crate) fn named(run: &Run, so: impl Fn(&Case) -> bool) -> Vec<String> {
    that_are(run, so).map(|case| case.id().key()).collect()
}

/// Whether a case is a defect: wrong where it must not be, or broken off.
pub(crate) fn is_defect(case: &Case) -> bool {
    case.outcome == Outcome::Failed
        || (case.outcome == Outcome::Wrong && !case.planned.may_be_wrong)
}

/// A/A noise of one study.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StudyNoise {
    pub(crate) study: &'static str,
    pub(crate) metric: &'static str,
    /// `None` where no right case was measured twice.
    pub(crate) noise: Option<Noise>,
    /// Cases whose processes fall into two groups.
    pub(crate) split: Vec<String>,
}

/// Noise of every study of the run that times something.
pub(crate) fn noise(run: &Run, chapters: &[&dyn Chapter]) -> Vec<StudyNoise> {
    let studies = chapters.iter().filter_map(|chapter| {
        let (study, metric) = (chapter.study(), chapter.primary_metric(run.clock())?);
        let is_timed = run
            .of_study(study)
            .any(|case| case.samples(metric).is_some());
        is_timed.then(|| StudyNoise {
            study,
            metric,
            noise: Noise::of(
                run.cases.iter().filter(|case| case.id().study == study),
                metric,
            ),
            split: named(run, |case| {
                case.id().study == study && has_two_groups(case, metric)
            }),
        })
    });
    studies.collect()
}

/// What a run says in sentences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Sentences {
    /// How its cases ended.
    pub(crate) verdict: Vec<String>,
    /// By which clock it compares.
    pub(crate) clock: String,
    /// By how much identical work differed, for each study.
    pub(crate) noise: Vec<String>,
    /// How many replicates there are; `None` for a run that times nothing.
    pub(crate) replicates: Option<String>,
}

impl Sentences {
    /// One after the other.
    pub(crate) fn all(&self) -> Vec<String> {
        let verdict = self.verdict.iter().chain([&self.clock]);
        let all = verdict.chain(&self.noise).chain(&self.replicates);
        all.cloned().collect()
    }
}

pub(crate) fn sentences(run: &Run, counts: &Counts, noise: &[StudyNoise]) -> Sentences {
    let total = counts.total();
    let number = |number: usize| count(number as u64);
    let mut verdict = vec![format!(
        "{}: {} right, {} wrong, {} skipped, {} failed, {} missing{}{}.",
        plural(total, "case"),
        number(counts.ok - counts.ok_as_result),
        number(counts.wrong - counts.wrong_as_result),
        number(counts.skipped),
        number(counts.failed),
        number(counts.missing),
        match counts.driver_fault {
            0 => String::new(),
            some => format!("; {some} differ by a known driver fault"),
        },
        match counts.ok_as_result + counts.wrong_as_result {
            0 => String::new(),
            some => format!(
                "; {} more may be wrong, as their error is measured (wrong: {})",
                number(some),
                number(counts.wrong_as_result)
            ),
        }
    )];
    let defects = named(run, is_defect);
    if !defects.is_empty() {
        verdict.push(format!("Wrong or failed: {}.", first_few(&defects)));
    }
    if counts.missing > 0 {
        verdict.push(format!(
            "This run broke off: {} of {total} planned cases have no result, and the report covers \
             the rest.",
            counts.missing
        ));
    }
    Sentences {
        verdict,
        clock: clock_sentence(run),
        noise: noise
            .iter()
            .map(noise_sentence)
            .chain(noise.iter().filter_map(split_sentence))
            .chain(unsteady_sentence(run))
            .collect(),
        replicates: replicate_sentence(run),
    }
}

fn clock_sentence(run: &Run) -> String {
    let why = match (run.clock(), run.environment.device_type.as_str()) {
        (Clock::Gpu, _) => "the device's own clock",
        (Clock::ProcessCpu, "cpu") => "the device is the CPU",
        (Clock::ProcessCpu, _) => "the device has no clock for its passes",
    };
    let name = run.clock().name();
    format!("Ratios, rankings and plots use {name}: {why}.")
}

fn noise_sentence(of: &StudyNoise) -> String {
    let (study, metric) = (of.study, of.metric);
    match &of.noise {
        Some(noise) => format!(
            "In {study}, identical work differed by up to {} % ({metric}, {}, median {} %) within a process{}; \
             smaller gaps are ties.",
            percent(noise.max_factor()),
            plural(noise.pairs, "pair"),
            percent(noise.median_factor()),
            match noise.between {
                Some(between) => format!(
                    ", and by up to {} % between processes (median {} %)",
                    percent(between.max.exp()),
                    percent(between.median.exp())
                ),
                None => String::new(),
            }
        ),
        None => format!(
            "In {study}, no identical work was measured twice, so it is unknown which gaps are ties."
        ),
    }
}

/// Marks cases whose processes fall into two groups.
fn split_sentence(of: &StudyNoise) -> Option<String> {
    (!of.split.is_empty()).then(|| {
        format!(
            "In {}, the processes of {} fall into two groups, as at two clocks, so that the median is of one of \
             them: {}.",
            of.study,
            plural(of.split.len(), "case"),
            first_few(&of.split)
        )
    })
}

/// Which processes timed before their clock was steady.
fn unsteady_sentence(run: &Run) -> Option<String> {
    let notes = run.cases.iter().flat_map(|case| case.notes());
    let unsteady = notes.filter(|(name, _)| name.starts_with(UNSTEADY_CLOCK));
    let unsteady: Vec<String> = unsteady.map(|(_, text)| text.clone()).collect();
    (!unsteady.is_empty()).then(|| format!("Clocks were not steady: {}.", first_few(&unsteady)))
}

/// How much more than 1 a factor is.
fn percent(factor: f64) -> String {
    significant((factor - 1.0) * 100.0)
}

/// `None` for a run that times nothing.
fn replicate_sentence(run: &Run) -> Option<String> {
    if run.plan.cases.iter().all(|case| case.samples == 0) && run.plan.processes <= 1 {
        return None;
    }
    Some(match run.plan.processes {
        0 | 1 => {
            "One process: no spread between processes, so no interval, and it decides nothing."
                .to_owned()
        }
        some if (some as usize) < MIN_REPLICATES => format!(
            "{some} processes, each one replicate: fewer than {MIN_REPLICATES} give no interval."
        ),
        some => format!("{some} processes, each one replicate."),
    })
}

pub(crate) fn plural(number: usize, noun: &str) -> String {
    let number = number as u64;
    format!(
        "{} {noun}{}",
        count(number),
        if number == 1 { "" } else { "s" }
    )
}

/// The names, or the first of them and how many more there are.
fn first_few(names: &[String]) -> String {
    const FEW: usize = 4;
    match names.len().saturating_sub(FEW) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..FEW].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_as_good_as_its_worst_case() {
        let counts = |ok, wrong, wrong_as_result, failed, missing| Counts {
            ok,
            ok_as_result: 0,
            wrong,
            wrong_as_result,
            skipped: 3,
            failed,
            driver_fault: 5,
            missing,
        };
        // An expected failure neither spoils a run nor makes one: the last has five of them.
        let cases = [
            (counts(2, 0, 0, 0, 0), Verdict::Good, 0),
            (counts(2, 1, 1, 0, 0), Verdict::Good, 0),
            (counts(2, 2, 1, 0, 0), Verdict::Bad, 1),
            (counts(2, 0, 0, 1, 1), Verdict::Bad, 1),
            (counts(2, 0, 0, 0, 1), Verdict::Incomplete, 3),
            (counts(0, 0, 0, 0, 0), Verdict::Nothing, 4),
        ];
        for (counts, verdict, code) in cases {
            assert_eq!(counts.verdict(), verdict, "{counts:?}");
            assert_eq!(verdict.exit_code(), code);
        }
    }
}
