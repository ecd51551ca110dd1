// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shaders on disk, shaders built into the program and shaders in the README's table: one set, and
//! valid.
//!
//! A file that lies in `shaders/` and is not embedded is never validated, so the three lists are
//! held against each other before naga runs.

use crate::source::{files_below, read, relative};
use anyhow::{Result, bail};
use std::collections::BTreeSet;
use std::path::Path;

/// Endings of shader sources.
const SOURCES: [&str; 9] = [
    "wgsl", "glsl", "geom", "tesc", "tese", "task", "mesh", "vert", "frag",
];

/// Checks the folder `shaders/`.
pub(crate) fn check(folder: &Path) -> Result<String> {
    let readme = read(&folder.join("README.md"))?;
    let embedded: BTreeSet<String> = terrafill_shaders::embedded_paths()
        .chain(terrafill_shaders::glsl_paths())
        .map(str::to_owned)
        .collect();
    same_set(&embedded, "embedded", &on_disk(folder)?, "on disk")?;
    same_set(
        &embedded,
        "embedded",
        &documented(&readme),
        "in shaders/README.md",
    )?;
    let valid = terrafill_shaders::check_all()?;
    let wgsl = terrafill_shaders::embedded_paths().count();
    if valid == 0 || embedded.is_empty() {
        bail!("{}: no shader was found, expected some", folder.display());
    }
    let geometry = crate::geometry::check(folder)?;
    Ok(format!(
        "{valid} shaders valid, {} imported by them; {geometry}",
        wgsl - valid
    ))
}

/// Paths of the shader sources below `folder`, relative to it, with `/`.
fn on_disk(folder: &Path) -> Result<BTreeSet<String>> {
    let found = files_below(folder, &SOURCES, |_| false)?;
    Ok(found.iter().map(|path| relative(folder, path)).collect())
}

/// First cells of the README's table that name a source.
fn documented(readme: &str) -> BTreeSet<String> {
    readme
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next())
        .filter(|cell| {
            let extension = cell.rsplit_once('.').map(|(_, extension)| extension);
            extension.is_some_and(|extension| SOURCES.contains(&extension))
        })
        .map(str::to_owned)
        .collect()
}

fn same_set(a: &BTreeSet<String>, a_is: &str, b: &BTreeSet<String>, b_is: &str) -> Result<()> {
    let list = |from: &BTreeSet<String>, without: &BTreeSet<String>| {
        from.difference(without)
            .cloned()
            .collect::<Vec<_>>()
            .join(", ")
    };
    if a != b {
        bail!(
            "shaders {a_is} but not {b_is}: [{}]; {b_is} but not {a_is}: [{}]",
            list(a, b),
            list(b, a)
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn sources_are_found_in_folders_and_other_files_are_not() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let sub = folder.path().join("vertex");
        std::fs::create_dir(&sub).expect("writable");
        std::fs::write(sub.join("a.wgsl"), "").expect("writable");
        std::fs::write(folder.path().join("README.md"), "").expect("writable");
        assert_eq!(
            on_disk(folder.path()).expect("readable"),
            set(&["vertex/a.wgsl"])
        );
    }

    #[test]
    fn the_table_names_sources_in_its_first_cell() {
        let readme = "| file | stage |\n|---|---|\n| a/b.wgsl | vertex |\n| c.glsl | – |\nd.wgsl\n";
        assert_eq!(documented(readme), set(&["a/b.wgsl", "c.glsl"]));
    }

    #[test]
    fn a_file_that_is_in_one_list_only_is_named() {
        let (both, one) = (set(&["a.wgsl", "b.wgsl"]), set(&["a.wgsl"]));
        same_set(&both, "x", &both, "y").expect("equal");
        for (first, second) in [(&both, &one), (&one, &both)] {
            let error = same_set(first, "x", second, "y").expect_err("unequal");
            assert!(error.to_string().contains("[b.wgsl]"), "{error}");
        }
    }
}
