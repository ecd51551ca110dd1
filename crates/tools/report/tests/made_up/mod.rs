// SPDX-License-Identifier: MIT OR Apache-2.0
//! Samples of a run that never was.

use terrafill_results::legacy::{CaseKey, Sample};

/// One frame for each of `times`, milliseconds, by the clocks that every device has.
pub(crate) fn samples(key: &CaseKey, times: &[f64]) -> Vec<Sample> {
    let frames = times.iter().zip(0..);
    frames
        .map(|(&time, frame)| Sample {
            scene: key.scene.clone(),
            view: key.view.clone(),
            backend: key.backend.clone(),
            variant: key.variant.clone(),
            frame,
            surface_gpu_ms: None,
            stencil_gpu_ms: None,
            colour_gpu_ms: None,
            fill_gpu_ms: None,
            fill_cpu_ms: time,
            fill_wall_ms: time,
        })
        .collect()
}
