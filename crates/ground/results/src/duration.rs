// SPDX-License-Identifier: MIT OR Apache-2.0
//! How long the groups of a run took: what shards of a later run are balanced by.
//!
//! `durations.csv` is no result and no part of the schema: a run without it is whole.

use crate::folder::{RunError, append_bytes, encode, read_table, write_whole};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Columns of `durations.csv`.
pub const DURATION_COLUMNS: [&str; 3] = ["first_case", "process", "seconds"];

const DURATIONS: &str = "durations.csv";

/// A row of `durations.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupDuration {
    /// Key of the group's first case.
    pub first_case: String,
    /// Which process measured it.
    pub process: u32,
    /// Wall time of opening, verifying and measuring it.
    pub seconds: f64,
}

/// Appends rows to the table of the run in `folder`, which is begun where there is none.
///
/// # Errors
/// [`RunError::Io`].
pub fn append_durations(folder: &Path, rows: &[GroupDuration]) -> Result<(), RunError> {
    let path = folder.join(DURATIONS);
    if !path.exists() {
        let header = encode(&path, |writer| writer.write_record(DURATION_COLUMNS))?;
        write_whole(&path, &header)?;
    }
    let text = encode(&path, |writer| {
        rows.iter().try_for_each(|row| writer.serialize(row))
    })?;
    append_bytes(&path, &text)
}

/// Rows of the table of the run in `folder`; none where it has none.
///
/// # Errors
/// [`RunError`], for a table that does not fit.
pub fn read_durations(folder: &Path) -> Result<Vec<GroupDuration>, RunError> {
    let path = folder.join(DURATIONS);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let columns: Vec<String> = DURATION_COLUMNS.iter().map(ToString::to_string).collect();
    let header: csv::StringRecord = columns.iter().collect();
    let rows = (2..).zip(read_table(&path, &columns)?);
    rows.map(|(row, record)| {
        let parsed: Result<GroupDuration, _> = record.deserialize(Some(&header));
        let usable = parsed
            .ok()
            .filter(|row| row.seconds.is_finite() && row.seconds >= 0.0);
        usable.ok_or_else(|| RunError::Cell {
            path: path.clone(),
            row,
            column: DURATION_COLUMNS.join(","),
            found: record.iter().collect::<Vec<_>>().join(","),
            expected: "a case, a process and its seconds".to_owned(),
        })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_and_wrong_ones_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(read_durations(folder.path()).expect("none"), []);
        let rows = [0, 1].map(|process| GroupDuration {
            first_case: "s/a, \"b\"".to_owned(),
            process,
            seconds: 1.25,
        });
        append_durations(folder.path(), &rows[..1]).expect("written");
        append_durations(folder.path(), &rows[1..]).expect("written");
        assert_eq!(read_durations(folder.path()).expect("readable"), rows);
        // Twins: a number that is none, and another header.
        let path = folder.path().join(DURATIONS);
        for (text, words) in [
            ("first_case,process,seconds\na,0,NaN\n", "row 2"),
            ("first_case,process,minutes\na,0,1\n", "minutes"),
        ] {
            std::fs::write(&path, text).expect("written");
            let error = read_durations(folder.path()).expect_err(words);
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
