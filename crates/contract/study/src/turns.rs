// SPDX-License-Identifier: MIT OR Apache-2.0
//! Measuring by turns: somebody else releases each sample, so that several processes, all alive, can
//! be compared frame by frame. Noise of a machine is local in time, and frames that follow one another
//! share it.

/// What a process that measures by turns is to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Begin a block, see [`crate::Session::begin_block`].
    Block,
    /// Take one sample of a case.
    Sample {
        /// Its place among those that are ready.
        place: usize,
        /// What the sample is the median of: short frames need many.
        of: u32,
        /// Whether the sample is kept; one that warms up is not.
        counts: bool,
    },
    /// Leave this group and make the next one ready.
    NextGroup,
}

/// Who releases the samples of a run, one by one.
pub trait Turns {
    /// A group's cases that can be timed, by key; none where it has nothing to time.
    ///
    /// # Errors
    /// A message, when nobody listens any more.
    fn ready(&mut self, cases: &[String]) -> Result<(), String>;

    /// Waits for the next turn.
    ///
    /// # Errors
    /// A message: no turn will come, or one that is not understood.
    fn next(&mut self) -> Result<Turn, String>;

    /// The turn is over.
    ///
    /// - `is_well`: false for a case that broke off
    ///
    /// # Errors
    /// As [`Turns::ready`].
    fn over(&mut self, is_well: bool) -> Result<(), String>;
}
