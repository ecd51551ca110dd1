// SPDX-License-Identifier: MIT OR Apache-2.0
//! The files that a gate leaves.

use crate::replace::replace;
use crate::{GateError, GateReport, junit, markdown};
use std::path::Path;

/// Writes `gate.md`, `gate.junit.xml` and, last, `gate.json`: a folder with it is whole.
///
/// # Errors
/// [`GateError::Io`].
pub fn write_files(report: &GateReport, out: &Path) -> Result<(), GateError> {
    std::fs::create_dir_all(out).map_err(GateError::io(out))?;
    let json = serde_json::to_string_pretty(report)
        .map_err(|error| GateError::BadInput(format!("gate.json: {error}")))?;
    for (name, text) in [
        ("gate.md", markdown(report)),
        ("gate.junit.xml", junit(report)),
        ("gate.json", json + "\n"),
    ] {
        replace(&out.join(name), &text)?;
    }
    Ok(())
}
