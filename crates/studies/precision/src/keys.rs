// SPDX-License-Identifier: MIT OR Apache-2.0
//! Metrics as the study's chapter reads them.

use crate::row::METRICS;
use terrafill_results::Metric;

pub(crate) const POINTS: &Metric = Metric::of(&METRICS, "points");
pub(crate) const NON_FINITE_EMULATED: &Metric = Metric::of(&METRICS, "non_finite_emulated");
pub(crate) const NON_FINITE_DEVICE: &Metric = Metric::of(&METRICS, "non_finite_device");
pub(crate) const EMULATED_MAX_M: &Metric = Metric::of(&METRICS, "emulated_max_m");
pub(crate) const DEVICE_MAX_M: &Metric = Metric::of(&METRICS, "device_max_m");
pub(crate) const DEVICE_RMS_M: &Metric = Metric::of(&METRICS, "device_rms_m");
pub(crate) const TEXTURE_PX: &Metric = Metric::of(&METRICS, "texture_px");
pub(crate) const MAX_TEXELS: &Metric = Metric::of(&METRICS, "max_texels");
pub(crate) const RMS_TEXELS: &Metric = Metric::of(&METRICS, "rms_texels");
pub(crate) const PIXEL_M: &Metric = Metric::of(&METRICS, "pixel_m");
pub(crate) const MAX_PX: &Metric = Metric::of(&METRICS, "max_px");
pub(crate) const MAX_OVER_RESIDUAL: &Metric = Metric::of(&METRICS, "max_over_residual");
pub(crate) const RMS_OVER_RESIDUAL: &Metric = Metric::of(&METRICS, "rms_over_residual");
pub(crate) const MEASURED_OVER_EXPECTED: &Metric = Metric::of(&METRICS, "measured_over_expected");
pub(crate) const OPERATIONS_COST: &Metric = Metric::of(&METRICS, "operations_cost");
pub(crate) const CHOSEN: &Metric = Metric::of(&METRICS, "chosen");
pub(crate) const CPU_NS: &Metric = Metric::of(&METRICS, "cpu_ns");
pub(crate) const GPU_NS: &Metric = Metric::of(&METRICS, "gpu_ns");
