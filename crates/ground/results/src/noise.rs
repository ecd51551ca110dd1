// SPDX-License-Identifier: MIT OR Apache-2.0
//! A/A noise: by how much identical work differed in one run.
//!
//! A repeat does the work of another case under another name (see [`REPEATS`]). For each pair the
//! noise is |ln ratio|, where the ratio is the one that all comparisons use ([`ratio`]): symmetric in
//! its operands, so that half as long and twice as long differ by as much. A gap between two cases
//! that is no larger than the largest noise of a pair is a tie.

use crate::threshold::{MIN_BAND, MIN_DIFFERENCE};
use crate::{Case, Estimate, REPEATS, process_medians, ratio};
use std::collections::{BTreeMap, BTreeSet};

/// By how much identical work differed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Largest |ln ratio| of a pair.
    pub max: f64,
    /// Median |ln ratio|.
    pub median: f64,
    /// Pairs behind it.
    pub pairs: usize,
    /// Largest |ln end| of a pair's 95 % interval; of its gap where too few processes give an interval.
    pub reach: f64,
    /// Between processes; `None` where one process measured, or none any case twice.
    pub between: Option<Between>,
}

/// By how much the same case differed between processes: the largest over the smallest of their medians, as |ln|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// Of the case that differed most.
    pub max: f64,
    /// Median over cases.
    pub median: f64,
}

impl Between {
    fn of<'a>(cases: impl Iterator<Item = &'a Case>, metric: &str) -> Option<Self> {
        let counted = cases.filter(|case| case.counts());
        let spreads: Vec<f64> = counted
            .filter_map(|case| {
                let times = sorted_medians(case, metric);
                let (low, high) = (*times.first()?, *times.last()?);
                (times.len() > 1).then(|| (high / low).ln())
            })
            .collect();
        Some(Self {
            max: spreads.iter().copied().fold(0.0, f64::max),
            median: crate::median(&spreads)?,
        })
    }
}

/// Two groups are at least this factor apart: the largest gap between neighbours among sorted medians. A busy
/// machine changes process CPU time by less, and two clocks of a GPU differ by more.
const GROUP_GAP: f64 = 1.2;

/// And so many times as wide, as a logarithm, as either group: what is scattered has no groups.
const GAP_OVER_GROUP: f64 = 3.0;

/// Whether the processes of a case fall into two groups, as at two clocks: its median is then that of the larger
/// group, and no measure of the work.
#[must_use]
pub fn has_two_groups(case: &Case, metric: &str) -> bool {
    let times = sorted_medians(case, metric);
    (1..times.len()).any(|first| {
        let (low, high) = times.split_at(first);
        let width = |group: &[f64]| (group[group.len() - 1] / group[0]).ln();
        let gap = (high[0] / low[low.len() - 1]).ln();
        // Two processes that differ are scattered or in two groups: nothing says which.
        times.len() > 2
            && gap >= GROUP_GAP.ln()
            && gap >= GAP_OVER_GROUP * width(low).max(width(high))
    })
}

/// Medians of processes in which it took longer than nothing.
fn sorted_medians(case: &Case, metric: &str) -> Vec<f64> {
    let medians = process_medians(case, metric).into_values();
    let mut times: Vec<f64> = medians
        .filter(|time| time.is_finite() && *time > 0.0)
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

impl Noise {
    /// Noise of `metric` among these cases: of a group, or of a whole run. `None` where no right
    /// case was measured twice.
    #[must_use]
    pub fn of<'a>(
        cases: impl Iterator<Item = &'a Case> + Clone,
        metric: impl AsRef<str>,
    ) -> Option<Self> {
        let metric = metric.as_ref();
        let repeats = || {
            let counted = cases.clone().filter(|case| case.counts());
            counted.filter(|case| case.is_repeat())
        };
        let repeated: BTreeSet<&str> = repeats().map(|repeat| repeat.condition(REPEATS)).collect();
        let originals = cases.clone().filter(|case| case.counts());
        let originals = originals.map(|case| (case.id().key(), case));
        let originals: BTreeMap<String, &Case> = originals
            .filter(|(key, _)| repeated.contains(key.as_str()))
            .collect();
        let ratios: Vec<Estimate> = repeats()
            .filter_map(|repeat| ratio(repeat, originals.get(repeat.condition(REPEATS))?, metric))
            .collect();
        let off = |ratio: f64| ratio.ln().abs();
        let gaps: Vec<f64> = ratios.iter().map(|ratio| off(ratio.middle)).collect();
        let ends = |ratio: &Estimate| ratio.interval.unwrap_or([ratio.middle; 2]);
        let ends = ratios.iter().flat_map(ends).map(off);
        Some(Self {
            max: gaps.iter().copied().fold(0.0, f64::max),
            median: crate::median(&gaps)?,
            pairs: gaps.len(),
            reach: ends.fold(0.0, f64::max),
            between: Between::of(cases, metric),
        })
    }

    /// How far from 1 the interval of a pair reaches, as a factor, 1 or more.
    ///
    /// The least band of no difference by which identical work, measured as often, is found to be none.
    #[must_use]
    pub fn reach_factor(&self) -> f64 {
        self.reach.exp()
    }

    /// Ratios closer to 1 than this factor are no difference: so far the intervals of identical work reached. Where none
    /// was measured twice, [`MIN_DIFFERENCE`].
    #[must_use]
    pub fn band(noise: Option<Self>) -> f64 {
        noise.map_or(MIN_DIFFERENCE, |noise| noise.reach_factor().max(MIN_BAND))
    }

    /// The largest noise as a factor, 1 or more.
    #[must_use]
    pub fn max_factor(&self) -> f64 {
        self.max.exp()
    }

    /// The median noise as a factor, 1 or more.
    #[must_use]
    pub fn median_factor(&self) -> f64 {
        self.median.exp()
    }

    /// Whether two cases whose costs stand in this ratio differ by no more than identical work did.
    #[must_use]
    pub fn is_tie(&self, ratio: f64) -> bool {
        ratio.ln().abs() <= self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{MadeUpRun, case_id};
    use crate::{Claim, Standing};

    const METRIC: &str = "fill_cpu_ms";

    /// Noise of a run of two pairs: the first one's repeat takes these times, the second one's are
    /// 2 % longer than 10.
    fn noise_of(again: &[f64], original: &[f64]) -> Option<Noise> {
        let mut run = MadeUpRun::default();
        let pairs = [("a", original, again), ("b", &[10.0; 5], &[10.2; 5])];
        for (name, original, again) in pairs {
            let id = case_id("filling", name, &[]);
            run.case(id.repeat()).timed(METRIC, again);
            run.case(id).timed(METRIC, original);
        }
        Noise::of(run.loaded().cases.iter(), METRIC)
    }

    #[test]
    fn noise_is_the_largest_gap_between_twins_whichever_way_it_goes() {
        let found = noise_of(&[9.0; 5], &[10.0; 5]).expect("two pairs");
        assert_eq!(found.pairs, 2);
        assert!((found.max_factor() - 10.0 / 9.0).abs() < 1e-12, "{found:?}");
        assert!(found.median_factor() > 1.02 && found.median_factor() < found.max_factor());
        // Swapped operands are the same noise.
        let swapped = noise_of(&[10.0; 5], &[9.0; 5]).expect("two pairs");
        assert!((found.max - swapped.max).abs() < 1e-12);
        // Negative control: identical times leave the second pair's noise.
        let quiet = noise_of(&[10.0; 5], &[10.0; 5]).expect("two pairs");
        assert!((quiet.max_factor() - 1.02).abs() < 1e-12);
    }

    #[test]
    fn one_slow_process_is_no_noise_and_three_of_five_are() {
        let slow = noise_of(&[90.0, 10.0, 10.0, 10.0, 10.0], &[10.0; 5]).expect("two pairs");
        assert!(slow.max_factor() < 1.03);
        let slow = noise_of(&[90.0, 90.0, 90.0, 10.0, 10.0], &[10.0; 5]).expect("two pairs");
        assert!(slow.max_factor() > 8.9);
    }

    #[test]
    fn gaps_within_the_noise_are_ties_and_larger_ones_are_not() {
        let noise = noise_of(&[11.0; 5], &[10.0; 5]).expect("two pairs");
        for tie in [1.0, 1.09, 1.0 / 1.09] {
            assert!(noise.is_tie(tie), "{tie}");
        }
        for gap in [1.11, 1.0 / 1.11, f64::NAN, 0.0] {
            assert!(!noise.is_tie(gap), "{gap}");
        }
    }

    #[test]
    fn noise_reaches_as_far_as_an_interval_of_identical_work() {
        let around = [9.9, 9.9, 10.0, 10.1, 10.1];
        let noise = noise_of(&around, &[10.0; 5]).expect("two pairs");
        let reach = noise.reach_factor();
        assert!((noise.max_factor() - 1.02).abs() < 1e-12, "the other pair");
        assert!((reach - 1.02).abs() < 1e-12, "{reach}");
        let wide = around.map(|ms| 10.0 + 5.0 * (ms - 10.0));
        let noise = noise_of(&wide, &[10.0; 5]).expect("two pairs");
        assert!((noise.max_factor() - 1.02).abs() < 1e-12, "its median is 1");
        assert!(
            (noise.reach_factor() - 1.0 / 0.95).abs() < 1e-9,
            "{noise:?}"
        );
        // Four processes give no interval: the largest gap has to do.
        let few = noise_of(&[10.5; 4], &[10.0; 5]).expect("two pairs");
        assert!((few.reach_factor() - 1.05).abs() < 1e-12, "{few:?}");
    }

    #[test]
    fn times_are_told_apart_beyond_the_noise_and_never_within_it() {
        let noise = noise_of(&[10.4; 5], &[10.0; 5]);
        let of = |slow: &[f64], fast: &[f64], noise| {
            let mut run = MadeUpRun::default();
            for (name, times) in [("slow", slow), ("fast", fast)] {
                run.case(case_id("filling", name, &[])).timed(METRIC, times);
            }
            let run = run.loaded();
            let gain = ratio(&run.cases[0], &run.cases[1], METRIC).expect("a ratio");
            Claim::Faster.standing_beyond(&gain, Noise::band(noise))
        };
        use Standing::{CannotTell, DoesNotHold, Holds, NoDifference};
        // Steady, and less than identical work differs by.
        assert_eq!(of(&[10.3; 5], &[10.0; 5], noise), NoDifference);
        assert_eq!(of(&[10.0; 5], &[10.3; 5], noise), NoDifference);
        // Controls: beyond it, either way.
        assert_eq!(of(&[10.5; 5], &[10.0; 5], noise), Holds);
        assert_eq!(of(&[10.0; 5], &[10.5; 5], noise), DoesNotHold);
        // Far apart in the middle, and in most processes only.
        let scattered = of(&[13.0, 13.0, 13.0, 9.0, 9.0], &[10.0; 5], noise);
        assert_eq!(scattered, CannotTell);
        // Too few processes, and no repeat, which leaves 5 %.
        assert_eq!(of(&[20.0; 3], &[10.0; 3], noise), CannotTell);
        assert_eq!(of(&[10.4; 5], &[10.0; 5], None), NoDifference);
        assert_eq!(of(&[10.6; 5], &[10.0; 5], None), Holds);
    }

    #[test]
    fn what_one_process_pairs_alike_and_processes_do_not_is_noise_between_them() {
        let clocks = [1.07, 0.293, 0.294];
        let found = noise_of(&clocks, &clocks).expect("two pairs");
        assert!((found.max_factor() - 1.02).abs() < 1e-12, "{found:?}");
        let between = found.between.expect("three processes");
        assert!(
            (between.max.exp() - 1.07 / 0.293).abs() < 1e-9,
            "{between:?}"
        );
        // Half of the cases do not differ at all.
        assert!(between.median < between.max, "{between:?}");
        // Negative controls: alike, and one process alone.
        let alike = noise_of(&[10.0; 3], &[10.0; 3]).expect("two pairs");
        assert!(alike.between.expect("three processes").max < 1e-12);
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[])).timed(METRIC, &[1.0]);
        run.case(case_id("filling", "a", &[]).repeat())
            .timed(METRIC, &[1.0]);
        let run = run.loaded();
        let one = Noise::of(run.cases.iter(), METRIC).expect("a pair");
        assert_eq!(one.between, None);
    }

    #[test]
    fn processes_at_two_clocks_are_marked_and_alike_or_scattered_ones_are_not() {
        let is_marked = |times: &[f64]| {
            let mut run = MadeUpRun::default();
            run.case(case_id("filling", "a", &[])).timed(METRIC, times);
            has_two_groups(&run.loaded().cases[0], METRIC)
        };
        assert!(is_marked(&[1.07, 0.293, 0.294]));
        assert!(is_marked(&[0.3, 1.0, 0.301, 1.01, 0.299]));
        for times in [
            &[0.293, 0.294, 0.295][..],
            &[1.0, 1.3, 1.6, 1.9],
            &[1.0, 1.1, 1.0],
            // Nothing says which of two is which, and one is one.
            &[1.07, 0.293],
            &[1.07],
            &[],
        ] {
            assert!(!is_marked(times), "{times:?}");
        }
    }

    #[test]
    fn without_twins_noise_is_unknown_rather_than_none() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]))
            .timed(METRIC, &[1.0; 5]);
        let run = run.loaded();
        assert_eq!(Noise::of(run.cases.iter(), METRIC), None);
    }
}
