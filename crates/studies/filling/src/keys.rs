// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared SCENE, VIEW, TECHNIQUE, VARIANT;
    APPROXIMATE = "approximate";
    ASIDE = "aside";
    BOUNDARY_LOD_PX = "boundary-lod-px";
    CAP_STEP = "cap-step-deg";
    LAYOUT = "layout";
    NEEDS_RUNG = "needs-rung";
    NEEDS_STEP = "needs-step";
    NORMALIZE = "normalize";
    NORMALS = "normals";
    PICTURE = "picture";
    POSITION = "position";
    POSITIONS = "positions";
    REGIONS = "regions";
    ROLE = "role";
    RUNG = "rung";
    STEP = "step";
    TEXTURE = "texture";
    TOLERANCE_M = "boundary-tolerance-m";
}

terrafill_results::metrics! {
    METRICS;
    ALLOCATED_INDEX_BYTES = "allocated_index_bytes";
    ALLOCATED_VERTEX_BYTES = "allocated_vertex_bytes";
    BOUNDARY_DEVIATION_M = "boundary_deviation_m"; BOUNDARY_EDGES = "boundary_edges";
    BOUNDARY_LOOPS = "boundary_loops"; BOUNDARY_MOVED_PX = "boundary_moved_px";
    BOUNDARY_TOLERANCE_M = "boundary_tolerance_m"; CAP_TRIANGLES = "cap_triangles";
    COLOUR_GPU_MS = "colour_gpu_ms"; COLOUR_MAX = "colour_max"; COLOUR_MEAN = "colour_mean";
    CONSTANT_BYTES = "constant_bytes"; DRAWS = "draws"; FILL_CPU_MS = "fill_cpu_ms";
    FILL_GPU_MS = "fill_gpu_ms"; FILL_WALL_MS = "fill_wall_ms"; FOREIGN_PX = "foreign_px";
    FORMULA_INDEX_BYTES = "formula_index_bytes"; FORMULA_VERTEX_BYTES = "formula_vertex_bytes";
    FRAGMENT_SHADER_INVOCATIONS = "fragment_shader_invocations"; GEOMETRY_BYTES = "geometry_bytes";
    HAUSDORFF_PX = "hausdorff_px"; HELD_BYTES = "held_bytes"; HELD_PIPELINES = "held_pipelines";
    INDEX_BYTES = "index_bytes"; MADE_BYTES = "made_bytes"; MADE_PIPELINES = "made_pipelines";
    MESH_TRIANGLES = "mesh_triangles"; MESH_VERTICES = "mesh_vertices";
    MISMATCHED_PX = "mismatched_px"; MISMATCHED_PX_OUTSIDE_BAND = "mismatched_px_outside_band";
    MOVED_PX_TRUE = "moved_px_true"; PREPARE_CPU_MS = "prepare_cpu_ms";
    REGIONS_DRAWN = "regions_drawn"; REGIONS_LEFT_OUT = "regions_left_out";
    REGION_BYTES_LARGEST = "region_bytes_largest"; REGION_BYTES_MEDIAN = "region_bytes_median";
    REGION_BYTES_SMALLEST = "region_bytes_smallest"; SPARED_BYTES = "spared_bytes";
    STENCIL_FRAGMENTS = "stencil_fragments"; STENCIL_GPU_MS = "stencil_gpu_ms";
    SURFACE_BYTES = "surface_bytes"; SURFACE_GPU_MS = "surface_gpu_ms";
    TARGET_BYTES = "target_bytes"; TEXEL_COMPARED_PX = "texel_compared_px"; TEXEL_MAX = "texel_max";
    TEXEL_NON_FINITE = "texel_non_finite"; TEXEL_RMS = "texel_rms"; TEXTURE_BYTES = "texture_bytes";
    UPLOAD_BYTES = "upload_bytes"; VERTEX_BYTES = "vertex_bytes"; VERTICES = "vertices";
    WALL_BOUND_M = "wall_bound_m"; WALL_HEIGHT_M = "wall_height_m"; WALL_SHIFT_M = "wall_shift_m";
}
