// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases of layers in a run.

use super::PART;
use crate::table::{self, with};
use terrafill_results::{Case, Run};

/// - `what`: their condition of that name
pub(super) fn cases<'a>(run: &'a Run, what: &str) -> Vec<&'a Case> {
    with(&table::cases(run, PART), "what", what)
}

/// Of a case whose picture counts.
pub(super) fn value(case: &Case, metric: &str) -> Option<f64> {
    case.value(metric).filter(|_| case.counts())
}
