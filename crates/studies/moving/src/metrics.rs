// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Metric, Primary, Scope};

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    SENSORS = "sensors", "how many sensors sweep";
    UPKEEP = "upkeep", "how a new footprint reaches the device";
}

terrafill_results::metrics! {
    MESH = Metric::time_ms(
        "moving_mesh_cpu_ms",
        "Process CPU time of meshing all moved regions of a frame.",
    )
    .covering(Scope::PLAN);
    PLAN = Metric::time_ms(
        "moving_plan_cpu_ms",
        "Process CPU time of joining the moved meshes with the scene and planning the frame.",
    )
    .covering(Scope::PLAN);
    UPDATE = Metric::time_ms(
        "moving_update_cpu_ms",
        "Process CPU time of handing the changed scene to the technique, uploads included; the device may copy \
         them later.",
    )
    .covering(Scope::UPLOAD);
    MESH_AND_UPDATE = Metric::time_ms(
        "moving_mesh_and_update_cpu_ms",
        "Process CPU time of meshing all moved regions of a frame and of handing them to the technique.",
    )
    .covering(Scope::PLAN.and(Scope::UPLOAD));
    FILL_CPU = Metric::time_ms(
        "moving_fill_cpu_ms",
        "Process CPU time of filling the frame, from recording until the device is done.",
    )
    .covering(Scope::FRAME);
    FILL_GPU = Metric::time_ms("moving_fill_gpu_ms", "GPU time of filling the frame.")
        .covering(Scope::DEVICE);
    FRAME_CPU = Metric::time_ms(
        "moving_frame_cpu_ms",
        "Process CPU time of a frame with moved regions: mesh, plan, update and fill.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .ranking(Primary::Cpu);
    FRAME_WALL = Metric::time_ms("moving_frame_wall_ms", "Wall clock over the same span.")
        .covering(Scope::PLAN.and(Scope::FRAME))
        .ranking(Primary::Wall);
    BYTES = Metric::bytes(
        "moving_upload_bytes",
        "Bytes handed to the device for a frame, constants included; largest of all frames.",
    );
    REGIONS = Metric::counter(
        "moving_uploaded_regions",
        "Regions whose geometry was uploaded for a frame; largest of all frames.",
    );
    COMPARED = Metric::quantity(
        "moving_frames_compared",
        "Frames that were compared with the reference of that frame.",
    );
    WRONG = Metric::error(
        "moving_frames_wrong",
        "",
        "Frames that were not within the tolerances of a fill.",
    );
    OUTSIDE = Metric::error_px(
        "moving_outside_px",
        "Pixels outside the boundary band that differ from the reference; largest of all frames.",
    );
    BOUND_M = Metric::error(
        "moving_bound_m",
        "m",
        "Upper bound on how far vertices that the device computes are off; largest of all frames.",
    );
    BOUND_PX = Metric::error_px(
        "moving_bound_px",
        "The same in pixels at the distance of the nearest ground.",
    );
}
