// SPDX-License-Identifier: MIT OR Apache-2.0
//! What kept blocks do, on whichever interface.

use crate::draws::Times;
use terrafill_contract::DeviceError;

/// Blocks kept in one way.
pub(super) trait Keeps {
    /// Looks everything up and waits.
    fn look_up(&self) -> Result<Times, DeviceError>;

    /// Writes a block and waits until the device has it.
    fn update(&self, block: u32, texels: &[f32]) -> Result<Times, DeviceError>;

    /// What was found last.
    fn read(&self) -> Result<Vec<f32>, DeviceError>;

    /// Bind groups or descriptor sets of a frame, and dispatches.
    fn binds(&self) -> usize;
}
