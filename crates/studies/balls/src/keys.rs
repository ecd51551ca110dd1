// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;
use terrafill_results::Metric;

terrafill_results::conditions! {
    shared PART, SIZE_PX;
    ARITHMETIC = "arithmetic";
    BALLS = "balls";
    DATUM_M = "datum_m";
    DRAWN = "drawn";
    GROUND = "ground";
    INTEGRATOR = "integrator";
    INTERFACE = "interface";
    OMEGA_DT = "omega_dt";
    RESTITUTION = "restitution";
    STATE = "state";
    STEPS_PER_SECOND = "steps_per_second";
    STIFFNESS = "stiffness";
    WAY = "way";
}

pub(crate) const BALL_ENERGY_CHANGE: &Metric = Metric::of(&METRICS, "ball_energy_change");
pub(crate) const BALL_BLOWN_SHARE: &Metric = Metric::of(&METRICS, "ball_blown_share");
pub(crate) const BALL_CONTACT_ENERGY_MEAN: &Metric =
    Metric::of(&METRICS, "ball_contact_energy_mean");
pub(crate) const BALL_CONTACT_ENERGY_MAX: &Metric = Metric::of(&METRICS, "ball_contact_energy_max");
pub(crate) const BALL_CONTACT_ENERGY_RMS: &Metric = Metric::of(&METRICS, "ball_contact_energy_rms");
pub(crate) const BALL_SUNK_SHARE: &Metric = Metric::of(&METRICS, "ball_sunk_share");
pub(crate) const BALL_REST_GAP_M: &Metric = Metric::of(&METRICS, "ball_rest_gap_m");
pub(crate) const BALL_REST_SPEED: &Metric = Metric::of(&METRICS, "ball_rest_speed");
pub(crate) const BALL_DEVICE_MAX_M: &Metric = Metric::of(&METRICS, "ball_device_max_m");
pub(crate) const BALL_DEVICE_RMS_M: &Metric = Metric::of(&METRICS, "ball_device_rms_m");
pub(crate) const BALL_UPLOAD_BYTES: &Metric = Metric::of(&METRICS, "ball_upload_bytes");
pub(crate) const BALL_TERRAIN_MAX_M: &Metric = Metric::of(&METRICS, "ball_terrain_max_m");
pub(crate) const BALL_TERRAIN_P95_M: &Metric = Metric::of(&METRICS, "ball_terrain_p95_m");
pub(crate) const BALL_TERRAIN_BEYOND: &Metric = Metric::of(&METRICS, "ball_terrain_beyond");
pub(crate) const BALL_TERRAIN_UNEXPLAINED: &Metric =
    Metric::of(&METRICS, "ball_terrain_unexplained");
pub(crate) const BALL_TERRAIN_GUIDED_M: &Metric = Metric::of(&METRICS, "ball_terrain_guided_m");
pub(crate) const BALL_TERRAIN_STEP_M: &Metric = Metric::of(&METRICS, "ball_terrain_step_m");
pub(crate) const BALL_MISMATCHED_PX: &Metric = Metric::of(&METRICS, "ball_mismatched_px");
pub(crate) const BALL_DIFFERING_PX: &Metric = Metric::of(&METRICS, "ball_differing_px");
pub(crate) const BALL_DRAWS: &Metric = Metric::of(&METRICS, "ball_draws");
pub(crate) const BALL_DRAW_GPU_US: &Metric = Metric::of(&METRICS, "ball_draw_gpu_us");
