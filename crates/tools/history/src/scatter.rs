// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether series step by more than they scatter, and how often series without a step would.
//!
//! A rank test sees only the order of values. Of twelve commits, three of which are later than all others,
//! it says 1 in 110, whether they are later by 1 % or by ten times. Hundreds of series need 1 in 6000. So a
//! step is measured in units of its own series' scatter. That comes from differences between neighbouring
//! commits: a step is in one of them alone, and a drift in none by much.
//!
//! Few commits tell a scatter badly. Series of one machine and metric therefore borrow from each other, by
//! as much as they are alike (empirical Bayes; Smyth, 2004), and none is moved further than its own error
//! allows (limited translation; Efron and Morris, 1972). The times themselves say how large the largest step
//! of a series without any is: every series is put in random order again and again. A series with an
//! outstanding step is so without that step. So heavy tails, which timing has, raise the threshold by themselves.
//! The seed is fixed.

use crate::threshold::{MIN_ALIKE, MIN_ORDERS, MIN_SCATTER, MIN_SIDE};
use terrafill_results::{SplitMix64, median};

/// Seed of the orders: the same history always gives the same changes.
const SEED: u64 = 1;

/// Share of the differences between neighbours that are left out as steps and spikes, the largest.
const TRIMMED: f64 = 0.2;

/// Probability of a step that a series is not put in random order with.
const OUTSTANDING: f64 = 0.01;

/// Scatters that a value counts for at most in its level.
const MAX_INFLUENCE: f64 = 1.5;

/// Standard errors that a scatter is moved towards others at most.
const MAX_MOVE: f64 = 2.0;

/// The place that splits values best into two levels: with the least absolute residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cut {
    /// First value after it.
    pub(crate) at: usize,
    /// Median of each side.
    pub(crate) levels: [f64; 2],
}

impl Cut {
    /// The best one of these values; `None` with too few for two sides.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        let before = levels(values.iter().copied());
        let after = levels(values.iter().rev().copied());
        let places = MIN_SIDE..=n.checked_sub(MIN_SIDE)?;
        let residuals = |at: &usize| before[at - 1].1 + after[n - at - 1].1;
        let at = places.min_by(|a, b| residuals(a).total_cmp(&residuals(b)))?;
        Some(Self {
            at,
            levels: [before[at - 1].0, after[n - at - 1].0],
        })
    }

    /// Its step in units of what the difference of two levels scatters by.
    ///
    /// - `values`: that it is of
    pub(crate) fn size(&self, values: &[f64], scatter: f64) -> f64 {
        let [before, after] = self.robust_levels(values, scatter);
        let error = error(self.at, values.len() - self.at);
        (after - before).abs() / (scatter * error)
    }

    /// Levels one step towards the location of Huber (1964): nearly means, and no spike moves them far.
    fn robust_levels(&self, values: &[f64], scatter: f64) -> [f64; 2] {
        let far = MAX_INFLUENCE * scatter;
        let level = |values: &[f64], median: f64| {
            let near = values.iter().map(|value| (value - median).clamp(-far, far));
            median + near.sum::<f64>() / values.len() as f64
        };
        let (before, after) = values.split_at(self.at);
        [level(before, self.levels[0]), level(after, self.levels[1])]
    }

    /// What is left of values without its step, as widely scattered as before.
    fn rest(&self, values: &[f64], scatter: f64) -> Vec<f64> {
        let levels = self.robust_levels(values, scatter);
        let sizes = [self.at, values.len() - self.at];
        let values = values.iter().enumerate();
        values
            .map(|(at, value)| {
                let side = usize::from(at >= self.at);
                // A mean of n values takes an nth of their variance with it.
                (value - levels[side]) / (1.0 - 1.0 / sizes[side] as f64).sqrt()
            })
            .collect()
    }
}

/// Standard error of the difference of two means, in standard deviations of a value.
pub(crate) fn error(before: usize, after: usize) -> f64 {
    (1.0 / before as f64 + 1.0 / after as f64).sqrt()
}

/// For every number of values from the front: their median, and the sum of distances from it.
fn levels(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let mut sorted: Vec<f64> = Vec::new();
    let level = |value: f64| {
        let at = sorted.partition_point(|known| *known < value);
        sorted.insert(at, value);
        let n = sorted.len();
        let (low, high) = sorted.split_at(n / 2);
        let middle = high[0];
        let (median, high) = match n % 2 {
            0 => (0.5 * (low[low.len() - 1] + middle), high),
            _ => (middle, &high[1..]),
        };
        (median, high.iter().sum::<f64>() - low.iter().sum::<f64>())
    };
    values.map(level).collect()
}

/// Logarithm of the scatter of values, up to a factor: the mean difference of neighbours, without the largest.
fn log_scatter(values: &[f64]) -> f64 {
    let mut differences: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    differences.sort_by(f64::total_cmp);
    #[allow(clippy::cast_possible_truncation, reason = "a share of a small count")]
    let left_out = (TRIMMED * differences.len() as f64).ceil() as usize;
    differences.truncate(differences.len() - left_out);
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    mean.max(MIN_SCATTER).ln()
}

/// The mean of the four fifths of smaller differences of normal neighbours, in standard deviations.
const NORMAL: f64 = 0.79;

/// How the scatters of alike series are combined.
#[derive(Debug, Clone, Copy)]
struct Prior {
    /// Share of its own scatter that a series keeps.
    own: f64,
    /// Standard error of a logarithm of a scatter.
    error: f64,
}

impl Prior {
    /// From how far the two halves of each series agree: what they share is true, the rest is error.
    fn of(series: &[&[f64]]) -> Self {
        let alone = Self {
            own: 1.0,
            error: 0.0,
        };
        if series.len() < MIN_ALIKE {
            return alone;
        }
        let halves = series.iter().map(|values| {
            let half = values.len() / 2;
            [&values[..half], &values[values.len() - half..]].map(log_scatter)
        });
        let halves: Vec<[f64; 2]> = halves.collect();
        let wholes: Vec<f64> = series.iter().map(|values| log_scatter(values)).collect();
        let [first, second] = [0, 1].map(|side| halves.iter().map(|half| half[side]).collect());
        let (spread, shared) = (
            covariance(&wholes, &wholes),
            covariance::<Vec<f64>>(&first, &second),
        );
        if spread <= 0.0 {
            return alone;
        }
        let own = (shared / spread).clamp(0.0, 1.0);
        Self {
            own,
            error: (spread * (1.0 - own)).sqrt(),
        }
    }

    /// Scatters of series, from their logarithms.
    fn scatters(self, logs: &[f64]) -> impl Iterator<Item = f64> {
        let middle = median(logs).unwrap_or(0.0);
        logs.iter().map(move |log| {
            let most = MAX_MOVE * self.error;
            let moved = (1.0 - self.own) * (middle - log);
            (log + moved.clamp(-most, most)).exp() / NORMAL
        })
    }
}

fn covariance<T: AsRef<[f64]>>(a: &T, b: &T) -> f64 {
    let (a, b) = (a.as_ref(), b.as_ref());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (of_a, of_b) = (mean(a), mean(b));
    let products = a.iter().zip(b).map(|(x, y)| (x - of_a) * (y - of_b));
    products.sum::<f64>() / (a.len() as f64 - 1.0)
}

/// Series of one history: their scatters, and the sizes of steps that there are without any.
#[derive(Debug)]
pub(crate) struct Scatters {
    /// Of each series, in the order in which they were given.
    pub(crate) each: Vec<f64>,
    /// Ascending.
    by_chance: Vec<f64>,
}

impl Scatters {
    /// Of groups of series that are alike, each with values enough for two sides.
    pub(crate) fn of(groups: &[Vec<&[f64]>]) -> Self {
        let count: usize = groups.iter().map(Vec::len).sum();
        let orders = MIN_ORDERS.max((10 * MIN_ORDERS).div_ceil(count.max(1)));
        let mut random = SplitMix64::new(SEED);
        let alike = |group: &Vec<&[f64]>| {
            let logs: Vec<f64> = group.iter().map(|values| log_scatter(values)).collect();
            let prior = Prior::of(group);
            let scatters: Vec<f64> = prior.scatters(&logs).collect();
            (prior, scatters)
        };
        let (priors, scatters): (Vec<Prior>, Vec<Vec<f64>>) = groups.iter().map(alike).unzip();
        // Without their steps all series have somewhat smaller steps by chance than whole ones, and a
        // scatter that is smaller still. That is good enough to say which steps are outstanding.
        let without = |(group, scatters): (&Vec<&[f64]>, &Vec<f64>)| {
            let of = |(values, scatter): (&&[f64], &f64)| {
                let cut = Cut::of(values)?;
                Some((cut.size(values, *scatter), cut.rest(values, *scatter)))
            };
            let all = group.iter().zip(scatters);
            all.map(|pair| of(pair).unwrap_or((0.0, pair.0.to_vec())))
                .collect::<Vec<(f64, Vec<f64>)>>()
        };
        let sized: Vec<Vec<(f64, Vec<f64>)>> = groups.iter().zip(&scatters).map(without).collect();
        let rests = sized
            .iter()
            .map(|group| group.iter().map(|(_, rest)| rest.clone()).collect());
        let mut found = Self {
            each: scatters.into_iter().flatten().collect(),
            by_chance: by_chance(rests.collect(), &priors, orders.div_ceil(5), &mut random),
        };
        let outstanding = found.size_at(OUTSTANDING);
        let whole = groups.iter().zip(sized).map(|(group, sized)| {
            let pairs = group.iter().zip(sized);
            let of = |(values, (size, rest)): (&&[f64], (f64, Vec<f64>))| {
                if size < outstanding {
                    values.to_vec()
                } else {
                    rest
                }
            };
            pairs.map(of).collect()
        });
        found.by_chance = by_chance(whole.collect(), &priors, orders, &mut random);
        found
    }

    /// Probability of so large a step in a series without any.
    pub(crate) fn probability(&self, size: f64) -> f64 {
        let smaller = self.by_chance.partition_point(|known| *known < size);
        let larger = self.by_chance.len() - smaller;
        (larger + 1) as f64 / (self.by_chance.len() + 1) as f64
    }

    /// The size that has this probability.
    pub(crate) fn size_at(&self, probability: f64) -> f64 {
        #[allow(clippy::cast_possible_truncation, reason = "a share of a count")]
        let larger = (probability * (self.by_chance.len() + 1) as f64) as usize;
        let at = self.by_chance.len().saturating_sub(larger.max(1));
        self.by_chance.get(at).copied().unwrap_or(f64::INFINITY)
    }
}

/// The sizes of the largest steps of series in random orders, ascending.
fn by_chance(
    mut groups: Vec<Vec<Vec<f64>>>,
    priors: &[Prior],
    orders: usize,
    random: &mut SplitMix64,
) -> Vec<f64> {
    let mut sizes = Vec::new();
    for (group, prior) in groups.iter_mut().zip(priors) {
        for _ in 0..orders {
            for values in group.iter_mut() {
                shuffle(values, random);
            }
            let logs: Vec<f64> = group.iter().map(|values| log_scatter(values)).collect();
            let size = |(values, scatter): (&Vec<f64>, f64)| {
                Cut::of(values).map_or(0.0, |cut| cut.size(values, scatter))
            };
            sizes.extend(group.iter().zip(prior.scatters(&logs)).map(size));
        }
    }
    sizes.sort_by(f64::total_cmp);
    sizes
}

/// Fisher and Yates (1938).
fn shuffle(values: &mut [f64], random: &mut SplitMix64) {
    for last in (1..values.len()).rev() {
        values.swap(last, random.below(last + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_cut_is_that_of_all_medians() {
        let values = [3.0, 1.0, 2.0, 2.5, 9.0, 8.0, 9.5, 8.5, 2.0];
        let cut = Cut::of(&values).expect("two sides");
        assert_eq!((cut.at, cut.levels), (4, [2.25, 8.5]));
        let sums: Vec<f64> = levels(values.into_iter())
            .into_iter()
            .map(|l| l.1)
            .collect();
        assert_eq!(sums[..4], [0.0, 2.0, 2.0, 2.5]);
        assert_eq!(Cut::of(&values[..2 * MIN_SIDE - 1]), None);
    }

    #[test]
    fn scatter_is_that_of_neighbours_and_not_of_steps() {
        let mut random = SplitMix64::new(3);
        let noise = |random: &mut SplitMix64| {
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            0.02 * radius * (std::f64::consts::TAU * random.unit()).cos()
        };
        let quiet: Vec<f64> = (0..2000).map(|_| noise(&mut random)).collect();
        let stepped: Vec<f64> = (0..)
            .zip(&quiet)
            .map(|(at, v)| v + f64::from(at / 500))
            .collect();
        for values in [quiet, stepped] {
            let found = log_scatter(&values).exp() / NORMAL;
            assert!((found - 0.02).abs() < 0.001, "{found}");
        }
    }
}
