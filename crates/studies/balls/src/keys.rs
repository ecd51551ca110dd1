// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared PART, SIZE_PX;
    ARITHMETIC = "arithmetic";
    BALLS = "balls";
    DRAWN = "drawn";
    GROUND = "ground";
    INTEGRATOR = "integrator";
    INTERFACE = "interface";
    STATE = "state";
    STEPS_PER_SECOND = "steps_per_second";
    STIFFNESS = "stiffness";
    WAY = "way";
}

terrafill_results::metrics! {
    METRICS;
    BALL_BLOWN_SHARE = "ball_blown_share"; BALL_CPU_US = "ball_cpu_us"; BALL_DEVICE_MAX_M = "ball_device_max_m";
    BALL_DEVICE_RMS_M = "ball_device_rms_m"; BALL_DIFFERING_PX = "ball_differing_px"; BALL_DRAWS = "ball_draws";
    BALL_DRAW_GPU_US = "ball_draw_gpu_us"; BALL_ENERGY_CHANGE = "ball_energy_change";
    BALL_MISMATCHED_PX = "ball_mismatched_px"; BALL_RMS_M = "ball_rms_m"; BALL_TERRAIN_BEYOND = "ball_terrain_beyond";
    BALL_TERRAIN_GUIDED_M = "ball_terrain_guided_m"; BALL_TERRAIN_MAX_M = "ball_terrain_max_m";
    BALL_TERRAIN_P95_M = "ball_terrain_p95_m"; BALL_TERRAIN_STEP_M = "ball_terrain_step_m";
    BALL_TERRAIN_UNEXPLAINED = "ball_terrain_unexplained"; BALL_UPLOAD_BYTES = "ball_upload_bytes";
}
