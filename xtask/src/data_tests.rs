// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests that read data which does not ship say so, and no test passes because data is missing.
//!
//! `terrafill_fixtures::data` is the only way for a test to reach the data folder, and it panics where
//! something is missing. So a test that reads data fails on a clone alone unless it is ignored. Refused here is what would get
//! round that: an attribute `ignore` for another reason, and a test that looks for data by itself. Refused too is a file of
//! tests that its crate's `tests/all.rs` does not name: nothing would compile it.

use crate::source::{files_below, read, relative};
use anyhow::{Result, bail};
use std::collections::BTreeMap;
use std::path::Path;

/// How a test says that it reads data; the names of the sets follow.
const NEEDS: &str = "#[ignore = \"needs data: ";

/// What looks for the data folder, or for files beside the repository.
const LOOKS_FOR_DATA: &[&str] = &[
    "data_dir_from_env",
    "var_os(\"TERRAFILL_DATA\")",
    "var(\"TERRAFILL_DATA\")",
    "DATA_DIR_VARIABLE",
    "DataMissing",
    "../shared",
];

/// Files and folders that may: what reads scenes, and programs that people run. Not their tests.
const MAY_LOOK: &[&str] = &[
    "crates/contract/scene/src/",
    "crates/ground/fixtures/src/data.rs",
    // Messages and codes of missing data are what these tests are about.
    "crates/contract/scene/tests/scene_file.rs",
    "crates/contract/scene/tests/shipped.rs",
    "crates/ground/core/benches/",
    // A run skips scenes whose data is missing, and says so.
    "crates/studies/filling/src/scenes.rs",
    "crates/studies/filling/src/suite/plan.rs",
    "crates/studies/moving/src/study.rs",
    "crates/tools/terrafill/src/",
    "xtask/src/data_tests.rs",
];

/// Counts tests by what they need; refuses tests that are ignored for other reasons or look for data.
pub(crate) fn check(root: &Path) -> Result<String> {
    let mut files = BTreeMap::new();
    for folder in ["crates", "xtask"] {
        let is_build = |path: &Path| path.ends_with("target");
        for path in files_below(&root.join(folder), &["rs"], is_build)? {
            files.insert(relative(root, &path), read(&path)?);
        }
    }
    judge(&files)
}

/// - `files`: texts by path
fn judge(files: &BTreeMap<String, String>) -> Result<String> {
    let mut tests: BTreeMap<&str, usize> = BTreeMap::new();
    let mut marked = 0;
    let mut wrong = Vec::new();
    for (path, text) in files {
        let may_look =
            MAY_LOOK.iter().any(|place| path.starts_with(place)) || path.contains("/examples/");
        for (number, line) in text.lines().enumerate() {
            let place = format!("{path}:{}", number + 1);
            let code = line.trim_start();
            if let Some(sets) = sets(code) {
                marked += 1;
                for set in sets {
                    *tests.entry(set).or_default() += 1;
                }
            } else if code.starts_with("#[ignore") {
                wrong.push(format!("{place}: {code}: allowed: {NEEDS}SET, …\"]"));
            }
            let looked = LOOKS_FOR_DATA.iter().find(|what| line.contains(**what));
            if let Some(what) = looked.filter(|_| !may_look && !code.starts_with("//")) {
                wrong.push(format!(
                    "{place}: {what}: a test reaches data by terrafill_fixtures::data only"
                ));
            }
        }
    }
    wrong.extend(files.keys().filter_map(|path| unnamed(files, path)));
    if !wrong.is_empty() {
        bail!("{} places:\n{}", wrong.len(), wrong.join("\n"));
    }
    if marked == 0 {
        bail!("no test needs data: the sources were not read");
    }
    let sets: Vec<String> = tests
        .iter()
        .map(|(set, count)| format!("{set} ({count})"))
        .collect();
    Ok(format!("{marked} tests need data: {}", sets.join(", ")))
}

/// That a file of tests is not named by the `all.rs` beside it, where there is one.
fn unnamed(files: &BTreeMap<String, String>, path: &str) -> Option<String> {
    let (folder, name) = path.rsplit_once('/')?;
    let all = files.get(&format!("{folder}/all.rs"))?;
    let line = format!("mod {};", name.strip_suffix(".rs")?);
    let is_named = name == "all.rs" || all.lines().any(|own| own == line);
    (!is_named && folder.ends_with("/tests"))
        .then(|| format!("{path}: {folder}/all.rs has no line \"{line}\""))
}

/// The sets that a test is marked with; `None` where the line is no such mark, or names none.
fn sets(line: &str) -> Option<impl Iterator<Item = &str>> {
    let names = line.strip_prefix(NEEDS)?.strip_suffix("\"]")?;
    (!names.trim().is_empty()).then(|| names.split(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(path: &str, text: &str) -> Result<String> {
        judge(&BTreeMap::from([
            (
                "crates/a/tests/good.rs".to_owned(),
                format!("{NEEDS}us-10m, etopo20\"]\n"),
            ),
            (path.to_owned(), text.to_owned()),
        ]))
    }

    #[test]
    fn tests_are_counted_by_what_they_need() {
        let summary = judged("crates/a/src/lib.rs", "fn main() {}").expect("nothing wrong");
        assert_eq!(summary, "1 tests need data: etopo20 (1), us-10m (1)");
    }

    #[test]
    fn a_test_ignored_for_another_reason_or_for_none_is_refused() {
        for mark in [
            "#[ignore]",
            "#[ignore = \"slow\"]",
            "#[ignore = \"needs data: \"]",
        ] {
            let refused = judged("crates/a/tests/b.rs", mark)
                .expect_err(mark)
                .to_string();
            assert!(refused.contains("crates/a/tests/b.rs:1"), "{refused}");
        }
    }

    #[test]
    fn a_file_of_tests_that_nothing_compiles_is_refused() {
        let files = |name: &str| {
            BTreeMap::from([
                (
                    "crates/a/tests/all.rs".to_owned(),
                    format!("{NEEDS}us-10m\"]\nmod b;\n"),
                ),
                (format!("crates/a/tests/{name}.rs"), String::new()),
            ])
        };
        judge(&files("b")).expect("named");
        let refused = judge(&files("c")).expect_err("not named").to_string();
        let words = "crates/a/tests/c.rs: crates/a/tests/all.rs has no line \"mod c;\"";
        assert!(refused.contains(words), "{refused}");
    }

    #[test]
    fn a_test_that_looks_for_data_by_itself_is_refused() {
        for line in [
            "let Some(data) = data_dir_from_env() else { return };",
            "let folder = std::env::var_os(\"TERRAFILL_DATA\")?;",
            "Err(SceneError::DataMissing { .. }) => continue,",
            "const PAPER: &str = \"/../../../../shared/papers/a.txt\";",
        ] {
            let refused = judged("crates/a/tests/b.rs", line)
                .expect_err(line)
                .to_string();
            assert!(
                refused.contains("terrafill_fixtures::data only"),
                "{refused}"
            );
            judged("crates/a/examples/b.rs", line).expect("an example may");
        }
    }

    #[test]
    fn a_scan_that_finds_no_test_is_refused() {
        let none = BTreeMap::from([("crates/a/src/lib.rs".to_owned(), String::new())]);
        judge(&none).expect_err("nothing was read");
    }
}
