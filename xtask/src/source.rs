// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rust source as checks read it: without comments, without what strings hold, without tests.
//!
//! A scanner of characters, not a parser: it knows comments, literals and brackets, which is what it
//! takes to find paths and to count lines. Every result has the line breaks of its source.

use anyhow::{Context as _, Result, bail};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Stands for what a string or character literal holds, so that its lines still count as code.
const IN_LITERAL: char = '"';

/// One source file of a crate, under the path of its module.
pub(crate) struct SourceFile {
    /// `["triangulate", "delaunay"]`; empty for the crate's root.
    pub(crate) module: Vec<String>,
    /// As it lies on disk.
    pub(crate) text: String,
}

/// One root of a package (its library or its program) with the files below it, tests left out.
pub(crate) struct Crate {
    /// Folder relative to the repository, then the root's file: `xtask/src/main.rs`.
    pub(crate) name: String,
    /// The root first.
    pub(crate) files: Vec<SourceFile>,
}

/// Every package of the repository: folders in `crates/*/*`, and `xtask`.
pub(crate) fn packages(root: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![root.join("crates"), root.join("xtask")];
    while let Some(folder) = folders.pop() {
        if folder.join("Cargo.toml").is_file() {
            // A package below another one (a fuzz target) is not of the workspace.
            found.push(folder);
            continue;
        }
        for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            }
        }
    }
    if found.is_empty() {
        bail!("{}: no package found", root.display());
    }
    found.sort();
    Ok(found)
}

/// Every file below `folder` with one of these endings; some folders are not looked into.
pub(crate) fn files_below(
    folder: &Path,
    endings: &[&str],
    is_left_out: fn(&Path) -> bool,
) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).with_context(|| next.display().to_string())? {
            let path = entry?.path();
            let ending = path.extension().and_then(OsStr::to_str);
            if path.is_dir() {
                folders.extend((!is_left_out(&path)).then_some(path));
            } else if ending.is_some_and(|ending| endings.contains(&ending)) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Every Rust file below `folder`, build outputs and packages within it left out.
pub(crate) fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_other = |path: &Path| path.join("Cargo.toml").is_file() || path.ends_with("target");
    files_below(folder, &["rs"], is_other)
}

/// The path of a file below `root` from there, with `/`.
pub(crate) fn relative(root: &Path, path: &Path) -> String {
    let path = path.strip_prefix(root).unwrap_or(path);
    path.to_string_lossy().replace('\\', "/")
}

/// What a file holds; an error names it.
pub(crate) fn read(file: &Path) -> Result<String> {
    std::fs::read_to_string(file).with_context(|| file.display().to_string())
}

/// The crates of the repository.
pub(crate) fn crates(root: &Path) -> Result<Vec<Crate>> {
    let mut all = Vec::new();
    for package in packages(root)? {
        for name in ["lib.rs", "main.rs"] {
            let file = package.join("src").join(name);
            if !file.is_file() {
                continue;
            }
            let mut files = Vec::new();
            read_module(&file, Vec::new(), &package.join("src"), &mut files)?;
            let name = relative(root, &file);
            all.push(Crate { name, files });
        }
    }
    if all.is_empty() {
        bail!("{}: no package has sources", root.display());
    }
    Ok(all)
}

/// Reads a module's file and those of the modules that it declares.
///
/// - `folder`: where the files of its children are
fn read_module(
    file: &Path,
    module: Vec<String>,
    folder: &Path,
    files: &mut Vec<SourceFile>,
) -> Result<()> {
    let text = read(file)?;
    let children = declared_modules(&without_tests(&without_comments(&text)));
    files.push(SourceFile {
        module: module.clone(),
        text,
    });
    for child in children {
        let mut path = module.clone();
        path.push(child.clone());
        let beside = folder.join(format!("{child}.rs"));
        let below = folder.join(&child);
        let file = if beside.is_file() {
            beside
        } else {
            below.join("mod.rs")
        };
        read_module(&file, path, &below, files)?;
    }
    Ok(())
}

/// Names in `mod name;`.
fn declared_modules(code: &str) -> Vec<String> {
    let words = tokens(code);
    words
        .windows(3)
        .filter(|w| w[0] == "mod" && w[2] == ";")
        .map(|w| w[1].to_owned())
        .collect()
}

/// Words, `::`, and every other mark by itself.
pub(crate) fn tokens(code: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if is_name(first) {
            rest.find(|c| !is_name(c)).unwrap_or(rest.len())
        } else if rest.starts_with("::") {
            2
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(length);
        found.push(token);
        rest = after.trim_start();
    }
    found
}

/// The source with comments blank and literals filled with one mark.
pub(crate) fn without_comments(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    while at < chars.len() {
        let (length, is_literal) = comment_or_literal(&chars, at);
        if length == 0 {
            code.push(chars[at]);
            at += 1;
            continue;
        }
        let end = (at + length).min(chars.len());
        let mark = if is_literal { IN_LITERAL } else { ' ' };
        code.extend(
            chars[at..end]
                .iter()
                .map(|&c| if c == '\n' { c } else { mark }),
        );
        at = end;
    }
    code
}

/// Length of the comment or literal that begins at `at`, 0 if none does, and whether it is a literal.
fn comment_or_literal(chars: &[char], at: usize) -> (usize, bool) {
    let rest = &chars[at..];
    let next = rest.get(1).copied();
    match rest[0] {
        '/' if next == Some('/') => {
            let end = rest.iter().position(|&c| c == '\n');
            (end.unwrap_or(rest.len()), false)
        }
        '/' if next == Some('*') => (block_comment(rest), false),
        '"' => (quoted(rest, '"'), true),
        'r' if !at
            .checked_sub(1)
            .is_some_and(|b| is_name(chars[b]) && chars[b] != 'b') =>
        {
            (raw_string(rest), true)
        }
        // A lifetime has no quote behind its first letter.
        '\'' if next == Some('\\') || rest.get(2) == Some(&'\'') => (quoted(rest, '\''), true),
        _ => (0, false),
    }
}

/// Whether a name may hold it.
pub(crate) fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Block comments nest.
fn block_comment(rest: &[char]) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at + 1 < rest.len() {
        match [rest[at], rest[at + 1]] {
            ['/', '*'] => depth += 1,
            ['*', '/'] => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    rest.len()
}

/// Length of the literal that begins here, its quotes included.
pub(crate) fn quoted(rest: &[char], quote: char) -> usize {
    let mut at = 1;
    while at < rest.len() {
        match rest[at] {
            '\\' => at += 2,
            c if c == quote => return at + 1,
            _ => at += 1,
        }
    }
    rest.len()
}

/// `r"…"`, `r#"…"#`; 0 for a name that begins with r.
fn raw_string(rest: &[char]) -> usize {
    let hashes = rest[1..].iter().take_while(|&&c| c == '#').count();
    if rest.get(1 + hashes) != Some(&'"') {
        return 0;
    }
    let is_end = |at: &usize| {
        rest[*at] == '"' && rest[at + 1..].iter().take_while(|&&c| c == '#').count() >= hashes
    };
    let end = (2 + hashes..rest.len()).find(is_end);
    end.map_or(rest.len(), |at| at + 1 + hashes)
}

/// Code without comments, with every item under `#[cfg(test)]` blank.
pub(crate) fn without_tests(code: &str) -> String {
    fill_tests(code, ' ')
}

/// Code without comments, with every item under `#[cfg(test)]` filled with one mark.
pub(crate) fn fill_tests(code: &str, mark: char) -> String {
    const ATTRIBUTE: &str = "#[cfg(test)]";
    let mut kept = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(start) = rest.find(ATTRIBUTE) {
        let (before, from) = rest.split_at(start);
        let (item, after) = from.split_at(item_length(from));
        kept.push_str(before);
        kept.extend(item.chars().map(|c| if c == '\n' { c } else { mark }));
        rest = after;
    }
    kept.push_str(rest);
    kept
}

/// Bytes of the item at the start, its attributes included: to its `;`, or to the bracket that
/// closes its braces where no `;` follows.
fn item_length(code: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in code.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 && c == '}' && !code[at + 1..].trim_start().starts_with(';') {
                    return at + 1;
                }
            }
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_are_no_code() {
        let text = "a // crate::b\n/* crate::c /* d */ e */ f('\\'', \"crate::g // \\\" h\", \
                    r#\"crate::\"i\"#, 'j', b\"k\") <'l> // m";
        let code = without_comments(text);
        assert_eq!(code.lines().count(), text.lines().count());
        assert!(!code.contains("crate"), "{code}");
        let words = tokens(&code);
        let names: Vec<&&str> = words.iter().filter(|w| w.starts_with(is_name)).collect();
        assert_eq!(names, [&"a", &"f", &"b", &"l"], "{code}");
        // Names that begin with r, and raw names.
        assert_eq!(without_comments("return r#type + r"), "return r#type + r");
    }

    #[test]
    fn items_of_tests_are_left_out_and_nothing_else_is() {
        let code = "use a;\n#[cfg(test)]\n#[path = \"x\"]\nmod b;\nfn c() {}\n#[cfg(test)]\nmod d {\n\
                    fn e() { f; }\n}\nfn g() {}\n#[cfg(test)]\nuse h::{i, j};\nk();\n";
        let kept = without_tests(code);
        assert_eq!(kept.lines().count(), code.lines().count());
        let words = tokens(&kept).concat();
        assert_eq!(words, "usea;fnc(){}fng(){}k();");
    }

    #[test]
    fn modules_are_read_from_the_files_that_declare_them() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let root = folder.path();
        assert!(crates(root).is_err(), "there is nothing to read");
        let source = root.join("crates/layer/one/src");
        std::fs::create_dir_all(source.join("a")).expect("writable");
        std::fs::create_dir_all(root.join("xtask")).expect("writable");
        assert!(crates(root).is_err(), "there is no package");
        let write = |name: &str, text: &str| {
            std::fs::write(source.join(name), text).expect("writable");
        };
        write("../Cargo.toml", "");
        assert!(crates(root).is_err(), "the package has no source");
        write("lib.rs", "mod a;\n#[cfg(test)]\nmod t;\n// mod c;\n");
        assert!(crates(root).is_err(), "a file is missing");
        write("a.rs", "pub(crate) mod b;");
        write("a/b.rs", "");
        let all = crates(root).expect("readable");
        assert_eq!(all[0].name, "crates/layer/one/src/lib.rs");
        let modules: Vec<String> = all[0].files.iter().map(|f| f.module.join("::")).collect();
        assert_eq!(modules, ["", "a", "a::b"]);
    }
}
