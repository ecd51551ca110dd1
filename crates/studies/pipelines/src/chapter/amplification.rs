// SPDX-License-Identifier: MIT OR Apache-2.0
//! Amplification: bytes and time of grids whose cells a geometry shader makes of fewer and fewer points.

use super::kit::{FRAME, beside, counter, frame_time, gain, of_most, ratios, said};
use crate::metrics::*;
use crate::way::AS_EMITTED;
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Finding};

pub(super) const SECTION: Section<'static> = Section {
    title: "Amplification",
    caption: "The same triangles by fewer and fewer points",
    text: "The same triangles by fewer and fewer points: bytes and time, by the clock of height grids. Points are 4-byte \
           numbers. A geometry shader declares how many vertices it may emit at most: as many as it emits, or 128, the \
           published cap, with the same vertices emitted.",
    cases: Select::With(EXPERIMENT, "amplify"),
    named_by: Names::Columns(&[
        ("cells a side", GRID_CELLS),
        ("points", SOURCE),
        ("cells a point", CELLS_PER_POINT),
        ("strip", STRIP),
        ("vertices declared", DECLARED),
    ]),
    columns: &[
        Column::metric("sent a frame", PIPELINE_SENT_BYTES),
        Column::of("time, ms", FRAME),
        ratios("time ÷ that of a cell a point", |cases, case| {
            let first = beside(cases, case, &[(CELLS_PER_POINT, "1"), (STRIP, "cell")]);
            gain(Some(case), first, frame_time(cases.clock()))
        })
        .meaning("with its 95 % interval"),
        ratios(
            "time ÷ that of vertices declared as emitted",
            |cases, case| {
                let emitted = beside(cases, case, &[(DECLARED, AS_EMITTED)]);
                let other = emitted.filter(|emitted| emitted.id() != case.id());
                gain(Some(case), other, frame_time(cases.clock()))
            },
        )
        .or("declared as emitted"),
        Column::metric("vertices given", PIPELINE_EMITTED_VERTICES),
        counter("geometry invocations", PIPELINE_GEOMETRY_INVOCATIONS),
        counter("primitives", PIPELINE_PRIMITIVES),
    ],
    is_main: true,
    ..Section::EMPTY
};

/// How many cells a point should make, by the largest grid.
pub(super) fn recommended(cases: &Cases<'_>) -> Option<String> {
    let metric = frame_time(cases.clock());
    let own = cases.with(&[(EXPERIMENT, "amplify"), (SOURCE, "stored")]);
    let (cells, of_largest) = of_most(&own, GRID_CELLS, metric)?;
    let best = of_largest.best(metric)?;
    let name = |case: &Case| {
        let [count, strip, declared] =
            [CELLS_PER_POINT, STRIP, DECLARED].map(|key| case.condition(key));
        let cells = if count == "1" { "cell" } else { "cells" };
        let more = match declared {
            AS_EMITTED => String::new(),
            some => format!(" with {some} vertices declared"),
        };
        format!("{count} {cells} a point in strips of a {strip}{more}")
    };
    Some(format!(
        "Geometry shaders make {cells}² cells of stored points fastest by {}{}: {} ms for {} vertices given.",
        name(best.case),
        best.tied_with(name),
        significant(best.value),
        said(best.case, PIPELINE_EMITTED_VERTICES),
    ))
}

/// That bytes fall as points do.
pub(super) fn bytes_finding(cases: &Cases<'_>) -> Option<Finding> {
    let own = cases.with(&[(EXPERIMENT, "amplify")]);
    let of_cells = own.with(&[(STRIP, "cell"), (SOURCE, "sent")]);
    let falls = [("4", 4.0), ("16", 16.0)]
        .into_iter()
        .flat_map(|(count, expected)| {
            let pairs = of_cells.pairs(CELLS_PER_POINT, ["1", count], &[]);
            pairs.into_iter().filter_map(move |pair| {
                let [all, few] = pair.map(|case| case.value(PIPELINE_SENT_BYTES));
                Some((all? / few?, expected))
            })
        });
    let falls: Vec<(f64, f64)> = falls.collect();
    let is_right = |(fall, expected): &(f64, f64)| (fall - expected).abs() < 1e-9;
    let said: Vec<String> = falls
        .iter()
        .map(|(fall, _)| format!("÷ {}", significant(*fall)))
        .collect();
    (!own.is_empty()).then(|| {
        finding(
            "Generating 4 and 16 cells of a point sends a quarter and a sixteenth of the bytes:",
            (!falls.is_empty()).then(|| falls.iter().all(is_right)),
            said.join(", "),
        )
    })
}
