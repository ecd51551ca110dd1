// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on precision: every route from a fragment to its texture coordinate, its error against
//! its cost, and where formula and measurement differ.

mod findings;
mod plots;
mod tables;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use terrafill_plot::Reading;
use terrafill_plot::number::{count, significant};
use terrafill_results::{Block, Case, Chapter, ChapterError, Clock, Outcome, Run, median, spread};

/// A formula that costs less than this much beyond the loop around it is below the timer's resolution
/// and is drawn here. Nanoseconds.
const MIN_NS: f64 = 0.01;

/// Formula and measurement agree within this factor.
const AGREEMENT: f64 = 2.0;

/// A quarter of a texel, and of a pixel: what a plan allows on average.
const QUARTER: f64 = 0.25;

/// The position route and depth that are drawn with by default.
const DEFAULT_POSITION: (&str, &str) = ("eye-region", "reversed-float32-infinite");

/// Where anchors stand, as in the `anchor` column.
const PLAN: &str = "plan";
const MIDDLE: &str = "middle";

/// Regions that are drawn: extent, latitude and heights as in the `condition` column.
const DRAWN: [(&str, &str); 6] = [
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

/// Errors and costs of the routes to a texture coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct PrecisionChapter;

impl Chapter for PrecisionChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Precision: from a fragment to its texture coordinate"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick("gpu_ns", "cpu_ns"))
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let data = Data::new(run);
        if data.formulas.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(format!(
            "Every way to longitude and latitude, evaluated at places of regions from 0.001° to the \
             globe, from the equator to the pole, with terrain from −110 to 90 km: on the CPU in the \
             shader's steps, and on the device by the shader's text. Errors are against the exact map \
             in double precision. Times are of the formula alone, without the loop around it. {}",
            summary(&data)
        ))];
        blocks.extend(findings::findings(&data).into_iter().map(Block::Finding));
        blocks.push(Block::Remark(format!(
            "In the plots terrain reaches up to 9 km where it says nothing else; one curve per family \
             through its knob: degree, or texels of a table. Filled: largest error on the device; open: \
             root mean square. A cross: an error above its bound; on the upper edge: no finite answer, \
             or no map of that region. Ringed and dashed: the Pareto front, where 95 % of the resamples \
             of processes keep it. A formula cheaper than {} ns, below the timer's resolution, stands \
             there. cubic-cesium: the arctangent of the best-known web globe (CesiumJS, after Drobot \
             2014) with the geodetic latitude; +geocentric: with the geocentric one, as it is used \
             there, where extents are computed by the same formula, so that edges fall together and \
             pictures are distorted between them. A label has its curve's colour. Dashed lines, named at \
             the right: a quarter of a texel; half a unit in the last place of the largest answer in \
             f32; 4096 units in the last place, which WGSL and Vulkan grant atan2.",
            significant(MIN_NS)
        )));
        blocks.extend(plots::plots(&data)?);
        blocks.extend(tables::tables(&data));
        Ok(blocks)
    }
}

/// One formula under one condition.
#[derive(Debug, Clone, Copy)]
struct Formula<'a>(&'a Case);

impl<'a> Formula<'a> {
    fn part(self) -> &'a str {
        self.0.condition("part")
    }

    fn route(self) -> &'a str {
        self.0.condition("route")
    }

    fn family(self) -> &'a str {
        self.0.condition("family")
    }

    fn condition(self) -> &'a str {
        self.0.condition("condition")
    }

    fn anchor(self) -> &'a str {
        self.0.condition("anchor")
    }

    /// A condition that is a number.
    fn number(self, condition: &str) -> Option<f64> {
        self.0.condition(condition).parse().ok()
    }

    fn figure(self, metric: &str) -> Option<f64> {
        self.0.value(metric)
    }

    fn is_chosen(self) -> bool {
        self.figure("chosen").is_some_and(|chosen| chosen > 0.5)
    }

    fn is_ok(self) -> bool {
        self.0.outcome == Outcome::Ok
    }

    /// A figure that counts something.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counts are whole, not negative and far below 2^53"
    )]
    fn count(self, metric: &str) -> Option<u64> {
        let value = self.figure(metric)?;
        (value.is_finite() && value >= 0.0).then(|| value.round() as u64)
    }

    /// Answers that are not finite, emulated or on the device.
    fn non_finite(self) -> u64 {
        let counted = |metric| self.count(metric).unwrap_or(0);
        counted("non_finite_emulated") + counted("non_finite_device")
    }
}

/// The study in a run.
struct Data<'a> {
    clock: Clock,
    /// Every formula that was verified.
    formulas: Vec<Formula<'a>>,
    /// Timed coordinate routes.
    times: BTreeMap<&'a str, &'a Case>,
}

impl<'a> Data<'a> {
    fn new(run: &'a Run) -> Self {
        let own = || run.of_study(crate::STUDY).filter(|case| !case.is_twin());
        let is_time = |case: &&Case| case.condition("part") == "time";
        let timed = own().filter(is_time);
        let timed = timed.filter(|case| case.condition("of_part") == "coordinate");
        Self {
            clock: run.clock(),
            formulas: own().filter(|case| !is_time(case)).map(Formula).collect(),
            times: timed.map(|case| (case.condition("route"), case)).collect(),
        }
    }

    fn of(&self, part: &'a str) -> impl Iterator<Item = Formula<'a>> {
        let formulas = self.formulas.iter().copied();
        formulas.filter(move |formula| formula.part() == part)
    }

    /// Time of a coordinate route, as a plot has it.
    fn time(&self, route: &str) -> Option<Reading> {
        let case = self.times.get(route).filter(|case| case.counts())?;
        let samples = case.samples(self.clock.pick("gpu_ns", "cpu_ns"))?;
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

    fn time_axis(&self) -> String {
        format!(
            "ns per fragment, {}: median, 5–95 % of samples",
            self.clock.name()
        )
    }
}

fn summary(data: &Data<'_>) -> String {
    let of = |status| {
        data.formulas
            .iter()
            .copied()
            .filter(|row| row.0.outcome == status)
            .count()
    };
    let points = data.formulas.iter().filter_map(|row| row.count("points"));
    let points: u64 = points.sum();
    let routes: BTreeSet<&str> = data.of("coordinate").map(|row| row.route()).collect();
    format!(
        "{} rows of {} places in all, {} coordinate routes: {} within their bound, {} not finite, above \
         their bound or without one, {} not measured.",
        count(data.formulas.len() as u64),
        count(points),
        routes.len(),
        of(Outcome::Ok),
        of(Outcome::Wrong),
        of(Outcome::Skipped) + of(Outcome::Failed),
    )
}

/// What a row says that has no better reason.
const NO_REASON: &str = "no reason";

fn agrees(ratio: f64) -> bool {
    (1.0 / AGREEMENT..=AGREEMENT).contains(&ratio)
}
