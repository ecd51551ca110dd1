// SPDX-License-Identifier: MIT OR Apache-2.0
//! A made-up run with one time, for tests of everything that reads cases.

use terrafill_results::made_up::MadeUpRun;
use terrafill_results::{Kind, Metric, Scope};

pub(crate) const METRICS: [Metric; 1] =
    [Metric::less("draw_cpu_ms", "ms", Kind::Time, "Time.").covering(Scope::FRAME)];
pub(crate) const TIME: &Metric = Metric::of(&METRICS, "draw_cpu_ms");

/// Without cases.
pub(crate) fn empty() -> MadeUpRun {
    MadeUpRun {
        metrics: METRICS.to_vec(),
        ..MadeUpRun::default()
    }
}
