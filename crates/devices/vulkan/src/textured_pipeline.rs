// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on Vulkan: their pipelines, what they are bound to, and the probe's targets.
//!
//! Depth stays attached read-only as in every pass of a fill, and that layout is one in which shaders
//! may read it too: no depth is copied and no layout changes. The covers' passes write no stencil.

use crate::bindings::{Bound, Set};
use crate::fixtures::{DEPTH_READ_ONLY, PROBE_FORMAT};
use crate::image::Image;
use crate::owned::Owned;
use crate::pipeline::{Assembly, OwnedPipeline, ShaderStage, stencil_test};
use crate::readback::{Readable, read_images};
use crate::shader_modules::new_module;
use crate::targets::{Targets, framebuffer};
use crate::{Buffer, BufferUse, Gpu, ImageBindings};
use ash::vk;
use std::cell::Cell;
use std::sync::Arc;
use terrafill_contract::DeviceError;
use terrafill_shaders::{SpirvStage, TEXTURED_COVER, TexturedParts, composed_to_spirv};
use terrafill_stencil::{CoverLook, CoverPurpose, StencilTest};

/// All that makes the pipeline of a textured cover.
#[derive(Debug, Clone, Copy)]
pub struct TexturedDescriptor<'a> {
    /// The shader.
    pub parts: &'a TexturedParts,
    /// Whether the table that the route reads has a sampler; `None` for a route without a table.
    pub table_is_sampled: Option<bool>,
    /// What the stencil must say, which is left as it is.
    pub test: StencilTest,
    /// What it does with its fragments.
    pub look: CoverLook,
}

/// Draws a textured cover.
#[derive(Debug)]
pub struct TexturedPipeline {
    pub(crate) owned: OwnedPipeline,
    pub(crate) layout: vk::PipelineLayout,
    table_is_sampled: Option<bool>,
    pub(crate) is_probe: bool,
}

impl TexturedPipeline {
    /// Makes a pipeline.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the stencil would be written, which is attached read-only;
    /// [`DeviceError::Shader`], [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, descriptor: &TexturedDescriptor<'_>) -> Result<Self, DeviceError> {
        let is_read = !descriptor.test.zeroes;
        gpu.require(is_read, "a textured cover that writes the stencil")?;
        Ok(Self {
            owned: create(gpu, descriptor)?,
            layout: gpu.fixtures.textured_layout(descriptor.table_is_sampled),
            table_is_sampled: descriptor.table_is_sampled,
            is_probe: descriptor.look.purpose == CoverPurpose::Probe,
        })
    }

    /// Whether set 3 is what the route reads.
    pub(crate) fn takes_table(&self, table: Option<&ImageBindings>) -> bool {
        table.map(ImageBindings::is_sampled) == self.table_is_sampled
    }
}

fn create(
    gpu: &Arc<Gpu>,
    descriptor: &TexturedDescriptor<'_>,
) -> Result<OwnedPipeline, DeviceError> {
    let failed = |error: terrafill_shaders::ShaderError| DeviceError::Shader {
        name: TEXTURED_COVER.to_owned(),
        message: error.to_string(),
    };
    let composed = descriptor.parts.compose().map_err(failed)?;
    let look = descriptor.look;
    let constants = look.overrides.constants();
    // Pipelines keep what they need of a module.
    let mut modules = Vec::new();
    let (vertex, fragment) = (SpirvStage::Vertex, SpirvStage::Fragment);
    let mut stages = Vec::new();
    for (stage, flag, name) in [
        (vertex, vk::ShaderStageFlags::VERTEX, "vertex_main"),
        (fragment, vk::ShaderStageFlags::FRAGMENT, look.entry_point()),
    ] {
        let spirv = composed_to_spirv(TEXTURED_COVER, &composed, stage, name, &constants);
        // SAFETY: naga validated the source.
        let module = unsafe {
            let made = new_module(&gpu.device, &spirv.map_err(failed)?);
            Owned::new(gpu, TEXTURED_COVER, made)
        }?;
        stages.push(ShaderStage::of_module(flag, module.raw, name)?);
        modules.push(module);
    }
    // Straight alpha over what is there.
    let over = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(look.blends)
        .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
        .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .color_blend_op(vk::BlendOp::ADD)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .alpha_blend_op(vk::BlendOp::ADD);
    let is_probe = look.purpose == CoverPurpose::Probe;
    let layout = gpu.fixtures.textured_layout(descriptor.table_is_sampled);
    let render_pass = if is_probe {
        gpu.fixtures.probe(false)
    } else {
        gpu.fixtures.textured
    };
    Assembly {
        stages: &stages,
        blends: &[over; 2][..1 + usize::from(is_probe)],
        ..Assembly::new(layout, render_pass, stencil_test(descriptor.test))
    }
    .create(gpu)
}

/// The surface's depth and the regions' constants, as textured covers read them.
#[derive(Debug)]
pub struct DepthBindings {
    pub(crate) set: Set,
    stride: u32,
    count: usize,
    pub(crate) depth: Arc<Image>,
    /// The set points at them.
    _view: Owned<vk::ImageView>,
    _regions: Arc<Buffer>,
}

impl DepthBindings {
    /// - `regions`: constants of one region after the other, `stride` bytes each
    pub(crate) fn new(
        targets: &Targets,
        gpu: &Arc<Gpu>,
        regions: &Arc<Buffer>,
        stride: usize,
    ) -> Result<Self, DeviceError> {
        let can_read = gpu.facts.features.samples_depth;
        gpu.require(can_read, "reading depth in shaders")?;
        let alignment = Self::alignment(gpu);
        let fits = regions.is_for(gpu, BufferUse::Constants)
            && stride > 0
            && stride.is_multiple_of(alignment)
            && stride as u64 <= u64::from(gpu.limits.max_uniform_buffer_range)
            && regions.size() >= stride as u64;
        let bytes = u32::try_from(stride).ok().filter(|_| fits);
        let Some(bytes) = bytes else {
            let what = "binding constants of another device, for another use or out of step";
            return Err(gpu.lacks(what));
        };
        let depth = Arc::clone(&targets.depth_stencil);
        let info = vk::ImageViewCreateInfo::default()
            .image(depth.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(depth.kind.format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: vk::ImageAspectFlags::DEPTH,
                ..depth.kind.whole()
            });
        // SAFETY: the image lives as long as the view, in its own format, and was made to be sampled.
        let view = unsafe {
            let made = gpu.device.create_image_view(&info, None);
            Owned::new(gpu, "view of depth", made)
        }?;
        let bound = [
            Bound::Image(view.raw, DEPTH_READ_ONLY),
            Bound::Part(regions, stride as u64),
        ];
        Ok(Self {
            // SAFETY: of the kinds that the layout has; view and buffer live as long as the set.
            set: unsafe { Set::new(gpu, gpu.fixtures.depth_set_layout, &bound) }?,
            stride: bytes,
            count: usize::try_from(regions.size() / stride as u64).unwrap_or(usize::MAX),
            depth,
            _view: view,
            _regions: Arc::clone(regions),
        })
    }

    /// What a region's constants must begin at a multiple of, bytes.
    #[must_use]
    pub fn alignment(gpu: &Gpu) -> usize {
        let alignment = gpu.limits.min_uniform_buffer_offset_alignment;
        usize::try_from(alignment).unwrap_or(usize::MAX)
    }

    /// Where the constants of one region begin; `None` beyond the last.
    pub(crate) fn offset(&self, region: usize) -> Option<u32> {
        let index = u32::try_from(region).ok().filter(|_| region < self.count)?;
        index.checked_mul(self.stride)
    }
}

/// Targets of the textured covers' probe, as large as the targets'.
#[derive(Debug)]
pub struct Probe {
    pub(crate) framebuffer: Owned<vk::Framebuffer>,
    /// Places and sizes, in the order of the shader's locations.
    images: [Image; 2],
    /// A pass has cleared the images and left them in its layout.
    pub(crate) is_drawn: Cell<bool>,
    pub(crate) depth: Arc<Image>,
}

impl Probe {
    pub(crate) fn new(targets: &Targets, gpu: &Arc<Gpu>) -> Result<Self, DeviceError> {
        let extent = targets.area().extent;
        let target = |label| {
            let unused = vk::ImageUsageFlags::empty();
            Image::target(gpu, label, extent, PROBE_FORMAT, unused)
        };
        let images = [target("probed places")?, target("probed sizes")?];
        let depth = Arc::clone(&targets.depth_stencil);
        let [places, sizes] = &images;
        let views = [places.view, sizes.view, depth.view];
        let render_pass = gpu.fixtures.probe(false);
        Ok(Self {
            // SAFETY: the views are of the pass's formats and of this size.
            framebuffer: unsafe { framebuffer(gpu, render_pass, &views, extent, 1) }?,
            images,
            is_drawn: Cell::new(false),
            depth,
        })
    }

    /// What the covers wrote into its two targets, row 0 at the top; `None` where no pass has drawn
    /// into them.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn read(&self) -> Result<Option<[Vec<[f32; 4]>; 2]>, DeviceError> {
        if !self.is_drawn.get() {
            return Ok(None);
        }
        let images = self.images.each_ref().map(|image| Readable {
            image,
            aspect: vk::ImageAspectFlags::COLOR,
            texel_bytes: 16,
            layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        });
        // SAFETY: a pass has left both in this layout, with as many bytes a texel.
        let read = unsafe { read_images(self.framebuffer.gpu(), images) }?;
        Ok(Some(read.map(|bytes| bytemuck::pod_collect_to_vec(&bytes))))
    }
}
