// SPDX-License-Identifier: MIT OR Apache-2.0
//! Proof of the time gate on the machine at hand: how often it raises a false alarm, and how often it
//! catches work that was really added; and by how much it leans to one side, see `bias`. The added work is frames: of every sample of so many frames, the
//! changed side draws a few more and adds their cost.

use crate::{
    Bias, CaseTime, GateError, GatedTimes, GroupBias, Job, Pace, Program, Side, Sides as _, Span,
    TimeOptions, Workload, compare_setups, compare_times, watched,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;
use terrafill_results::{rate_bounds, spread};

/// Coverage of the bounds of a rate.
const RATE_COVERAGE: f64 = 0.95;

/// Samples of a case in each process that runs by itself, where they are means of many frames.
const INJECTED_SAMPLES: u32 = 9;

/// Work added to one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Injection {
    /// Frames of a sample.
    pub frames: u32,
    /// Frames added to it.
    pub extra: u32,
}

impl Injection {
    /// The smallest sample of at least 10 frames of which a whole number is this share; `None` for less
    /// than 1 or more than 100 percent.
    #[must_use]
    pub fn percent(percent: u32) -> Option<Self> {
        if !(1..=100).contains(&percent) {
            return None;
        }
        let is_whole = |frames: &u32| (frames * percent).is_multiple_of(100);
        let frames = (10..=100).find(is_whole)?;
        Some(Self {
            frames,
            extra: frames * percent / 100,
        })
    }
}

/// What is to be proved, and how often.
#[derive(Debug, Clone)]
pub struct SelfTest {
    /// `None`: both sides do the same.
    pub injection: Option<Injection>,
    /// Gates to run.
    pub runs: u32,
    /// Time for each of them.
    pub budget: Duration,
    /// Smallest change that fails, percent.
    pub floor_percent: f64,
}

/// How the cases of all gates ended, one case of one gate being one case-run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Rates {
    /// Gates that were run.
    pub gates: u32,
    /// Case-runs.
    pub case_runs: u32,
    /// Called slower where the new side had more work, or the same.
    pub slower: u32,
    /// Called faster there.
    pub faster: u32,
    /// Inconclusive.
    pub unknown: u32,
    /// Case-runs in which the base had the more work.
    pub swapped_case_runs: u32,
    /// Of these, called faster, as they should.
    pub swapped_faster: u32,
    /// Of these, called slower.
    pub swapped_slower: u32,
    /// Of these, inconclusive.
    pub swapped_unknown: u32,
    /// Standard deviation of each case-run's deciding blocks, percent.
    pub spreads_percent: Vec<f64>,
}

impl Rates {
    /// Counts a gate's cases.
    pub fn count(&mut self, cases: &[CaseTime], is_swapped: bool) {
        let paces: Vec<Pace> = cases.iter().map(|case| case.pace).collect();
        let spreads = cases.iter().filter_map(|case| case.spread_percent);
        self.spreads_percent.extend(spreads);
        let of = |wanted: &[Pace]| {
            let found = paces.iter().filter(|pace| wanted.contains(pace)).count();
            u32::try_from(found).unwrap_or(u32::MAX)
        };
        let all = u32::try_from(paces.len()).unwrap_or(u32::MAX);
        let (slower, unknown) = (of(&[Pace::Slower]), of(&[Pace::Unknown]));
        let faster = of(&[Pace::Faster, Pace::Collapsed]);
        self.gates += 1;
        if is_swapped {
            self.swapped_case_runs += all;
            self.swapped_slower += slower;
            self.swapped_faster += faster;
            self.swapped_unknown += unknown;
        } else {
            self.case_runs += all;
            self.slower += slower;
            self.faster += faster;
            self.unknown += unknown;
        }
    }

    /// Case-runs in which the same work was called slower or faster; with an injection, those called the wrong way.
    #[must_use]
    pub fn false_alarms(&self, injection: Option<Injection>) -> u32 {
        match injection {
            None => self.slower + self.faster,
            Some(_) => self.faster + self.swapped_slower,
        }
    }

    /// The rates with their 95 % bounds, a line each.
    ///
    /// - `injection`: what was added; `None` where both sides did the same
    #[must_use]
    pub fn sentences(&self, injection: Option<Injection>) -> Vec<String> {
        let rate_of = |hits: u32, of: u32, what: &str| {
            let [low, high] = rate_bounds(hits, of, RATE_COVERAGE).map(|bound| 100.0 * bound);
            let share = 100.0 * f64::from(hits) / f64::from(of.max(1));
            format!("{what}: {hits} of {of} case-runs, {share:.1} % [{low:.1} … {high:.1}]")
        };
        let spread = spread(&self.spreads_percent).map_or(String::new(), |spread| {
            format!(
                "; standard deviation of a case's blocks {:.2} % ({:.2} … {:.2})",
                spread.median, spread.p5, spread.p95
            )
        });
        let gates = format!("{} gates{spread}", self.gates);
        let of_new = if injection.is_some() {
            "more on the new side, "
        } else {
            ""
        };
        let new = |hits, call: &str| rate_of(hits, self.case_runs, &format!("{of_new}{call}"));
        let rates_of_new = [
            new(self.slower, "called slower"),
            new(self.faster, "called faster"),
            new(self.unknown, "inconclusive"),
        ];
        let Some(Injection { frames, extra }) = injection else {
            let head = format!("same work on both sides, {gates}");
            return std::iter::once(head).chain(rates_of_new).collect();
        };
        let percent = 100.0 * f64::from(extra) / f64::from(frames);
        let head =
            format!("{percent} % more work on one side ({extra} more frames of {frames}), {gates}");
        let base = |hits, call: &str| {
            let what = format!("more on the base's side, {call}");
            rate_of(hits, self.swapped_case_runs, &what)
        };
        let rates_of_base = [
            base(self.swapped_faster, "called faster"),
            base(self.swapped_slower, "called slower"),
            base(self.swapped_unknown, "inconclusive"),
        ];
        let rates = rates_of_new.into_iter().chain(rates_of_base);
        std::iter::once(head).chain(rates).collect()
    }
}

/// What a self-test found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Proof {
    /// How often it was right.
    pub rates: Rates,
    /// By how much it leans; of equal work alone.
    pub bias: Bias,
}

impl Proof {
    /// Rates and means, a line each.
    #[must_use]
    pub fn sentences(&self, injection: Option<Injection>) -> Vec<String> {
        let mut lines = self.rates.sentences(injection);
        lines.extend(self.bias.groups().iter().map(GroupBias::sentence));
        lines
    }

    /// Whether it called what it should not have called, or leans to one side.
    #[must_use]
    pub fn is_wrong(&self, injection: Option<Injection>) -> bool {
        let is_biased = self.bias.groups().iter().any(GroupBias::is_biased);
        is_biased || self.rates.false_alarms(injection) > 0
    }
}

/// Runs the time gate again and again over two programs of the same work. In every second gate their roles are
/// swapped; with an injection, the base's side has it instead.
///
/// - `out`: a folder for the run folders, one for each gate
/// - `done`: gets what was found after each gate
///
/// # Errors
/// [`GateError`] of a gate; [`GateError::NothingMeasured`] where no case is timed.
pub fn self_test(
    test: &SelfTest,
    programs: &[Program; 2],
    workload: &Workload,
    out: &Path,
    gated: GatedTimes<'_>,
    say: &mut dyn FnMut(&str),
    done: &mut dyn FnMut(&Proof),
) -> Result<Proof, GateError> {
    let mut proof = Proof::default();
    for number in 0..test.runs {
        let is_swapped = number % 2 == 1;
        let mut programs = programs.clone();
        if is_swapped && test.injection.is_none() {
            programs.reverse();
        }
        let mut workload = workload.clone();
        if let Some(Injection { frames, extra }) = test.injection {
            workload.frames = frames;
            workload.samples = INJECTED_SAMPLES;
            workload.extra = if is_swapped { [extra, 0] } else { [0, extra] };
        }
        let folder = out.join(format!("gate-{number:03}"));
        let mut say = |what: &str| say(&format!("gate {} of {}, {what}", number + 1, test.runs));
        let mut job = Job::new(programs, workload, &folder, &mut say)?;
        let (base, new) = (job.verify(Side::Base)?, job.verify(Side::New)?);
        let [of_frames, of_setups] = watched(&base, &new, gated);
        if of_frames.iter().all(|of| of.span != Span::Frame) {
            let message = "no case is right and timed on both sides".to_owned();
            return Err(GateError::NothingMeasured(message));
        }
        let mut options = TimeOptions::new(new.clock(), test.budget);
        options.floors.frame.percent = test.floor_percent;
        let mut gate = compare_times(&mut job, &of_frames, &options)?;
        if test.injection.is_none() {
            // Of equal work no side is the slower one.
            let mut times = BTreeMap::new();
            for of in of_frames.iter().filter(|of| of.span == Span::Frame) {
                let base = job.times(Side::Base, &of.metric)?;
                let new = job.times(Side::New, &of.metric)?;
                times.insert(of.metric.clone(), [base, new]);
            }
            proof.bias.count(&gate, &times, is_swapped);
            gate.cases
                .extend(compare_setups(&mut job, &of_setups, &options)?);
            proof.rates.count(&gate.cases, false);
        } else {
            // Frames are what is added.
            gate.cases.retain(|case| case.span == Span::Frame);
            proof.rates.count(&gate.cases, is_swapped);
        }
        done(&proof);
    }
    Ok(proof)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_work_is_a_whole_number_of_frames() {
        let of = |percent| Injection::percent(percent).map(|i| (i.frames, i.extra));
        assert_eq!(of(10), Some((10, 1)));
        assert_eq!(of(5), Some((20, 1)));
        assert_eq!(of(3), Some((100, 3)));
        assert_eq!(of(100), Some((10, 10)));
        assert_eq!((of(0), of(101), of(u32::MAX)), (None, None, None));
    }

    #[test]
    fn a_self_test_that_leans_or_calls_equal_work_is_wrong() {
        assert!(!Proof::default().is_wrong(None));
        let mut called = Proof::default();
        called.rates.slower = 1;
        assert!(called.is_wrong(None));
    }

    #[cfg(unix)]
    #[test]
    fn equal_programs_are_unbiased_and_a_later_start_that_the_gate_made_slower_is_seen() {
        use crate::fake_program::{Fake, gated};
        let mean = |new: Fake| {
            let place = tempfile::tempdir().expect("a folder");
            let programs = [
                Fake::default().write(place.path(), "old"),
                new.write(place.path(), "new"),
            ];
            let test = SelfTest {
                injection: None,
                runs: 2,
                budget: Duration::from_secs(600),
                floor_percent: 3.0,
            };
            let workload = Workload {
                samples: 30,
                frames: 1,
                ..Workload::default()
            };
            let out = place.path().join("out");
            let (mut say, mut done) = (|_: &str| {}, |_: &Proof| {});
            self_test(
                &test, &programs, &workload, &out, &gated, &mut say, &mut done,
            )
            .expect("measured")
        };
        let proof = mean(Fake::default());
        assert!(!proof.is_wrong(None), "{:?}", proof.sentences(None));
        assert_eq!(proof.bias.groups().len(), 2);
        // 2.3 % faster is called by no gate, and is no equal work: each way round, with the other sign.
        let faster = Fake {
            fill_cpu_ms: 9.77,
            ..Fake::default()
        };
        let proof = mean(faster);
        assert_eq!(proof.rates.false_alarms(None), 0);
        assert!(proof.is_wrong(None), "{:?}", proof.sentences(None));
        let groups = proof.bias.groups();
        let percent =
            [groups[0].as_given, groups[0].swapped].map(|mean| mean.expect("one").percent());
        assert!(
            (percent[0] + 2.3).abs() < 0.01 && (percent[1] - 2.354).abs() < 0.01,
            "{percent:?}"
        );
        assert!(!groups[0].mirror().expect("both").is_biased());
    }

    #[test]
    fn rates_count_each_direction_by_itself() {
        use Pace::{Collapsed, Faster, Same, Slower, Unknown};
        let cases = |paces: [Pace; 4]| {
            paces.map(|pace| CaseTime {
                case: "filling/a".to_owned(),
                pace,
                spread_percent: Some(1.5),
                ..CaseTime::default()
            })
        };
        let mut rates = Rates::default();
        rates.count(&cases([Slower, Slower, Unknown, Same]), false);
        rates.count(&cases([Faster, Collapsed, Slower, Unknown]), true);
        let found = [rates.slower, rates.faster, rates.unknown, rates.case_runs];
        assert_eq!(found, [2, 0, 1, 4]);
        let swapped = [
            rates.swapped_faster,
            rates.swapped_slower,
            rates.swapped_unknown,
            rates.swapped_case_runs,
        ];
        assert_eq!(swapped, [2, 1, 1, 4]);
        // One slower where the base had more; of the same work all calls are wrong.
        assert_eq!(rates.false_alarms(Injection::percent(5)), 1);
        assert_eq!(rates.false_alarms(None), 2);
        assert_eq!(Rates::default().false_alarms(None), 0);
        let lines = rates.sentences(Injection::percent(5));
        assert!(lines[0].starts_with("5 % more work"), "{lines:?}");
        assert!(
            lines[0].ends_with("blocks 1.50 % (1.50 … 1.50)"),
            "{lines:?}"
        );
        assert!(lines[1].contains("2 of 4 case-runs, 50.0 %"), "{lines:?}");
        let none = Rates::default().sentences(None);
        assert!(
            none[1].contains("0 of 0 case-runs, 0.0 % [0.0 … 100.0]"),
            "{none:?}"
        );
    }
}
