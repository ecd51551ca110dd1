// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 15] = [
    frame_ms(
        "flight_frame_cpu_ms",
        "Process CPU time of a frame: surface, plan, upload and fill, pieces made by the way \
         included; median of a flight.",
    )
    .ranking(Primary::Cpu),
    frame_ms(
        "flight_worst_frame_cpu_ms",
        "The same of the worst frame of a flight after its first.",
    ),
    frame_ms(
        "flight_frame_wall_ms",
        "Wall clock of a frame; median of a flight.",
    )
    .ranking(Primary::Wall),
    frame_ms(
        "flight_worst_frame_wall_ms",
        "Wall clock of the worst frame of a flight after its first.",
    ),
    frame_ms(
        "flight_first_frame_wall_ms",
        "Wall clock of the first frame, for which no piece is there.",
    ),
    error_px(
        "flight_changed_px",
        "Pixels that show another region than over the terrain that the view asks for, by the \
         reference; worst frame compared.",
    ),
    error_px(
        "flight_last_changed_px",
        "The same of the last frame, when the eye has rested.",
    ),
    count(
        "flight_late_frames",
        "Frames that were drawn while pieces they asked for were missing.",
    ),
    count("flight_pieces_made", "Pieces made during a flight."),
    count(
        "flight_pieces_evicted",
        "Of these, let go because the memory was full.",
    ),
    Metric::bytes(
        "flight_piece_bytes",
        "Memory of all pieces; largest of all frames.",
    ),
    Metric::neither(
        "flight_budget_bytes",
        "bytes",
        Kind::Bytes,
        "Memory that pieces may take.",
    ),
    Metric::quantity(
        "flight_frames_compared",
        "Frames that were compared with the reference over the triangles of that very frame.",
    ),
    Metric::error(
        "flight_frames_wrong",
        "",
        "Frames that were not within the tolerances of a fill.",
    ),
    error_px(
        "flight_outside_px",
        "Pixels outside the boundary band that differ from the reference; largest of all \
         frames.",
    ),
];

/// A time of whole frames.
const fn frame_ms(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "ms", Kind::Time, meaning).covering(Scope::PLAN.and(Scope::FRAME))
}

const fn count(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "", Kind::Counter, meaning)
}

const fn error_px(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "px", Kind::Error, meaning)
}
