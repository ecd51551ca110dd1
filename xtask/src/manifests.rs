// SPDX-License-Identifier: MIT OR Apache-2.0
//! Dependencies that a manifest names and no code uses, and lists of dependencies out of order.
//!
//! A name counts as used where it is a word of the code. Comments are no code, so that a dependency is not
//! kept for a link in the documentation.

use crate::dependencies::Package;
use crate::source::{crates, packages, read, sources, tokens, without_comments, without_tests};
use anyhow::{Context as _, Result, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The words of a package's code.
#[derive(Default)]
struct Words {
    /// Of its library and its program, tests left out.
    shipped: BTreeSet<String>,
    /// Of its build script.
    build: BTreeSet<String>,
    /// Of everything: tests, benches and examples too.
    all: BTreeSet<String>,
}

/// Holds every manifest of the workspace against the code beside it.
pub(crate) fn check(root: &Path, listed: &[Package]) -> Result<String> {
    let words = words_by_folder(root)?;
    let mut wrong = Vec::new();
    let mut count = 0;
    for package in listed {
        let manifest = Path::new(&package.manifest_path);
        let folder = manifest.parent().unwrap_or(manifest);
        let folder = folder.strip_prefix(root).unwrap_or(folder);
        let words = words.get(&*folder.to_string_lossy());
        let words = words.with_context(|| format!("{}: no sources", folder.display()))?;
        count += package.dependencies.len();
        wrong.extend(unused(package, words));
        wrong.extend(unsorted(manifest)?);
    }
    let workspace = root.join("Cargo.toml");
    wrong.extend(unsorted(&workspace)?);
    wrong.extend(unnamed(&read(&workspace)?, listed));
    if !wrong.is_empty() {
        bail!("dependencies in manifests:\n  {}", wrong.join("\n  "));
    }
    if count == 0 {
        bail!("no dependencies found: the manifests were not read");
    }
    Ok(format!(
        "{count} dependencies in manifests, all used and sorted"
    ))
}

fn words_by_folder(root: &Path) -> Result<BTreeMap<String, Words>> {
    let words =
        |code: &str| -> BTreeSet<String> { tokens(code).into_iter().map(str::to_owned).collect() };
    let mut found: BTreeMap<String, Words> = BTreeMap::new();
    for one in crates(root)? {
        let folder = one.name.rsplitn(3, '/').nth(2).unwrap_or(&one.name);
        let shipped = &mut found.entry(folder.to_owned()).or_default().shipped;
        for file in &one.files {
            shipped.extend(words(&without_tests(&without_comments(&file.text))));
        }
    }
    for package in packages(root)? {
        let folder = package.strip_prefix(root).unwrap_or(&package);
        let own = found
            .entry(folder.to_string_lossy().into_owned())
            .or_default();
        for file in sources(&package)? {
            let words = words(&without_comments(&read(&file)?));
            if file == package.join("build.rs") {
                own.build.extend(words.iter().cloned());
            }
            own.all.extend(words);
        }
    }
    Ok(found)
}

/// What a package names and does not use where it says so.
fn unused(package: &Package, words: &Words) -> Vec<String> {
    let dependencies = package.dependencies.iter();
    let found = dependencies.filter_map(|dependency| {
        let name = dependency.rename.as_ref().unwrap_or(&dependency.name);
        let word = name.replace('-', "_");
        let kind = dependency.kind.as_deref();
        let users = match kind {
            Some("dev") => &words.all,
            Some("build") => &words.build,
            _ => &words.shipped,
        };
        let why = if users.contains(&word) {
            return None;
        } else if kind.is_none() && words.all.contains(&word) {
            "used by tests only, so a dev-dependency"
        } else {
            "unused"
        };
        Some(format!("{} -> {name}: {why}", package.name))
    });
    found.collect()
}

/// Names in a manifest's lists of dependencies. A blank line ends a list.
fn lists(manifest: &str) -> Vec<Vec<&str>> {
    let mut found = Vec::new();
    let mut is_list = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            is_list = line.ends_with("dependencies]");
        }
        if line.starts_with('[') || line.is_empty() {
            found.push(Vec::new());
        } else if is_list && !line.starts_with('#') {
            let name = line.split(['.', ' ', '=']).next().unwrap_or(line);
            found.last_mut().unwrap_or(&mut Vec::new()).push(name);
        }
    }
    found
}

fn unsorted(manifest: &Path) -> Result<Vec<String>> {
    let text = read(manifest)?;
    let lists = lists(&text);
    let pairs = lists.iter().flat_map(|list| list.windows(2));
    let wrong = pairs.filter(|pair| pair[0] > pair[1]);
    let place = manifest.display();
    Ok(wrong
        .map(|pair| format!("{place}: {} stands before {}", pair[0], pair[1]))
        .collect())
}

/// Dependencies of the workspace that no package names.
fn unnamed(workspace: &str, listed: &[Package]) -> Vec<String> {
    let dependencies = listed.iter().flat_map(|package| &package.dependencies);
    let named: BTreeSet<&str> = dependencies.map(|one| one.name.as_str()).collect();
    let all = lists(workspace).concat().into_iter();
    all.filter(|name| !named.contains(name))
        .map(|name| format!("workspace -> {name}: no package names it"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dependencies::packages_of;

    const MANIFEST: &str = "[dependencies]\na-b = \"1\"\nlog.workspace = true\n\n[dev-dependencies]\n\
                            # Why.\ntempfile.workspace = true\n";
    const SOURCE: &str =
        "use a_b::c;\nfn f() { log::info!(\"x\"); }\n#[cfg(test)]\nmod tests { use tempfile; }\n";

    /// What is wrong with a workspace of one package.
    fn judged(manifest: &str, source: &str, workspace: &str) -> Result<String> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let root = folder.path();
        let package = root.join("crates/layer/one");
        std::fs::create_dir_all(package.join("src")).expect("writable");
        std::fs::create_dir_all(root.join("xtask")).expect("writable");
        std::fs::write(root.join("Cargo.toml"), workspace).expect("writable");
        std::fs::write(package.join("Cargo.toml"), manifest).expect("writable");
        std::fs::write(package.join("src/lib.rs"), source).expect("writable");
        let metadata = serde_json::json!({"packages": [{
            "name": "one",
            "manifest_path": package.join("Cargo.toml"),
            "dependencies": [
                {"name": "a-b", "kind": null},
                {"name": "log", "kind": null},
                {"name": "tempfile", "kind": "dev"},
            ],
        }]});
        check(root, &packages_of(&metadata.to_string()).expect("valid"))
    }

    const WORKSPACE: &str =
        "[workspace.dependencies]\na-b = \"=1\"\nlog = \"=1\"\n\ntempfile = \"=1\"\n";

    #[test]
    fn what_is_used_and_sorted_passes() {
        let summary = judged(MANIFEST, SOURCE, WORKSPACE).expect("in order");
        assert!(summary.starts_with("3 dependencies"), "{summary}");
    }

    #[test]
    fn what_is_unused_used_by_tests_alone_or_out_of_order_is_named() {
        let refused = |manifest: &str, source: &str, workspace: &str| {
            let error = judged(manifest, source, workspace).expect_err("refused");
            error.to_string()
        };
        for (from, to, says) in [
            ("log::info!(\"x\");", "", "one -> log: unused"),
            ("use a_b::c;", "// a_b::c", "one -> a-b: unused"),
            ("use a_b::c;", "/// [`a_b::c`]", "one -> a-b: unused"),
            ("use tempfile;", "use a;", "one -> tempfile: unused"),
            (
                "fn f()",
                "#[cfg(test)]\nfn f()",
                "one -> log: used by tests only",
            ),
        ] {
            let text = refused(MANIFEST, &SOURCE.replace(from, to), WORKSPACE);
            assert!(text.contains(says), "{text}");
            assert_eq!(text.lines().count(), 2, "{text}");
        }
        let swapped = MANIFEST.replace("a-b", "m-b");
        let text = refused(&swapped, SOURCE, WORKSPACE);
        assert!(text.ends_with("m-b stands before log"), "{text}");
        let more = format!("{WORKSPACE}zip = \"=9\"\n");
        let text = refused(MANIFEST, SOURCE, &more);
        assert!(text.contains("workspace -> zip: no package"), "{text}");
    }

    #[test]
    fn a_workspace_that_was_not_read_fails() {
        let folder = tempfile::tempdir().expect("temporary folder");
        assert!(check(folder.path(), &[]).is_err());
    }
}
