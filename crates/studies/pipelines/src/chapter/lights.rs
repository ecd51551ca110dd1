// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows of several lights: depth maps in one pass or in many, with the counters behind their times.

use super::kit::{
    TIME, beside, compared, counter, gain, none_of, of_most, percent, ratios, remark, said,
};
use crate::lights::{LightWay, ShadowFilter};
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Claim, Clock, Finding, Metric, Scope};

const WHAT_WAS_PUBLISHED: &str = "Published are \"2 passes\" in words, without number of lights, sizes or times. A geometry shader was given 32 \
     matrices, so at most 10 lights of three, or 15 that share one. Multiview has a limit of views a \
     pass; more lights take several passes, all with as many views.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Shadows of several lights",
    caption: "Depth maps of several lights, by every way on Vulkan",
    text: "Distant lights stand all round ground with towers and domes on it. Their depth maps are the layers of one image; the picture's pixels \
           say which lights reach them, by one lookup each: the lighter, the more of them. The published way draws all \
           maps in one pass, in which a geometry shader copies each triangle into every layer; a pass a light is what \
           it is held against. Each geometry shader is compiled for its number of lights. All ways leave the same depths bit for bit. The reference follows the ray of each map's \
           texel, and beside it the ray of the place itself, whose difference is the map's error.",
    cases: Select::With(EXPERIMENT, "lights"),
    named_by: Names::Columns(&[("lights", LIGHTS), ("layers by", LAYERS_BY)]),
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

pub(super) const CUBE: Section<'static> = Section {
    title: "A cube map in one pass",
    caption: "Six faces of a cube of depths and colours, by every way on Vulkan",
    text: "A cube of depths and colours around a place above the ground has six faces, the layers of two images. They are \
           drawn in a pass each, or in one pass: by a geometry shader for six copies or six invocations, by instances \
           whose vertex shader chooses the layer, or as six views. A colour is the number of a triangle. All ways leave the same depths and colours bit for bit. Rays in f64 from \
           the middle judge all texels along the seams and one in 61 of the others; the picture says which face sees a pixel, and \
           whether the middle does.",
    cases: Select::With(EXPERIMENT, "cube"),
    findings: &[cube_claim],
    named_by: Names::Columns(&[("texels a side", MAP_TEXELS), ("faces by", LAYERS_BY)]),
    columns: &[
        Column::clocked("faces, ms", LIGHTS_MAPS_GPU_MS, LIGHTS_MAPS_CPU_MS),
        ratios("time ÷ that of passes", |cases, case| {
            let passes = beside(cases, case, &[(LAYERS_BY, LightWay::Passes.name())]);
            gain(Some(case), passes, maps(cases.clock()))
        }),
        Column::metric("passes", LIGHTS_PASSES),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("seam texels", CUBE_SEAM_TEXELS),
        Column::metric("wrong along seams", CUBE_SEAM_WRONG),
        Column::metric("wrong elsewhere", CUBE_INNER_WRONG),
        Column::metric("wrong colours", CUBE_COLOUR_WRONG),
        Column::metric("texels that differ", LIGHTS_DEPTHS_DIFFERING),
        Column::metric("wrong pixels", PIPELINE_MISMATCHED_PX),
    ],
    pictures: &[("picture", ""), ("faces", "Six faces, unfolded")],
    ..Section::EMPTY
};

fn cube_claim(cases: &Cases<'_>) -> Finding {
    let ways = [LightWay::Passes, LightWay::Copied].map(LightWay::name);
    let pairs = cases.pairs(LAYERS_BY, ways, &[]);
    let claim = "Six faces of a cube are faster copied by a geometry shader in one pass than in a pass each (published in \
                 words):";
    let time = (maps(cases.clock()), Scope::DRAW);
    compared(
        cases,
        (LAYERS_BY, &[]),
        time,
        &pairs,
        (claim.to_owned(), Claim::Faster),
    )
}

const WHAT_EXACT_IS: &str = "Lights are points at infinity, so that exact visibility of a light is 0 or 1. A filter that blurs edges errs there by \
     what it blurs, however soft a shadow may be wanted. The published formula has neither bias nor floor.";

pub(super) const SOFT: Section<'static> = Section {
    title: "Shadows by filters",
    caption: "Four lights over terrain with objects, by filters of their maps",
    text: "The maps of four lights are filtered by the picture: one depth, 5 × 5 depths compared, or mean and variance of \
           5 × 5 depths as published. A pixel is the mean share of light. Pictures are judged by the formula in f64 over \
           the maps that the device has. Errors are against exact visibility by rays in f64 from each place to each \
           light.",
    cases: Select::With(EXPERIMENT, "soft"),
    findings: &[variance_errs_less],
    named_by: Names::Columns(&[("texels a side", MAP_TEXELS), ("filter", SHADOW_FILTER)]),
    columns: &[
        Column::metric("rms error", SOFT_RMS),
        Column::metric("mean error", SOFT_MEAN),
        Column::of("maps and picture, ms", TIME),
        Column::metric("maps", PIPELINE_HELD_BYTES),
        Column::metric("wrong pixels", PIPELINE_MISMATCHED_PX),
    ],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_EXACT_IS)],
    ..Section::EMPTY
};

/// Whether the published filter errs less than one depth, at every size of the maps.
fn variance_errs_less(cases: &Cases<'_>) -> Finding {
    let filters = [ShadowFilter::Hard, ShadowFilter::Variance].map(ShadowFilter::name);
    let pairs = cases.pairs(SHADOW_FILTER, filters, &[]);
    let errors = pairs.iter().filter_map(|pair| {
        let [hard, soft] = pair.map(|case| case.value(SOFT_RMS));
        Some([hard?, soft?])
    });
    let errors: Vec<[f64; 2]> = errors.collect();
    let said = errors
        .iter()
        .map(|[hard, soft]| format!("{} against {}", significant(*soft), significant(*hard)));
    finding(
        "The published variance of 25 depths errs less against exact visibility than one depth:",
        (!errors.is_empty()).then(|| errors.iter().all(|[hard, soft]| soft < hard)),
        said.collect::<Vec<_>>().join(", "),
    )
}

fn maps(clock: Clock) -> &'static Metric {
    clock.pick(LIGHTS_MAPS_GPU_MS, LIGHTS_MAPS_CPU_MS)
}

/// What is required: the same texels everywhere.
pub(super) fn requirement(cases: &Cases<'_>) -> Option<Finding> {
    let own = cases.fitting(|case| ["lights", "cube"].contains(&case.condition(EXPERIMENT)));
    let claim = "Every way to the maps of several lights leaves the same depths, and to a cube's faces the same depths and colours, \
                 bit for bit";
    (!own.is_empty()).then(|| none_of(claim, "texels differ", &own.values(LIGHTS_DEPTHS_DIFFERING)))
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
