// SPDX-License-Identifier: MIT OR Apache-2.0
//! Depth maps in the layers of one image. They are drawn one after the other, all at once by a stage that chooses
//! the layer, or some at once as views of one draw.

use crate::failure::failure;
use crate::memory::{Image, ImageKind, ImageShape};
use crate::readback::let_host_read;
use crate::targets::Framebuffer;
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const FORMAT: vk::Format = vk::Format::D32_SFLOAT;
const ASPECT: vk::ImageAspectFlags = vk::ImageAspectFlags::DEPTH;
/// In which maps are left, for shaders.
const READABLE: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

/// How all layers are reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayersBy {
    /// A pass each.
    Passes,
    /// One pass, in which a stage chooses the layer.
    Stage,
    /// As many layers a pass as the device has views, all passes alike.
    Views,
}

/// A pass over some layers.
#[derive(Debug)]
pub(crate) struct LayerPass {
    view: vk::ImageView,
    pub(crate) framebuffer: Framebuffer,
    pub(crate) first: u32,
}

/// Square depth maps, cleared to 0 before each draw, of which the greatest depth stays.
#[derive(Debug)]
pub struct LayeredDepth {
    pub(crate) gpu: Arc<Gpu>,
    image: Image,
    pub(crate) side: u32,
    layers: u32,
    pub(crate) by: LayersBy,
    /// Layers that a pass draws into as views.
    pub(crate) views: u32,
    pub(crate) render_pass: vk::RenderPass,
    pub(crate) passes: Vec<LayerPass>,
}

impl LayeredDepth {
    /// Makes the maps.
    ///
    /// - `side`: texels
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] without multiview where it is asked for, [`DeviceError::OverCapacity`],
    /// [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        side: u32,
        layers: u32,
        by: LayersBy,
    ) -> Result<Arc<Self>, DeviceError> {
        let limits = &gpu.limits;
        let largest = limits
            .max_image_dimension2_d
            .min(limits.max_framebuffer_width);
        let most = limits
            .max_image_array_layers
            .min(limits.max_framebuffer_layers);
        for (what, found, allowed) in [
            ("texels along a side of a map", side, largest),
            ("layers of a map", layers, most),
        ] {
            if found > allowed || found == 0 {
                return Err(DeviceError::OverCapacity {
                    what: what.to_owned(),
                    found: found.into(),
                    allowed: allowed.into(),
                });
            }
        }
        let most_views = gpu.facts.features.max_views;
        if by == LayersBy::Views && most_views == 0 {
            return Err(DeviceError::unsupported("multiview", &gpu.facts.name));
        }
        let views = match by {
            LayersBy::Views => largest_divisor(layers, most_views),
            LayersBy::Passes | LayersBy::Stage => 1,
        };
        let kind = ImageKind {
            extent: vk::Extent2D {
                width: side,
                height: side,
            },
            format: FORMAT,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
                | vk::ImageUsageFlags::SAMPLED
                | vk::ImageUsageFlags::TRANSFER_SRC,
            aspects: ASPECT,
            levels: 1,
            shape: ImageShape::Array(layers),
        };
        let mut made = Self {
            gpu: Arc::clone(gpu),
            image: Image::new(gpu, "depth maps", &kind)?,
            side,
            layers,
            by,
            views,
            render_pass: vk::RenderPass::null(),
            passes: Vec::new(),
        };
        gpu.work.count_texture(made.bytes());
        let broken = |error| failure(error, "passes of depth maps", 0);
        made.render_pass = render_pass(&gpu.device, by, views).map_err(broken)?;
        let (step, framebuffer_layers) = match by {
            LayersBy::Passes | LayersBy::Views => (views, 1),
            LayersBy::Stage => (layers, layers),
        };
        for first in (0..layers).step_by(step as usize) {
            made.push_pass(first, step, framebuffer_layers)?;
        }
        Ok(Arc::new(made))
    }

    fn push_pass(&mut self, first: u32, count: u32, layers: u32) -> Result<(), DeviceError> {
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(ASPECT)
            .level_count(1)
            .base_array_layer(first)
            .layer_count(count);
        let view = vk::ImageViewCreateInfo::default()
            .image(self.image.raw)
            .view_type(vk::ImageViewType::TYPE_2D_ARRAY)
            .format(FORMAT)
            .subresource_range(range);
        // SAFETY: the structure lives through the call, and the layers are the image's.
        let view = unsafe { self.gpu.device.create_image_view(&view, None) }
            .map_err(|error| failure(error, "view of depth maps", 0))?;
        let extent = vk::Extent2D {
            width: self.side,
            height: self.side,
        };
        // SAFETY: the view has these layers and this size, in the pass's format.
        let framebuffer =
            unsafe { Framebuffer::new(&self.gpu, self.render_pass, &[view], extent, layers) };
        // A view without a framebuffer is destroyed here, another one with the maps.
        let framebuffer = framebuffer.inspect_err(|_| {
            // SAFETY: nothing uses it.
            unsafe { self.gpu.device.destroy_image_view(view, None) };
        })?;
        self.passes.push(LayerPass {
            view,
            framebuffer,
            first,
        });
        Ok(())
    }

    /// Passes of a frame.
    #[must_use]
    pub fn passes(&self) -> usize {
        self.passes.len()
    }

    /// Bytes of all maps.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        4 * u64::from(self.side).pow(2) * u64::from(self.layers)
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.image.view
    }

    /// Depths of all layers, one after the other, row by row.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`], [`DeviceError::DeviceLost`].
    pub fn read(&self) -> Result<Vec<f32>, DeviceError> {
        let copy = Buffer::for_reading(&self.gpu, "depth maps", self.bytes())?;
        let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(ASPECT)
            .level_count(1)
            .layer_count(self.layers);
        let barrier = |old_layout, new_layout| {
            [vk::ImageMemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
                .dst_access_mask(vk::AccessFlags::MEMORY_READ)
                .old_layout(old_layout)
                .new_layout(new_layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(self.image.raw)
                .subresource_range(range)]
        };
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: ASPECT,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: self.layers,
            })
            .image_extent(vk::Extent3D {
                width: self.side,
                height: self.side,
                depth: 1,
            })];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        let (before, after) = (barrier(READABLE, from), barrier(from, READABLE));
        // SAFETY: the buffer has room for all layers, and both live until the submission is done.
        unsafe {
            self.gpu.submit(|device, commands| {
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &before);
                device.cmd_copy_image_to_buffer(commands, self.image.raw, from, copy.raw, &region);
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &after);
                let_host_read(device, commands);
            })?;
        }
        let bytes = copy.read()?;
        let (depths, _) = bytes.as_chunks::<4>();
        Ok(depths.iter().map(|of| f32::from_ne_bytes(*of)).collect())
    }
}

impl Drop for LayeredDepth {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: every submission that used them has been waited for; null is ignored.
        unsafe {
            for pass in &self.passes {
                device.destroy_image_view(pass.view, None);
            }
            device.destroy_render_pass(self.render_pass, None);
        }
    }
}

/// Largest divisor of a number that is at most so much.
fn largest_divisor(number: u32, most: u32) -> u32 {
    let divisors = (1..=most.min(number)).rev();
    let mut divisors = divisors.filter(|divisor| number.is_multiple_of(*divisor));
    divisors.next().unwrap_or(1)
}

fn render_pass(
    device: &ash::Device,
    by: LayersBy,
    views: u32,
) -> Result<vk::RenderPass, vk::Result> {
    let attachments = [vk::AttachmentDescription::default()
        .format(FORMAT)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(READABLE)];
    let attached = vk::AttachmentReference {
        attachment: 0,
        layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    };
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .depth_stencil_attachment(&attached)];
    let tests =
        vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let written = vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    // Whoever read the maps before is done, and whoever reads them next waits.
    let dependencies = [
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(vk::PipelineStageFlags::ALL_COMMANDS)
            .dst_stage_mask(tests)
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(written | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(tests)
            .dst_stage_mask(vk::PipelineStageFlags::ALL_COMMANDS)
            .src_access_mask(written)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ),
    ];
    let masks = [u32::MAX >> (32 - views.clamp(1, 32))];
    let mut multiview = vk::RenderPassMultiviewCreateInfo::default().view_masks(&masks);
    let mut info = vk::RenderPassCreateInfo::default()
        .attachments(&attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    if by == LayersBy::Views {
        info = info.push_next(&mut multiview);
    }
    // SAFETY: the structures live through the call.
    unsafe { device.create_render_pass(&info, None) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_views_are_alike() {
        assert_eq!(largest_divisor(16, 6), 4);
        assert_eq!(largest_divisor(4, 6), 4);
        assert_eq!(largest_divisor(12, 6), 6);
        assert_eq!(largest_divisor(7, 6), 1);
    }
}
