// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything that the study measures. `terrafill studies --markdown` and `schema.json` are made from these.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Why figures are absent that several metrics have in common.
const NOT_COMPARED: &str = "not compared with the reference";
const NOT_COUNTED: &str = "not counted by this technique";
const NOT_TIMED: &str = "no frame was timed";
const NO_PASS_TIME: &str = "no GPU time of its own: stencil and colour alternate region by region, or the device gave \
                            none";
const NO_TEXELS: &str = "a plain fill has no texels";

/// A count that is exact within one driver.
const fn driver_counter(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "", Kind::DriverCounter, meaning)
}

// Times first, then bytes, counters, errors, textured fills and bytes of layouts.
terrafill_results::metrics! {
    FILL_CPU_MS = Metric::time_ms(
        "fill_cpu_ms",
        "CPU time of the whole process from recording the fill until the device is done with it. On a software driver it contains the driver's threads and is the steadiest clock on a busy machine.",
    ).or(NOT_TIMED).covering(Scope::FRAME).ranking(Primary::Cpu);
    FILL_GPU_MS = Metric::time_ms(
        "fill_gpu_ms",
        "The whole fill, by the GPU's clock. Copies that a frame submits are inside of it, what the CPU writes before is not.",
    ).or("no frame was timed, or the device gave no GPU time").covering(Scope::DEVICE).ranking(Primary::Gpu);
    FILL_WALL_MS = Metric::time_ms(
        "fill_wall_ms",
        "Wall clock over the same span.",
    ).or(NOT_TIMED).covering(Scope::FRAME);
    SURFACE_GPU_MS = Metric::neither(
        "surface_gpu_ms",
        "ms",
        Kind::Time,
        "The pass that draws the planet and leaves depth behind, by the GPU's clock. Not part of the fill.",
    ).or("the technique draws a surface of its own, untimed, or the device gave no GPU time").covering(Scope::DRAW);
    STENCIL_GPU_MS = Metric::time_ms(
        "stencil_gpu_ms",
        "The pass that marks the regions' pixels in the stencil, by the GPU's clock. Not measured where stencil and colour alternate region by region.",
    ).or(NO_PASS_TIME).covering(Scope::DISPATCH.and(Scope::DRAW));
    COLOUR_GPU_MS = Metric::time_ms(
        "colour_gpu_ms",
        "The pass that colours the marked pixels, by the GPU's clock. Not measured as above.",
    ).or(NO_PASS_TIME).covering(Scope::DRAW);
    PLAN_CPU_MS = Metric::time_ms(
        "plan_cpu_ms",
        "Process CPU time of planning one frame: culling, cap heights and screen rectangles of every region. Not part of the fill's times, since an unchanged view is not planned again.",
    ).covering(Scope::PLAN);
    PREPARE_CPU_MS = Metric::time_ms(
        "prepare_cpu_ms",
        "Process CPU time of making the probe frame ready, once: pipelines, geometry, uploads, a mesh cut along the surface, a mask drawn. Not part of the fill's times, since an unchanged view needs it once.",
    ).covering(Scope::PLAN.and(Scope::UPLOAD));
    GEOMETRY_BYTES = Metric::bytes(
        "geometry_bytes",
        "Bytes of positions, flags and indices that the technique holds for the scene: `vertex_bytes` + `index_bytes`.",
    ).or(NOT_COUNTED);
    VERTEX_BYTES = Metric::bytes("vertex_bytes", "Buffers with positions and flags, bytes.");
    INDEX_BYTES = Metric::bytes(
        "index_bytes",
        "Index buffers, or the index lists that a pulling shader reads, bytes.",
    );
    CONSTANT_BYTES = Metric::bytes("constant_bytes", "Per-region constants of the view, bytes.");
    TARGET_BYTES = Metric::bytes(
        "target_bytes",
        "Bytes of further targets that the technique draws into, such as numbers that regions add up in, or a mask of ids.",
    ).or(NOT_COUNTED);
    TEXTURE_BYTES = Metric::bytes(
        "texture_bytes",
        "Bytes of pictures with all their levels and of the routes' tables on the device.",
    ).or(NOT_COUNTED);
    UPLOAD_BYTES = Metric::bytes("upload_bytes", "Bytes uploaded per frame once everything is prepared.");
    BUFFERS = Metric::counter("buffers", "Number of buffers the technique holds.");
    HELD_BYTES = Metric::bytes(
        "held_bytes",
        "Bytes of every buffer and texture that the fill holds for the view, padding included: the sum over the features in the `need_` notes.",
    );
    MADE_BYTES = Metric::bytes(
        "made_bytes",
        "Bytes of the buffers and textures that the device was asked to make for the fill, measuring included. Must equal `held_bytes`: a backend is prepared once.",
    );
    SPARED_BYTES = Metric::neither(
        "spared_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes that the features left out would take, where they would take any.",
    );
    HELD_PIPELINES = Metric::counter(
        "held_pipelines",
        "Pipelines that the fill holds for the view and for measuring: the sum over the features in the `need_` notes.",
    );
    MADE_PIPELINES = Metric::counter(
        "made_pipelines",
        "Pipelines that the device was asked to make for the fill since its backend was opened. Must equal `held_pipelines`.",
    );
    DRAWS = Metric::counter("draws", "Draw calls of one fill.").or(NOT_COUNTED);
    VERTICES = Metric::counter(
        "vertices",
        "Vertices that the draws process: the sum of their vertex or index counts.",
    ).or(NOT_COUNTED);
    REGIONS_DRAWN = Metric::quantity("regions_drawn", "Regions that the frame plan kept.");
    REGIONS_LEFT_OUT = Metric::quantity(
        "regions_left_out",
        "Regions that the frame plan left out; `left_out` has the reasons.",
    );
    VERTEX_SHADER_INVOCATIONS = driver_counter(
        "vertex_shader_invocations",
        "Pipeline statistic of the stencil pass. Exact within one driver only, as are the next three.",
    );
    GEOMETRY_SHADER_PRIMITIVES = driver_counter(
        "geometry_shader_primitives",
        "Primitives that geometry shaders gave out in the stencil pass.",
    );
    CLIPPER_INVOCATIONS =
        driver_counter("clipper_invocations", "Primitives that reached clipping in the stencil pass.");
    CLIPPER_PRIMITIVES_OUT =
        driver_counter("clipper_primitives_out", "Primitives that left clipping in the stencil pass.");
    FRAGMENT_SHADER_INVOCATIONS = driver_counter("fragment_shader_invocations", "Fragments shaded in the colour pass.");
    STENCIL_FRAGMENTS = driver_counter(
        "stencil_fragments",
        "Fragments of volumes in the stencil work, whether or not the depth test lets them touch the stencil; counted in an extra frame that is not timed.",
    ).or(NOT_COUNTED);
    BUFFER_CREATIONS = Metric::counter(
        "buffer_creations",
        "Buffers made for the probe frame's fill, by `prepare` or later.",
    );
    PIPELINE_CREATIONS = Metric::counter(
        "pipeline_creations",
        "Pipelines made for the probe frame's fill, by `prepare` or later.",
    );
    STEADY_BUFFER_CREATIONS = Metric::counter(
        "steady_buffer_creations",
        "Buffers made for the same frame drawn once more: 0 in a steady state.",
    );
    STEADY_PIPELINE_CREATIONS = Metric::counter(
        "steady_pipeline_creations",
        "Pipelines made for the same frame drawn once more: 0 in a steady state.",
    );
    STEADY_UPLOADS = Metric::counter(
        "steady_uploads",
        "Writes of the CPU into buffers for the same frame drawn once more: 0 in a steady state.",
    );
    CAP_TRIANGLES = Metric::counter("cap_triangles", "Triangles of one cap of every region drawn.");
    SURFACE_BYTES = Metric::neither(
        "surface_bytes",
        "bytes",
        Kind::Bytes,
        "Vertices, indices and picture of the surface as drawn in this view. Not part of the fill.",
    ).or(NOT_COUNTED);
    WALL_HEIGHT_M = Metric::less(
        "wall_height_m",
        "m",
        Kind::Counter,
        "Tallest wall of the regions drawn, from bottom cap to top cap, metres: terrain and what the caps' triangles bend away from it.",
    );
    WALL_BOUND_M = Metric::less(
        "wall_bound_m",
        "m",
        Kind::Counter,
        "The tallest wall of the regions drawn if their caps' triangles bent away as far as the cap step allows, by formula, metres. Of the sweep through cap steps alone.",
    );
    WALL_SHIFT_M = Metric::error(
        "wall_shift_m",
        "m",
        "How far at most walls that lead away from the body's centre are from walls along geodetic normals, where they meet the surface drawn, metres. Not measured of walls along geodetic normals.",
    );
    FILLED_PX = Metric::neither(
        "filled_px",
        "px",
        Kind::DriverCounter,
        "Pixels that the technique gave to a region.",
    );
    MISMATCHED_PX = Metric::error_px(
        "mismatched_px",
        "Pixels whose region differs from the reference's.",
    ).or(NOT_COMPARED);
    MISMATCHED_PX_OUTSIDE_BAND = Metric::error_px(
        "mismatched_px_outside_band",
        "Wrong pixels outside the boundary band. One is enough to make a case `wrong`.",
    ).or(NOT_COMPARED);
    HAUSDORFF_PX = Metric::error_px(
        "hausdorff_px",
        "Symmetric Hausdorff distance between the boundaries of the two pictures, pixels: the farthest that any boundary pixel of either is from the other's. Regions of fewer than 4 pixels are left out.",
    ).or("one of the two pictures has no boundary, or they were not compared");
    BOUNDARY_MOVED_PX = Metric::error_px(
        "boundary_moved_px",
        "How far boundaries moved that levels of detail simplify on purpose: the farthest that the centre of a mismatched pixel is from a place where the reference shows the id of the frame, pixels, found in steps of 1/16. Of other boundaries it is measured where their Hausdorff distance is beyond a pixel, in steps of 1/256. Of approximate fills: to the centre of such a pixel, and empty beyond 64 pixels.",
    ).or("nothing moves boundaries on purpose, and they lie within a pixel of the reference's; or too many pixels mismatch to compare");
    MOVED_PX_TRUE = Metric::error_px(
        "moved_px_true",
        "How far the surface's triangles move a boundary: the farthest that a place seen on one lies from where the surface at its full resolution has the same place. What hides what is left aside. The same for every technique of a view. Empty where the surface cannot say, and of rivals that draw a surface of their own.",
    ).or("the surface does not say where the ground truly is, or they were not compared");
    MOVED_PX_TRUE_P99 = Metric::error_px("moved_px_true_p99", "The same, not exceeded by 99 of 100 boundary pixels.");
    FOREIGN_PX = Metric::error_px(
        "foreign_px",
        "Of boundaries that levels of detail simplify: mismatched pixels with an id that the reference shows nowhere within 2 pixels. Two neighbours are rounded each by itself, so that a pixel of their border may belong to both, which colours it as a third region, or to neither.",
    );
    AREA_ERROR = Metric::error("area_error", "", "Pixels filled over the reference's, minus 1.");
    TINY_REGIONS = Metric::neither(
        "tiny_regions",
        "",
        Kind::DriverCounter,
        "Pieces of fewer than 4 pixels in the reference, or in the frame where the reference shows them between the centres of its pixels; left out of `hausdorff_px`.",
    );
    NON_FINITE = Metric::error("non_finite", "", "Distances or positions that came out as NaN or infinite.");
    REFERENCE_DISAGREEMENTS = Metric::error_px(
        "reference_disagreements",
        "Pixels on which the reference's two independent inside tests disagree.",
    );
    REFERENCE_DISAGREEMENTS_OUTSIDE_BAND = Metric::error_px(
        "reference_disagreements_outside_band",
        "Those of them outside the boundary band.",
    );
    BOUNDARY_TOLERANCE_M = Metric::neither(
        "boundary_tolerance_m",
        "m",
        Kind::Error,
        "Largest deviation that the mesh was allowed, metres.",
    );
    BOUNDARY_DEVIATION_M = Metric::error(
        "boundary_deviation_m",
        "m",
        "Largest distance found between a boundary edge as drawn and the edge by its rule, metres.",
    );
    CAP_STEP_DEG = Metric::neither(
        "cap_step_deg",
        "deg",
        Kind::Counter,
        "Largest edge of a cap triangle, degrees.",
    );
    TEXEL_RMS = Metric::error(
        "texel_rms",
        "texels",
        "Root mean square error of the texture coordinates, texels, of the worse axis.",
    ).or(NO_TEXELS);
    TEXEL_MAX = Metric::error(
        "texel_max",
        "texels",
        "Largest error of the texture coordinates, texels, of the worse axis.",
    ).or(NO_TEXELS);
    TEXEL_NON_FINITE = Metric::error_px(
        "texel_non_finite",
        "Pixels with a texture coordinate or level of detail that is NaN or infinite; at most 0.",
    ).or(NO_TEXELS);
    TEXEL_COMPARED_PX = Metric::neither(
        "texel_compared_px",
        "px",
        Kind::DriverCounter,
        "Pixels whose texture coordinates were compared.",
    ).or(NO_TEXELS);
    COLOUR_MAX = Metric::error(
        "colour_max",
        "",
        "Largest difference of a colour channel from the reference's picture, of 255, over pixels that both fill with the same region, edges included.",
    ).or(NO_TEXELS);
    COLOUR_MEAN = Metric::error(
        "colour_mean",
        "",
        "Mean of those differences over the three channels.",
    ).or(NO_TEXELS);
    MESH_VERTICES = Metric::quantity("mesh_vertices", "Vertices of their meshes, each counted once.");
    MESH_TRIANGLES = Metric::quantity("mesh_triangles", "Triangles of one cap.");
    BOUNDARY_EDGES = Metric::quantity("boundary_edges", "Edges of their boundaries: as many walls.");
    BOUNDARY_LOOPS = Metric::quantity("boundary_loops", "Closed loops of their boundaries.");
    FORMULA_VERTEX_BYTES = Metric::bytes(
        "formula_vertex_bytes",
        "Bytes of positions and flags by the layout's formula. A layout that is made every frame holds what it makes for the regions in view only.",
    );
    FORMULA_INDEX_BYTES = Metric::bytes(
        "formula_index_bytes",
        "Bytes of indices by the layout's formula, as for vertices.",
    );
    ALLOCATED_VERTEX_BYTES = Metric::bytes(
        "allocated_vertex_bytes",
        "Bytes of positions and flags as the technique allocated them; empty where nothing was drawn. Must equal the formula.",
    );
    ALLOCATED_INDEX_BYTES = Metric::bytes("allocated_index_bytes", "Bytes of indices as allocated, as for vertices.");
    REGION_BYTES_SMALLEST = Metric::bytes(
        "region_bytes_smallest",
        "Bytes of the smallest region by formula, without what regions share.",
    );
    REGION_BYTES_MEDIAN = Metric::bytes("region_bytes_median", "Bytes of the median region by formula.");
    REGION_BYTES_LARGEST = Metric::bytes("region_bytes_largest", "Bytes of the largest region by formula.");
}
