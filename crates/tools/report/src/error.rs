// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can go wrong between a run's folder and its report.

use std::path::PathBuf;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The run cannot be read, or a chapter cannot be made of it; names the file or the plot.
    #[error(transparent)]
    Chapter(#[from] terrafill_results::ChapterError),
    /// A file of the report cannot be written.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// `result.json` cannot be encoded.
    #[error("result.json: {0}")]
    Result(serde_json::Error),
    /// The page could not be put together.
    #[error("report template: {0}")]
    Template(#[from] askama::Error),
}
