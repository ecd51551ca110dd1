// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows of several lights: depth maps in one pass or in many, with the counters behind their times.

use super::kit::{
    TIME, at_least, beside, compared, counter, gain, none_of, of_most, percent, ratios, remark,
    said,
};
use crate::lights::LightWay;
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Names, Section, Select};
use terrafill_plot::number::significant;
use terrafill_results::{Claim, Clock, Finding, Metric, Scope};

/// Fewest lights of which the claim is read.
const LEAST_CLAIMED: u32 = 4;

const WHAT_WAS_PUBLISHED: &str = "Published are \"2 passes\" in words, without number of lights, sizes or times. A geometry shader was given 32 \
     matrices, so at most 10 lights of three, or 15 that share one. Multiview has a limit of views a \
     pass; more lights take several passes, all with as many views.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Shadows of several lights",
    caption: "Depth maps of several lights, by every way on Vulkan",
    text: "Distant lights stand all round the ground. Their depth maps are the layers of one image; the picture's pixels \
           say which lights reach them, by one lookup each: the lighter, the more of them. The published way draws all \
           maps in one pass, in which a geometry shader copies each triangle into every layer; a pass a light is what \
           it is held against. All ways leave the same depths bit for bit. The reference follows the ray of each map's \
           texel, and beside it the ray of the place itself, whose difference is the map's error.",
    cases: Select::With(EXPERIMENT, "lights"),
    named_by: Names::Columns(&[("lights", LIGHTS), ("layers by", LAYERS_BY)]),
    findings: &[claim],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_WAS_PUBLISHED)],
    columns: &[
        Column::clocked("maps, ms", LIGHTS_MAPS_GPU_MS, LIGHTS_MAPS_CPU_MS),
        ratios("time ÷ that of passes", |cases, case| {
            let passes = beside(cases, case, &[(LAYERS_BY, LightWay::Passes.name())]);
            gain(Some(case), passes, maps(cases.clock()))
        }),
        Column::of("maps and picture, ms", TIME),
        Column::metric("passes", LIGHTS_PASSES),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("maps", PIPELINE_HELD_BYTES),
        Column::metric("depths that differ", LIGHTS_DEPTHS_DIFFERING),
        Column::metric("wrong pixels", PIPELINE_MISMATCHED_PX),
        percent("map's error, %", LIGHTS_MAP_ERROR),
    ],
    is_main: true,
    ..Section::EMPTY
};

fn maps(clock: Clock) -> &'static Metric {
    clock.pick(LIGHTS_MAPS_GPU_MS, LIGHTS_MAPS_CPU_MS)
}

/// What is required: the same depths everywhere.
pub(super) fn requirement(cases: &Cases<'_>) -> Option<Finding> {
    let own = cases.with(&[(EXPERIMENT, "lights")]);
    let claim = "Every way to the maps of several lights leaves the same depths, bit for bit";
    (!own.is_empty()).then(|| none_of(claim, "texels differ", &own.values(LIGHTS_DEPTHS_DIFFERING)))
}

fn claim(cases: &Cases<'_>) -> Finding {
    let ways = [LightWay::Passes, LightWay::Copied].map(LightWay::name);
    let pairs = at_least(cases, LIGHTS, LEAST_CLAIMED).pairs(LAYERS_BY, ways, &[]);
    let claim = "Maps of four lights and more are faster copied by a geometry shader in one pass than in a pass each \
                 (published in words):";
    let time = (maps(cases.clock()), Scope::DRAW);
    let says = (claim.to_owned(), Claim::Faster);
    compared(cases, (LAYERS_BY, &[]), time, &pairs, says)
}

/// The fastest way to the maps of the most lights, with its counters.
pub(super) fn recommended(cases: &Cases<'_>) -> Option<String> {
    let metric = maps(cases.clock());
    let own = cases.with(&[(EXPERIMENT, "lights")]);
    let (lights, own) = of_most(&own, LIGHTS, metric)?;
    let best = own.best(metric)?;
    let copied = own.with(&[(LAYERS_BY, LightWay::Copied.name())]).first();
    let copied = copied.filter(|copied| copied.id() != best.case.id());
    let against = copied.map(|copied| {
        format!(
            "; the published copies take {} ms with {} vertex shader invocations",
            said(copied, metric),
            said(copied, PIPELINE_VERTEX_INVOCATIONS),
        )
    });
    Some(format!(
        "Maps of {lights} lights are drawn fastest by {}{}: {} ms in {} passes with the picture, {} vertex shader \
             invocations{}.",
        best.case.condition(LAYERS_BY),
        best.tied_with(|case| case.condition(LAYERS_BY).to_owned()),
        significant(best.value),
        said(best.case, LIGHTS_PASSES),
        said(best.case, PIPELINE_VERTEX_INVOCATIONS),
        against.unwrap_or_default(),
    ))
}
