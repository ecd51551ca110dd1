// SPDX-License-Identifier: MIT OR Apache-2.0
//! How many times as much one case costs as another, over processes, and what that says of a claim.
//!
//! One process is one replicate: the median over its samples (frames of one process are not
//! independent). Both cases of a ratio are measured by every process, in the same blocks, so process
//! *i* of the one is paired with process *i* of the other: what the machine did then falls on both.
//! The ratio is the median over processes of cost over cost; its interval is the 2.5th to the 97.5th
//! percentile of that median over resampled processes (Efron, 1979, "Bootstrap methods"). With fewer
//! than [`MIN_REPLICATES`] processes there is a ratio and no interval.

use crate::resample::{generator, resampled_median};
use crate::threshold::{BOOTSTRAP_RESAMPLES, INTERVAL_COVERAGE, MIN_DIFFERENCE, MIN_REPLICATES};
use crate::{Case, Spread, Standing, median, quantile, spread};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A figure from several processes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Median over the processes.
    pub middle: f64,
    /// 95 % interval of the median; `None` with too few processes.
    pub interval: Option<[f64; 2]>,
    /// Processes behind it.
    pub processes: usize,
}

impl Estimate {
    /// A figure that no process changes: its interval has no width.
    #[must_use]
    pub fn exact(middle: f64) -> Self {
        Self {
            middle,
            interval: Some([middle; 2]),
            processes: 0,
        }
    }
}

/// A claim about how many times faster something became. In files: `"faster"`, `{ at-least = 2.0 }`,
/// `{ factor = { of = 0.5, within = 1.25 } }`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Claim {
    /// It is faster by more than nothing.
    Faster,
    /// It makes no difference.
    NoDifference,
    /// It is not faster, and may be slower.
    NotFaster,
    /// It is faster by this factor, or slower by one below 1.
    Factor {
        /// The factor as stated.
        of: f64,
        /// By how many times the statement may be off, 1 or more.
        within: f64,
    },
    /// It is faster by less than this factor.
    LessThan(f64),
    /// It is faster by this factor or more.
    AtLeast(f64),
}

impl Claim {
    /// What a measured gain says of it.
    ///
    /// - `gain`: cost before over cost after; without an interval nothing can be told
    #[must_use]
    pub fn standing(self, gain: &Estimate) -> Standing {
        self.standing_beyond(gain, MIN_DIFFERENCE)
    }

    /// The same with another idea of what is no difference.
    ///
    /// - `band`: ratios closer to 1 than this factor are none; 1 or more
    #[must_use]
    pub fn standing_beyond(self, gain: &Estimate, band: f64) -> Standing {
        let Some([low, high]) = gain.interval else {
            return Standing::CannotTell;
        };
        let least = 1.0 / band;
        let is_none = low >= least && high <= band;
        let (holds, fails) = match self {
            Self::Faster => (low > band, high <= band),
            Self::NotFaster => (high <= band, low > band),
            Self::NoDifference => (low >= least && high <= band, low > band || high < least),
            Self::Factor { of, within } => {
                let off = within.max(band);
                let (least, most) = (of / off, of * off);
                (low >= least && high <= most, low > most || high < least)
            }
            Self::LessThan(limit) => (high < limit, low > limit),
            Self::AtLeast(limit) => (low >= limit, high < limit),
        };
        match (holds, fails) {
            (true, false) => Standing::Holds,
            // Of a claim that something changes by much this is an answer as well.
            (false, true) if is_none && self != Self::NoDifference => Standing::NoDifference,
            (false, true) => Standing::DoesNotHold,
            _ => Standing::CannotTell,
        }
    }
}

/// One number for each process: the median over the usable samples of a time, which are finite and
/// positive.
#[must_use]
pub fn process_medians(case: &Case, metric: impl AsRef<str>) -> BTreeMap<u32, f64> {
    let processes = case.samples(metric).into_iter().flatten();
    processes
        .filter_map(|(process, samples)| {
            let usable: Vec<f64> = samples
                .values()
                .copied()
                .filter(|v| is_usable(*v))
                .collect();
            Some((*process, median(&usable)?))
        })
        .collect()
}

/// Spread of all usable samples of a time over all processes: what a reader may expect of one frame,
/// and no interval of anything.
#[must_use]
pub fn sample_spread(case: &Case, metric: impl AsRef<str>) -> Option<Spread> {
    let samples = case.samples(metric)?.values();
    let usable: Vec<f64> = samples
        .flat_map(|samples| samples.values().copied())
        .filter(|value| is_usable(*value))
        .collect();
    spread(&usable)
}

fn is_usable(time: f64) -> bool {
    time.is_finite() && time > 0.0
}

/// `metric` of `case` over that of `other`, paired by process; `None` without a process that measured
/// both.
#[must_use]
pub fn ratio(case: &Case, other: &Case, metric: impl AsRef<str>) -> Option<Estimate> {
    let metric = metric.as_ref();
    let others = process_medians(other, metric);
    let ratios: Vec<f64> = process_medians(case, metric)
        .iter()
        .filter_map(|(process, cost)| Some(cost / others.get(process)?))
        .collect();
    over_processes(&ratios)
}

/// Typical cost of `case` over that of `other`: the quotient of their [`typical`] figures, so that it orders
/// cases as these do. None is less than 1 over the case whose figure is least, as medians of ratios can be.
/// Its interval is over processes that measured both, resampled together.
#[must_use]
pub fn over_typical(case: &Case, other: &Case, metric: impl AsRef<str>) -> Option<Estimate> {
    let metric = metric.as_ref();
    let [own, others] = [case, other].map(|case| process_medians(case, metric));
    let middle_of =
        |costs: &BTreeMap<u32, f64>| median(&costs.values().copied().collect::<Vec<_>>());
    let middle = middle_of(&own)? / middle_of(&others)?;
    let both = own
        .iter()
        .filter_map(|(process, cost)| Some([*cost, *others.get(process)?]));
    let both: Vec<[f64; 2]> = both.collect();
    let mut random = generator();
    estimate(middle, both.len(), || {
        let drawn: Vec<[f64; 2]> = both
            .iter()
            .map(|_| both[random.below(both.len())])
            .collect();
        let side = |side: usize| median(&drawn.iter().map(|costs| costs[side]).collect::<Vec<_>>());
        side(0)
            .zip(side(1))
            .map_or(f64::NAN, |(cost, other)| cost / other)
    })
}

/// A figure of which every process gives one; `None` for none.
#[must_use]
pub fn over_processes(figures: &[f64]) -> Option<Estimate> {
    let mut random = generator();
    estimate(median(figures)?, figures.len(), || {
        resampled_median(&mut random, figures)
    })
}

/// Share of `part` in the sum of two metrics of one case that every sample has, over processes; `None`
/// without a process that measured both.
#[must_use]
pub fn share(case: &Case, part: impl AsRef<str>, rest: impl AsRef<str>) -> Option<Estimate> {
    let rests = process_medians(case, rest);
    let shares: Vec<f64> = process_medians(case, part)
        .iter()
        .filter_map(|(process, part)| Some(part / (part + rests.get(process)?)))
        .collect();
    over_processes(&shares)
}

/// `metric` of one case: the median over its processes; `None` without a process that measured it.
#[must_use]
pub fn typical(case: &Case, metric: impl AsRef<str>) -> Option<Estimate> {
    let medians: Vec<f64> = process_medians(case, metric).into_values().collect();
    over_processes(&medians)
}

fn estimate(middle: f64, processes: usize, mut resampled: impl FnMut() -> f64) -> Option<Estimate> {
    let interval = (processes >= MIN_REPLICATES).then(|| {
        let values: Vec<f64> = (0..BOOTSTRAP_RESAMPLES).map(|_| resampled()).collect();
        let tail = 0.5 * (1.0 - INTERVAL_COVERAGE);
        Some([quantile(&values, tail)?, quantile(&values, 1.0 - tail)?])
    });
    Some(Estimate {
        middle,
        interval: match interval {
            Some(interval) => Some(interval?),
            None => None,
        },
        processes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{MadeUpRun, case_id};

    const METRIC: &str = "fill_cpu_ms";

    /// Two cases by the samples of their processes.
    fn ratio_of(a: &[&[f64]], b: &[&[f64]]) -> Option<Estimate> {
        let mut run = MadeUpRun::default();
        for (name, samples) in [("a", a), ("b", b)] {
            let id = case_id("filling", name, &[]);
            run.case(id).sampled(METRIC, samples);
        }
        let run = run.loaded();
        ratio(&run.cases[0], &run.cases[1], METRIC)
    }

    fn each(values: &[f64]) -> Vec<&[f64]> {
        values.chunks(1).collect()
    }

    #[test]
    fn what_falls_on_both_falls_out() {
        // Processes differ tenfold, the ratio hardly at all.
        let before = [20.0, 202.0, 41.0, 90.0, 30.3, 61.0];
        let after = [10.0, 101.0, 20.0, 45.0, 15.0, 30.0];
        let gain = ratio_of(&each(&before), &each(&after)).expect("six processes");
        let [low, high] = gain.interval.expect("enough");
        assert!(low > 1.99 && high < 2.06, "{gain:?}");
        assert_eq!(Claim::Faster.standing(&gain), Standing::Holds);
        // Negative control: with the operands swapped it is slower.
        let swapped = ratio_of(&each(&after), &each(&before)).expect("six processes");
        assert!((swapped.middle * gain.middle - 1.0).abs() < 0.01);
        assert_eq!(Claim::Faster.standing(&swapped), Standing::DoesNotHold);
    }

    #[test]
    fn a_slow_sample_moves_nothing_and_a_slow_process_widens_the_interval() {
        let steady: Vec<&[f64]> = vec![&[10.0, 10.0, 10.0]; 6];
        let mut one_slow_sample = steady.clone();
        one_slow_sample[0] = &[10.0, 500.0, 10.0];
        let ratio = ratio_of(&one_slow_sample, &steady).expect("six processes");
        assert_eq!(ratio.interval, Some([1.0, 1.0]));
        // Negative control: three slow processes of six must not pass for certainty.
        let mut slow = steady.clone();
        slow[..3].fill(&[500.0, 500.0, 500.0]);
        let ratio = ratio_of(&slow, &steady).expect("six processes");
        assert_eq!(Claim::NoDifference.standing(&ratio), Standing::CannotTell);
    }

    #[test]
    fn samples_of_one_process_are_one_replicate() {
        let many_samples: &[f64] = &[20.0; 100];
        let one = ratio_of(&[many_samples], &[&[10.0; 100]]).expect("a process");
        assert_eq!((one.middle, one.interval, one.processes), (2.0, None, 1));
        assert_eq!(Claim::Faster.standing(&one), Standing::CannotTell);
        // Negative control: five processes of one sample each say more.
        let five = ratio_of(&each(&[20.0; 5]), &each(&[10.0; 5])).expect("five processes");
        assert_eq!(Claim::Faster.standing(&five), Standing::Holds);
    }

    #[test]
    fn a_process_without_a_partner_does_not_count() {
        let ratio = ratio_of(&each(&[20.0; 6]), &each(&[10.0; 4])).expect("four in common");
        assert_eq!((ratio.processes, ratio.interval), (4, None));
        assert_eq!(ratio_of(&each(&[20.0; 6]), &[]), None);
        // Times of 0 and below are no times.
        assert_eq!(ratio_of(&each(&[20.0]), &each(&[0.0])), None);
    }

    #[test]
    fn a_time_has_an_interval_from_enough_processes() {
        let typical_of = |samples: &[f64]| {
            let mut run = MadeUpRun::default();
            run.case(case_id("filling", "a", &[]))
                .timed(METRIC, samples);
            typical(&run.loaded().cases[0], METRIC)
        };
        let five = typical_of(&[9.0, 10.0, 11.0, 10.0, 10.5]).expect("times");
        let [low, high] = five.interval.expect("enough");
        assert!(low < five.middle && five.middle < high, "{five:?}");
        // Negative controls: too few processes give no interval, and none give nothing.
        assert_eq!(typical_of(&[9.0; 4]).and_then(|few| few.interval), None);
        assert_eq!(typical_of(&[]), None);
    }

    #[test]
    fn nothing_takes_less_than_what_is_typically_fastest() {
        let mut run = MadeUpRun::default();
        // Of paired ratios most are below 1, though the typical time is longer.
        for (name, times) in [
            ("a", [10.0, 10.0, 11.0, 40.0, 40.0]),
            ("b", [9.0, 12.0, 12.0, 39.0, 39.0]),
        ] {
            run.case(case_id("filling", name, &[]))
                .timed(METRIC, &times);
        }
        let run = run.loaded();
        let (fastest, other) = (&run.cases[0], &run.cases[1]);
        let over = over_typical(other, fastest, METRIC).expect("five processes");
        assert_eq!((over.middle, over.processes), (12.0 / 11.0, 5));
        let [low, high] = over.interval.expect("enough");
        assert!(low <= over.middle && over.middle <= high, "{over:?}");
        // Control: the median of ratios of the same times is below 1.
        let paired = ratio(other, fastest, METRIC).expect("five processes");
        assert!(paired.middle < 1.0, "{paired:?}");
        // Negative control: swapped operands.
        let swapped = over_typical(fastest, other, METRIC).expect("five processes");
        assert!((swapped.middle * over.middle - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_share_is_of_both_parts_of_the_same_process() {
        let share_of = |parts: &[f64], rests: &[f64]| {
            let mut run = MadeUpRun::default();
            let case = run.case(case_id("filling", "a", &[]));
            case.timed("colour_gpu_ms", parts)
                .timed("stencil_gpu_ms", rests);
            share(&run.loaded().cases[0], "colour_gpu_ms", "stencil_gpu_ms")
        };
        let quarter = share_of(&[1.0, 2.0, 3.0, 4.0, 5.0], &[3.0, 6.0, 9.0, 12.0, 15.0]);
        let quarter = quarter.expect("five processes");
        assert_eq!((quarter.middle, quarter.interval), (0.25, Some([0.25; 2])));
        // Negative controls: swapped parts, and nothing to share with.
        let swapped = share_of(&[3.0; 5], &[1.0; 5]).expect("five processes");
        assert_eq!(swapped.middle, 0.75);
        assert_eq!(share_of(&[3.0; 5], &[]), None);
    }

    #[test]
    fn noise_is_called_neither_a_gain_nor_nothing() {
        let before = [10.0, 14.0, 9.0, 12.0, 8.0, 13.0, 10.0];
        let after = [11.0, 10.0, 12.0, 9.0, 11.0, 10.0, 8.0];
        let gain = ratio_of(&each(&before), &each(&after)).expect("seven processes");
        for claim in [Claim::Faster, Claim::NoDifference] {
            assert_eq!(claim.standing(&gain), Standing::CannotTell, "{gain:?}");
        }
    }

    #[test]
    fn a_gain_of_five_per_cent_is_one_where_noise_is_smaller() {
        let gain = Estimate {
            middle: 1.04,
            interval: Some([1.03, 1.049]),
            processes: 9,
        };
        assert_eq!(Claim::Faster.standing(&gain), Standing::NoDifference);
        assert_eq!(Claim::Faster.standing_beyond(&gain, 1.02), Standing::Holds);
        let nothing = Claim::NoDifference;
        assert_eq!(nothing.standing(&gain), Standing::Holds);
        assert_eq!(nothing.standing_beyond(&gain, 1.02), Standing::DoesNotHold);
        assert_eq!(nothing.standing_beyond(&gain, 1.035), Standing::CannotTell);
    }

    #[test]
    fn claims_by_hand() {
        const HALF: Claim = Claim::Factor {
            of: 0.5,
            within: 1.25,
        };
        let estimate = |low: f64, high: f64| Estimate {
            middle: f64::midpoint(low, high),
            interval: Some([low, high]),
            processes: 5,
        };
        use Standing::{CannotTell, DoesNotHold, Holds, NoDifference};
        let cases = [
            (Claim::Faster, estimate(1.06, 1.3), Holds),
            (Claim::Faster, estimate(1.01, 1.3), CannotTell),
            (Claim::Faster, estimate(0.99, 1.01), NoDifference),
            (Claim::NoDifference, estimate(0.99, 1.01), Holds),
            (Claim::NoDifference, estimate(0.99, 1.06), CannotTell),
            (Claim::NoDifference, estimate(1.06, 1.3), DoesNotHold),
            (Claim::NoDifference, estimate(0.8, 0.9), DoesNotHold),
            (Claim::NotFaster, estimate(0.5, 1.01), Holds),
            (Claim::NotFaster, estimate(0.9, 1.06), CannotTell),
            (Claim::NotFaster, estimate(1.06, 1.3), DoesNotHold),
            (HALF, estimate(0.45, 0.6), Holds),
            (HALF, estimate(0.6, 0.7), CannotTell),
            (HALF, estimate(0.7, 0.9), DoesNotHold),
            (HALF, estimate(0.2, 0.3), DoesNotHold),
            (Claim::LessThan(1.5), estimate(1.1, 1.4), Holds),
            (Claim::LessThan(1.5), estimate(1.6, 1.9), DoesNotHold),
            (Claim::LessThan(1.5), estimate(1.4, 1.6), CannotTell),
            (Claim::AtLeast(2.0), estimate(2.0, 2.2), Holds),
            (Claim::AtLeast(2.0), estimate(1.2, 1.9), DoesNotHold),
            (Claim::AtLeast(2.0), estimate(1.9, 2.1), CannotTell),
        ];
        for (claim, gain, standing) in cases {
            assert_eq!(claim.standing(&gain), standing, "{claim:?} {gain:?}");
        }
    }
}
