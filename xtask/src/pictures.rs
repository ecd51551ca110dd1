// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether two run folders hold the same pictures, case by case, by the hashes in their tables.

use anyhow::{Context as _, Result, bail};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// What makes a case.
const CASE_COLUMNS: [&str; 4] = ["scene", "view", "backend", "variant"];
/// What must be equal: the marked pixels, the region ids, and whether the frame is right at all.
const PICTURE_COLUMNS: [&str; 3] = ["mask_hash", "ids_hash", "status"];
const STATUS: usize = 2;
/// Cases listed; more would hide the counts.
const MAX_LISTED: usize = 20;

/// Picture columns by case.
type Table = BTreeMap<String, [String; PICTURE_COLUMNS.len()]>;

/// Compares the tables `summary.csv` of two run folders.
///
/// # Errors
/// Any difference in a case of `base`, a case of it that `new` lacks, a table that cannot be read.
pub(crate) fn compare(base: &Path, new: &Path) -> Result<String> {
    compare_tables(&read(base)?, &read(new)?)
}

fn read(folder: &Path) -> Result<Table> {
    let path = folder.join("summary.csv");
    let mut reader = csv::Reader::from_path(&path).with_context(|| path.display().to_string())?;
    let headers = reader.headers()?.clone();
    let place = |name: &str| {
        let found = headers.iter().position(|header| header == name);
        found.with_context(|| format!("{}: no column {name}", path.display()))
    };
    let case: Vec<usize> = CASE_COLUMNS
        .iter()
        .map(|c| place(c))
        .collect::<Result<_>>()?;
    let picture: Vec<usize> = PICTURE_COLUMNS
        .iter()
        .map(|c| place(c))
        .collect::<Result<_>>()?;
    let mut table = Table::new();
    for record in reader.records() {
        let record = record.with_context(|| path.display().to_string())?;
        let cell = |column: usize| record.get(column).unwrap_or_default().to_owned();
        let name = case.iter().map(|&c| cell(c)).collect::<Vec<_>>().join(" ");
        let values = std::array::from_fn(|i| cell(picture[i]));
        if table.insert(name.clone(), values).is_some() {
            bail!("{}: two rows of the case {name}", path.display());
        }
    }
    if table.is_empty() {
        bail!("{}: no rows", path.display());
    }
    Ok(table)
}

fn compare_tables(base: &Table, new: &Table) -> Result<String> {
    let ok = |table: &Table| {
        table
            .values()
            .filter(|values| values[STATUS] == "ok")
            .count()
    };
    let both = base.keys().filter(|case| new.contains_key(*case)).count();
    let missing: Vec<&String> = base
        .keys()
        .filter(|case| !new.contains_key(*case))
        .collect();
    let added: Vec<&String> = new
        .keys()
        .filter(|case| !base.contains_key(*case))
        .collect();
    let mut different = Vec::new();
    for (case, before) in base {
        if let Some(after) = new.get(case).filter(|after| *after != before) {
            let columns = PICTURE_COLUMNS.iter().zip(before.iter().zip(after));
            let changes: Vec<String> = columns
                .filter(|(_, (before, after))| before != after)
                .map(|(column, (before, after))| format!("{column} {before:?} -> {after:?}"))
                .collect();
            different.push(format!("{case}: {}", changes.join(", ")));
        }
    }
    let mut text = format!(
        "{both} cases in both, {} different; status ok: {} in BASE, {} in NEW",
        different.len(),
        ok(base),
        ok(new)
    );
    list(&mut text, "different", &different);
    list(&mut text, "only in BASE", &missing);
    list(&mut text, "only in NEW", &added);
    if different.is_empty() && missing.is_empty() {
        return Ok(text);
    }
    bail!(text);
}

/// Adds the first lines of a list under its name and length.
fn list<T: std::fmt::Display>(text: &mut String, name: &str, lines: &[T]) {
    if lines.is_empty() {
        return;
    }
    // Writing to a string cannot fail.
    let _ = write!(text, "\n{name}: {}", lines.len());
    for line in lines.iter().take(MAX_LISTED) {
        let _ = write!(text, "\n  {line}");
    }
    if lines.len() > MAX_LISTED {
        let _ = write!(text, "\n  … and {} more", lines.len() - MAX_LISTED);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "scene,view,reason,backend,variant,status,ids_hash,mask_hash\n";
    const ROWS: [&str; 3] = [
        "island,globe,,vertex,\"doubled,colour=volume\",ok,i1,m1\n",
        "island,globe,,compute,,ok,i1,m1\n",
        "island,globe,no device,native,strips,skipped,,\n",
    ];

    fn folder(text: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("temporary folder");
        std::fs::write(folder.path().join("summary.csv"), text).expect("writable");
        folder
    }

    fn run(rows: &[&str]) -> tempfile::TempDir {
        folder(&format!("{HEADER}{}", rows.concat()))
    }

    #[test]
    fn equal_pictures_pass_in_any_order_of_rows() {
        let base = run(&ROWS);
        let summary = compare(base.path(), base.path()).expect("the same");
        assert_eq!(
            summary,
            "3 cases in both, 0 different; status ok: 2 in BASE, 2 in NEW"
        );
        let reordered = run(&[ROWS[2], ROWS[0], ROWS[1]]);
        compare(base.path(), reordered.path()).expect("the same");
    }

    #[test]
    fn a_changed_hash_or_status_fails_and_is_shown() {
        let base = run(&ROWS);
        for (old, new) in [(",m1", ",m2"), (",i1", ",i2"), ("skipped,,", "wrong,,")] {
            let changed = ROWS.concat().replacen(old, new, 1);
            let error = compare(base.path(), run(&[&changed]).path()).expect_err(new);
            let text = error.to_string();
            assert!(text.contains("3 cases in both, 1 different"), "{text}");
            assert!(text.contains("-> "), "{text}");
        }
    }

    #[test]
    fn a_missing_case_fails_and_an_added_one_does_not() {
        let (all, fewer) = (run(&ROWS), run(&ROWS[1..]));
        let added = compare(fewer.path(), all.path()).expect("only more");
        assert!(
            added.contains("only in NEW: 1\n  island globe vertex"),
            "{added}"
        );
        let missing = compare(all.path(), fewer.path()).expect_err("one is missing");
        let text = missing.to_string();
        assert!(
            text.contains("only in BASE: 1\n  island globe vertex"),
            "{text}"
        );
        assert!(text.contains("2 cases in both, 0 different"), "{text}");
    }

    #[test]
    fn what_is_not_a_table_of_pictures_is_an_error() {
        let base = run(&ROWS);
        let none = tempfile::tempdir().expect("temporary folder");
        let no_column = folder(&format!("{HEADER}{}", ROWS[0]).replace("ids_hash", "hash"));
        let torn = run(&[ROWS[0], "island,globe\n"]);
        for wrong in [none, no_column, run(&[]), run(&[ROWS[0], ROWS[0]]), torn] {
            assert!(compare(base.path(), wrong.path()).is_err());
            assert!(compare(wrong.path(), base.path()).is_err());
        }
    }

    #[test]
    fn long_lists_are_cut() {
        let row = |i: usize| format!("island,globe,,vertex,{i},ok,i,m\n");
        let rows: Vec<String> = (0..MAX_LISTED + 3).map(row).collect();
        let many = run(&[&rows.concat()]);
        let text = compare(many.path(), run(&ROWS).path())
            .expect_err("missing")
            .to_string();
        assert!(text.contains("… and 3 more"), "{text}");
    }
}
