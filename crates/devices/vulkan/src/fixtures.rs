// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every pipeline of a device shares: the kinds of passes, and how shaders are bound.
//!
//! Passes of a fill attach depth read-only and stencil writable, as wgpu does when it is given no
//! depth operations.

use crate::failure::failure;
use crate::handle::Handle as _;
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

/// Depth after the surface pass. Its depth may be read by shaders while it is attached.
pub(crate) const DEPTH_READ_ONLY: vk::ImageLayout =
    vk::ImageLayout::DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL;

/// Kinds of passes and bindings.
#[derive(Debug, Default)]
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
    /// Of fills, whose set 1 is the image of accumulated numbers.
    pub(crate) pipeline_layout: vk::PipelineLayout,
    /// Of surfaces with a picture, which set 1 holds with its sampler.
    pub(crate) picture_layout: vk::PipelineLayout,
    /// Set 1 of textured covers: binding 0 is the surface's depth, 1 a region's constants.
    pub(crate) depth_set_layout: vk::DescriptorSetLayout,
    /// Set 1 of fills, sets 2 and 3 of textured covers, by [`image_index`]: binding 0 is an image, 1 its sampler.
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
        let mut fixtures = Self::default();
        match fixtures.fill_in(device, has_no_store) {
            Ok(()) => Ok(fixtures),
            Err(error) => {
                fixtures.destroy(device);
                Err(failure(error, "render passes and layouts", 0))
            }
        }
    }

    fn fill_in(&mut self, device: &ash::Device, has_no_store: bool) -> Result<(), vk::Result> {
        let undefined = vk::ImageLayout::UNDEFINED;
        let clear = vk::AttachmentLoadOp::CLEAR;
        let cleared = |of: vk::AttachmentDescription| of.load_op(clear).initial_layout(undefined);
        let (colour, depth) = (colour_attachment(), depth_attachment());
        let all = [cleared(colour), cleared(depth).stencil_load_op(clear)];
        let written = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        self.surface = render_pass(device, &all, written, false)?;
        let readable = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let numbers = cleared(colour.format(NUMBER_FORMAT)).final_layout(readable);
        self.numbers = render_pass(device, &[numbers, depth], DEPTH_READ_ONLY, false)?;
        for clears in [false, true] {
            for has_colour in [false, true] {
                let depth = if clears {
                    depth.stencil_load_op(clear)
                } else {
                    depth
                };
                let all = &[colour, depth][usize::from(!has_colour)..];
                self.fills[fill_index(clears, has_colour)] =
                    render_pass(device, all, DEPTH_READ_ONLY, false)?;
            }
        }
        let read = read_depth_attachment(has_no_store);
        self.textured = render_pass(device, &[colour, read], DEPTH_READ_ONLY, true)?;
        let probed = colour.format(PROBE_FORMAT);
        for (pass, probed) in self.probes.iter_mut().zip([probed, cleared(probed)]) {
            *pass = render_pass(device, &[probed, probed, read], DEPTH_READ_ONLY, true)?;
        }
        let fragment = vk::ShaderStageFlags::FRAGMENT;
        let both = vk::ShaderStageFlags::VERTEX | fragment;
        let uniform = (vk::DescriptorType::UNIFORM_BUFFER, 1, both);
        let storage = (vk::DescriptorType::STORAGE_BUFFER, 1, both);
        let image = (vk::DescriptorType::SAMPLED_IMAGE, 1, fragment);
        let sampler = (vk::DescriptorType::SAMPLER, 1, fragment);
        // A textured region's constants lie one after the other in a buffer, and each draw says where its
        // region's begin.
        let region = (vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, 1, fragment);
        self.set_layout = set_layout(device, [uniform, storage, storage])?;
        self.depth_set_layout = set_layout(device, [image, region])?;
        self.image_set_layouts[image_index(false)] = set_layout(device, [image])?;
        self.image_set_layouts[image_index(true)] = set_layout(device, [image, sampler])?;
        let [plain, sampled] = self.image_set_layouts;
        self.pipeline_layout = pipeline_layout(device, &[self.set_layout, plain])?;
        self.picture_layout = pipeline_layout(device, &[self.set_layout, sampled])?;
        let shared = [self.set_layout, self.depth_set_layout, sampled];
        let tables = [None, Some(plain), Some(sampled)];
        for (layout, table) in self.textured_layouts.iter_mut().zip(tables) {
            let sets: Vec<_> = shared.into_iter().chain(table).collect();
            *layout = pipeline_layout(device, &sets)?;
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
        let pipeline_layouts = [self.picture_layout, self.pipeline_layout];
        let set_layouts = [self.depth_set_layout, self.set_layout];
        let passes = [self.surface, self.numbers, self.textured];
        // SAFETY: called once, when nothing uses them any more; null handles are ignored.
        unsafe {
            for layout in pipeline_layouts.into_iter().chain(self.textured_layouts) {
                layout.destroy(device);
            }
            for layout in set_layouts.into_iter().chain(self.image_set_layouts) {
                layout.destroy(device);
            }
            for pass in passes.into_iter().chain(self.fills).chain(self.probes) {
                pass.destroy(device);
            }
        }
    }
}

/// A layout of so many descriptors of each kind at the bindings 0, 1 …, for these stages.
pub(crate) fn set_layout(
    device: &ash::Device,
    kinds: impl IntoIterator<Item = (vk::DescriptorType, u32, vk::ShaderStageFlags)>,
) -> Result<vk::DescriptorSetLayout, vk::Result> {
    let entry = |(binding, (kind, count, stages))| {
        vk::DescriptorSetLayoutBinding::default()
            .binding(binding)
            .descriptor_type(kind)
            .descriptor_count(count)
            .stage_flags(stages)
    };
    let bindings: Vec<_> = (0..).zip(kinds).map(entry).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the structures live through the call.
    unsafe { device.create_descriptor_set_layout(&info, None) }
}

pub(crate) fn pipeline_layout(
    device: &ash::Device,
    sets: &[vk::DescriptorSetLayout],
) -> Result<vk::PipelineLayout, vk::Result> {
    let info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets);
    // SAFETY: the structures live through the call.
    unsafe { device.create_pipeline_layout(&info, None) }
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
