// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every threshold of the trends, each with its reason. All of them are advisory: only `gate`, which runs
//! both versions by turns, decides.

/// Fewest commits of a series in which a change is looked for: fewer give no rank test a small enough
/// probability.
pub const MIN_POINTS: usize = 10;

/// Fewest commits on each side of a step. A step nearer to the newest commit is seen later.
pub const MIN_SIDE: usize = 5;

/// Newest commits of a series that are looked at: older ones say nothing of today's changes, and the
/// exact null distributions grow with the fourth power.
pub const MAX_POINTS: usize = 100;

/// Smallest change that is named, in percent; the gate's floor.
pub const FLOOR_PERCENT: f64 = 3.0;

/// A change is at least this many times the median distance of points from their own side's median.
pub const MIN_RESIDUALS: f64 = 3.0;

/// Smallest probability that a point after a step is above one before it (or below, for a fall).
pub const MIN_SEPARATION: f64 = 0.85;

/// Expected share of false changes among those named, over every test of every series (Benjamini and
/// Hochberg, 1995).
pub const FALSE_DISCOVERY_RATE: f64 = 0.10;

/// Coverage of the interval of a ratio of two runs' times. It needs four processes on each side.
pub const COVERAGE: f64 = 0.95;

/// Share of a commit's series that must have changed there for the machine to be the likelier cause.
pub const COMMON_SHARE: f64 = 0.5;
