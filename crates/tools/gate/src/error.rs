// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why the gate cannot come to a verdict.

use std::path::PathBuf;
use terrafill_results::RunError;

/// Why the gate cannot come to a verdict. None of it is ever a pass.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GateError {
    /// What was given cannot be compared.
    #[error("{0}")]
    BadInput(String),
    /// A table that people write has a wrong row.
    #[error("{path}, row {row}: {message}")]
    Row {
        /// Which file.
        path: PathBuf,
        /// From 1, the header counted.
        row: usize,
        /// Found and allowed.
        message: String,
    },
    /// A file or a folder cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A run folder.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A program that was started did not end well.
    #[error("{what}: {message}")]
    Program {
        /// Which program, doing what.
        what: String,
        /// Its status and what it said last.
        message: String,
    },
    /// A program found no device.
    #[error("no usable device: {0}")]
    NoDevice(String),
    /// Nothing was there to be compared.
    #[error("nothing measured: {0}")]
    NothingMeasured(String),
}

impl GateError {
    /// The exit code of a command that ends with it.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NothingMeasured(_) => 4,
            Self::NoDevice(_) => 5,
            _ => 2,
        }
    }

    pub(crate) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, source }
    }
}
