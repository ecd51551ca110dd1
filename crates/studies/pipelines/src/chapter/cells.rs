// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases by their conditions, and cells of tables with the reason of each that is empty.

use crate::keys::{API, EXPERIMENT};
use crate::metrics::METRICS;
use terrafill_lab::{Comparison, Follows};
use terrafill_plot::dotted;
use terrafill_plot::number::{bytes, significant};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, ConditionKey, Estimate, Finding, Heading, Metric, Noise, Run,
    Scope, ratio,
};

const CPU: &Metric = Metric::of(&METRICS, "pipeline_cpu_ms");
const GPU: &Metric = Metric::of(&METRICS, "pipeline_gpu_ms");
const WALL: &Metric = Metric::of(&METRICS, "pipeline_wall_ms");

/// The metric of times.
pub(super) fn time(clock: Clock) -> &'static Metric {
    clock.pick(GPU, CPU)
}

/// The metric of times of ways that differ in what the CPU does and sends each frame, of which a device's clock knows
/// nothing.
pub(super) fn frame_time(clock: Clock) -> &'static Metric {
    clock.pick(WALL, CPU)
}

/// What it covers of a frame.
pub(super) const WHOLE: Scope = Scope::UPLOAD.and(Scope::DRAW);

/// What the times of a section by [`frame_time`] are.
pub(super) fn what_times_cover(clock: Clock) -> Block {
    let by = clock.pick(
        "wall clock: GPU time does not cover what the CPU writes for a frame",
        "process CPU time",
    );
    Block::Remark(format!(
        "Times of this section are {by}. They run from before a frame's upload until the device is done."
    ))
}

/// Of the conditions named.
pub(super) fn of<'a>(cases: &[&'a Case], conditions: &[(ConditionKey, &str)]) -> Vec<&'a Case> {
    let fits = |case: &&Case| {
        conditions
            .iter()
            .all(|(key, value)| case.condition(*key) == *value)
    };
    cases.iter().copied().filter(fits).collect()
}

/// Values of a condition in rising order.
pub(super) fn values(cases: &[&Case], key: ConditionKey) -> Vec<u32> {
    let values = cases
        .iter()
        .filter_map(|case| case.condition(key).parse().ok());
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Why a cell is empty.
pub(super) fn why(case: &Case) -> &str {
    match case.reason.as_str() {
        "" => "not measured",
        reason => reason,
    }
}

pub(super) fn count(case: &Case, metric: &Metric) -> Cell {
    let text = case.value(metric).map(significant);
    let absent = match (case.counts(), case.condition(API)) {
        (false, _) => why(case),
        (_, "wgpu") => "counted on Vulkan alone",
        _ => "not counted by the device for this stage",
    };
    Cell::or_absent(text, absent)
}

/// Whole and positive, as written.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count of bytes below 2⁵³"
)]
pub(super) fn byte_cell(case: &Case, metric: &Metric) -> Cell {
    let text = case.value(metric).map(|count| bytes(count as u64));
    Cell::or_absent(text, why(case))
}

pub(super) fn time_cell(case: &Case, metric: &Metric) -> Cell {
    let value = case.value(metric).filter(|_| case.counts());
    let time = Cell::or_absent(value.map(significant), why(case));
    dotted(time, case, metric)
}

/// How many times as fast `fast` is as `slow`: time of the second over time of the first.
pub(super) fn gain(slow: Option<&Case>, fast: Option<&Case>, metric: &Metric) -> Option<Estimate> {
    let (slow, fast) = (
        slow.filter(|case| case.counts())?,
        fast.filter(|case| case.counts())?,
    );
    ratio(slow, fast, metric)
}

/// What pairs of one experiment say of a claim: time of the first over time of the second.
pub(super) fn paired_finding(
    run: &Run,
    (changed, follows): (ConditionKey, &[Follows<'_>]),
    (metric, needs): (&'static Metric, Scope),
    pairs: &[[&Case; 2]],
    (claim, says): (String, Claim),
) -> Finding {
    let comparison = Comparison {
        changed: changed.name(),
        follows,
        one_sided: None,
        metric,
        needs,
    };
    let of_study = || run.of_study(crate::STUDY);
    let experiment = pairs
        .first()
        .map_or("", |pair| pair[0].condition(EXPERIMENT));
    let own = of_study().filter(|case| case.condition(EXPERIMENT) == experiment);
    let own: Vec<&Case> = own.collect();
    let all: Vec<&Case> = of_study().collect();
    let noise = Noise::of(own.into_iter(), metric).or_else(|| Noise::of(all.into_iter(), metric));
    comparison.finding(run, pairs, says, claim, noise)
}

pub(super) fn headings(names: &[(&str, Option<&'static Metric>)]) -> Vec<Heading> {
    let heading = |(name, metric): &(&str, Option<&'static Metric>)| match metric {
        Some(metric) => Heading::metric(*name, *metric),
        None => Heading::plain(*name),
    };
    names.iter().map(heading).collect()
}
