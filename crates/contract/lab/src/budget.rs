// SPDX-License-Identifier: MIT OR Apache-2.0
//! For each scene the cheapest choice that is within what the reader of a report allows: error, bytes and time. And
//! what exactness costs on top of it.

use crate::timings::{Timings, sums_by_process};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use terrafill_plot::number::{count, figure, measured_bytes, significant};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{Block, Budget, Case, Estimate, Run, over_processes, typical};

const HEADING: &str = "The cheapest fill within your limits";

/// As many ties as are named.
const MAX_TIES: usize = 3;

/// What may be chosen for a scene.
#[derive(Debug, Clone)]
pub struct Contender<'a> {
    /// In sentences.
    pub name: String,
    /// One for each view of the scene.
    pub cases: Vec<&'a Case>,
    /// How far its picture is off in the view that it errs most in, pixels; or beyond how many nothing is measured.
    pub error_px: Result<f64, f64>,
    /// What it holds in the view that it holds most for; `None` where that is not counted.
    pub bytes: Option<f64>,
    /// Whether it promises no error elsewhere.
    pub is_approximate: bool,
}

/// A contender with its times over a scene's views.
struct Priced<'a> {
    of: Contender<'a>,
    /// Of the view that takes longest.
    slowest: Estimate,
    /// Over all views, by process, ms.
    sums: BTreeMap<u32, f64>,
    sum_ms: f64,
}

impl<'a> Priced<'a> {
    /// `None` unless every view has its time.
    fn new(timings: Timings, of: Contender<'a>) -> Option<Self> {
        let cases = of.cases.iter();
        let times = cases.map(|case| typical(case, timings.metric));
        let times: Vec<Estimate> = times.collect::<Option<_>>()?;
        Some(Self {
            slowest: *times.iter().max_by(|a, b| a.middle.total_cmp(&b.middle))?,
            sums: sums_by_process(&of.cases, timings.metric),
            sum_ms: times.iter().map(|time| time.middle).sum(),
            of,
        })
    }

    fn is_exact(&self) -> bool {
        self.of.error_px == Ok(0.0)
    }

    /// Time over that of another, by the processes that measured both.
    fn over(&self, other: &Self) -> Option<Estimate> {
        let pairs = self.sums.iter();
        let ratios = pairs.filter_map(|(process, ms)| Some(ms / other.sums.get(process)?));
        over_processes(&ratios.collect::<Vec<f64>>())
    }

    fn described(&self) -> String {
        let error = match self.of.error_px {
            Ok(px) if px <= 0.0 => "moves no boundary on purpose".to_owned(),
            Ok(px) if self.of.is_approximate => format!(
                "approximate, off by up to {} px here, which it does not promise elsewhere",
                significant(px)
            ),
            Ok(px) => format!("moves boundaries by up to {} px", significant(px)),
            Err(limit) => format!("off by more than {limit} px"),
        };
        let time = match self.of.cases.len() {
            1 => format!("{} ms", figure(&self.slowest)),
            _ => format!(
                "{} ms for all views together, {} ms in the slowest",
                significant(self.sum_ms),
                figure(&self.slowest)
            ),
        };
        let bytes = self.of.bytes.map(measured_bytes);
        let bytes = bytes.unwrap_or_else(|| "bytes unknown".to_owned());
        format!("{}: {time}, {bytes}, {error}", self.of.name)
    }

    /// Every limit that it is over, in words, and by what factor.
    fn excesses(&self, budget: &Budget) -> Vec<(String, f64)> {
        let megabytes = self.of.bytes.map(|bytes| bytes / 1e6);
        let limits = [
            (
                "tolerance-px",
                self.of.error_px.ok(),
                Some(budget.tolerance_px),
            ),
            ("max-mb", megabytes, budget.max_mb),
            ("budget-ms", Some(self.slowest.middle), budget.budget_ms),
        ];
        let excesses = limits.into_iter().filter_map(|(switch, found, limit)| {
            let limit = limit?;
            let factor = found.map(|found| found / limit);
            if found.is_some_and(|found| found <= limit) {
                return None;
            }
            let by = match factor {
                Some(factor) if factor.is_finite() => format!(" by {} ×", significant(factor)),
                Some(_) => String::new(),
                None => ", by an unknown amount".to_owned(),
            };
            let words = format!("over --{switch} {limit}{by}");
            Some((words, factor.unwrap_or(f64::INFINITY)))
        });
        excesses.collect()
    }
}

/// The section; nothing where nothing was timed in all views of a scene.
///
/// - `scenes`: what may be chosen for each
#[must_use]
pub fn cheapest_within<'a>(
    run: &Run,
    timings: Timings,
    budget: &Budget,
    scenes: impl IntoIterator<Item = (&'a str, Vec<Contender<'a>>)>,
) -> Option<Block> {
    let scenes = scenes.into_iter();
    let lines = scenes.filter_map(|(scene, choices)| line(timings, budget, scene, choices));
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then(|| Block::Folded {
        summary: HEADING.to_owned(),
        is_open: true,
        blocks: vec![
            Block::Text(limits(run, timings, budget)),
            Block::List(lines),
        ],
    })
}

/// What the limits are, and what the answers rest on.
fn limits(run: &Run, timings: Timings, budget: &Budget) -> String {
    let clock = run.clock().name();
    let bytes = match budget.max_mb {
        Some(limit) => format!("at most {limit} MB"),
        None => "any number of MB".to_owned(),
    };
    let time = match budget.budget_ms {
        Some(limit) => format!("at most {limit} ms of {clock}"),
        None => format!("any {clock}"),
    };
    let processes = run.plan.processes;
    let weight = match processes as usize {
        0 | 1 => " One process decides nothing: these times have no interval.".to_owned(),
        some if some < MIN_REPLICATES => {
            format!(" {processes} processes give no interval.")
        }
        _ => String::new(),
    };
    let ties = match timings.noise {
        Some(_) => "",
        None => " No identical work was measured twice, so ties are unknown.",
    };
    format!(
        "Boundaries moved by at most {} px (--tolerance-px), {bytes} of all that a fill holds (--max-mb), {time} in the slowest view (--budget-ms). The defaults are 1, none and none; the \
         command terrafill report takes others. Cheapest: least {clock} over the scene's views; of ties the one with \
         the fewest bytes.{weight}{ties}",
        budget.tolerance_px,
    )
}

/// The answer for a scene.
fn line(
    timings: Timings,
    budget: &Budget,
    scene: &str,
    choices: Vec<Contender<'_>>,
) -> Option<String> {
    let priced = choices
        .into_iter()
        .filter_map(|of| Priced::new(timings, of));
    let mut all: Vec<Priced<'_>> = priced.collect();
    all.sort_by(|a, b| a.sum_ms.total_cmp(&b.sum_ms));
    let heading = match all.first()?.of.cases.len() {
        1 => scene.to_owned(),
        some => format!("{scene}, {} views", count(some as u64)),
    };
    let within = all.iter().filter(|own| own.excesses(budget).is_empty());
    let within: Vec<&Priced<'_>> = within.collect();
    let Some(fastest) = within.first() else {
        let closest = all.iter().min_by(|a, b| by_excess(a, b, budget))?;
        let excesses = closest.excesses(budget).into_iter();
        let excesses: Vec<String> = excesses.map(|(words, _)| words).collect();
        return Some(format!(
            "{heading}: none is within. Closest: {}; {}.",
            closest.described(),
            excesses.join(", ")
        ));
    };
    let is_tie = |own: &&&Priced<'_>| timings.is_tie(own.sum_ms / fastest.sum_ms);
    let ties = within[1..].iter().filter(is_tie).copied();
    let tied: Vec<&Priced<'_>> = std::iter::once(*fastest).chain(ties).collect();
    let bytes = |own: &Priced<'_>| own.of.bytes.unwrap_or(f64::INFINITY);
    // Of several the first is the fastest.
    let by_bytes = |a: &&&Priced<'_>, b: &&&Priced<'_>| bytes(a).total_cmp(&bytes(b));
    let cheapest = *tied.iter().min_by(by_bytes)?;
    let others = tied.iter().map(|own| own.of.name.as_str());
    let others: Vec<&str> = others.filter(|name| *name != cheapest.of.name).collect();
    let others = match others.as_slice() {
        [] => String::new(),
        names => format!(" Ties: {}.", some_of(names)),
    };
    Some(format!(
        "{heading}: {}.{}{others}{}",
        cheapest.described(),
        unsure(cheapest, budget),
        exactness(timings, &all, cheapest, budget)
    ))
}

/// The first of several names, and how many more there are.
#[must_use]
pub fn some_of<T: AsRef<str>>(names: &[T]) -> String {
    let shown = names.iter().take(MAX_TIES).map(AsRef::as_ref);
    let shown = shown.collect::<Vec<&str>>().join("; ");
    match names.len().saturating_sub(MAX_TIES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// What says that a time within the budget may as well be over it.
fn unsure(choice: &Priced<'_>, budget: &Budget) -> &'static str {
    let reaches = |limit: f64| {
        let high = choice.slowest.interval.map(|[_, high]| high);
        high.is_some_and(|high| high > limit)
    };
    if budget.budget_ms.is_some_and(reaches) {
        " Its interval reaches over the budget."
    } else {
        ""
    }
}

/// What the fastest exact choice takes over the cheapest one; nothing where that one is exact.
fn exactness(
    timings: Timings,
    all: &[Priced<'_>],
    cheapest: &Priced<'_>,
    budget: &Budget,
) -> String {
    if cheapest.is_exact() {
        return String::new();
    }
    let Some(exact) = all.iter().find(|own| own.is_exact()) else {
        return " No fill that moves no boundary on purpose was timed in every view.".to_owned();
    };
    let time = exact.over(cheapest);
    let time = time.map(|ratio| timings.ratio_text(&ratio));
    let bytes = exact.of.bytes.zip(cheapest.of.bytes);
    let bytes = bytes.filter(|(_, of)| *of > 0.0);
    let bytes = bytes.map(|(exact, of)| significant(exact / of));
    let excesses = exact.excesses(budget).into_iter();
    let excesses: Vec<String> = excesses.map(|(words, _)| format!("; {words}")).collect();
    format!(
        " Without moved boundaries: {}, {} the time, {} × the bytes{}.",
        exact.of.name,
        time.unwrap_or_else(|| "an unknown multiple of".to_owned()),
        bytes.unwrap_or_else(|| "an unknown number".to_owned()),
        excesses.concat()
    )
}

/// By how many limits are exceeded, then by the largest factor, then by the error.
fn by_excess(a: &Priced<'_>, b: &Priced<'_>, budget: &Budget) -> Ordering {
    let key = |own: &Priced<'_>| {
        let excesses = own.excesses(budget);
        let largest = excesses.iter().map(|(_, factor)| *factor);
        (
            excesses.len(),
            largest.fold(0.0, f64::max),
            own.of.error_px.unwrap_or(f64::INFINITY),
        )
    };
    let (a, b) = (key(a), key(b));
    let by_factor = a.1.total_cmp(&b.1);
    a.0.cmp(&b.0).then(by_factor).then(a.2.total_cmp(&b.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{TIME, empty};
    use terrafill_results::made_up::case_id;

    /// What is said of a coarse choice of 1 ms that is off by 2 px and an exact one of 4 ms.
    fn said(budget: Budget) -> String {
        let mut made = empty();
        for (name, ms) in [("coarse", 1.0), ("exact", 4.0)] {
            made.case(case_id("study", name, &[("way", name)]))
                .timed(TIME, &[ms; 5]);
        }
        let run = made.loaded();
        let timings = Timings {
            metric: TIME,
            noise: None,
        };
        let choices = run
            .cases
            .iter()
            .zip([2.0, 0.0])
            .map(|(case, px)| Contender {
                name: case.id().name.clone(),
                cases: vec![case],
                error_px: Ok(px),
                bytes: Some(1e6),
                is_approximate: false,
            });
        let block = cheapest_within(&run, timings, &budget, [("s", choices.collect())]);
        format!("{block:?}")
    }

    #[test]
    fn the_cheapest_within_the_limits_is_named_and_what_is_over_one_is_not() {
        let rough = Budget {
            tolerance_px: 2.0,
            ..Budget::default()
        };
        assert!(said(rough).contains("s: coarse: 1.00 [1.00–1.00] ms"));
        assert!(said(rough).contains("Without moved boundaries: exact, 4.00 ×"));
        // Negative controls: an error, and a time, that are over their limits.
        assert!(said(Budget::default()).contains("s: exact: 4.00"));
        let quick = Budget {
            budget_ms: Some(0.5),
            ..rough
        };
        assert!(said(quick).contains("none is within. Closest: coarse"));
        assert!(said(quick).contains("over --budget-ms 0.5 by 2.00 ×"));
    }
}
