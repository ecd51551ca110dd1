// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an opened way does, on whichever interface.

use terrafill_fill::{DeviceError, Picture};

/// Times of a frame, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Times {
    /// Process CPU time from sending until the device is done.
    pub(crate) cpu_ms: f64,
    /// Wall clock over the same span.
    pub(crate) wall_ms: f64,
    /// GPU clock of dispatch and draw.
    pub(crate) gpu_ms: Option<f64>,
}

/// What the device counted; absent where it counts nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counted {
    pub(crate) vertex_invocations: Option<u64>,
    pub(crate) geometry_invocations: Option<u64>,
    pub(crate) primitives: Option<u64>,
    pub(crate) fragments: Option<u64>,
}

/// A grid by one way, ready to be drawn.
pub(crate) trait Draws {
    /// Draws it and reads it back.
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError>;

    /// Sends what is sent each frame, draws, and waits.
    fn time(&mut self) -> Result<Times, DeviceError>;
}
