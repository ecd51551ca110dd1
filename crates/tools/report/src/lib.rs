// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run's tables to pages, a summary and a verdict; opens no device and knows no study.
//!
//! [`write()`] reads a run folder and lays out what the studies' chapters say of it: `index.html` with the
//! answers, and beside it `pages/` with a page for each chapter or each of its long sections, and every
//! figure as SVG and CSV. Plots are inline SVG, links are relative, nothing is loaded from elsewhere, and
//! without scripts only sorting, filters and the like are gone. [`write_single_file`] puts all of it
//! into one file that can be mailed. A run that broke off gives a report that says so and names what is
//! missing; what was not measured is a dash with its reason, never a 0.

mod clocks;
mod contents;
mod error;
mod front;
mod glossary;
mod markdown;
mod pages;
mod picture;
mod table;
mod verdict;
mod view;
mod write;

pub use error::ReportError;
pub use glossary::{TECHNIQUES, TermGroup};
pub use verdict::{Counts, Verdict};
pub use write::{WrittenReport, write, write_page, write_single_file};
