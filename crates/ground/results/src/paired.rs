// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paired differences without a random generator, and the bounds of a rate.
//!
//! The centre of paired differences is the Hodges–Lehmann estimate, the median of the means of all
//! pairs (Walsh averages); its interval inverts the exact signed-rank test (Hodges and Lehmann, 1963;
//! Wilcoxon, 1945). Both change sign with their operands. A rate's bounds are exact (Clopper and
//! Pearson, 1934).

use crate::median;

/// Largest number of differences: the null distribution is counted in `f64`, exact up to 2⁵³ subsets.
const MAX_DIFFERENCES: usize = 53;

/// Centre of paired differences with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Hodges–Lehmann estimate, in the differences' unit.
    pub estimate: f64,
    /// The narrowest interval of order statistics whose coverage is at least the one asked for; `None`
    /// with too few differences for any.
    pub interval: Option<[f64; 2]>,
    /// Differences behind it.
    pub pairs: usize,
}

impl Shift {
    /// Centre of `differences`; `None` for none, more than 53, or one that is not finite.
    ///
    /// - `coverage`: of the interval, such as 0.99, which takes 8 differences
    #[must_use]
    pub fn of(differences: &[f64], coverage: f64) -> Option<Self> {
        let pairs = differences.len();
        let is_usable = differences.iter().all(|value| value.is_finite());
        if !is_usable || pairs > MAX_DIFFERENCES {
            return None;
        }
        let mut walsh: Vec<f64> = (0..pairs)
            .flat_map(|i| (i..pairs).map(move |j| (i, j)))
            .map(|(i, j)| f64::midpoint(differences[i], differences[j]))
            .collect();
        walsh.sort_by(f64::total_cmp);
        let estimate = median(&walsh)?;
        let cut = signed_rank_cut(pairs, 0.5 * (1.0 - coverage));
        Some(Self {
            estimate,
            interval: cut.map(|cut| [walsh[cut], walsh[walsh.len() - 1 - cut]]),
            pairs,
        })
    }

    /// Half of the interval's width; infinite without one.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        self.interval
            .map_or(f64::INFINITY, |[low, high]| 0.5 * (high - low))
    }
}

/// Largest rank sum *k* with P(W ≤ k) ≤ `tail` under the null; `None` where even P(W = 0) is more.
fn signed_rank_cut(pairs: usize, tail: f64) -> Option<usize> {
    let all = pairs * (pairs + 1) / 2;
    // Number of subsets of {1 … pairs} by their sum.
    let mut subsets = vec![0.0_f64; all + 1];
    subsets[0] = 1.0;
    for rank in 1..=pairs {
        for sum in (rank..=all).rev() {
            subsets[sum] += subsets[sum - rank];
        }
    }
    let total: f64 = subsets.iter().sum();
    let mut below = 0.0;
    let within = subsets.iter().take_while(|count| {
        below += **count;
        below / total <= tail
    });
    within.count().checked_sub(1)
}

/// Exact two-sided bounds of a rate (Clopper and Pearson, 1934).
///
/// - `hits` of `trials`, at most as many
/// - `coverage`: such as 0.95
/// - returns: `[0, 1]` for no trial
#[must_use]
pub fn rate_bounds(hits: u32, trials: u32, coverage: f64) -> [f64; 2] {
    let tail = 0.5 * (1.0 - coverage);
    let (hits, trials) = (hits.min(trials), trials);
    let low = match hits {
        0 => 0.0,
        // P(X ≥ hits) grows with the rate.
        _ => bisect(|rate| 1.0 - cumulative(hits - 1, trials, rate) < tail),
    };
    let high = if hits == trials {
        1.0
    } else {
        bisect(|rate| cumulative(hits, trials, rate) > tail)
    };
    [low, high]
}

/// Where `is_below` turns false between 0 and 1.
fn bisect(is_below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // 60 halvings reach the spacing of `f64` near 1.
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// P(X ≤ `hits`) of a binomial distribution, by logarithms so that no term overflows.
fn cumulative(hits: u32, trials: u32, rate: f64) -> f64 {
    let (yes, no) = (rate.ln(), (-rate).ln_1p());
    let mut choose = 0.0;
    let mut sum = 0.0;
    for i in 0..=hits {
        if i > 0 {
            choose += (f64::from(trials - i + 1) / f64::from(i)).ln();
        }
        sum += (choose + f64::from(i) * yes + f64::from(trials - i) * no).exp();
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_are_those_of_printed_tables() {
        // Critical values of the signed-rank test at 0.01 two-sided: none below 8 pairs, then these.
        for (pairs, cut) in [(8, 0), (9, 1), (10, 3), (15, 15), (20, 37), (25, 68)] {
            assert_eq!(signed_rank_cut(pairs, 0.005), Some(cut), "{pairs}");
        }
        assert_eq!(signed_rank_cut(7, 0.005), None);
        assert_eq!(signed_rank_cut(6, 0.025), Some(0));
        assert_eq!(signed_rank_cut(5, 0.025), None);
    }

    #[test]
    fn the_estimate_is_the_median_of_all_means_of_two() {
        // Walsh averages of 1, 2, 9: 1, 1.5, 2, 5, 5.5, 9.
        let shift = Shift::of(&[1.0, 9.0, 2.0], 0.99).expect("three");
        assert_eq!((shift.estimate, shift.interval), (3.5, None));
        assert!(shift.half_width().is_infinite());
        let eight: Vec<f64> = (1..=8).map(f64::from).collect();
        let shift = Shift::of(&eight, 0.99).expect("eight");
        assert_eq!((shift.estimate, shift.interval), (4.5, Some([1.0, 8.0])));
    }

    #[test]
    fn swapped_operands_change_the_sign_and_nothing_else() {
        let values = [0.031, -0.004, 0.022, 0.4, 0.018, 0.027, 0.009, 0.05, -0.01];
        let swapped: Vec<f64> = values.iter().map(|value| -value).collect();
        let (a, b) = (Shift::of(&values, 0.99), Shift::of(&swapped, 0.99));
        let (a, b) = (a.expect("nine"), b.expect("nine"));
        let ([low, high], [low_b, high_b]) = (a.interval.expect("n"), b.interval.expect("n"));
        assert!((a.estimate + b.estimate).abs() < 1e-15);
        assert!((low + high_b).abs() < 1e-15 && (high + low_b).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_number_gives_no_centre() {
        assert_eq!(Shift::of(&[], 0.99), None);
        assert_eq!(Shift::of(&[1.0, f64::NAN], 0.99), None);
        assert_eq!(Shift::of(&[1.0, f64::INFINITY], 0.99), None);
        assert_eq!(Shift::of(&[0.0; 54], 0.99), None);
    }

    #[test]
    fn bounds_of_rates_are_those_of_printed_tables() {
        let near = |found: [f64; 2], expected: [f64; 2]| {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 5e-5, "{found} {expected}");
            }
        };
        near(rate_bounds(0, 10, 0.95), [0.0, 0.3085]);
        near(rate_bounds(10, 10, 0.95), [0.6915, 1.0]);
        near(rate_bounds(5, 10, 0.95), [0.1871, 0.8129]);
        near(rate_bounds(0, 300, 0.95), [0.0, 0.0122]);
        near(rate_bounds(0, 0, 0.95), [0.0, 1.0]);
    }
}
