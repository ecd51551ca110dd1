// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rank statistics with exact null distributions, and no random generator.
//!
//! Two groups are compared by the number of pairs in which the second is larger (Mann and Whitney, 1947);
//! a trend by the number of pairs in order (Mann, 1945; Kendall, 1938), its slope by the median of all
//! pairwise slopes (Theil, 1950; Sen, 1968). Ties count half and are rounded towards no difference, which
//! makes probabilities larger, never smaller. Many tests share a rate of false discoveries (Benjamini and
//! Hochberg, 1995).

use std::collections::BTreeMap;
use terrafill_results::median;

/// Null distributions that were counted before.
#[derive(Debug, Default)]
pub(crate) struct Nulls {
    groups: BTreeMap<(usize, usize), Vec<f64>>,
    orders: BTreeMap<usize, Vec<f64>>,
}

impl Nulls {
    /// Two-sided probability that two groups of equal distribution differ by as much as these.
    pub(crate) fn groups(&mut self, before: &[f64], after: &[f64]) -> f64 {
        let (m, n) = (before.len(), after.len());
        let sizes = (m.min(n), m.max(n));
        let counts = self
            .groups
            .entry(sizes)
            .or_insert_with(|| larger_pairs(sizes.0, sizes.1));
        two_sided(counts, pairs_larger(before, after), (m * n) as f64)
    }

    /// The least that [`Self::groups`] can give for groups of these sizes.
    pub(crate) fn least(&mut self, m: usize, n: usize) -> f64 {
        let low = vec![0.0; m];
        let high = vec![1.0; n];
        self.groups(&low, &high)
    }

    /// Two-sided probability that values in random order are as ordered as these.
    pub(crate) fn order(&mut self, values: &[f64]) -> f64 {
        let n = values.len();
        let counts = self.orders.entry(n).or_insert_with(|| ordered_pairs(n));
        let ordered: f64 = (0..n)
            .map(|i| pairs_larger(&values[i..=i], &values[i + 1..]))
            .sum();
        two_sided(counts, ordered, (n * n.saturating_sub(1) / 2) as f64)
    }
}

/// Pairs of which the second is larger, ties counting half.
fn pairs_larger(before: &[f64], after: &[f64]) -> f64 {
    let pair = |a: &f64, b: &f64| match a.total_cmp(b) {
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Greater => 0.0,
    };
    let pairs = before
        .iter()
        .flat_map(|a| after.iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| pair(a, b)).sum()
}

/// Probability that a value of `after` is above one of `before`, or below where that is more probable.
pub(crate) fn separation(before: &[f64], after: &[f64]) -> f64 {
    let share = pairs_larger(before, after) / (before.len() * after.len()) as f64;
    share.max(1.0 - share)
}

/// Twice the tail of a symmetric null distribution, at most 1.
fn two_sided(counts: &[f64], statistic: f64, all: f64) -> f64 {
    let total: f64 = counts.iter().sum();
    let least = statistic.min(all - statistic).ceil();
    let below = (0..)
        .zip(counts)
        .take_while(|(at, _): &(u32, _)| f64::from(*at) <= least);
    let tail: f64 = below.map(|(_, count)| count).sum();
    (2.0 * tail / total).min(1.0)
}

/// How many of the choices of `m` ranks of `m + n` have each number of larger pairs.
fn larger_pairs(m: usize, n: usize) -> Vec<f64> {
    let all = m * n;
    // By the number of ranks chosen so far.
    let mut counts = vec![vec![0.0; all + 1]; m + 1];
    counts[0][0] = 1.0;
    for rank in 1..=m + n {
        for chosen in (1..=m.min(rank)).rev() {
            // The chosen rank is above so many that were not.
            let pairs = rank - chosen;
            if pairs > n {
                continue;
            }
            let (fewer, more) = counts.split_at_mut(chosen);
            for (to, from) in more[0][pairs..].iter_mut().zip(&fewer[chosen - 1]) {
                *to += from;
            }
        }
    }
    counts.swap_remove(m)
}

/// How many of the orders of `n` values have each number of ordered pairs.
fn ordered_pairs(n: usize) -> Vec<f64> {
    let mut counts = vec![1.0];
    for place in 1..n {
        let mut next = vec![0.0; counts.len() + place];
        for (at, count) in counts.iter().enumerate() {
            for to in &mut next[at..=at + place] {
                // Divided, so that 100! does not overflow.
                *to += count / (place + 1) as f64;
            }
        }
        counts = next;
    }
    counts
}

/// Median of all slopes between two values, for each step of the place.
pub(crate) fn slope(values: &[f64]) -> Option<f64> {
    let pairs = (0..values.len()).flat_map(|i| (i + 1..values.len()).map(move |j| (i, j)));
    let slopes: Vec<f64> = pairs
        .map(|(i, j)| (values[j] - values[i]) / (j - i) as f64)
        .collect();
    median(&slopes)
}

/// Groups of more pairs than this have the normal distribution of the statistic. Its cut differs from the exact one
/// by three pairs at most, while counting takes the square of the pairs' number.
const MAX_COUNTED_PAIRS: usize = 2500;

/// How many pairs an interval leaves out at each end, by the sizes of the groups: counted once for all cases of
/// the same sizes.
#[derive(Debug, Default)]
pub(crate) struct Cuts(BTreeMap<(usize, usize), Option<usize>>);

impl Cuts {
    fn of(&mut self, m: usize, n: usize, coverage: f64) -> Option<usize> {
        let sizes = (m.min(n), m.max(n));
        let cut = self.0.entry(sizes);
        *cut.or_insert_with(|| match m * n {
            counted if counted <= MAX_COUNTED_PAIRS => counted_cut(sizes, coverage),
            _ => Some(normal_cut(sizes, coverage)),
        })
    }
}

fn counted_cut((m, n): (usize, usize), coverage: f64) -> Option<usize> {
    let counts = larger_pairs(m, n);
    let total: f64 = counts.iter().sum();
    let tail = 0.5 * (1.0 - coverage);
    let mut below = 0.0;
    let within = counts.iter().take_while(|count| {
        below += **count;
        below / total <= tail
    });
    within.count().checked_sub(1)
}

/// The same by the normal distribution of mean m n / 2 and variance m n (m + n + 1) / 12 (Mann and Whitney, 1947).
fn normal_cut((m, n): (usize, usize), coverage: f64) -> usize {
    let (m, n) = (m as f64, n as f64);
    let deviation = (m * n * (m + n + 1.0) / 12.0).sqrt();
    // The quantile of a tail, within 0.0005 (Abramowitz and Stegun, 26.2.23).
    let t = (-2.0 * (0.5 * (1.0 - coverage)).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let cut = 0.5 * m * n - (t - above / below) * deviation - 0.5;
    (0..)
        .take_while(|at: &u32| f64::from(*at) <= cut)
        .count()
        .saturating_sub(1)
}

/// Median difference of two groups with the interval that inverts the exact test (Hodges and Lehmann,
/// 1963); no interval with too few values.
pub(crate) fn difference(
    before: &[f64],
    after: &[f64],
    coverage: f64,
    cuts: &mut Cuts,
) -> Option<(f64, Option<[f64; 2]>)> {
    let pairs = before.iter().flat_map(|a| after.iter().map(move |b| b - a));
    let mut differences: Vec<f64> = pairs.collect();
    differences.sort_by(f64::total_cmp);
    let middle = median(&differences)?;
    let cut = cuts.of(before.len(), after.len(), coverage);
    let interval = cut.map(|cut| [differences[cut], differences[differences.len() - 1 - cut]]);
    Some((middle, interval))
}

/// The largest of these probabilities that is a discovery at this rate of false ones; `None` where none is.
pub(crate) fn discovered(probabilities: &[f64], rate: f64) -> Option<f64> {
    let mut sorted = probabilities.to_vec();
    sorted.sort_by(f64::total_cmp);
    let tests = sorted.len() as f64;
    let within = (1_u32..).zip(sorted);
    let within = within.filter(|(rank, p)| *p <= rate * f64::from(*rank) / tests);
    within.last().map(|(_, p)| p)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(range: std::ops::RangeInclusive<u32>) -> Vec<f64> {
        range.map(f64::from).collect()
    }

    #[test]
    fn probabilities_are_those_of_printed_tables() {
        let mut nulls = Nulls::default();
        // 2 of C(10, 5) = 252 choices are as far apart; swapped operands are no other case.
        let (low, high) = (numbers(1..=5), numbers(6..=10));
        for p in [nulls.groups(&low, &high), nulls.groups(&high, &low)] {
            assert!((p - 2.0 / 252.0).abs() < 1e-12, "{p}");
        }
        // The critical value of U at 0.05 two-sided for 8 and 8 is 13: P(U ≤ 13) ≤ 0.025 < P(U ≤ 14).
        let counts = larger_pairs(8, 8);
        let total: f64 = counts.iter().sum();
        let tail = |to: usize| counts[..=to].iter().sum::<f64>() / total;
        assert!((total - 12_870.0).abs() < 1e-6);
        assert!(tail(13) <= 0.025 && tail(14) > 0.025);
        // Kendall: one of 4! orders is complete in each direction.
        assert!((nulls.order(&numbers(1..=4)) - 2.0 / 24.0).abs() < 1e-12);
        // Negative control: mixed values are no difference and no trend.
        assert!(nulls.groups(&[1.0, 4.0, 5.0, 8.0], &[2.0, 3.0, 6.0, 7.0]) > 0.9);
        assert!(nulls.order(&[2.0, 1.0, 4.0, 3.0, 2.5]) > 0.3);
    }

    #[test]
    fn ties_are_no_evidence() {
        let mut nulls = Nulls::default();
        assert_eq!(nulls.groups(&[1.0; 6], &[1.0; 6]), 1.0);
        assert_eq!(nulls.order(&[1.0; 12]), 1.0);
        assert_eq!(separation(&[1.0; 3], &[1.0; 4]), 0.5);
        assert_eq!(separation(&[1.0; 3], &[2.0; 4]), 1.0);
        assert_eq!(separation(&[2.0; 3], &[1.0; 4]), 1.0);
    }

    #[test]
    fn a_difference_has_an_interval_from_four_on_each_side() {
        let (a, b) = ([1.0, 2.0, 3.0, 4.0], [11.0, 12.0, 13.0, 14.0]);
        let mut cuts = Cuts::default();
        let mut difference = |a: &[f64], b: &[f64]| difference(a, b, 0.95, &mut cuts);
        let (middle, interval) = difference(&a, &b).expect("values");
        assert_eq!((middle, interval), (10.0, Some([7.0, 13.0])));
        let (swapped, interval) = difference(&b, &a).expect("values");
        assert_eq!((swapped, interval), (-10.0, Some([-13.0, -7.0])));
        // Negative controls: three say too little, and none nothing.
        assert_eq!(difference(&a[..3], &b).map(|(_, i)| i), Some(None));
        assert_eq!(difference(&[], &b), None);
    }

    #[test]
    fn large_groups_have_the_interval_that_counting_gives() {
        // Printed tables: 127 is the critical value of 20 and 20 at 0.05 two-sided, 317 of 30 and 30.
        for (sizes, cut) in [((20, 20), 127), ((30, 30), 317)] {
            assert_eq!(counted_cut(sizes, 0.95), Some(cut));
            assert!(normal_cut(sizes, 0.95).abs_diff(cut) <= 1, "{sizes:?}");
        }
        for coverage in [0.95, 0.99] {
            let (counted, normal) = (
                counted_cut((50, 50), coverage),
                normal_cut((50, 50), coverage),
            );
            assert!(
                counted.expect("many").abs_diff(normal) <= 3,
                "{counted:?} {normal}"
            );
        }
        // A thousand processes on each side are no more than sizes.
        assert!(Cuts::default().of(1000, 1000, 0.95) > Some(470_000));
    }

    #[test]
    fn one_wild_value_does_not_tilt_a_slope() {
        let mut values = numbers(1..=9);
        assert_eq!(slope(&values), Some(1.0));
        values[4] = 500.0;
        assert_eq!(slope(&values), Some(1.0));
        assert_eq!(slope(&[3.0]), None);
    }

    #[test]
    fn discoveries_are_those_of_the_worked_example() {
        // Benjamini and Hochberg (1995), section 3.2: at 0.05 the first four of fifteen.
        let p = [
            0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262,
            0.5719, 0.6528, 0.7590, 1.0,
        ];
        assert_eq!(discovered(&p, 0.05), Some(p[3]));
        // Negative controls: a rate of nothing, and no tests.
        assert_eq!(discovered(&p, 1e-6), None);
        assert_eq!(discovered(&[], 0.1), None);
    }
}
