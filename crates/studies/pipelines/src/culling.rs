// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two levels of culling: tiles on the CPU, patches on the device, as published and as it can be exact.
//!
//! Level 1 keeps the tiles whose box of least and greatest height meets the frustum. Level 2 tests patches of
//! 8 × 8 cells of those tiles: "against a range", as published, or by their boxes. Which patches are needed is
//! said by the reference, cell by cell in `f64`.

mod culls;
mod frustum;
mod ground;
mod needed;
mod on_vulkan;
mod on_wgpu;
mod study;
mod way;

pub(crate) use study::group;
pub(crate) use way::{CullStage, RANGES, Test, VIEWS};
