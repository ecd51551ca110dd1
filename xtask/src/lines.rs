// SPDX-License-Identifier: MIT OR Apache-2.0
//! How much source each package ships: lines outside tests, benches and examples.

use crate::source::{crates, fill_tests, without_comments};
use anyhow::{Result, bail};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Stands for every character of a test.
const IN_TEST: char = '\u{1}';

/// Lines of a file at most, tests that stand in it counted.
const MAX_LINES: usize = 700;
/// Names that a crate of the contract exports at most: who implements it meets them all.
const MAX_NAMES: usize = 60;
/// Folder of these crates.
const CONTRACT: &str = "crates/contract/";

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

/// No file outside tests is longer than [`MAX_LINES`], and no crate of the contract exports more than [`MAX_NAMES`].
pub(crate) fn check(root: &Path) -> Result<String> {
    let (mut files, mut longest, mut most, mut too_long) = (0, 0, 0, Vec::new());
    for one in crates(root)? {
        if one.name.starts_with(CONTRACT) {
            let names = one.files.first().map_or(0, |root| exported(&root.text));
            most = most.max(names);
            if names > MAX_NAMES {
                too_long.push(format!(
                    "{}: {names} exported names, allowed {MAX_NAMES}",
                    one.name
                ));
            }
        }
        for file in &one.files {
            let lines = file.text.lines().count();
            files += 1;
            longest = longest.max(lines);
            if lines > MAX_LINES {
                let module = file.module.join("::");
                too_long.push(format!(
                    "{}, module {module:?}: {lines} lines, allowed {MAX_LINES}; tests may stand in a file of their own",
                    one.name
                ));
            }
        }
    }
    if !too_long.is_empty() {
        bail!(too_long.join("\n"));
    }
    Ok(format!(
        "{files} files outside tests, the longest has {longest} lines of at most {MAX_LINES}; a crate of the contract exports {most} names of at most {MAX_NAMES}"
    ))
}

/// Names that the root of a crate exports: those that it re-exports, and its own items.
fn exported(root: &str) -> usize {
    let code = without_comments(root);
    let uses = code.split("pub use ").skip(1);
    let names = uses.map(|rest| {
        let tree = rest.split(';').next().unwrap_or_default();
        let names = tree.split(['{', '}', ',']).map(str::trim);
        names
            .filter(|name| !name.is_empty() && !name.ends_with("::"))
            .count()
    });
    let is_item = |line: &&str| line.starts_with("pub ") && !line.starts_with("pub use ");
    names.sum::<usize>() + code.lines().filter(is_item).count()
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
    fn exported_names_are_counted_and_too_many_refused() {
        let root =
            "pub use a::{B, c::{D, E},\n F}; // G\npub use h::I;\nuse j::K;\npub fn l() {}\n";
        assert_eq!(exported(root), 6);
        let folder = tempfile::tempdir().expect("temporary folder");
        let source = folder.path().join(CONTRACT).join("one/src");
        std::fs::create_dir_all(&source).expect("writable");
        std::fs::create_dir_all(folder.path().join("xtask")).expect("writable");
        std::fs::write(source.join("../Cargo.toml"), "").expect("writable");
        let mut text = "pub const A: u8 = 0;\n".repeat(MAX_NAMES);
        std::fs::write(source.join("lib.rs"), &text).expect("writable");
        assert!(check(folder.path()).is_ok());
        text += "pub const A: u8 = 0;\n";
        std::fs::write(source.join("lib.rs"), &text).expect("writable");
        let refused = check(folder.path()).expect_err("one too many").to_string();
        assert!(
            refused.contains("61 exported names, allowed 60"),
            "{refused}"
        );
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

    #[test]
    fn a_file_may_have_so_many_lines_and_no_more() {
        let root = tempfile::tempdir().expect("a folder");
        let package = root.path().join("xtask");
        std::fs::create_dir_all(package.join("src")).expect("a folder");
        std::fs::create_dir_all(root.path().join("crates")).expect("a folder");
        std::fs::write(package.join("Cargo.toml"), "").expect("written");
        let with = |lines: usize| {
            std::fs::write(package.join("src/lib.rs"), "\n".repeat(lines)).expect("written");
            check(root.path())
        };
        let said = with(MAX_LINES).expect("short enough");
        assert!(said.starts_with("1 files outside tests"), "{said}");
        let refused = with(MAX_LINES + 1).expect_err("too long").to_string();
        assert!(
            refused.contains("xtask/src/lib.rs, module \"\": 701 lines"),
            "{refused}"
        );
    }
}
