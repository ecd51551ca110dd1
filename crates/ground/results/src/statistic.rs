// SPDX-License-Identifier: MIT OR Apache-2.0
//! The statistics that rows and plots use; each formula stands here only.

/// 5th percentile, median and 95th percentile of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// 5th percentile.
    pub p5: f64,
    /// Median.
    pub median: f64,
    /// 95th percentile.
    pub p95: f64,
}

/// Quantile `q` in 0 … 1 by linear interpolation between order statistics (Hyndman and Fan, 1996,
/// type 7). `None` for an empty sample or one that holds a NaN.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    reason = "the rank lies within the slice's length"
)]
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let mut values = values.to_vec();
    let rank = q.clamp(0.0, 1.0) * (values.len() - 1) as f64;
    // Two values in order are all that is needed: a picture's pixels are a million.
    let place = rank.floor() as usize;
    let (_, low, above) = values.select_nth_unstable_by(place, f64::total_cmp);
    let next = above.iter().copied().min_by(f64::total_cmp);
    let high = next.filter(|_| rank > place as f64).unwrap_or(*low);
    Some(*low + (high - *low) * (rank - place as f64))
}

/// Median; see [`quantile`].
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// Percentiles for whiskers; see [`quantile`].
#[must_use]
pub fn spread(values: &[f64]) -> Option<Spread> {
    Some(Spread {
        p5: quantile(values, 0.05)?,
        median: median(values)?,
        p95: quantile(values, 0.95)?,
    })
}

impl Spread {
    /// The same divided by a baseline.
    #[must_use]
    pub fn over(self, baseline: f64) -> Self {
        Self {
            p5: self.p5 / baseline,
            median: self.median / baseline,
            p95: self.p95 / baseline,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(median(&values), Some(2.5));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 1.0), Some(4.0));
        assert_eq!(quantile(&values, 0.25), Some(1.75));
    }

    #[test]
    fn nothing_measured_is_no_number() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[1.0, f64::NAN]), None);
    }
}
