// SPDX-License-Identifier: MIT OR Apache-2.0
//! Amplification: bytes and time of grids whose cells a geometry shader makes of fewer and fewer points.

use super::kit::{
    FRAME, WHOLE, beside, compared, counter, frame_time, gain, of_most, ratios, remark, said,
};
use super::published::AMPLIFICATION;
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Claim, Finding};

/// What the published table says, and what it does not.
const WHAT_THEY_CANNOT_SHOW: &str = "The published table counts k × k generated vertices for a point, which is read here as (k/2)² cells of four \
     vertices: it is the one reading under which all its rows draw the same triangles and none exceeds \
     the driver's 128 vertices. Its text says that generating geometry saves bandwidth; its figures say \
     that 4 and 16 times fewer points took 2.2 and 8.5 to 9.7 times as long. Points are sent as 4-byte \
     numbers here.";

pub(super) const SECTION: Section<'static> = Section {
    title: "Amplification",
    caption: "The same triangles by fewer and fewer points",
    text: "The same triangles by fewer and fewer points: bytes and time, by the clock of height grids.",
    cases: Select::With(EXPERIMENT, "amplify"),
    findings: &[|cases| slower(cases, "4"), |cases| slower(cases, "16")],
    more: &[|_| remark(WHAT_THEY_CANNOT_SHOW)],
    named_by: Names::Columns(&[
        ("cells a side", GRID_CELLS),
        ("points", SOURCE),
        ("cells a point", CELLS_PER_POINT),
        ("strip", STRIP),
    ]),
    columns: &[
        Column::metric("sent a frame", PIPELINE_SENT_BYTES),
        Column::of("time, ms", FRAME),
        ratios("time ÷ that of a cell a point", |cases, case| {
            let first = beside(cases, case, &[(CELLS_PER_POINT, "1"), (STRIP, "cell")]);
            gain(Some(case), first, frame_time(cases.clock()))
        })
        .meaning("with its 95 % interval"),
        Column::of("the same, published", Figure::Words(published_of))
            .meaning("ratio of frames per second, 8800 GTX")
            .or("not published"),
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
        let [count, strip] = [CELLS_PER_POINT, STRIP].map(|key| case.condition(key));
        format!("{count} cells a point in strips of a {strip}")
    };
    Some(format!(
        "Geometry shaders make {cells}² cells of stored points fastest with {}{}: {} ms for {} vertices given.",
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

/// How much faster than a cell a point so many cells a point are: below 1 where they are slower.
fn slower(cases: &Cases<'_>, per_point: &str) -> Finding {
    let own = cases.with(&[(STRIP, "cell")]);
    let pairs = own.pairs(CELLS_PER_POINT, ["1", per_point], &[]);
    let rows = AMPLIFICATION.iter().map(|row| row.cells.to_string());
    let published: Vec<String> = rows
        .flat_map(|cells| ["sent", "stored"].map(|source| published(&cells, per_point, source)))
        .flatten()
        .map(|slower| significant(1.0 / slower))
        .collect();
    let claim = format!(
        "A frame of {per_point} cells a point is faster than one of a cell a point (implied; the published \
         table says slower, {} times as fast):",
        published.join("; ")
    );
    let time = (frame_time(cases.clock()), WHOLE);
    compared(
        cases,
        (CELLS_PER_POINT, &[]),
        time,
        &pairs,
        (claim, Claim::Faster),
    )
}

/// Time over that of a cell a point.
fn published(cells: &str, per_point: &str, source: &str) -> Option<f64> {
    let row = AMPLIFICATION
        .iter()
        .find(|row| row.cells.to_string() == cells)?;
    let fps = match source {
        "sent" => row.sent_fps,
        _ => row.stored_fps,
    };
    let column = ["1", "4", "16"]
        .iter()
        .position(|known| *known == per_point)?;
    Some(fps[0] / fps[column])
}

fn published_of(case: &Case) -> Option<String> {
    let [cells, per_point, strip, source] =
        [GRID_CELLS, CELLS_PER_POINT, STRIP, SOURCE].map(|key| case.condition(key));
    let known = published(cells, per_point, source).filter(|_| strip == "cell");
    known.map(significant)
}
