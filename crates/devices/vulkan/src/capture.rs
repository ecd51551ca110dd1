// SPDX-License-Identifier: MIT OR Apache-2.0
//! Steps from one state buffer to another without a picture: by compute, or by vertices whose outputs
//! transform feedback keeps, the rest of the pipeline discarded.

use crate::memory::barrier;
use crate::owned::Owned;
use crate::pipeline::{OwnedPipeline, ShaderStage, graphics};
use crate::queries::{Queries, QueryKind, Span};
use crate::readback::let_host_read;
use crate::shader_modules::ModuleKey;
use crate::targets::framebuffer;
use crate::{Buffer, BufferUse, ComputePipeline, Gpu, Resources};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// What is not drawn into.
const ONE_PIXEL: vk::Extent2D = vk::Extent2D {
    width: 1,
    height: 1,
};

/// A compiled vertex shader whose outputs are kept.
#[derive(Debug)]
pub struct CapturePipeline {
    pipeline: OwnedPipeline,
    framebuffer: Owned<vk::Framebuffer>,
    /// Without attachments: feedback takes place inside a pass.
    pass: Owned<vk::RenderPass>,
    resources: Arc<Resources>,
}

impl CapturePipeline {
    /// Makes a pipeline.
    ///
    /// - `vertex`: SPIR-V that was compiled beforehand, by its name
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] without transform feedback or for resources of another device,
    /// [`DeviceError::Shader`], [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        resources: &Arc<Resources>,
        vertex: &'static str,
    ) -> Result<Self, DeviceError> {
        gpu.require(gpu.feedback.is_some(), "VK_EXT_transform_feedback")?;
        gpu.require(resources.is_on(gpu), "resources of another device")?;
        let subpasses =
            [vk::SubpassDescription::default()
                .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)];
        let info = vk::RenderPassCreateInfo::default().subpasses(&subpasses);
        // SAFETY: the structures live through the call.
        let pass = unsafe {
            let made = gpu.device.create_render_pass(&info, None);
            Owned::new(gpu, "transform feedback", made)
        }?;
        // SAFETY: the pass has no attachments.
        let framebuffer = unsafe { framebuffer(gpu, pass.raw, &[], ONE_PIXEL, 1) }?;
        let key = ModuleKey::Compiled(vertex);
        let stage = ShaderStage::new(gpu, vk::ShaderStageFlags::VERTEX, key, "main")?;
        let stages = [stage.info()];
        let input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::POINT_LIST);
        let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
            .rasterizer_discard_enable(true)
            .line_width(1.0);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&input)
            .input_assembly_state(&assembly)
            .rasterization_state(&rasterization)
            .layout(resources.layout())
            .render_pass(pass.raw);
        Ok(Self {
            // SAFETY: the structures live through the call; spirv-val has judged the shader.
            pipeline: unsafe { graphics(gpu, &info) }?,
            framebuffer,
            pass,
            resources: Arc::clone(resources),
        })
    }
}

/// Workgroups of a compute shader, whose results what comes after sees.
#[derive(Debug, Clone, Copy)]
pub struct Dispatch<'a> {
    /// Shader and its resources.
    pub pipeline: &'a ComputePipeline,
    /// Workgroups.
    pub groups: [u32; 3],
}

/// One step.
#[derive(Debug, Clone, Copy)]
pub enum StateStep<'a> {
    /// By compute.
    Dispatch(Dispatch<'a>),
    /// By vertices.
    Capture {
        /// Shader and what it reads.
        pipeline: &'a CapturePipeline,
        /// Where its outputs go, a [`BufferUse::State`]; what does not fit is not written.
        into: &'a Buffer,
        /// How many.
        vertices: u32,
    },
}

impl StateStep<'_> {
    /// Whether all of it is of this device and for this use.
    pub(crate) fn fits(&self, gpu: &Arc<Gpu>) -> bool {
        match self {
            Self::Dispatch(dispatch) => dispatch.pipeline.owned.is_on(gpu),
            Self::Capture { pipeline, into, .. } => {
                pipeline.pipeline.is_on(gpu) && into.is_for(gpu, BufferUse::State)
            }
        }
    }
}

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// GPU time of all steps, milliseconds; absent where the device keeps no time.
    pub gpu_ms: Option<f64>,
}

/// Takes steps one after the other, each of which sees what the one before wrote, and waits.
///
/// # Errors
/// [`DeviceError::Unsupported`] for what is of another device or a buffer for another use,
/// [`DeviceError::DeviceLost`].
pub fn advance(gpu: &Arc<Gpu>, steps: &[StateStep<'_>]) -> Result<StepReport, DeviceError> {
    let what = "stepping what is of another device or made for another use";
    gpu.require(steps.iter().all(|step| step.fits(gpu)), what)?;
    let stamps = Queries::new(gpu, QueryKind::Timestamps, 2)?;
    let span = Span::new(stamps.as_ref(), 0);
    // SAFETY: everything is of this device and lives until the submission is done.
    unsafe {
        gpu.submit(|device, commands| {
            span.begin(commands);
            for step in steps {
                record_step(gpu, commands, step);
                let_all_see(device, commands);
            }
            span.end(commands);
        })?;
    }
    Ok(StepReport { gpu_ms: span.ms()? })
}

impl Buffer {
    /// Contents of a [`BufferUse::State`] or of [`BufferUse::Arguments`].
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for another use, [`DeviceError::OutOfMemory`],
    /// [`DeviceError::DeviceLost`].
    pub fn contents(&self, gpu: &Arc<Gpu>) -> Result<Vec<u8>, DeviceError> {
        let mut readable = [BufferUse::State, BufferUse::Arguments].into_iter();
        let is_readable = readable.any(|of| self.is_for(gpu, of));
        let what = "reading back a buffer that is neither state nor arguments";
        gpu.require(is_readable, what)?;
        let copy = Self::for_reading(gpu, "state read-back", self.size())?;
        let region = [vk::BufferCopy::default().size(self.size())];
        // SAFETY: both have this size and live until the submission is done.
        unsafe {
            gpu.submit(|device, commands| {
                device.cmd_copy_buffer(commands, self.raw, copy.raw, &region);
                let_host_read(device, commands);
            })?;
        }
        copy.read()
    }
}

/// Records a step. What a dispatch wrote is seen by whatever follows, what was captured after [`let_all_see`].
///
/// # Safety
/// Recording is under way, outside of a pass, on the device of all of the step.
pub(crate) unsafe fn record_step(gpu: &Gpu, commands: vk::CommandBuffer, step: &StateStep<'_>) {
    // SAFETY: the caller's promise.
    unsafe {
        match *step {
            StateStep::Dispatch(dispatch) => record_dispatch(&gpu.device, commands, dispatch),
            StateStep::Capture {
                pipeline,
                into,
                vertices,
            } => record_capture(gpu, commands, pipeline, into, vertices),
        }
    }
}

/// # Safety
/// Recording is under way, outside of a pass, on the device of the dispatch.
unsafe fn record_dispatch(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    Dispatch { pipeline, groups }: Dispatch<'_>,
) {
    let compute = vk::PipelineBindPoint::COMPUTE;
    let written = (
        vk::PipelineStageFlags::COMPUTE_SHADER,
        vk::AccessFlags::SHADER_WRITE,
    );
    let readers = (
        vk::PipelineStageFlags::ALL_GRAPHICS
            | vk::PipelineStageFlags::COMPUTE_SHADER
            | vk::PipelineStageFlags::DRAW_INDIRECT,
        vk::AccessFlags::SHADER_READ
            | vk::AccessFlags::SHADER_WRITE
            | vk::AccessFlags::INDIRECT_COMMAND_READ,
    );
    // SAFETY: the caller's promise.
    unsafe {
        device.cmd_bind_pipeline(commands, compute, pipeline.owned.raw);
        pipeline.resources.bind(commands, compute);
        let [x, y, z] = groups;
        device.cmd_dispatch(commands, x, y, z);
        barrier(device, commands, written, readers);
    }
}

/// # Safety
/// Recording is under way, outside of a pass, on the device of all that is given.
unsafe fn record_capture(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    pipeline: &CapturePipeline,
    into: &Buffer,
    vertices: u32,
) {
    // A pipeline could not be made without it.
    let Some(feedback) = &gpu.feedback else {
        return;
    };
    let device = &gpu.device;
    let graphics = vk::PipelineBindPoint::GRAPHICS;
    let begin = vk::RenderPassBeginInfo::default()
        .render_pass(pipeline.pass.raw)
        .framebuffer(pipeline.framebuffer.raw)
        .render_area(ONE_PIXEL.into());
    // SAFETY: the caller's promise.
    unsafe {
        device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
        device.cmd_bind_pipeline(commands, graphics, pipeline.pipeline.raw);
        pipeline.resources.bind(commands, graphics);
        let (buffers, offsets, sizes) = ([into.raw], [0], [into.size()]);
        let bind = feedback.fp().cmd_bind_transform_feedback_buffers_ext;
        bind(
            commands,
            0,
            1,
            buffers.as_ptr(),
            offsets.as_ptr(),
            sizes.as_ptr(),
        );
        let none = std::ptr::null();
        let begin = feedback.fp().cmd_begin_transform_feedback_ext;
        begin(commands, 0, 0, std::ptr::null(), none);
        device.cmd_draw(commands, vertices, 1, 0, 0);
        let end = feedback.fp().cmd_end_transform_feedback_ext;
        end(commands, 0, 0, std::ptr::null(), none);
        device.cmd_end_render_pass(commands);
    }
}

/// # Safety
/// Recording is under way, outside of a pass.
pub(crate) unsafe fn let_all_see(device: &ash::Device, commands: vk::CommandBuffer) {
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    let any = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    let written = (all, vk::AccessFlags::MEMORY_WRITE);
    // SAFETY: the caller's promise.
    unsafe { barrier(device, commands, written, (all, any)) };
}
