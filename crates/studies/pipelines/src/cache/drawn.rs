// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks, whatever keeps them, and craters drawn into the layers of an array texture.
//!
//! Every way must show the picture of the same ground as one grid, which rays verify.

mod craters;
mod ground;
mod on_vulkan;
mod on_wgpu;
mod study;

pub(crate) use craters::{CraterWay, group as crater_group};
pub(crate) use study::groups as drawn_groups;
