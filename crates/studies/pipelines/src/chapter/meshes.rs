// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that are no terrain: what each stage takes for them, and how near their triangles come to the surface.

use super::kit::{
    FRAME, WHOLE, beside, compared, counter, frame_time, gain, of_most, ratios, remark, said,
};
use crate::meshes::{CellCut, DeformWay, Division, ImageWay, MAX_PATCH_CELLS};
use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Names, Panel, Section, Select, finding, log_slope, range,
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
           or the tessellation stages, or the vertex shader alone. The error is the distance of the triangles from \
           the exact patches in double precision, the largest of seven places of each triangle. Pictures are held \
           against rays in double precision to the same triangles; of the tessellation stages, whose cut of a cell is \
           the driver's, against rays to the cells cut either way. Each triangle is shown in its light, every other \
           cell a little darker.",
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

const WHAT_OF_IMAGES: &str = "The published image is of another model, and neither its window nor its camera is stated: frames per second stand \
     here as ratios within their table alone. Its figures on the older cards, 271 and 713, are of points.";

pub(super) const IMAGES: Section<'static> = Section {
    title: "Geometry images",
    caption: "The image by every stage that fetches its texels",
    text: "A rabbit-like surface is where a sum of fields is 1. A program meshes it with irregular triangles, lays \
           these on a sphere along the field's lines, folds that onto an octahedron and unfolds the octahedron onto a \
           square of texels, each a place of the surface. Vulkan draws the square as points whose vertex shader \
           fetches a texel, and as triangles: a geometry shader makes the 2 × 2 texels of a cell, as published, or \
           another stage does. Errors are distances both ways in double precision: of seven places of each triangle \
           from the surface, and of the irregular mesh's vertices, which lie on it, from the triangles. They are \
           largest between and behind the ears, where those lines part and a texel spans most. The published order of \
           vertices cuts every cell one way, which in half of the square crosses the octahedron's folds. Pictures are \
           held against rays in double precision to the triangles as they are stored, points against projections.",
    cases: Select::With(EXPERIMENT, "image"),
    named_by: Names::Columns(&[
        ("texels a side", TEXELS),
        ("way", WAY),
        ("cut", CUT),
        ("stored", STORED),
    ]),
    findings: &[|cases| fetched_finding(cases)],
    drawing: Some(Drawing {
        caption: "Error against time: along each curve the texels rise.",
        panels: &[Panel {
            across: ("frame, ms", FRAME),
            up: (
                "distance from the surface, rms, m",
                Figure::Metric(SURFACE_ERROR_RMS_M),
            ),
            upwards: Upwards::Error,
            curve: Names::Joined(&[WAY, CUT, STORED]),
            knob: Figure::Condition(TEXELS),
            label: Some(Names::Joined(&[TEXELS])),
            ..Panel::EMPTY
        }],
    }),
    columns: &[
        Column::of("time, ms", FRAME),
        ratios("time ÷ that of points", |cases, case| {
            let points = beside(cases, case, &[(WAY, ImageWay::Points.name())]);
            gain(Some(case), points, frame_time(cases.clock()))
        }),
        Column::metric("rms, m", SURFACE_ERROR_RMS_M),
        Column::metric("largest distance, m", SURFACE_ERROR_MAX_M),
        Column::metric("largest, px", SURFACE_ERROR_PX),
        Column::metric("held", PIPELINE_HELD_BYTES),
        Column::metric("vertices given", PIPELINE_EMITTED_VERTICES),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("pixels in the band", PIPELINE_BAND_PX),
    ],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_OF_IMAGES)],
    ..Section::EMPTY
};

const WHAT_OF_MODELS: &str = "The paper names deformable models among what it streamed and gives neither set-up nor time of them: there is nothing \
     of it to compare.";

pub(super) const DEFORMED: Section<'static> = Section {
    title: "Deformed models",
    caption: "A model deformed once and kept, or in each drawing",
    text: "A dozen dents deform the rabbit of the geometry images. Vulkan draws it from either side into the halves \
           of one picture, by indices, twice or more often. Its vertices are deformed by the vertex shader in each \
           drawing; or once by vertices, which transform feedback streams into a buffer that the drawings read; or \
           once by compute. Halves are held against rays in double precision to the triangles deformed in double \
           precision, and kept vertices against those. Counters are those of the drawings alone.",
    cases: Select::With(EXPERIMENT, "deformed"),
    named_by: Names::Columns(&[("drawings", DRAWINGS), ("way", WAY)]),
    findings: &[
        |cases| deformed_finding(cases, DeformWay::Streamed),
        |cases| deformed_finding(cases, DeformWay::Computed),
    ],
    columns: &[
        Column::of("time, ms", FRAME),
        ratios("time ÷ that of deforming anew", |cases, case| {
            let anew = beside(cases, case, &[(WAY, DeformWay::Anew.name())]);
            gain(Some(case), anew, frame_time(cases.clock()))
        }),
        Column::metric("vertices deformed", DEFORMED_VERTICES),
        Column::metric("held", PIPELINE_HELD_BYTES),
        Column::metric("kept vertices' error, m", KEPT_ERROR_M),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
        Column::metric("pixels in the band", PIPELINE_BAND_PX),
    ],
    pictures: &[("picture", "")],
    more: &[|_| remark(WHAT_OF_MODELS)],
    ..Section::EMPTY
};

/// That keeping what was deformed is faster than deforming it in both drawings.
fn deformed_finding(cases: &Cases<'_>, way: DeformWay) -> Finding {
    let ways = [DeformWay::Anew, way].map(DeformWay::name);
    let pairs = cases.with(&[(DRAWINGS, "2")]).pairs(WAY, ways, &[]);
    let claim = format!(
        "A model drawn twice takes less time deformed once, {}, than in each drawing:",
        way.name()
    );
    let time = (frame_time(cases.clock()), WHOLE);
    compared(cases, (WAY, &[]), time, &pairs, (claim, Claim::Faster))
}

/// That the stage of 2007 is not needed for triangles of fetched texels.
fn fetched_finding(cases: &Cases<'_>) -> Finding {
    let ways = [ImageWay::Geometry, ImageWay::Indexed].map(ImageWay::name);
    let pairs = cases.pairs(WAY, ways, &[]);
    let claim = "Triangles of a geometry image are drawn in less time by indices, whose vertex shader fetches, than by \
                 the geometry shader:";
    let time = (frame_time(cases.clock()), WHOLE);
    compared(
        cases,
        (WAY, &[]),
        time,
        &pairs,
        (claim.to_owned(), Claim::Faster),
    )
}

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
    falls.into_iter().chain(folds(cases)).collect()
}

/// What is required of images: that cells cut along the folds are nearer.
fn folds(cases: &Cases<'_>) -> Option<Finding> {
    let own = cases.with(&[
        (EXPERIMENT, "image"),
        (WAY, ImageWay::NoBuffer.name()),
        (STORED, "f32"),
    ]);
    let cuts = [CellCut::Published, CellCut::Fold].map(CellCut::name);
    let pairs = own.pairs(CUT, cuts, &[]);
    let ratios = pairs.iter().filter_map(|pair| {
        let [published, fold] = pair.map(|case| case.value(SURFACE_ERROR_RMS_M));
        Some(published? / fold?)
    });
    let ratios: Vec<f64> = ratios.collect();
    let said = range(&ratios)?;
    Some(finding(
        "Cells of a geometry image cut along its folds are nearer to the surface, rms, than cut as published:",
        Some(ratios.iter().all(|ratio| *ratio > 1.0)),
        format!("{said} times as near"),
    ))
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
    let images = || {
        let own = cases.with(&[(EXPERIMENT, "image"), (STORED, "f32")]);
        let own = own.fitting(|case| case.condition(WAY) != ImageWay::Points.name());
        let (texels, own) = of_most(&own, TEXELS, metric)?;
        let nearest = own.least(SURFACE_ERROR_RMS_M)?;
        // The cut along folds is nearer: a way that errs more is not the one to take.
        let own = own.fitting(|case| case.value(SURFACE_ERROR_RMS_M) == Some(nearest));
        let best = own.best(metric)?;
        Some(format!(
            "A geometry image of {texels} × {texels}, {} m rms from the surface, is drawn by {}, cut {}: {} ms.",
            significant(nearest),
            best.case.condition(WAY),
            best.case.condition(CUT),
            significant(best.value),
        ))
    };
    let models = || {
        let own = cases.with(&[(EXPERIMENT, "deformed")]);
        let (drawings, own) = of_most(&own, DRAWINGS, metric)?;
        let best = own.best(metric)?;
        Some(format!(
            "A deformed model that is drawn {drawings} times a frame is drawn fastest by {}{}: {} ms.",
            best.case.condition(WAY),
            best.tied_with(|case| case.condition(WAY).to_owned()),
            significant(best.value),
        ))
    };
    patches()
        .into_iter()
        .chain(images())
        .chain(models())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Standing;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn errors_that_do_not_fall_and_folds_that_err_more_are_said() {
        let standings = |exponent: i32, fold: f64| {
            let mut made = MadeUpRun::default();
            let mut add = |name: &str, conditions: &[(&str, &str)], figure: (&'static str, f64)| {
                let case = made.case(case_id(crate::STUDY, name, conditions));
                case.figure(figure.0, figure.1);
            };
            for level in [2, 4, 8] {
                let error = f64::from(level).powi(exponent);
                let level = level.to_string();
                let conditions = [
                    ("experiment", "patches"),
                    ("way", "geometry-row"),
                    ("level", level.as_str()),
                ];
                add(&level, &conditions, ("surface_error_max_m", error));
            }
            for (cut, error) in [("published", 1.0), ("fold", fold)] {
                let conditions = [
                    ("experiment", "image"),
                    ("texels", "65"),
                    ("way", "no-vertex-buffer"),
                    ("cut", cut),
                    ("stored", "f32"),
                ];
                add(cut, &conditions, ("surface_error_rms_m", error));
            }
            let found = requirements(&Cases::of_study(&made.loaded(), crate::STUDY));
            found.iter().map(|of| of.standing).collect::<Vec<_>>()
        };
        assert_eq!(standings(-2, 0.4), [Standing::Holds; 2]);
        // Negative controls.
        assert_eq!(standings(-1, 1.1), [Standing::DoesNotHold; 2]);
    }
}
