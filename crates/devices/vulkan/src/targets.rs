// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colour, depth, stencil and numbers as attachments, in the formats of the wgpu targets'.

use crate::Gpu;
use crate::failure::failure;
use crate::fixtures::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, NUMBER_FORMAT};
use crate::memory::Image;
use ash::vk;
use std::sync::Arc;
use terrafill_fill::{DeviceError, NUMBER_BYTES};
use terrafill_scene::ImageSize;

/// Colour, depth and stencil, as attachments.
#[derive(Debug)]
pub(crate) struct Targets {
    gpu: Arc<Gpu>,
    extent: vk::Extent2D,
    colour: Image,
    /// Shared with whoever reads its depth in shaders.
    depth_stencil: Arc<Image>,
    /// Depth and stencil only, with colour, and with colour for textured covers.
    framebuffers: [vk::Framebuffer; 3],
}

/// Target of accumulated numbers, and how shaders read it. Each fill that accumulates has its own.
#[derive(Debug)]
pub struct Numbers {
    gpu: Arc<Gpu>,
    _image: Image,
    depth: Arc<Image>,
    pub(crate) framebuffer: vk::Framebuffer,
    pool: vk::DescriptorPool,
    pub(crate) set: vk::DescriptorSet,
    bytes: u64,
}

impl Numbers {
    pub(crate) fn new(targets: &Targets) -> Result<Self, DeviceError> {
        let gpu = &targets.gpu;
        let image = Image::target(
            gpu,
            "accumulated numbers",
            targets.extent,
            NUMBER_FORMAT,
            vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            vk::ImageAspectFlags::COLOR,
        )?;
        let view = image.view;
        let mut numbers = Self {
            gpu: Arc::clone(gpu),
            _image: image,
            depth: Arc::clone(&targets.depth_stencil),
            framebuffer: vk::Framebuffer::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            bytes: NUMBER_BYTES
                * u64::from(targets.extent.width)
                * u64::from(targets.extent.height),
        };
        let views = [view, targets.depth_stencil.view];
        let framebuffer_info = vk::FramebufferCreateInfo::default()
            .render_pass(gpu.fixtures.numbers)
            .attachments(&views)
            .width(targets.extent.width)
            .height(targets.extent.height)
            .layers(1);
        let sizes = [vk::DescriptorPoolSize {
            ty: vk::DescriptorType::SAMPLED_IMAGE,
            descriptor_count: 1,
        }];
        let pool_info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(&sizes);
        let layouts = [gpu.fixtures.number_set_layout];
        let broken = |error| failure(error, "accumulated numbers", 0);
        // SAFETY: the views are of the pass's formats and of this size; the pool has room for one
        // set of this layout, which then points at an image that lives as long as the set.
        unsafe {
            numbers.framebuffer = gpu
                .device
                .create_framebuffer(&framebuffer_info, None)
                .map_err(broken)?;
            numbers.pool = gpu
                .device
                .create_descriptor_pool(&pool_info, None)
                .map_err(broken)?;
            let set_info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(numbers.pool)
                .set_layouts(&layouts);
            let sets = gpu
                .device
                .allocate_descriptor_sets(&set_info)
                .map_err(broken)?;
            numbers.set = sets.first().copied().unwrap_or_default();
            let images = [vk::DescriptorImageInfo {
                sampler: vk::Sampler::null(),
                image_view: view,
                image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            }];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(numbers.set)
                .dst_binding(0)
                .descriptor_type(vk::DescriptorType::SAMPLED_IMAGE)
                .image_info(&images);
            gpu.device.update_descriptor_sets(&[write], &[]);
        }
        gpu.work.count_texture(numbers.bytes);
        Ok(numbers)
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

impl Drop for Numbers {
    fn drop(&mut self) {
        // SAFETY: every submission that used them has been waited for; null is ignored.
        unsafe {
            self.gpu.device.destroy_framebuffer(self.framebuffer, None);
            self.gpu.device.destroy_descriptor_pool(self.pool, None);
        }
    }
}

impl Targets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let extent = vk::Extent2D {
            width: size.width,
            height: size.height,
        };
        let mut targets = Self {
            gpu: Arc::clone(gpu),
            extent,
            colour: Image::target(
                gpu,
                "colour",
                extent,
                COLOUR_FORMAT,
                vk::ImageUsageFlags::COLOR_ATTACHMENT,
                vk::ImageAspectFlags::COLOR,
            )?,
            depth_stencil: Arc::new(Image::target(
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
            )?),
            framebuffers: [vk::Framebuffer::null(); 3],
        };
        let views = [targets.colour.view, targets.depth_stencil.view];
        let fixtures = &gpu.fixtures;
        let passes = [
            (fixtures.fill(false, false), &views[1..]),
            (fixtures.fill(false, true), &views[..]),
            (fixtures.textured, &views[..]),
        ];
        for (framebuffer, (render_pass, views)) in targets.framebuffers.iter_mut().zip(passes) {
            let info = vk::FramebufferCreateInfo::default()
                .render_pass(render_pass)
                .attachments(views)
                .width(extent.width)
                .height(extent.height)
                .layers(1);
            // SAFETY: the views are of the pass's formats and of this size.
            *framebuffer = unsafe { gpu.device.create_framebuffer(&info, None) }
                .map_err(|error| failure(error, "framebuffer", 0))?;
        }
        Ok(targets)
    }

    pub(crate) fn framebuffer(&self, has_colour: bool) -> vk::Framebuffer {
        self.framebuffers[usize::from(has_colour)]
    }

    pub(crate) fn textured_framebuffer(&self) -> vk::Framebuffer {
        self.framebuffers[2]
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

impl Drop for Targets {
    fn drop(&mut self) {
        for framebuffer in self.framebuffers {
            // SAFETY: every submission that used it has been waited for; null is ignored.
            unsafe { self.gpu.device.destroy_framebuffer(framebuffer, None) };
        }
    }
}
