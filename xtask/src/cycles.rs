// SPDX-License-Identifier: MIT OR Apache-2.0
//! No two files of a crate import from each other, directly or by way of others.
//!
//! An edge goes from a file to the file that defines what a path names: through re-exports, so that
//! `crate::Name` leads to the module behind the root's `pub use`. Declaring and re-exporting a module
//! is no use of it. Tests do not count; methods have no path and are not seen.

use crate::source::{self, Crate, crates, tokens, without_comments, without_tests};
use anyhow::{Result, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Re-exports that lead to one another are followed no further than this; real chains have one or two.
const MAX_REEXPORTS: usize = 16;

/// Refuses crates in which files import from each other.
pub(crate) fn check(root: &Path) -> Result<String> {
    let crates = crates(root)?;
    let mut edges = 0;
    let mut found = Vec::new();
    for one in &crates {
        let imports = imports(one);
        edges += imports.values().map(BTreeSet::len).sum::<usize>();
        for cycle in cycles(&imports) {
            found.push(format!("{}:\n{}", one.name, describe(&cycle, &imports)));
        }
    }
    if edges == 0 {
        bail!("no file imports from another: the sources were not read");
    }
    if found.is_empty() {
        return Ok(format!(
            "{} crates, {edges} imports between their files, no cycle",
            crates.len()
        ));
    }
    bail!("{} import cycles:\n{}", found.len(), found.join("\n"));
}

/// Which modules each module imports from; the crate's root is the empty name.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// The imports inside a cycle, one a line.
fn describe(cycle: &BTreeSet<String>, imports: &Imports) -> String {
    let name = |module: &str| {
        if module.is_empty() {
            "the root"
        } else {
            module
        }
        .to_owned()
    };
    let line = |from: &String| {
        let to = imports.get(from).into_iter().flatten();
        let inside: Vec<String> = to
            .filter(|to| cycle.contains(*to))
            .map(|m| name(m))
            .collect();
        format!("  {} -> {}", name(from), inside.join(", "))
    };
    cycle.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Modules that reach each other, in sets of two and more.
fn cycles(imports: &Imports) -> Vec<BTreeSet<String>> {
    let reach: BTreeMap<&String, BTreeSet<&String>> = imports
        .keys()
        .map(|from| (from, reached_from(from, imports)))
        .collect();
    let mut sets: Vec<BTreeSet<String>> = Vec::new();
    for (from, to) in &reach {
        if !to.contains(*from) || sets.iter().any(|set| set.contains(*from)) {
            continue;
        }
        let back = |other: &&&String| reach.get(**other).is_some_and(|r| r.contains(*from));
        sets.push(to.iter().filter(back).map(|m| (*m).clone()).collect());
    }
    sets
}

fn reached_from<'a>(from: &'a String, imports: &'a Imports) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(next) = open.pop() {
        for to in imports.get(next).into_iter().flatten() {
            if reached.insert(to) {
                open.push(to);
            }
        }
    }
    reached
}

/// A path as it is written.
#[derive(Debug, Clone)]
struct WrittenPath {
    /// The module around it, modules inside the file included.
    scope: Vec<String>,
    segments: Vec<String>,
}

/// What one file says of paths.
#[derive(Default)]
struct Module {
    /// Names that a `use` brings in.
    names: BTreeMap<String, WrittenPath>,
    /// Paths that are uses: all but re-exports.
    uses: Vec<WrittenPath>,
}

/// The modules of a crate, by their paths.
struct Tree(BTreeMap<Vec<String>, Module>);

fn imports(one: &Crate) -> Imports {
    let modules = one.files.iter().map(|file| {
        let code = without_tests(&without_comments(&file.text));
        (file.module.clone(), module_of(&file.module, &tokens(&code)))
    });
    let tree = Tree(modules.collect());
    let mut imports = Imports::new();
    for (name, module) in &tree.0 {
        let to = module.uses.iter().filter_map(|path| tree.defining(path, 0));
        let others = to.filter(|to| to != name).map(|to| to.join("::"));
        imports.entry(name.join("::")).or_default().extend(others);
    }
    imports
}

/// Reads the paths of a file.
fn module_of(name: &[String], code: &[&str]) -> Module {
    let mut module = Module::default();
    // The file's module and those written inside it, with the depth of braces around each.
    let mut scope = name.to_vec();
    let mut inside = Vec::new();
    let mut depth = 0_usize;
    let mut at = 0;
    while at < code.len() {
        match code[at] {
            "mod" if code.get(at + 2) == Some(&"{") => {
                scope.push(code[at + 1].to_owned());
                inside.push(depth);
                at += 1;
            }
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                if inside.last() == Some(&depth) {
                    inside.pop();
                    scope.pop();
                }
            }
            "use" => {
                let end = code[at..].iter().position(|word| *word == ";");
                let end = end.map_or(code.len(), |length| at + length);
                let is_reexport = has_visibility(&code[..at]);
                for (segments, name) in use_paths(&code[at + 1..end], &[]) {
                    let scope = scope.clone();
                    let path = WrittenPath { scope, segments };
                    if !is_reexport {
                        module.uses.push(path.clone());
                    }
                    module.names.extend(name.map(|name| (name, path)));
                }
                at = end;
            }
            word if is_name(word) => {
                let is_next = |at: usize| {
                    code.get(at + 1) == Some(&"::") && code.get(at + 2).is_some_and(|w| is_name(w))
                };
                let mut segments = vec![word.to_owned()];
                while is_next(at) {
                    segments.push(code[at + 2].to_owned());
                    at += 2;
                }
                if segments.len() > 1 {
                    let scope = scope.clone();
                    module.uses.push(WrittenPath { scope, segments });
                }
            }
            _ => {}
        }
        at += 1;
    }
    module
}

fn is_name(word: &str) -> bool {
    word.starts_with(source::is_name)
}

/// Whether the words end with `pub` or `pub(…)`.
fn has_visibility(before: &[&str]) -> bool {
    match before {
        [.., "pub"] => true,
        [head @ .., ")"] => {
            let open = head.iter().rposition(|word| *word == "(");
            open.is_some_and(|open| head[..open].last() == Some(&"pub"))
        }
        _ => false,
    }
}

/// The paths between `use` and `;`, each with the name that it brings in; `None` for `*`.
fn use_paths(words: &[&str], before: &[String]) -> Vec<(Vec<String>, Option<String>)> {
    let mut depth = 0_usize;
    let items = words.split(|word| {
        match *word {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && *word == ","
    });
    let mut found = Vec::new();
    for item in items.filter(|item| !item.is_empty()) {
        let open = item.iter().position(|word| *word == "{");
        let head = &item[..open.unwrap_or(item.len())];
        let renamed = head.iter().position(|word| *word == "as");
        let (head, alias) = head.split_at(renamed.unwrap_or(head.len()));
        let mut path = before.to_vec();
        path.extend(
            head.iter()
                .filter(|word| is_name(word))
                .map(|word| (*word).to_owned()),
        );
        if let Some(open) = open {
            found.extend(use_paths(&item[open + 1..item.len() - 1], &path));
            continue;
        }
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let name = match (alias.get(1), head.last()) {
            (Some(alias), _) => Some((*alias).to_owned()),
            (None, Some(&"*")) => None,
            (None, _) => path.last().cloned(),
        };
        found.push((path, name));
    }
    found
}

impl Tree {
    /// The module whose file defines what a path names; `None` for another crate's names and for
    /// names of the file itself.
    fn defining(&self, path: &WrittenPath, reexports: usize) -> Option<Vec<String>> {
        let mut at = path.scope.clone();
        for (i, segment) in path.segments.iter().enumerate() {
            match segment.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => {
                    at.pop();
                }
                name => {
                    at.push(name.to_owned());
                    if self.0.contains_key(&at) {
                        continue;
                    }
                    at.pop();
                    let file = self.file_of(at);
                    let brought_in = self.0.get(&file).and_then(|module| module.names.get(name));
                    return match brought_in {
                        Some(next) if reexports < MAX_REEXPORTS => {
                            let mut next = next.clone();
                            next.segments.extend_from_slice(&path.segments[i + 1..]);
                            self.defining(&next, reexports + 1)
                        }
                        _ => (i > 0).then_some(file),
                    };
                }
            }
        }
        Some(self.file_of(at))
    }

    /// The module with a file that holds this one.
    fn file_of(&self, mut module: Vec<String>) -> Vec<String> {
        while !module.is_empty() && !self.0.contains_key(&module) {
            module.pop();
        }
        module
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceFile;

    fn of(files: &[(&str, &str)]) -> Imports {
        let file = |&(module, text): &(&str, &str)| SourceFile {
            module: module
                .split("::")
                .filter(|m| !m.is_empty())
                .map(str::to_owned)
                .collect(),
            text: text.to_owned(),
        };
        imports(&Crate {
            name: "one".to_owned(),
            files: files.iter().map(file).collect(),
        })
    }

    fn edges(files: &[(&str, &str)]) -> Vec<String> {
        let pairs = of(files).into_iter();
        pairs
            .flat_map(|(from, to)| to.into_iter().map(move |to| format!("{from} -> {to}")))
            .collect()
    }

    #[test]
    fn paths_lead_to_the_file_that_defines() {
        let files = [
            (
                "",
                "mod a; mod b; mod c; pub use a::{Alpha, deep::Below as Beyond}; pub(crate) use b::*; struct Own;",
            ),
            (
                "a",
                "pub mod deep; use std::fmt::{self, Debug}; fn f() { deep::g(); Debug::h(); fmt::i(); }",
            ),
            ("a::deep", "use crate::{Beyond, Own};"),
            (
                "b",
                "use crate::{Alpha as Other}; fn f() -> Other { mod inner { use super::super::c; } }",
            ),
            (
                "c",
                "// use crate::a::X;\nfn f() { crate::Alpha::new(\"crate::b::X\") }",
            ),
        ];
        let found = edges(&files);
        assert_eq!(
            found,
            ["a -> a::deep", "a::deep -> ", "b -> a", "b -> c", "c -> a"]
        );
    }

    #[test]
    fn cycles_are_found_through_reexports_parents_and_third_files() {
        let root = "mod a; mod b; mod c; pub use a::A; pub use b::B; pub use c::C;";
        let none = [
            ("", root),
            ("a", "use crate::B;"),
            ("b", "use crate::C;"),
            ("c", ""),
        ];
        assert!(cycles(&of(&none)).is_empty());
        let three = [
            ("", root),
            ("a", "use crate::B;"),
            ("b", "use crate::C;"),
            ("c", "use crate::A;"),
        ];
        let found = of(&three);
        let cycle = cycles(&found);
        assert_eq!(cycle.len(), 1);
        assert_eq!(describe(&cycle[0], &found), "  a -> b\n  b -> c\n  c -> a");
        let in_a_test = [
            three[0],
            three[1],
            three[2],
            ("c", "#[cfg(test)] mod tests { use crate::A; }"),
        ];
        assert!(cycles(&of(&in_a_test)).is_empty());
        let parent = [
            ("", "mod a;"),
            ("a", "mod b; fn f() { b::g() }"),
            ("a::b", "use super::f;"),
        ];
        assert_eq!(cycles(&of(&parent)).len(), 1);
        let two = [
            ("", "mod a; mod b; mod c; struct R; use c::S;"),
            ("a", "use crate::b;"),
            ("b", "use crate::a::A;"),
            ("c", "use crate::R;"),
        ];
        assert_eq!(cycles(&of(&two)).len(), 2);
    }

    #[test]
    fn a_repository_with_a_cycle_and_one_with_nothing_to_check_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let source = folder.path().join("crates/layer/one/src");
        std::fs::create_dir_all(&source).expect("writable");
        std::fs::create_dir_all(folder.path().join("xtask")).expect("writable");
        let write = |name: &str, text: &str| {
            std::fs::write(source.join(name), text).expect("writable");
        };
        write("../Cargo.toml", "");
        write("lib.rs", "mod a;\nmod b;\n");
        write("a.rs", "");
        write("b.rs", "");
        let nothing = check(folder.path()).expect_err("no imports");
        assert!(nothing.to_string().contains("were not read"), "{nothing}");
        write("a.rs", "use crate::b::B;");
        let summary = check(folder.path()).expect("no cycle");
        assert_eq!(summary, "1 crates, 1 imports between their files, no cycle");
        write("b.rs", "use crate::a::A;");
        let cycle = check(folder.path()).expect_err("a cycle");
        assert!(
            cycle
                .to_string()
                .contains("one/src/lib.rs:\n  a -> b\n  b -> a"),
            "{cycle}"
        );
    }
}
