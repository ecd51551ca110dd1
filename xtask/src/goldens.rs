// SPDX-License-Identifier: MIT OR Apache-2.0
//! Goldens: text files that hold what the code gave when someone last looked at it.
//!
//! A missing, changed or unused golden fails. Only `bless` writes, one golden at a time, so that
//! each change is somebody's decision and shows in the review.

use anyhow::{Context as _, Result, bail};
use std::path::Path;

/// Compares every golden with what the code gives now.
pub(crate) fn check(folder: &Path, now: &[(&'static str, String)]) -> Result<String> {
    let mut wrong = Vec::new();
    for (name, text) in now {
        match std::fs::read_to_string(folder.join(name)) {
            Ok(golden) if golden == *text => {}
            Ok(golden) => wrong.push(format!("{name}: {}", first_difference(&golden, text))),
            Err(error) => wrong.push(format!("{name}: {error}")),
        }
    }
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let file = entry?.file_name().to_string_lossy().into_owned();
        if !now.iter().any(|(name, _)| *name == file) {
            wrong.push(format!("{file}: no check uses it"));
        }
    }
    if wrong.is_empty() {
        return Ok(format!("{} goldens, all as the code gives them", now.len()));
    }
    bail!(
        "goldens:\n  {}\nlook at the change; if it is meant: cargo xtask bless NAME",
        wrong.join("\n  ")
    );
}

/// Writes one golden anew.
pub(crate) fn bless(folder: &Path, now: &[(&'static str, String)], name: &str) -> Result<String> {
    let Some((name, text)) = now.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = now.iter().map(|(name, _)| *name).collect();
        bail!(
            "no golden is called {name:?}, allowed: {}",
            names.join(", ")
        );
    };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let path = folder.join(name);
    std::fs::write(&path, text).with_context(|| path.display().to_string())?;
    Ok(format!("wrote {}", path.display()))
}

fn first_difference(golden: &str, now: &str) -> String {
    let (mut old, mut new) = (golden.lines(), now.lines());
    let mut line = 1;
    loop {
        match (old.next(), new.next()) {
            (a, b) if a.is_some() && a == b => line += 1,
            (a, b) => return format!("line {line}: golden {a:?}, now {b:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn now(text: &str) -> Vec<(&'static str, String)> {
        vec![("a.txt", text.to_owned())]
    }

    #[test]
    fn only_a_blessed_golden_passes() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let missing = check(folder.path(), &now("x\ny\n"));
        assert!(missing.is_err(), "a missing golden passed");
        bless(folder.path(), &now("x\ny\n"), "a.txt").expect("writable");
        check(folder.path(), &now("x\ny\n")).expect("as blessed");
        let changed = check(folder.path(), &now("x\nz\n")).expect_err("changed");
        let text = changed.to_string();
        assert!(
            text.contains("line 2: golden Some(\"y\"), now Some(\"z\")"),
            "{text}"
        );
        let shorter = check(folder.path(), &now("x\n")).expect_err("shorter");
        assert!(shorter.to_string().contains("now None"), "{shorter}");
    }

    #[test]
    fn an_unused_golden_and_an_unknown_name_fail() {
        let folder = tempfile::tempdir().expect("temporary folder");
        bless(folder.path(), &now("x"), "a.txt").expect("writable");
        assert!(bless(folder.path(), &now("x"), "b.txt").is_err());
        std::fs::write(folder.path().join("b.txt"), "").expect("writable");
        let unused = check(folder.path(), &now("x")).expect_err("unused");
        assert!(
            unused.to_string().contains("b.txt: no check uses it"),
            "{unused}"
        );
    }
}
