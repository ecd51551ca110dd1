// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blessings that cover nothing any more, taken out of their file.

use crate::bless::write_blessings;
use crate::{Blessing, GateError, GateReport, read_blessings};
use std::collections::BTreeSet;
use std::path::Path;

/// Takes out of a file what covers nothing that this gate found, of the scenes that it measured and, without times,
/// of exact figures alone. Returns what was taken out.
///
/// # Errors
/// As [`read_blessings`].
pub fn prune_blessings(path: &Path, report: &GateReport) -> Result<Vec<Blessing>, GateError> {
    let scene = |case: &str| case.split('/').take(2).collect::<Vec<_>>().join("/");
    let measured: BTreeSet<String> = report.compared.iter().map(|case| scene(case)).collect();
    let base = report.base_commit();
    let is_idle = |blessing: &Blessing| {
        let is_time = blessing.to.ends_with('%');
        measured.contains(&scene(&blessing.case))
            && (report.time.is_some() || !is_time)
            && !report
                .findings
                .iter()
                .any(|finding| blessing.covers(finding, base))
    };
    let (idle, kept): (Vec<_>, Vec<_>) = read_blessings(path)?.into_iter().partition(is_idle);
    if !idle.is_empty() {
        write_blessings(path, &kept)?;
    }
    Ok(idle)
}
