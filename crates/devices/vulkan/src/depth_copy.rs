// SPDX-License-Identifier: MIT OR Apache-2.0
//! A copy of the depth that the surface left: what a fill pays where depth cannot be read while it is
//! attached. Nothing reads it.

use crate::Gpu;
use crate::fixtures::{DEPTH_READ_ONLY, DEPTH_STENCIL_FORMAT};
use crate::image::Image;
use crate::targets::Targets;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_stencil::DEPTH_STENCIL_BYTES;

/// Room for the copy, as large as the targets.
#[derive(Debug)]
pub struct DepthCopy {
    gpu: Arc<Gpu>,
    image: Image,
    pub(crate) depth: Arc<Image>,
}

impl DepthCopy {
    pub(crate) fn new(gpu: &Arc<Gpu>, targets: &Targets) -> Result<Self, DeviceError> {
        let image = Image::target(
            gpu,
            "copy of depth",
            targets.area().extent,
            DEPTH_STENCIL_FORMAT,
            vk::ImageUsageFlags::TRANSFER_DST,
        )?;
        let copy = Self {
            gpu: Arc::clone(gpu),
            image,
            depth: Arc::clone(&targets.depth_stencil),
        };
        gpu.work.count_texture(copy.bytes());
        Ok(copy)
    }

    /// Bytes of its texels; the stencil comes with the depth.
    pub(crate) fn bytes(&self) -> u64 {
        self.image.bytes(DEPTH_STENCIL_BYTES)
    }

    /// Records the copy.
    ///
    /// # Safety
    /// Recording is under way, outside of a pass; depth is in the layout that passes leave, and both
    /// images live until the submission is done.
    pub(crate) unsafe fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.gpu.device;
        let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let target = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let all = vk::ImageSubresourceLayers::default()
            .aspect_mask(self.image.kind.aspects)
            .layer_count(1);
        let region = vk::ImageCopy::default()
            .src_subresource(all)
            .dst_subresource(all)
            .extent(self.image.kind.extent.into());
        let unknown = vk::ImageLayout::UNDEFINED;
        let (from, to) = (&self.depth, &self.image);
        // SAFETY: the caller's promise; what the copy held before is not needed.
        unsafe {
            from.change_layout(device, commands, DEPTH_READ_ONLY, source);
            to.change_layout(device, commands, unknown, target);
            device.cmd_copy_image(commands, from.raw, source, to.raw, target, &[region]);
            from.change_layout(device, commands, source, DEPTH_READ_ONLY);
        }
    }
}
