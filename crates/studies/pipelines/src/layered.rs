// SPDX-License-Identifier: MIT OR Apache-2.0
//! Listed triangles drawn into layers, and pictures that look the layers up: variance and hard shadows, motion blur.
//!
//! What a device shows is held against the definitions that the CPU has of the same, within what rounding allows.

mod blurred;
mod listed;
mod on_wgpu;
mod opened;
mod shaded;
mod shaded_study;
mod turning;
mod variance_bounds;

pub(crate) use blurred::groups as blurs;
pub(crate) use shaded_study::group as shades;
pub(crate) use variance_bounds::{TAPS, light as share_bounds};
