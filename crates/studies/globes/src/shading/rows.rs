// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases of layers in a run.

use super::PART;
use crate::STUDY;
use crate::clock::draw;
use crate::keys;
use crate::keys::WHAT;
use crate::table::{self, with};
use terrafill_results::{Case, Clock, Metric, Noise, Run};

/// - `what`: their condition of that name
pub(super) fn cases<'a>(run: &'a Run, what: &str) -> Vec<&'a Case> {
    with(&table::cases(run, PART), WHAT, what)
}

/// By how much identical work differed in drawing layers alone: other parts draw for much shorter times, which
/// differ by larger shares.
pub(super) fn noise(run: &Run, clock: Clock) -> Option<Noise> {
    let own = run.of_study(STUDY);
    let own: Vec<&Case> = own
        .filter(|case| case.condition(keys::PART) == PART)
        .collect();
    Noise::of(own.iter().copied(), draw(clock))
}

/// Of a case whose picture counts.
pub(super) fn value(case: &Case, metric: &Metric) -> Option<f64> {
    case.value(metric).filter(|_| case.counts())
}
