// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `flight`: what frames cost and show on the way from orbit to the ground, while the terrain's pieces
//! are still being made. Each way of making them is a case; so is a memory that is too small.

mod chapter;
mod metrics;
mod pace;
mod path;
mod study;

pub use study::FlightStudy;

/// Name of the study.
pub const STUDY: &str = "flight";
