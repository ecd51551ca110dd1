// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times of the chapter's sections, and cases beside others.

use crate::metrics::{API, PIPELINE_CPU_MS, PIPELINE_GPU_MS, PIPELINE_WALL_MS};
use terrafill_lab::{Cases, Column, Comparison, Figure, Follows, finding};
use terrafill_plot::number::significant;
use terrafill_results::{
    Block, Case, ChapterError, Claim, Clock, ConditionKey, Estimate, Finding, Metric, Scope, ratio,
};

/// Times.
pub(super) const TIME: Figure = Figure::ByClock(PIPELINE_GPU_MS, PIPELINE_CPU_MS);
/// Times of ways that differ in what the CPU does and sends each frame, of which a device's clock knows nothing.
pub(super) const FRAME: Figure = Figure::ByClock(PIPELINE_WALL_MS, PIPELINE_CPU_MS);
/// What the latter covers of a frame.
pub(super) const WHOLE: Scope = Scope::UPLOAD.and(Scope::DRAW);

/// The metric of [`TIME`].
pub(super) fn time(clock: Clock) -> &'static Metric {
    clock.pick(PIPELINE_GPU_MS, PIPELINE_CPU_MS)
}

/// The metric of [`FRAME`].
pub(super) fn frame_time(clock: Clock) -> &'static Metric {
    clock.pick(PIPELINE_WALL_MS, PIPELINE_CPU_MS)
}

/// A column of what devices count.
pub(super) const fn counter(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).or_of(|case| match case.condition(API) {
        "wgpu" => "counted on Vulkan alone",
        _ => "not counted by the device for this stage",
    })
}

/// A column of shares in percent.
pub(super) const fn percent(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).written(|share| significant(100.0 * share))
}

/// A column of ratios to another case; a case without one says what is wrong with it.
pub(super) const fn ratios(
    heading: &'static str,
    of: fn(&Cases<'_>, &Case) -> Option<Estimate>,
) -> Column {
    Column::beside(heading, of).or_of(|case| match case.reason.as_str() {
        "" => "not measured",
        reason => reason,
    })
}

/// What published figures cannot show.
pub(super) fn remark(text: &str) -> Result<Option<Block>, ChapterError> {
    Ok(Some(Block::Remark(text.to_owned())))
}

/// A figure in a sentence.
pub(super) fn said(case: &Case, metric: &Metric) -> String {
    let value = case.value(metric).map(significant);
    value.unwrap_or_else(|| "–".to_owned())
}

/// Cases whose error was measured and is at most this: among them the cheapest may be named.
pub(super) fn within<'a>(cases: &Cases<'a>, error: &Metric, most: f64) -> Cases<'a> {
    cases.fitting(|case| case.value(error).is_some_and(|found| found <= most))
}

/// Timed cases of the greatest number of a condition, and that number.
pub(super) fn of_most<'a>(
    cases: &Cases<'a>,
    key: ConditionKey,
    metric: &Metric,
) -> Option<(&'a str, Cases<'a>)> {
    let timed = cases.fitting(|case| case.counts() && case.value(metric).is_some());
    let number = |text: &&str| text.parse::<u32>().unwrap_or(0);
    let most = timed.distinct(key).into_iter().max_by_key(number)?;
    Some((most, timed.with(&[(key, most)])))
}

/// The case that differs in these conditions and in no other.
pub(super) fn beside<'a>(
    cases: &Cases<'a>,
    case: &Case,
    changed: &[(ConditionKey, &str)],
) -> Option<&'a Case> {
    let rest = |case: &Case| {
        let mut rest = case.id().conditions.clone();
        rest.retain(|name, _| changed.iter().all(|(key, _)| key.name() != name));
        rest
    };
    let own = rest(case);
    cases.with(changed).iter().find(|other| rest(other) == own)
}

/// How many times as fast `fast` is as `slow`: time of the second over time of the first.
pub(super) fn gain(slow: Option<&Case>, fast: Option<&Case>, metric: &Metric) -> Option<Estimate> {
    let (slow, fast) = (
        slow.filter(|case| case.counts())?,
        fast.filter(|case| case.counts())?,
    );
    ratio(slow, fast, metric)
}

/// What pairs say of a claim on a time: the first's over the second's.
pub(super) fn compared(
    cases: &Cases<'_>,
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
    cases.compared(&comparison, pairs, says, claim)
}

/// That none of these figures is above 0.
pub(super) fn none_of(claim: &str, what: &str, values: &[f64]) -> Finding {
    let most = values.iter().copied().max_by(f64::total_cmp);
    let because = most.map(|most| format!("at most {most} {what} in {} cases", values.len()));
    let holds = most.map(|most| most <= 0.0);
    finding(format!("{claim}:"), holds, because.unwrap_or_default())
}
