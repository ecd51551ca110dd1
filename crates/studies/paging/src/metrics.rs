// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// The parts' names in cases.
pub(crate) const FLIGHTS: &str = "flights";
pub(crate) const TABLE_2: &str = "table-2";
pub(crate) const COUNTING: &str = "counting";
pub(crate) const OF_EARTH: &str = "picture";

terrafill_results::conditions! {
    shared PART, SIZE_PX;
    COUNTED = "counted", "when counts of fragments are read; `no`: fragments do not count themselves";
    HYSTERESIS = "hysteresis", "how many times the pixels at which four leaves merge a leaf splits at";
    PATH = "path", "what the eye does";
    PICTURE = "picture", "what the texture shows";
    RULE = "rule", "by what the level of a page is chosen";
    TRANSFERS = "transfers", "pages that a frame may read";
    "addresses" = "a pattern whose texels say their own level, column and row";
    "blue-marble" = "NASA's picture of the Earth, enlarged";
    "smooth" = "the eye drifts eastwards at 3,500 km";
    "zoom" = "the eye comes down from 20,000 km to 3,500 km";
    "jump" = "the eye rests, and is over another continent from one frame to the next";
    "distance" = "pixels of each leaf are predicted from its distance, as if it faced the eye";
    "derivative" = "each pixel finds its level by the footprint that derivatives span, and says which page it wants";
    "any" = "all that are wanted";
    "none" = "a footprint has no state that could swing";
    "page" = "a square of 128 × 128 texels of one level, with a border of one texel";
    "slot" = "a place on the device that holds one page";
    "missing" = "showing a coarser page than the footprint of a pixel asks for";
    "later" = "counts are read when they are two frames old";
    "at-once" = "each frame waits for its counts";
    "counts are read" = "when a frame reads how many pixels each leaf had: never, two frames later, or at once";
    "pixels a side" = "columns and rows of the window";
    "spike" = "a frame that takes much longer than others";
}

terrafill_results::metrics! {
    PAGING_FRAME_CPU_MS = Metric::time_ms(
        "paging_frame_cpu_ms",
        "Process CPU time of a frame of a flight: deciding, reading and sending pages, and drawing; median of its frames.",
    ).covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK)).ranking(Primary::Cpu);
    PAGING_FRAME_WALL_MS = Metric::time_ms("paging_frame_wall_ms", "The same by the wall clock.")
        .covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK)).ranking(Primary::Wall);
    PAGING_FRAME_P95_CPU_MS = Metric::time_ms(
        "paging_frame_p95_cpu_ms",
        "Process CPU time that 95 % of a flight's frames stay below.",
    ).covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    PAGING_FRAME_P95_WALL_MS = Metric::time_ms("paging_frame_p95_wall_ms", "The same by the wall clock.")
        .covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    PAGING_FRAME_MAX_CPU_MS = Metric::time_ms(
        "paging_frame_max_cpu_ms",
        "Process CPU time of a flight's longest frame.",
    ).covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    PAGING_FRAME_MAX_WALL_MS = Metric::time_ms("paging_frame_max_wall_ms", "The same by the wall clock.")
        .covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    PAGING_UPDATE_MS = Metric::time_ms(
        "paging_update_wall_ms",
        "Wall clock of an update: taking counts over, deciding, reading pages from the file and sending them until the device has them; mean of the frames in which the eye moves.",
    ).covering(Scope::PLAN.and(Scope::UPLOAD).and(Scope::READ_BACK));
    PAGING_UPDATE_MAX_MS = Metric::time_ms("paging_update_max_wall_ms", "Wall clock of a flight's longest update.")
        .covering(Scope::PLAN.and(Scope::UPLOAD).and(Scope::READ_BACK));
    PAGING_DRAW_CPU_MS = Metric::time_ms(
        "paging_draw_cpu_ms",
        "Process CPU time of drawing a frame; mean of a flight's frames, each until the device is done, or of 20 of a still view, until the last is done.",
    ).covering(Scope::FRAME);
    PAGING_DRAW_WALL_MS = Metric::time_ms("paging_draw_wall_ms", "The same by the wall clock.")
        .covering(Scope::FRAME);
    PAGING_MISMATCHED_PX = Metric::error_px(
        "paging_mismatched_px",
        "Pixels of the judged frames that show what is right nowhere within 1/32 of a pixel about their middle.",
    );
    PAGING_BAND_PX = Metric::neither(
        "paging_band_px",
        "px",
        Kind::Counter,
        "Pixels of the judged frames that show what is right beside their middle alone.",
    );
    PAGING_JUDGED_PX = Metric::quantity("paging_judged_px", "Pixels of the globe in the judged frames.");
    PAGING_MISSING_FRAMES = Metric::counter(
        "paging_missing_frames",
        "Frames of a flight in which a pixel shows a coarser page than its footprint asks for, of the first 48.",
    );
    PAGING_MISSING_PX = Metric::less(
        "paging_missing_px",
        "px",
        Kind::Counter,
        "Pixels that show a coarser page than their footprint asks for, mean of a flight's first 48 frames.",
    );
    PAGING_MISSING_MAX_PX = Metric::less(
        "paging_missing_max_px",
        "px",
        Kind::Counter,
        "The same, most of a frame.",
    );
    PAGING_FRAMES = Metric::quantity("paging_frames", "Frames of a flight until it has its pages.");
    PAGING_READS = Metric::counter("paging_reads", "Pages that a flight reads from the file, after those of its first frame.");
    PAGING_READS_MAX = Metric::counter("paging_reads_max", "The same, most of a frame.");
    PAGING_WANTED = Metric::neither(
        "paging_wanted",
        "pages",
        Kind::Counter,
        "Pages that a frame wants, mean of the frames in which the eye moves.",
    );
    PAGING_WITHOUT_SLOT = Metric::counter(
        "paging_without_slot",
        "Pages of a flight's frames that were not read because every slot held what the frame shows.",
    );
    PAGING_BYTES = Metric::bytes("paging_bytes", "Bytes that a flight sends to the device.");
    PAGING_BYTES_MAX = Metric::bytes("paging_bytes_max", "The same, most of a frame.");
    PAGING_FILE_BYTES = Metric::neither(
        "paging_file_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of the file with all pages of all levels.",
    );
    PAGING_STEADY_BYTES = Metric::bytes(
        "paging_steady_bytes",
        "Bytes that the last two frames of a flight send, which read nothing.",
    );
    PAGING_TEXELS_PER_PX = Metric::neither(
        "paging_texels_per_px",
        "texels/px",
        Kind::Error,
        "Texels of the pages that the last frame of a flight wants, over pixels of the globe.",
    );
    PAGING_BLURRED_PX = Metric::error_px(
        "paging_blurred_px",
        "Pixels of the last frame whose texel is larger than their footprint by more than a level.",
    );
    PAGING_BLURRED_MOVING_PX = Metric::error_px(
        "paging_blurred_moving_px",
        "The same of frame 24, in which the eye moves or has jumped four frames before.",
    );
    PAGING_EDGE_LOSS = Metric::error(
        "paging_edge_loss",
        "levels",
        "By how many levels texels of the last frame are larger than footprints in pages that the picture's edge cuts, mean, less the same of pages that lie within.",
    );
}
