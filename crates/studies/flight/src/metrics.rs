// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    PIECES = "pieces", "how pieces of terrain are made on the way";
}

/// Note with the path of a case's picture.
pub(crate) const IMAGE: &str = "image";

terrafill_results::metrics! {
    FRAME_CPU = frame_ms(
        "flight_frame_cpu_ms",
        "Process CPU time of a frame: surface, plan, upload and fill, pieces made by the way \
         included; median of a flight.",
    )
    .ranking(Primary::Cpu);
    WORST_CPU = frame_ms(
        "flight_worst_frame_cpu_ms",
        "The same of the worst frame of a flight after its first.",
    );
    FRAME_WALL = frame_ms(
        "flight_frame_wall_ms",
        "Wall clock of a frame; median of a flight.",
    )
    .ranking(Primary::Wall);
    WORST_WALL = frame_ms(
        "flight_worst_frame_wall_ms",
        "Wall clock of the worst frame of a flight after its first.",
    );
    FIRST = frame_ms(
        "flight_first_frame_wall_ms",
        "Wall clock of the first frame, for which no piece is there.",
    );
    ERROR = Metric::error_px(
        "flight_changed_px",
        "Pixels that show another region than over the terrain that the view asks for, by the \
         reference; worst frame compared.",
    );
    LAST_ERROR = Metric::error_px(
        "flight_last_changed_px",
        "The same of the last frame, when the eye has rested.",
    );
    LATE = Metric::counter(
        "flight_late_frames",
        "Frames that were drawn while pieces they asked for were missing.",
    );
    MADE = Metric::counter("flight_pieces_made", "Pieces made during a flight.");
    EVICTED = Metric::counter(
        "flight_pieces_evicted",
        "Of these, let go because the memory was full.",
    );
    BYTES = Metric::bytes(
        "flight_piece_bytes",
        "Memory of all pieces; largest of all frames.",
    );
    BUDGET = Metric::neither(
        "flight_budget_bytes",
        "bytes",
        Kind::Bytes,
        "Memory that pieces may take.",
    );
    COMPARED = Metric::quantity(
        "flight_frames_compared",
        "Frames that were compared with the reference over the triangles of that very frame.",
    );
    WRONG = Metric::error(
        "flight_frames_wrong",
        "",
        "Frames that were not within the tolerances of a fill.",
    );
    OUTSIDE = Metric::error_px(
        "flight_outside_px",
        "Pixels outside the boundary band that differ from the reference; largest of all \
         frames.",
    );
}

/// A time of whole frames.
const fn frame_ms(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "ms", Kind::Time, meaning).covering(Scope::PLAN.and(Scope::FRAME))
}
