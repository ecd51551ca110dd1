// SPDX-License-Identifier: MIT OR Apache-2.0
//! The answer: for each view the fastest, the smallest, the most exact and the recommended fill, what
//! follows from them in words, and which requirements are met.
//!
//! Everything is computed from the rows. A fill is a technique with its switches; it competes where its
//! picture is right and its time was measured.

use super::data::{Data, View, competes, counter, distinct, has_role, is_approximate};
use super::{fronts, memory, needs, textured};
use crate::keys::{
    BOUNDARY_MOVED_PX, GEOMETRY_BYTES, HAUSDORFF_PX, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND,
    REGIONS_DRAWN, STENCIL_FRAGMENTS, VERTICES,
};
use terrafill_plot::number::{bytes, count, figure, significant, spread};
use terrafill_plot::{Palette, dotted};
use terrafill_results::{
    Answers, Block, Case, Cell, ChapterError, Finding, Heading, Metric, Row, Spread, Standing,
    Table, TableLayout, typical,
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

/// What the chapter offers for the first page.
pub(super) fn answers(data: &Data<'_>) -> Result<Answers, ChapterError> {
    let mut blocks = Vec::new();
    if let Some(matrix) = matrix(data) {
        blocks.push(matrix);
        blocks.extend(fronts::block(data)?);
        blocks.extend(guide(data));
    }
    Ok(Answers {
        scope: scope(data).into_iter().collect(),
        blocks,
        requirements: requirements(data),
    })
}

/// Fills that compete in a view, each with its typical time, fastest first.
fn candidates<'a>(data: &Data<'a>, view: &View<'a>) -> Vec<(&'a Case, f64)> {
    let timed = view.cases.iter().filter_map(|case| {
        let time = data.typical(case).filter(|_| competes(case))?;
        Some((*case, time.middle))
    });
    let mut timed: Vec<(&Case, f64)> = timed.collect();
    timed.sort_by(|a, b| a.1.total_cmp(&b.1));
    timed
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

fn winners<'a>(data: &Data<'a>, candidates: &[(&'a Case, f64)]) -> Option<Winners<'a>> {
    let cases = || candidates.iter().map(|(case, _)| *case);
    let fastest = cases().next()?;
    let ties = cases().skip(1).filter(|case| data.ties_with(case, fastest));
    let ties: Vec<&Case> = ties.collect();
    // The first of several is the fastest of them.
    let sized = |case: &&'a Case| counter(case, GEOMETRY_BYTES).unwrap_or(u64::MAX);
    let smallest = cases().filter(|case| counter(case, GEOMETRY_BYTES).is_some());
    let exact = cases().filter_map(|case| Some((case, error(case)?)));
    let by_error = |a: &[f64; 2], b: &[f64; 2]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]));
    let close = std::iter::once(fastest).chain(ties.iter().copied());
    Some(Winners {
        smallest: smallest.min_by_key(sized),
        most_exact: exact
            .min_by(|a, b| by_error(&a.1, &b.1))
            .map(|(case, _)| case),
        recommended: close.min_by_key(sized).unwrap_or(fastest),
        fastest,
        ties,
    })
}

fn matrix(data: &Data<'_>) -> Option<Block> {
    let palette = Palette::new(data.all_series());
    let mut rows = Vec::new();
    for scene in data.scenes() {
        for view in &scene.views {
            let candidates = candidates(data, view);
            let Some(winners) = winners(data, &candidates) else {
                continue;
            };
            let cell = |case: Option<&Case>| match case {
                Some(case) => winner(data, &palette, case),
                None => Cell::absent("no fill of this view has such a figure"),
            };
            let picture = view.cases.iter().map(|case| case.note("reference_image"));
            rows.push(Row::new(vec![
                Cell {
                    detail: format!(
                        "{} of {} fills right",
                        candidates.len(),
                        view.cases
                            .iter()
                            .filter(|case| !has_role(case, "sweep") && !is_approximate(case))
                            .count()
                    ),
                    picture: picture.max().unwrap_or_default().to_owned(),
                    section: scene.name.to_owned(),
                    ..Cell::name(format!("{}, {}", scene.name, view.name))
                },
                cell(Some(winners.recommended)),
                cell(Some(winners.fastest)),
                ties(data, &winners.ties),
                cell(winners.smallest),
                cell(winners.most_exact),
            ]));
        }
    }
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "Every view with its best fills. A cell: technique, {} with {}, bytes of geometry, \
                 Hausdorff distance of the boundary from the reference's, by how much levels of detail \
                 moved it, and mismatched pixels. Point at a cell for the command that draws it.",
                data.unit(),
                brackets(data)
            ),
            headings: vec![
                Heading::plain("scene, view"),
                Heading::explained(
                    "recommended",
                    "of the fastest fill and its ties, the one with the fewest bytes of geometry",
                ),
                Heading::plain("fastest"),
                Heading::explained(
                    "ties",
                    "fills that differ from the fastest by no more than identical work did",
                ),
                Heading::explained("smallest", "fewest bytes of geometry; of several the fastest"),
                Heading::explained(
                    "most exact",
                    "least boundary distance, then fewest mismatched pixels; of several the fastest",
                ),
            ],
            rows,
            is_main: true,
            layout: TableLayout::Cards,
        })
    })
}

/// What the brackets after a time are.
fn brackets(data: &Data<'_>) -> &'static str {
    let has_interval =
        |case: &&Case| typical(case, data.metric).is_some_and(|time| time.interval.is_some());
    match data.cases.iter().any(has_interval) {
        true => "its [95 % interval]",
        false => "(5–95 % of samples), since too few processes give no interval",
    }
}

fn winner(data: &Data<'_>, palette: &Palette, case: &Case) -> Cell {
    let time = match typical(case, data.metric) {
        Some(time) if time.interval.is_some() => figure(&time),
        // The figure that ranks it, among its samples.
        time => {
            let samples = data.time(case).zip(time);
            let samples = samples.map(|(samples, time)| Spread {
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
            distance.as_deref().unwrap_or("–"),
            wrong.as_deref().unwrap_or("–"),
        ),
        marker: palette.marker(&data.marked(case)),
        command: data.command(case),
        ..Cell::name(data.label(case))
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

/// What the rows say for one kind of view.
struct Advice {
    kind: String,
    /// Titles of the views.
    views: Vec<String>,
    /// Each fill that is right in all of them: geometric mean and maximum of its ratio to the best.
    ranked: Vec<(String, f64, f64)>,
}

/// Fills in these views, by the mean of how much longer they take than the best.
fn ranked(data: &Data<'_>, views: &[&View<'_>]) -> Vec<(String, f64, f64)> {
    let all = views.iter().map(|view| candidates(data, view));
    let all: Vec<Vec<(&Case, f64)>> = all.collect();
    let names = all.iter().flatten().map(|(case, _)| data.label(case));
    let mut ranked = Vec::new();
    for name in distinct(names) {
        let ratios = all.iter().filter_map(|candidates| {
            let (best, _) = candidates.first()?;
            let (own, _) = candidates
                .iter()
                .find(|(case, _)| data.label(case) == name)?;
            Some(data.over_fastest(own, best)?.middle)
        });
        let ratios: Vec<f64> = ratios.collect();
        if ratios.len() == views.len() {
            let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
            let most = ratios.iter().copied().fold(0.0, f64::max);
            ranked.push((name, mean.exp(), most));
        }
    }
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    ranked
}

/// What to take when, in words. Kinds of views are found by what their fills count.
fn guide(data: &Data<'_>) -> Vec<Block> {
    let scenes = data.scenes();
    let views = || {
        let of_scene = |scene: &'_ super::data::Scene<'_>| scene.name.to_owned();
        scenes
            .iter()
            .flat_map(move |scene| scene.views.iter().map(move |view| (of_scene(scene), view)))
    };
    // Every fill of a view draws the same regions; the first one that counted stands for all.
    let counted = |view: &View<'_>, metric: &Metric| {
        let all = candidates(data, view);
        all.iter().find_map(|(case, _)| case.value(metric))
    };
    let fragments_a_vertex = |view: &View<'_>| {
        let (fragments, vertices) = (counted(view, STENCIL_FRAGMENTS)?, counted(view, VERTICES)?);
        (vertices > 0.0).then(|| fragments / vertices)
    };
    let advice = |kind: String, is_it: &dyn Fn(&View<'_>) -> bool| {
        let own: Vec<(String, &View<'_>)> = views().filter(|(_, view)| is_it(view)).collect();
        Advice {
            kind,
            ranked: ranked(data, &own.iter().map(|(_, view)| *view).collect::<Vec<_>>()),
            views: own
                .iter()
                .map(|(scene, view)| format!("{scene}, {}", view.name))
                .collect(),
        }
    };
    let by_time = [
        advice(
            format!(
                "Many regions in view (from {} on)",
                count(MANY_REGIONS.into())
            ),
            &|view| counted(view, REGIONS_DRAWN).is_some_and(|n| n >= MANY_REGIONS.into()),
        ),
        advice(
            format!(
                "Eye near, fill rate is the limit (from {} stencil-tested fragments a vertex on)",
                count(MANY_FRAGMENTS.into())
            ),
            &|view| fragments_a_vertex(view).is_some_and(|n| n >= MANY_FRAGMENTS.into()),
        ),
        advice(
            format!(
                "Eye far, vertices are the limit (at most {} fragments a vertex)",
                count(FEW_FRAGMENTS.into())
            ),
            &|view| fragments_a_vertex(view).is_some_and(|n| n <= FEW_FRAGMENTS.into()),
        ),
        advice("Over all views".to_owned(), &|_| true),
    ];
    let mut lines: Vec<String> = by_time
        .iter()
        .filter_map(|advice| advised(data, advice))
        .collect();
    lines.extend(memory_advice(data));
    lines.extend(exact_advice(data));
    match lines.is_empty() {
        true => Vec::new(),
        false => vec![
            Block::Heading {
                level: 3,
                text: "What to take".to_owned(),
            },
            Block::List(lines),
        ],
    }
}

/// `kind → fill`, with what it costs beside the best and what ties with it.
fn advised(data: &Data<'_>, advice: &Advice) -> Option<String> {
    let (name, mean, most) = advice.ranked.first()?;
    let ties = advice.ranked.iter().skip(1).take_while(|(_, other, _)| {
        let noise = data.noise;
        noise.is_some_and(|noise| noise.is_tie(other / mean))
    });
    let ties: Vec<&str> = ties.map(|(name, ..)| name.as_str()).collect();
    let views = match advice.views.as_slice() {
        [only] => only.clone(),
        several => format!("{} views", several.len()),
    };
    let ties = match ties.len() {
        0 => String::new(),
        some if some <= MAX_TIES => format!("; ties: {}", ties.join(", ")),
        some => format!(
            "; ties: {} and {} more",
            ties[..MAX_TIES].join(", "),
            some - MAX_TIES
        ),
    };
    Some(format!(
        "{} → {name}: {views}, {} × the best of each on average, {} × at most{ties}.",
        advice.kind,
        significant(*mean),
        significant(*most),
    ))
}

/// The fill that holds least on average over scenes, and what that costs in time.
fn memory_advice(data: &Data<'_>) -> Option<String> {
    let scenes = data.scenes();
    let views: Vec<&View<'_>> = scenes.iter().flat_map(|scene| &scene.views).collect();
    let all = ranked(data, &views);
    let held = |name: &str| -> Option<f64> {
        let cases = views.iter().flat_map(|view| candidates(data, view));
        let own = cases.filter(|(case, _)| data.label(case) == name);
        let bytes: Vec<f64> = own
            .filter_map(|(case, _)| case.value(GEOMETRY_BYTES))
            .filter(|bytes| *bytes > 0.0)
            .collect();
        let logs: f64 = bytes.iter().map(|bytes| bytes.ln()).sum();
        (!bytes.is_empty()).then(|| (logs / bytes.len() as f64).exp())
    };
    let sized = all.iter().filter_map(|fill| Some((fill, held(&fill.0)?)));
    let sized: Vec<_> = sized.collect();
    // The first of several is the fastest.
    let ((name, mean, _), least) = sized.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (_, fastest) = sized.first()?;
    Some(format!(
        "Memory is short → {name}: {} × the bytes of the fastest fill on average, at {} × the time of \
         the best of each view.",
        significant(least / fastest),
        significant(*mean),
    ))
}

/// The fastest fill that moves no boundary on purpose, where another one is faster.
fn exact_advice(data: &Data<'_>) -> Option<String> {
    let scenes = data.scenes();
    let views: Vec<&View<'_>> = scenes.iter().flat_map(|scene| &scene.views).collect();
    let all = ranked(data, &views);
    let moves = |name: &str| {
        let mut cases = views.iter().flat_map(|view| &view.cases);
        cases.any(|case| data.label(case) == name && case.value(BOUNDARY_MOVED_PX).is_some())
    };
    let (fastest, ..) = all.first()?;
    if !moves(fastest) {
        return None;
    }
    let (name, mean, most) = all.iter().find(|(name, ..)| !moves(name))?;
    Some(format!(
        "Boundaries must not move at all → {name}: {} × the best of each view on average, {} × at most.",
        significant(*mean),
        significant(*most),
    ))
}

/// Which pictures were compared, in exact numbers.
fn scope(data: &Data<'_>) -> Option<String> {
    let drawn = data.cases.iter().filter(|case| !super::is_baseline(case));
    let drawn: Vec<&&Case> = drawn.collect();
    if drawn.is_empty() {
        return None;
    }
    let outside = |case: &&&&Case| counter(case, MISMATCHED_PX_OUTSIDE_BAND);
    let compared = drawn.iter().filter(|case| outside(case).is_some());
    let meant = drawn.iter().filter(|case| case.planned.may_be_wrong);
    let compared: Vec<_> = compared.collect();
    let is_fault = |case: &Case| case.outcome == super::Outcome::DriverFault;
    let faults = drawn.iter().filter(|case| is_fault(case)).count();
    let must_match = compared
        .iter()
        .filter(|case| !case.planned.may_be_wrong && !is_fault(case));
    let wrong = must_match
        .filter(|case| outside(case) != Some(0) || case.outcome == super::Outcome::Wrong)
        .count();
    let approximate = meant.clone().filter(|case| is_approximate(case)).count() as u64;
    let points = meant.count() as u64 - approximate;
    let meant = points + approximate;
    Some(format!(
        "{} of {} pictures compared with the reference; {}{}. {}",
        count(compared.len() as u64),
        count(drawn.len() as u64),
        match (points, approximate) {
            (0, 0) => "none is meant to be wrong".to_owned(),
            (1, 0) => "1 sweep point may be wrong: its error is the question".to_owned(),
            (some, 0) => format!(
                "{} sweep points may be wrong: their error is the question",
                count(some)
            ),
            (0, some) => format!("{} approximate: their error is the question", count(some)),
            (some, more) => format!(
                "{} sweep points may be wrong and {} are approximate: their error is the question",
                count(some),
                count(more)
            ),
        },
        match faults {
            0 => String::new(),
            some => format!("; {some} differ by a known driver fault"),
        },
        match wrong {
            0 if meant == 0 && faults == 0 =>
                "All match outside the 1-pixel boundary band.".to_owned(),
            0 => "All others match outside the 1-pixel boundary band.".to_owned(),
            1 => "1 of the others does not match outside the 1-pixel boundary band.".to_owned(),
            some => format!(
                "{} of the others do not match outside the 1-pixel boundary band.",
                count(some as u64)
            ),
        }
    ))
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
    let own = data
        .cases
        .iter()
        .filter(|case| !case.planned.may_be_wrong && !super::is_baseline(case));
    let outside = own.filter_map(|case| case.value(MISMATCHED_PX_OUTSIDE_BAND));
    let outside: Vec<f64> = outside.collect();
    let wrong = outside.iter().filter(|px| **px > 0.0).count();
    Finding {
        claim: "No picture has a wrong pixel outside the 1-pixel boundary band.".to_owned(),
        standing: match outside.len() {
            0 => Standing::NotMeasured,
            _ => Standing::holds_if(wrong == 0),
        },
        because: format!(
            "{} of {} pictures have none",
            count((outside.len() - wrong) as u64),
            count(outside.len() as u64)
        ),
    }
}
