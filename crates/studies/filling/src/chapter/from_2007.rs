// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ablation: what each switch gives on the way from the method of 2007 to the full plan. What the document
//! says of these steps stands in the table of its claims.

use super::ablations::{Ablation, counters};
use super::data::{DEPTH_PASS, Data};
use super::table::{STATUS, head};
use crate::keys::*;
use terrafill_lab::{Column, StepsSection, gains_table, missing_steps};
use terrafill_plot::number::digits;
use terrafill_results::{Block, Case, Cell, ChapterError};

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

/// Every ablation of the run.
pub(super) fn blocks(
    data: &Data<'_>,
    ablations: &[Ablation<'_>],
) -> Result<Vec<Block>, ChapterError> {
    if ablations.is_empty() {
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
            data.band_sentence(ablations.first().map(|ablation| ablation.scene)),
        ),
    );
    let named = ablations.iter();
    let named = named.map(|ablation| (ablation.title.as_str(), ablation.steps.as_slice()));
    let gains = gains_table(data.timings, "scene, view: technique", named);
    blocks.push(Block::Table(gains));
    for ablation in ablations {
        blocks.extend(ablation_blocks(data, ablation)?);
    }
    Ok(blocks)
}

fn ablation_blocks(data: &Data<'_>, ablation: &Ablation<'_>) -> Result<Vec<Block>, ChapterError> {
    let mut blocks = vec![Block::part(&ablation.title)];
    let missing = missing_steps(&ablation.steps);
    if !missing.is_empty() {
        blocks.push(Block::Alarm(format!(
            "Steps without a result: {}.",
            missing.join("; ")
        )));
    }
    let section = StepsSection {
        title: &format!("{}: time over depth-pass, step by step", ablation.title),
        baseline: DEPTH_PASS,
        columns: &COLUMNS,
        is_main: false,
    };
    let changed = |before: &Case, after: &Case| Cell::name(counters(before, after));
    blocks.extend(ablation.blocks(data, section, changed)?);
    Ok(blocks)
}
