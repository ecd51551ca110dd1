// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists the WGSL modules below `shaders/`, so that a new one needs no line anywhere. Every folder but
//! `shared` (imported by others) and `texture` (parts that are put together) holds files with entry
//! points of their own.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Folders whose files do not compile as they are.
const PARTS: [&str; 2] = ["shared", "texture"];

fn main() -> io::Result<()> {
    let root =
        Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../../../shaders");
    println!("cargo::rerun-if-changed={}", root.display());
    let mut modules: Vec<(String, PathBuf)> = Vec::new();
    for folder in fs::read_dir(&root)? {
        let folder = folder?.path();
        let name = folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if !folder.is_dir() || PARTS.contains(&name.as_str()) {
            continue;
        }
        println!("cargo::rerun-if-changed={}", folder.display());
        for file in fs::read_dir(&folder)? {
            let file = file?.path();
            if file
                .extension()
                .is_some_and(|extension| extension == "wgsl")
            {
                let leaf = file
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned();
                modules.push((format!("{name}/{leaf}"), file.canonicalize()?));
            }
        }
    }
    // The order of a folder's entries is the file system's; the list's is the same everywhere.
    modules.sort();
    let entries: Vec<String> = modules
        .iter()
        .map(|(path, file)| {
            let file = file.display().to_string();
            format!("crate::wgsl::ShaderSource {{ path: {path:?}, text: include_str!({file:?}) }}")
        })
        .collect();
    let list = format!("&[{}]", entries.join(",\n"));
    let out = Path::new(&env::var("OUT_DIR").unwrap_or_default()).join("modules.rs");
    fs::write(out, list)
}
