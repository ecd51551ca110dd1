// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder: what each switch gives on the way from the method of 2007 to the full plan, and whether
//! what was found then is still found.
//!
//! Claims are compared with the measured interval; nothing here knows what came out.

use super::data::{Data, counter, name, standing};
use super::rungs::{Ladder, Rung, SOURCE, counters};
use super::{claims, fill_rate};
use crate::keys::{
    DRAWS, GEOMETRY_BYTES, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND, STENCIL_FRAGMENTS, VERTICES,
};
use terrafill_plot::number::{bytes, count, significant};
use terrafill_plot::{RatioAxis, Step, Steps};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Estimate, Heading, Outcome, Plot, Row, Table,
};

/// Ratios of this chapter's axes.
pub(super) const AXIS_ONE: &str = "depth-pass = 1";

/// Every ladder of the run.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Result<Vec<Block>, ChapterError> {
    if ladders.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section("From 2007 to the full plan"),
        Block::Text(format!(
            "One switch at a time, from the un-optimised method to the full plan. Gain = {} of the \
             last kept step before ÷ this step's, paired by process; above 1 is faster. A step is kept \
             unless its picture is wrong or it stands aside: an experiment that the next step does not \
             start from. A bar's length is the printed gain. After each table of the vertex shader: what \
             {SOURCE} says of the steps that repeat its experiments, and whether the interval measured \
             here agrees. {}",
            data.run.clock().name(),
            data.band_sentence(ladders.first().map(|ladder| ladder.scene)),
        )),
        Block::Table(overview(data, ladders)),
    ];
    blocks.extend(fill_rate::blocks(data, ladders));
    for ladder in ladders {
        blocks.extend(ladder_blocks(data, ladder)?);
    }
    Ok(blocks)
}

fn ladder_blocks(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Vec<Block>, ChapterError> {
    let mut blocks = vec![Block::Heading {
        level: 4,
        text: ladder.title.clone(),
    }];
    let missing = missing(&ladder.rungs);
    if !missing.is_empty() {
        blocks.push(Block::Alarm(format!(
            "Rungs without a result: {}.",
            missing.join("; ")
        )));
    }
    let sentences = sentences(data, &ladder.rungs);
    if !sentences.is_empty() {
        blocks.push(Block::Text(sentences.join(" ")));
    }
    if let Some(svg) = plot(data, ladder)? {
        blocks.push(Block::Plot(Plot {
            caption: String::new(),
            svg,
        }));
    }
    blocks.push(Block::Table(table(data, &ladder.rungs)));
    let findings = claims::of_ladder(data, ladder);
    blocks.extend(findings.into_iter().map(Block::Finding));
    Ok(blocks)
}

fn table(data: &Data<'_>, rungs: &[Rung<'_>]) -> Table {
    let mut headings = vec![
        Heading::plain("step"),
        Heading::plain("status"),
        Heading::explained(
            "÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)",
            "times over the median of the full-screen depth-pass of the same view",
        ),
        Heading::explained(
            "gain over the last kept step [95\u{a0}%]",
            "time of the last kept step before over this one's, paired by process",
        ),
    ];
    let metrics = [
        ("geometry bytes", GEOMETRY_BYTES),
        ("draws", DRAWS),
        ("vertices", VERTICES),
        ("stencil-tested fragments", STENCIL_FRAGMENTS),
        ("px that differ", MISMATCHED_PX),
        ("outside band", MISMATCHED_PX_OUTSIDE_BAND),
    ];
    headings.extend(metrics.map(|(text, metric)| Heading::metric(text, metric)));
    headings.push(Heading::explained(
        "because",
        "what the step changed of the work that is done",
    ));
    let rows = rungs.iter().map(|rung| {
        let case = rung.case;
        let why = match case.reason.as_str() {
            "" => case.outcome.name(),
            reason => reason,
        };
        let absent = |text: Option<String>| Cell::or_absent(text, why);
        let ratio = data
            .spread_over_depth_pass(case)
            .map(terrafill_plot::number::spread);
        let mut cells = vec![
            Cell {
                detail: name(case),
                ..Cell::name(format!(
                    "{} · {}{}: {}",
                    rung.number,
                    if rung.is_aside { "aside, " } else { "" },
                    rung.step,
                    case.note("change")
                ))
            },
            Cell::plain(case.outcome.name()),
            absent(ratio),
            match &rung.gain {
                Some(gain) => Cell::plain(data.ratio_text(gain)),
                None => Cell::absent("no kept step before it, or no times of both"),
            },
        ];
        cells.extend(metrics.map(|(_, metric)| {
            let print = if metric.name.ends_with("bytes") {
                bytes
            } else {
                count
            };
            absent(counter(case, metric).map(print))
        }));
        cells.push(match rung.before {
            Some(before) => Cell::name(counters(before, case)),
            None => Cell::absent("nothing comes before it"),
        });
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: match case.outcome {
                Outcome::Ok => String::new(),
                _ => case.reason.clone(),
            },
        }
    });
    Table {
        rows: rows.collect(),
        headings,
        ..Table::default()
    }
}

fn plot(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Option<String>, ChapterError> {
    let rows = ladder.rungs.iter().map(|rung| {
        let ratio = data.spread_over_depth_pass(rung.case);
        let gain = rung.gain.map_or_else(String::new, |gain| {
            format!(" · gain {}", significant(gain.middle))
        });
        let value = ratio.map_or_else(String::new, |ratio| {
            format!("{} ×{gain}", significant(ratio.median))
        });
        Step {
            label: format!("{} · {}", rung.number, rung.step),
            begins: ratio.and_then(|ratio| Some(ratio.median * rung.gain?.middle)),
            is_kept: rung.is_kept(),
            ratio: ratio.ok_or_else(|| no_ratio(data, rung.case)),
            value,
            command: data.command(rung.case),
        }
    });
    let axis = axis_title(data);
    let steps = Steps {
        title: format!("{}: time over depth-pass, step by step", ladder.title),
        axis: RatioAxis {
            title: &axis,
            one: AXIS_ONE,
        },
        rows: rows.collect(),
    };
    Ok(steps.draw()?)
}

/// What the axis of every plot of ratios says.
pub(super) fn axis_title(data: &Data<'_>) -> String {
    format!(
        "{} of the fill ÷ that of the depth-pass, median with 5–95 % of samples (logarithmic)",
        data.run.clock().name()
    )
}

/// Why a case has no ratio to the depth-pass.
pub(super) fn no_ratio(data: &Data<'_>, case: &Case) -> String {
    let why = match case.outcome {
        Outcome::Ok if data.time(case).is_none() => "no fill time",
        Outcome::Ok => "no depth-pass measured",
        _ => standing(case),
    };
    why.to_owned()
}

/// Steps by what they gave, most first.
fn by_gain<'r>(rungs: &'r [Rung<'_>]) -> Vec<(&'r str, &'r Estimate)> {
    let gains = rungs
        .iter()
        .filter(|rung| !rung.is_aside)
        .filter_map(|rung| Some((rung.step, rung.gain.as_ref()?)));
    let mut gains: Vec<(&str, &Estimate)> = gains.collect();
    gains.sort_by(|a, b| b.1.middle.total_cmp(&a.1.middle));
    gains
}

fn overview(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Table {
    let rows = ladders.iter().map(|ladder| {
        let right = || {
            ladder
                .rungs
                .iter()
                .filter(|rung| !rung.is_aside)
                .map(|rung| rung.case)
                .filter(|case| case.counts())
        };
        let over_depth_pass = |case: Option<&Case>| {
            let ratio = case.and_then(|case| data.spread_over_depth_pass(case));
            Cell::or_absent(ratio.map(|ratio| significant(ratio.median)), "no ratio")
        };
        let (first, last) = (right().next(), right().next_back());
        let total = first
            .zip(last)
            .and_then(|(first, last)| data.over(first, last));
        let gains = by_gain(&ladder.rungs);
        let most = gains
            .first()
            .map(|(step, gain)| format!("{step}: {}", data.ratio_text(gain)));
        Row::new(vec![
            Cell::name(&ladder.title),
            over_depth_pass(first),
            over_depth_pass(last),
            data.ratio_cell(total.as_ref(), "no two right steps with times"),
            Cell::or_absent(most, "no gain was measured"),
        ])
    });
    Table {
        headings: [
            "scene, view: technique",
            "first right step ÷\u{a0}depth-pass",
            "last ÷\u{a0}depth-pass",
            "first ÷ last [95\u{a0}%]",
            "gave most",
        ]
        .map(Heading::plain)
        .into(),
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// What gave most, and where the ladder ends.
fn sentences(data: &Data<'_>, rungs: &[Rung<'_>]) -> Vec<String> {
    let mut sentences = Vec::new();
    let gains = by_gain(rungs);
    if let Some((step, most)) = gains.first() {
        let is_close = |second: &Estimate| match (second.interval, most.interval) {
            (Some([_, high]), Some([low, _])) => high > low,
            _ => true,
        };
        sentences.push(format!(
            "{step} gave most: {}{}.",
            data.ratio_text(most),
            match gains.get(1) {
                Some((second, gain)) if is_close(gain) =>
                    format!(", not clearly more than {second}"),
                _ => String::new(),
            }
        ));
    }
    let on_the_way = || rungs.iter().rev().filter(|rung| !rung.is_aside);
    let last_right = on_the_way().find(|rung| rung.case.counts());
    if let (Some(right), Some(last)) = (last_right, on_the_way().next())
        && right.number != last.number
    {
        sentences.push(format!(
            "The last step that is right is {}, {}.",
            right.number, right.step
        ));
    }
    sentences
}

/// Names of rungs that are not there.
fn missing(rungs: &[Rung<'_>]) -> Vec<String> {
    let mut missing = Vec::new();
    for (rung, number) in rungs.iter().zip(1_u32..) {
        if rung.number != number {
            missing.push(format!(
                "rung {number} (the ladder goes on with {}, {})",
                rung.number, rung.step
            ));
            break;
        }
    }
    let absent = rungs
        .iter()
        .filter(|rung| rung.case.outcome == Outcome::Missing);
    missing.extend(
        absent.map(|rung| format!("rung {}, {}: {}", rung.number, rung.step, rung.case.id())),
    );
    missing
}
