// SPDX-License-Identifier: MIT OR Apache-2.0
//! Checks of the repository that need more than cargo, and shaders compiled beforehand.
//!
//! Every check prints what it looked at and how much of it there was, since a check that found
//! nothing to check has not passed.

mod cycles;
mod data_tests;
mod dependencies;
mod docs;
mod geometry;
mod keys;
mod lines;
mod manifests;
mod mutations;
mod pictures;
mod shaders;
mod source;
mod validation_log;

use anyhow::{Context as _, Result, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "\
usage: cargo xtask COMMAND

  check-deps                   no crate depends on one that is forbidden or that it does not use
  check-cycles                 no two files of a crate import from each other
  check-data-tests             tests that read data say so, and none passes because data is missing
  check-docs                   links of pages lead somewhere, and the code that guides quote is the code
  check-keys                   studies read conditions and metrics by constants, not by names in quotes
  check-lines                  no file outside tests has more lines than a newcomer reads at a sitting
  check-shaders                shaders on disk, embedded and documented are the same, and valid
  compile-shaders              write the SPIR-V of the geometry shaders anew
  check-validation-log FILE    the Vulkan layer was at work and reported nothing unexpected
  compare-pictures BASE NEW    two run folders hold the same masks and ids, case by case
  quote-docs                   write the code that guides quote anew
  gate-mutations [NAME...]     the gate names the counter that each mistake on a list moves
  lines [--root DIR]           lines of source outside tests, for each package";

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words[..] {
        ["check-deps"] => check_deps(),
        ["check-cycles"] => cycles::check(&root()),
        ["check-data-tests"] => data_tests::check(&root()),
        ["check-docs"] => docs::check(&root()),
        ["check-keys"] => keys::check(&root()),
        ["check-lines"] => lines::check(&root()),
        ["check-shaders"] => shaders::check(&root().join("shaders")),
        ["compile-shaders"] => geometry::compile(&root().join("shaders")),
        ["check-validation-log", file] => validation_log::check(Path::new(file)),
        ["compare-pictures", base, new] => pictures::compare(Path::new(base), Path::new(new)),
        ["quote-docs"] => docs::quote(&root()),
        ["gate-mutations", ref names @ ..] => mutations::check(&root(), names),
        ["lines"] => lines::count(&root()),
        ["lines", "--root", folder] => lines::count(Path::new(folder)),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(summary) => {
            println!("{summary}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn check_deps() -> Result<String> {
    let packages = dependencies::packages_of(&metadata()?)?;
    let edges = dependencies::check(&dependencies::edges(&packages))?;
    let imports = dependencies::check_reference(&root().join("crates/judges/reference/src"))?;
    let manifests = manifests::check(&root(), &packages)?;
    let config = source::read(&root().join(".config/nextest.toml"))?;
    let group = dependencies::check_test_group(&config, &packages)?;
    Ok(format!("{edges}; {imports}; {manifests}; {group}"))
}

/// The repository: xtask lies in a folder of it.
fn root() -> PathBuf {
    let xtask = Path::new(env!("CARGO_MANIFEST_DIR"));
    xtask.parent().unwrap_or(xtask).to_path_buf()
}

fn metadata() -> Result<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(root())
        .output()
        .context("cargo metadata does not start")?;
    if !output.status.success() {
        bail!(
            "cargo metadata: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    String::from_utf8(output.stdout).context("cargo metadata")
}
