// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured.

use terrafill_results::{Kind, Metric};

pub(crate) const METRICS: [Metric; 14] = [
    Metric::less(
        "pipeline_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of a frame of a grid: sending what is sent, recording, and waiting for the device.",
    ),
    Metric::less(
        "pipeline_wall_ms",
        "ms",
        Kind::Time,
        "Wall clock over the same span.",
    ),
    Metric::less(
        "pipeline_gpu_ms",
        "ms",
        Kind::Time,
        "GPU time of drawing a grid; on Vulkan with the dispatch before it.",
    ),
    Metric::less(
        "pipeline_mismatched_px",
        "px",
        Kind::Error,
        "Pixels that show another triangle or point than the reference allows, outside of the band of 1/32 pixel.",
    ),
    Metric::neither(
        "pipeline_band_px",
        "px",
        Kind::Error,
        "Pixels that differ from the ray through their centre, whose border passes within 1/32 pixel of it.",
    ),
    Metric::less(
        "pipeline_differing_px",
        "px",
        Kind::Error,
        "Pixels that differ from those of the first way on the same interface with the same primitives.",
    ),
    Metric::neither(
        "pipeline_shown_px",
        "px",
        Kind::DriverCounter,
        "Pixels that show the grid.",
    ),
    Metric::less(
        "pipeline_sent_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of vertices or points that the CPU sends for each frame.",
    ),
    Metric::less(
        "pipeline_held_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes that the device holds: heights where they are fetched, vertices, points, indices, expanded vertices.",
    ),
    Metric::less(
        "pipeline_emitted_vertices",
        "",
        Kind::Counter,
        "Vertices that the last stage before rasterisation gives, by the definition of the way.",
    ),
    Metric::less(
        "pipeline_draws",
        "",
        Kind::Counter,
        "Draw calls of a frame.",
    ),
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
];
