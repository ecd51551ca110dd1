// SPDX-License-Identifier: MIT OR Apache-2.0
//! The answer in a few sentences and one picture. They say what to take, how far off the best it is, what it holds and
//! how sure that is. Then come what unmoved boundaries cost on top, and the next best.

use super::contest::{Contest, Ranked, ranked};
use super::data::{Data, label, layout_name};
use crate::keys::{GEOMETRY_BYTES, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND};
use crate::purpose::is_approximate;
use terrafill_lab::{in_every_group, some_of};
use terrafill_plot::number::{digits, measured_bytes, significant};
use terrafill_plot::{RatioAxis, RatioGroup, RatioPlot, RatioRow};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{Block, Case, ChapterError, Estimate, Spread, median, typical};

/// Both; nothing of a view without a fill that is right and timed.
pub(super) fn blocks<'a>(
    data: &Data<'a>,
    contests: &[Contest<'_, 'a>],
) -> Result<Vec<Block>, ChapterError> {
    let contested = contests.iter().filter(|contest| !contest.fills.is_empty());
    let contested: Vec<&Contest<'_, '_>> = contested.collect();
    let ranked = ranked(data, &contested);
    let mut blocks = vec![Block::Lead(answer(data, &ranked, contested.len()))];
    blocks.extend(picture(data, &contested, &ranked)?);
    Ok(blocks)
}

fn answer(data: &Data<'_>, ranked: &[Ranked<'_>], views: usize) -> String {
    let Some((best, others)) = ranked.split_first() else {
        return format!(
            "No fill is right and timed in all {views} views; the table says which is the best of each."
        );
    };
    let sentences = [
        Some(taken(data, best)),
        Some(held(best)),
        Some(sureness(data, best)),
        exactness(best, others),
        next(data, best, others),
    ];
    let sentences: Vec<String> = sentences.into_iter().flatten().collect();
    sentences.join(" ")
}

/// Every fill of all views, and approximate ones, by how much longer they take than the fastest right one of each view.
fn picture(
    data: &Data<'_>,
    contested: &[&Contest<'_, '_>],
    ranked: &[Ranked<'_>],
) -> Result<Option<Block>, ChapterError> {
    let right = ranked.iter().map(|fill| {
        let value = format!(", {} × at most", significant(fill.most));
        row(data, fill.name.clone(), &fill.cases, &fill.ratios, value)
    });
    let mut rows: Vec<RatioRow> = right.chain(approximate(data, contested)).collect();
    let place = |row: &RatioRow| data.palette().place(&row.series);
    rows.sort_by(|a, b| (place(a), &a.label).cmp(&(place(b), &b.label)));
    let title = format!(
        "{} over the view's fastest right fill (logarithmic)",
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
            name: format!("{} views", contested.len()),
            dashed: None,
            rows,
        }],
    };
    let caption = "How much longer each fill takes than the fastest. Its mark is the geometric mean over the views. Its \
        line goes from the least to the most of them and is no error bar. Left is better. Grey about 1: as far as \
        identical work differed. Only fills that were right and timed in every view are shown, and approximate ones \
        with their wrong pixels over all views.";
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
fn taken(data: &Data<'_>, best: &Ranked<'_>) -> String {
    let is_first = |ratio: &&f64| **ratio <= 1.0 || data.timings.is_tie(**ratio);
    let (first, all) = (
        best.ratios.iter().filter(is_first).count(),
        best.ratios.len(),
    );
    let views = match (first, all) {
        (1, 1) => "the fastest of its view, or tied".to_owned(),
        _ if first == all => format!("fastest or tied in all {all} views"),
        _ => format!(
            "over {all} views {} × the time of each view's fastest, the least of all, and {} × at most; fastest or \
             tied in {first}",
            significant(best.mean),
            significant(best.most)
        ),
    };
    format!("Take {}: {views}.", best.name)
}

/// Bytes of geometry where they are most, and how its pictures differ from the reference's.
fn held(best: &Ranked<'_>) -> String {
    let bytes = best.most_of(GEOMETRY_BYTES).map(measured_bytes);
    let bytes = bytes.map_or_else(
        || "Its bytes were not counted".to_owned(),
        |bytes| format!("At most {bytes} of geometry in a view"),
    );
    let differ = best.most_of(MISMATCHED_PX).map_or_else(
        || "How many pixels differ was not counted".to_owned(),
        |px| {
            format!(
                "At most {} pixels of a picture differ from the reference's, all of them at boundaries",
                digits(px)
            )
        },
    );
    let moved = best.moved_px().map_or_else(String::new, |px| {
        format!(
            ", which are moved by up to {} px on purpose",
            significant(px)
        )
    });
    format!("{bytes}. {differ}{moved}.")
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
    match widths.and_then(|widths| median(&widths)) {
        Some(percent) => format!(
            "Times are sure to ± {} % ({processes} processes).",
            significant(percent)
        ),
        None => {
            let noise = data.timings.noise.map(|noise| noise.max_factor() - 1.0);
            let noise = noise.map_or_else(String::new, |noise| {
                format!(
                    ", and identical work differed by up to {} %",
                    significant(100.0 * noise)
                )
            });
            format!(
                "How sure the times are is not known: {processes} {} ran, an interval takes {MIN_REPLICATES}{noise}.",
                if processes == 1 {
                    "process"
                } else {
                    "processes"
                },
            )
        }
    }
}

/// What the fastest fill that moves no boundary costs on top; nothing where the best moves none.
fn exactness(best: &Ranked<'_>, others: &[Ranked<'_>]) -> Option<String> {
    best.moved_px()?;
    let Some(exact) = others.iter().find(|other| other.moved_px().is_none()) else {
        return Some("No fill that moves no boundary was timed in all views.".to_owned());
    };
    let bytes = exact
        .most_of(GEOMETRY_BYTES)
        .zip(best.most_of(GEOMETRY_BYTES));
    let bytes = bytes.filter(|(_, own)| *own > 0.0);
    let bytes = bytes.map_or_else(String::new, |(exact, own)| {
        format!(" and {} × the bytes", significant(exact / own))
    });
    Some(format!(
        "Without moved boundaries: {} × the time{bytes} ({}).",
        significant(exact.mean / best.mean),
        exact.name
    ))
}

/// The best of other layouts: those that tie with it by name, else the next with its price.
fn next(data: &Data<'_>, best: &Ranked<'_>, others: &[Ranked<'_>]) -> Option<String> {
    let layout = best.cases.first().map(|case| layout_name(case));
    let is_other =
        |other: &&Ranked<'_>| other.cases.first().map(|case| layout_name(case)) != layout;
    let over = |other: &Ranked<'_>| other.mean / best.mean;
    let others = others.iter().filter(is_other);
    let ties = others
        .clone()
        .take_while(|other| data.timings.is_tie(over(other)));
    let ties: Vec<&str> = ties.map(|other| other.name.as_str()).collect();
    if !ties.is_empty() {
        return Some(format!("As fast on average: {}.", some_of(&ties)));
    }
    let next = others.clone().next()?;
    Some(format!(
        "Next best: {}, {} × on average.",
        next.name,
        significant(over(next))
    ))
}
