// SPDX-License-Identifier: MIT OR Apache-2.0
//! A copy of the depth that the surface left: what a fill pays where depth cannot be read while it is
//! attached. Nothing reads it.

use crate::Gpu;
use crate::fixtures::{DEPTH_READ_ONLY, DEPTH_STENCIL_FORMAT};
use crate::memory::Image;
use crate::readback::{DEPTH_AND_STENCIL, change_layout};
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
    extent: vk::Extent2D,
    depth: Arc<Image>,
}

impl DepthCopy {
    pub(crate) fn new(gpu: &Arc<Gpu>, targets: &Targets) -> Result<Self, DeviceError> {
        let extent = targets.area().extent;
        let image = Image::target(
            gpu,
            "copy of depth",
            extent,
            DEPTH_STENCIL_FORMAT,
            vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST,
            DEPTH_AND_STENCIL,
        )?;
        let copy = Self {
            gpu: Arc::clone(gpu),
            image,
            extent,
            depth: Arc::clone(targets.depth_stencil()),
        };
        gpu.work.count_texture(copy.bytes());
        Ok(copy)
    }

    /// Bytes of its texels; the stencil comes with the depth.
    pub(crate) fn bytes(&self) -> u64 {
        DEPTH_STENCIL_BYTES * u64::from(self.extent.width) * u64::from(self.extent.height)
    }

    /// Whether it is for the depth of these targets.
    pub(crate) fn is_of(&self, targets: &Targets) -> bool {
        Arc::ptr_eq(&self.depth, targets.depth_stencil())
    }

    /// Records the copy.
    ///
    /// # Safety
    /// Recording is under way, outside of a pass; depth is in the layout that passes leave, and both
    /// images live until the submission is done.
    pub(crate) unsafe fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.gpu.device;
        let (from, to) = (self.depth.raw, self.image.raw);
        let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let target = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let all = vk::ImageSubresourceLayers::default()
            .aspect_mask(DEPTH_AND_STENCIL)
            .layer_count(1);
        let region = vk::ImageCopy::default()
            .src_subresource(all)
            .dst_subresource(all)
            .extent(self.extent.into());
        let unknown = vk::ImageLayout::UNDEFINED;
        // SAFETY: the caller's promise; what the copy held before is not needed.
        unsafe {
            let change = |image, from, to| {
                change_layout(device, commands, image, DEPTH_AND_STENCIL, from, to);
            };
            change(from, DEPTH_READ_ONLY, source);
            change(to, unknown, target);
            device.cmd_copy_image(commands, from, source, to, target, &[region]);
            change(from, source, DEPTH_READ_ONLY);
        }
    }
}
