// SPDX-License-Identifier: MIT OR Apache-2.0
//! Records what the program is built from, since a run must name its own commit and not that of
//! whatever repository it is started in: `gate` compares two programs from one folder.

use std::path::Path;
use std::process::Command;

/// The workspace's folder, from this crate's.
const ROOT: &str = "../../..";

fn main() {
    let git = |arguments: &[&str]| {
        let git = Command::new("git")
            .current_dir(ROOT)
            .args(arguments)
            .output();
        let output = git.ok().filter(|output| output.status.success())?;
        Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
    };
    let head = git(&["rev-parse", "HEAD"]).unwrap_or_default();
    let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
    let is_dirty = changes.is_some_and(|changes| !changes.is_empty());
    let mark = if is_dirty { "+dirty" } else { "" };
    println!("cargo::rustc-env=TERRAFILL_COMMIT={head}{mark}");
    let features = std::env::vars_os().filter_map(|(name, _)| {
        let feature = name.to_str()?.strip_prefix("CARGO_FEATURE_")?;
        Some(feature.to_lowercase().replace('_', "-"))
    });
    let features = match features.collect::<Vec<_>>().join(" ") {
        none if none.is_empty() => "none".to_owned(),
        some => some,
    };
    println!("cargo::rustc-env=TERRAFILL_FEATURES={features}");
    let lock = std::fs::read_to_string(Path::new(ROOT).join("Cargo.lock")).unwrap_or_default();
    for package in ["wgpu", "ash"] {
        let version = locked_version(&lock, package);
        println!("cargo::rustc-env=TERRAFILL_{package}={version}");
    }
    // Commits, and changes that make a tree differ from its commit.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]).unwrap_or_default();
    let sources = [
        "crates",
        "shaders",
        "bench-scenes",
        "Cargo.toml",
        "Cargo.lock",
    ];
    for path in sources.iter().copied().chain([log.as_str()]) {
        let path = Path::new(ROOT).join(path);
        if path.exists() {
            println!("cargo::rerun-if-changed={}", path.display());
        }
    }
}

/// Version of a package in a lock file; empty where it has none.
fn locked_version<'a>(lock: &'a str, package: &str) -> &'a str {
    let name = format!("name = \"{package}\"");
    let mut lines = lock.lines().skip_while(|line| *line != name);
    let version = lines
        .nth(1)
        .and_then(|line| line.strip_prefix("version = "));
    version.map_or("", |version| version.trim_matches('"'))
}
