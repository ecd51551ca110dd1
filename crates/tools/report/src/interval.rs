// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much faster one case is than another, with an interval, and what that says of a claim.
//!
//! Cases of one view are timed in the same rounds, so frame *i* of the one stands beside frame *i* of
//! the other: what the machine did in that round falls on both. The gain is the median over rounds of
//! time before over time after; the interval is the 2.5th to the 97.5th percentile of that median
//! over resampled rounds (Efron, 1979, "Bootstrap methods"), with a fixed seed.

use crate::statistic::{BOOTSTRAP_RESAMPLES, BOOTSTRAP_SEED, SplitMix64};
use std::collections::BTreeMap;
use terrafill_results::legacy::{median, quantile};

/// Fewest rounds from which an interval is formed: the median of fewer hardly moves under
/// resampling, which would look like certainty.
pub(crate) const MIN_ROUNDS: usize = 5;

/// Gains below this factor are called nothing: process CPU time ratios of one binary repeat within
/// 5 % on a software driver.
pub(crate) const NOTHING: f64 = 1.05;

/// Frame times of a case by frame number, milliseconds.
pub(crate) type Frames = BTreeMap<u32, f64>;

/// A ratio with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) low: f64,
    pub(crate) middle: f64,
    pub(crate) high: f64,
}

/// What an interval says of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Standing {
    Holds,
    DoesNot,
    CannotTell,
}

impl Standing {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNot => "does not hold",
            Self::CannotTell => "cannot tell",
        }
    }

    /// Class in the style sheet.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNot => "does-not",
            Self::CannotTell => "cannot-tell",
        }
    }
}

/// A claim about a gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Claim {
    /// It is faster by more than nothing.
    Faster,
    /// It makes no difference.
    Nothing,
    /// It gains less than this factor.
    LessThan(f64),
    /// It gains this factor or more.
    AtLeast(f64),
}

impl Claim {
    /// What `gain` says of it.
    pub(crate) fn standing(self, gain: Interval) -> Standing {
        let least = 1.0 / NOTHING;
        let (holds, fails) = match self {
            Self::Faster => (gain.low > NOTHING, gain.high < NOTHING),
            Self::Nothing => (
                gain.low >= least && gain.high <= NOTHING,
                gain.low > NOTHING || gain.high < least,
            ),
            Self::LessThan(limit) => (gain.high < limit, gain.low > limit),
            Self::AtLeast(limit) => (gain.low >= limit, gain.high < limit),
        };
        match (holds, fails) {
            (true, false) => Standing::Holds,
            (false, true) => Standing::DoesNot,
            _ => Standing::CannotTell,
        }
    }
}

/// Time before over time after; `None` with fewer than [`MIN_ROUNDS`] rounds in common.
pub(crate) fn gain(before: &Frames, after: &Frames) -> Option<Interval> {
    let ratios: Vec<f64> = before
        .iter()
        .filter_map(|(frame, before)| Some(before / after.get(frame)?))
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    if ratios.len() < MIN_ROUNDS {
        return None;
    }
    let mut random = SplitMix64(BOOTSTRAP_SEED);
    let medians: Vec<f64> = (0..BOOTSTRAP_RESAMPLES)
        .map(|_| random.resampled_median(&ratios))
        .collect();
    around(median(&ratios)?, &medians)
}

/// Exponent *b* of time = c · workᵇ through two cases that were not timed in the same rounds, so
/// that their frames are resampled apart; `None` without enough frames or without a difference in
/// work.
pub(crate) fn exponent(
    [few, many]: [f64; 2],
    [time_of_few, time_of_many]: [&[f64]; 2],
) -> Option<Interval> {
    let growth = (many / few).ln();
    let enough = time_of_few.len() >= MIN_ROUNDS && time_of_many.len() >= MIN_ROUNDS;
    if !enough || !growth.is_finite() || growth <= 0.0 {
        return None;
    }
    let mut random = SplitMix64(BOOTSTRAP_SEED);
    let exponents: Vec<f64> = (0..BOOTSTRAP_RESAMPLES)
        .map(|_| {
            let ratio =
                random.resampled_median(time_of_many) / random.resampled_median(time_of_few);
            ratio.ln() / growth
        })
        .collect();
    let ratio = median(time_of_many)? / median(time_of_few)?;
    around(ratio.ln() / growth, &exponents)
}

fn around(middle: f64, resampled: &[f64]) -> Option<Interval> {
    Some(Interval {
        low: quantile(resampled, 0.025)?,
        middle,
        high: quantile(resampled, 0.975)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(times: &[f64]) -> Frames {
        (0..).zip(times.iter().copied()).collect()
    }

    #[test]
    fn what_falls_on_both_falls_out() {
        // Rounds differ tenfold, the ratio hardly at all.
        let before = frames(&[20.0, 202.0, 41.0, 90.0, 30.3, 61.0]);
        let after = frames(&[10.0, 101.0, 20.0, 45.0, 15.0, 30.0]);
        let gain = gain(&before, &after).expect("six rounds");
        assert!(gain.low > 1.99 && gain.high < 2.06, "{gain:?}");
        assert_eq!(Claim::Faster.standing(gain), Standing::Holds);
        // Twin: swapped, it is slower.
        let swapped = super::gain(&after, &before).expect("six rounds");
        assert!((swapped.middle * gain.middle - 1.0).abs() < 0.01);
        assert_eq!(Claim::Faster.standing(swapped), Standing::DoesNot);
    }

    #[test]
    fn rounds_without_a_partner_do_not_count() {
        let before = frames(&[10.0; 6]);
        let mut after = frames(&[5.0; 6]);
        assert!(gain(&before, &after).is_some());
        after.remove(&0);
        after.remove(&1);
        assert_eq!(gain(&before, &after), None, "four rounds prove nothing");
    }

    #[test]
    fn noise_is_not_called_a_gain_nor_nothing() {
        let before = frames(&[10.0, 14.0, 9.0, 12.0, 8.0, 13.0, 10.0]);
        let after = frames(&[11.0, 10.0, 12.0, 9.0, 11.0, 10.0, 8.0]);
        let gain = gain(&before, &after).expect("seven rounds");
        for claim in [Claim::Faster, Claim::Nothing] {
            assert_eq!(claim.standing(gain), Standing::CannotTell, "{gain:?}");
        }
    }

    #[test]
    fn claims_by_hand() {
        let interval = |low: f64, high: f64| Interval {
            low,
            middle: f64::midpoint(low, high),
            high,
        };
        use Standing::{CannotTell, DoesNot, Holds};
        let cases = [
            (Claim::Faster, interval(1.06, 1.3), Holds),
            (Claim::Faster, interval(1.01, 1.3), CannotTell),
            (Claim::Faster, interval(0.99, 1.01), DoesNot),
            (Claim::Nothing, interval(0.99, 1.01), Holds),
            (Claim::Nothing, interval(0.99, 1.06), CannotTell),
            (Claim::Nothing, interval(1.06, 1.3), DoesNot),
            (Claim::Nothing, interval(0.8, 0.9), DoesNot),
            (Claim::LessThan(1.5), interval(1.1, 1.4), Holds),
            (Claim::LessThan(1.5), interval(1.6, 1.9), DoesNot),
            (Claim::LessThan(1.5), interval(1.4, 1.6), CannotTell),
            (Claim::AtLeast(2.0), interval(2.0, 2.2), Holds),
            (Claim::AtLeast(2.0), interval(1.2, 1.9), DoesNot),
            (Claim::AtLeast(2.0), interval(1.9, 2.1), CannotTell),
        ];
        for (claim, gain, standing) in cases {
            assert_eq!(claim.standing(gain), standing, "{claim:?} {gain:?}");
        }
    }

    #[test]
    fn time_that_grows_with_work_has_exponent_one() {
        let few = [10.0, 10.1, 9.9, 10.0, 10.05];
        let many = few.map(|time| time * 8.0);
        let found = exponent([1_000.0, 8_000.0], [&few, &many]).expect("enough frames");
        assert!((found.middle - 1.0).abs() < 1e-9 && found.low > 0.98 && found.high < 1.02);
        // Twins: another growth is another exponent, and no growth gives none.
        let slower = exponent([1_000.0, 64_000.0], [&few, &many]).expect("enough frames");
        assert!((slower.middle - 0.5).abs() < 1e-9);
        assert_eq!(exponent([1_000.0, 1_000.0], [&few, &many]), None);
        assert_eq!(exponent([1_000.0, 8_000.0], [&few[..4], &many]), None);
    }
}
