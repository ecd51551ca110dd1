// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Metric, Primary, Scope};

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    SENSORS = "sensors";
    UPKEEP = "upkeep";
}

pub(crate) const MESH: &Metric = &Metric::time_ms(
    "moving_mesh_cpu_ms",
    "Process CPU time of meshing all moved regions of a frame.",
)
.covering(Scope::PLAN);
pub(crate) const PLAN: &Metric = &Metric::time_ms(
    "moving_plan_cpu_ms",
    "Process CPU time of joining the moved meshes with the scene and planning the frame.",
)
.covering(Scope::PLAN);
pub(crate) const UPDATE: &Metric = &Metric::time_ms(
    "moving_update_cpu_ms",
    "Process CPU time of handing the changed scene to the technique, uploads included; the device may copy \
     them later.",
)
.covering(Scope::UPLOAD);
pub(crate) const MESH_AND_UPDATE: &Metric = &Metric::time_ms(
    "moving_mesh_and_update_cpu_ms",
    "Process CPU time of meshing all moved regions of a frame and of handing them to the technique.",
)
.covering(Scope::PLAN.and(Scope::UPLOAD));
pub(crate) const FILL_CPU: &Metric = &Metric::time_ms(
    "moving_fill_cpu_ms",
    "Process CPU time of filling the frame, from recording until the device is done.",
)
.covering(Scope::FRAME);
pub(crate) const FILL_GPU: &Metric =
    &Metric::time_ms("moving_fill_gpu_ms", "GPU time of filling the frame.")
        .covering(Scope::DEVICE);
pub(crate) const FRAME_CPU: &Metric = &Metric::time_ms(
    "moving_frame_cpu_ms",
    "Process CPU time of a frame with moved regions: mesh, plan, update and fill.",
)
.covering(Scope::PLAN.and(Scope::FRAME))
.ranking(Primary::Cpu);
pub(crate) const FRAME_WALL: &Metric =
    &Metric::time_ms("moving_frame_wall_ms", "Wall clock over the same span.")
        .covering(Scope::PLAN.and(Scope::FRAME))
        .ranking(Primary::Wall);
pub(crate) const BYTES: &Metric = &Metric::bytes(
    "moving_upload_bytes",
    "Bytes handed to the device for a frame, constants included; largest of all frames.",
);
pub(crate) const REGIONS: &Metric = &Metric::counter(
    "moving_uploaded_regions",
    "Regions whose geometry was uploaded for a frame; largest of all frames.",
);
pub(crate) const COMPARED: &Metric = &Metric::quantity(
    "moving_frames_compared",
    "Frames that were compared with the reference of that frame.",
);
pub(crate) const WRONG: &Metric = &Metric::error(
    "moving_frames_wrong",
    "",
    "Frames that were not within the tolerances of a fill.",
);
pub(crate) const OUTSIDE: &Metric = &Metric::error_px(
    "moving_outside_px",
    "Pixels outside the boundary band that differ from the reference; largest of all frames.",
);
pub(crate) const BOUND_M: &Metric = &Metric::error(
    "moving_bound_m",
    "m",
    "Upper bound on how far vertices that the device computes are off; largest of all frames.",
);
pub(crate) const BOUND_PX: &Metric = &Metric::error_px(
    "moving_bound_px",
    "The same in pixels at the distance of the nearest ground.",
);

/// Everything that the study measures.
#[rustfmt::skip]
pub(crate) const METRICS: [Metric; 15] = [
    *MESH, *PLAN, *UPDATE, *MESH_AND_UPDATE, *FILL_CPU, *FILL_GPU, *FRAME_CPU, *FRAME_WALL,
    *BYTES, *REGIONS, *COMPARED, *WRONG, *OUTSIDE, *BOUND_M, *BOUND_PX,
];
