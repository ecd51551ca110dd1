// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks.

use super::kit::{TIME, beside, counter, gain, of_most, ratios, remark, said, time};
use crate::cache::Keep;
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Names, Section, Select};
use terrafill_plot::number::significant;

const WHAT_REBINDING_IS: &str = "A texture a block is what came before arrays: each block is a draw of its own, with its texture bound before it, all \
     in one pass. All others are one draw, whose vertex shader finds layer, slice, texel or texture from column and row. \
     The most blocks are of 129 × 129 samples, so that all grounds of more than four blocks have a million cells.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Ground drawn from its blocks",
    caption: "Ground of blocks of 257 × 257 or 129 × 129 samples, drawn",
    text: "Terrain of m × n blocks is drawn from what keeps them, every vertex fetched by the vertex shader, which \
           chooses the block by the vertex's place. Samples of borders are in both neighbours. Every picture must be \
           that of the same ground as one grid: its triangles' numbers are held against rays in f64, and pictures of \
           one interface against each other.",
    cases: Select::With(EXPERIMENT, "blocks"),
    named_by: Names::Columns(&[
        ("blocks", BLOCKS),
        ("cells a side", GRID_CELLS),
        ("interface", API),
        ("kept in", KEPT_IN),
    ]),
    columns: &[
        Column::of("time, ms", TIME),
        ratios("time ÷ that of the array", |cases, case| {
            let array = beside(cases, case, &[(KEPT_IN, Keep::Array.name())]);
            gain(Some(case), array, time(cases.clock()))
        }),
        Column::metric("draws", PIPELINE_DRAWS),
        Column::metric("bind groups", CACHE_BINDS),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        Column::metric("held", PIPELINE_HELD_BYTES),
        Column::metric("wrong pixels", PIPELINE_MISMATCHED_PX),
        Column::metric("pixels that differ", PIPELINE_DIFFERING_PX),
    ],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_REBINDING_IS)],
    ..Section::EMPTY
};

/// From what the most blocks are drawn fastest.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let metric = time(cases.clock());
    let on = |api: &str| {
        let own = cases.with(&[(EXPERIMENT, "blocks"), (API, api)]);
        let (blocks, own) = of_most(&own, BLOCKS, metric)?;
        let best = own.best(metric)?;
        Some(format!(
            "On {api} ground of {blocks} blocks is drawn fastest from: {}{} ({} ms, {} bind groups).",
            best.case.condition(KEPT_IN),
            best.tied_with(|case| case.condition(KEPT_IN).to_owned()),
            significant(best.value),
            said(best.case, CACHE_BINDS),
        ))
    };
    ["wgpu", "vulkan"].into_iter().filter_map(on).collect()
}
