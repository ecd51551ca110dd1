// SPDX-License-Identifier: MIT OR Apache-2.0
//! The answer: for each view the fastest, the smallest, the most exact and the recommended fill, what
//! follows from them in words, and which requirements are met.
//!
//! Everything is computed from the rows. A fill is a technique with its switches; it competes where its
//! picture is right and its time was measured.

use super::data::{Data, View, counter, distinct, has_role, is_approximate, is_baseline};
use super::table::{figures, main_table, none_differs, or_dash, row};
use super::{fronts, memory, needs, textured};
use crate::keys::*;
use terrafill_plot::dotted;
use terrafill_plot::number::{bytes, count, figure, significant, spread};
use terrafill_results::{
    Answers, Block, Case, Cell, ChapterError, Finding, Metric, Outcome, Spread, Table, TableLayout,
};

/// From so many regions in view on, their number decides.
const MANY_REGIONS: u32 = 50;
/// From so many stencil-tested fragments a vertex on, fill rate decides; a volume that covers the view
/// from near has thousands.
const MANY_FRAGMENTS: u32 = 1_000;
/// Up to so many, vertices decide: a triangle of this many fragments is smaller than a block of 4 × 4
/// pixels.
const FEW_FRAGMENTS: u32 = 16;
/// As many ties as a cell names.
const MAX_TIES: usize = 3;

/// Fills that compete in a view, each with its typical time, fastest first.
struct Contest<'d, 'a> {
    view: &'d View<'a>,
    fills: Vec<(&'a Case, f64)>,
}

impl Contest<'_, '_> {
    /// Every fill of a view draws the same regions; the first one that counted stands for all.
    fn counted(&self, metric: &Metric) -> Option<f64> {
        self.fills.iter().find_map(|(case, _)| case.value(metric))
    }

    fn fragments_a_vertex(&self) -> Option<f64> {
        let vertices = self.counted(VERTICES).filter(|vertices| *vertices > 0.0)?;
        Some(self.counted(STENCIL_FRAGMENTS)? / vertices)
    }
}

/// What the chapter offers for the first page.
pub(super) fn answers(data: &Data<'_>) -> Result<Answers, ChapterError> {
    let contests = data.views.iter().map(|view| {
        let timed = view.competing();
        let timed = timed.filter_map(|case| Some((case, data.typical(case)?.middle)));
        let mut fills: Vec<(&Case, f64)> = timed.collect();
        fills.sort_by(|a, b| a.1.total_cmp(&b.1));
        Contest { view, fills }
    });
    let contests: Vec<Contest<'_, '_>> = contests.collect();
    let mut blocks = Vec::new();
    if let Some(matrix) = matrix(data, &contests) {
        blocks.push(matrix);
        blocks.extend(fronts::block(data)?);
        blocks.extend(guide(data, &contests));
    }
    Ok(Answers {
        scope: scope(data).into_iter().collect(),
        blocks,
        requirements: requirements(data),
    })
}

/// Distance of the drawn boundary from the reference's and mismatched pixels: less is more exact.
fn error(case: &Case) -> Option<[f64; 2]> {
    let px = case.value(MISMATCHED_PX)?;
    // Without a boundary in the picture there is no distance.
    Some([case.value(HAUSDORFF_PX).unwrap_or(0.0), px])
}

/// The winners of a view, out of its candidates, fastest first.
struct Winners<'a> {
    fastest: &'a Case,
    ties: Vec<&'a Case>,
    smallest: Option<&'a Case>,
    most_exact: Option<&'a Case>,
    recommended: &'a Case,
}

fn winners<'a>(data: &Data<'a>, contest: &Contest<'_, 'a>) -> Option<Winners<'a>> {
    let cases = || contest.fills.iter().map(|(case, _)| *case);
    let fastest = cases().next()?;
    let ties = cases().skip(1).filter(|case| data.ties_with(case, fastest));
    let ties: Vec<&Case> = ties.collect();
    // The first of several is the fastest of them.
    let sized = |case: &&'a Case| counter(case, GEOMETRY_BYTES).unwrap_or(u64::MAX);
    let smallest = cases().filter(|case| counter(case, GEOMETRY_BYTES).is_some());
    let exact = cases().filter_map(|case| Some((case, error(case)?)));
    let by_error = |a: &[f64; 2], b: &[f64; 2]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]));
    let most_exact = exact.min_by(|a, b| by_error(&a.1, &b.1));
    let close = std::iter::once(fastest).chain(ties.iter().copied());
    Some(Winners {
        smallest: smallest.min_by_key(sized),
        most_exact: most_exact.map(|(case, _)| case),
        recommended: close.min_by_key(sized).unwrap_or(fastest),
        fastest,
        ties,
    })
}

fn matrix(data: &Data<'_>, contests: &[Contest<'_, '_>]) -> Option<Block> {
    let rows = contests.iter().filter_map(|contest| {
        let (view, winners) = (contest.view, winners(data, contest)?);
        let cell = |case: Option<&Case>| match case {
            Some(case) => winner(data, case),
            None => Cell::absent("no fill of this view has such a figure"),
        };
        let cases = || view.cases.iter();
        let all = cases().filter(|case| !has_role(case, "sweep") && !is_approximate(case));
        let picture = cases().map(|case| case.note("reference_image")).max();
        let name = Cell {
            detail: format!("{} of {} fills right", contest.fills.len(), all.count()),
            picture: picture.unwrap_or_default().to_owned(),
            section: view.scene.to_owned(),
            ..Cell::name(view.title())
        };
        let cells = [
            cell(Some(winners.recommended)),
            cell(Some(winners.fastest)),
            ties(data, &winners.ties),
            cell(winners.smallest),
            cell(winners.most_exact),
        ];
        Some(row(name, cells))
    });
    let headings = [
        ("scene, view", ""),
        (
            "recommended",
            "of the fastest fill and its ties, the one with the fewest bytes of geometry",
        ),
        ("fastest", ""),
        (
            "ties",
            "fills that differ from the fastest by no more than identical work did",
        ),
        (
            "smallest",
            "fewest bytes of geometry; of several the fastest",
        ),
        (
            "most exact",
            "least boundary distance, then fewest mismatched pixels; of several the fastest",
        ),
    ];
    let caption = format!(
        "Every view with its best fills. A cell: technique, {} with its [95 % interval], or (5–95 % of samples) \
         where there are too few processes, bytes of geometry, Hausdorff distance of the boundary from the \
         reference's, by how much levels of detail moved it, and mismatched pixels. Point at a cell for the \
         command that draws it.",
        data.unit(),
    );
    main_table(Table {
        caption,
        layout: TableLayout::Cards,
        ..figures(&headings, rows.collect())
    })
}

fn winner(data: &Data<'_>, case: &Case) -> Cell {
    let time = match data.typical(case) {
        Some(time) if time.interval.is_some() => figure(&time),
        // The figure that ranks it, among its samples.
        time => {
            let samples = data.time(case).zip(time).map(|(samples, time)| Spread {
                median: time.middle,
                ..samples
            });
            samples.map_or_else(String::new, spread)
        }
    };
    let size = counter(case, GEOMETRY_BYTES).map_or_else(|| "bytes unknown".to_owned(), bytes);
    let wrong = counter(case, MISMATCHED_PX).map(count);
    let distance = case.value(HAUSDORFF_PX).map(significant);
    let moved = case.value(BOUNDARY_MOVED_PX);
    let moved = moved.map_or_else(String::new, |px| format!(" (moved {})", significant(px)));
    let cell = Cell {
        detail: format!(
            "{time} ms · {size} · boundary {} px{moved}, {} px differ",
            or_dash(distance),
            or_dash(wrong),
        ),
        ..data.name_cell(case, data.label(case))
    };
    dotted(cell, case, data.metric)
}

fn ties(data: &Data<'_>, ties: &[&Case]) -> Cell {
    if data.noise.is_none() {
        return Cell::absent("no identical work was measured twice");
    }
    let names: Vec<String> = ties.iter().map(|case| data.label(case)).collect();
    let shown = names.iter().take(MAX_TIES).cloned().collect::<Vec<_>>();
    match names.len() {
        0 => Cell::name("none"),
        all if all <= MAX_TIES => Cell::name(shown.join("; ")),
        all => Cell {
            detail: format!("and {} more", all - MAX_TIES),
            title: names.join("; "),
            ..Cell::name(shown.join("; "))
        },
    }
}

/// A fill that is right in all of some views: geometric mean and maximum of its time over each view's best.
struct Ranked {
    name: String,
    mean: f64,
    most: f64,
}

/// By the mean of how much longer they take than the best.
fn ranked(data: &Data<'_>, contests: &[&Contest<'_, '_>]) -> Vec<Ranked> {
    let named = contests.iter().map(|contest| {
        let fills = contest.fills.iter();
        fills.map(|(case, _)| (data.label(case), *case)).collect()
    });
    let named: Vec<Vec<(String, &Case)>> = named.collect();
    let names = distinct(named.iter().flatten().map(|(name, _)| name)).into_iter();
    let of = |name: &String| {
        let ratios = named.iter().map(|fills| {
            let (_, best) = fills.first()?;
            let (_, own) = fills.iter().find(|(own, _)| own == name)?;
            Some(data.over_fastest(own, best)?.middle)
        });
        let ratios: Vec<f64> = ratios.collect::<Option<_>>()?;
        Some(Ranked {
            name: name.clone(),
            mean: geometric_mean(&ratios),
            most: ratios.iter().copied().fold(0.0, f64::max),
        })
    };
    let mut ranked: Vec<Ranked> = names.filter_map(of).collect();
    ranked.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    ranked
}

fn geometric_mean(values: &[f64]) -> f64 {
    let logs = values.iter().map(|value| value.ln()).sum::<f64>();
    (logs / values.len() as f64).exp()
}

/// What to take when, in words. Kinds of views are found by what their fills count.
fn guide(data: &Data<'_>, contests: &[Contest<'_, '_>]) -> Vec<Block> {
    let [regions, many, few] = [MANY_REGIONS, MANY_FRAGMENTS, FEW_FRAGMENTS];
    let [regions_text, many_text, few_text] = [regions, many, few].map(|n| count(n.into()));
    let advice = |kind: String, is_it: &dyn Fn(&Contest<'_, '_>) -> Option<bool>| {
        let own = contests.iter().filter(|view| is_it(view) == Some(true));
        let own: Vec<&Contest<'_, '_>> = own.collect();
        advised(data, &kind, &own)
    };
    let by_time = [
        advice(
            format!("Many regions in view (from {regions_text} on)"),
            &|view| Some(view.counted(REGIONS_DRAWN)? >= regions.into()),
        ),
        advice(
            format!(
                "Eye near, fill rate is the limit (from {many_text} stencil-tested fragments a vertex on)"
            ),
            &|view| Some(view.fragments_a_vertex()? >= many.into()),
        ),
        advice(
            format!("Eye far, vertices are the limit (at most {few_text} fragments a vertex)"),
            &|view| Some(view.fragments_a_vertex()? <= few.into()),
        ),
        advice("Over all views".to_owned(), &|_| Some(true)),
    ];
    let all: Vec<&Contest<'_, '_>> = contests.iter().collect();
    let ranked = ranked(data, &all);
    let lines = by_time.into_iter().chain([
        memory_advice(data, contests, &ranked),
        exact_advice(data, &ranked),
    ]);
    let lines: Vec<String> = lines.flatten().collect();
    match lines.is_empty() {
        true => Vec::new(),
        false => vec![Block::section("What to take"), Block::List(lines)],
    }
}

/// `kind → fill`, with what it costs beside the best and what ties with it.
fn advised(data: &Data<'_>, kind: &str, contests: &[&Contest<'_, '_>]) -> Option<String> {
    let ranked = ranked(data, contests);
    let best = ranked.first()?;
    let is_tie = |other: &&Ranked| {
        let noise = data.noise;
        noise.is_some_and(|noise| noise.is_tie(other.mean / best.mean))
    };
    let ties = ranked.iter().skip(1).take_while(is_tie);
    let ties: Vec<&str> = ties.map(|fill| fill.name.as_str()).collect();
    let views = match contests {
        [only] => only.view.title(),
        several => format!("{} views", several.len()),
    };
    let shown = ties[..ties.len().min(MAX_TIES)].join(", ");
    let ties = match ties.len() {
        0 => String::new(),
        some if some <= MAX_TIES => format!("; ties: {shown}"),
        some => format!("; ties: {shown} and {} more", some - MAX_TIES),
    };
    Some(format!(
        "{kind} → {}: {views}, {} × the best of each on average, {} × at most{ties}.",
        best.name,
        significant(best.mean),
        significant(best.most),
    ))
}

/// The fill that holds least on average over views, and what that costs in time.
fn memory_advice(
    data: &Data<'_>,
    contests: &[Contest<'_, '_>],
    ranked: &[Ranked],
) -> Option<String> {
    let held = |fill: &Ranked| -> Option<f64> {
        let fills = contests.iter().flat_map(|contest| &contest.fills);
        let own = fills.filter(|(case, _)| data.label(case) == fill.name);
        let bytes = own.filter_map(|(case, _)| case.value(GEOMETRY_BYTES));
        let bytes: Vec<f64> = bytes.filter(|bytes| *bytes > 0.0).collect();
        (!bytes.is_empty()).then(|| geometric_mean(&bytes))
    };
    let sized = ranked.iter().filter_map(|fill| Some((fill, held(fill)?)));
    let sized: Vec<(&Ranked, f64)> = sized.collect();
    // The first of several is the fastest.
    let (smallest, least) = sized.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (_, fastest) = sized.first()?;
    Some(format!(
        "Memory is short → {}: {} × the bytes of the fastest fill on average, at {} × the time of the best of \
         each view.",
        smallest.name,
        significant(least / fastest),
        significant(smallest.mean),
    ))
}

/// The fastest fill that moves no boundary on purpose, where another one is faster.
fn exact_advice(data: &Data<'_>, ranked: &[Ranked]) -> Option<String> {
    let moves = |fill: &Ranked| {
        let mut cases = data.views.iter().flat_map(|view| &view.cases);
        cases.any(|case| case.value(BOUNDARY_MOVED_PX).is_some() && data.label(case) == fill.name)
    };
    let exact = ranked.iter().find(|fill| !moves(fill))?;
    moves(ranked.first()?).then(|| {
        format!(
            "Boundaries must not move at all → {}: {} × the best of each view on average, {} × at most.",
            exact.name,
            significant(exact.mean),
            significant(exact.most),
        )
    })
}

/// Which pictures were compared, in exact numbers; `None` for a run that drew none.
pub(super) fn scope(data: &Data<'_>) -> Option<String> {
    let drawn = data.cases.iter().filter(|case| !is_baseline(case));
    let counted = |is_it: fn(&Case) -> bool| {
        let own = drawn.clone().filter(|case| is_it(case));
        own.count() as u64
    };
    let exceptions = [
        (
            counted(|case| case.planned.may_be_wrong && !is_approximate(case)),
            "of sweeps, whose error is the question",
        ),
        (counted(is_approximate), "approximate by nature"),
        (
            counted(|case| case.outcome == Outcome::DriverFault),
            "with a known driver fault",
        ),
    ];
    let some = exceptions.iter().filter(|(number, _)| *number > 0);
    let some: Vec<String> = some
        .map(|(number, what)| format!("{} {what}", count(*number)))
        .collect();
    let (exceptions, others) = match some.is_empty() {
        true => (String::new(), ""),
        false => (format!(" ({})", some.join(", ")), " of the others"),
    };
    let wrong = match wrong(data) {
        0 => "none".to_owned(),
        some => count(some as u64),
    };
    let all = counted(|_| true);
    (all > 0).then(|| {
        format!(
            "{} of {} pictures compared with the reference{exceptions}. Wrong outside the 1-pixel boundary \
             band: {wrong}{others}.",
            count(counted(|case| case.value(MISMATCHED_PX_OUTSIDE_BAND).is_some())),
            count(all),
        )
    })
}

/// Compared pictures that do not match, those aside whose error is the question or a known fault.
pub(super) fn wrong(data: &Data<'_>) -> usize {
    let differs = |case: &&&Case| {
        let outside = case.value(MISMATCHED_PX_OUTSIDE_BAND);
        !case.planned.may_be_wrong
            && case.outcome != Outcome::DriverFault
            && !is_baseline(case)
            && outside.is_some_and(|px| px > 0.0 || case.outcome == Outcome::Wrong)
    };
    data.cases.iter().filter(differs).count()
}

fn requirements(data: &Data<'_>) -> Vec<Finding> {
    if data.cases.is_empty() {
        return Vec::new();
    }
    let mut requirements = vec![pictures(data)];
    requirements.extend(memory::requirement(data));
    requirements.extend(needs::requirement(data));
    requirements.extend(textured::requirements(data));
    requirements
}

/// No picture has a wrong pixel outside the band, those aside whose error is the question.
fn pictures(data: &Data<'_>) -> Finding {
    let own = data.cases.iter();
    let own = own.filter(|case| !case.planned.may_be_wrong && !is_baseline(case));
    let outside = own.filter_map(|case| case.value(MISMATCHED_PX_OUTSIDE_BAND));
    let outside: Vec<f64> = outside.collect();
    let wrong = outside.iter().filter(|px| **px > 0.0).count();
    let claim = "No picture has a wrong pixel outside the 1-pixel boundary band.";
    none_differs(claim, outside.len(), wrong, "pictures have none")
}
