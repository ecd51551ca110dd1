// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reviewed CSV files of the gate, limits and blessings: one header, and a reason in every row.

use crate::GateError;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads every row of `text`.
///
/// - `path`: what messages call it
/// - `columns`: the header, in order
/// - `check`: what is wrong with a row, if anything is
///
/// # Errors
/// [`GateError::Row`], by the line of the file, for another header, a value of another type, and what
/// `check` objects to.
pub(crate) fn parse<T: DeserializeOwned>(
    path: &Path,
    text: &str,
    columns: &[&str],
    check: impl Fn(&T) -> Result<(), String>,
) -> Result<Vec<T>, GateError> {
    let wrong = |row: usize, message: String| GateError::Row {
        path: path.to_owned(),
        row,
        message,
    };
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| wrong(1, e.to_string()))?;
    if !header.iter().eq(columns.iter().copied()) {
        let found: Vec<&str> = header.iter().collect();
        let (found, expected) = (found.join(","), columns.join(","));
        return Err(wrong(1, format!("found {found:?}, expected {expected:?}")));
    }
    let mut rows = Vec::new();
    for (line, row) in (2..).zip(reader.deserialize()) {
        let row: T = row.map_err(|error| wrong(line, error.to_string()))?;
        check(&row).map_err(|message| wrong(line, message))?;
        rows.push(row);
    }
    Ok(rows)
}

/// Refuses a row without a reason.
pub(crate) fn check_reason(reason: &str) -> Result<(), String> {
    if reason.trim().is_empty() {
        return Err("found no reason, needs one".to_owned());
    }
    Ok(())
}
