// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can go wrong between a run's folder and its report.

use std::path::PathBuf;
use terrafill_results::legacy::RunError;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The run cannot be read; names the file, and the row where one is to blame.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The report cannot be written.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A plot could not be drawn.
    #[error("plot {plot:?}: {message}")]
    Plot {
        /// Which plot.
        plot: String,
        /// Why.
        message: String,
    },
    /// The page could not be put together.
    #[error("report template: {0}")]
    Template(#[from] askama::Error),
}

/// Why the report of a run of cases and measurements cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
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
