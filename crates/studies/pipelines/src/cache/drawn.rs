// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks, whatever keeps them.
//!
//! Every way must show the picture of the same ground as one grid, which rays verify.

mod ground;
mod on_vulkan;
mod on_wgpu;
mod study;

pub(crate) use study::groups as drawn_groups;
