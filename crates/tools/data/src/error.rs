// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a data set did not get into the data folder.

use crate::topojson::TopologyError;
use std::io;
use std::path::PathBuf;

/// Why a data set could not be got. Whatever it is, no file with other bytes has the set's name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DataError {
    /// The program that fetches is not there.
    #[error(
        "curl cannot be started ({source}), and fetches all data; install it, or put {url} into {} \
         ({bytes} bytes, sha256 {sha256})", path.display()
    )]
    NoCurl {
        /// The system's words.
        source: io::Error,
        /// What was to be fetched.
        url: String,
        /// Where it belongs.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// Its hash.
        sha256: String,
    },
    /// The transfer failed or ended early.
    #[error("{url}: cannot be fetched: {why}{}", kept(part, *found, *expected))]
    Transfer {
        /// What was to be fetched.
        url: String,
        /// Words of `curl`.
        why: String,
        /// The file of the transfer.
        part: PathBuf,
        /// Bytes that are there.
        found: u64,
        /// Bytes that should be.
        expected: u64,
    },
    /// The published file has more, fewer or other bytes than it had.
    #[error("{url}: found {found}, expected {expected}; nothing was kept")]
    Altered {
        /// What was fetched.
        url: String,
        /// What came: `more than 10 bytes`, or a hash.
        found: String,
        /// What should have come.
        expected: String,
    },
    /// A file with other bytes has the name.
    #[error(
        "{}: is there with sha256 {found}, expected sha256 {expected}; move it away first",
        path.display()
    )]
    Occupied {
        /// The file.
        path: PathBuf,
        /// Its hash.
        found: String,
        /// The hash of what belongs there.
        expected: String,
    },
    /// Another process fetches the same set.
    #[error("{}: another process is fetching it", path.display())]
    Busy {
        /// The file of the transfer.
        path: PathBuf,
    },
    /// What is there cannot be read.
    #[error("{}: cannot be read: {why}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's words.
        why: String,
    },
    /// The disk has less room than the set takes.
    #[error(
        "{}: found {found} bytes free on its disk, needs {needed} bytes; nothing was fetched",
        folder.display()
    )]
    NoRoom {
        /// The data folder.
        folder: PathBuf,
        /// Bytes that are free.
        found: u64,
        /// Bytes to be written.
        needed: u64,
    },
    /// The disk is full, or the folder may not be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// The published file cannot be converted.
    #[error("{}: cannot be converted by {by}: {source}", path.display())]
    Conversion {
        /// The published file.
        path: PathBuf,
        /// Name of the conversion.
        by: String,
        /// What is wrong.
        source: TopologyError,
    },
    /// A conversion gave other bytes than it gave when the catalogue was written.
    #[error("{}: made with sha256 {found}, expected sha256 {expected}; it was not written", path.display())]
    MadeOtherwise {
        /// The file that was to be made.
        path: PathBuf,
        /// Hash of what was made.
        found: String,
        /// Hash of what should have been made.
        expected: String,
    },
}

/// What a later try goes on from.
fn kept(part: &std::path::Path, found: u64, expected: u64) -> String {
    match found {
        0 => String::new(),
        _ => format!(
            "; {} holds {found} of {expected} bytes, and the next try goes on from there",
            part.display()
        ),
    }
}
