// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `growth`: how the cost of a mesh, from the text of its outline on, grows with its vertices.
//!
//! Shapes and sizes take turns in shuffled blocks, so that whatever else the machine does falls on all
//! of them alike.

mod chapter;
mod measure;
mod metrics;
mod study;

pub use measure::{GrowthProgram, growth_sample};
pub use study::GrowthStudy;

/// Name of the study.
pub const STUDY: &str = "growth";
