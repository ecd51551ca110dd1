// SPDX-License-Identifier: MIT OR Apache-2.0
//! Height grids: every way of every size, and the published ratios beside ours.

use super::kit::{
    FRAME, WHOLE, at_least, compared, counter, frame_time, gain, of_most, remark, said,
};
use super::published::{CARDS, GRIDS, GridRow};
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Drawing, Figure, Names, Panel, Section, Select};
use terrafill_plot::number::{significant, times};
use terrafill_results::{Block, Cell, Claim, Finding, Heading, Row, Table};

/// What the published figures cannot show.
const WHAT_THEY_CANNOT_SHOW: &str = "Published figures are frames per second, one a case. The window, the camera, the vertex formats and how \
     vertices were sent are not stated, so fragments and transfers may be part of any of them. Columns 1 \
     and 3 of that table draw points, 2 and 4 triangles: only 1 with 3 and 2 with 4 draw the same. The \
     text's 14, 32 and 270 frames a second for 1000² fetched points agree with the table on the last card \
     alone.";

/// Sizes from which on the claims are read.
const LEAST_CLAIMED: u32 = 256;

pub(super) const SECTION: Section<'static> = Section {
    title: "Height grids",
    text: "Points of sent and fetched points are no triangles: compare them with each other alone. Times run from before \
           a frame's upload until the device is done: wall clock where GPU times are compared elsewhere, since those do \
           not cover what the CPU writes for a frame, else process CPU time. Pictures show numbers of triangles or \
           points, cells as a chessboard, both halves of a cell in a shade of their own; wrong pixels would be red.",
    cases: Select::With(EXPERIMENT, "grid"),
    named_by: Names::Columns(&[("cells a side", GRID_CELLS), ("way", WAY)]),
    columns: &[
        Column::of("time, ms", FRAME),
        Column::metric("sent a frame", PIPELINE_SENT_BYTES),
        Column::metric("held", PIPELINE_HELD_BYTES),
        Column::metric("vertices given", PIPELINE_EMITTED_VERTICES),
        counter("vertices shaded", PIPELINE_VERTEX_INVOCATIONS),
        Column::metric("draws", PIPELINE_DRAWS),
        Column::metric("pixels in the band", PIPELINE_BAND_PX),
    ],
    per: Some(API),
    is_main: true,
    findings: &[
        |cases| published_finding(cases, &COMPARISONS[0], "wgpu"),
        |cases| published_finding(cases, &COMPARISONS[0], "vulkan"),
        |cases| published_finding(cases, &COMPARISONS[1], "vulkan"),
        |cases| published_finding(cases, &COMPARISONS[2], "vulkan"),
    ],
    drawing: Some(Drawing {
        caption: "Time of a frame against the grid's points. Left out: what the interface lacks.",
        panels: &[Panel {
            across: (
                "points of the grid",
                Figure::Computed(|case| {
                    let cells: f64 = case.condition(GRID_CELLS).parse().ok()?;
                    Some(cells.powi(2))
                }),
            ),
            up: ("ms: median, 5–95 %", FRAME),
            curve: Names::Joined(&[WAY]),
            knob: Figure::Condition(GRID_CELLS),
            ..Panel::EMPTY
        }],
    }),
    pictures: &[("picture", "")],
    more: &[
        |cases| Ok(Some(Block::Table(comparisons(cases)))),
        |_| remark(WHAT_THEY_CANNOT_SHOW),
    ],
    ..Section::EMPTY
};

/// A comparison that was published.
struct Published {
    claim: &'static str,
    /// Ways whose times are divided: first over second.
    ways: [&'static str; 2],
    says: Claim,
    ratio: fn(&GridRow, usize) -> Option<f64>,
}

const COMPARISONS: [Published; 3] = [
    Published {
        claim: "Fetched heights beat sent points",
        ways: ["sent-points", "fetched-points"],
        says: Claim::Faster,
        ratio: |row, card| Some(row.fps[card][2] / row.fps[card][0]),
    },
    Published {
        claim: "Triangles of a geometry shader beat sent strips",
        ways: ["sent-strips", "geometry-shader"],
        says: Claim::Faster,
        ratio: |row, card| (card == 2).then(|| row.geometry_fps / row.fps[card][1]),
    },
    Published {
        claim: "Triangles of a geometry shader cost more than fetched points, at most 0.8 of their rate",
        ways: ["fetched-points", "geometry-shader"],
        says: Claim::LessThan(0.8),
        ratio: |row, card| (card == 2).then(|| row.geometry_fps / row.fps[card][2]),
    },
];

fn published_finding(cases: &Cases<'_>, published: &Published, api: &str) -> Finding {
    let own = at_least(&cases.with(&[(API, api)]), GRID_CELLS, LEAST_CLAIMED);
    let pairs = own.pairs(WAY, published.ways, &[]);
    let claim = format!("{}, on {api} (published, measured):", published.claim);
    let time = (frame_time(cases.clock()), WHOLE);
    compared(cases, (WAY, &[]), time, &pairs, (claim, published.says))
}

/// The fastest way to draw the triangles of the largest grid on each interface, with the counters behind
/// it, and by how much each published way of triangles is slower.
pub(super) fn recommended(cases: &Cases<'_>) -> Vec<String> {
    let metric = frame_time(cases.clock());
    let on = |api: &str| {
        let own = cases.with(&[(EXPERIMENT, "grid"), (API, api)]);
        let of_triangles = own.fitting(|case| !case.condition(WAY).ends_with("-points"));
        let (cells, of_largest) = of_most(&of_triangles, GRID_CELLS, metric)?;
        let best = of_largest.best(metric)?;
        let mut sentence = format!(
            "On {api} the fastest way to triangles of {cells}² cells is {}{}: {} ms for {} vertices given",
            best.case.condition(WAY),
            best.tied_with(|case| case.condition(WAY).to_owned()),
            significant(best.value),
            said(best.case, PIPELINE_EMITTED_VERTICES),
        );
        if let Some(shaded) = best.case.value(PIPELINE_VERTEX_INVOCATIONS) {
            let shaded = significant(shaded);
            sentence.push_str(&format!(" and {shaded} vertex shader invocations"));
        }
        for way in ["sent-strips", "geometry-shader"] {
            let other = of_largest.with(&[(WAY, way)]).first();
            let slower = other.filter(|other| other.id() != best.case.id());
            if let Some(slower) = gain(slower, Some(best.case), metric) {
                sentence.push_str(&format!("; {way} takes {} times as long", times(&slower)));
            }
        }
        Some(sentence + ".")
    };
    ["vulkan", "wgpu"].into_iter().filter_map(on).collect()
}

/// The published ratios beside ours.
fn comparisons(cases: &Cases<'_>) -> Table {
    let metric = frame_time(cases.clock());
    let mut rows = Vec::new();
    for comparison in &COMPARISONS {
        for (cells, of_size) in cases.by(GRID_CELLS) {
            let row = GRIDS.iter().find(|row| row.cells.to_string() == cells);
            let published = |card| {
                let ratio = row.and_then(|row| (comparison.ratio)(row, card));
                let absent = match row {
                    None => "not a published size",
                    Some(_) => "this card has no geometry shaders",
                };
                Cell::or_absent(ratio.map(significant), absent)
            };
            let measured = |api: &str| {
                if api == "wgpu" && comparison.ways.contains(&"geometry-shader") {
                    return Cell::absent("WebGPU has no geometry shaders");
                }
                let own = of_size.with(&[(API, api)]);
                let [slow, fast] = comparison.ways.map(|way| own.with(&[(WAY, way)]).first());
                let gain = gain(slow, fast, metric);
                Cell::or_absent(gain.as_ref().map(times), "not measured")
            };
            let [slow, fast] = comparison.ways;
            let mut row = vec![Cell::name(format!("{slow} ÷ {fast}")), Cell::plain(cells)];
            row.extend((0..CARDS.len()).map(published));
            row.extend(["vulkan", "wgpu"].map(measured));
            rows.push(Row::new(row));
        }
    }
    let names = ["time of … ÷ time of …", "cells a side"].map(Heading::plain);
    let cards = CARDS.map(|card| Heading::explained(card, "published: ratio of frames per second"));
    let ours = ["here, vulkan", "here, wgpu"];
    let ours = ours.map(|api| Heading::explained(api, "ratio of times, with its 95 % interval"));
    Table {
        caption: "How many times as fast the second way is as the first".to_owned(),
        headings: names.into_iter().chain(cards).chain(ours).collect(),
        rows,
        ..Table::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Run, RunEnvironment};

    /// Milliseconds by GPU, wall and process CPU.
    fn run_of(device_type: &str, figures: &[(&str, [f64; 3])]) -> Run {
        let mut made = MadeUpRun {
            environment: RunEnvironment {
                device_type: device_type.to_owned(),
                gpu_timestamps: true,
                ..RunEnvironment::default()
            },
            ..MadeUpRun::default()
        };
        for (way, [gpu, wall, cpu]) in figures {
            let conditions = [
                ("experiment", "grid"),
                ("api", "wgpu"),
                ("way", *way),
                ("grid_cells", "256"),
            ];
            let case = made.case(case_id(crate::STUDY, way, &conditions));
            case.timed("pipeline_gpu_ms", &[*gpu]);
            case.timed("pipeline_wall_ms", &[*wall]);
            case.timed("pipeline_cpu_ms", &[*cpu]);
        }
        made.loaded()
    }

    fn said_of(device_type: &str, figures: &[(&str, [f64; 3])]) -> String {
        let run = run_of(device_type, figures);
        recommended(&Cases::of_study(&run, crate::STUDY)).join(" ")
    }

    #[test]
    fn what_is_sent_each_frame_is_ranked_by_a_clock_that_covers_it() {
        let fastest = |device_type, sent_wall, sent_cpu| {
            let said = said_of(
                device_type,
                &[
                    ("sent-strips", [0.1, sent_wall, sent_cpu]),
                    ("no-vertex-buffer", [0.2, 0.4, 0.5]),
                ],
            );
            said.contains("256² cells is sent-strips")
        };
        // Its GPU time is the least: the upload is outside of it.
        assert!(!fastest("discrete-gpu", 0.6, 0.3));
        // Negative controls: where the whole frame is faster it is named, by each device's own clock.
        assert!(fastest("discrete-gpu", 0.3, 0.6));
        assert!(!fastest("cpu", 0.3, 0.6));
        assert!(fastest("cpu", 0.6, 0.3));
    }

    #[test]
    fn ways_within_the_noise_are_a_tie() {
        let tied = |other: f64| {
            let figures = [
                ("no-vertex-buffer", [1.0; 3]),
                ("indexed-patch", [other; 3]),
            ];
            said_of("cpu", &figures).contains("no-vertex-buffer, tied with indexed-patch")
        };
        assert!(tied(1.001));
        // Negative control.
        assert!(!tied(1.5));
    }
}
