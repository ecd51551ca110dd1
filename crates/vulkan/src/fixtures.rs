// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every pipeline of a device shares: the kinds of passes, and how shaders are bound.
//!
//! Passes of a fill attach depth read-only and stencil writable, as wgpu does when it is given no
//! depth operations.

use crate::failure::failure;
use ash::vk;
use terrafill_frame::BackendError;

/// Colour target: ids and colours are exact in it. Every driver can draw into it.
pub(crate) const COLOUR_FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Reversed depth needs float: on a 24-bit depth buffer it gains nothing.
pub(crate) const DEPTH_STENCIL_FORMAT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;

/// Target of accumulated numbers.
pub(crate) const NUMBER_FORMAT: vk::Format = vk::Format::R32_SFLOAT;

/// Depth after the surface pass.
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
    /// Set 0: binding 0 is view constants, 1 region constants.
    pub(crate) set_layout: vk::DescriptorSetLayout,
    /// Set 1: binding 0 is the image of accumulated numbers.
    pub(crate) number_set_layout: vk::DescriptorSetLayout,
    pub(crate) pipeline_layout: vk::PipelineLayout,
}

fn fill_index(clears_stencil: bool, has_colour: bool) -> usize {
    usize::from(clears_stencil) + 2 * usize::from(has_colour)
}

impl Fixtures {
    pub(crate) fn new(device: &ash::Device) -> Result<Self, BackendError> {
        // Null handles may be destroyed, so that whatever was made until an error goes again.
        let mut fixtures = Self {
            surface: vk::RenderPass::null(),
            fills: [vk::RenderPass::null(); 4],
            numbers: vk::RenderPass::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            number_set_layout: vk::DescriptorSetLayout::null(),
            pipeline_layout: vk::PipelineLayout::null(),
        };
        match fixtures.fill_in(device) {
            Ok(()) => Ok(fixtures),
            Err(error) => {
                fixtures.destroy(device);
                Err(failure(error, "render passes and layouts", 0))
            }
        }
    }

    fn fill_in(&mut self, device: &ash::Device) -> Result<(), vk::Result> {
        self.surface = surface_pass(device)?;
        self.numbers = number_pass(device)?;
        for clears in [false, true] {
            for has_colour in [false, true] {
                self.fills[fill_index(clears, has_colour)] = fill_pass(device, clears, has_colour)?;
            }
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
        Ok(())
    }

    pub(crate) fn fill(&self, clears_stencil: bool, has_colour: bool) -> vk::RenderPass {
        self.fills[fill_index(clears_stencil, has_colour)]
    }

    pub(crate) fn destroy(&self, device: &ash::Device) {
        // SAFETY: called once, when nothing uses them any more; null handles are ignored.
        unsafe {
            device.destroy_pipeline_layout(self.pipeline_layout, None);
            device.destroy_descriptor_set_layout(self.number_set_layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
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
    render_pass(
        device,
        &attachments,
        vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    )
}

fn number_pass(device: &ash::Device) -> Result<vk::RenderPass, vk::Result> {
    let numbers = colour_attachment()
        .format(NUMBER_FORMAT)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    render_pass(device, &[numbers, depth_attachment()], DEPTH_READ_ONLY)
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
        render_pass(device, &[colour_attachment(), depth], DEPTH_READ_ONLY)
    } else {
        render_pass(device, &[depth], DEPTH_READ_ONLY)
    }
}

/// One subpass over the attachments, the last of which is depth and stencil, after all that drew
/// into them before; shaders of later passes may read what it leaves.
fn render_pass(
    device: &ash::Device,
    attachments: &[vk::AttachmentDescription],
    depth_layout: vk::ImageLayout,
) -> Result<vk::RenderPass, vk::Result> {
    let colour = [vk::AttachmentReference {
        attachment: 0,
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
    }];
    let has_colour = attachments.len() > 1;
    let depth = vk::AttachmentReference {
        attachment: u32::from(has_colour),
        layout: depth_layout,
    };
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(if has_colour { &colour } else { &[] })
        .depth_stencil_attachment(&depth)];
    let stages = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT
        | vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
    let writes =
        vk::AccessFlags::COLOR_ATTACHMENT_WRITE | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    let before = vk::SubpassDependency::default()
        .src_subpass(vk::SUBPASS_EXTERNAL)
        .dst_subpass(0)
        .src_stage_mask(stages | vk::PipelineStageFlags::TRANSFER)
        .src_access_mask(writes)
        .dst_stage_mask(stages)
        .dst_access_mask(
            writes
                | vk::AccessFlags::COLOR_ATTACHMENT_READ
                | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ,
        );
    let after = vk::SubpassDependency::default()
        .src_subpass(0)
        .dst_subpass(vk::SUBPASS_EXTERNAL)
        .src_stage_mask(vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT)
        .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
        .dst_stage_mask(vk::PipelineStageFlags::FRAGMENT_SHADER)
        .dst_access_mask(vk::AccessFlags::SHADER_READ);
    // Passes of fills must agree in their dependencies to be compatible; only numbers are read.
    let is_read = attachments
        .iter()
        .any(|attachment| attachment.final_layout == vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    let dependencies = [before, after];
    let dependencies = &dependencies[..1 + usize::from(is_read)];
    let info = vk::RenderPassCreateInfo::default()
        .attachments(attachments)
        .subpasses(&subpasses)
        .dependencies(dependencies);
    // SAFETY: the structures live through the call.
    unsafe { device.create_render_pass(&info, None) }
}
