// SPDX-License-Identifier: MIT OR Apache-2.0
//! The time gate: two programs, run by turns in one job on one device.
//!
//! One process is one number: the median over its samples. Blocks of four processes go base, new, new,
//! base and the other way round by turns, so that what drifts evenly falls out. A block's difference is
//! the mean of ln(new) less that of ln(base). [`SCREEN_BLOCKS`] look at every case. What moved by
//! [`SCREEN_RATIO`], or spread too much to tell, is measured again in [`CONFIRM_BLOCKS`] *fresh* blocks,
//! which alone decide. Choosing cases by their first blocks biases these. Base against base within the
//! same blocks is the null: where it moves, the machine did.

use crate::threshold::{
    CONFIRM_BLOCKS, COVERAGE, FLOOR_PERCENT, MIN_AGREEMENT, MIN_CONFIRM_BLOCKS,
    MIN_PLAUSIBLE_RATIO, NULL_COVERAGE, SCREEN_BLOCKS, SCREEN_RATIO, floor_ms,
};
use crate::{Finding, Gate, GateError, Severity};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use terrafill_results::{Clock, Shift, median};

/// Which of the two programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// What is compared with.
    Base,
    /// What is to be decided about.
    New,
}

impl Side {
    /// Folder of its run, and its word in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::New => "new",
        }
    }
}

/// Case → process → milliseconds: the median over the process's samples.
pub type Times = BTreeMap<String, BTreeMap<u32, f64>>;

/// Two programs that can be measured, process by process.
pub trait Sides {
    /// Runs one process of a side, which times these cases.
    ///
    /// # Errors
    /// [`GateError`] when it does not end well.
    fn run(&mut self, side: Side, process: u32, cases: &BTreeSet<String>) -> Result<(), GateError>;

    /// Times of all processes of a side so far. A time that is zero, negative or no number is absent.
    ///
    /// # Errors
    /// [`GateError::Run`].
    fn times(&self, side: Side) -> Result<Times, GateError>;

    /// Time since the gate began.
    fn elapsed(&self) -> Duration;

    /// Hears what comes next.
    fn say(&mut self, what: &str);
}

/// What decides, beside the figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeOptions {
    /// The clock that the times are by.
    pub clock: Clock,
    /// Smallest change that fails, percent.
    pub floor_percent: f64,
    /// Smallest difference that fails, milliseconds.
    pub floor_ms: f64,
    /// When to stop measuring.
    pub budget: Duration,
}

impl TimeOptions {
    /// The usual floors by this clock.
    #[must_use]
    pub fn new(clock: Clock, budget: Duration) -> Self {
        Self {
            clock,
            floor_percent: FLOOR_PERCENT,
            floor_ms: floor_ms(clock),
            budget,
        }
    }

    /// The relative floor as a difference of logarithms.
    fn floor(&self) -> f64 {
        (0.01 * self.floor_percent).ln_1p()
    }
}

/// How a case's time compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
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
    Unknown,
}

/// What the time gate found of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseTime {
    /// Its key.
    pub case: String,
    /// How it compares.
    pub pace: Pace,
    /// Median over the base's processes, milliseconds; `None` without a usable time.
    pub base_ms: Option<f64>,
    /// Median over the new program's processes, milliseconds.
    pub new_ms: Option<f64>,
    /// Change in percent: Hodges–Lehmann of the deciding blocks, or the first look's median.
    pub percent: Option<f64>,
    /// 99 % interval of the change in percent; `None` where the first look decided.
    pub interval_percent: Option<[f64; 2]>,
    /// Base against base in the same blocks, percent.
    pub null_percent: Option<f64>,
    /// Blocks that decided.
    pub blocks: usize,
    /// Of these, blocks in which the new program was slower.
    pub slower_blocks: usize,
    /// Why it is inconclusive, or why a change does not count.
    pub words: String,
}

/// Four processes: numbers of the base's and the new program's, in the order in which they ran.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Processes of the base.
    pub base: [u32; 2],
    /// Processes of the new program.
    pub new: [u32; 2],
}

/// What the time gate found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TimeGate {
    /// Every case that was to be timed.
    pub cases: Vec<CaseTime>,
    /// Blocks of the first look.
    pub screen: Vec<Block>,
    /// Blocks that decided on the cases that moved.
    pub confirm: Vec<Block>,
}

/// Measures and compares the times of `cases`.
///
/// # Errors
/// [`GateError`] of a program that does not run; [`GateError::NothingMeasured`] where the budget ends
/// before the first look does.
pub fn compare_times(
    sides: &mut dyn Sides,
    cases: &BTreeSet<String>,
    options: &TimeOptions,
) -> Result<TimeGate, GateError> {
    let mut next_process = 1;
    let screen = blocks(
        sides,
        cases,
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
    let times = both(sides)?;
    let mut looked_at: Vec<CaseTime> = cases
        .iter()
        .map(|case| first_look(case, &screen, &times, options))
        .collect();
    let again: BTreeSet<String> = looked_at
        .iter()
        .filter(|case| case.pace != Pace::Same && case.percent.is_some())
        .map(|case| case.case.clone())
        .collect();
    let mut confirm = Vec::new();
    if !again.is_empty() {
        let what = format!("{} cases again", again.len());
        confirm = blocks(
            sides,
            &again,
            options,
            CONFIRM_BLOCKS,
            &mut next_process,
            &what,
        )?;
        let times = both(sides)?;
        for case in looked_at
            .iter_mut()
            .filter(|case| again.contains(&case.case))
        {
            *case = decide(&case.case, &confirm, &times, options);
        }
    }
    Ok(TimeGate {
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
        let order = if number % 2 == 1 {
            [Side::Base, Side::New, Side::New, Side::Base]
        } else {
            [Side::New, Side::Base, Side::Base, Side::New]
        };
        let mut processes = BTreeMap::from([(Side::Base, Vec::new()), (Side::New, Vec::new())]);
        for side in order {
            sides.run(side, *next_process, cases)?;
            processes.entry(side).or_default().push(*next_process);
            *next_process += 1;
        }
        let of = |side| match processes.get(&side).map(Vec::as_slice) {
            Some(&[first, second]) => [first, second],
            _ => [0, 0],
        };
        blocks.push(Block {
            base: of(Side::Base),
            new: of(Side::New),
        });
    }
    Ok(blocks)
}

fn both(sides: &dyn Sides) -> Result<[Times; 2], GateError> {
    Ok([sides.times(Side::Base)?, sides.times(Side::New)?])
}

/// Natural logarithms of a case's times in one program's processes of all blocks; `None` where one is
/// absent.
fn logarithms(case: &str, times: &Times, processes: impl Iterator<Item = u32>) -> Option<Vec<f64>> {
    let times = times.get(case)?;
    let logarithms = processes.map(|process| {
        let ms = *times.get(&process)?;
        (ms.is_finite() && ms > 0.0).then(|| ms.ln())
    });
    logarithms.collect()
}

/// A block's difference of logarithms, for each block.
fn differences(case: &str, blocks: &[Block], [base, new]: &[Times; 2]) -> Option<Vec<f64>> {
    let base = logarithms(case, base, blocks.iter().flat_map(|block| block.base))?;
    let new = logarithms(case, new, blocks.iter().flat_map(|block| block.new))?;
    let pairs = base.chunks_exact(2).zip(new.chunks_exact(2));
    Some(
        pairs
            .map(|(base, new)| 0.5 * (new[0] + new[1] - base[0] - base[1]))
            .collect(),
    )
}

/// Base against base: of two blocks' four base processes the outer ones less the inner ones, with the
/// sign turned from pair to pair, so that an even drift falls out.
fn null_differences(case: &str, blocks: &[Block], base: &Times) -> Option<Vec<f64>> {
    let base = logarithms(case, base, blocks.iter().flat_map(|block| block.base))?;
    let pairs = base.chunks_exact(4).enumerate();
    Some(
        pairs
            .map(|(index, of)| {
                let gap = 0.5 * (of[0] + of[3] - of[1] - of[2]);
                if index % 2 == 0 { gap } else { -gap }
            })
            .collect(),
    )
}

fn percent(logarithm: f64) -> f64 {
    100.0 * logarithm.exp_m1()
}

/// Median over all of a program's processes in the blocks.
fn middle_ms(case: &str, times: &Times, processes: impl Iterator<Item = u32>) -> Option<f64> {
    let logarithms = logarithms(case, times, processes)?;
    median(&logarithms).map(f64::exp)
}

fn case_time(case: &str, blocks: &[Block], [base, new]: &[Times; 2]) -> CaseTime {
    CaseTime {
        case: case.to_owned(),
        pace: Pace::Unknown,
        base_ms: middle_ms(case, base, blocks.iter().flat_map(|block| block.base)),
        new_ms: middle_ms(case, new, blocks.iter().flat_map(|block| block.new)),
        percent: None,
        interval_percent: None,
        null_percent: None,
        blocks: blocks.len(),
        slower_blocks: 0,
        words: String::new(),
    }
}

const NO_TIME: &str = "a process of it has no usable time";

/// Whether a case is measured again. A case whose first blocks spread so widely that a change of the
/// floor's size could hide in them is.
fn first_look(case: &str, blocks: &[Block], times: &[Times; 2], options: &TimeOptions) -> CaseTime {
    let mut found = case_time(case, blocks, times);
    let Some(differences) = differences(case, blocks, times) else {
        found.words = NO_TIME.to_owned();
        return found;
    };
    let Some(middle) = median(&differences) else {
        return found;
    };
    found.percent = Some(percent(middle));
    found.slower_blocks = differences.iter().filter(|gap| **gap > 0.0).count();
    let spread = differences.iter().map(|gap| (gap - middle).abs());
    let spread = median(&spread.collect::<Vec<_>>()).unwrap_or(f64::INFINITY);
    found.pace = if middle.abs() >= SCREEN_RATIO.ln() || spread > options.floor() {
        Pace::Unknown
    } else {
        Pace::Same
    };
    found
}

/// The verdict of fresh blocks.
fn decide(case: &str, blocks: &[Block], times: &[Times; 2], options: &TimeOptions) -> CaseTime {
    let mut found = case_time(case, blocks, times);
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
    let null = null_differences(case, blocks, &times[0])
        .and_then(|differences| Shift::of(&differences, NULL_COVERAGE));
    found.percent = Some(percent(shift.estimate));
    found.interval_percent = shift.interval.map(|interval| interval.map(percent));
    found.null_percent = null.map(|null| percent(null.estimate));
    found.slower_blocks = differences.iter().filter(|gap| **gap > 0.0).count();
    let gap_ms = found
        .base_ms
        .zip(found.new_ms)
        .map(|(base, new)| (new - base).abs());
    let (pace, words) = pace(&shift, null.as_ref(), &differences, gap_ms, options);
    found.pace = pace;
    found.words = words;
    found
}

/// A change counts when the interval excludes none, the estimate reaches both floors, and the blocks
/// agree. It is inconclusive where the null moved as much, or the interval is wider than the floor.
fn pace(
    shift: &Shift,
    null: Option<&Shift>,
    differences: &[f64],
    gap_ms: Option<f64>,
    options: &TimeOptions,
) -> (Pace, String) {
    let floor = options.floor();
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
        if gap_ms < options.floor_ms {
            let words = format!("a difference below {} ms does not count", options.floor_ms);
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

impl CaseTime {
    /// `+10.3 % [8.9 … 11.8], 12.31 → 13.58 ms, 20 of 20 blocks slower`.
    #[must_use]
    pub fn sentence(&self) -> String {
        let mut parts = Vec::new();
        if let Some(percent) = self.percent {
            let interval = self.interval_percent.map_or(String::new(), |[low, high]| {
                format!(" [{low:+.1} … {high:+.1}]")
            });
            parts.push(format!("{percent:+.1} %{interval}"));
        }
        if let (Some(base), Some(new)) = (self.base_ms, self.new_ms) {
            parts.push(format!("{base:.3} → {new:.3} ms"));
        }
        if self.percent.is_some() {
            parts.push(format!(
                "{} of {} blocks slower",
                self.slower_blocks, self.blocks
            ));
        }
        if !self.words.is_empty() {
            parts.push(self.words.clone());
        }
        parts.join(", ")
    }

    /// As a finding; `None` for a case that stayed the same.
    ///
    /// - `metric`: that was compared
    #[must_use]
    pub fn finding(&self, metric: &str, conditions: &BTreeMap<String, String>) -> Option<Finding> {
        let severity = match self.pace {
            Pace::Same => return None,
            Pace::Slower => Severity::Worse,
            Pace::Faster => Severity::Note,
            Pace::Collapsed | Pace::Unknown => Severity::Unknown,
        };
        Some(Finding {
            case: self.case.clone(),
            conditions: conditions.clone(),
            metric: metric.to_owned(),
            gate: Gate::Time,
            severity,
            from: String::new(),
            to: String::new(),
            words: self.sentence(),
            percent: self.percent,
            blessed: None,
        })
    }
}

#[cfg(test)]
mod tests;
