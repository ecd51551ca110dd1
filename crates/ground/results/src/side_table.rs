// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tables beside a run's results: no part of the schema, and a run without them is whole.

use crate::folder::{RunError, append_bytes, cut_torn_row, encode, read_table, write_whole};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// One of them.
pub(crate) struct SideTable {
    pub(crate) file: &'static str,
    pub(crate) columns: &'static [&'static str],
    /// What a row holds, for whoever wrote another one.
    pub(crate) expected: &'static str,
}

impl SideTable {
    /// Appends rows to the table of the run in `folder`, which is begun where there is none.
    pub(crate) fn append(&self, folder: &Path, rows: &[impl Serialize]) -> Result<(), RunError> {
        let path = folder.join(self.file);
        if !path.exists() {
            let header = encode(&path, |writer| writer.write_record(self.columns))?;
            write_whole(&path, &header)?;
        }
        cut_torn_row(&path)?;
        let text = encode(&path, |writer| {
            rows.iter().try_for_each(|row| writer.serialize(row))
        })?;
        append_bytes(&path, &text)
    }

    /// Rows of the table of the run in `folder`; none where it has none.
    ///
    /// - `is_usable`: whether the values of a row may be as they are
    pub(crate) fn read<Row: DeserializeOwned>(
        &self,
        folder: &Path,
        is_usable: impl Fn(&Row) -> bool,
    ) -> Result<Vec<Row>, RunError> {
        let path = folder.join(self.file);
        if !path.exists() {
            return Ok(Vec::new());
        }
        let columns: Vec<String> = self.columns.iter().map(ToString::to_string).collect();
        let header: csv::StringRecord = columns.iter().collect();
        let rows = (2..).zip(read_table(&path, &columns)?);
        rows.map(|(row, record)| {
            let parsed: Result<Row, _> = record.deserialize(Some(&header));
            let usable = parsed.ok().filter(|row| is_usable(row));
            usable.ok_or_else(|| RunError::Cell {
                path: path.clone(),
                row,
                column: self.columns.join(","),
                found: record.iter().collect::<Vec<_>>().join(","),
                expected: self.expected.to_owned(),
            })
        })
        .collect()
    }
}
