// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a history cannot be kept or read.

use std::path::{Path, PathBuf};
use terrafill_gate::GateError;
use terrafill_results::RunError;

/// Why a history cannot be kept or read. Whatever it is, what was stored before stays.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum HistoryError {
    /// There is no store where one is read.
    #[error("{path}: found no such file, expected a history; `terrafill history add` begins one")]
    NoStore {
        /// Where.
        path: PathBuf,
    },
    /// A file that is something else.
    #[error("{path}: found {found}, expected a history of terrafill; it was not touched")]
    NotAStore {
        /// Which file.
        path: PathBuf,
        /// What it is.
        found: String,
    },
    /// A store of another version of this program.
    #[error("{path}, schema: found {found}, allowed {allowed}; it was not touched")]
    Schema {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: i64,
        /// That of this program.
        allowed: i64,
    },
    /// A store that lost a part of itself.
    #[error("{path} is damaged: {message}; nothing was written, restore it from a copy")]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What SQLite found.
        message: String,
    },
    /// The store's disk has no room.
    #[error("{path}: no space left; nothing of this was stored, and what was there before is")]
    Full {
        /// Which file.
        path: PathBuf,
    },
    /// SQLite failed otherwise.
    #[error("{path}: {message}; nothing of this was stored")]
    Sql {
        /// Which file.
        path: PathBuf,
        /// What it said.
        message: String,
    },
    /// A run that cannot be placed in a history.
    #[error("{run}: {message}")]
    Run {
        /// Its folder, or its digest in a table.
        run: String,
        /// What was found, and what is allowed.
        message: String,
    },
    /// A table that was exported has a wrong row.
    #[error("{path}, row {row}: {message}; nothing was stored")]
    Row {
        /// Which file.
        path: PathBuf,
        /// From 1, the header counted.
        row: usize,
        /// Found and allowed.
        message: String,
    },
    /// A file or folder cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// What was named is not in the store, or not in the repository.
    #[error("{0}")]
    NotFound(String),
    /// A run folder.
    #[error(transparent)]
    Folder(#[from] RunError),
    /// Two runs cannot be compared.
    #[error(transparent)]
    Compare(#[from] GateError),
}

impl HistoryError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }

    pub(crate) fn sql(path: &Path) -> impl Fn(rusqlite::Error) -> Self {
        use rusqlite::ErrorCode as Code;
        let path = path.to_owned();
        move |error| {
            let (path, message) = (path.clone(), error.to_string());
            match error.sqlite_error_code() {
                Some(Code::DiskFull) => Self::Full { path },
                Some(Code::DatabaseCorrupt) => Self::Damaged { path, message },
                Some(Code::NotADatabase) => Self::NotAStore {
                    path,
                    found: "no SQLite file".to_owned(),
                },
                _ => Self::Sql { path, message },
            }
        }
    }
}
