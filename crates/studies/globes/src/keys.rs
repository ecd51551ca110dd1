// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared API, PART, SIZE_PX, VIEW;
    CELLS = "n"; COUNTED_BY = "counted_by"; DELAY = "delay"; FAULT = "fault";
    HEIGHTS = "heights"; HYSTERESIS = "hysteresis"; KNOB = "knob";
    LAW = "law"; LEVEL = "level"; LIMIT = "limit"; LOOKUP = "lookup";
    MERCATOR = "mercator"; PATH = "path"; PICTURES = "pictures"; PROJECTION = "projection";
    REMOVED = "removed"; SEAM = "seam"; SPIKE_M = "spike_m"; SPLIT_BY = "split_by";
    SURFACE = "surface"; TILES = "tiles"; TRANSFERS = "transfers"; TRIG = "trig"; VALUE = "value";
    VERTICES = "vertices"; WANTED = "wanted"; WHAT = "what";
}

terrafill_results::metrics! {
    METRICS;
    GLOBE_DRAW_CPU_MS = "globe_draw_cpu_ms"; GLOBE_DRAW_GPU_MS = "globe_draw_gpu_ms";
    GLOBE_WHOLE_CPU_MS = "globe_whole_cpu_ms"; GLOBE_WHOLE_GPU_MS = "globe_whole_gpu_ms";
    GLOBE_COUNT_CYCLES = "globe_count_cycles";
    GLOBE_COUNT_LEAVES = "globe_count_leaves"; GLOBE_COUNT_NODES = "globe_count_nodes";
    GLOBE_COUNT_OFF_PX = "globe_count_off_px"; GLOBE_COUNT_PAGE_CPU_MS = "globe_count_page_cpu_ms";
    GLOBE_COUNT_PAGE_MAX_CPU_MS = "globe_count_page_max_cpu_ms";
    GLOBE_COUNT_SETTLE_FRAMES = "globe_count_settle_frames";
    GLOBE_COUNT_TEXELS_PER_PX = "globe_count_texels_per_px";
    GLOBE_COUNT_WRONG_NODES = "globe_count_wrong_nodes";
    GLOBE_COUNTED_CPU_MS = "globe_counted_cpu_ms"; GLOBE_DEPTH_M_MAX = "globe_depth_m_max";
    GLOBE_EXPECTED_LOWEST_M = "globe_expected_lowest_m";
    GLOBE_EXPECTED_MAP_M_MAX = "globe_expected_map_m_max";
    GLOBE_EXPECTED_PX_MAX = "globe_expected_px_max"; GLOBE_EXTRA_PX = "globe_extra_px";
    GLOBE_LOWEST_M = "globe_lowest_m"; GLOBE_MADE_DIFFERS_PX = "globe_made_differs_px";
    GLOBE_MADE_M_MAX = "globe_made_m_max"; GLOBE_MADE_PX_MAX = "globe_made_px_max";
    GLOBE_MAKE_CPU_MS = "globe_make_cpu_ms"; GLOBE_MAP_M_MAX = "globe_map_m_max";
    GLOBE_MAP_PX_MAX = "globe_map_px_max"; GLOBE_MAP_PX_MEDIAN = "globe_map_px_median";
    GLOBE_MAP_PX_P99 = "globe_map_px_p99"; GLOBE_NON_FINITE = "globe_non_finite";
    GLOBE_PX_MAX = "globe_px_max"; GLOBE_PX_MEDIAN = "globe_px_median";
    GLOBE_PX_P99 = "globe_px_p99"; GLOBE_SHADE_MAX = "globe_shade_max";
    GLOBE_SHADE_P99 = "globe_shade_p99"; GLOBE_SHADE_POLAR_MAX = "globe_shade_polar_max";
    GLOBE_SHADE_POLAR_P99 = "globe_shade_polar_p99"; GLOBE_TILE_BYTES = "globe_tile_bytes";
    GLOBE_TILE_COLOUR_OFF_MEDIAN = "globe_tile_colour_off_median";
    GLOBE_TILE_COLOUR_OFF_P99 = "globe_tile_colour_off_p99";
    GLOBE_TILE_COLOUR_WRONG_PX = "globe_tile_colour_wrong_px";
    GLOBE_TILE_COUNT = "globe_tile_count"; GLOBE_TILE_CROSSING = "globe_tile_crossing";
    GLOBE_TILE_DRAWS = "globe_tile_draws";
    GLOBE_TILE_MISSED = "globe_tile_missed"; GLOBE_TILE_MISSING_PX = "globe_tile_missing_px";
    GLOBE_TILE_POLE_PX = "globe_tile_pole_px"; GLOBE_TILE_PX = "globe_tile_px";
    GLOBE_TILE_SEAM_PX = "globe_tile_seam_px";
    GLOBE_TILE_SEAM_WRONG_PX = "globe_tile_seam_wrong_px";
    GLOBE_TILE_TEXELS_MAX = "globe_tile_texels_max";
    GLOBE_TILE_TEXELS_P99 = "globe_tile_texels_p99";
    GLOBE_TILE_TRUE_TEXELS_MAX = "globe_tile_true_texels_max";
    GLOBE_TILE_TRUE_TEXELS_MEDIAN = "globe_tile_true_texels_median";
    GLOBE_TILE_TRUE_TEXELS_P99 = "globe_tile_true_texels_p99";
    GLOBE_TRIANGLES = "globe_triangles";
    GLOBE_UNCOUNTED_CPU_MS = "globe_uncounted_cpu_ms"; GLOBE_UNCOVERED_PX = "globe_uncovered_px";
    GLOBE_UPLOAD_BYTES = "globe_upload_bytes"; GLOBE_UPLOAD_CPU_MS = "globe_upload_cpu_ms";
    GLOBE_VERTICES = "globe_vertices"; GLOBE_ZONE_HIDES = "globe_zone_hides";
}
