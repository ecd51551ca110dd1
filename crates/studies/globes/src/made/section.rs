// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on vertices made on the GPU.

use super::PART;
use crate::keys::{
    GLOBE_MADE_DIFFERS_PX, GLOBE_MADE_M_MAX, GLOBE_MADE_PX_MAX, GLOBE_UPLOAD_BYTES,
    GLOBE_UPLOAD_CPU_MS, GLOBE_VERTICES, HEIGHTS, LAW, LOOKUP, TRIG, VERTICES, VIEW,
};
use crate::table::{by_case, cases, conditions};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Clock, Finding, Run, Standing, Table};

/// Views by whose pixels a height that is looked up in f32 is judged.
const NEAR: &str = "ground-1.7m";

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    [
        Block::section("Vertices made on the GPU"),
        Block::Text(
            "A spiral of 72 vertices a turn by the focus-local form, from the fan to the horizon: sent by the CPU, made \
             by a compute shader into the buffer that is drawn, or made by the vertex stage from the vertex's number. \
             Vertices are read back and held against f64; the vertex stage's picture is held to the compute shader's \
             to the bit. Native sines and cosines have a bound of 2^-11 in WGSL, 3 km on the Earth; series of ninth and \
             tenth order have one of their own."
                .to_owned(),
        ),
        Block::Text(
            "Over terrain each vertex is moved up by a height that it looks up where it is, on the faces of a cube; the \
             paper had no hardware for that and leaves it to the future. By its direction from the body's centre, in \
             f32, a vertex is half a metre off and its height with it. Locally it goes by its way from the ground below \
             the eye: heights and normals are differences from those there."
                .to_owned(),
        ),
        Block::Table(table(&cases, clock)),
        Block::Finding(finding(&cases)),
    ]
    .into_iter()
    .chain(displaced(&cases).map(Block::Finding))
    .collect()
}

/// What looking heights up in f32 costs on the ground; nothing where no vertex was displaced.
fn displaced(cases: &[&Case]) -> Option<Finding> {
    let worst = |lookup: &str, view: Option<&str>| {
        let own = cases.iter().filter(|case| {
            case.condition(LOOKUP) == lookup && view.is_none_or(|view| case.condition(VIEW) == view)
        });
        own.filter_map(|case| case.value(GLOBE_MADE_PX_MAX))
            .max_by(f64::total_cmp)
    };
    let (absolute, local) = (worst("absolute", Some(NEAR))?, worst("local", None)?);
    Some(Finding {
        claim: "Vertices displaced in the vertex stage stay where f64 puts them if heights are looked up locally"
            .to_owned(),
        standing: Standing::holds_if(local <= super::ALLOWED_PX),
        because: format!(
            "Locally they are {} px off at most in all views. By directions from the centre they are {} px off at 1.7 m.",
            significant(local),
            significant(absolute)
        ),
    })
}

fn table(cases: &[&Case], clock: Clock) -> Table {
    let columns = [
        ("sent a frame", GLOBE_UPLOAD_BYTES),
        ("px off f64, largest", GLOBE_MADE_PX_MAX),
        ("m off f64, largest", GLOBE_MADE_M_MAX),
        ("px that differ from compute's", GLOBE_MADE_DIFFERS_PX),
        ("vertices", GLOBE_VERTICES),
        ("frame, ms", crate::clock::whole(clock)),
        ("make and send, CPU ms", GLOBE_UPLOAD_CPU_MS),
        ("draw, ms", crate::clock::draw(clock)),
    ];
    by_case(
        "Vertices sent and made",
        cases,
        (
            &[
                "view",
                "vertices",
                "trigonometry",
                "law",
                "heights",
                "looked up",
            ],
            &conditions(&[VIEW, VERTICES, TRIG, LAW, HEIGHTS, LOOKUP]),
        ),
        &columns,
        &|_| "not measured",
    )
}

fn finding(cases: &[&Case]) -> Finding {
    let worst = |trig: &str| {
        let own = cases.iter().filter(|case| {
            case.condition(TRIG) == trig
                && case.condition(VERTICES) == "compute"
                && case.condition(HEIGHTS) == "none"
        });
        own.filter_map(|case| case.value(GLOBE_MADE_PX_MAX))
            .max_by(f64::total_cmp)
    };
    let differs: Vec<f64> = cases
        .iter()
        .filter(|case| case.condition(VERTICES) == "number")
        .filter_map(|case| case.value(GLOBE_MADE_DIFFERS_PX))
        .collect();
    let words: Vec<String> = ["native", "series"]
        .iter()
        .filter_map(|trig| {
            Some(format!(
                "{trig}: {} px off at most",
                significant(worst(trig)?)
            ))
        })
        .collect();
    Finding {
        claim: "Vertices made by the vertex stage are those of the compute shader, to the pixel"
            .to_owned(),
        standing: match differs.is_empty() {
            true => Standing::CannotTell,
            false => Standing::holds_if(differs.iter().all(|px| *px == 0.0)),
        },
        because: format!(
            "{} pixels differ in {} pictures. Against f64, {}.",
            differs.iter().sum::<f64>(),
            differs.len(),
            words.join(", ")
        ),
    }
}
