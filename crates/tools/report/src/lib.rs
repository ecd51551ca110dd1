// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run's tables to one page, a summary and a verdict; opens no device and knows no study.
//!
//! [`write()`] reads a run folder and lays out what the studies' chapters say of it. `index.html` needs no
//! file beside it: pictures are data URIs, plots are inline SVG, and nothing is loaded from elsewhere,
//! so the file can be mailed. A run that broke off gives a report that says so and names what is
//! missing; what was not measured is a dash with its reason, never a 0.

mod error;
mod markdown;
mod picture;
mod verdict;
mod view;
mod write;

pub use error::ReportError;
pub use verdict::{Counts, Verdict};
pub use write::{WrittenReport, write};
