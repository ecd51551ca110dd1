// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 14] = [
    Metric::less(
        "moving_mesh_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of meshing all moved regions of a frame.",
    )
    .covering(Scope::PLAN),
    Metric::less(
        "moving_plan_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of joining the moved meshes with the scene and planning the frame.",
    )
    .covering(Scope::PLAN),
    Metric::less(
        "moving_update_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of handing the changed scene to the technique, uploads included; the device may copy them later.",
    )
    .covering(Scope::UPLOAD),
    Metric::less(
        "moving_fill_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of filling the frame, from recording until the device is done.",
    )
    .covering(Scope::FRAME),
    Metric::less(
        "moving_fill_gpu_ms",
        "ms",
        Kind::Time,
        "GPU time of filling the frame.",
    )
    .covering(Scope::DEVICE),
    Metric::less(
        "moving_frame_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of a frame with moved regions: mesh, plan, update and fill.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Cpu),
    Metric::less(
        "moving_frame_wall_ms",
        "ms",
        Kind::Time,
        "Wall clock over the same span.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Wall),
    Metric::less(
        "moving_upload_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes handed to the device for a frame, constants included; largest of all frames.",
    ),
    Metric::less(
        "moving_uploaded_regions",
        "",
        Kind::Counter,
        "Regions whose geometry was uploaded for a frame; largest of all frames.",
    ),
    Metric::neither(
        "moving_frames_compared",
        "",
        Kind::Counter,
        "Frames that were compared with the reference of that frame.",
    ),
    Metric::less(
        "moving_frames_wrong",
        "",
        Kind::Error,
        "Frames that were not within the tolerances of a fill.",
    ),
    Metric::less(
        "moving_outside_px",
        "px",
        Kind::Error,
        "Pixels outside the boundary band that differ from the reference; largest of all frames.",
    ),
    Metric::less(
        "moving_bound_m",
        "m",
        Kind::Error,
        "Upper bound on how far vertices that the device computes are off; largest of all frames.",
    ),
    Metric::less(
        "moving_bound_px",
        "px",
        Kind::Error,
        "The same in pixels at the distance of the nearest ground.",
    ),
];
