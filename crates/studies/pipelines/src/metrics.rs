// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, SIZE_PX, VIEW;
    ACCESS = "access", "in which order blocks of a cache are read";
    BLOCKS = "blocks", "how many blocks a cache holds";
    CELLS_PER_POINT = "cells_per_point", "cells that the geometry shader makes of each point";
    CUT = "cut", "how the cells of a geometry image are cut: as published, or along the folds of its octahedron";
    DECLARED = "declared", "vertices that the geometry shader declares at most";
    DEPTH = "depth", "format of the depths that variances are made of";
    DRAWINGS = "drawings", "how often a deformed model is drawn in a frame";
    EXPERIMENT = "experiment", "which question of the chapter";
    FLIGHT_S = "flight_s", "at which second of the flight";
    FLOOR = "floor", "what the least variance of a shadow map is";
    GRID_CELLS = "grid_cells", "cells along a side of the grid";
    KEPT_IN = "kept_in", "where blocks are kept: in an array of textures, or in a texture each";
    LAYERS = "layers", "pictures of moments that are laid over each other";
    LAYERS_BY = "layers_by", "what sends triangles to a layer: a pass each, or a stage of one pass";
    LEVEL = "level", "how often a side of a patch is divided";
    LIGHTS = "lights", "how many lights cast shadows";
    MAP_TEXELS = "map_texels", "texels along a side of a map";
    MOMENTS = "moments", "which moments layers show: the middle of each part of the time, or jittered ones";
    PLACE = "place", "where patches are left out: nowhere, on the CPU, or in a stage of the device";
    RESOLVE = "resolve", "how layers become a picture";
    SHADOW_FILTER = "shadow_filter", "how depths of a map become a share of light";
    SIGMA = "sigma", "spread of depths within a filter";
    SOURCE = "source", "where heights come from: from the CPU in each frame, or from a buffer";
    STORED = "stored", "how places of a geometry image are stored";
    STRIP = "strip", "what a strip of triangles holds: a cell, or a row of cells";
    TEST = "test", "how a patch is tested: by its first corner, or by its box";
    TEXELS = "texels", "texels along a side";
    TILE_CELLS = "tile_cells", "cells along a side of a tile, which is culled as a whole";
    WAY = "way", "how a grid reaches the rasteriser: what the CPU sends, and which stages make triangles of it";
    "sent-points" = "the CPU sends points with their heights in each frame";
    "sent-strips" = "the CPU sends strips of triangles with their heights in each frame";
    "fetched-points" = "numbers of points lie in a buffer; the vertex shader fetches heights";
    "geometry-shader" = "the geometry shader makes cells of points, or drops those that are not seen";
    "no-vertex-buffer" = "the vertex shader has the numbers of vertices and nothing else";
    "indexed-patch" = "instances of one indexed patch";
    "compute-indirect" = "compute places every vertex, and says how many are drawn";
    "mesh-shader" = "a mesh shader makes the triangles";
    "geometry-patch" = "an invocation of a geometry shader divides a patch";
    "geometry-row" = "an invocation of a geometry shader makes a row of a patch's cells";
    "compute-buffer" = "compute places every vertex once";
    "deformed-anew" = "the vertex shader deforms the model in each drawing";
    "stream-output" = "vertices are deformed once, and transform feedback keeps them";
    "indexed" = "indices of all triangles; the vertex shader fetches places";
    "tessellation" = "the tessellation stages divide a patch";
    "tiles-alone" = "no patch is left out: all of the tiles in view are drawn";
    "compute" = "compute makes the list of patches, and says how many are drawn";
    "rebound" = "a texture a block, bound for its own draw";
    "one-depth" = "the depth of one texel is compared";
    "25-depths-compared" = "the share of 5 × 5 texels whose depth does not hide the place";
    "25-depths-variance" = "by mean and variance of 5 × 5 depths, as published";
    "25-depths-variance-about-the-place" = "the same of depths less that of the place";
    "none" = "without a test";
    "box" = "by the box of least and greatest height against the planes of the frustum";
    "point" = "by the first corner, projected";
    "passes" = "a pass for each layer";
    "multiview" = "one pass, which Vulkan sends to every layer";
    "vertex-layer" = "one pass with an instance a layer, which the vertex shader chooses";
    "geometry-copies" = "one pass, whose geometry shader copies each triangle into every layer";
    "geometry-invocations" = "the same, by an invocation of the geometry shader a layer";
    "published" = "as the paper of 2007 has it";
    "fold" = "cells cut along the lines at which the square was folded to a closed mesh";
    "filter" = "how depths of a map become a share of light";
    "geometry image" = "places of a mesh as texels of a square image";
    "motion blur" = "what a pixel sees in the mean while the shutter is open";
    "blended-f32" = "layers are added up in a target of 32 bits";
    "blended-f16" = "layers are added up in a target of 16 bits";
    "blended-8-bit" = "layers are added up in a target of 8 bits";
    "middle" = "the middle of each part of the exposure";
    "jittered" = "anywhere in each part, each pixel of a tile of 2 × 2 for itself: interleaved sampling";
    "patch" = "16 × 16 cells or as many as are culled together";
    "level 2" = "culling of patches within the tiles in view";
    "flight" = "a path of the camera over the ground";
    "points" = "corners of cells of the grid";
    "grid" = "a terrain of square cells";
    "trail" = "pixels that something moving touches";
    "spread" = "standard deviation of depths";
    "read" = "in which order blocks of a cache are read";
    "shown" = "which picture of a shadow map";
    "cells" = "squares of a height grid, each between four points";
}

terrafill_results::metrics! {
    PIPELINE_CPU_MS = Metric::time_ms(
        "pipeline_cpu_ms",
        "Process CPU time of a frame of a grid: sending what is sent, recording, and waiting for \
         the device.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Cpu);
    PIPELINE_WALL_MS = Metric::time_ms("pipeline_wall_ms", "Wall clock over the same span.")
        .covering(Scope::PLAN.and(Scope::FRAME));
    PIPELINE_GPU_MS = Metric::time_ms(
        "pipeline_gpu_ms",
        "GPU time of drawing a grid; on Vulkan with the dispatch before it.",
    )
    .covering(Scope::DEVICE)
    .ranking(Primary::Gpu);
    PIPELINE_MISMATCHED_PX = Metric::error_px(
        "pipeline_mismatched_px",
        "Pixels that show another triangle or point than the reference allows, outside of the \
         band of 1/32 pixel.",
    );
    PIPELINE_BAND_PX = Metric::neither(
        "pipeline_band_px",
        "px",
        Kind::Error,
        "Pixels that differ from the ray through their centre, whose border passes within 1/32 \
         pixel of it.",
    );
    PIPELINE_DIFFERING_PX = Metric::error_px(
        "pipeline_differing_px",
        "Pixels that differ from those of the first way on the same interface with the same \
         primitives; of culling, less those where rays allow both.",
    );
    PIPELINE_SHOWN_PX = Metric::neither(
        "pipeline_shown_px",
        "px",
        Kind::DriverCounter,
        "Pixels that show the grid.",
    );
    PIPELINE_SENT_BYTES = Metric::bytes(
        "pipeline_sent_bytes",
        "Bytes of vertices or points that the CPU sends for each frame.",
    );
    PIPELINE_HELD_BYTES = Metric::bytes(
        "pipeline_held_bytes",
        "Bytes that the device holds: heights where they are fetched, vertices, points, indices, \
         expanded vertices.",
    );
    PIPELINE_EMITTED_VERTICES = Metric::counter(
        "pipeline_emitted_vertices",
        "Vertices that the last stage before rasterisation gives, by the definition of the way.",
    );
    PIPELINE_DRAWS = Metric::counter("pipeline_draws", "Draw calls of a frame.");
    PIPELINE_VERTEX_INVOCATIONS = Metric::less(
        "pipeline_vertex_invocations",
        "",
        Kind::DriverCounter,
        "Vertex shader invocations that the device counted.",
    );
    PIPELINE_GEOMETRY_INVOCATIONS = Metric::less(
        "pipeline_geometry_invocations",
        "",
        Kind::DriverCounter,
        "Geometry shader invocations that the device counted.",
    );
    PIPELINE_PRIMITIVES = Metric::neither(
        "pipeline_primitives",
        "",
        Kind::DriverCounter,
        "Primitives that reached clipping, as the device counted them.",
    );
    SURFACE_ERROR_MAX_M = Metric::error(
        "surface_error_max_m",
        "m",
        "Largest distance of the drawn triangles from the surface that they stand for, at seven \
         places of each; f64.",
    );
    SURFACE_ERROR_RMS_M = Metric::error(
        "surface_error_rms_m",
        "m",
        "Root mean square of those distances.",
    );
    SURFACE_ERROR_PX = Metric::error_px(
        "surface_error_px",
        "The largest of those distances as it is seen, were it across the view.",
    );
    DEFORMED_VERTICES = Metric::counter(
        "deformed_vertices",
        "Vertices that are deformed in a frame, by the definition of the way.",
    );
    KEPT_ERROR_M = Metric::error(
        "kept_error_m",
        "m",
        "Largest distance of a deformed vertex that was kept from its place in f64.",
    )
    .or("nothing is kept");
    CULL_TILES = Metric::counter(
        "cull_tiles",
        "Tiles whose box of least and greatest height meets the view.",
    );
    CULL_NEEDED = Metric::quantity(
        "cull_needed",
        "Patches of which a cell is not wholly outside of one plane of the view, by the reference.",
    );
    CULL_KEPT = Metric::counter(
        "cull_kept",
        "Patches that are kept: by the list, the primitives or the task shader's count.",
    );
    CULL_LOST = Metric::error("cull_lost", "", "Patches that are needed and not kept.");
    CULL_EXTRA_SHARE = Metric::error(
        "cull_extra_share",
        "",
        "Patches that are kept and not needed, of those needed.",
    );
    SOFT_RMS = Metric::error(
        "soft_rms",
        "",
        "Root mean square difference of the mean share of light from exact visibility by rays in f64.",
    );
    SOFT_MEAN = Metric::neither(
        "soft_mean",
        "",
        Kind::Error,
        "Mean of that difference: above 0 the picture is too light.",
    );
    CUBE_SEAM_TEXELS = Metric::quantity(
        "cube_seam_texels",
        "Texels along the borders of a cube's faces, all of which are held against rays.",
    );
    CUBE_SEAM_WRONG = Metric::error(
        "cube_seam_wrong",
        "",
        "Those of them whose depth is not that of rays within 1/32 texel.",
    );
    CUBE_INNER_WRONG = Metric::error(
        "cube_inner_wrong",
        "",
        "The same of other texels that are held against rays.",
    );
    CUBE_COLOUR_WRONG = Metric::error(
        "cube_colour_wrong",
        "",
        "Texels of a cube's faces, of all that are held against rays, whose colour is not that of the triangle that a ray \
         within 1/32 texel meets.",
    );
    CACHE_DIFFERING = Metric::error(
        "cache_differing",
        "",
        "Texels looked up, before and after a block was written anew, that are not those by \
         arithmetic of integers.",
    );
    CACHE_BINDS = Metric::counter(
        "cache_binds",
        "Bind groups set in a frame, a draw after each.",
    );
    CACHE_BYTES = Metric::bytes("cache_bytes", "Bytes of all texels.");
    CACHE_UPDATE_CPU_US = Metric::less(
        "cache_update_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of writing a block of 64 × 64 texels anew and waiting for the device.",
    )
    .covering(Scope::UPLOAD);
    CACHE_UPDATE_WALL_US = Metric::less(
        "cache_update_wall_us",
        "µs",
        Kind::Time,
        "Wall clock over the same span.",
    )
    .covering(Scope::UPLOAD);
    LIGHTS_PASSES = Metric::counter(
        "lights_passes",
        "Passes of a frame: those that draw or add up layers, and that of the picture.",
    );
    LIGHTS_DEPTHS_DIFFERING = Metric::error(
        "lights_depths_differing",
        "",
        "Depths of all layers, and colours of a cube's faces, whose bits differ from those of the first way drawn, \
         usually a pass a layer.",
    );
    LIGHTS_MAP_ERROR = Metric::error(
        "lights_map_error",
        "",
        "Of pixels and lights looked at, the share whose shadow differs from a ray from the \
         place to the light.",
    );
    LIGHTS_MAPS_CPU_MS = Metric::time_ms(
        "lights_maps_cpu_ms",
        "Process CPU time of the layers alone.",
    )
    .covering(Scope::DRAW);
    LIGHTS_MAPS_GPU_MS = Metric::time_ms("lights_maps_gpu_ms", "GPU time of the layers alone.")
        .covering(Scope::DRAW);
    LAYERED_WRONG_TEXELS = Metric::error(
        "layered_wrong_texels",
        "",
        "Texels of shadows' maps that are not what an f64 ray along the light meets, outside of \
         1/32 texel of an edge.",
    );
    LAYERED_WRONG_PX = Metric::error_px(
        "layered_wrong_px",
        "Pixels of shadows or blur outside of what the CPU's definition or rays allow, rounding \
         bounded.",
    );
    LAYERED_OPEN_PX = Metric::neither(
        "layered_open_px",
        "px",
        Kind::Error,
        "Pixels whose light may be anything, since rounding may turn their variance to 0.",
    );
    LAYERED_JUDGED_PX = Metric::neither(
        "layered_judged_px",
        "px",
        Kind::Counter,
        "Pixels of shadows or blur that were held against the definition.",
    );
    VARIANCE_BLACK_PX = Metric::error_px(
        "variance_black_px",
        "Pixels of a lit plane with less than 0.01 of the light.",
    );
    VARIANCE_RELATIVE_RMS = Metric::error(
        "variance_relative_rms",
        "",
        "Root mean square error of the variance of 25 taps over the exact one, relative to that.",
    );
    VARIANCE_ABSOLUTE_RMS = Metric::error(
        "variance_absolute_rms",
        "",
        "Root mean square error of the variance, of the depth range squared.",
    );
    VARIANCE_ABSOLUTE_MAX = Metric::error(
        "variance_absolute_max",
        "",
        "Largest error of the variance.",
    );
    VARIANCE_NON_FINITE = Metric::error(
        "variance_non_finite",
        "",
        "Windows whose variance or light is NaN or infinite.",
    );
    VARIANCE_DARK_SHARE = Metric::error(
        "variance_dark_share",
        "",
        "Share of the pixels of a lit plane with less than 0.99 of the light.",
    );
    VARIANCE_OUTSIDE_SHARE = Metric::error(
        "variance_outside_share",
        "",
        "Share of the pixels of a lit plane whose light is below 0 or above 1.",
    );
    HARD_WRONG_AREA = Metric::error(
        "hard_wrong_area",
        "",
        "Area that a hard shadow's map shows wrongly, as a share of the map.",
    );
    HARD_AREA_SHARE = Metric::neither(
        "hard_area_share",
        "",
        Kind::Error,
        "That area over the shadow's perimeter times the size of a texel.",
    );
    HARD_DEVIATION_TEXELS = Metric::error(
        "hard_deviation_texels",
        "",
        "Largest distance of a wrongly shown place from the shadow's edge, in texels.",
    );
    BLUR_RMS = Metric::error(
        "blur_rms",
        "",
        "Root mean square error of the trail's pixels against 1,024 moments by rays in f64, full \
         scale 1.",
    );
    BLUR_MAX = Metric::error("blur_max", "", "Largest error of a pixel of the trail.");
}
