// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists the WGSL files below `shaders/`, so that a new one needs no line anywhere. Every folder but
//! `shared` (imported by others) and `texture` (parts that are put together) holds files with entry
//! points of their own.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// The folder of files that others import.
const SHARED: &str = "shared";
/// Folders whose files do not compile as they are.
const PARTS: [&str; 2] = [SHARED, "texture"];

fn main() -> io::Result<()> {
    let root =
        Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../../../shaders");
    println!("cargo::rerun-if-changed={}", root.display());
    let mut modules = Vec::new();
    for folder in fs::read_dir(&root)? {
        let folder = folder?.path();
        if folder.is_dir() && !PARTS.contains(&name_of(&folder).as_str()) {
            modules.extend(files(&folder)?);
        }
    }
    write_list("modules.rs", modules)?;
    write_list("shared.rs", files(&root.join(SHARED))?)
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// WGSL files of a folder: their paths relative to `shaders/`, and where they are.
fn files(folder: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut found = Vec::new();
    for file in fs::read_dir(folder)? {
        let file = file?.path();
        if file
            .extension()
            .is_some_and(|extension| extension == "wgsl")
        {
            let path = format!("{}/{}", name_of(folder), name_of(&file));
            found.push((path, file.canonicalize()?));
        }
    }
    Ok(found)
}

/// Writes a list of `ShaderSource` for `include!`.
fn write_list(name: &str, mut files: Vec<(String, PathBuf)>) -> io::Result<()> {
    // The order of a folder's entries is the file system's; the list's is the same everywhere.
    files.sort();
    let entries: Vec<String> = files
        .iter()
        .map(|(path, file)| {
            let file = file.display().to_string();
            format!("crate::wgsl::ShaderSource {{ path: {path:?}, text: include_str!({file:?}) }}")
        })
        .collect();
    let list = format!("&[{}]", entries.join(",\n"));
    let out = Path::new(&env::var("OUT_DIR").unwrap_or_default()).join(name);
    fs::write(out, list)
}
