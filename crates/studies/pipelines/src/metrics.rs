// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured.

use terrafill_results::{Kind, Metric, Primary, Scope};

pub(crate) const METRICS: [Metric; 50] = [
    Metric::time_ms(
        "pipeline_cpu_ms",
        "Process CPU time of a frame of a grid: sending what is sent, recording, and waiting for \
         the device.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Cpu),
    Metric::time_ms("pipeline_wall_ms", "Wall clock over the same span.")
        .covering(Scope::PLAN.and(Scope::FRAME)),
    Metric::time_ms(
        "pipeline_gpu_ms",
        "GPU time of drawing a grid; on Vulkan with the dispatch before it.",
    )
    .covering(Scope::DEVICE)
    .ranking(Primary::Gpu),
    Metric::error_px(
        "pipeline_mismatched_px",
        "Pixels that show another triangle or point than the reference allows, outside of the \
         band of 1/32 pixel.",
    ),
    Metric::neither(
        "pipeline_band_px",
        "px",
        Kind::Error,
        "Pixels that differ from the ray through their centre, whose border passes within 1/32 \
         pixel of it.",
    ),
    Metric::error_px(
        "pipeline_differing_px",
        "Pixels that differ from those of the first way on the same interface with the same \
         primitives.",
    ),
    Metric::neither(
        "pipeline_shown_px",
        "px",
        Kind::DriverCounter,
        "Pixels that show the grid.",
    ),
    Metric::bytes(
        "pipeline_sent_bytes",
        "Bytes of vertices or points that the CPU sends for each frame.",
    ),
    Metric::bytes(
        "pipeline_held_bytes",
        "Bytes that the device holds: heights where they are fetched, vertices, points, indices, \
         expanded vertices.",
    ),
    Metric::counter(
        "pipeline_emitted_vertices",
        "Vertices that the last stage before rasterisation gives, by the definition of the way.",
    ),
    Metric::counter("pipeline_draws", "Draw calls of a frame."),
    Metric::less(
        "pipeline_vertex_invocations",
        "",
        Kind::DriverCounter,
        "Vertex shader invocations that the device counted.",
    ),
    Metric::less(
        "pipeline_geometry_invocations",
        "",
        Kind::DriverCounter,
        "Geometry shader invocations that the device counted.",
    ),
    Metric::neither(
        "pipeline_primitives",
        "",
        Kind::DriverCounter,
        "Primitives that reached clipping, as the device counted them.",
    ),
    Metric::counter(
        "cull_tiles",
        "Tiles of 256 whose box of least and greatest height meets the view.",
    ),
    Metric::counter("cull_in_tiles", "Patches in those tiles."),
    Metric::quantity(
        "cull_needed",
        "Patches of which a cell is not wholly outside of one plane of the view, by the reference.",
    ),
    Metric::counter(
        "cull_kept",
        "Patches that are kept: by the list, the primitives or the task shader's count.",
    ),
    Metric::error("cull_lost", "", "Patches that are needed and not kept."),
    Metric::error(
        "cull_extra_share",
        "",
        "Patches that are kept and not needed, of those needed.",
    ),
    Metric::error(
        "cache_differing",
        "",
        "Texels looked up, before and after a block was written anew, that are not those by \
         arithmetic of integers.",
    ),
    Metric::quantity("cache_asked", "Texels that were looked up for that."),
    Metric::counter(
        "cache_binds",
        "Bind groups set, and dispatches, of a frame.",
    ),
    Metric::bytes("cache_bytes", "Bytes of all texels."),
    Metric::bytes(
        "cache_update_bytes",
        "Bytes that the CPU sends for a block that is written anew.",
    ),
    Metric::less(
        "cache_update_cpu_us",
        "µs",
        Kind::Time,
        "Process CPU time of writing a block of 64 × 64 texels anew and waiting for the device.",
    )
    .covering(Scope::UPLOAD),
    Metric::less(
        "cache_update_wall_us",
        "µs",
        Kind::Time,
        "Wall clock over the same span.",
    )
    .covering(Scope::UPLOAD),
    Metric::counter(
        "lights_passes",
        "Passes of a frame: those of the lights' depth maps and that of the picture.",
    ),
    Metric::error(
        "lights_depths_differing",
        "",
        "Depths of all maps whose bits differ from those of a pass a light.",
    ),
    Metric::error(
        "lights_map_error",
        "",
        "Of pixels and lights looked at, the share whose shadow differs from a ray from the \
         place to the light.",
    ),
    Metric::time_ms(
        "lights_maps_cpu_ms",
        "Process CPU time of the depth maps alone.",
    )
    .covering(Scope::DRAW),
    Metric::time_ms("lights_maps_gpu_ms", "GPU time of the depth maps alone.")
        .covering(Scope::DRAW),
    Metric::error(
        "layered_wrong_texels",
        "",
        "Texels of shadows' maps that are not what an f64 ray along the light meets, outside of \
         1/32 texel of an edge.",
    ),
    Metric::error_px(
        "layered_wrong_px",
        "Pixels of shadows or blur outside of what the CPU's definition allows, its rounding \
         bounded.",
    ),
    Metric::neither(
        "layered_open_px",
        "px",
        Kind::Error,
        "Pixels whose light may be anything, since rounding may turn their variance to 0.",
    ),
    Metric::neither(
        "layered_judged_px",
        "px",
        Kind::Counter,
        "Pixels of shadows or blur that were held against the definition.",
    ),
    Metric::error_px(
        "variance_black_px",
        "Pixels of a lit plane with less than 0.01 of the light.",
    ),
    Metric::error(
        "variance_relative_rms",
        "",
        "Root mean square error of the variance of 25 taps over the exact one, relative to that.",
    ),
    Metric::error(
        "variance_absolute_rms",
        "",
        "Root mean square error of the variance, of the depth range squared.",
    ),
    Metric::error(
        "variance_absolute_max",
        "",
        "Largest error of the variance.",
    ),
    Metric::error(
        "variance_non_finite",
        "",
        "Windows whose variance or light is NaN or infinite.",
    ),
    Metric::error(
        "variance_dark_share",
        "",
        "Share of the pixels of a lit plane with less than 0.99 of the light.",
    ),
    Metric::error(
        "variance_black_share",
        "",
        "Share of the pixels of a lit plane with less than 0.01 of the light.",
    ),
    Metric::error(
        "variance_outside_share",
        "",
        "Share of the pixels of a lit plane whose light is below 0 or above 1.",
    ),
    Metric::error(
        "hard_wrong_area",
        "",
        "Area that a hard shadow's map shows wrongly, as a share of the map.",
    ),
    Metric::neither(
        "hard_area_share",
        "",
        Kind::Error,
        "That area over the shadow's perimeter times the size of a texel.",
    ),
    Metric::error(
        "hard_deviation_texels",
        "",
        "Largest distance of a wrongly shown place from the shadow's edge, in texels.",
    ),
    Metric::error(
        "blur_rms",
        "",
        "Root mean square error of the trail's pixels against the integral over time, full scale \
         1.",
    ),
    Metric::error("blur_max", "", "Largest error of a pixel of the trail."),
    Metric::quantity("blur_layers", "Layers that are drawn."),
];
