// SPDX-License-Identifier: MIT OR Apache-2.0
//! The time gate: two programs, measured by turns in one job on one device.
//!
//! *In lock-step*, a block is three fresh processes that are all alive: the base, the base once more, and
//! the new program. They draw samples in bursts, each in one order and back, and one alone runs at any
//! time. A burst's difference is ln(new) less the mean ln(base) of samples that follow one another within
//! milliseconds, so noise that lasts longer falls out. The block's one number is the median over its
//! bursts; base against base in the same bursts is the null.
//!
//! On a software device all processes of a block run on one core, see `cores`.
//!
//! *By turns*, where a program cannot be stepped, a block is four whole processes: base, new, new, base,
//! and the other way round by turns. Its difference is the mean of ln(new) less that of ln(base), each of a
//! process's median.
//!
//! [`SCREEN_BLOCKS`] look at every case. What moved by [`SCREEN_SHARE`] of its floor, or spread too much to tell, is
//! measured again in [`CONFIRM_BLOCKS`] *fresh* blocks, which alone decide. Choosing cases by their first
//! blocks biases these. Where the null moves, the machine did. What these blocks leave undecided is measured
//! on, for up to [`CONFIRM_ROUNDS`] such rounds, as the time budget allows.

use crate::block::{Block, deviation, differences, level, logarithm, null_differences, percent};
use crate::sides::{Side, Sides, Times, TimingOrder, Trio};
use crate::threshold::{
    CONFIRM_BLOCKS, CONFIRM_ROUNDS, COVERAGE, MIN_AGREEMENT, MIN_CONFIRM_BLOCKS,
    MIN_PLAUSIBLE_RATIO, NULL_COVERAGE, SCREEN_BLOCKS, SCREEN_SHARE,
};
use crate::{Finding, Floor, Floors, Gate, GateError, Severity, Span};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use terrafill_results::{Clock, Shift, median};

/// What decides, beside the figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeOptions {
    /// The clock that the times are by.
    pub clock: Clock,
    /// Smallest changes that fail.
    pub floors: Floors,
    /// When to stop measuring.
    pub budget: Duration,
}

impl TimeOptions {
    /// The usual floors by this clock.
    #[must_use]
    pub fn new(clock: Clock, budget: Duration) -> Self {
        Self {
            clock,
            floors: Floors::new(clock),
            budget,
        }
    }
}

/// A time that is compared, and of which cases.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Watched {
    /// Its metric.
    pub metric: String,
    /// What it is of.
    pub span: Span,
    /// Keys of the cases that have it.
    pub cases: BTreeSet<String>,
}

/// How a case's time compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// No change of the floor's size.
    Same,
    /// Slower by more than the floors.
    Slower,
    /// Faster by more than the floors.
    Faster,
    /// So much faster that it may have stopped working.
    Collapsed,
    /// It is inconclusive.
    #[default]
    Unknown,
}

/// What the time gate found of one case.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CaseTime {
    /// Its key.
    pub case: String,
    /// The metric that was compared.
    pub metric: String,
    /// What it is of.
    pub span: Span,
    /// How it compares.
    pub pace: Pace,
    /// Median over the base's processes, milliseconds; `None` without a usable time.
    pub base_ms: Option<f64>,
    /// Median over the new program's processes, milliseconds.
    pub new_ms: Option<f64>,
    /// Change in percent: Hodges–Lehmann of the deciding blocks, or the first look's median.
    pub percent: Option<f64>,
    /// The change over the smallest that fails by the floors of this gate.
    #[serde(default)]
    pub of_floor: Option<f64>,
    /// 99 % interval of the change in percent; `None` where the first look decided.
    pub interval_percent: Option<[f64; 2]>,
    /// Base against base in the same blocks, percent.
    pub null_percent: Option<f64>,
    /// Standard deviation of the deciding blocks, percent.
    pub spread_percent: Option<f64>,
    /// Blocks that decided.
    pub blocks: usize,
    /// Of these, blocks in which the new program was slower.
    pub slower_blocks: usize,
    /// Why it is inconclusive, or why a change does not count.
    pub words: String,
    /// Parts of its work, in the same blocks.
    pub stages: Vec<Stage>,
}

/// Time of a part of a frame's work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Its metric.
    pub metric: String,
    /// Median over the base's processes, milliseconds.
    pub base_ms: f64,
    /// Median over the new program's processes, milliseconds.
    pub new_ms: f64,
}

impl Stage {
    /// `stencil +0.210 ms`.
    fn sentence(&self) -> String {
        let name = self.metric.split('_').next().unwrap_or_default();
        format!("{name} {:+.3} ms", self.new_ms - self.base_ms)
    }
}

/// What the time gate found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TimeGate {
    /// How the two programs were measured.
    pub way: TimingOrder,
    /// Whether all processes of a block ran on one core.
    pub on_one_core: bool,
    /// Every case that was to be timed.
    pub cases: Vec<CaseTime>,
    /// Blocks of the first look.
    pub screen: Vec<Block>,
    /// Blocks that decided on the cases that moved.
    pub confirm: Vec<Block>,
}

/// Measures and compares times that each frame has.
///
/// - `watched`: those that are compared, and stages
///
/// # Errors
/// [`GateError`] of a program that does not run; [`GateError::NothingMeasured`] where the budget ends
/// before the first look does.
pub fn compare_times(
    sides: &mut dyn Sides,
    watched: &[Watched],
    options: &TimeOptions,
) -> Result<TimeGate, GateError> {
    let mut next_process = 1;
    let all: BTreeSet<String> = watched.iter().flat_map(|of| of.cases.clone()).collect();
    let screen = blocks(
        sides,
        &all,
        options,
        SCREEN_BLOCKS,
        &mut next_process,
        "first look",
    )?;
    if screen.len() < SCREEN_BLOCKS as usize {
        return Err(GateError::NothingMeasured(format!(
            "the time budget of {} s ended after {} of {SCREEN_BLOCKS} blocks of the first look; give \
             fewer scenes or a larger --time-budget-s",
            options.budget.as_secs(),
            screen.len()
        )));
    }
    let (stages, compared): (Vec<&Watched>, Vec<&Watched>) =
        watched.iter().partition(|of| of.span == Span::Stage);
    let mut looked_at: Vec<CaseTime> = Vec::new();
    for of in &compared {
        let times = both(sides, &of.metric)?;
        let cases = of.cases.iter();
        looked_at.extend(cases.map(|case| first_look(case, of, &screen, &times, options)));
    }
    let mut confirm = Vec::new();
    for round in 1..=CONFIRM_ROUNDS {
        let is_undecided = |case: &CaseTime| case.pace == Pace::Unknown && case.percent.is_some();
        let undecided = looked_at.iter().filter(|case| is_undecided(case));
        let undecided: BTreeSet<String> = undecided.map(|case| case.case.clone()).collect();
        if undecided.is_empty() {
            break;
        }
        let again = if round == 1 {
            "again"
        } else {
            "still undecided"
        };
        let what = format!("{} cases {again}", undecided.len());
        let more = blocks(
            sides,
            &undecided,
            options,
            CONFIRM_BLOCKS,
            &mut next_process,
            &what,
        )?;
        if more.is_empty() && round > 1 {
            break;
        }
        confirm.extend(more);
        for of in &compared {
            let times = both(sides, &of.metric)?;
            let cases = looked_at.iter_mut();
            let of_metric = cases.filter(|case| case.metric == of.metric && is_undecided(case));
            for case in of_metric {
                *case = decide(&case.case, of, &confirm, &times, options);
            }
        }
    }
    for of in stages {
        let times = both(sides, &of.metric)?;
        let frames = looked_at.iter_mut().filter(|case| case.span == Span::Frame);
        for case in frames.filter(|case| of.cases.contains(&case.case)) {
            let blocks = if case.blocks > screen.len() {
                &confirm
            } else {
                &screen
            };
            let ms = |side: Side| middle_ms(&case.case, &times[side.index()], blocks, side);
            if let (Some(base_ms), Some(new_ms)) = (ms(Side::Base), ms(Side::New)) {
                let metric = of.metric.clone();
                case.stages.push(Stage {
                    metric,
                    base_ms,
                    new_ms,
                });
            }
        }
    }
    Ok(TimeGate {
        way: sides.way().clone(),
        on_one_core: sides.is_on_one_core(),
        cases: looked_at,
        screen,
        confirm,
    })
}

/// Runs so many blocks, or as many as the budget allows; a block is measured whole or not at all.
fn blocks(
    sides: &mut dyn Sides,
    cases: &BTreeSet<String>,
    options: &TimeOptions,
    count: u32,
    next_process: &mut u32,
    what: &str,
) -> Result<Vec<Block>, GateError> {
    let mut blocks: Vec<Block> = Vec::new();
    let started = sides.elapsed();
    for number in 1..=count {
        let spent = sides.elapsed();
        // As long as the blocks so far: the next one must end within the budget too.
        let one = (spent - started) / u32::try_from(blocks.len().max(1)).unwrap_or(u32::MAX);
        if spent + one > options.budget {
            break;
        }
        sides.say(&format!("{what}: block {number} of {count}"));
        blocks.push(match sides.way() {
            TimingOrder::LockStep => together(sides, cases, next_process)?,
            TimingOrder::Turns { .. } => by_turns(sides, cases, number, next_process)?,
        });
    }
    Ok(blocks)
}

fn together(
    sides: &mut dyn Sides,
    cases: &BTreeSet<String>,
    next_process: &mut u32,
) -> Result<Block, GateError> {
    let trio = Trio::of_block((*next_process - 1) / 3);
    *next_process += 3;
    sides.run_together(trio, cases)?;
    Ok(Block::LockStep(trio))
}

fn by_turns(
    sides: &mut dyn Sides,
    cases: &BTreeSet<String>,
    number: u32,
    next_process: &mut u32,
) -> Result<Block, GateError> {
    let [a, b, c, d] = [0, 1, 2, 3].map(|place| *next_process + place);
    *next_process += 4;
    use Side::{Base, New};
    let (order, block) = if number % 2 == 1 {
        let (base, new) = ([a, d], [b, c]);
        ([Base, New, New, Base], Block::Turns { base, new })
    } else {
        let (base, new) = ([b, c], [a, d]);
        ([New, Base, Base, New], Block::Turns { base, new })
    };
    for (side, process) in order.into_iter().zip([a, b, c, d]) {
        sides.run(side, process, cases)?;
    }
    Ok(block)
}

fn both(sides: &mut dyn Sides, metric: &str) -> Result<[Times; 2], GateError> {
    let base = sides.times(Side::Base, metric)?;
    Ok([base, sides.times(Side::New, metric)?])
}

/// Median over all of a program's processes in the blocks.
fn middle_ms(case: &str, times: &Times, blocks: &[Block], side: Side) -> Option<f64> {
    let processes = blocks.iter().flat_map(|block| block.processes(side));
    let levels: Option<Vec<f64>> = processes
        .map(|process| level(case, times, process))
        .collect();
    median(&levels?).map(f64::exp)
}

fn case_time(case: &str, of: &Watched, blocks: &[Block], [base, new]: &[Times; 2]) -> CaseTime {
    CaseTime {
        case: case.to_owned(),
        metric: of.metric.clone(),
        span: of.span,
        base_ms: middle_ms(case, base, blocks, Side::Base),
        new_ms: middle_ms(case, new, blocks, Side::New),
        blocks: blocks.len(),
        ..CaseTime::default()
    }
}

pub(crate) const NO_TIME: &str = "a process of it has no usable time";

/// Whether a case is measured again. A case whose first blocks spread so widely that a change of the
/// floor's size could hide in them is.
fn first_look(
    case: &str,
    of: &Watched,
    blocks: &[Block],
    times: &[Times; 2],
    options: &TimeOptions,
) -> CaseTime {
    let floor = options.floors.of(of.span).log();
    let mut found = case_time(case, of, blocks, times);
    let Some(differences) = differences(case, blocks, times) else {
        found.words = NO_TIME.to_owned();
        return found;
    };
    let Some(middle) = median(&differences) else {
        return found;
    };
    found.percent = Some(percent(middle));
    found.spread_percent = deviation(&differences).map(percent);
    found.slower_blocks = differences.iter().filter(|gap| **gap > 0.0).count();
    let spread = differences.iter().map(|gap| (gap - middle).abs());
    let spread = median(&spread.collect::<Vec<_>>()).unwrap_or(f64::INFINITY);
    found.pace = if middle.abs() >= SCREEN_SHARE * floor || spread > floor {
        Pace::Unknown
    } else {
        Pace::Same
    };
    found
}

/// The verdict of fresh blocks.
fn decide(
    case: &str,
    of: &Watched,
    blocks: &[Block],
    times: &[Times; 2],
    options: &TimeOptions,
) -> CaseTime {
    let floor = options.floors.of(of.span);
    let mut found = case_time(case, of, blocks, times);
    if blocks.len() < MIN_CONFIRM_BLOCKS as usize {
        found.words = format!(
            "it moved in the first look, and the time budget of {} s allowed {} blocks to decide, \
             needed {MIN_CONFIRM_BLOCKS}",
            options.budget.as_secs(),
            blocks.len()
        );
        return found;
    }
    let Some(differences) = differences(case, blocks, times) else {
        found.words = NO_TIME.to_owned();
        return found;
    };
    let Some(shift) = Shift::of(&differences, COVERAGE) else {
        return found;
    };
    let null = null_differences(case, blocks, times)
        .and_then(|differences| Shift::of(&differences, NULL_COVERAGE));
    found.percent = Some(percent(shift.estimate));
    found.interval_percent = shift.interval.map(|interval| interval.map(percent));
    found.null_percent = null.map(|null| percent(null.estimate));
    found.spread_percent = deviation(&differences).map(percent);
    found.slower_blocks = differences.iter().filter(|gap| **gap > 0.0).count();
    // Not the two medians' difference: these are not of the same moments, and drift as the machine does.
    let gap_ms = found
        .base_ms
        .map(|base| base * shift.estimate.exp_m1().abs());
    let (pace, words) = pace(&shift, null.as_ref(), &differences, gap_ms, &floor);
    // Other programs move the wall clock, which only a change that it shows may decide.
    let is_let_pass = of.span == Span::Wall && shift.estimate.abs() < floor.log();
    found.pace = match pace {
        Pace::Unknown if is_let_pass => Pace::Same,
        _ => pace,
    };
    found.words = words;
    found
}

/// A change counts when the interval excludes none, the estimate reaches both floors, and the blocks
/// agree. It is inconclusive where the null moved as much, or the interval is wider than the floor.
pub(crate) fn pace(
    shift: &Shift,
    null: Option<&Shift>,
    differences: &[f64],
    gap_ms: Option<f64>,
    allowed: &Floor,
) -> (Pace, String) {
    let floor = allowed.log();
    let excludes_none = |of: &Shift| {
        of.interval
            .is_some_and(|[low, high]| low > 0.0 || high < 0.0)
    };
    if let Some(null) = null.filter(|null| excludes_none(null) && null.estimate.abs() >= floor) {
        let null = percent(null.estimate);
        let words = format!("base against base differed by {null:+.1} % in the same blocks");
        return (Pace::Unknown, words);
    }
    let sign = shift.estimate.signum();
    let agree = differences.iter().filter(|gap| *gap * sign > 0.0).count();
    let agreement = agree as f64 / differences.len() as f64;
    let is_far = shift.estimate.abs() >= floor;
    if is_far && excludes_none(shift) && agreement >= MIN_AGREEMENT {
        let Some(gap_ms) = gap_ms else {
            return (Pace::Unknown, NO_TIME.to_owned());
        };
        if gap_ms < allowed.ms {
            let words = format!("a difference below {} ms does not count", allowed.ms);
            return (Pace::Same, words);
        }
        return match () {
            () if sign > 0.0 => (Pace::Slower, String::new()),
            () if shift.estimate < MIN_PLAUSIBLE_RATIO.ln() => {
                let words = "so much faster that it may have stopped doing its work";
                (Pace::Collapsed, words.to_owned())
            }
            () => (Pace::Faster, String::new()),
        };
    }
    if shift.half_width() > floor {
        let width = percent(shift.half_width());
        let words = format!("too noisy: the interval is ±{width:.1} % wide");
        return (Pace::Unknown, words);
    }
    if is_far {
        let words = format!(
            "{agree} of {} blocks agree on the direction",
            differences.len()
        );
        return (Pace::Unknown, words);
    }
    (Pace::Same, String::new())
}

impl TimeGate {
    /// Measures each case's change by the smallest that fails.
    pub(crate) fn measure_by(&mut self, floors: &Floors) {
        for case in &mut self.cases {
            case.of_floor = case.over(&floors.of(case.span));
        }
    }
}

impl CaseTime {
    /// Its change over the floor that is further off: 40 % of three microseconds are nothing. `None` without a change.
    fn over(&self, floor: &Floor) -> Option<f64> {
        let factor = 1.0 + 0.01 * self.percent?;
        let of_percent = logarithm(factor)?.abs() / floor.log();
        let of_ms = (self.base_ms? * (factor - 1.0)).abs() / floor.ms;
        Some(of_percent.min(of_ms))
    }

    /// `+10.3 % [8.9 … 11.8], 20 of 20 blocks slower, stencil +0.210 ms`.
    #[must_use]
    pub fn sentence(&self) -> String {
        let mut parts = Vec::new();
        if let Some(percent) = self.percent {
            let interval = self.interval_percent.map_or(String::new(), |[low, high]| {
                format!(" [{low:+.1} … {high:+.1}]")
            });
            parts.push(format!("{percent:+.1} %{interval}"));
            parts.push(format!(
                "{} of {} blocks slower",
                self.slower_blocks, self.blocks
            ));
        }
        if !self.stages.is_empty() {
            parts.push(self.split());
        }
        if !self.words.is_empty() {
            parts.push(self.words.clone());
        }
        parts.join(", ")
    }

    /// Where the difference lies: `stencil +0.210 ms, colour -0.001 ms`.
    #[must_use]
    pub fn split(&self) -> String {
        let stages: Vec<String> = self.stages.iter().map(Stage::sentence).collect();
        stages.join(", ")
    }

    /// As a finding; `None` for a case that stayed the same.
    #[must_use]
    pub fn finding(&self, conditions: &BTreeMap<String, String>) -> Option<Finding> {
        let severity = match self.pace {
            Pace::Same => return None,
            Pace::Slower => Severity::Worse,
            Pace::Faster => Severity::Note,
            Pace::Collapsed | Pace::Unknown => Severity::Unknown,
        };
        Some(Finding {
            case: self.case.clone(),
            conditions: conditions.clone(),
            metric: self.metric.clone(),
            gate: Gate::Time,
            severity,
            from: milliseconds(self.base_ms),
            to: milliseconds(self.new_ms),
            words: format!("{}, {}", self.span.name(), self.sentence()),
            percent: self.percent,
            blessed: None,
        })
    }
}

/// As text; empty where there is none.
pub(crate) fn milliseconds(ms: Option<f64>) -> String {
    ms.map_or(String::new(), |ms| format!("{ms:.3} ms"))
}

#[cfg(test)]
mod tests;
