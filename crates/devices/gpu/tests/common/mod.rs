// SPDX-License-Identifier: MIT OR Apache-2.0
//! Formulas as the device evaluates them.

use std::sync::Arc;
use terrafill_gpu::{Evaluator, Gpu, Kernel};

/// What a kernel answers for these inputs under these constants.
pub(crate) fn evaluated(
    gpu: &Arc<Gpu>,
    kernel: &Kernel<'_>,
    constants: &[[f32; 4]],
    inputs: &[[f32; 3]],
) -> Vec<[f32; 4]> {
    let evaluator = Evaluator::new(gpu, kernel, constants.len()).expect("compiles");
    evaluator.set_constants(constants).expect("room");
    let inputs: Vec<[f32; 4]> = inputs.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
    evaluator.evaluate(&inputs).expect("runs").values
}
