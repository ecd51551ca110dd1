// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `readback`: how long it takes to read an image back to the CPU, and at which rate, by
//! graphics interface and image size.
//!
//! An image is colour and depth of the render targets, four bytes a pixel each.

mod chapter;
mod metrics;
mod study;

pub use study::ReadbackStudy;

/// Name of the study.
pub const STUDY: &str = "readback";
