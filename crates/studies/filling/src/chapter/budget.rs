// SPDX-License-Identifier: MIT OR Apache-2.0
//! For each scene the cheapest fill that is within what the reader allows: error, bytes and time. And what exactness
//! costs on top of it.
//!
//! Right fills compete, and so do approximate ones, by the error that they had in this run. Points of sweeps do not.

use super::answers::some_of;
use super::data::{Data, View, distinct, has_role, is_approximate, is_compared, label};
use crate::keys::*;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use terrafill_conformance::{BAND_RADIUS_PX, MAX_PICTURE_SEARCH_PX};
use terrafill_plot::number::{count, figure, measured_bytes, significant};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{
    Block, Budget, Case, Estimate, Outcome, over_processes, process_medians, typical,
};

const HEADING: &str = "The cheapest fill within your limits";

/// What a fill holds of its own.
const HELD: [&terrafill_results::Metric; 3] = [CONSTANT_BYTES, TARGET_BYTES, TEXTURE_BYTES];

/// A fill with its figures over a scene's views.
struct Fill<'a> {
    name: String,
    cases: Vec<&'a Case>,
    /// Of the view that it errs most in, pixels; `None` for more than could be measured.
    error_px: Option<f64>,
    /// Of the view that it holds most for.
    bytes: Option<f64>,
    /// Of the view that takes longest.
    slowest: Estimate,
    /// Over all views, by process, ms.
    sums: BTreeMap<u32, f64>,
    sum_ms: f64,
}

impl<'a> Fill<'a> {
    /// `None` unless every view has its time.
    fn new(data: &Data<'a>, name: String, cases: Vec<&'a Case>) -> Option<Self> {
        let times = cases.iter().map(|case| typical(case, data.metric));
        let times: Vec<Estimate> = times.collect::<Option<_>>()?;
        let medians = cases.iter().map(|case| process_medians(case, data.metric));
        let medians: Vec<BTreeMap<u32, f64>> = medians.collect();
        // A process counts where it measured all views.
        let processes = medians.first()?.keys();
        let sums = processes.filter_map(|process| {
            let of_views = medians.iter().map(|own| own.get(process));
            Some((*process, of_views.sum::<Option<f64>>()?))
        });
        let largest = |figures: Vec<Option<f64>>| {
            let known: Option<Vec<f64>> = figures.into_iter().collect();
            known.map(|known| known.into_iter().fold(0.0, f64::max))
        };
        Some(Self {
            name,
            error_px: largest(cases.iter().map(|case| error_px(case)).collect()),
            bytes: largest(cases.iter().map(|case| held_bytes(case)).collect()),
            slowest: *times.iter().max_by(|a, b| a.middle.total_cmp(&b.middle))?,
            sums: sums.collect(),
            sum_ms: times.iter().map(|time| time.middle).sum(),
            cases,
        })
    }

    fn is_exact(&self) -> bool {
        self.error_px == Some(0.0)
    }

    /// Time over that of another, by the processes that measured both.
    fn over(&self, other: &Self) -> Option<Estimate> {
        let pairs = self.sums.iter();
        let ratios = pairs.filter_map(|(process, ms)| Some(ms / other.sums.get(process)?));
        over_processes(&ratios.collect::<Vec<f64>>())
    }

    fn told(&self, views: usize) -> String {
        let error = match (
            self.error_px,
            self.cases.iter().any(|case| is_approximate(case)),
        ) {
            (Some(px), _) if px <= 0.0 => "exact".to_owned(),
            (Some(px), false) => format!("moves boundaries by up to {} px", significant(px)),
            (Some(px), true) => format!(
                "approximate, off by up to {} px here, which it does not promise elsewhere",
                significant(px)
            ),
            (None, _) => format!("off by more than {} px", MAX_PICTURE_SEARCH_PX),
        };
        let time = match views {
            1 => format!("{} ms", figure(&self.slowest)),
            _ => format!(
                "{} ms over all views, {} ms in the slowest",
                significant(self.sum_ms),
                figure(&self.slowest)
            ),
        };
        let bytes = self.bytes.map(measured_bytes);
        let bytes = bytes.unwrap_or_else(|| "bytes unknown".to_owned());
        format!("{}: {time}, {bytes}, {error}", self.name)
    }

    /// Every limit that it is over, in words, and by what factor.
    fn excesses(&self, budget: &Budget) -> Vec<(String, f64)> {
        let over = |found: Option<f64>, limit: Option<f64>, words: &dyn Fn(&str) -> String| {
            let limit = limit?;
            match found {
                Some(found) if found <= limit => None,
                Some(found) => {
                    let factor = found / limit;
                    let by = if factor.is_finite() {
                        format!(" by {} ×", significant(factor))
                    } else {
                        String::new()
                    };
                    Some((words(&by), factor))
                }
                None => Some((words(", by an unknown amount"), f64::INFINITY)),
            }
        };
        let limits = [
            over(self.error_px, Some(budget.tolerance_px), &|by| {
                format!("over --tolerance-px {}{by}", budget.tolerance_px)
            }),
            over(self.bytes.map(|bytes| bytes / 1e6), budget.max_mb, &|by| {
                format!("over --max-mb {}{by}", budget.max_mb.unwrap_or_default())
            }),
            over(Some(self.slowest.middle), budget.budget_ms, &|by| {
                format!(
                    "over --budget-ms {}{by}",
                    budget.budget_ms.unwrap_or_default()
                )
            }),
        ];
        limits.into_iter().flatten().collect()
    }
}

/// How far a picture's boundaries are from the reference's, pixels: 0 for a right fill that simplifies none, whose
/// boundary pixels alone are rounded; `None` for more than could be measured.
///
/// Of an approximate fill whole pixels are compared, so that a picture without a difference may be off by one.
fn error_px(case: &Case) -> Option<f64> {
    let moved = case.value(BOUNDARY_MOVED_PX);
    if !is_approximate(case) {
        return Some(moved.unwrap_or(0.0));
    }
    // Both ways: what the picture has too much of, and what it lacks.
    let lacks = case.value(HAUSDORFF_PX).unwrap_or(0.0);
    Some(moved?.max(lacks).max(f64::from(BAND_RADIUS_PX)))
}

/// Bytes of geometry, constants, targets and textures; `None` where the technique counts none.
fn held_bytes(case: &Case) -> Option<f64> {
    let others = HELD.iter().filter_map(|metric| case.value(*metric));
    Some(case.value(GEOMETRY_BYTES)? + others.sum::<f64>())
}

/// The section; nothing where no fill of any scene was timed in all its views.
pub(super) fn blocks(data: &Data<'_>, budget: &Budget) -> Vec<Block> {
    let scenes = data.scenes().into_iter();
    let lines = scenes.filter_map(|(scene, views)| line(data, scene, &views, budget));
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() {
        Vec::new()
    } else {
        vec![Block::Folded {
            summary: HEADING.to_owned(),
            is_open: true,
            blocks: vec![Block::Text(limits(data, budget)), Block::List(lines)],
        }]
    }
}

/// What the limits are, and what the answers rest on.
fn limits(data: &Data<'_>, budget: &Budget) -> String {
    let clock = data.run.clock().name();
    let bytes = match budget.max_mb {
        Some(limit) => format!("at most {limit} MB"),
        None => "any number of MB".to_owned(),
    };
    let time = match budget.budget_ms {
        Some(limit) => format!("at most {limit} ms of {clock}"),
        None => format!("any {clock}"),
    };
    let processes = data.run.plan.processes;
    let weight = match processes as usize {
        0 | 1 => " One process decides nothing: these times have no interval.".to_owned(),
        some if some < MIN_REPLICATES => {
            format!(" {processes} processes give no interval.")
        }
        _ => String::new(),
    };
    let ties = match data.noise {
        Some(_) => "",
        None => " No identical work was measured twice, so ties are unknown.",
    };
    format!(
        "Boundaries off by at most {} px (--tolerance-px; 0 is exact, 1 what counts as right), {bytes} (--max-mb), {time} \
         in the slowest view (--budget-ms). The defaults are 1, none and none; `report` takes others. Cheapest: least \
         {clock} over the scene's views; of ties the one with the fewest bytes.{weight}{ties}",
        budget.tolerance_px,
    )
}

/// The answer for a scene.
fn line(data: &Data<'_>, scene: &str, views: &[&View<'_>], budget: &Budget) -> Option<String> {
    let mut fills = fills(data, views);
    fills.sort_by(|a, b| a.sum_ms.total_cmp(&b.sum_ms));
    let told = |fill: &Fill<'_>| fill.told(views.len());
    let within = fills.iter().filter(|fill| fill.excesses(budget).is_empty());
    let within: Vec<&Fill<'_>> = within.collect();
    let heading = match views.len() {
        1 => scene.to_owned(),
        some => format!("{scene}, {} views", count(some as u64)),
    };
    let Some(fastest) = within.first() else {
        let closest = fills.iter().min_by(|a, b| by_excess(a, b, budget))?;
        let excesses = closest.excesses(budget).into_iter();
        let excesses: Vec<String> = excesses.map(|(words, _)| words).collect();
        return Some(format!(
            "{heading}: none is within. Closest: {}; {}.",
            told(closest),
            excesses.join(", ")
        ));
    };
    let ties = within[1..].iter().filter(|fill| {
        let over = fill.sum_ms / fastest.sum_ms;
        data.is_tie(over)
    });
    let tied: Vec<&Fill<'_>> = [*fastest].into_iter().chain(ties.copied()).collect();
    let bytes = |fill: &Fill<'_>| fill.bytes.unwrap_or(f64::INFINITY);
    // Of several the first is the fastest.
    let cheapest = tied.iter().copied().reduce(|least, next| {
        if bytes(next) < bytes(least) {
            next
        } else {
            least
        }
    })?;
    let others = tied.iter().filter(|fill| fill.name != cheapest.name);
    let others: Vec<&str> = others.map(|fill| fill.name.as_str()).collect();
    let others = match others.as_slice() {
        [] => String::new(),
        names => format!(" Ties: {}.", some_of(names)),
    };
    Some(format!(
        "{heading}: {}.{}{others} {}",
        told(cheapest),
        unsure(cheapest, budget),
        exactness(data, &fills, cheapest, budget)
    ))
}

/// What says that a time within the budget may as well be over it.
fn unsure(fill: &Fill<'_>, budget: &Budget) -> &'static str {
    let reaches = |limit: f64| {
        let high = fill.slowest.interval.map(|[_, high]| high);
        high.is_some_and(|high| high > limit)
    };
    if budget.budget_ms.is_some_and(reaches) {
        " Its interval reaches over the budget."
    } else {
        ""
    }
}

/// What the fastest exact fill takes over the cheapest one.
fn exactness(data: &Data<'_>, fills: &[Fill<'_>], cheapest: &Fill<'_>, budget: &Budget) -> String {
    if cheapest.is_exact() {
        return "Exactness costs nothing on top.".to_owned();
    }
    let Some(exact) = fills.iter().find(|fill| fill.is_exact()) else {
        return "No exact fill was timed in every view.".to_owned();
    };
    let time = exact.over(cheapest).map(|ratio| data.ratio_text(&ratio));
    let bytes = exact.bytes.zip(cheapest.bytes);
    let bytes = bytes.filter(|(_, of)| *of > 0.0);
    let bytes = bytes.map(|(exact, of)| significant(exact / of));
    let excesses = exact.excesses(budget).into_iter();
    let excesses: Vec<String> = excesses.map(|(words, _)| format!("; {words}")).collect();
    format!(
        "Exact is {}: {} the time, {} × the bytes{}.",
        exact.name,
        time.unwrap_or_else(|| "an unknown multiple of".to_owned()),
        bytes.unwrap_or_else(|| "an unknown number".to_owned()),
        excesses.concat()
    )
}

/// Fills that were measured in all of these views.
fn fills<'a>(data: &Data<'a>, views: &[&View<'a>]) -> Vec<Fill<'a>> {
    let of_view = |view: &View<'a>| {
        let cases = view.cases.iter().copied().filter(|case| competes(case));
        cases.collect::<Vec<&'a Case>>()
    };
    let of_views: Vec<Vec<&Case>> = views.iter().map(|view| of_view(view)).collect();
    let names = distinct(of_views.iter().flatten().map(|case| label(case))).into_iter();
    let fills = names.filter_map(|name| {
        let own = of_views.iter().map(|cases| {
            let mut cases = cases.iter().copied();
            cases.find(|case| label(case) == name)
        });
        let cases: Vec<&Case> = own.collect::<Option<_>>()?;
        Fill::new(data, name, cases)
    });
    fills.collect()
}

/// Right, or approximate by nature, with a picture that was compared.
fn competes(case: &Case) -> bool {
    let is_point = has_role(case, "sweep") && !is_compared(case);
    let is_usable = if is_approximate(case) {
        matches!(case.outcome, Outcome::Ok | Outcome::Wrong)
    } else {
        case.counts()
    };
    !is_point && is_usable && case.value(MISMATCHED_PX).is_some()
}

/// By how many limits are exceeded, then by the largest factor, then by the error.
fn by_excess(a: &Fill<'_>, b: &Fill<'_>, budget: &Budget) -> Ordering {
    let key = |fill: &Fill<'_>| {
        let excesses = fill.excesses(budget);
        let largest = excesses.iter().map(|(_, factor)| *factor);
        (
            excesses.len(),
            largest.fold(0.0, f64::max),
            fill.error_px.unwrap_or(f64::INFINITY),
        )
    };
    let (a, b) = (key(a), key(b));
    let by_factor = a.1.total_cmp(&b.1);
    a.0.cmp(&b.0).then(by_factor).then(a.2.total_cmp(&b.2))
}

#[cfg(test)]
mod tests;
