// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `precision`: how wrong every route from a fragment to its texture coordinate is, and what it
//! costs.
//!
//! Each formula is evaluated at many places of many regions, on the CPU by emulation and on the device
//! by the text that a fill compiles, and compared with the exact map in `f64`. Beside it stands the
//! error that was computed for it. Times are of the formula alone, in blocks in which every formula
//! and an empty one take a turn (see [`terrafill_gpu::Evaluator`]). Residuals and measurements use
//! different places on purpose: the residual's are those of `MapRegion::samples`, the measured ones a
//! Halton sequence, so that neither can fit itself.

mod chapter;
mod coordinate;
mod error;
mod findings;
mod kernel;
mod metrics;
mod place;
mod position;
mod routes;
mod row;
mod sight;
mod special;
mod study;
mod suite;
mod vertex;

pub use chapter::PrecisionChapter;
pub use findings::suite_findings;
pub use row::{PrecisionPart, PrecisionRow};
pub use study::PrecisionStudy;
pub use suite::measure_suite;

/// Name of the study.
pub const STUDY: &str = "precision";
