// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `moving`: what regions cost that change in every frame, such as what sensors see.
//!
//! Cones sweep over a globe of countries. In every frame their footprints are meshed anew, uploaded
//! and filled, by each technique and by three ways of keeping a scene up to date, and every frame is
//! compared with the reference of that frame.

mod chapter;
mod metrics;
mod sensors;
mod stage;
mod study;

pub use study::MovingStudy;

/// Name of the study.
pub const STUDY: &str = "moving";
