// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every pipeline of a device shares: the kinds of passes, and how shaders are bound.
//!
//! Passes of a fill attach depth read-only and stencil writable, as wgpu does when it is given no
//! depth operations.

use crate::failure::failure;
use ash::vk;
use terrafill_contract::DeviceError;

/// Colour target: ids and colours are exact in it. Every driver can draw into it.
pub(crate) const COLOUR_FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Reversed depth needs float: on a 24-bit depth buffer it gains nothing.
pub(crate) const DEPTH_STENCIL_FORMAT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

/// Target of accumulated numbers.
pub(crate) const NUMBER_FORMAT: vk::Format = vk::Format::R32_SFLOAT;

/// What the textured covers' probe writes: what the shader computes, unrounded. Every driver can draw
/// into it.
pub(crate) const PROBE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// How a textured region's constants are bound: one after the other in a buffer, and each draw says
/// where its region's begin.
pub(crate) const REGION_KIND: vk::DescriptorType = vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC;

/// Depth after the surface pass. Its depth may be read by shaders while it is attached.
pub(crate) const DEPTH_READ_ONLY: vk::ImageLayout =
    vk::ImageLayout::DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL;

/// Kinds of passes and bindings.
#[derive(Debug)]
pub(crate) struct Fixtures {
    /// Clears everything and writes depth.
    pub(crate) surface: vk::RenderPass,
    /// By [`fill_index`].
    fills: [vk::RenderPass; 4],
    /// Clears the numbers and leaves them to be read.
    pub(crate) numbers: vk::RenderPass,
    /// Like a fill with colour; shaders read the depth that is attached.
    pub(crate) textured: vk::RenderPass,
    /// Into the probe's targets, which the second clears.
    probes: [vk::RenderPass; 2],
    /// Set 0: binding 0 is view constants, 1 region constants, 2 footprints.
    pub(crate) set_layout: vk::DescriptorSetLayout,
    /// Set 1: binding 0 is the image of accumulated numbers.
    pub(crate) number_set_layout: vk::DescriptorSetLayout,
    pub(crate) pipeline_layout: vk::PipelineLayout,
    /// Of surfaces with a picture, which set 1 holds with its sampler.
    pub(crate) picture_layout: vk::PipelineLayout,
    /// Set 1 of textured covers: binding 0 is the surface's depth, 1 a region's constants.
    pub(crate) depth_set_layout: vk::DescriptorSetLayout,
    /// Sets 2 and 3 of textured covers, by [`image_index`]: binding 0 is an image, 1 its sampler.
    image_set_layouts: [vk::DescriptorSetLayout; 2],
    /// Of textured covers, by what set 3 is: nothing, an image, an image and its sampler.
    textured_layouts: [vk::PipelineLayout; 3],
}

fn image_index(is_sampled: bool) -> usize {
    usize::from(is_sampled)
}

fn fill_index(clears_stencil: bool, has_colour: bool) -> usize {
    usize::from(clears_stencil) + 2 * usize::from(has_colour)
}

impl Fixtures {
    /// - `has_no_store`: the device knows `VK_ATTACHMENT_STORE_OP_NONE` (Vulkan 1.3)
    pub(crate) fn new(device: &ash::Device, has_no_store: bool) -> Result<Self, DeviceError> {
        // Null handles may be destroyed, so that whatever was made until an error goes again.
        let mut fixtures = Self {
            surface: vk::RenderPass::null(),
            fills: [vk::RenderPass::null(); 4],
            numbers: vk::RenderPass::null(),
            textured: vk::RenderPass::null(),
            probes: [vk::RenderPass::null(); 2],
            set_layout: vk::DescriptorSetLayout::null(),
            number_set_layout: vk::DescriptorSetLayout::null(),
            pipeline_layout: vk::PipelineLayout::null(),
            picture_layout: vk::PipelineLayout::null(),
            depth_set_layout: vk::DescriptorSetLayout::null(),
            image_set_layouts: [vk::DescriptorSetLayout::null(); 2],
            textured_layouts: [vk::PipelineLayout::null(); 3],
        };
        match fixtures.fill_in(device, has_no_store) {
            Ok(()) => Ok(fixtures),
            Err(error) => {
                fixtures.destroy(device);
                Err(failure(error, "render passes and layouts", 0))
            }
        }
    }

    fn fill_in(&mut self, device: &ash::Device, has_no_store: bool) -> Result<(), vk::Result> {
        self.surface = surface_pass(device)?;
        self.numbers = number_pass(device)?;
        for clears in [false, true] {
            for has_colour in [false, true] {
                self.fills[fill_index(clears, has_colour)] = fill_pass(device, clears, has_colour)?;
            }
        }
        let read = read_depth_attachment(has_no_store);
        self.textured = textured_pass(device, read)?;
        for clears in [false, true] {
            self.probes[usize::from(clears)] = probe_pass(device, read, clears)?;
        }
        let both = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let entry = |binding, kind, stages| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(stages)
        };
        let bindings = [
            entry(0, vk::DescriptorType::UNIFORM_BUFFER, both),
            entry(1, vk::DescriptorType::STORAGE_BUFFER, both),
            entry(2, vk::DescriptorType::STORAGE_BUFFER, both),
        ];
        let number_bindings = [entry(
            0,
            vk::DescriptorType::SAMPLED_IMAGE,
            vk::ShaderStageFlags::FRAGMENT,
        )];
        let number_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&number_bindings);
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: the structures live through the calls.
        unsafe {
            self.set_layout = device.create_descriptor_set_layout(&set_info, None)?;
            self.number_set_layout = device.create_descriptor_set_layout(&number_info, None)?;
            let sets = [self.set_layout, self.number_set_layout];
            let layout_info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            self.pipeline_layout = device.create_pipeline_layout(&layout_info, None)?;
        }
        self.fill_in_textured(device)
    }

    fn fill_in_textured(&mut self, device: &ash::Device) -> Result<(), vk::Result> {
        let entry = |binding, kind| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::FRAGMENT)
        };
        let image = entry(0, vk::DescriptorType::SAMPLED_IMAGE);
        let set_layout = |bindings: &[vk::DescriptorSetLayoutBinding<'_>]| {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
            // SAFETY: the structures live through the call.
            unsafe { device.create_descriptor_set_layout(&info, None) }
        };
        self.depth_set_layout = set_layout(&[image, entry(1, REGION_KIND)])?;
        self.image_set_layouts[image_index(false)] = set_layout(&[image])?;
        self.image_set_layouts[image_index(true)] =
            set_layout(&[image, entry(1, vk::DescriptorType::SAMPLER)])?;
        let [plain, sampled] = self.image_set_layouts;
        let coloured = [self.set_layout, sampled];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&coloured);
        // SAFETY: the structures live through the call.
        self.picture_layout = unsafe { device.create_pipeline_layout(&info, None) }?;
        let shared = [self.set_layout, self.depth_set_layout, sampled];
        for (layout, table) in
            self.textured_layouts
                .iter_mut()
                .zip([None, Some(plain), Some(sampled)])
        {
            let sets: Vec<_> = shared.into_iter().chain(table).collect();
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
            // SAFETY: the structures live through the call.
            *layout = unsafe { device.create_pipeline_layout(&info, None) }?;
        }
        Ok(())
    }

    /// Layout of a set that holds an image and, if it is filtered, a sampler.
    pub(crate) fn image_set_layout(&self, is_sampled: bool) -> vk::DescriptorSetLayout {
        self.image_set_layouts[image_index(is_sampled)]
    }

    /// Of textured covers whose route reads no table, one texel by texel, or one with a sampler.
    pub(crate) fn textured_layout(&self, table_is_sampled: Option<bool>) -> vk::PipelineLayout {
        self.textured_layouts[table_is_sampled.map_or(0, |is_sampled| 1 + image_index(is_sampled))]
    }

    /// Into the probe's targets.
    pub(crate) fn probe(&self, clears: bool) -> vk::RenderPass {
        self.probes[usize::from(clears)]
    }

    pub(crate) fn fill(&self, clears_stencil: bool, has_colour: bool) -> vk::RenderPass {
        self.fills[fill_index(clears_stencil, has_colour)]
    }

    pub(crate) fn destroy(&self, device: &ash::Device) {
        // SAFETY: called once, when nothing uses them any more; null handles are ignored.
        unsafe {
            for layout in self.textured_layouts {
                device.destroy_pipeline_layout(layout, None);
            }
            for layout in self.image_set_layouts {
                device.destroy_descriptor_set_layout(layout, None);
            }
            device.destroy_descriptor_set_layout(self.depth_set_layout, None);
            device.destroy_pipeline_layout(self.picture_layout, None);
            device.destroy_pipeline_layout(self.pipeline_layout, None);
            device.destroy_descriptor_set_layout(self.number_set_layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
            device.destroy_render_pass(self.textured, None);
            for pass in self.probes {
                device.destroy_render_pass(pass, None);
            }
            device.destroy_render_pass(self.numbers, None);
            for pass in self.fills {
                device.destroy_render_pass(pass, None);
            }
            device.destroy_render_pass(self.surface, None);
        }
    }
}

/// Loaded, kept, and in the same layout before and after.
fn kept(format: vk::Format, layout: vk::ImageLayout) -> vk::AttachmentDescription {
    vk::AttachmentDescription::default()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::LOAD)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(layout)
        .final_layout(layout)
}

fn colour_attachment() -> vk::AttachmentDescription {
    kept(COLOUR_FORMAT, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
}

fn depth_attachment() -> vk::AttachmentDescription {
    kept(DEPTH_STENCIL_FORMAT, DEPTH_READ_ONLY)
        .stencil_load_op(vk::AttachmentLoadOp::LOAD)
        .stencil_store_op(vk::AttachmentStoreOp::STORE)
}

/// Depth and stencil of a pass that writes neither, in which shaders read depth. A store counts as a
/// write after those reads, whatever it leaves unchanged; so there is none, where the device knows how.
fn read_depth_attachment(has_no_store: bool) -> vk::AttachmentDescription {
    let kept = depth_attachment();
    if has_no_store {
        kept.store_op(vk::AttachmentStoreOp::NONE)
            .stencil_store_op(vk::AttachmentStoreOp::NONE)
    } else {
        kept
    }
}

fn surface_pass(device: &ash::Device) -> Result<vk::RenderPass, vk::Result> {
    let attachments = [
        colour_attachment()
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .initial_layout(vk::ImageLayout::UNDEFINED),
        depth_attachment()
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .stencil_load_op(vk::AttachmentLoadOp::CLEAR)
            .initial_layout(vk::ImageLayout::UNDEFINED),
    ];
    let layout = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    render_pass(device, &attachments, layout, false)
}

/// Neither depth nor stencil is written, and shaders read depth.
fn textured_pass(
    device: &ash::Device,
    depth: vk::AttachmentDescription,
) -> Result<vk::RenderPass, vk::Result> {
    let attachments = [colour_attachment(), depth];
    render_pass(device, &attachments, DEPTH_READ_ONLY, true)
}

fn probe_pass(
    device: &ash::Device,
    depth: vk::AttachmentDescription,
    clears: bool,
) -> Result<vk::RenderPass, vk::Result> {
    let kept = colour_attachment().format(PROBE_FORMAT);
    let probed = if clears {
        kept.load_op(vk::AttachmentLoadOp::CLEAR)
            .initial_layout(vk::ImageLayout::UNDEFINED)
    } else {
        kept
    };
    let attachments = [probed, probed, depth];
    render_pass(device, &attachments, DEPTH_READ_ONLY, true)
}

fn number_pass(device: &ash::Device) -> Result<vk::RenderPass, vk::Result> {
    let numbers = colour_attachment()
        .format(NUMBER_FORMAT)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    let attachments = [numbers, depth_attachment()];
    render_pass(device, &attachments, DEPTH_READ_ONLY, false)
}

fn fill_pass(
    device: &ash::Device,
    clears_stencil: bool,
    has_colour: bool,
) -> Result<vk::RenderPass, vk::Result> {
    let depth = if clears_stencil {
        depth_attachment().stencil_load_op(vk::AttachmentLoadOp::CLEAR)
    } else {
        depth_attachment()
    };
    if has_colour {
        let attachments = [colour_attachment(), depth];
        render_pass(device, &attachments, DEPTH_READ_ONLY, false)
    } else {
        render_pass(device, &[depth], DEPTH_READ_ONLY, false)
    }
}

/// One subpass over the attachments, the last of which is depth and stencil, after all that drew
/// into them before; shaders of later passes may read what it leaves. Those of this one read the
/// attached depth where `reads_depth` says so.
fn render_pass(
    device: &ash::Device,
    attachments: &[vk::AttachmentDescription],
    depth_layout: vk::ImageLayout,
    reads_depth: bool,
) -> Result<vk::RenderPass, vk::Result> {
    let attached = |(attachment, layout)| vk::AttachmentReference { attachment, layout };
    let colour_layout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
    let colours: Vec<_> = (0..)
        .zip(attachments.iter().skip(1).map(|_| colour_layout))
        .map(attached)
        .collect();
    let depth = attached((
        colours.last().map_or(0, |last| last.attachment + 1),
        depth_layout,
    ));
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&colours)
        .depth_stencil_attachment(&depth)];
    let stages = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT
        | vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let writes =
        vk::AccessFlags::COLOR_ATTACHMENT_WRITE | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let drawn = writes
        | vk::AccessFlags::COLOR_ATTACHMENT_READ
        | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ;
    let before = vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .dst_subpass(0)
        .src_stage_mask(stages | vk::PipelineStageFlags::TRANSFER)
        .src_access_mask(writes)
        .dst_stage_mask(if reads_depth {
            stages | vk::PipelineStageFlags::FRAGMENT_SHADER
        } else {
            stages
        })
        .dst_access_mask(if reads_depth {
            drawn | vk::AccessFlags::SHADER_READ
        } else {
            drawn
        });
    let after = vk::SubpassDependency::default()
        .src_subpass(0)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
        .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags::FRAGMENT_SHADER)
        .dst_access_mask(vk::AccessFlags::SHADER_READ);
    // What was read is stored over by later passes.
    let after_reading = vk::SubpassDependency::default()
        .src_subpass(0)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(vk::PipelineStageFlags::FRAGMENT_SHADER)
        .src_access_mask(vk::AccessFlags::SHADER_READ)
        .dst_stage_mask(stages)
        .dst_access_mask(vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE);
    // Passes of fills must agree in their dependencies to be compatible; only numbers are read.
    let is_read = attachments
        .iter()
        .any(|attachment| attachment.final_layout == vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    let later = if reads_depth { after_reading } else { after };
    let dependencies = [before, later];
    let dependencies = &dependencies[..1 + usize::from(is_read || reads_depth)];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(attachments)
        .subpasses(&subpasses)
        .dependencies(dependencies);
    // SAFETY: the structures live through the call.
    unsafe { device.create_render_pass(&info, None) }
}
