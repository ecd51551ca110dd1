// SPDX-License-Identifier: MIT OR Apache-2.0
//! Drawing a sample again from itself (Efron, 1979, "Bootstrap methods"), with a fixed seed.

use crate::median;
use crate::threshold::BOOTSTRAP_SEED;

/// The generator of Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators".
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    /// The same numbers in every report.
    pub(crate) fn new() -> Self {
        Self(BOOTSTRAP_SEED)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `limit`, by multiplication (Lemire, 2019); its bias of `limit` / 2⁶⁴ is nothing here.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the high half of the product is below `limit`"
    )]
    fn below(&mut self, limit: usize) -> usize {
        ((u128::from(self.next()) * limit as u128) >> 64) as usize
    }

    /// Median of as many values drawn with repetition. Infinite for no values, so that a case
    /// without times is never on a front.
    pub(crate) fn resampled_median(&mut self, values: &[f64]) -> f64 {
        let resample: Vec<f64> = values
            .iter()
            .map(|_| values[self.below(values.len())])
            .collect();
        median(&resample).unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resampling_draws_every_value_about_equally_often() {
        let mut random = SplitMix64::new();
        let mut drawn = [0_u32; 7];
        for _ in 0..70_000 {
            drawn[random.below(7)] += 1;
        }
        // Five standard deviations of a count with mean 10,000 are 463.
        assert!(drawn.iter().all(|&n| n.abs_diff(10_000) < 463), "{drawn:?}");
    }
}
