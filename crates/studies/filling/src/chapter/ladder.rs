// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder: what each switch gives on the way from the method of 2007 to the full plan. What the document
//! says of these steps stands in the table of its claims.

use super::data::Data;
use super::rungs::{Ladder, Rung, counters};
use super::table::{STATUS, head, steps_plot, steps_table};
use crate::keys::*;
use terrafill_lab::Column;
use terrafill_plot::number::{digits, significant};
use terrafill_results::{Block, Case, Cell, ChapterError, Outcome, Row, Table};

const COLUMNS: [Column; 8] = [
    STATUS,
    Column::metric("geometry bytes", GEOMETRY_BYTES),
    Column::metric("draws", DRAWS),
    Column::metric("vertices", VERTICES),
    Column::metric("stencil-tested fragments", STENCIL_FRAGMENTS).written(digits),
    Column::metric("tallest wall, m", WALL_HEIGHT_M).written(digits),
    Column::metric("px that differ", MISMATCHED_PX),
    Column::metric("outside band", MISMATCHED_PX_OUTSIDE_BAND),
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
             start from. A bar's length is the printed gain. {}",
            data.run.clock().name(),
            data.band_sentence(ladders.first().map(|ladder| ladder.scene)),
        ),
    );
    blocks.push(Block::Table(overview(data, ladders)));
    for ladder in ladders {
        blocks.extend(ladder_blocks(data, ladder)?);
    }
    Ok(blocks)
}

fn ladder_blocks(data: &Data<'_>, ladder: &Ladder<'_>) -> Result<Vec<Block>, ChapterError> {
    let rungs = &ladder.rungs;
    let mut blocks = vec![Block::part(&ladder.title)];
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
    let changed = |before: &Case, after: &Case| Cell::name(counters(before, after));
    blocks.push(Block::Table(steps_table(data, rungs, &COLUMNS, changed)));
    Ok(blocks)
}

/// What all kept steps gave together, and which gave most.
fn overview(data: &Data<'_>, ladders: &[Ladder<'_>]) -> Table {
    let rows = ladders.iter().map(|ladder| {
        let mut kept = ladder.rungs.iter().filter(|rung| rung.is_kept());
        let gains = kept.clone().filter_map(|rung| Some((rung, rung.gain?)));
        let most = gains.max_by(|a, b| a.1.middle.total_cmp(&b.1.middle));
        let most =
            most.map(|(rung, gain)| format!("{}: {}", rung.step, data.timings.ratio_text(&gain)));
        let both = kept.next().zip(kept.next_back());
        let total = both.and_then(|(first, last)| data.timings.over(first.case, last.case));
        let cells = [
            data.timings
                .ratio_cell(total.as_ref(), "no two right steps with times"),
            Cell::or_absent(most, "no gain was measured"),
        ];
        Row::named(Cell::name(&ladder.title), cells)
    });
    let headings = [
        "scene, view: technique",
        "first right step ÷ last [95\u{a0}%]",
        "gave most",
    ];
    Table {
        is_main: true,
        ..Table::of(headings, rows.collect())
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
