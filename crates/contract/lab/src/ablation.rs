// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ablations: steps that change one thing each, and what each gains.
//!
//! A step is compared with the last one before it that is kept: its picture is right, and it does not stand aside.

use crate::cases::Cases;
use crate::section::{Column, case_table};
use crate::timings::Timings;
use terrafill_plot::number::{digits, measured_bytes, significant, spread};
use terrafill_plot::{RatioAxis, Step, Steps};
use terrafill_results::{
    Block, Case, Cell, ChapterError, ConditionKey, Estimate, Heading, Kind, Metric, Outcome, Row,
    Spread, Table,
};

/// Work that differs by less than this factor is equal.
const SAME_WORK: f64 = 1.05;

/// How many times more work must differ to show what it costs.
const MIN_LEVER: f64 = 1.2;

/// Which conditions number and name steps, and which note says what a step changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepKeys {
    /// Of the number; a case without one is no step.
    pub number: ConditionKey,
    /// Of the name.
    pub name: ConditionKey,
    /// Of what stands aside, where it is `yes`; `None` where nothing does.
    pub aside: Option<ConditionKey>,
    /// The note with a sentence on the change.
    pub change: &'static str,
}

/// A step as measured.
#[derive(Debug, Clone)]
pub struct AblationStep<'a> {
    /// From 1.
    pub number: u32,
    /// In short.
    pub name: &'a str,
    /// What changes, in a sentence.
    pub change: &'a str,
    /// With its figures.
    pub case: &'a Case,
    /// Whether nothing is compared with it.
    pub is_aside: bool,
    /// The last kept step before it.
    pub before: Option<&'a Case>,
    /// The step between both that is not right: what differs is its work as well as this one's.
    pub skipped: Option<&'a str>,
    /// Time of the step before over this one's.
    pub gain: Option<Estimate>,
}

impl AblationStep<'_> {
    /// Whether the next step starts from it: it is right, and not aside.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        self.case.counts() && !self.is_aside
    }
}

/// Steps by number, each with its gain.
#[must_use]
pub fn ablation<'a>(
    timings: Timings,
    keys: StepKeys,
    cases: impl IntoIterator<Item = &'a Case>,
) -> Vec<AblationStep<'a>> {
    let cases = cases.into_iter();
    let numbered = cases.filter_map(|case| Some((case.condition(keys.number).parse().ok()?, case)));
    let mut numbered: Vec<(u32, &Case)> = numbered.collect();
    numbered.sort_by_key(|(number, _)| *number);
    let (mut before, mut skipped) = (None, None);
    let mut steps = Vec::new();
    for (number, case) in numbered {
        let step = AblationStep {
            number,
            name: case.condition(keys.name),
            change: case.note(keys.change),
            case,
            is_aside: keys.aside.is_some_and(|key| case.condition(key) == "yes"),
            before,
            skipped,
            gain: before.and_then(|before| timings.over(before, case)),
        };
        if step.is_kept() {
            (before, skipped) = (Some(case), None);
        } else if !step.is_aside {
            skipped = Some(step.name);
        }
        steps.push(step);
    }
    steps
}

/// Steps that have no result, in words: the first number that is left out, and what was planned and is missing.
#[must_use]
pub fn missing_steps(steps: &[AblationStep<'_>]) -> Vec<String> {
    let mut numbered = steps.iter().zip(1_u32..);
    let gap = numbered.find(|(step, number)| step.number != *number);
    let gap = gap.map(|(step, number)| {
        let AblationStep {
            number: next, name, ..
        } = step;
        format!("step {number} (the ablation goes on with {next}, {name})")
    });
    let absent = steps
        .iter()
        .filter(|step| step.case.outcome == Outcome::Missing);
    let absent =
        absent.map(|step| format!("step {}, {}: {}", step.number, step.name, step.case.id()));
    gap.into_iter().chain(absent).collect()
}

/// How time grows with one kind of work while another stays: an exponent, 0 where the work costs nothing and 1 where it
/// costs everything. It is ln of the times' ratio over ln of the work's, of the step that changes the work most.
///
/// - `varied`: the work that time is held against
/// - `kept`: what must be equal before and after the step
pub fn work_exponent<'s, 'a: 's>(
    steps: impl Iterator<Item = &'s AblationStep<'a>>,
    varied: impl Fn(&Case) -> Option<f64>,
    kept: impl Fn(&Case) -> Option<f64>,
) -> Option<Estimate> {
    let levers = steps.filter_map(|step| {
        let (before, gain) = (step.before?, step.gain?);
        let lever = |work: &dyn Fn(&Case) -> Option<f64>| {
            let ratio = work(before)? / work(step.case)?;
            (ratio.is_finite() && ratio > 0.0).then(|| ratio.ln())
        };
        let is_same = lever(&kept)?.abs() <= SAME_WORK.ln();
        let lever = lever(&varied)?;
        (is_same && lever.abs() >= MIN_LEVER.ln()).then_some((lever, gain))
    });
    let (lever, gain) = levers.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let of = |ratio: f64| ratio.ln() / lever;
    Some(Estimate {
        middle: of(gain.middle),
        interval: gain.interval.map(|[low, high]| {
            let (a, b) = (of(low), of(high));
            [a.min(b), a.max(b)]
        }),
        processes: gain.processes,
    })
}

/// What all kept steps of each ablation gave together, and which gave most.
///
/// - `named`: heading of the ablations' names
#[must_use]
pub fn gains_table<'s, 'a: 's>(
    timings: Timings,
    named: &str,
    ablations: impl IntoIterator<Item = (&'s str, &'s [AblationStep<'a>])>,
) -> Table {
    let rows = ablations.into_iter().map(|(title, steps)| {
        let mut kept = steps.iter().filter(|step| step.is_kept());
        let gains = kept.clone().filter_map(|step| Some((step, step.gain?)));
        let most = gains.max_by(|a, b| a.1.middle.total_cmp(&b.1.middle));
        let most = most.map(|(step, gain)| format!("{}: {}", step.name, timings.ratio_text(&gain)));
        let both = kept.next().zip(kept.next_back());
        let total = both.and_then(|(first, last)| timings.over(first.case, last.case));
        let cells = [
            timings.ratio_cell(total.as_ref(), "no two right steps with times"),
            Cell::or_absent(most, "no gain was measured"),
        ];
        Row::named(Cell::name(title), cells)
    });
    let headings = [named, "first right step ÷ last [95\u{a0}%]", "gave most"];
    Table {
        is_main: true,
        ..Table::of(headings, rows.collect())
    }
}

/// Which amounts of work a step changes, in a sentence; `None` where it changes none.
///
/// - `amounts`: each in words
#[must_use]
pub fn changed_work(
    amounts: &[(&str, &'static Metric)],
    before: &Case,
    after: &Case,
) -> Option<String> {
    let changed = amounts.iter().filter_map(|(name, metric)| {
        let values = [before.value(*metric)?, after.value(*metric)?];
        let print = match metric.kind {
            Kind::Bytes => measured_bytes,
            _ => digits,
        };
        let [from, to] = values.map(print);
        (values[0] != values[1]).then(|| format!("{name} {from} → {to}"))
    });
    let changed: Vec<String> = changed.collect();
    (!changed.is_empty()).then(|| changed.join(", "))
}

/// How a step is shown.
#[derive(Debug, Clone)]
pub struct ShownStep {
    /// Of its case.
    pub name: String,
    /// Its times over the median of its baseline, or why there is no ratio.
    pub over_baseline: Result<Spread, String>,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

/// A plot and a table of steps, from the first to the last.
#[derive(Debug, Clone, Copy)]
pub struct StepsSection<'r> {
    /// Of the plot.
    pub title: &'r str,
    /// What times are divided by.
    pub baseline: &'r str,
    /// Figures of each step.
    pub columns: &'r [Column],
    /// Whether `summary.md` repeats the table.
    pub is_main: bool,
}

impl StepsSection<'_> {
    /// The plot, where there is a time, and the table.
    ///
    /// - `cases`: those that the steps are of
    /// - `changed`: what a step changed of the work, from the kept one before it
    ///
    /// # Errors
    /// [`ChapterError`] when the plot cannot be drawn.
    pub fn blocks(
        &self,
        cases: &Cases<'_>,
        timings: Timings,
        steps: &[AblationStep<'_>],
        show: impl Fn(&Case) -> ShownStep,
        changed: impl Fn(&Case, &Case) -> Cell,
    ) -> Result<Vec<Block>, ChapterError> {
        let shown: Vec<ShownStep> = steps.iter().map(|step| show(step.case)).collect();
        let baseline = self.baseline;
        let clock = cases.clock().name();
        let axis = format!(
            "{clock} of the fill ÷ that of the {baseline}, median with 5–95 % of samples (logarithmic)"
        );
        let one = format!("{baseline} = 1");
        let rows = steps.iter().zip(&shown);
        let plot = Steps {
            title: self.title.to_owned(),
            axis: RatioAxis {
                title: &axis,
                one: &one,
            },
            rows: rows.map(|(step, shown)| bar(step, shown)).collect(),
        };
        let rows = steps.iter().zip(shown);
        let rows = rows.map(|(step, shown)| (step.case, said(timings, step, shown, &changed)));
        let over = format!("÷\u{a0}{baseline} (5\u{2060}–\u{2060}95\u{a0}%)");
        let over_meaning =
            format!("times over the median of the full-screen {baseline} of the same view");
        let headings = [
            ("step", ""),
            (
                "gain [95\u{a0}%]",
                "time of the last kept step before over this one's, paired by process",
            ),
            (over.as_str(), over_meaning.as_str()),
            ("changed", "of the work that is done"),
        ];
        let headings = headings.map(|(text, meaning)| Heading::explained(text, meaning));
        let table = Table {
            is_main: self.is_main,
            ..case_table(cases, headings.into(), self.columns, rows)
        };
        let plot = Block::plot("", plot.draw()?);
        Ok(plot.into_iter().chain([Block::Table(table)]).collect())
    }
}

fn bar(step: &AblationStep<'_>, shown: &ShownStep) -> Step {
    let ratio = shown.over_baseline.as_ref().ok();
    let gain = step.gain.map(|gain| gain.middle);
    let gained = gain.map_or_else(String::new, |gain| format!(" · gain {}", significant(gain)));
    Step {
        label: format!("{} · {}", step.number, step.name),
        begins: ratio.zip(gain).map(|(ratio, gain)| ratio.median * gain),
        is_kept: step.is_kept(),
        value: ratio.map_or_else(String::new, |ratio| {
            format!("{} ×{gained}", significant(ratio.median))
        }),
        ratio: shown.over_baseline.clone(),
        command: shown.command.clone(),
    }
}

/// What a row says before its figures.
fn said(
    timings: Timings,
    step: &AblationStep<'_>,
    shown: ShownStep,
    changed: impl Fn(&Case, &Case) -> Cell,
) -> Vec<Cell> {
    let aside = if step.is_aside { "aside, " } else { "" };
    let AblationStep {
        number,
        name,
        change,
        ..
    } = step;
    let named = Cell {
        detail: shown.name,
        ..Cell::name(format!("{number} · {aside}{name}: {change}"))
    };
    let why = "no kept step before it, or no times of both";
    vec![
        named,
        timings.ratio_cell(step.gain.as_ref(), why),
        match shown.over_baseline {
            Ok(over) => Cell::plain(spread(over)),
            Err(why) => Cell::absent(why),
        },
        match step.before {
            Some(before) => changed(before, step.case),
            None => Cell::absent("nothing comes before it"),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{TIME, empty};
    use terrafill_results::Status;
    use terrafill_results::condition::{SIZE_PX, VIEW};
    use terrafill_results::made_up::{MadeUpRun, case_id};

    const TIMINGS: Timings = Timings {
        metric: TIME,
        noise: None,
    };
    const KEYS: StepKeys = StepKeys {
        number: SIZE_PX,
        name: VIEW,
        aside: None,
        change: "change",
    };

    /// Three steps of 8, 4 and 2 ms, and a case that is none.
    fn made() -> MadeUpRun {
        let mut made = empty();
        for (number, name, ms) in [
            ("3", "c", 2.0),
            ("1", "a", 8.0),
            ("2", "b", 4.0),
            ("", "d", 1.0),
        ] {
            made.case(case_id(
                "study",
                name,
                &[("view", name), ("size_px", number)],
            ))
            .timed(TIME, &[ms; 5]);
        }
        made
    }

    /// Names of steps with their gains, and the blocks of all.
    fn gains(made: &MadeUpRun) -> (Vec<(String, Option<f64>)>, String) {
        let run = made.loaded();
        let cases = Cases::of_study(&run, "study");
        let steps = ablation(TIMINGS, KEYS, cases.iter());
        let section = StepsSection {
            title: "Steps",
            baseline: "first",
            columns: &[],
            is_main: false,
        };
        let show = |case: &Case| ShownStep {
            name: case.id().name.clone(),
            over_baseline: TIMINGS.samples(case).ok_or_else(|| "no time".to_owned()),
            command: String::new(),
        };
        let changed = |before: &Case, _: &Case| Cell::name(format!("after {}", before.id().name));
        let blocks = section.blocks(&cases, TIMINGS, &steps, show, changed);
        let named = steps.iter().map(|step| {
            let gain = step.gain.map(|gain| gain.middle);
            (step.name.to_owned(), gain)
        });
        (named.collect(), format!("{:?}", blocks.expect("blocks")))
    }

    #[test]
    fn a_step_gains_over_the_last_kept_one_and_a_wrong_one_is_passed_over() {
        let named = |gains: [Option<f64>; 3]| {
            let names = ["a", "b", "c"].map(str::to_owned).into_iter();
            names.zip(gains).collect::<Vec<_>>()
        };
        let (found, blocks) = gains(&made());
        assert_eq!(found, named([None, Some(2.0), Some(2.0)]));
        assert!(
            blocks.contains("after b") && blocks.contains("· gain 2.00"),
            "{blocks}"
        );
        // Negative control: a wrong step has no gain, and the next one starts from the step before it.
        let mut made = made();
        made.cases[2].ended(Status::Wrong, "9 px");
        let (found, blocks) = gains(&made);
        assert_eq!(found, named([None, None, Some(4.0)]));
        assert!(!blocks.contains("after b"), "{blocks}");
    }

    #[test]
    fn work_has_an_exponent_where_the_other_work_stays() {
        let run = made().loaded();
        let steps = ablation(TIMINGS, KEYS, run.of_study("study"));
        let time = |case: &Case| case.value(TIME);
        let one = |_: &Case| Some(1.0);
        let found = work_exponent(steps.iter(), time, one).expect("an exponent");
        assert!((found.middle - 1.0).abs() < 1e-12, "{found:?}");
        let of = |before: usize, after: usize| {
            changed_work(&[("ms", TIME)], steps[before].case, steps[after].case)
        };
        assert_eq!(of(0, 1).as_deref(), Some("ms 8 → 4"));
        assert_eq!(of(1, 1), None, "negative control: the same work");
        let table = gains_table(TIMINGS, "of", [("all", &steps[..])]);
        let texts = table.rows[0].cells.iter().map(|cell| cell.text.as_str());
        let texts: Vec<&str> = texts.collect();
        assert_eq!(texts[..2], ["all", "4.00 × [4.00–4.00]"]);
        // Negative controls: both change, or neither does.
        assert_eq!(work_exponent(steps.iter(), time, time), None);
        assert_eq!(work_exponent(steps.iter(), one, one), None);
    }

    #[test]
    fn a_number_that_is_left_out_and_a_missing_step_are_named() {
        let missing = |made: &MadeUpRun| {
            missing_steps(&ablation(TIMINGS, KEYS, made.loaded().of_study("study")))
        };
        let mut made = made();
        assert_eq!(missing(&made), [""; 0]);
        // Negative controls: one that was not measured, and one that nobody planned.
        made.cases[0].missing();
        assert_eq!(missing(&made), ["step 3, c: study/c"]);
        made.cases.remove(2);
        assert_eq!(missing(&made)[0], "step 2 (the ablation goes on with 3, c)");
    }
}
