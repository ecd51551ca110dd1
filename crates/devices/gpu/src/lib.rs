// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every wgpu backend stands on. The device, the targets and the surface pass that fills them;
//! fills by volumes with all but the volumes themselves. GPU clocks, read-back, and the two
//! full-screen passes that fills are measured against.

mod adapter;
mod attachments;
mod baseline;
mod bindings;
#[cfg(test)]
mod constants;
mod covers;
mod deliberate_error;
mod direct;
mod evaluate;
mod fill;
mod held_buffer;
mod loaded;
mod mesh;
mod overlay;
mod picture;
mod queries;
mod ray_cast;
mod readback;
mod render_pipeline;
mod route_table;
mod shared;
mod statistics;
mod surface;
mod targets;
mod textured;
mod timing;
mod validation;
mod volume_pass;
mod volume_pipeline;
mod work;

pub use terrafill_contract::{
    CpuStopwatch, DeviceOptions as GpuOptions, POSITIVE_CONTROL, ValidationMessage, WorkDone,
};
pub use terrafill_shaders::source_hash as shader_source_hash;
pub use terrafill_stencil::{RouteTexelFormat, RouteTexels};

pub use adapter::{DeviceFacts, Features, Gpu, list_adapters, open_for_test};
pub use attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, attached, read_only_depth};
pub use baseline::{Baseline, BaselineKind};
pub use deliberate_error::make_deliberate_error;
pub use direct::{DirectFrame, DirectPipeline};
pub use evaluate::{
    EVALUATIONS_PER_DISPATCH, EvaluateError, Evaluation, EvaluationTime, Evaluator, Kernel,
};
pub use fill::{VolumeFill, WgpuVolumes};
pub use held_buffer::HeldBuffer;
pub use overlay::{Overlay, OverlayBackend};
pub use ray_cast::RayCast;
pub use readback::{read_buffer, read_texture};
pub use render_pipeline::{described, tested, vertex_layout};
pub use shared::{API, SURFACES, shared_gpu, shared_targets};
pub use targets::{RenderTargets, SharedTargets};
pub use textured::{BoundCover, Probe, TexturedFill};
pub use timing::{PassTimer, Stamps, TimedPass};
pub use validation::validation_log;
pub use volume_pass::{VolumePass, index_format};
pub use volume_pipeline::{HandedOn, VolumeShader};
