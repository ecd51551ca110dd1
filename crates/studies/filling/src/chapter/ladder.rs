// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder: what each switch gives on the way from the method of 2007 to the full plan, and whether
//! what was found then is still found.
//!
//! Claims are compared with the measured interval; nothing here knows what came out.

use super::data::{Data, is_more};
use super::rungs::{Ladder, Rung, SOURCE, counters};
use super::table::Show::{Bytes, Count, Own, Ratios, Status};
use super::table::{Column, head, part, plain_figures, row, step_cells, steps_plot, table};
use super::{claims, fill_rate};
use crate::keys::*;
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, ChapterError, Estimate, Outcome, Standing, Table};

const COLUMNS: [Column; 11] = [
    ("step", Own("")),
    ("status", Status),
    ("÷\u{a0}depth-pass (5\u{2060}–\u{2060}95\u{a0}%)", Ratios),
    (
        "gain over the last kept step [95\u{a0}%]",
        Own("time of the last kept step before over this one's, paired by process"),
    ),
    ("geometry bytes", Bytes(GEOMETRY_BYTES)),
    ("draws", Count(DRAWS)),
    ("vertices", Count(VERTICES)),
    ("stencil-tested fragments", Count(STENCIL_FRAGMENTS)),
    ("px that differ", Count(MISMATCHED_PX)),
    ("outside band", Count(MISMATCHED_PX_OUTSIDE_BAND)),
    (
        "because",
        Own("what the step changed of the work that is done"),
    ),
];

/// Every ladder of the run.
pub(super) fn blocks(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Result<Vec<Block>, ChapterError> {
    if ladders.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = head(
        "From 2007 to the full plan",
        format!(
            "One switch at a time, from the un-optimised method to the full plan. Gain = {} of the \
             last kept step before ÷ this step's, paired by process; above 1 is faster. A step is kept \
             unless its picture is wrong or it stands aside: an experiment that the next step does not \
             start from. A bar's length is the printed gain. After each table of the vertex shader: what \
             {SOURCE} says of the steps that repeat its experiments, and whether the interval measured \
             here agrees. {}",
            data.run.clock().name(),
            data.band_sentence(ladders.first().map(|ladder| ladder.scene)),
        ),
    );
    blocks.push(Block::Table(overview(data, ladders)));
    blocks.extend(fill_rate::blocks(data, ladders));
    for ladder in ladders {
        blocks.extend(ladder_blocks(data, ladder)?);
    }
    Ok(blocks)
}

fn ladder_blocks(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Vec<Block>, ChapterError> {
    let rungs = &ladder.rungs;
    let mut blocks = vec![part(ladder.title.clone())];
    let missing = missing(rungs);
    if !missing.is_empty() {
        blocks.push(Block::Alarm(format!(
            "Rungs without a result: {}.",
            missing.join("; ")
        )));
    }
    let title = format!("{}: time over depth-pass, step by step", ladder.title);
    let gain = |rung: &Rung<'_>| {
        let gain = rung
            .gain
            .map(|gain| format!(" · gain {}", significant(gain.middle)));
        gain.unwrap_or_default()
    };
    blocks.extend(steps_plot(data, title, rungs, gain)?);
    let rows = rungs.iter().map(|rung| {
        let because = match rung.before {
            Some(before) => Cell::name(counters(before, rung.case)),
            None => Cell::absent("nothing comes before it"),
        };
        let own = step_cells(data, rung).into_iter().chain([because]);
        (rung.case, own.collect())
    });
    blocks.push(Block::Table(table(data, &COLUMNS, rows)));
    let findings = claims::of_ladder(data, ladder);
    blocks.extend(findings.into_iter().map(Block::Finding));
    Ok(blocks)
}

/// The step that gave most, and whether another one may have given as much.
fn gave_most(data: &Data<'_>, rungs: &[Rung<'_>]) -> Option<String> {
    let own = rungs.iter().filter(|rung| !rung.is_aside);
    let gains = own.filter_map(|rung| Some((rung.step, rung.gain?)));
    let mut gains: Vec<(&str, Estimate)> = gains.collect();
    gains.sort_by(|a, b| b.1.middle.total_cmp(&a.1.middle));
    let (step, most) = gains.first()?;
    let is_close = |(_, second): &&(&str, Estimate)| is_more(most, second) != Standing::Holds;
    let close = gains.get(1).filter(is_close);
    let close = close.map_or_else(String::new, |(second, _)| {
        format!(", not clearly more than {second}")
    });
    Some(format!("{step}: {}{close}", data.ratio_text(most)))
}

fn overview(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Table {
    let rows = ladders.iter().map(|ladder| {
        let kept = ladder.rungs.iter().filter(|rung| rung.is_kept());
        let mut right = kept.map(|rung| rung.case);
        let over_depth_pass = |case: Option<&Case>| {
            let ratio = case.and_then(|case| data.spread_over_depth_pass(case));
            Cell::or_absent(ratio.map(|ratio| significant(ratio.median)), "no ratio")
        };
        let first = right.next();
        let last = right.next_back().or(first);
        let total = first
            .zip(last)
            .and_then(|(first, last)| data.over(first, last));
        let cells = [
            over_depth_pass(first),
            over_depth_pass(last),
            data.ratio_cell(total.as_ref(), "no two right steps with times"),
            Cell::or_absent(gave_most(data, &ladder.rungs), "no gain was measured"),
        ];
        row(Cell::name(&ladder.title), cells)
    });
    let headings = [
        "scene, view: technique",
        "first right step ÷\u{a0}depth-pass",
        "last ÷\u{a0}depth-pass",
        "first ÷ last [95\u{a0}%]",
        "gave most",
    ];
    Table {
        is_main: true,
        ..plain_figures(&headings, rows.collect())
    }
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
