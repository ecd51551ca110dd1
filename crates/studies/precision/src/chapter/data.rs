// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter reads from a run: formulas with their figures, and times of routes.

use crate::keys::*;
use crate::row::whole;
use std::collections::BTreeMap;
use terrafill_plot::Reading;
use terrafill_results::{Case, Clock, ConditionKey, Metric, Outcome, Run, median, spread};

/// A formula that costs less than this much beyond the loop around it is below the timer's resolution
/// and is drawn here. Nanoseconds.
pub(super) const MIN_NS: f64 = 0.01;

/// Formula and measurement agree within this factor.
pub(super) const AGREEMENT: f64 = 2.0;

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

/// One formula under one condition.
#[derive(Debug, Clone, Copy)]
pub(super) struct Formula<'a>(pub(super) &'a Case);

impl<'a> Formula<'a> {
    pub(super) fn part(self) -> &'a str {
        self.0.condition(PART)
    }

    pub(super) fn route(self) -> &'a str {
        self.0.condition(ROUTE)
    }

    pub(super) fn family(self) -> &'a str {
        self.0.condition(FAMILY)
    }

    pub(super) fn condition(self) -> &'a str {
        self.0.condition(CONDITION)
    }

    pub(super) fn anchor(self) -> &'a str {
        self.0.condition(ANCHOR)
    }

    /// A condition that is a number.
    pub(super) fn number(self, condition: ConditionKey) -> Option<f64> {
        self.0.condition(condition).parse().ok()
    }

    pub(super) fn figure(self, metric: &Metric) -> Option<f64> {
        self.0.value(metric)
    }

    pub(super) fn is_chosen(self) -> bool {
        self.figure(CHOSEN).is_some_and(|chosen| chosen > 0.5)
    }

    pub(super) fn is_ok(self) -> bool {
        self.0.outcome == Outcome::Ok
    }

    /// A figure that counts something; 0 where nothing was counted.
    pub(super) fn count(self, metric: &Metric) -> u64 {
        self.figure(metric).and_then(whole).unwrap_or(0)
    }

    /// Answers that are not finite, emulated or on the device.
    pub(super) fn non_finite(self) -> u64 {
        self.count(NON_FINITE_EMULATED) + self.count(NON_FINITE_DEVICE)
    }
}

/// The study in a run.
pub(super) struct Data<'a> {
    pub(super) clock: Clock,
    /// Every formula that was verified.
    pub(super) formulas: Vec<Formula<'a>>,
    /// Timed coordinate routes.
    pub(super) times: BTreeMap<&'a str, &'a Case>,
}

impl<'a> Data<'a> {
    pub(super) fn new(run: &'a Run) -> Self {
        let own = || run.of_study(crate::STUDY).filter(|case| !case.is_twin());
        let is_time = |case: &&Case| case.condition(PART) == "time";
        let timed = own().filter(is_time);
        let timed = timed.filter(|case| case.condition(OF_PART) == "coordinate");
        Self {
            clock: run.clock(),
            formulas: own().filter(|case| !is_time(case)).map(Formula).collect(),
            times: timed.map(|case| (case.condition(ROUTE), case)).collect(),
        }
    }

    pub(super) fn of(&self, part: &'a str) -> impl Iterator<Item = Formula<'a>> {
        let formulas = self.formulas.iter().copied();
        formulas.filter(move |formula| formula.part() == part)
    }

    /// Time of a coordinate route, as a plot has it.
    pub(super) fn time(&self, route: &str) -> Option<Reading> {
        let case = self.times.get(route).filter(|case| case.counts())?;
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

pub(super) fn agrees(ratio: f64) -> bool {
    (1.0 / AGREEMENT..=AGREEMENT).contains(&ratio)
}
