// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a case holds on the device and what it leaves out, feature by feature, each with its reason.
//!
//! `features.csv` is no part of the schema: a run without it is whole, and says nothing of features.

use crate::folder::cell;
use crate::side_table::SideTable;
use crate::{CaseFeature, RunError, RunFolder};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Columns of `features.csv`.
const FEATURE_COLUMNS: [&str; 7] = [
    "case",
    "feature",
    "held",
    "bytes",
    "pipelines",
    "spared_bytes",
    "reason",
];

const FEATURES: SideTable = SideTable {
    file: "features.csv",
    columns: &FEATURE_COLUMNS,
    expected: "a case, a feature, whether it is held, its bytes and pipelines, the bytes that it would take, and why",
};

/// A row of `features.csv`.
#[derive(Debug, Serialize, Deserialize)]
struct FeatureRow {
    case: String,
    feature: String,
    held: bool,
    bytes: u64,
    pipelines: u64,
    spared_bytes: u64,
    reason: String,
}

impl RunFolder {
    /// Appends what a case holds and leaves out; the table is begun where there is none.
    ///
    /// - `case`: its key
    ///
    /// # Errors
    /// [`RunError::Io`].
    pub fn append_features(&self, case: &str, features: &[CaseFeature]) -> Result<(), RunError> {
        append(self.path(), case, features)
    }
}

fn append(folder: &Path, case: &str, features: &[CaseFeature]) -> Result<(), RunError> {
    if features.is_empty() {
        return Ok(());
    }
    let rows = features.iter().map(|of| FeatureRow {
        case: case.to_owned(),
        feature: of.feature.clone(),
        held: of.is_held,
        bytes: of.bytes,
        pipelines: of.pipelines,
        spared_bytes: of.spared_bytes,
        reason: of.reason.clone(),
    });
    FEATURES.append(folder, &rows.collect::<Vec<_>>())
}

/// What each case says, in the order of the table; nothing where the run in `folder` has none. A case that was
/// verified again, since its run was killed, says what it said last.
///
/// - `planned`: keys of its cases
///
/// # Errors
/// [`RunError`], for a table that does not fit and for a case that was not planned.
pub(crate) fn read_features(
    folder: &Path,
    planned: &BTreeSet<String>,
) -> Result<BTreeMap<String, Vec<CaseFeature>>, RunError> {
    let mut all: BTreeMap<String, Vec<CaseFeature>> = BTreeMap::new();
    let is_usable = |row: &FeatureRow| !row.feature.is_empty() && !row.reason.is_empty();
    for (number, row) in (2..).zip(FEATURES.read(folder, is_usable)?) {
        let path = folder.join(FEATURES.file);
        if !planned.contains(&row.case) {
            return Err(cell(
                &path,
                number,
                "case",
                &row.case,
                "a case of plan.json",
            ));
        }
        let of_case = all.entry(row.case).or_default();
        of_case.retain(|of| of.feature != row.feature);
        of_case.push(CaseFeature {
            feature: row.feature,
            is_held: row.held,
            bytes: row.bytes,
            pipelines: row.pipelines,
            spared_bytes: row.spared_bytes,
            reason: row.reason,
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_come_back_in_order_and_what_does_not_fit_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let planned: BTreeSet<String> = ["s/a", "s/b"].map(str::to_owned).into();
        let read = || read_features(folder.path(), &planned);
        assert_eq!(read().expect("none"), BTreeMap::new());
        let walls = CaseFeature {
            feature: "walls".to_owned(),
            is_held: true,
            bytes: 96,
            pipelines: 2,
            spared_bytes: 0,
            reason: "of \"all\" 4, and more".to_owned(),
        };
        let order = CaseFeature {
            feature: "order".to_owned(),
            is_held: false,
            bytes: 0,
            pipelines: 0,
            spared_bytes: 64,
            ..walls.clone()
        };
        let both = [walls.clone(), order];
        append(folder.path(), "s/b", &both).expect("written");
        append(folder.path(), "s/a", &both[..1]).expect("written");
        append(folder.path(), "s/a", &both[..1]).expect("written");
        let all = [
            ("s/a".to_owned(), vec![walls]),
            ("s/b".to_owned(), both.to_vec()),
        ];
        assert_eq!(read().expect("readable"), BTreeMap::from(all.clone()));
        // A killed process leaves half a row, which the next row does not go on with.
        let path = folder.path().join(FEATURES.file);
        let mut torn = std::fs::read_to_string(&path).expect("readable");
        torn += "s/a,wal";
        std::fs::write(&path, torn).expect("written");
        append(folder.path(), "s/a", &both[..1]).expect("written");
        assert_eq!(read().expect("readable"), BTreeMap::from(all));
        // Negative controls: a case of no plan, no number, neither held nor left out, no reason.
        for (rows, found) in [
            ("s/c,walls,true,1,0,0,x\n", "s/c"),
            ("s/a,walls,true,-1,0,0,x\n", "row 2"),
            ("s/a,walls,held,1,0,0,x\n", "row 2"),
            ("s/a,walls,true,1,0,0,\n", "row 2"),
        ] {
            let text = format!("{}\n{rows}", FEATURE_COLUMNS.join(","));
            std::fs::write(&path, text).expect("written");
            let error = read().expect_err(rows).to_string();
            assert!(error.contains(found), "{error}");
        }
    }
}
