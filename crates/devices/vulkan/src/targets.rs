// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colour, depth, stencil and numbers as attachments, in the formats of the wgpu targets'.

use crate::Gpu;
use crate::bindings::{Bound, Set};
use crate::fixtures::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, NUMBER_FORMAT};
use crate::image::Image;
use crate::owned::Owned;
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
    pub(crate) colour: Image,
    /// Shared with whoever reads its depth in shaders.
    pub(crate) depth_stencil: Arc<Image>,
    /// Depth and stencil only, with colour, and with colour for textured covers.
    framebuffers: [Owned<vk::Framebuffer>; 3],
}

/// Views that a pass draws into.
///
/// # Safety
/// The views are of the pass's formats, of this device, have this size and as many layers, and live as long.
pub(crate) unsafe fn framebuffer(
    gpu: &Arc<Gpu>,
    render_pass: vk::RenderPass,
    views: &[vk::ImageView],
    extent: vk::Extent2D,
    layers: u32,
) -> Result<Owned<vk::Framebuffer>, DeviceError> {
    let info = vk::FramebufferCreateInfo::default()
        .render_pass(render_pass)
        .attachments(views)
        .width(extent.width)
        .height(extent.height)
        .layers(layers);
    // SAFETY: the caller's promise.
    unsafe {
        let made = gpu.device.create_framebuffer(&info, None);
        Owned::new(gpu, "framebuffer", made)
    }
}

/// Target of accumulated numbers, and how shaders read it. Each fill that accumulates has its own.
#[derive(Debug)]
pub struct Numbers {
    pub(crate) framebuffer: Owned<vk::Framebuffer>,
    pub(crate) set: Set,
    image: Image,
    pub(crate) depth: Arc<Image>,
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
            vk::ImageUsageFlags::SAMPLED,
        )?;
        let bound = [Bound::readable(image.view)];
        // SAFETY: of the kind that the layout has; the image lives as long as the set.
        let set = unsafe { Set::new(gpu, gpu.fixtures.image_set_layout(false), &bound) }?;
        let views = [image.view, targets.depth_stencil.view];
        // SAFETY: the views are of the pass's formats and of this size.
        let framebuffer = unsafe { framebuffer(gpu, gpu.fixtures.numbers, &views, extent, 1) }?;
        gpu.work.count_texture(image.bytes(NUMBER_BYTES));
        Ok(Self {
            framebuffer,
            set,
            image,
            depth: Arc::clone(&targets.depth_stencil),
        })
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        self.image.bytes(NUMBER_BYTES)
    }
}

impl Targets {
    pub(crate) fn new(gpu: &Arc<Gpu>, size: ImageSize) -> Result<Self, DeviceError> {
        let extent = vk::Extent2D {
            width: size.width,
            height: size.height,
        };
        let unused = vk::ImageUsageFlags::empty();
        let colour = Image::target(gpu, "colour", extent, COLOUR_FORMAT, unused)?;
        // As on wgpu, whether or not a fill reads depth: one surface serves all fills.
        let read = if gpu.facts.features.samples_depth {
            vk::ImageUsageFlags::SAMPLED
        } else {
            unused
        };
        let label = "depth and stencil";
        let depth_stencil = Image::target(gpu, label, extent, DEPTH_STENCIL_FORMAT, read)?;
        let views = [colour.view, depth_stencil.view];
        let attached = |render_pass, views: &[vk::ImageView]| {
            // SAFETY: the views are of the pass's formats and of this size.
            unsafe { framebuffer(gpu, render_pass, views, extent, 1) }
        };
        let fixtures = &gpu.fixtures;
        Ok(Self {
            gpu: Arc::clone(gpu),
            extent,
            framebuffers: [
                attached(fixtures.fill(false, false), &views[1..])?,
                attached(fixtures.fill(false, true), &views)?,
                attached(fixtures.textured, &views)?,
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

    /// Whether `depth` is the depth of these targets.
    pub(crate) fn has(&self, depth: &Arc<Image>) -> bool {
        Arc::ptr_eq(&self.depth_stencil, depth)
    }

    /// Of negative height: WGSL has y up, Vulkan down.
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
