// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times that a process takes once: preparation and planning.
//!
//! The first process of each side measures them while it verifies its pictures, so a first look is free. What moved
//! there is looked at once more, and what moved again is measured in [`SETUP_PAIRS`] fresh pairs of processes, which
//! alone decide. So a gate in which nothing moved pays nothing for it.

use crate::block::{deviation, logarithm, percent};
use crate::threshold::{SCREEN_SHARE, SETUP_COVERAGE, SETUP_LOOKS, SETUP_PAIRS};
use crate::time::{NO_TIME, pace};
use crate::{CaseTime, GateError, Pace, Side, Sides, TimeOptions, Times, Watched};
use std::time::Duration;
use terrafill_results::{Shift, median};

/// Measures and compares times that a process takes once.
///
/// # Errors
/// [`GateError`] of a program that does not run.
pub fn compare_setups(
    sides: &mut dyn Sides,
    watched: &[Watched],
    options: &TimeOptions,
) -> Result<Vec<CaseTime>, GateError> {
    let mut found = Vec::new();
    let mut verified = 1;
    let mut longest = Duration::ZERO;
    for look in 1..=SETUP_LOOKS {
        found = looked_at(sides, watched, options, 0..look);
        let moved = found.iter().filter(|case| case.pace == Pace::Unknown);
        let moved = moved.filter(|case| case.percent.is_some()).count();
        if moved == 0 {
            return Ok(found);
        }
        let more = if look < SETUP_LOOKS { 1 } else { SETUP_PAIRS };
        for number in verified..verified + more {
            let started = sides.elapsed();
            if started + longest > options.budget {
                let words =
                    "it moved at first, and the time budget for setups ended before it was decided";
                let undecided = found.iter_mut().filter(|case| case.pace == Pace::Unknown);
                undecided.for_each(|case| words.clone_into(&mut case.words));
                return Ok(found);
            }
            sides.say(&format!("setup of {moved} cases again: pair {number}"));
            sides.verify_again(number)?;
            longest = longest.max(sides.elapsed() - started);
        }
        verified += more;
    }
    let fresh = SETUP_LOOKS..SETUP_LOOKS + SETUP_PAIRS;
    for of in watched {
        let times = both(sides, &of.metric);
        let cases = found.iter_mut().filter(|case| case.metric == of.metric);
        for case in cases.filter(|case| case.pace == Pace::Unknown && case.percent.is_some()) {
            *case = decide(&case.case, of, fresh.clone(), &times, options);
        }
    }
    Ok(found)
}

fn both(sides: &dyn Sides, metric: &str) -> [Times; 2] {
    [Side::Base, Side::New].map(|side| sides.setups(side, metric))
}

/// Cases after their first looks: the same, or so far off that they are measured again.
fn looked_at(
    sides: &dyn Sides,
    watched: &[Watched],
    options: &TimeOptions,
    looks: std::ops::Range<u32>,
) -> Vec<CaseTime> {
    let mut found = Vec::new();
    for of in watched {
        let times = both(sides, &of.metric);
        let floor = options.floors.of(of.span);
        for case in &of.cases {
            let mut case = case_time(case, of, looks.clone(), &times);
            if let Some(log) =
                differences(&case.case, looks.clone(), &times).and_then(|d| median(&d))
            {
                let gap_ms = case.base_ms.unwrap_or(0.0) * log.exp_m1().abs();
                let is_far =
                    log.abs() >= SCREEN_SHARE * floor.log() && gap_ms >= SCREEN_SHARE * floor.ms;
                case.percent = Some(percent(log));
                case.pace = if is_far { Pace::Unknown } else { Pace::Same };
            } else {
                case.words = NO_TIME.to_owned();
            }
            found.push(case);
        }
    }
    found
}

fn case_time(
    case: &str,
    of: &Watched,
    looks: std::ops::Range<u32>,
    [base, new]: &[Times; 2],
) -> CaseTime {
    let ms = |times: &Times| {
        let values: Option<Vec<f64>> = looks.clone().map(|look| value(case, look, times)).collect();
        median(&values?).map(f64::exp)
    };
    CaseTime {
        case: case.to_owned(),
        metric: of.metric.clone(),
        span: of.span,
        base_ms: ms(base),
        new_ms: ms(new),
        blocks: looks.len(),
        ..CaseTime::default()
    }
}

/// Logarithm of what one verification measured; `None` for what is no time.
fn value(case: &str, look: u32, times: &Times) -> Option<f64> {
    logarithm(*times.get(case)?.get(&look)?.values().next()?)
}

fn differences(
    case: &str,
    looks: std::ops::Range<u32>,
    [base, new]: &[Times; 2],
) -> Option<Vec<f64>> {
    looks
        .map(|look| Some(value(case, look, new)? - value(case, look, base)?))
        .collect()
}

/// The verdict of fresh pairs.
fn decide(
    case: &str,
    of: &Watched,
    fresh: std::ops::Range<u32>,
    times: &[Times; 2],
    options: &TimeOptions,
) -> CaseTime {
    let mut found = case_time(case, of, fresh.clone(), times);
    let Some(differences) = differences(case, fresh, times) else {
        found.words = NO_TIME.to_owned();
        return found;
    };
    let Some(shift) = Shift::of(&differences, SETUP_COVERAGE) else {
        return found;
    };
    let floor = options.floors.of(of.span);
    found.percent = Some(percent(shift.estimate));
    found.interval_percent = shift.interval.map(|interval| interval.map(percent));
    found.spread_percent = deviation(&differences).map(percent);
    found.slower_blocks = differences.iter().filter(|gap| **gap > 0.0).count();
    let gap_ms = found
        .base_ms
        .map(|base| base * shift.estimate.exp_m1().abs());
    let (pace, words) = pace(&shift, None, &differences, gap_ms, &floor);
    found.pace = match pace {
        // Work that is left out of a frame's preparation is missed where the frame is drawn.
        Pace::Collapsed => Pace::Faster,
        // Wide, and no change that fails.
        Pace::Unknown if shift.estimate.abs() < floor.log() => Pace::Same,
        other => other,
    };
    found.words = words;
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Span, TimingOrder, Trio};
    use std::collections::{BTreeMap, BTreeSet};
    use terrafill_results::{Clock, SplitMix64};

    /// Programs whose preparation takes 10 ms and `factor` times that, in each process up to `noise` more or less.
    struct MadeUp {
        factor: f64,
        noise: f64,
        /// Of the first verification alone, of the new side.
        first: f64,
        way: TimingOrder,
        verified: u32,
    }

    impl MadeUp {
        fn new(factor: f64) -> Self {
            Self {
                factor,
                noise: 0.1,
                first: 1.0,
                way: TimingOrder::LockStep,
                verified: 1,
            }
        }
    }

    impl Sides for MadeUp {
        fn way(&self) -> &TimingOrder {
            &self.way
        }

        fn run_together(&mut self, _: Trio, _: &BTreeSet<String>) -> Result<(), GateError> {
            Ok(())
        }

        fn run(&mut self, _: Side, _: u32, _: &BTreeSet<String>) -> Result<(), GateError> {
            Ok(())
        }

        fn times(&mut self, _: Side, _: &str) -> Result<Times, GateError> {
            Ok(Times::new())
        }

        fn verify_again(&mut self, _number: u32) -> Result<(), GateError> {
            self.verified += 1;
            Ok(())
        }

        fn setups(&self, side: Side, _metric: &str) -> Times {
            let value = |number: u32| {
                let seed = u64::from(2 * number) + side.index() as u64;
                let noise = 1.0 + self.noise * (2.0 * SplitMix64::new(seed).unit() - 1.0);
                let factor = match (side, number) {
                    (Side::Base, _) => 1.0,
                    (Side::New, 0) => self.factor * self.first,
                    (Side::New, _) => self.factor,
                };
                10.0 * factor * noise
            };
            let of =
                (0..self.verified).map(|number| (number, BTreeMap::from([(0, value(number))])));
            Times::from([("filling/a".to_owned(), of.collect())])
        }

        fn elapsed(&self) -> Duration {
            Duration::from_secs(20 * u64::from(self.verified))
        }

        fn say(&mut self, _: &str) {}
    }

    fn compared(mut sides: MadeUp, budget_s: u64) -> (CaseTime, u32) {
        let watched = Watched {
            metric: "prepare_cpu_ms".to_owned(),
            span: Span::Preparation,
            cases: BTreeSet::from(["filling/a".to_owned()]),
        };
        let options = TimeOptions::new(Clock::ProcessCpu, Duration::from_secs(budget_s));
        let mut found = compare_setups(&mut sides, &[watched], &options).expect("measured");
        assert_eq!(found.len(), 1);
        (found.remove(0), sides.verified)
    }

    #[test]
    fn preparation_five_times_as_long_is_called_by_its_name_and_equal_work_costs_nothing() {
        let (case, verified) = compared(MadeUp::new(5.0), 600);
        assert_eq!((case.pace, verified), (Pace::Slower, 8));
        assert!(
            (case.percent.expect("measured") - 400.0).abs() < 40.0,
            "{case:?}"
        );
        let finding = case.finding(&BTreeMap::new()).expect("a finding");
        let sentence = finding.sentence();
        assert!(
            sentence.starts_with("prepare_cpu_ms 1") && sentence.contains("ms: preparation, +"),
            "{sentence}"
        );
        // Negative control: the same work takes the first look alone.
        let (case, verified) = compared(MadeUp::new(1.0), 600);
        assert_eq!((case.pace, verified), (Pace::Same, 1));
        let (case, _) = compared(MadeUp::new(0.2), 600);
        assert_eq!(case.pace, Pace::Faster);
    }

    #[test]
    fn a_first_process_that_was_held_up_is_no_change() {
        let held_up = |first| MadeUp {
            first,
            ..MadeUp::new(1.0)
        };
        let (case, verified) = compared(held_up(1.6), 600);
        assert_eq!((case.pace, verified), (Pace::Same, 2), "{case:?}");
        // So long that two looks do not settle it: fresh pairs do.
        let (case, verified) = compared(held_up(3.0), 600);
        assert_eq!((case.pace, verified), (Pace::Same, 8), "{case:?}");
    }

    #[test]
    fn what_the_budget_leaves_undecided_and_what_is_no_time_is_no_pass() {
        let (case, _) = compared(MadeUp::new(5.0), 100);
        assert_eq!(case.pace, Pace::Unknown);
        assert!(
            case.words.contains("time budget for setups"),
            "{}",
            case.words
        );
        for value in [0.0, f64::NAN] {
            let (case, _) = compared(MadeUp::new(value), 600);
            assert_eq!((case.pace, case.words.as_str()), (Pace::Unknown, NO_TIME));
        }
    }
}
