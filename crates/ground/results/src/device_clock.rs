// SPDX-License-Identifier: MIT OR Apache-2.0
//! At which clocks a device ran when a process began and when it ended, where the system says so.

use crate::RunError;
use crate::side_table::SideTable;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Columns of `clocks.csv`.
pub const CLOCK_COLUMNS: [&str; 6] = ["process", "moment", "clock", "mhz", "max_mhz", "reason"];

const CLOCKS: SideTable = SideTable {
    file: "clocks.csv",
    columns: &CLOCK_COLUMNS,
    expected: "a process, start or end, a clock, and its MHz or why they are not known",
};

/// When a clock was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Moment {
    /// Before the process measured anything.
    Start,
    /// After it measured the last.
    End,
}

/// A row of `clocks.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceClock {
    /// Which process read it.
    pub process: u32,
    /// When.
    pub moment: Moment,
    /// Which clock, such as `graphics`; empty where none is known.
    pub clock: String,
    /// Its frequency; absent where the system does not say it.
    pub mhz: Option<f64>,
    /// The highest that it can have, where known.
    pub max_mhz: Option<f64>,
    /// Why the frequency is absent.
    pub reason: String,
}

impl DeviceClock {
    fn is_usable(&self) -> bool {
        let is_frequency = |mhz: f64| mhz.is_finite() && mhz >= 0.0;
        let said = [self.mhz, self.max_mhz];
        said.into_iter().flatten().all(is_frequency) && self.mhz.is_none() != self.reason.is_empty()
    }
}

/// Appends rows to the table of the run in `folder`, which is begun where there is none.
///
/// # Errors
/// [`RunError::Io`].
pub fn append_clocks(folder: &Path, rows: &[DeviceClock]) -> Result<(), RunError> {
    CLOCKS.append(folder, rows)
}

/// Rows of the table of the run in `folder`; none where it has none.
///
/// # Errors
/// [`RunError`], for a table that does not fit.
pub fn read_clocks(folder: &Path) -> Result<Vec<DeviceClock>, RunError> {
    CLOCKS.read(folder, DeviceClock::is_usable)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_come_back_and_an_absent_one_needs_its_reason() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(read_clocks(folder.path()).expect("none"), []);
        let known = DeviceClock {
            process: 0,
            moment: Moment::Start,
            clock: "graphics".to_owned(),
            mhz: Some(1_980.0),
            max_mhz: None,
            reason: String::new(),
        };
        let absent = DeviceClock {
            moment: Moment::End,
            mhz: None,
            reason: "no nvidia-smi, \"so\"".to_owned(),
            ..known.clone()
        };
        let rows = [known, absent];
        append_clocks(folder.path(), &rows[..1]).expect("written");
        append_clocks(folder.path(), &rows[1..]).expect("written");
        assert_eq!(read_clocks(folder.path()).expect("readable"), rows);
        // Negative controls: absent without a reason, a reason beside a value, no number, no moment.
        let path = folder.path().join(CLOCKS.file);
        for row in [
            "0,start,graphics,,,",
            "0,start,graphics,1,,why",
            "0,start,graphics,NaN,,",
            "0,later,graphics,1,,",
        ] {
            let text = format!("{}\n{row}\n", CLOCK_COLUMNS.join(","));
            std::fs::write(&path, text).expect("written");
            let error = read_clocks(folder.path()).expect_err(row).to_string();
            assert!(error.contains("row 2") && error.contains(row), "{error}");
        }
    }
}
