// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colour, depth, stencil and numbers as attachments, in the formats of the wgpu targets'.

use crate::Gpu;
use crate::bindings::SetPool;
use crate::failure::failure;
use crate::fixtures::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, NUMBER_FORMAT};
use crate::memory::Image;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_scene::ImageSize;
use terrafill_stencil::NUMBER_BYTES;

/// Colour, depth and stencil, as attachments.
#[derive(Debug)]
pub(crate) struct Targets {
    gpu: Arc<Gpu>,
    extent: vk::Extent2D,
    colour: Image,
    /// Shared with whoever reads its depth in shaders.
    depth_stencil: Arc<Image>,
    /// Depth and stencil only, with colour, and with colour for textured covers.
    framebuffers: [Framebuffer; 3],
}

/// Views that a pass draws into, destroyed with it.
#[derive(Debug)]
pub(crate) struct Framebuffer {
    gpu: Arc<Gpu>,
    pub(crate) raw: vk::Framebuffer,
}

impl Framebuffer {
    /// # Safety
    /// The views are of the pass's formats, of this device, and have this size and as many layers.
    pub(crate) unsafe fn new(
        gpu: &Arc<Gpu>,
        render_pass: vk::RenderPass,
        views: &[vk::ImageView],
        extent: vk::Extent2D,
        layers: u32,
    ) -> Result<Self, DeviceError> {
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(render_pass)
            .attachments(views)
            .width(extent.width)
            .height(extent.height)
            .layers(layers);
        // SAFETY: the caller's promise.
        let raw = unsafe { gpu.device.create_framebuffer(&info, None) }
            .map_err(|error| failure(error, "framebuffer", 0))?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            raw,
        })
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        // SAFETY: every submission that used it has been waited for.
        unsafe { self.gpu.device.destroy_framebuffer(self.raw, None) };
    }
}

/// Target of accumulated numbers, and how shaders read it. Each fill that accumulates has its own.
#[derive(Debug)]
pub struct Numbers {
    framebuffer: Framebuffer,
    pool: SetPool,
    _image: Image,
    depth: Arc<Image>,
    bytes: u64,
}

impl Numbers {
    pub(crate) fn new(targets: &Targets) -> Result<Self, DeviceError> {
        let gpu = &targets.gpu;
        let extent = targets.extent;
        let image = Image::target(
            gpu,
            "accumulated numbers",
            extent,
            NUMBER_FORMAT,
            vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            vk::ImageAspectFlags::COLOR,
        )?;
        let kind = vk::DescriptorType::SAMPLED_IMAGE;
        let pool = SetPool::new(gpu, gpu.fixtures.number_set_layout, &[kind])?;
        let images = [vk::DescriptorImageInfo {
            sampler: vk::Sampler::null(),
            image_view: image.view,
            image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        }];
        let write = vk::WriteDescriptorSet::default()
            .dst_set(pool.set)
            .dst_binding(0)
            .descriptor_type(kind)
            .image_info(&images);
        // SAFETY: of the kind that the layout has; the image lives as long as the set.
        unsafe { gpu.device.update_descriptor_sets(&[write], &[]) };
        let views = [image.view, targets.depth_stencil.view];
        // SAFETY: the views are of the pass's formats and of this size.
        let framebuffer =
            unsafe { Framebuffer::new(gpu, gpu.fixtures.numbers, &views, extent, 1) }?;
        let bytes = NUMBER_BYTES * u64::from(extent.width) * u64::from(extent.height);
        gpu.work.count_texture(bytes);
        Ok(Self {
            framebuffer,
            pool,
            _image: image,
            depth: Arc::clone(&targets.depth_stencil),
            bytes,
        })
    }

    pub(crate) fn framebuffer(&self) -> vk::Framebuffer {
        self.framebuffer.raw
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.pool.set
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Whether it stands beside the depth of these targets.
    pub(crate) fn is_beside(&self, targets: &Targets) -> bool {
        Arc::ptr_eq(&self.depth, targets.depth_stencil())
    }
}

impl Targets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let extent = vk::Extent2D {
            width: size.width,
            height: size.height,
        };
        let colour = Image::target(
            gpu,
            "colour",
            extent,
            COLOUR_FORMAT,
            vk::ImageUsageFlags::COLOR_ATTACHMENT,
            vk::ImageAspectFlags::COLOR,
        )?;
        let depth_stencil = Image::target(
            gpu,
            "depth and stencil",
            extent,
            DEPTH_STENCIL_FORMAT,
            // As on wgpu, whether or not a fill reads depth: one surface serves all fills.
            if gpu.facts.features.samples_depth {
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED
            } else {
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            },
            vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL,
        )?;
        let views = [colour.view, depth_stencil.view];
        let framebuffer = |render_pass, views: &[vk::ImageView]| {
            // SAFETY: the views are of the pass's formats and of this size.
            unsafe { Framebuffer::new(gpu, render_pass, views, extent, 1) }
        };
        let fixtures = &gpu.fixtures;
        Ok(Self {
            gpu: Arc::clone(gpu),
            extent,
            framebuffers: [
                framebuffer(fixtures.fill(false, false), &views[1..])?,
                framebuffer(fixtures.fill(false, true), &views)?,
                framebuffer(fixtures.textured, &views)?,
            ],
            colour,
            depth_stencil: Arc::new(depth_stencil),
        })
    }

    pub(crate) fn framebuffer(&self, has_colour: bool) -> vk::Framebuffer {
        self.framebuffers[usize::from(has_colour)].raw
    }

    pub(crate) fn textured_framebuffer(&self) -> vk::Framebuffer {
        self.framebuffers[2].raw
    }

    pub(crate) fn area(&self) -> vk::Rect2D {
        self.extent.into()
    }

    pub(crate) fn colour(&self) -> vk::Image {
        self.colour.raw
    }

    pub(crate) fn depth_stencil(&self) -> &Arc<Image> {
        &self.depth_stencil
    }

    /// Of negative height: WGSL has y up, Vulkan down.
    #[allow(
        clippy::cast_precision_loss,
        reason = "images are far smaller than 2^24 pixels a side"
    )]
    pub(crate) fn viewport(&self) -> vk::Viewport {
        let (width, height) = (self.extent.width as f32, self.extent.height as f32);
        vk::Viewport {
            x: 0.0,
            y: height,
            width,
            height: -height,
            min_depth: 0.0,
            max_depth: 1.0,
        }
    }
}
