// SPDX-License-Identifier: MIT OR Apache-2.0
//! The answer in a sentence, its price in a few lines, and one picture. The sentence says what to take and how far off the
//! best it is. The lines say what it holds, how its pictures differ, what exact boundaries cost, how sure all that is,
//! and what is as good or next best.

use super::contest::{Contest, Ranked, ranked, tied};
use super::data::{Data, label, layout_name};
use crate::keys::{GEOMETRY_BYTES, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND};
use crate::purpose::is_approximate;
use terrafill_lab::{in_every_group, some_of};
use terrafill_plot::number::{digits, measured_bytes, significant};
use terrafill_plot::{RatioAxis, RatioGroup, RatioPlot, RatioRow};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{Block, Case, ChapterError, Estimate, Spread, median, typical};

/// All three; nothing of a view without a fill that is right and timed.
pub(super) fn blocks<'a>(
    data: &Data<'a>,
    contests: &[Contest<'_, 'a>],
) -> Result<Vec<Block>, ChapterError> {
    let contested = contests.iter().filter(|contest| !contest.fills.is_empty());
    let contested: Vec<&Contest<'_, '_>> = contested.collect();
    let ranked = ranked(data, &contested);
    let mut blocks = answer(data, &ranked, contested.len());
    blocks.extend(picture(data, &contested, &ranked)?);
    Ok(blocks)
}

/// The sentence and the lines.
fn answer(data: &Data<'_>, ranked: &[Ranked<'_>], views: usize) -> Vec<Block> {
    let ties = tied(data, ranked);
    let Some(best) = least_geometry(ties) else {
        let none = format!(
            "No fill is right and timed in all {views} views; the table says which is the best of each."
        );
        return vec![Block::Lead(none)];
    };
    let lines = [
        times(data, best),
        Some(held(best)),
        Some(pictures(best)),
        exactness(best, ranked),
        Some(sureness(data, best)),
        next(best, ranked, ties),
        software(data),
        shown(data, best),
    ];
    vec![
        Block::Lead(
            unseparated(data, best, ranked, ties).unwrap_or_else(|| taken(data, best, ties)),
        ),
        Block::List(lines.into_iter().flatten().collect()),
    ]
}

/// Of fills that tie the one whose geometry takes the fewest bytes, as in each view; of several the fastest.
fn least_geometry<'r, 'a>(ties: &'r [Ranked<'a>]) -> Option<&'r Ranked<'a>> {
    let bytes = |fill: &Ranked<'_>| fill.most_of(GEOMETRY_BYTES).unwrap_or(f64::INFINITY);
    ties.iter().min_by(|a, b| bytes(a).total_cmp(&bytes(b)))
}

/// Every fill of all views, and approximate ones, by how much longer they take than the fastest right one of each view.
fn picture(
    data: &Data<'_>,
    contested: &[&Contest<'_, '_>],
    ranked: &[Ranked<'_>],
) -> Result<Option<Block>, ChapterError> {
    let right = ranked.iter().map(|fill| {
        let held = fill
            .held_bytes()
            .map_or_else(String::new, |bytes| format!(", {}", measured_bytes(bytes)));
        let value = format!(", {} × at most{held}", significant(fill.most));
        row(data, fill.name.clone(), &fill.cases, &fill.ratios, value)
    });
    let approximate = approximate(data, contested);
    let has_approximate = !approximate.is_empty();
    let mut rows: Vec<RatioRow> = right.chain(approximate).collect();
    let place = |row: &RatioRow| data.palette().place(&row.series);
    rows.sort_by(|a, b| (place(a), &a.label).cmp(&(place(b), &b.label)));
    let title = format!(
        "{} ÷ those of the view's fastest right fill (logarithmic)",
        data.timings.unit()
    );
    let plot = RatioPlot {
        title: "time over the fastest, over all views".to_owned(),
        axis: RatioAxis {
            title: &title,
            one: "fastest = 1",
        },
        dots: "small dots: one for each view",
        tie_factor: data.timings.noise.map(|noise| noise.max_factor()),
        groups: vec![RatioGroup {
            name: match contested.len() {
                1 => "1 view".to_owned(),
                views => format!("{views} views"),
            },
            dashed: None,
            rows,
        }],
    };
    let noise = match plot.tie_factor {
        Some(_) => " Grey: by how much the same work measured twice differed.",
        None => "",
    };
    let off = if has_approximate {
        " Approximate fills are shown with their wrong pixels, all views together."
    } else {
        ""
    };
    let caption = format!(
        "How much longer each fill takes than the fastest of its view, where it is right and timed in every view. Left is \
         better. The mark is the geometric mean over the views. The line goes from the least to the most of them and is \
         no error bar. On the right: the mean, the most, and the bytes that it holds on the device where they are \
         most.{noise}{off}"
    );
    Ok(Block::plot(caption, plot.draw(data.palette())?))
}

/// Fills that are off by nature, timed in every view.
fn approximate<'a>(data: &Data<'a>, contested: &[&Contest<'_, 'a>]) -> Vec<RatioRow> {
    let of_view = |contest: &&Contest<'_, 'a>| -> Vec<&'a Case> {
        let cases = contest.view.cases.iter().copied();
        cases.filter(|case| is_approximate(case)).collect()
    };
    let fills =
        in_every_group(&contested.iter().map(of_view).collect::<Vec<_>>(), label).into_iter();
    let rows = fills.filter_map(|(name, cases)| {
        let time = |case: &Case| Some(typical(case, data.timings.metric)?.middle);
        let ratios = contested.iter().zip(&cases);
        let ratios =
            ratios.map(|(contest, case)| Some(time(case)? / time(contest.fills.first()?)?));
        let ratios: Vec<f64> = ratios.collect::<Option<_>>()?;
        let wrong = cases
            .iter()
            .map(|case| case.value(MISMATCHED_PX_OUTSIDE_BAND));
        let wrong = format!(", {} px wrong", digits(wrong.sum::<Option<f64>>()?));
        Some(row(data, name, &cases, &ratios, wrong))
    });
    rows.collect()
}

fn row(data: &Data<'_>, label: String, cases: &[&Case], ratios: &[f64], value: String) -> RatioRow {
    let logs = ratios.iter().map(|ratio| ratio.ln());
    RatioRow {
        label,
        series: cases
            .first()
            .map_or_else(String::new, |case| data.marked(case)),
        ratio: Ok(Spread {
            p5: ratios.iter().copied().fold(f64::INFINITY, f64::min),
            median: (logs.sum::<f64>() / ratios.len() as f64).exp(),
            p95: ratios.iter().copied().fold(0.0, f64::max),
        }),
        processes: ratios.to_vec(),
        value,
        command: cases
            .first()
            .map_or_else(String::new, |case| data.command(case)),
    }
}

/// How far off the fastest it is over all views, and in how many it is the fastest or ties with it.
fn taken(data: &Data<'_>, best: &Ranked<'_>, ties: &[Ranked<'_>]) -> String {
    let is_first = |ratio: &&f64| **ratio <= 1.0 || data.timings.is_tie(**ratio);
    let (first, all) = (
        best.ratios.iter().filter(is_first).count(),
        best.ratios.len(),
    );
    let views = match (first, all) {
        (1, 1) => "the fastest of its view, or tied".to_owned(),
        _ if first == all => format!("fastest or tied in all {all} views"),
        _ => format!(
            "over {all} views {} × the time of each view's fastest on average{}, {} × at most; fastest or tied in {first}",
            significant(best.mean),
            if ties.len() > 1 {
                ""
            } else {
                ", the least of all"
            },
            significant(best.most)
        ),
    };
    let of_ties = match ties.len() {
        0 | 1 => "",
        _ => " Of the fills that tie with it on average it has the fewest bytes.",
    };
    format!("Take {}: {views}.{of_ties}", best.name)
}

/// That times decide nothing, where they do not: every fill that is right in all views ties.
fn unseparated(
    data: &Data<'_>,
    best: &Ranked<'_>,
    ranked: &[Ranked<'_>],
    ties: &[Ranked<'_>],
) -> Option<String> {
    let noise = data.timings.noise?;
    (ties.len() > 1 && ties.len() == ranked.len()).then(|| {
        format!(
            "No fill is proven faster: on average the {} that are right in every view differ by less than the same work \
             measured twice, which differed by up to {} %. Take {} for the fewest bytes.",
            ties.len(),
            percent(noise.max_factor()),
            best.name
        )
    })
}

/// Its times in the fastest and the slowest view.
fn times(data: &Data<'_>, best: &Ranked<'_>) -> Option<String> {
    let times = best.cases.iter();
    let times = times.map(|case| Some(data.timings.typical(case)?.middle));
    let times: Vec<f64> = times.collect::<Option<_>>()?;
    let most = times.iter().copied().reduce(f64::max)?;
    let least = times.into_iter().reduce(f64::min)?;
    Some(format!(
        "Time: {} to {} {} a view.",
        significant(least),
        significant(most),
        data.timings.unit()
    ))
}

/// Bytes on the device where they are most.
fn held(best: &Ranked<'_>) -> String {
    match (best.held_bytes(), best.most_of(GEOMETRY_BYTES)) {
        (Some(held), Some(geometry)) => format!(
            "Memory: at most {} on the device in a view: geometry, constants, targets and textures; geometry alone at most {}.",
            measured_bytes(held),
            measured_bytes(geometry)
        ),
        _ => "Memory: not counted.".to_owned(),
    }
}

/// How its pictures differ from the reference's.
fn pictures(best: &Ranked<'_>) -> String {
    let differ = match best.most_of(MISMATCHED_PX) {
        None => "Pictures: how many pixels differ was not counted".to_owned(),
        Some(0.0) => {
            "Pictures are right: none differs from the exact reference in any pixel".to_owned()
        }
        Some(px) => format!(
            "Pictures are right: at most {} pixels of one differ from the exact reference, each within a pixel of a \
             boundary",
            digits(px)
        ),
    };
    let moved = best.moved_px().map_or_else(String::new, |px| {
        format!(
            ". Levels of detail moved boundaries by up to {} px on purpose",
            significant(px)
        )
    });
    format!("{differ}{moved}.")
}

/// Half the width of the times' 95 % intervals, as a share of the times: the median over views.
fn sureness(data: &Data<'_>, best: &Ranked<'_>) -> String {
    let times = best
        .cases
        .iter()
        .filter_map(|case| data.timings.typical(case));
    let times: Vec<_> = times.collect();
    let processes = times.iter().map(|time| time.processes).min().unwrap_or(0);
    let half_percent = |time: &Estimate| {
        let [low, high] = time.interval?;
        Some(50.0 * (high - low) / time.middle)
    };
    let widths: Option<Vec<f64>> = times.iter().map(half_percent).collect();
    if let Some(half) = widths.and_then(|widths| median(&widths)) {
        return format!(
            "How sure: times to ± {} % ({processes} processes).",
            significant(half)
        );
    }
    let noise = data.timings.noise.map_or_else(String::new, |noise| {
        format!(
            " The same work measured twice differed by up to {} %.",
            percent(noise.max_factor())
        )
    });
    format!(
        "How sure: unknown. {processes} {} ran, and an interval takes {MIN_REPLICATES}.{noise}",
        if processes == 1 {
            "process"
        } else {
            "processes"
        }
    )
}

/// By how many percent a factor differs from 1.
fn percent(factor: f64) -> String {
    significant(100.0 * (factor - 1.0))
}

/// What the fastest fill that moves no boundary costs on top; nothing where the best moves none.
fn exactness(best: &Ranked<'_>, ranked: &[Ranked<'_>]) -> Option<String> {
    best.moved_px()?;
    let Some(exact) = ranked.iter().find(|other| other.moved_px().is_none()) else {
        return Some("Without moved boundaries: no such fill was timed in all views.".to_owned());
    };
    let bytes = exact
        .most_of(GEOMETRY_BYTES)
        .zip(best.most_of(GEOMETRY_BYTES));
    let bytes = bytes.filter(|(_, own)| *own > 0.0);
    let bytes = bytes.map_or_else(String::new, |(exact, own)| {
        format!(" and {} × the bytes of geometry", significant(exact / own))
    });
    Some(format!(
        "Without moved boundaries the fastest is {}: {} × the time{bytes}.",
        exact.name,
        significant(exact.mean / best.mean),
    ))
}

/// The best of other layouts: those that tie with it by name, else the next with its price.
fn next(best: &Ranked<'_>, ranked: &[Ranked<'_>], ties: &[Ranked<'_>]) -> Option<String> {
    let layout = best.cases.first().map(|case| layout_name(case));
    let is_other =
        |other: &&Ranked<'_>| other.cases.first().map(|case| layout_name(case)) != layout;
    let tied = ties.iter().filter(is_other);
    let tied: Vec<&str> = tied.map(|other| other.name.as_str()).collect();
    if !tied.is_empty() {
        return Some(format!("As fast on average: {}.", some_of(&tied)));
    }
    let next = ranked.iter().find(is_other)?;
    Some(format!(
        "Next best: {}, {} × its time on average.",
        next.name,
        significant(next.mean / best.mean)
    ))
}

/// That a GPU may rank them otherwise, where none was measured.
fn software(data: &Data<'_>) -> Option<String> {
    (data.run.environment.device_type == "cpu").then(|| {
        "No GPU was measured: this device is software on the processor, its times are those of all threads together, and \
         a GPU may rank fills otherwise.".to_owned()
    })
}

/// What draws a picture of it, with all its switches.
fn shown(data: &Data<'_>, best: &Ranked<'_>) -> Option<String> {
    let commands = best.cases.iter().map(|case| data.command(case));
    let first = commands.into_iter().find(|command| !command.is_empty())?;
    Some(format!(
        "To draw one of its pictures, with all its switches: {first}"
    ))
}
