// SPDX-License-Identifier: MIT OR Apache-2.0
//! The commands of README.md, run as they stand there.

use crate::harness::{Desk, has_device, ran};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// First cells of the table of commands.
fn commands(readme: &str) -> Vec<&str> {
    readme
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` |"))
        .map(|(command, _)| command)
        .filter(|command| command.starts_with("terrafill ") || command.contains(" > "))
        .collect()
}

/// A folder with what a clone has and the commands need.
fn clone() -> Desk {
    let desk = Desk::new();
    for entry in std::fs::read_dir(repository().join("bench-scenes")).expect("scenes") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        let content = std::fs::read(&path).expect("readable");
        desk.write(&format!("bench-scenes/{name}"), content);
    }
    desk
}

/// Runs a line in a shell that finds the program first in its path. Runs of the bench are cut to a
/// moment by a small picture, one frame, no numerical suite, and no ladder and matrix where the line
/// asks for none; all else is as written.
fn run_line(desk: &Desk, line: &str) -> Result<(), String> {
    let program = Path::new(env!("CARGO_BIN_EXE_terrafill"));
    let folder = program.parent().expect("a folder").display();
    let path = std::env::var("PATH").unwrap_or_default();
    let is_bench = line.starts_with("terrafill bench");
    let haste = match is_bench {
        true if line.contains("--matrix") => " --size 48 --frames 1 --no-precision",
        true => " --size 48 --frames 1 --ladder none --matrix none --no-precision",
        false => "",
    };
    let ran = ran(Command::new("sh")
        .args(["-c", &format!("{line}{haste}")])
        .current_dir(desk.path(""))
        .env("PATH", format!("{folder}:{path}"))
        .env_remove("TERRAFILL_DATA")
        .stdin(Stdio::null()));
    if ran.code == 0 {
        Ok(())
    } else {
        Err(format!("{line}: {}: {}", ran.code, ran.stderr))
    }
}

#[test]
fn every_command_of_the_readme_runs_as_written() {
    if !has_device() {
        return;
    }
    let readme = std::fs::read_to_string(repository().join("README.md")).expect("README.md");
    let commands = commands(&readme);
    for verb in [
        "scenes", "devices", "bench", "report", "render", "mesh", "locate",
    ] {
        let used = commands
            .iter()
            .any(|command| command.split(' ').nth(1) == Some(verb));
        assert!(used, "{verb}: {commands:?}");
    }
    let desk = clone();
    for command in commands {
        assert_eq!(run_line(&desk, command), Ok(()));
    }
    for output in [
        "out/quick/report.html",
        "out/full/report.html",
        "california.png",
    ] {
        assert!(desk.path(output).is_file(), "{output}");
    }
}

#[test]
fn a_command_that_does_not_run_is_noticed() {
    let table = "| `terrafill mesh none --json` | x |\n| `crates/` | y |\n";
    let commands = commands(table);
    assert_eq!(commands, ["terrafill mesh none --json"]);
    assert!(run_line(&clone(), commands[0]).is_err());
}
