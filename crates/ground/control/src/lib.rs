// SPDX-License-Identifier: MIT OR Apache-2.0
//! Controllers of level of detail by counted pixels, as discrete loops: one step a frame, each using a count
//! that is some frames old. (Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds using Programmable
//! Graphics Hardware", print neither thresholds nor gains.)
//!
//! No device and no clock: what a loop does follows from its numbers alone.

mod probe;
mod quadtree;
mod radius;
mod zones;

pub use probe::OuterProbe;
pub use quadtree::{Node, Quadtree, QuadtreeView, Settling, Thresholds, settle};
pub use radius::{
    Cycle, constant_step, cycle, gain_without_overshoot, logarithmic, proportional, stable_gain,
};
pub use zones::{ZoneRule, changes_to_the_end, cycling_zones};
