// SPDX-License-Identifier: MIT OR Apache-2.0
//! Drawing a sample again from itself (Efron, 1979, "Bootstrap methods"), with a fixed seed.

use crate::threshold::BOOTSTRAP_SEED;
use crate::{SplitMix64, median};

/// The same numbers in every report.
pub(crate) fn generator() -> SplitMix64 {
    SplitMix64::new(BOOTSTRAP_SEED)
}

/// Median of as many values drawn with repetition. Infinite for no values, so that a case without
/// times is never on a front.
pub(crate) fn resampled_median(random: &mut SplitMix64, values: &[f64]) -> f64 {
    let resample: Vec<f64> = values
        .iter()
        .map(|_| values[random.below(values.len())])
        .collect();
    median(&resample).unwrap_or(f64::INFINITY)
}
