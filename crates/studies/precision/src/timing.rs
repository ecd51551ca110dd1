// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times of formulas beyond the loop around them.

use crate::failure::broken;
use terrafill_gpu::Evaluator;
use terrafill_results::median;
use terrafill_study::StudyError;

/// Passes of the empty formula per round: every other time is held against their median.
const EMPTY_PASSES: usize = 3;

/// What the loop alone took in a round.
pub(crate) struct LoopTime {
    pub(crate) cpu_ms: f64,
    pub(crate) gpu_ms: Option<f64>,
}

impl LoopTime {
    pub(crate) fn of_empty(empty: &Evaluator, turns: u32) -> Result<Self, StudyError> {
        let mut cpu_ms = Vec::new();
        let mut gpu_ms = Vec::new();
        for _ in 0..EMPTY_PASSES {
            let time = empty.time(turns).map_err(broken)?;
            cpu_ms.push(time.cpu_ms);
            gpu_ms.extend(time.gpu_ms);
        }
        Ok(Self {
            cpu_ms: median(&cpu_ms).unwrap_or(f64::NAN),
            gpu_ms: median(&gpu_ms),
        })
    }
}
