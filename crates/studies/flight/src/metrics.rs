// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 15] = [
    Metric::less(
        "flight_frame_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of a frame: surface, plan, upload and fill, pieces made by the way included; median of a flight.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME)).ranking(Primary::Cpu),
    Metric::less(
        "flight_worst_frame_cpu_ms",
        "ms",
        Kind::Time,
        "The same of the worst frame of a flight after its first.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME)),
    Metric::less(
        "flight_frame_wall_ms",
        "ms",
        Kind::Time,
        "Wall clock of a frame; median of a flight.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME)).ranking(Primary::Wall),
    Metric::less(
        "flight_worst_frame_wall_ms",
        "ms",
        Kind::Time,
        "Wall clock of the worst frame of a flight after its first.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME)),
    Metric::less(
        "flight_first_frame_wall_ms",
        "ms",
        Kind::Time,
        "Wall clock of the first frame, for which no piece is there.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME)),
    Metric::less(
        "flight_changed_px",
        "px",
        Kind::Error,
        "Pixels that show another region than over the terrain that the view asks for, by the reference; worst frame compared.",
    ),
    Metric::less(
        "flight_last_changed_px",
        "px",
        Kind::Error,
        "The same of the last frame, when the eye has rested.",
    ),
    Metric::less(
        "flight_late_frames",
        "",
        Kind::Counter,
        "Frames that were drawn while pieces they asked for were missing.",
    ),
    Metric::less(
        "flight_pieces_made",
        "",
        Kind::Counter,
        "Pieces made during a flight.",
    ),
    Metric::less(
        "flight_pieces_evicted",
        "",
        Kind::Counter,
        "Of these, let go because the memory was full.",
    ),
    Metric::less(
        "flight_piece_bytes",
        "bytes",
        Kind::Bytes,
        "Memory of all pieces; largest of all frames.",
    ),
    Metric::neither(
        "flight_budget_bytes",
        "bytes",
        Kind::Bytes,
        "Memory that pieces may take.",
    ),
    Metric::neither(
        "flight_frames_compared",
        "",
        Kind::Counter,
        "Frames that were compared with the reference over the triangles of that very frame.",
    ),
    Metric::less(
        "flight_frames_wrong",
        "",
        Kind::Error,
        "Frames that were not within the tolerances of a fill.",
    ),
    Metric::less(
        "flight_outside_px",
        "px",
        Kind::Error,
        "Pixels outside the boundary band that differ from the reference; largest of all frames.",
    ),
];
