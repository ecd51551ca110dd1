// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an opened way of culling does, on whichever interface.

use crate::draws::{Counted, Times};
use terrafill_fill::{DeviceError, Picture};

/// What was kept of the patches.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kept {
    /// Which, in any order.
    List(Vec<u32>),
    /// How many, where a stage hands them on within the pipeline.
    Count(u64),
}

impl Kept {
    pub(crate) fn count(&self) -> u64 {
        match self {
            Self::List(patches) => patches.len() as u64,
            Self::Count(count) => *count,
        }
    }
}

/// What a frame showed.
#[derive(Debug)]
pub(crate) struct Shown {
    pub(crate) picture: Picture,
    pub(crate) kept: Kept,
    pub(crate) counted: Counted,
    pub(crate) sent_bytes: u64,
}

/// Ground by one way, ready to be culled and drawn.
pub(crate) trait Culls {
    /// Draws it and reads back what it kept.
    fn draw(&mut self) -> Result<Shown, DeviceError>;

    /// Culls tiles, sends what is sent each frame, tests patches, draws, and waits.
    fn time(&mut self) -> Result<Times, DeviceError>;
}
