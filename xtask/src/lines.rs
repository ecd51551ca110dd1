// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much source each package ships: lines outside tests, benches and examples.

use crate::source::{crates, fill_tests, without_comments};
use anyhow::Result;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Stands for every character of a test.
const IN_TEST: char = '\u{1}';

/// Lines of source outside tests.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Lines {
    /// With code, a comment behind it or not.
    code: usize,
    /// With a comment and nothing else.
    comments: usize,
    blank: usize,
}

impl std::ops::AddAssign for Lines {
    fn add_assign(&mut self, other: Self) {
        self.code += other.code;
        self.comments += other.comments;
        self.blank += other.blank;
    }
}

/// A table of the packages below `root`, and their sum.
pub(crate) fn count(root: &Path) -> Result<String> {
    let mut packages: BTreeMap<String, Lines> = BTreeMap::new();
    let mut sum = Lines::default();
    for one in crates(root)? {
        let folder = one.name.rsplitn(3, '/').nth(2).unwrap_or(&one.name);
        let lines = packages.entry(folder.to_owned()).or_default();
        for file in &one.files {
            let found = lines_of(&file.text);
            *lines += found;
            sum += found;
        }
    }
    let mut text = "    code  comments     blank  package".to_owned();
    let total = ("total".to_owned(), sum);
    for (name, lines) in packages.into_iter().chain([total]) {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n{:8}  {:8}  {:8}  {name}",
            lines.code, lines.comments, lines.blank
        );
    }
    Ok(text)
}

fn lines_of(text: &str) -> Lines {
    let code = fill_tests(&without_comments(text), IN_TEST);
    let mut lines = Lines::default();
    for (line, code) in text.lines().zip(code.lines()) {
        if code.contains(IN_TEST) {
            continue;
        }
        if !code.trim().is_empty() {
            lines.code += 1;
        } else if line.trim().is_empty() {
            lines.blank += 1;
        } else {
            lines.comments += 1;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "//! Head.\n\nuse a; // b\n/// Doc.\nfn f() {\n    \"x\n// in a string\n\";\n}\n\
                        #[cfg(test)]\nmod tests {\n    // Why.\n    fn g() {}\n}\n";

    #[test]
    fn code_comments_and_blank_lines_are_counted_apart_and_tests_not_at_all() {
        let mut expected = Lines {
            code: 6,
            comments: 2,
            blank: 1,
        };
        assert_eq!(lines_of(TEXT), expected);
        // Without the attribute they are no tests.
        expected.code += 3;
        expected.comments += 1;
        assert_eq!(lines_of(&TEXT.replace("#[cfg(test)]\n", "")), expected);
    }

    #[test]
    fn packages_are_counted_with_their_library_and_program_and_an_empty_folder_fails() {
        let folder = tempfile::tempdir().expect("temporary folder");
        assert!(count(folder.path()).is_err());
        let source = folder.path().join("crates/layer/one/src");
        std::fs::create_dir_all(&source).expect("writable");
        std::fs::create_dir_all(folder.path().join("xtask")).expect("writable");
        std::fs::write(source.join("../Cargo.toml"), "").expect("writable");
        for root in ["lib.rs", "main.rs"] {
            std::fs::write(source.join(root), TEXT).expect("writable");
        }
        let table = count(folder.path()).expect("readable");
        let rows: Vec<Vec<&str>> = table
            .lines()
            .map(|l| l.split_whitespace().collect())
            .collect();
        assert_eq!(rows[1], ["12", "4", "2", "crates/layer/one"], "{table}");
        assert_eq!(rows[2], ["12", "4", "2", "total"], "{table}");
    }
}
