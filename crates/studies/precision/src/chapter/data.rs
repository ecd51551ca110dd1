// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter reads from a run: formulas with their figures, and times of routes.

use crate::metrics::*;
use crate::row::whole;
use terrafill_lab::Cases;
use terrafill_plot::Reading;
use terrafill_results::{Case, Clock, ConditionKey, Metric, Run, median, spread};

/// A formula that costs less than this much beyond the loop around it is below the timer's resolution
/// and is drawn here. Nanoseconds.
pub(super) const MIN_NS: f64 = 0.01;

/// A quarter of a texel, and of a pixel: what a plan allows on average.
pub(super) const QUARTER: f64 = 0.25;

/// The position route and depth that are drawn with by default.
pub(super) const DEFAULT_POSITION: (&str, &str) = ("eye-region", "reversed-float32-infinite");

/// Where anchors stand, as in the `anchor` column.
pub(super) const PLAN: &str = "plan";
pub(super) const MIDDLE: &str = "middle";

/// Regions that are drawn: extent, latitude and heights as in the `condition` column.
pub(super) const DRAWN: [(&str, &str); 6] = [
    (
        "extent=0.01;latitude=45;heights=+9km",
        "0.01°, latitude 45°",
    ),
    ("extent=1;latitude=45;heights=+9km", "1°, latitude 45°"),
    ("extent=10;latitude=45;heights=+9km", "10°, latitude 45°"),
    (
        "extent=10;latitude=90;heights=+9km",
        "a cap of 5° round the pole",
    ),
    ("extent=90;latitude=45;heights=+9km", "90°, latitude 45°"),
    ("extent=360;latitude=0;heights=+9km", "The globe"),
];

/// A condition that is a number.
pub(super) fn number(row: &Case, condition: ConditionKey) -> Option<f64> {
    row.condition(condition).parse().ok()
}

/// Whether a plan takes the route there.
pub(super) fn is_chosen(row: &Case) -> bool {
    row.value(CHOSEN).is_some_and(|chosen| chosen > 0.5)
}

/// A figure that counts something; 0 where nothing was counted.
pub(super) fn count_of(row: &Case, metric: &Metric) -> u64 {
    row.value(metric).and_then(whole).unwrap_or(0)
}

/// Answers that are not finite, emulated or on the device.
pub(super) fn non_finite(row: &Case) -> u64 {
    count_of(row, NON_FINITE_EMULATED) + count_of(row, NON_FINITE_DEVICE)
}

/// The study in a run.
pub(super) struct Data<'a> {
    pub(super) clock: Clock,
    /// Every formula under every condition that was verified.
    pub(super) formulas: Cases<'a>,
    /// Timed coordinate routes.
    pub(super) times: Cases<'a>,
}

impl<'a> Data<'a> {
    pub(super) fn new(run: &'a Run) -> Self {
        let own = Cases::of_study(run, crate::STUDY);
        Self {
            clock: run.clock(),
            formulas: own.fitting(|case| case.condition(PART) != "time"),
            times: own.with(&[(PART, "time"), (OF_PART, "coordinate")]),
        }
    }

    /// Formulas of a part.
    pub(super) fn of(&self, part: &str) -> Cases<'a> {
        self.formulas.with(&[(PART, part)])
    }

    /// Time of a coordinate route, as a plot has it.
    pub(super) fn time(&self, route: &str) -> Option<Reading> {
        let timed = self.times.with(&[(ROUTE, route)]);
        let case = timed.first().filter(|case| case.counts())?;
        let samples = case.samples(self.clock.pick(GPU_NS, CPU_NS))?;
        let seen = |ns: &f64| ns.max(MIN_NS);
        let all: Vec<f64> = samples
            .values()
            .flat_map(|of| of.values().map(seen))
            .collect();
        let replicates = samples.values().filter_map(|of| {
            let of: Vec<f64> = of.values().map(seen).collect();
            median(&of)
        });
        Some(Reading::sampled(
            spread(&all)?,
            &replicates.collect::<Vec<_>>(),
        ))
    }

    pub(super) fn time_axis(&self) -> String {
        format!(
            "ns per fragment, {}: median, 5–95 % of samples",
            self.clock.name()
        )
    }
}

/// What a row says that has no better reason.
pub(super) const NO_REASON: &str = "no reason";
