// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every wgpu backend stands on: the device, the targets and the surface pass that fills them,
//! GPU and CPU clocks, read-back, and the two full-screen passes that fills are measured against.

mod adapter;
mod baseline;
mod clock;
#[cfg(test)]
mod constants;
mod evaluate;
mod readback;
mod stage;
mod timing;
mod validation;
mod work;

pub use terrafill_shaders::source_hash as shader_source_hash;

pub use adapter::{DeviceFacts, Gpu, GpuOptions, list_adapters, open_for_test};
pub use baseline::{Baseline, BaselineKind};
pub use clock::CpuStopwatch;
pub use evaluate::{
    EVALUATIONS_PER_DISPATCH, EvaluateError, Evaluation, EvaluationTime, Evaluator, Kernel,
    KernelTable, TableFormat,
};
pub use readback::read_buffer;
pub use stage::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, SharedStage, Stage};
pub use timing::{PassTimer, Stamps, TimedPass};
pub use validation::{POSITIVE_CONTROL, ValidationMessage, make_deliberate_error, messages};
pub use work::WorkDone;
