// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that a run read, and what was remarkable about them.
//!
//! `inputs.csv` is no result and no part of the schema: a run of an earlier version, without it, is whole.

use crate::RunError;
use crate::side_table::SideTable;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Columns of `inputs.csv`.
pub const INPUT_COLUMNS: [&str; 4] = ["scene", "file", "sha256", "warning"];

const INPUTS: SideTable = SideTable {
    file: "inputs.csv",
    columns: &INPUT_COLUMNS,
    expected: "a scene, and a file with its SHA-256 or a warning",
};

/// A row of `inputs.csv`: a file with its hash, or a warning of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunInput {
    /// Which scene read it.
    pub scene: String,
    /// As the scene names it; empty for a warning of no file.
    pub file: String,
    /// SHA-256 of its bytes, lower-case hexadecimal; empty for a warning.
    pub sha256: String,
    /// What was read otherwise than the file says, or was left out; empty for a file.
    pub warning: String,
}

impl RunInput {
    fn is_usable(&self) -> bool {
        let is_digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
        let is_hash = self.sha256.len() == 64 && self.sha256.chars().all(is_digit);
        if self.warning.is_empty() {
            is_hash && !self.file.is_empty()
        } else {
            self.sha256.is_empty()
        }
    }
}

/// Appends rows to the table of the run in `folder`, which is begun where there is none.
///
/// # Errors
/// [`RunError::Io`].
pub fn append_inputs(folder: &Path, rows: &[RunInput]) -> Result<(), RunError> {
    INPUTS.append(folder, rows)
}

/// Rows of the table of the run in `folder`; none where it has none.
///
/// # Errors
/// [`RunError`], for a table that does not fit.
pub fn read_inputs(folder: &Path) -> Result<Vec<RunInput>, RunError> {
    INPUTS.read(folder, RunInput::is_usable)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_and_warnings_come_back_and_a_hash_must_be_one() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(read_inputs(folder.path()).expect("none"), []);
        let file = RunInput {
            scene: "hoods".to_owned(),
            file: "a, b.geojson".to_owned(),
            sha256: "0f".repeat(32),
            warning: String::new(),
        };
        let warning = RunInput {
            sha256: String::new(),
            warning: "1 ring was not closed".to_owned(),
            ..file.clone()
        };
        let rows = [file, warning];
        append_inputs(folder.path(), &rows).expect("written");
        assert_eq!(read_inputs(folder.path()).expect("readable"), rows);
        // Negative controls: no hash, a short one, one in capitals, a hash beside a warning.
        let hash = "0f".repeat(32);
        for row in [
            "s,f,,".to_owned(),
            "s,f,0f,".to_owned(),
            format!("s,f,{},", hash.to_uppercase()),
            format!("s,f,{hash},why"),
        ] {
            let text = format!("{}\n{row}\n", INPUT_COLUMNS.join(","));
            std::fs::write(folder.path().join(INPUTS.file), text).expect("written");
            let error = read_inputs(folder.path()).expect_err(&row).to_string();
            assert!(error.contains("row 2"), "{error}");
        }
    }
}
