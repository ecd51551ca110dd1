// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every threshold of the statistics, each with its reason.

/// Resamples of a bootstrap: at 95 % the standard error of a survival rate is 0.7 %.
pub const BOOTSTRAP_RESAMPLES: u32 = 1000;

/// Seed of every bootstrap. Any number will do; a fixed one makes reports repeatable.
pub const BOOTSTRAP_SEED: u64 = 0x7465_7272_6166_696c;

/// Share of the resamples that an interval covers.
pub const INTERVAL_COVERAGE: f64 = 0.95;

/// Fewest replicates from which an interval or a place on a front is formed. The median of fewer
/// hardly moves under resampling, which would look like certainty: of 5, the smallest and the largest
/// hold the true median in 1 − 2 · ½⁵ = 94 % of all cases.
pub const MIN_REPLICATES: usize = 5;

/// Share of resamples in which a case must lie on the Pareto front to be drawn on it.
pub const FRONT_SURVIVAL: f64 = 0.95;

/// Ratios closer to 1 than this factor are no difference: times of one binary repeat within 5 % on a
/// software driver.
pub const MIN_DIFFERENCE: f64 = 1.05;

/// Least band of no difference that repeats can give: clocks of software devices step by less, and what two of three
/// pairs of identical work happen to agree by says little.
pub const MIN_BAND: f64 = 1.005;
