// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every threshold of the gate, each with its reason.

use terrafill_results::Clock;

/// Blocks of the first look at every case. Five give a median that one or two slow processes cannot
/// move.
pub const SCREEN_BLOCKS: u32 = 5;

/// Cases whose median moved by this share of the floor in the first look are measured again, so that a change of
/// the floor's size is hardly ever passed over.
pub const SCREEN_SHARE: f64 = 2.0 / 3.0;

/// Fresh blocks that decide. With 2 % spread between processes their 99 % interval is ±1.3 % wide.
pub const CONFIRM_BLOCKS: u32 = 20;

/// Rounds of [`CONFIRM_BLOCKS`], of which a further one measures what is undecided so far. Each looks once more at
/// 99 %, so the same work could be called in 3 of 100 cases instead of 1. The floor must be reached as well, which the
/// same work hardly ever does by more blocks (`time/tests.rs`).
pub const CONFIRM_ROUNDS: u32 = 3;

/// Fewest blocks that decide where the time budget ends early: 12 give the base-against-base
/// comparison its 6 differences, the fewest with a 95 % interval.
pub const MIN_CONFIRM_BLOCKS: u32 = 12;

/// Coverage of the interval that decides.
pub const COVERAGE: f64 = 0.99;

/// Coverage of the base-against-base interval: lower, since it has half the differences where whole
/// processes go by turns.
pub const NULL_COVERAGE: f64 = 0.95;

/// Share of the blocks that must agree on the direction of a change.
pub const MIN_AGREEMENT: f64 = 0.8;

/// Smallest change that fails, in percent: 0.6 of 5 %, which must be caught. Changes of the floor's
/// own size are caught half of the time.
pub const FLOOR_PERCENT: f64 = 3.0;

/// Smallest change of the wall clock that fails, in percent: other programs that share a core make it longer. A
/// frame that waits half a millisecond is beyond it wherever one takes less than 5 ms.
pub const WALL_FLOOR_PERCENT: f64 = 10.0;

/// The same in milliseconds: a turn of the scheduler is a tenth of one.
pub const WALL_FLOOR_MS: f64 = 0.1;

/// Smallest change of preparation and planning that fails, in percent. A process does both once, with cold caches,
/// so identical work differs by tens of percent from process to process.
pub const SETUP_FLOOR_PERCENT: f64 = 50.0;

/// Smallest difference of preparation that fails, milliseconds.
pub const PREPARATION_FLOOR_MS: f64 = 1.0;

/// Smallest difference of planning that fails, milliseconds: it is the median of several plans.
pub const PLANNING_FLOOR_MS: f64 = 0.02;

/// Looks at preparation and planning before these are measured in earnest. The first is free: both programs verify
/// their pictures.
pub const SETUP_LOOKS: u32 = 2;

/// Pairs of fresh processes that decide about them: the fewest with a 95 % interval, of which all have to agree.
pub const SETUP_PAIRS: u32 = 6;

/// Coverage of that interval.
pub const SETUP_COVERAGE: f64 = 0.95;

/// A case that takes less than this share of its former time is not taken for an improvement: it may
/// have stopped doing its work.
pub const MIN_PLAUSIBLE_RATIO: f64 = 0.5;

/// Smallest difference that fails, milliseconds: below it a relative change is about the clock and not
/// about the work.
#[must_use]
pub fn floor_ms(clock: Clock) -> f64 {
    match clock {
        // Steps of device clocks are up to 1 µs.
        Clock::Gpu => 0.005,
        // Half of what submitting and waiting alone take on a software device. Both sides spend that, and
        // a floor of all of it passes over 5 % of a frame of 0.4 ms.
        Clock::ProcessCpu => 0.01,
    }
}

/// Annotations that GitHub shows of one step.
pub const MAX_ANNOTATIONS: usize = 10;
