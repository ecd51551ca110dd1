// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces that are triangles, drawn through Vulkan by the same shader as through wgpu.

use crate::{
    Buffer, BufferUse, Gpu, ImageBindings, Pipeline, PipelineDescriptor, PipelineState,
    SampledImage, VertexFormat,
};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceDevice, SurfaceDraw, SurfaceLook};
use terrafill_scene::MipChain;

/// Set 0 holds the view's constants, set 1 a picture where there is one.
#[derive(Debug)]
pub(crate) struct VulkanSurface(pub(crate) Arc<Gpu>);

impl SurfaceDevice for VulkanSurface {
    type Buffer = Buffer;
    type Pipeline = Pipeline;
    type Picture = ImageBindings;

    fn pipeline(&self, look: SurfaceLook) -> Result<Pipeline, DeviceError> {
        let state = PipelineState::Surface(look);
        let descriptor = PipelineDescriptor::of_shader(look.shader(), VertexFormat::Metres, state);
        Pipeline::new(&self.0, descriptor)
    }

    fn picture(&self, picture: &MipChain) -> Result<ImageBindings, DeviceError> {
        let image = Arc::new(SampledImage::picture(&self.0, picture)?);
        ImageBindings::picture(&image, SurfaceLook::PICTURE_ADDRESS)
    }

    fn upload(&self, bytes: &[u8], are_indices: bool) -> Result<Buffer, DeviceError> {
        let (label, use_for) = if are_indices {
            ("surface indices", BufferUse::Index)
        } else {
            ("surface vertices", BufferUse::Vertex)
        };
        Buffer::upload(&self.0, label, bytes, use_for)
    }

    fn rewrite(&self, buffer: &Buffer, bytes: &[u8]) -> Result<(), DeviceError> {
        buffer.rewrite_parts(&[(0, bytes)])
    }
}

/// Records the draws of a surface.
///
/// # Safety
/// The surface's render pass is being recorded on the device of `gpu`. Viewport, scissor and the view's constants
/// are set. What is drawn is of this device and lives until the submission is done.
pub(crate) unsafe fn draw(
    gpu: &Gpu,
    commands: vk::CommandBuffer,
    surface: &SurfaceDraw<'_, VulkanSurface>,
) {
    let device = &gpu.device;
    let graphics = vk::PipelineBindPoint::GRAPHICS;
    // SAFETY: the caller's promise; pipeline, set and buffers were made for such a pass, and the indices are all
    // there.
    unsafe {
        device.cmd_bind_pipeline(commands, graphics, surface.pipeline.owned.raw);
        if let Some(bindings) = surface.picture {
            let (layout, sets) = (gpu.fixtures.picture_layout, [bindings.set.raw]);
            device.cmd_bind_descriptor_sets(commands, graphics, layout, 1, &sets, &[]);
        }
        device.cmd_bind_vertex_buffers(commands, 0, &[surface.vertices.raw], &[0]);
        let width = vk::IndexType::UINT32;
        device.cmd_bind_index_buffer(commands, surface.indices.raw, 0, width);
        for range in surface.ranges {
            let count = range.end - range.start;
            device.cmd_draw_indexed(commands, count, 1, range.start, 0, 0);
        }
    }
}
