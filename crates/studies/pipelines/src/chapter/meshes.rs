// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that are no terrain: what each stage takes for them, and how near their triangles come to the surface.

use super::kit::{
    FRAME, WHOLE, beside, compared, counter, frame_time, gain, of_most, ratios, remark, said,
};
use crate::meshes::{Division, MAX_PATCH_CELLS};
use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Names, Panel, Section, Select, finding, log_slope,
};
use terrafill_plot::Upwards;
use terrafill_plot::number::significant;
use terrafill_results::{Claim, Finding};

const WHAT_OF_TEAPOTS: &str = "The paper shows a teapot \"rendered with spline subdivision\" in its first figure and gives no set-up, level or \
     time of it, so there is nothing of it to compare. Its cap of 128 vertices an invocation holds 7 × 7 cells.";

pub(super) const PATCHES: Section<'static> = Section {
    title: "A pot of bicubic patches",
    caption: "The pot by every stage that divides patches",
    text: "A pot of 40 bicubic patches with control points of its own is divided on Vulkan into level × level cells a \
           patch. One invocation of a geometry shader makes a patch, or a row of one; or compute places every vertex, \
           or the tessellation stages, or the vertex shader alone. The error is the distance of the triangles from the \
           exact patches in double precision, the largest of seven places of each triangle. Pictures are held against \
           rays in double precision to the same triangles; of the tessellation stages, whose cut of a cell is the \
           driver's, against rays to the cells cut either way. Each triangle is shown in its light, every other cell a \
           little darker.",
    cases: Select::With(EXPERIMENT, "patches"),
    named_by: Names::Columns(&[("level", LEVEL), ("way", WAY)]),
    findings: &[|cases| patches_finding(cases)],
    drawing: Some(Drawing {
        caption: "Error against time: along each curve the level rises.",
        panels: &[Panel {
            across: ("frame, ms", FRAME),
            up: (
                "largest distance from the surface, m",
                Figure::Metric(SURFACE_ERROR_MAX_M),
            ),
            upwards: Upwards::Error,
            curve: Names::Joined(&[WAY]),
            knob: Figure::Condition(LEVEL),
            label: Some(Names::Joined(&[LEVEL])),
            ..Panel::EMPTY
        }],
    }),
    columns: &[
        Column::of("time, ms", FRAME),
        ratios("time ÷ that of a row an invocation", |cases, case| {
            let row = beside(cases, case, &[(WAY, Division::Row.name())]);
            gain(Some(case), row, frame_time(cases.clock()))
        }),
        Column::metric("largest distance, m", SURFACE_ERROR_MAX_M),
        Column::metric("rms, m", SURFACE_ERROR_RMS_M),
        Column::metric("largest, px", SURFACE_ERROR_PX),
        Column::metric("held", PIPELINE_HELD_BYTES),
        Column::metric("vertices given", PIPELINE_EMITTED_VERTICES),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("pixels in the band", PIPELINE_BAND_PX),
    ],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_OF_TEAPOTS)],
    ..Section::EMPTY
};

/// That one invocation a patch is slower than the stages that are made for it: what 2007 had against what came after.
fn patches_finding(cases: &Cases<'_>) -> Finding {
    let own = cases.fitting(|case| {
        case.condition(LEVEL)
            .parse()
            .is_ok_and(|level: u32| level <= MAX_PATCH_CELLS)
    });
    let ways = [Division::Patch, Division::Tessellation].map(Division::name);
    let pairs = own.pairs(WAY, ways, &[]);
    let claim = "The tessellation stages divide the pot in less time than one invocation of a geometry shader a patch:";
    let time = (frame_time(cases.clock()), WHOLE);
    compared(
        cases,
        (WAY, &[]),
        time,
        &pairs,
        (claim.to_owned(), Claim::Faster),
    )
}

/// What is required: the error falls by the square of the level.
pub(super) fn requirements(cases: &Cases<'_>) -> Vec<Finding> {
    let own = cases.with(&[(EXPERIMENT, "patches"), (WAY, Division::Row.name())]);
    let slope = log_slope(own.series(LEVEL, SURFACE_ERROR_MAX_M));
    let falls = slope.map(|slope| {
        finding(
            "The largest distance of a pot's triangles from its patches falls by the square of the level, within 15 %:",
            Some((slope + 2.0).abs() <= 0.3),
            format!("an exponent of {}", significant(slope)),
        )
    });
    falls.into_iter().collect()
}

/// The cheapest way at the finest level, and its error.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let metric = frame_time(cases.clock());
    let patches = || {
        let own = cases.with(&[(EXPERIMENT, "patches")]);
        let (level, own) = of_most(&own, LEVEL, metric)?;
        let best = own.best(metric)?;
        Some(format!(
            "A pot of bicubic patches at level {level}, within {} m of the surface, is drawn fastest by {}{}: {} ms.",
            said(best.case, SURFACE_ERROR_MAX_M),
            best.case.condition(WAY),
            best.tied_with(|case| case.condition(WAY).to_owned()),
            significant(best.value),
        ))
    };
    patches().into_iter().collect()
}
