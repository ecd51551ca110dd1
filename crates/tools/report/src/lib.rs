// SPDX-License-Identifier: MIT OR Apache-2.0
//! CSV to statistics, plots and HTML; opens no device.
//!
//! [`write_report`] reads a run folder as `terrafill-results` writes it and puts one self-contained
//! `report.html` into it: pictures are data URIs, plots are inline SVG, and nothing is loaded from
//! elsewhere, so the file can be mailed. A run that broke off gives a report that says so and names
//! what is missing; what was not measured is a dash with its reason, never a 0.

mod error;
mod exponent;
mod glossary;
mod growth;
mod interval;
mod ladder;
mod markdown;
mod matrix;
mod memory;
mod number;
mod page;
mod pairs;
mod picture;
mod plot;
mod precision;
mod published;
mod run_data;
mod statistic;
mod subdivision;
mod textured;
mod verdict;
mod view;
mod write;

pub use error::{ReportError, WriteError};
pub use verdict::{Counts, Verdict};
pub use write::{WrittenReport, write};

use run_data::{Outcome, RunData};
use std::path::{Path, PathBuf};

/// What a report says in numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReportSummary {
    /// The report.
    pub path: PathBuf,
    /// Cases whose picture is right and whose times were measured.
    pub ok: usize,
    /// Cases whose picture is wrong.
    pub wrong: usize,
    /// Those of them that belong to a sweep through the boundary tolerance, where a wrong picture is
    /// a result.
    pub wrong_in_sweep: usize,
    /// Cases not run, with a reason.
    pub skipped: usize,
    /// Cases that broke off, with a reason.
    pub failed: usize,
    /// Planned cases of which the run says nothing.
    pub missing: usize,
}

/// Writes `report.html` into `run_folder` from the files there.
///
/// The report replaces an older one in one step, so a reader never meets half a file.
///
/// # Errors
/// [`ReportError::Run`] when the folder holds no run or a file in it does not fit the schema, with
/// the file and the row; [`ReportError::Io`] when the report cannot be written.
pub fn write_report(run_folder: &Path) -> Result<ReportSummary, ReportError> {
    let data = RunData::load(run_folder)?;
    let html = page::render(&data)?;
    let path = run_folder.join("report.html");
    let unfinished = run_folder.join("report.html.new");
    std::fs::write(&unfinished, html)
        .and_then(|()| std::fs::rename(&unfinished, &path))
        .map_err(|source| ReportError::Io {
            path: path.clone(),
            source,
        })?;
    Ok(ReportSummary {
        path,
        ok: data.count(Outcome::Ok),
        wrong: data.count(Outcome::Wrong),
        wrong_in_sweep: data.wrong_in_sweep(),
        skipped: data.count(Outcome::Skipped),
        failed: data.count(Outcome::Failed),
        missing: data.count(Outcome::Missing),
    })
}
