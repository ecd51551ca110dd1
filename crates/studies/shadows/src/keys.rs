// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared API, SIZE_PX, VIEW;
    BIAS = "bias"; BOXES = "boxes"; CASTERS = "casters"; CHECKED_PX = "checked_px";
    COUNTING = "counting"; DEPTH_BOUNDS = "depth_bounds"; EXTENT = "extent"; EYE_TEST = "eye_test";
    FACES = "faces"; LENGTH_M = "length_m"; MESH = "mesh"; MODEL = "model"; MODELS = "models";
    NEAR_M = "near_m"; OUTLINE = "outline"; PAPER = "paper"; POLICY = "policy";
    POSITIONS = "positions"; QUESTION = "question"; RIVAL = "rival"; RULE = "rule";
    SCISSOR = "scissor"; SILHOUETTE = "silhouette"; STEP = "step"; SUN = "sun"; TEXEL_M = "texel_m";
}

terrafill_results::metrics! {
    METRICS;
    TIME = "shadow_silhouette_cpu_ms"; UPDATES = "shadow_updates"; MISSED = "shadow_eyes_missed";
    MOSTLY = "shadow_eyes_missed_mostly"; LOST = "shadow_lost_share";
    SHADOW_BAND_PX = "shadow_band_px"; SHADOW_BUILD_GPU_MS = "shadow_build_gpu_ms";
    SHADOW_BYTES = "shadow_bytes"; SHADOW_CASTERS_LEFT_OUT = "shadow_casters_left_out";
    SHADOW_CLEARS = "shadow_clears"; SHADOW_CONTOUR_PX = "shadow_contour_px";
    SHADOW_DRAWS = "shadow_draws"; SHADOW_EDGE_ON_PX = "shadow_edge_on_px";
    SHADOW_EYES_MISSED_AT_CORNERS = "shadow_eyes_missed_at_corners";
    SHADOW_EYES_NEEDLESS = "shadow_eyes_needless"; SHADOW_FAIL_TRIANGLES = "shadow_fail_triangles";
    SHADOW_FALSE_DARK_PX = "shadow_false_dark_px"; SHADOW_FALSE_LIT_PX = "shadow_false_lit_px";
    FILL_CPU = "shadow_fill_cpu_ms"; FILL_GPU = "shadow_fill_gpu_ms";
    SHADOW_FRAGMENTS = "shadow_fragments"; SHADOW_MAP_BIAS_M = "shadow_map_bias_m";
    SHADOW_MAP_CPU_MS = "shadow_map_cpu_ms"; SHADOW_MAP_DIFFERS = "shadow_map_differs";
    SHADOW_MAP_GPU_MS = "shadow_map_gpu_ms"; MAP_WRONG = "shadow_map_wrong";
    SHADOW_MAP_WRONG_IN_THREE = "shadow_map_wrong_in_three";
    SHADOW_MAP_WRONG_UNBIASED = "shadow_map_wrong_unbiased";
    SHADOW_MAX_OVERLAP = "shadow_max_overlap"; SHADOW_MESH_MODELS = "shadow_mesh_models";
    SHADOW_MESH_PARTS = "shadow_mesh_parts"; SHADOW_MESH_TRIANGLES = "shadow_mesh_triangles";
    SHADOW_NEAR_DARK = "shadow_near_dark"; SHADOW_OPEN_EDGES = "shadow_open_edges";
    SHADOW_PX = "shadow_px"; SHADOW_RECEIVER_PX = "shadow_receiver_px";
    SHADOW_RIM_PX = "shadow_rim_px"; SHADOW_SIDES = "shadow_sides";
    SHADOW_SUN_BYTES = "shadow_sun_bytes"; SHADOW_UNDECIDED_FACINGS = "shadow_undecided_facings";
    SHADOW_UNDECIDED_PX = "shadow_undecided_px";
    SHADOW_VOLUME_TRIANGLES = "shadow_volume_triangles";
    SHADOW_VOLUMES_CPU_MS = "shadow_volumes_cpu_ms";
}
