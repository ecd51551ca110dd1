// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks, and craters written into them.

use super::kit::{TIME, beside, compared, counter, gain, of_most, ratios, remark, said, time};
use crate::cache::{CraterWay, Keep};
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Claim, Finding, Outcome};

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

pub(super) const CRATERED: Section<'static> = Section {
    title: "Craters where balls strike",
    caption: "Craters written into the layers of an array texture, on wgpu",
    text: "Craters of 20 to 60 m radius are let into ground of 4 × 4 blocks. A pass draws each struck layer from a copy of \
           it, less the craters that reach it; or the CPU computes the layer and writes it. Heights are then held \
           against the same craters in f64, at borders in both blocks, and the ground is drawn from its layers and held \
           against rays over them. A time is that of all craters once, without drawing the ground.",
    cases: Select::With(EXPERIMENT, "craters"),
    findings: &[faster],
    named_by: Names::Columns(&[("craters", CRATERS), ("by", CRATER_WAY)]),
    columns: &[
        Column::of("time, ms", FRAME),
        Column::metric("GPU ms", PIPELINE_GPU_MS)
            .or("the CPU writes outside of what the GPU times"),
        Column::metric("sent", PIPELINE_SENT_BYTES),
        Column::metric("layers", CRATER_LAYERS),
        Column::metric("heights struck", CRATER_STRUCK),
        Column::metric("largest error, m", CRATER_ERROR_M),
        Column::metric("strayed or torn", CRATER_STRAYED),
        Column::metric("wrong pixels", PIPELINE_MISMATCHED_PX),
    ],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

/// The CPU's part of a frame of craters is outside of what the GPU times.
const FRAME: Figure = super::kit::FRAME;

fn faster(cases: &Cases<'_>) -> Finding {
    let ways = [CraterWay::Written, CraterWay::Drawn].map(CraterWay::name);
    let pairs = cases.pairs(CRATER_WAY, ways, &[]);
    let claim =
        "Craters are drawn into layers faster than the CPU writes the layers anew:".to_owned();
    let time = (super::kit::frame_time(cases.clock()), super::kit::WHOLE);
    compared(
        cases,
        (CRATER_WAY, &[]),
        time,
        &pairs,
        (claim, Claim::Faster),
    )
}

/// What is required: heights are those of `f64`, at borders too.
pub(super) fn requirement(cases: &Cases<'_>) -> Option<Finding> {
    let own = cases.with(&[(EXPERIMENT, "craters")]);
    let far = own
        .greatest(CRATER_ERROR_M)
        .zip(own.greatest(CRATER_STRAYED));
    let wrong = own
        .iter()
        .any(|case| ![Outcome::Ok, Outcome::Skipped].contains(&case.outcome));
    (!own.is_empty()).then(|| {
        finding(
            "Craters in layers are those of f64, and blocks that share heights have the same:",
            far.map(|(_, strayed)| !wrong && strayed <= 0.0),
            far.map_or_else(String::new, |(far, strayed)| {
                format!("at most {} m off, {strayed} strayed", significant(far))
            }),
        )
    })
}

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
