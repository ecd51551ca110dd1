// SPDX-License-Identifier: MIT OR Apache-2.0
//! The same ground as `terrafill-gpu`, on Vulkan itself: the device, the targets and the surface
//! pass that fills them, fills by volumes with all but the volumes themselves, pipelines with
//! geometry shaders, queries, clocks and read-back.
//!
//! All `unsafe` of the project's own drawing is here, behind an interface that cannot be misused:
//!
//! - a submission borrows all it uses and is waited for before it returns, so nothing is destroyed
//!   under the device;
//! - every draw names its pipeline, bindings and buffers, and is refused where they do not fit;
//! - shaders come from `terrafill-shaders` only, which validates them;
//! - the device is opened with `robustBufferAccess`, so an index past its buffer reads a defined
//!   value.

#![allow(
    unsafe_code,
    reason = "Vulkan is an unsafe interface; this crate is what makes it a safe one"
)]
#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks)]

mod adapter;
mod bindings;
mod block_image;
mod capture;
mod covers;
mod deliberate_error;
mod depth_copy;
mod direct;
mod draw_pipeline;
mod failure;
mod features;
mod fill;
mod fixtures;
mod handle;
mod image;
mod image_array;
mod layer_pipeline;
mod layered;
mod memory;
mod owned;
mod pass;
mod pipeline;
mod queries;
mod readback;
mod render_targets;
mod resources;
mod sampled;
mod shader_modules;
mod shared;
mod surface;
mod targets;
mod textured;
mod textured_pipeline;
mod triangle_tree;
mod validation;
mod volume_pass;

pub use adapter::{DeviceFacts, Gpu, list_adapters, open_for_test};
pub use bindings::BindGroup;
pub use block_image::BlockImage;
pub use features::Features;
pub use terrafill_shaders::{HandsOn, RouteText, TexturedParts, TexturedPlacement};

pub use capture::{CapturePipeline, Dispatch, StateStep, StepReport, advance};
pub use deliberate_error::make_deliberate_error;
pub use depth_copy::DepthCopy;
pub use direct::{DirectDraw, DirectReport, DrawCall};
pub use draw_pipeline::{ComputePipeline, DrawPipeline, GeometryOutput, PrimitiveStages, Shader};
pub use fill::{VolumeFill, VulkanVolumes};
pub use image::ImageShape;
pub use layer_pipeline::LayerPipeline;
pub use layered::{LayerContents, LayeredDepth, LayersBy};
pub use memory::{Buffer, BufferUse};
pub use pass::{
    CoverState, DrawCommand, DrawState, FillRecorder, Geometry, IndexWidth, PassRecorder,
};
pub use pipeline::{
    Fragments, GeometryStage, Pipeline, PipelineDescriptor, PipelineState, Topology, VertexFormat,
};
pub use queries::PassStatistics;
pub use render_targets::{FillReport, Measured, RenderTargets, SharedTargets};
pub use resources::{Resource, Resources};
pub use sampled::{ImageBindings, SampledImage};
pub use shader_modules::VertexStage;
pub use shared::{API, SURFACES, shared_gpu, shared_targets};
pub use targets::Numbers;
pub use terrafill_contract::{DeviceOptions as GpuOptions, POSITIVE_CONTROL, ValidationMessage};
pub use textured_pipeline::{DepthBindings, Probe, TexturedDescriptor, TexturedPipeline};
pub use triangle_tree::TriangleTree;
pub use validation::validation_log;
pub use volume_pass::VolumePass;
