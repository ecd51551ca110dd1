// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Metric, Primary, Scope};

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; 14] = [
    Metric::time_ms(
"moving_mesh_cpu_ms",
        "Process CPU time of meshing all moved regions of a frame.",
    )
    .covering(Scope::PLAN),
    Metric::time_ms(
"moving_plan_cpu_ms",
        "Process CPU time of joining the moved meshes with the scene and planning the frame.",
    )
    .covering(Scope::PLAN),
    Metric::time_ms(
"moving_update_cpu_ms",
        "Process CPU time of handing the changed scene to the technique, uploads included; the device may copy them later.",
    )
    .covering(Scope::UPLOAD),
    Metric::time_ms(
"moving_fill_cpu_ms",
        "Process CPU time of filling the frame, from recording until the device is done.",
    )
    .covering(Scope::FRAME),
    Metric::time_ms(
"moving_fill_gpu_ms",
        "GPU time of filling the frame.",
    )
    .covering(Scope::DEVICE),
    Metric::time_ms(
"moving_frame_cpu_ms",
        "Process CPU time of a frame with moved regions: mesh, plan, update and fill.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Cpu),
    Metric::time_ms(
"moving_frame_wall_ms",
        "Wall clock over the same span.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Wall),
    Metric::bytes(
"moving_upload_bytes",
        "Bytes handed to the device for a frame, constants included; largest of all frames.",
    ),
    Metric::counter(
"moving_uploaded_regions",
        "Regions whose geometry was uploaded for a frame; largest of all frames.",
    ),
    Metric::quantity(
"moving_frames_compared",
        "Frames that were compared with the reference of that frame.",
    ),
    Metric::error(
"moving_frames_wrong",
"",
        "Frames that were not within the tolerances of a fill.",
    ),
    Metric::error_px(
"moving_outside_px",
        "Pixels outside the boundary band that differ from the reference; largest of all frames.",
    ),
    Metric::error(
"moving_bound_m",
"m",
        "Upper bound on how far vertices that the device computes are off; largest of all frames.",
    ),
    Metric::error_px(
"moving_bound_px",
        "The same in pixels at the distance of the nearest ground.",
    ),
];
