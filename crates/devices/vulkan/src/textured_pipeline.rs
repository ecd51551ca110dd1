// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on Vulkan: their pipelines, what they are bound to, and the probe's targets.
//!
//! Depth stays attached read-only as in every pass of a fill, and that layout is one in which shaders
//! may read it too: no depth is copied and no layout changes. The covers' passes write no stencil.

use crate::bindings::SetPool;
use crate::failure::failure;
use crate::fixtures::{PROBE_FORMAT, REGION_KIND};
use crate::memory::Image;
use crate::pipeline::{Assembly, OwnedPipeline, ShaderStage, stencil_test};
use crate::readback::read_probed;
use crate::shader_modules::new_module;
use crate::targets::{Framebuffer, Targets};
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
    owned: OwnedPipeline,
    layout: vk::PipelineLayout,
    table_is_sampled: Option<bool>,
    is_probe: bool,
}

impl TexturedPipeline {
    /// Makes a pipeline.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the stencil would be written, which is attached read-only;
    /// [`DeviceError::Shader`], [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, descriptor: &TexturedDescriptor<'_>) -> Result<Self, DeviceError> {
        if descriptor.test.zeroes {
            return Err(DeviceError::unsupported(
                "a textured cover that writes the stencil",
                &gpu.facts.name,
            ));
        }
        Ok(Self {
            owned: create(gpu, descriptor)?,
            layout: gpu.fixtures.textured_layout(descriptor.table_is_sampled),
            table_is_sampled: descriptor.table_is_sampled,
            is_probe: descriptor.look.purpose == CoverPurpose::Probe,
        })
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        self.owned.is_on(gpu)
    }

    pub(crate) fn raw(&self) -> vk::Pipeline {
        self.owned.raw
    }

    pub(crate) fn layout(&self) -> vk::PipelineLayout {
        self.layout
    }

    pub(crate) fn is_probe(&self) -> bool {
        self.is_probe
    }

    /// Whether set 3 is what the route reads.
    pub(crate) fn takes_table(&self, table: Option<&ImageBindings>) -> bool {
        table.map(ImageBindings::is_sampled) == self.table_is_sampled
    }
}

/// Shader modules of one pipeline, which keeps what it needs of them.
struct Modules<'a> {
    gpu: &'a Gpu,
    made: Vec<vk::ShaderModule>,
}

impl Modules<'_> {
    fn add(&mut self, spirv: &[u32]) -> Result<vk::ShaderModule, DeviceError> {
        // SAFETY: naga validated the source.
        let module = unsafe { new_module(&self.gpu.device, TEXTURED_COVER, spirv) }?;
        self.made.push(module);
        Ok(module)
    }
}

impl Drop for Modules<'_> {
    fn drop(&mut self) {
        for module in self.made.drain(..) {
            // SAFETY: no pipeline is being made of it any more.
            unsafe { self.gpu.device.destroy_shader_module(module, None) };
        }
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
    let mut modules = Modules {
        gpu,
        made: Vec::new(),
    };
    let (vertex, fragment) = (SpirvStage::Vertex, SpirvStage::Fragment);
    let mut stages = Vec::new();
    for (stage, flag, name) in [
        (vertex, vk::ShaderStageFlags::VERTEX, "vertex_main"),
        (fragment, vk::ShaderStageFlags::FRAGMENT, look.entry_point()),
    ] {
        let spirv = composed_to_spirv(TEXTURED_COVER, &composed, stage, name, &constants);
        let module = modules.add(&spirv.map_err(failed)?)?;
        stages.push(ShaderStage::of_module(flag, module, name)?);
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
    gpu: Arc<Gpu>,
    view: vk::ImageView,
    pool: SetPool,
    stride: u32,
    count: usize,
    depth: Arc<Image>,
    /// The set points at it.
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
        let lacks = |capability: &str| DeviceError::unsupported(capability, &gpu.facts.name);
        if !gpu.facts.features.samples_depth {
            return Err(lacks("reading depth in shaders"));
        }
        let alignment = Self::alignment(gpu);
        let fits = regions.is_on(gpu)
            && regions.use_for() == Some(BufferUse::Constants)
            && stride > 0
            && stride.is_multiple_of(alignment)
            && stride as u64 <= u64::from(gpu.limits.max_uniform_buffer_range)
            && regions.size() >= stride as u64;
        let bytes = u32::try_from(stride).ok().filter(|_| fits);
        let Some(bytes) = bytes else {
            return Err(lacks(
                "binding constants of another device, for another use or out of step",
            ));
        };
        let kinds = [vk::DescriptorType::SAMPLED_IMAGE, REGION_KIND];
        let depth = Arc::clone(targets.depth_stencil());
        let mut bindings = Self {
            gpu: Arc::clone(gpu),
            view: vk::ImageView::null(),
            pool: SetPool::new(gpu, gpu.fixtures.depth_set_layout, &kinds)?,
            stride: bytes,
            count: usize::try_from(regions.size() / stride as u64).unwrap_or(usize::MAX),
            depth,
            _regions: Arc::clone(regions),
        };
        let view_info = vk::ImageViewCreateInfo::default()
            .image(bindings.depth.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(crate::fixtures::DEPTH_STENCIL_FORMAT)
            .subresource_range(
                vk::ImageSubresourceRange::default()
                    .aspect_mask(vk::ImageAspectFlags::DEPTH)
                    .level_count(1)
                    .layer_count(1),
            );
        // SAFETY: the image lives as long as the view, in its own format, and was made to be sampled.
        bindings.view = unsafe { gpu.device.create_image_view(&view_info, None) }
            .map_err(|error| failure(error, "view of depth", 0))?;
        let images = [vk::DescriptorImageInfo {
            sampler: vk::Sampler::null(),
            image_view: bindings.view,
            image_layout: crate::fixtures::DEPTH_READ_ONLY,
        }];
        let buffers = [vk::DescriptorBufferInfo {
            buffer: regions.raw,
            offset: 0,
            range: stride as u64,
        }];
        let write = |binding, kind| {
            vk::WriteDescriptorSet::default()
                .dst_set(bindings.pool.set)
                .dst_binding(binding)
                .descriptor_type(kind)
        };
        let writes = [
            write(0, kinds[0]).image_info(&images),
            write(1, kinds[1]).buffer_info(&buffers),
        ];
        // SAFETY: of the kinds that the layout has; view and buffer live as long as the set.
        unsafe { gpu.device.update_descriptor_sets(&writes, &[]) };
        Ok(bindings)
    }

    /// What a region's constants must begin at a multiple of, bytes.
    #[must_use]
    pub fn alignment(gpu: &Gpu) -> usize {
        let alignment = gpu.limits.min_uniform_buffer_offset_alignment;
        usize::try_from(alignment).unwrap_or(usize::MAX)
    }

    /// Whether it is the depth of these targets.
    pub(crate) fn reads(&self, targets: &Targets) -> bool {
        Arc::ptr_eq(&self.depth, targets.depth_stencil())
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.pool.set
    }

    /// Where the constants of one region begin; `None` beyond the last.
    pub(crate) fn offset(&self, region: usize) -> Option<u32> {
        let index = u32::try_from(region).ok().filter(|_| region < self.count)?;
        index.checked_mul(self.stride)
    }
}

impl Drop for DepthBindings {
    fn drop(&mut self) {
        // SAFETY: every submission that used it has been waited for; null is ignored.
        unsafe { self.gpu.device.destroy_image_view(self.view, None) };
    }
}

/// Targets of the textured covers' probe, as large as the targets'.
#[derive(Debug)]
pub struct Probe {
    gpu: Arc<Gpu>,
    framebuffer: Framebuffer,
    /// Places and sizes, in the order of the shader's locations.
    pub(crate) images: [Image; 2],
    pub(crate) extent: vk::Extent2D,
    /// A pass has cleared the images and left them in its layout.
    pub(crate) is_drawn: Cell<bool>,
    depth: Arc<Image>,
}

impl Probe {
    pub(crate) fn new(targets: &Targets, gpu: &Arc<Gpu>) -> Result<Self, DeviceError> {
        let extent = targets.area().extent;
        let target = |label| {
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
            let aspects = vk::ImageAspectFlags::COLOR;
            Image::target(gpu, label, extent, PROBE_FORMAT, usage, aspects)
        };
        let images = [target("probed places")?, target("probed sizes")?];
        let depth = Arc::clone(targets.depth_stencil());
        let [places, sizes] = &images;
        let views = [places.view, sizes.view, depth.view];
        let render_pass = gpu.fixtures.probe(false);
        Ok(Self {
            gpu: Arc::clone(gpu),
            // SAFETY: the views are of the pass's formats and of this size.
            framebuffer: unsafe { Framebuffer::new(gpu, render_pass, &views, extent, 1) }?,
            images,
            extent,
            is_drawn: Cell::new(false),
            depth,
        })
    }

    pub(crate) fn framebuffer(&self) -> vk::Framebuffer {
        self.framebuffer.raw
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
        let [places, sizes] = &self.images;
        let read = |image| read_probed(&self.gpu, self.extent, image);
        Ok(Some([read(places)?, read(sizes)?]))
    }

    /// Whether it attaches the depth of these targets.
    pub(crate) fn is_beside(&self, targets: &Targets) -> bool {
        Arc::ptr_eq(&self.depth, targets.depth_stencil())
    }
}
