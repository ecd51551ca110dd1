// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions that cases of tiles alone have, and what is measured of them. Study `globes` says in its glossary what the
//! conditions are.

use terrafill_globe_views::pixels;
pub(crate) use terrafill_globe_views::{CELLS, GLOBE_TRIANGLES, PATH, PICTURES};
pub(crate) use terrafill_results::condition::{PART, SIZE_PX, VIEW};
use terrafill_results::{ConditionKey, Kind, Metric, Scope};

/// Wait that is added to reading each tile, as a network might have, milliseconds.
pub const LATENCY_MS: ConditionKey = ConditionKey::declare("latency_ms");
/// How a tile's level is chosen.
pub const LEVEL: ConditionKey = ConditionKey::declare("level");
/// Error that is allowed, pixels.
pub const LIMIT: ConditionKey = ConditionKey::declare("limit");
/// When tiles are read: beside frames, by frames that wait, or before the first.
pub const LOADING: ConditionKey = ConditionKey::declare("loading");
/// Where latitude becomes a place in a Web Mercator map.
pub const MERCATOR: ConditionKey = ConditionKey::declare("mercator");
/// How the jump of longitude at ±180° is kept out of the choice of a texel.
pub const SEAM: ConditionKey = ConditionKey::declare("seam");
/// By what triangles are split at the seam.
pub const SPLIT_BY: ConditionKey = ConditionKey::declare("split_by");
/// How tiles reach shaders: a draw each, an array of textures, or bindless.
pub const TILES: ConditionKey = ConditionKey::declare("tiles");
/// Tiles that a frame may send.
pub const TRANSFERS: ConditionKey = ConditionKey::declare("transfers");

/// What a flight does that reads tiles meanwhile. It flies by the wall clock, so how much depends on how fast frames and
/// files are, as a time does.
const fn loading(name: &'static str, unit: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, unit, Kind::Time, meaning).covering(Scope::PLAN.and(Scope::FRAME))
}

terrafill_results::metrics! {
    GLOBE_TILE_PX = pixels("globe_tile_px", "Pixels that show a texel and whose triangle holds no pole.");
    GLOBE_TILE_TEXELS_MAX = Metric::error(
        "globe_tile_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its place on the triangle as drawn lies, largest; triangles that hold a pole are left out.",
    );
    GLOBE_TILE_TEXELS_P99 = Metric::error("globe_tile_texels_p99", "texels", "The same, 99 % of the pixels.");
    GLOBE_TILE_TRUE_TEXELS_MAX = Metric::error(
        "globe_tile_true_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its true place on the body lies, largest.",
    );
    GLOBE_TILE_TRUE_TEXELS_P99 = Metric::error("globe_tile_true_texels_p99", "texels", "The same, 99 % of the pixels.");
    GLOBE_TILE_TRUE_TEXELS_MEDIAN =
        Metric::error("globe_tile_true_texels_median", "texels", "The same, median of the pixels.");
    GLOBE_TILE_SEAM_PX = pixels("globe_tile_seam_px", "Pixels within two of ±180°, caps of the poles left out.");
    GLOBE_TILE_SEAM_WRONG_PX = Metric::error_px(
        "globe_tile_seam_wrong_px",
        "Of them, those that show a texel off by more than ½ from their place on the triangle as drawn, or none.",
    );
    GLOBE_TILE_STEP_TEXELS = Metric::neither(
        "globe_tile_step_texels",
        "texels",
        Kind::Counter,
        "What a step of f32 just below 1, 2⁻²⁴ of the map, is of the finest level that the view asks for. Ten such steps, the roundings of a place in perspective, are at most ½ where a way that counts from the map's edge must be right.",
    )
    .or("counted from the eye");
    GLOBE_TILE_POLE_PX = Metric::less(
        "globe_tile_pole_px",
        "px",
        Kind::Counter,
        "Pixels in triangles that hold a pole, where longitude is no function.",
    );
    GLOBE_TILE_CAP_PX = pixels("globe_tile_cap_px", "Pixels poleward of 85.05°, shown from a stereographic cap.");
    GLOBE_TILE_MISSING_PX = Metric::error_px(
        "globe_tile_missing_px",
        "Pixels of the surface that ask for a tile that is not there.",
    );
    GLOBE_TILE_WRONG_PX = Metric::error_px(
        "globe_tile_wrong_px",
        "Pixels whose tile is at hand and that show none, or a texel too far from their place on the triangle: by more than ½ and what corners within 1/256 px explain. Pixels beside the outline are left out; at most 0.",
    );
    GLOBE_TILE_SPARE = Metric::less(
        "globe_tile_spare",
        "",
        Kind::Counter,
        "Tiles at hand of which no pixel shows a texel.",
    );
    GLOBE_CHOOSE_CPU_MS = Metric::time_ms(
        "globe_choose_cpu_ms",
        "Process CPU time of choosing a frame's tiles by what the grid's corners ask for.",
    ).covering(Scope::PLAN);
    GLOBE_LOAD_WRONG_PX = Metric::error_px(
        "globe_load_wrong_px",
        "Pixels of the judged frames that show another texel than that of the finest tile that is there, by more than rounding explains; at most 0.",
    );
    GLOBE_LOAD_JUDGED_PX = pixels("globe_load_judged_px", "Pixels of the judged frames of a flight.");
    GLOBE_LOAD_MOVING_COARSE_PX = pixels(
        "globe_load_moving_coarse_px",
        "Pixels of the judged frames whose eye moves that show a coarser level than they want.",
    );
    GLOBE_LOAD_COARSE_LAST_PX = Metric::less(
        "globe_load_coarse_last_px",
        "px",
        Kind::Counter,
        "Pixels of a flight's last frame that show a coarser level than they want: what the choice of tiles leaves out.",
    );
    GLOBE_LOAD_STEADY_BYTES = Metric::bytes(
        "globe_load_steady_bytes",
        "Bytes written at the device's queue in a flight's frames whose eye rests and which have the tiles that they choose, by whoever wrote them.",
    );
    GLOBE_LOAD_FILE_BYTES = Metric::neither(
        "globe_load_file_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of the files of all tiles of a flight.",
    );
    GLOBE_LOAD_COARSE = loading(
        "globe_load_coarse_wall_frames",
        "frames",
        "Share of a frame's pixels that show a coarser level than they want, summed over a flight's frames. Every fourth pixel of every fourth row is asked.",
    );
    GLOBE_LOAD_REST_FRAMES = loading(
        "globe_load_rest_wall_frames",
        "frames",
        "Frames after the eye has come to rest until the last tile is sent.",
    );
    GLOBE_LOAD_CANCELLED = loading(
        "globe_load_cancelled_wall_tiles",
        "tiles",
        "Requests for tiles that frames gave up, before they were read or after.",
    );
    GLOBE_LOAD_SENT_MAX = loading("globe_load_sent_max_wall_tiles", "tiles", "Tiles that a flight's frame sends, most of one.");
    GLOBE_LOAD_BYTES = loading("globe_load_wall_bytes", "bytes", "Bytes that a flight's frames send, tiles and all else.");
    GLOBE_LOAD_BYTES_MAX = loading("globe_load_max_wall_bytes", "bytes", "The same, most of a frame.");
    GLOBE_LOAD_SPIKE = loading("globe_load_spike_wall_ratio", "", "Wall clock of a flight's longest frame over that of its median frame.");
    GLOBE_LOAD_FRAME_WALL_MS = Metric::time_ms(
        "globe_load_frame_wall_ms",
        "Wall clock of a frame of a flight: making the grid, choosing, taking or reading, sending, and drawing until the device is done; median of its frames.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_FRAME_MAX_WALL_MS =
        Metric::time_ms("globe_load_frame_max_wall_ms", "The same, longest.").covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_FRAME_CPU_MS = Metric::time_ms(
        "globe_load_frame_cpu_ms",
        "Process CPU time of the same, mean of a flight's frames; what a thread that reads uses meanwhile is among it.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_THREAD_CPU_MS = Metric::time_ms(
        "globe_load_thread_cpu_ms",
        "CPU time of the thread that reads tiles beside a flight's frames, between them too; none where frames read."
    ).covering(Scope::PLAN);
    GLOBE_TILE_CROSSING = Metric::quantity("globe_tile_crossing", "Triangles across ±180° that hold no pole.");
    GLOBE_TILE_MISSED = Metric::error("globe_tile_missed", "", "Of them, those that the seam's rule leaves whole.");
    GLOBE_TILE_COUNT = Metric::counter("globe_tile_count", "Tiles that a view needs, two caps among them.");
    GLOBE_TILE_DRAWS = Metric::counter("globe_tile_draws", "Draws of a frame.");
    GLOBE_TILE_BYTES = Metric::bytes("globe_tile_bytes", "Bytes of the texels of a view's tiles.");
    GLOBE_TILE_COLOUR_WRONG_PX = Metric::error_px(
        "globe_tile_colour_wrong_px",
        "Pixels that have another colour than the texel that they show.",
    );
    GLOBE_TILE_COLOUR_OFF_MEDIAN = Metric::error(
        "globe_tile_colour_off_median",
        "",
        "Difference of a pixel's colour from the whole picture at its place on the body: the largest channel's, of 255, median.",
    );
    GLOBE_TILE_COLOUR_OFF_P99 = Metric::error("globe_tile_colour_off_p99", "", "The same, 99 % of the pixels.");
}
