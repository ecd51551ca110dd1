// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared API, SIZE_PX, VIEW;
    ACCESS = "access"; BLOCKS = "blocks"; CELLS_PER_POINT = "cells_per_point"; DEPTH = "depth";
    EXPERIMENT = "experiment"; FILTER = "filter"; FLIGHT_S = "flight_s"; FLOOR = "floor";
    GRID_CELLS = "grid_cells"; KEPT_IN = "kept_in"; LAYERS = "layers"; LAYERS_BY = "layers_by";
    LIGHTS = "lights"; MAP_TEXELS = "map_texels"; MOMENTS = "moments"; PLACE = "place";
    RESOLVE = "resolve"; SIGMA = "sigma"; SOURCE = "source"; STRIP = "strip"; TEST = "test";
    TEXELS = "texels"; TILE_CELLS = "tile_cells"; WAY = "way";
}

terrafill_results::metrics! {
    METRICS;
    BLUR_MAX = "blur_max"; BLUR_RMS = "blur_rms"; CACHE_BINDS = "cache_binds";
    CACHE_BYTES = "cache_bytes"; CACHE_DIFFERING = "cache_differing";
    CACHE_UPDATE_CPU_US = "cache_update_cpu_us"; CACHE_UPDATE_WALL_US = "cache_update_wall_us";
    CULL_EXTRA_SHARE = "cull_extra_share"; CULL_IN_TILES = "cull_in_tiles"; CULL_KEPT = "cull_kept";
    CULL_LOST = "cull_lost"; CULL_NEEDED = "cull_needed"; CULL_TILES = "cull_tiles";
    HARD_AREA_SHARE = "hard_area_share"; HARD_DEVIATION_TEXELS = "hard_deviation_texels";
    HARD_WRONG_AREA = "hard_wrong_area"; LAYERED_JUDGED_PX = "layered_judged_px";
    LAYERED_OPEN_PX = "layered_open_px"; LAYERED_WRONG_PX = "layered_wrong_px";
    LAYERED_WRONG_TEXELS = "layered_wrong_texels";
    LIGHTS_DEPTHS_DIFFERING = "lights_depths_differing"; LIGHTS_MAP_ERROR = "lights_map_error";
    LIGHTS_PASSES = "lights_passes"; PIPELINE_BAND_PX = "pipeline_band_px";
    PIPELINE_DIFFERING_PX = "pipeline_differing_px"; PIPELINE_DRAWS = "pipeline_draws";
    PIPELINE_EMITTED_VERTICES = "pipeline_emitted_vertices";
    PIPELINE_GEOMETRY_INVOCATIONS = "pipeline_geometry_invocations";
    PIPELINE_HELD_BYTES = "pipeline_held_bytes"; PIPELINE_MISMATCHED_PX = "pipeline_mismatched_px";
    PIPELINE_PRIMITIVES = "pipeline_primitives"; PIPELINE_SENT_BYTES = "pipeline_sent_bytes";
    PIPELINE_SHOWN_PX = "pipeline_shown_px";
    PIPELINE_VERTEX_INVOCATIONS = "pipeline_vertex_invocations";
    VARIANCE_ABSOLUTE_MAX = "variance_absolute_max";
    VARIANCE_ABSOLUTE_RMS = "variance_absolute_rms"; VARIANCE_BLACK_PX = "variance_black_px";
    VARIANCE_DARK_SHARE = "variance_dark_share"; VARIANCE_NON_FINITE = "variance_non_finite";
    VARIANCE_OUTSIDE_SHARE = "variance_outside_share";
    VARIANCE_RELATIVE_RMS = "variance_relative_rms";
}
