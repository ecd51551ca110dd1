// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics by which they are written and read.

use crate::metrics::METRICS;

terrafill_results::conditions! {
    shared PART;
    ANCHOR = "anchor";
    CONDITION = "condition";
    DEPTH_FORMAT = "depth_format";
    DISTANCE_M = "distance_m";
    EXTENT_DEG = "extent_deg";
    FAMILY = "family";
    HIGHEST_M = "highest_m";
    KNOB = "knob";
    LATITUDE_DEG = "latitude_deg";
    LOWEST_M = "lowest_m";
    OF_PART = "of_part";
    ROUTE = "route";
}

terrafill_results::metrics! {
    METRICS;
    POINTS = "points"; NON_FINITE_EMULATED = "non_finite_emulated"; NON_FINITE_DEVICE = "non_finite_device";
    EMULATED_MAX_M = "emulated_max_m"; EMULATED_RMS_M = "emulated_rms_m";
    DEVICE_MAX_M = "device_max_m"; DEVICE_RMS_M = "device_rms_m";
    DEVICE_MAX_RAD = "device_max_rad"; DEVICE_RMS_RAD = "device_rms_rad";
    TEXTURE_PX = "texture_px"; MAX_TEXELS = "max_texels"; RMS_TEXELS = "rms_texels";
    PIXEL_M = "pixel_m"; MAX_PX = "max_px"; RMS_PX = "rms_px";
    RESIDUAL_MAX_M = "residual_max_m"; RESIDUAL_RMS_M = "residual_rms_m";
    RESIDUAL_MAX_RAD = "residual_max_rad"; RESIDUAL_RMS_RAD = "residual_rms_rad";
    EXPECTED_MAX_RAD = "expected_max_rad"; MAX_OVER_RESIDUAL = "max_over_residual";
    RMS_OVER_RESIDUAL = "rms_over_residual"; MEASURED_OVER_EXPECTED = "measured_over_expected";
    ADD_MUL_FMA = "add_mul_fma"; DIVISIONS = "divisions"; COMPARES_SELECTS = "compares_selects";
    SQRT = "sqrt"; TRANSCENDENTAL = "transcendental"; TEXTURE_FETCHES = "texture_fetches";
    OPERATIONS_COST = "operations_cost"; CHOSEN = "chosen";
    CPU_NS = "cpu_ns"; GPU_NS = "gpu_ns";
}
