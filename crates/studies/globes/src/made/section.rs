// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on vertices made on the GPU.

use super::PART;
use crate::table::{by_case, cases, conditions};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Clock, Finding, Run, Standing, Table};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    vec![
        Block::section("Vertices made on the GPU"),
        Block::Text(
            "A spiral of 72 vertices a turn by the focus-local form, from the fan to the horizon: sent by the CPU, made \
             by a compute shader into the buffer that is drawn, or made by the vertex stage from the vertex's number. \
             Vertices are read back and held against f64; the vertex stage's picture is held to the compute shader's \
             to the bit. Native sines and cosines have a bound of 2^-11 in WGSL, 3 km on the Earth; series of ninth and \
             tenth order have one of their own."
                .to_owned(),
        ),
        Block::Table(table(&cases, clock)),
        Block::Finding(finding(&cases)),
    ]
}

fn table(cases: &[&Case], clock: Clock) -> Table {
    let columns = [
        ("sent a frame", "globe_upload_bytes"),
        ("px off f64, largest", "globe_made_px_max"),
        ("m off f64, largest", "globe_made_m_max"),
        ("px that differ from compute's", "globe_made_differs_px"),
        ("vertices", "globe_vertices"),
        ("frame, ms", crate::clock::whole(clock)),
        ("make and send, CPU ms", "globe_upload_cpu_ms"),
        ("draw, ms", crate::clock::draw(clock)),
    ];
    by_case(
        "Vertices sent and made",
        cases,
        (
            &["view", "vertices", "trigonometry", "law"],
            &conditions(&["view", "vertices", "trig", "law"]),
        ),
        &columns,
        &|_| "not measured",
    )
}

fn finding(cases: &[&Case]) -> Finding {
    let worst = |trig: &str| {
        let own = cases.iter().filter(|case| {
            case.condition("trig") == trig && case.condition("vertices") == "compute"
        });
        own.filter_map(|case| case.value("globe_made_px_max"))
            .max_by(f64::total_cmp)
    };
    let differs: Vec<f64> = cases
        .iter()
        .filter(|case| case.condition("vertices") == "number")
        .filter_map(|case| case.value("globe_made_differs_px"))
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
