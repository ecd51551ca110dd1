// SPDX-License-Identifier: MIT OR Apache-2.0
//! How long the groups of a run took: what shards of a later run are balanced by.
//!
//! `durations.csv` is no result and no part of the schema: a run without it is whole.

use crate::RunError;
use crate::side_table::SideTable;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Columns of `durations.csv`.
pub const DURATION_COLUMNS: [&str; 3] = ["first_case", "process", "seconds"];

const DURATIONS: SideTable = SideTable {
    file: "durations.csv",
    columns: &DURATION_COLUMNS,
    expected: "a case, a process and its seconds",
};

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
    DURATIONS.append(folder, rows)
}

/// Rows of the table of the run in `folder`; none where it has none.
///
/// # Errors
/// [`RunError`], for a table that does not fit.
pub fn read_durations(folder: &Path) -> Result<Vec<GroupDuration>, RunError> {
    let is_usable = |row: &GroupDuration| row.seconds.is_finite() && row.seconds >= 0.0;
    DURATIONS.read(folder, is_usable)
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
        // Negative controls: a number that is none, and another header.
        let path = folder.path().join(DURATIONS.file);
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
