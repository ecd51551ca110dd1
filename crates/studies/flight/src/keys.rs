// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics as its chapter reads them.

use crate::metrics::METRICS;
use terrafill_results::Metric;

terrafill_results::conditions! {
    shared SCENE, TECHNIQUE, VARIANT;
    PIECES = "pieces";
}

pub(crate) const FLIGHT_FRAME_CPU_MS: &Metric = Metric::of(&METRICS, "flight_frame_cpu_ms");
pub(crate) const FLIGHT_WORST_FRAME_CPU_MS: &Metric =
    Metric::of(&METRICS, "flight_worst_frame_cpu_ms");
pub(crate) const FLIGHT_FRAME_WALL_MS: &Metric = Metric::of(&METRICS, "flight_frame_wall_ms");
pub(crate) const FLIGHT_WORST_FRAME_WALL_MS: &Metric =
    Metric::of(&METRICS, "flight_worst_frame_wall_ms");

/// Note with the path of a case's picture.
pub(crate) const IMAGE: &str = "image";
