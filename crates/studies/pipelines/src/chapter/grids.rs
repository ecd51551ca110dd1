// SPDX-License-Identifier: MIT OR Apache-2.0
//! Height grids: every way of every size.

use super::kit::{FRAME, counter, frame_time, gain, of_most, said};
use crate::metrics::*;
use terrafill_lab::{Cases, Column, Drawing, Figure, Names, Panel, Section, Select};
use terrafill_plot::number::{significant, times};

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
    ..Section::EMPTY
};

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
            "On {api} the fastest way to triangles of {cells}² cells, every pixel as by rays, is {}{}: {} ms for {} vertices given",
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

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Run, RunEnvironment, Status};

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
            said.contains("is sent-strips")
        };
        // Its GPU time is the least: the upload is outside of it.
        assert!(!fastest("discrete-gpu", 0.6, 0.3));
        // Negative controls: where the whole frame is faster it is named, by each device's own clock.
        assert!(fastest("discrete-gpu", 0.3, 0.6));
        assert!(!fastest("cpu", 0.3, 0.6));
        assert!(fastest("cpu", 0.6, 0.3));
    }

    #[test]
    fn a_faster_way_whose_picture_is_wrong_is_not_named() {
        let said = |status| {
            let mut made = MadeUpRun::default();
            for (way, ms, status) in [
                ("indexed-patch", 2.0, Status::Ok),
                ("mesh-shader", 1.0, status),
            ] {
                let conditions = [
                    ("experiment", "grid"),
                    ("api", "vulkan"),
                    ("way", way),
                    ("grid_cells", "256"),
                ];
                let case = made.case(case_id(crate::STUDY, way, &conditions));
                case.timed("pipeline_cpu_ms", &[ms]);
                case.ended(status, "");
            }
            recommended(&Cases::of_study(&made.loaded(), crate::STUDY)).join(" ")
        };
        assert!(
            said(Status::Wrong).contains("is indexed-patch"),
            "{}",
            said(Status::Wrong)
        );
        // Negative control: right, it is.
        assert!(
            said(Status::Ok).contains("is mesh-shader"),
            "{}",
            said(Status::Ok)
        );
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
