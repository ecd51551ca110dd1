// SPDX-License-Identifier: MIT OR Apache-2.0
//! By which metric a study is ranked.

use terrafill_results::{Clock, Run};

/// The metric that a study is ranked by, by the clock of the machine.
pub type Primary<'a> = &'a dyn Fn(&str, Clock) -> Option<&'static str>;

/// The metric that a study of a run is ranked by: the run's own mark, else that of this program.
pub(crate) fn ranks<'a>(run: &'a Run, study: &str, primary: Primary<'_>) -> Option<&'a str> {
    run.primary_metric(study)
        .or_else(|| primary(study, run.clock()))
}
