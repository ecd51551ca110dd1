// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on vertices made on the GPU.

use super::{ALLOWED_PX, PART};
use crate::clock::{DRAW, FRAME};
use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Block, ChapterError, Finding};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Vertices made on the GPU",
    text: "A spiral of 72 vertices a turn by the focus-local form, from the fan to the horizon: sent by the CPU, made \
           by a compute shader into the buffer that is drawn, or made by the vertex stage from the vertex's number. \
           Vertices are read back and held against f64; the vertex stage's picture is held to the compute shader's to \
           the bit. Native sines and cosines have a bound of 2^-11 in WGSL, 3 km on the Earth; series of ninth and \
           tenth order have one of their own. Over terrain each vertex is moved up by a height that it looks up where \
           it is, on the faces of a cube, which the paper leaves to the future. By its direction from the body's \
           centre, in f32, a vertex is half a metre off and its height with it. Locally it goes by its way from the \
           ground below the eye: heights and normals are differences from those there.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("view", VIEW),
        ("vertices", VERTICES),
        ("trigonometry", TRIG),
        ("law", LAW),
        ("heights", HEIGHTS),
        ("looked up", LOOKUP),
    ]),
    columns: &[
        Column::metric("sent a frame", GLOBE_UPLOAD_BYTES),
        Column::metric("px off f64, largest", GLOBE_MADE_PX_MAX),
        Column::metric("m off f64, largest", GLOBE_MADE_M_MAX),
        Column::metric("px that differ from compute's", GLOBE_MADE_DIFFERS_PX),
        Column::metric("vertices", GLOBE_VERTICES),
        FRAME,
        Column::metric("make and send, CPU ms", GLOBE_UPLOAD_CPU_MS),
        DRAW,
    ],
    findings: &[same_as_compute],
    more: &[displaced],
    ..Section::EMPTY
};

fn same_as_compute(cases: &Cases<'_>) -> Finding {
    let differs = cases.with(&[(VERTICES, "number")]);
    let differs = differs.values(GLOBE_MADE_DIFFERS_PX);
    let words = ["native", "series"].into_iter().filter_map(|trig| {
        let own = [(TRIG, trig), (VERTICES, "compute"), (HEIGHTS, "none")];
        let worst = cases.with(&own).greatest(GLOBE_MADE_PX_MAX)?;
        Some(format!("{trig}: {} px off at most", significant(worst)))
    });
    finding(
        "Vertices made by the vertex stage are those of the compute shader, to the pixel",
        (!differs.is_empty()).then(|| differs.iter().all(|px| *px == 0.0)),
        format!(
            "{} pixels differ in {} pictures. Against f64, {}.",
            differs.iter().sum::<f64>(),
            differs.len(),
            words.collect::<Vec<_>>().join(", ")
        ),
    )
}

/// What looking heights up in f32 costs on the ground; nothing where no vertex was displaced.
fn displaced(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let near = [(LOOKUP, "absolute"), (VIEW, "ground-1.7m")];
    let absolute = cases.with(&near).greatest(GLOBE_MADE_PX_MAX);
    let local = cases.with(&[(LOOKUP, "local")]).greatest(GLOBE_MADE_PX_MAX);
    let found = absolute.zip(local).map(|(absolute, local)| {
        finding(
            "Vertices displaced in the vertex stage stay where f64 puts them if heights are looked up locally",
            Some(local <= ALLOWED_PX),
            format!(
                "Locally they are {} px off at most in all views. By directions from the centre they are {} px off at \
                 1.7 m.",
                significant(local),
                significant(absolute)
            ),
        )
    });
    Ok(found.map(Block::Finding))
}
