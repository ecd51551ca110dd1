// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    PIECES = "pieces";
}

/// Note with the path of a case's picture.
pub(crate) const IMAGE: &str = "image";

pub(crate) const FRAME_CPU: &Metric = &frame_ms(
    "flight_frame_cpu_ms",
    "Process CPU time of a frame: surface, plan, upload and fill, pieces made by the way \
     included; median of a flight.",
)
.ranking(Primary::Cpu);
pub(crate) const WORST_CPU: &Metric = &frame_ms(
    "flight_worst_frame_cpu_ms",
    "The same of the worst frame of a flight after its first.",
);
pub(crate) const FRAME_WALL: &Metric = &frame_ms(
    "flight_frame_wall_ms",
    "Wall clock of a frame; median of a flight.",
)
.ranking(Primary::Wall);
pub(crate) const WORST_WALL: &Metric = &frame_ms(
    "flight_worst_frame_wall_ms",
    "Wall clock of the worst frame of a flight after its first.",
);
pub(crate) const FIRST: &Metric = &frame_ms(
    "flight_first_frame_wall_ms",
    "Wall clock of the first frame, for which no piece is there.",
);
pub(crate) const ERROR: &Metric = &Metric::error_px(
    "flight_changed_px",
    "Pixels that show another region than over the terrain that the view asks for, by the \
     reference; worst frame compared.",
);
pub(crate) const LAST_ERROR: &Metric = &Metric::error_px(
    "flight_last_changed_px",
    "The same of the last frame, when the eye has rested.",
);
pub(crate) const LATE: &Metric = &Metric::counter(
    "flight_late_frames",
    "Frames that were drawn while pieces they asked for were missing.",
);
pub(crate) const MADE: &Metric =
    &Metric::counter("flight_pieces_made", "Pieces made during a flight.");
pub(crate) const EVICTED: &Metric = &Metric::counter(
    "flight_pieces_evicted",
    "Of these, let go because the memory was full.",
);
pub(crate) const BYTES: &Metric = &Metric::bytes(
    "flight_piece_bytes",
    "Memory of all pieces; largest of all frames.",
);
pub(crate) const BUDGET: &Metric = &Metric::neither(
    "flight_budget_bytes",
    "bytes",
    Kind::Bytes,
    "Memory that pieces may take.",
);
pub(crate) const COMPARED: &Metric = &Metric::quantity(
    "flight_frames_compared",
    "Frames that were compared with the reference over the triangles of that very frame.",
);
pub(crate) const WRONG: &Metric = &Metric::error(
    "flight_frames_wrong",
    "",
    "Frames that were not within the tolerances of a fill.",
);
pub(crate) const OUTSIDE: &Metric = &Metric::error_px(
    "flight_outside_px",
    "Pixels outside the boundary band that differ from the reference; largest of all \
     frames.",
);

/// Everything that the study measures.
#[rustfmt::skip]
pub(crate) const METRICS: [Metric; 15] = [
    *FRAME_CPU, *WORST_CPU, *FRAME_WALL, *WORST_WALL, *FIRST, *ERROR, *LAST_ERROR, *LATE,
    *MADE, *EVICTED, *BYTES, *BUDGET, *COMPARED, *WRONG, *OUTSIDE,
];

/// A time of whole frames.
const fn frame_ms(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "ms", Kind::Time, meaning).covering(Scope::PLAN.and(Scope::FRAME))
}
