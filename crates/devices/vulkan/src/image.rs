// SPDX-License-Identifier: MIT OR Apache-2.0
//! Images, each with memory of its own.

use crate::Gpu;
use crate::fixtures::DEPTH_STENCIL_FORMAT;
use crate::memory::{DEVICE, Memory};
use crate::owned::Owned;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// An image with a view of all of it.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) kind: ImageKind,
    pub(crate) raw: vk::Image,
    pub(crate) view: vk::ImageView,
    /// What these are: the view goes before the image, and that before its memory.
    owned: (Owned<vk::ImageView>, Owned<vk::Image>, Memory),
}

/// What an image is made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageKind {
    pub(crate) extent: vk::Extent2D,
    pub(crate) format: vk::Format,
    pub(crate) usage: vk::ImageUsageFlags,
    pub(crate) aspects: vk::ImageAspectFlags,
    pub(crate) levels: u32,
    pub(crate) shape: ImageShape,
}

/// What the layers of an image are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageShape {
    /// One flat picture.
    Flat,
    /// Six faces.
    Cube,
    /// Pictures, numbered.
    Array(u32),
    /// Slices of one volume.
    Volume(u32),
}

impl ImageKind {
    /// One flat picture of one level, in colour.
    pub(crate) fn flat(
        extent: vk::Extent2D,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Self {
        Self {
            extent,
            format,
            usage,
            aspects: vk::ImageAspectFlags::COLOR,
            levels: 1,
            shape: ImageShape::Flat,
        }
    }

    pub(crate) fn layers(&self) -> u32 {
        match self.shape {
            ImageShape::Flat | ImageShape::Volume(_) => 1,
            ImageShape::Cube => 6,
            ImageShape::Array(layers) => layers,
        }
    }

    pub(crate) fn depth(&self) -> u32 {
        match self.shape {
            ImageShape::Volume(slices) => slices,
            ImageShape::Flat | ImageShape::Cube | ImageShape::Array(_) => 1,
        }
    }

    /// All levels and layers.
    pub(crate) fn whole(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default()
            .aspect_mask(self.aspects)
            .level_count(self.levels)
            .layer_count(self.layers())
    }
}

impl Image {
    /// A target, which can be read back, and whatever `usage` says beside.
    pub(crate) fn target(
        gpu: &Arc<Gpu>,
        label: &str,
        extent: vk::Extent2D,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self, DeviceError> {
        let (aspects, attached) = match format {
            DEPTH_STENCIL_FORMAT => (
                vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL,
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            ),
            _ => (
                vk::ImageAspectFlags::COLOR,
                vk::ImageUsageFlags::COLOR_ATTACHMENT,
            ),
        };
        let usage = usage | attached | vk::ImageUsageFlags::TRANSFER_SRC;
        let kind = ImageKind {
            aspects,
            ..ImageKind::flat(extent, format, usage)
        };
        Self::new(gpu, label, &kind)
    }

    /// The extent is within the device's limits, and the format can be used so.
    pub(crate) fn new(gpu: &Arc<Gpu>, label: &str, kind: &ImageKind) -> Result<Self, DeviceError> {
        let info = vk::ImageCreateInfo::default()
            .flags(if kind.shape == ImageShape::Cube {
                vk::ImageCreateFlags::CUBE_COMPATIBLE
            } else {
                vk::ImageCreateFlags::empty()
            })
            .image_type(match kind.shape {
                ImageShape::Volume(_) => vk::ImageType::TYPE_3D,
                _ => vk::ImageType::TYPE_2D,
            })
            .format(kind.format)
            .extent(vk::Extent3D {
                width: kind.extent.width,
                height: kind.extent.height,
                depth: kind.depth(),
            })
            .mip_levels(kind.levels)
            .array_layers(kind.layers())
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(kind.usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: extent, format and usage are the device's (checked by whoever makes the image, or
        // when the device was chosen, or guaranteed); submissions that use the image are waited for.
        let owned = unsafe {
            let made = gpu.device.create_image(&info, None);
            Owned::new(gpu, label, made)
        }?;
        let raw = owned.raw;
        // SAFETY: the image is the device's.
        let needs = unsafe { gpu.device.get_image_memory_requirements(raw) };
        let memory = Memory::new(gpu, label, needs, DEVICE, false)?;
        let info = vk::ImageViewCreateInfo::default()
            .image(raw)
            .view_type(match kind.shape {
                ImageShape::Flat => vk::ImageViewType::TYPE_2D,
                ImageShape::Cube => vk::ImageViewType::CUBE,
                ImageShape::Array(_) => vk::ImageViewType::TYPE_2D_ARRAY,
                ImageShape::Volume(_) => vk::ImageViewType::TYPE_3D,
            })
            .format(kind.format)
            .subresource_range(kind.whole());
        // SAFETY: fresh memory of the type and size that the image asked for; the view is of
        // all of the image, in its own format.
        let view = unsafe {
            let bound = gpu.device.bind_image_memory(raw, memory.owned.raw, 0);
            let made = bound.and_then(|()| gpu.device.create_image_view(&info, None));
            Owned::sized(gpu, label, needs.size, made)
        }?;
        Ok(Self {
            kind: *kind,
            raw,
            view: view.raw,
            owned: (view, owned, memory),
        })
    }

    pub(crate) fn gpu(&self) -> &Arc<Gpu> {
        self.owned.0.gpu()
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        self.owned.0.is_on(gpu)
    }

    /// Bytes of all texels of all layers and slices, of the first level.
    pub(crate) fn bytes(&self, texel_bytes: u64) -> u64 {
        let [width, height] = [self.kind.extent.width, self.kind.extent.height].map(u64::from);
        width * height * u64::from(self.kind.layers() * self.kind.depth()) * texel_bytes
    }

    /// Changes the layout of all levels and layers. Everything waits for everything: fills are over by then, and
    /// a copy, which the study `readback` times, has nothing to run beside.
    ///
    /// # Safety
    /// Recording is under way on the image's device, outside of a pass; the image lives until the submission is done and
    /// is in layout `from`.
    pub(crate) unsafe fn change_layout(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        from: vk::ImageLayout,
        to: vk::ImageLayout,
    ) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.raw)
            .subresource_range(self.kind.whole())];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the caller's promise.
        unsafe { device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &barrier) };
    }
}
