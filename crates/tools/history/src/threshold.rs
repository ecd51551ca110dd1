// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every threshold of the trends, each with its reason. All of them are advisory: only `gate`, which runs
//! both versions by turns, decides.

/// Fewest commits of a series in which a change is looked for: from fewer differences of neighbours a
/// scatter is a guess.
pub const MIN_POINTS: usize = 8;

/// Fewest commits on each side of a step: two may be spikes. A step nearer to the newest commit is seen
/// later.
pub const MIN_SIDE: usize = 3;

/// Newest commits of a series that are looked at: older ones say nothing of today's changes, and the
/// exact null distributions grow with the fourth power.
pub const MAX_POINTS: usize = 100;

/// Smallest change that is named, in percent; the gate's floor.
pub const FLOOR_PERCENT: f64 = 3.0;

/// A change is at least this many times the median distance of points from their own side's median.
pub const MIN_RESIDUALS: f64 = 3.0;

/// Smallest probability that a point after a step is above one before it (or below, for a fall).
pub const MIN_SEPARATION: f64 = 0.85;

/// Expected share of false changes among those named, one half for steps and one for drifts: each over
/// every series that can be decided (Benjamini and Hochberg, 1995).
pub const FALSE_DISCOVERY_RATE: f64 = 0.10;

/// Fewest series that borrow scatter from each other: fewer do not tell how alike they are.
pub const MIN_ALIKE: usize = 10;

/// Random orders of each series at least, from which the sizes of steps by chance come. Of 300 series that
/// makes 30,000, of which five are as large as a lone step has to be.
pub const MIN_ORDERS: usize = 100;

/// Smallest scatter of logarithms that is believed: times are not repeated more closely.
pub const MIN_SCATTER: f64 = 0.0005;

/// A time in which a lone step is found only from this size on, in percent, even in the middle of its
/// commits, counts as undecided.
pub const MAX_HIDDEN_PERCENT: f64 = 25.0;

/// Coverage of the interval of a ratio of two runs' times. It needs four processes on each side.
pub const COVERAGE: f64 = 0.95;

/// Share of a commit's series that must have changed there for the machine to be the likelier cause.
pub const COMMON_SHARE: f64 = 0.5;
