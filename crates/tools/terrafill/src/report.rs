// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a verb says of the report that it wrote.

use crate::outcome::{Failure, Outcome, complain, print};
use std::path::Path;
use std::process::{Command, Stdio};
use terrafill_report::{ReportError, WrittenReport};

/// Prints `heading` and where the report is, names what is missing, and gives the run's verdict.
///
/// - `opens`: with the system's program for pages, too
pub(crate) fn print_report(
    report: Result<WrittenReport, ReportError>,
    heading: &str,
    opens: bool,
) -> Result<Outcome, Failure> {
    let report = report.map_err(Failure::bad_input)?;
    if !report.missing.is_empty() {
        complain(format!(
            "{} planned cases are missing:",
            report.missing.len()
        ));
        for case in &report.missing {
            complain(format!("  {case}"));
        }
    }
    print(format!("{heading}report: {}\n", report.path.display()))?;
    if opens {
        open(&report.path);
    }
    Ok(Outcome::from_code(report.verdict.exit_code()))
}

/// Starts the system's program for pages and waits for nothing: a report that is not shown is written all the same.
fn open(page: &Path) {
    let (program, words): (_, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(words).arg(page).stdin(Stdio::null());
    let started = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if let Err(error) = started {
        complain(format!("warning: --open: {program}: {error}"));
    }
}
