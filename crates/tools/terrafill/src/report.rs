// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a verb says of the report that it wrote.

use crate::outcome::{Failure, Outcome, complain, print};
use terrafill_report::{ReportError, WrittenReport};

/// Prints `heading` and where the report is, names what is missing, and gives the run's verdict.
pub(crate) fn print_report(
    report: Result<WrittenReport, ReportError>,
    heading: &str,
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
    Ok(Outcome::from_code(report.verdict.exit_code()))
}
