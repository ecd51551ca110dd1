// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter says of outlines.

use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Comparison, Names, Section, Select, finding, measured, none_differs,
};
use terrafill_results::condition::{API, SIZE_PX};
use terrafill_results::{Case, Claim, Finding, Scope};

/// Outlines of all numbers of models.
pub const SECTION: Section<'static> = Section {
    title: "Outlines by a stencil value",
    text: "Not a shadow technique: a value S for each model instead of a clear (McGuire & Hughes, 2004). The port's models, \
           and copies of them, turned and stretched, are seen from 300 m up. One copy in four lies alongside the one that has \
           its value where values come round. Each model writes S where its depth test passes; then its contour edges, found \
           for the eye in f64, are drawn as strokes with round ends. A stroke has the depth of its edge, is tested and written \
           by it, and is kept where the stencil is not S. The paper prints the test as \"stencil == S\", which keeps inner \
           contours instead. The reference plays the method through at each pixel, model after model, by numbers that never \
           repeat. A clear is a pass of its own, since WebGPU clears nothing within one.",
    cases: Select::Fitting(is_drawn),
    named_by: Names::Joined(&[API, MODELS, STROKE_PX, OUTLINE, SIZE_PX]),
    columns: &[
        Column::metric("clears", SHADOW_CLEARS),
        Column::metric("wrong px", SHADOW_CONTOUR_PX),
        Column::metric("unlike clears, px", SHADOW_OUTLINE_UNLIKE_PX)
            .or("clears were not drawn before it"),
        Column::metric("strokes, px", SHADOW_OUTLINE_PX),
        Column::metric("undecided px", SHADOW_OUTLINE_UNDECIDED_PX),
        Column::clocked("frame, ms", OUTLINE_GPU_MS, OUTLINE_CPU_MS)
            .or("only right pictures are timed"),
    ],
    is_main: true,
    shows_what_is_wrong: true,
    pictures: &[("image", "as drawn, wrong pixels red")],
    ..Section::EMPTY
};

/// Whether a case was drawn: runs of older programs count contours along a made-up line of pixels.
fn is_drawn(case: &Case) -> bool {
    !case.condition(STROKE_PX).is_empty()
}

/// Whether a value for each model draws what clears draw, in how many clears and in which time.
#[must_use]
pub fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let cases = &cases.fitting(is_drawn);
    let values = cases.with(&[(OUTLINE, "value")]);
    let all = [pictures(cases), clears(&values), time(cases)];
    all.into_iter().flatten().collect()
}

fn name(case: &Case) -> String {
    let [models, width] = [MODELS, STROKE_PX].map(|key| case.condition(key));
    format!("{models} models, {width} px")
}

fn pictures(cases: &Cases<'_>) -> Option<Finding> {
    let right = cases.fitting(|case| ["clear", "value"].contains(&case.condition(OUTLINE)));
    let wrong = |case: &Case| {
        let px = measured(case, SHADOW_CONTOUR_PX)?;
        Some(px + measured(case, SHADOW_OUTLINE_UNLIKE_PX).unwrap_or(0.0))
    };
    let judged: Vec<(String, f64)> = right
        .iter()
        .filter_map(|case| Some((name(case), wrong(case)?)))
        .collect();
    let differing = judged.iter().filter(|(_, px)| *px > 0.0);
    let differing: Vec<String> = differing.map(|(name, _)| name.clone()).collect();
    let claim = "A stencil value for each model leaves out the same contours as a clear for each.";
    let what = "show what the reference has, by either, and one picture by both";
    (!judged.is_empty()).then(|| none_differs(claim, judged.len(), &differing, what))
}

fn clears(values: &Cases<'_>) -> Option<Finding> {
    let mut pairs = values.series(MODELS, SHADOW_CLEARS);
    pairs.dedup();
    let text = pairs.iter();
    let text: Vec<String> = text
        .map(|(models, clears)| format!("{models}: {clears}"))
        .collect();
    let is_as_said = |(models, clears): &(f64, f64)| *clears == 1.0 + (models / 255.0).floor();
    (!pairs.is_empty()).then(|| {
        finding(
            "A stencil value for each model takes 1 + ⌊N/255⌋ clears.",
            Some(pairs.iter().all(is_as_said)),
            format!("Clears by models: {}", text.join(", ")),
        )
    })
}

fn time(cases: &Cases<'_>) -> Option<Finding> {
    // "For a scene with many objects": from where values come round.
    let is_many = |case: &Case| {
        case.condition(MODELS)
            .parse()
            .is_ok_and(|models: u32| models >= 254)
    };
    let pairs = cases
        .fitting(is_many)
        .pairs(OUTLINE, ["clear", "value"], &[]);
    let comparison = Comparison {
        changed: OUTLINE.name(),
        follows: &[],
        one_sided: None,
        metric: cases.clock().pick(OUTLINE_GPU_MS, OUTLINE_CPU_MS),
        needs: Scope::DRAW,
    };
    let names: Vec<String> = pairs.iter().map(|[clear, _]| name(clear)).collect();
    let claim = format!(
        "A stencil value for each model is faster than a clear for each: time by clears ÷ by values, of {}.",
        names.join("; ")
    );
    (!pairs.is_empty()).then(|| cases.compared(&comparison, &pairs, Claim::Faster, claim))
}
