// SPDX-License-Identifier: MIT OR Apache-2.0
//! Depth maps in the layers of one image, with colours in those of another where they are asked for.
//!
//! They are drawn one after the other, all at once by a stage that chooses the layer, or some at once as views of one
//! draw.

use crate::Gpu;
use crate::image::{Image, ImageKind, ImageShape};
use crate::memory::check_some;
use crate::owned::Owned;
use crate::readback::{Readable, read_images};
use crate::targets::framebuffer;
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const FORMAT: vk::Format = vk::Format::D32_SFLOAT;
const COLOUR_FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const TEXEL_BYTES: u64 = 4;
/// In which maps are left, for shaders.
const READABLE: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

/// How all layers are reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayersBy {
    /// A pass each.
    Passes,
    /// One pass, in which a stage chooses the layer.
    Stage,
    /// As many layers a pass as the device has views, all passes alike.
    Views,
}

/// A pass over some layers.
#[derive(Debug)]
pub(crate) struct LayerPass {
    pub(crate) framebuffer: Owned<vk::Framebuffer>,
    pub(crate) first: u32,
    /// The framebuffer is of them.
    _views: Vec<Owned<vk::ImageView>>,
}

/// What layers hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerContents {
    /// Depths alone.
    Depth,
    /// Depths, and colours of four bytes.
    DepthAndColour,
}

/// Square depth maps, cleared to 0 before each draw, of which the greatest depth stays; and its colour, where maps have
/// colours.
#[derive(Debug)]
pub struct LayeredDepth {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) image: Image,
    pub(crate) colours: Option<Image>,
    pub(crate) by: LayersBy,
    /// Layers that a pass draws into as views.
    pub(crate) views: u32,
    pub(crate) render_pass: Owned<vk::RenderPass>,
    pub(crate) passes: Vec<LayerPass>,
}

impl LayeredDepth {
    /// Makes the maps.
    ///
    /// - `side`: texels
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] without multiview where it is asked for, [`DeviceError::OverCapacity`],
    /// [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        side: u32,
        layers: u32,
        by: LayersBy,
        contents: LayerContents,
    ) -> Result<Arc<Self>, DeviceError> {
        let limits = &gpu.limits;
        let largest = limits
            .max_image_dimension2_d
            .min(limits.max_framebuffer_width);
        let most = limits
            .max_image_array_layers
            .min(limits.max_framebuffer_layers);
        for (what, found, allowed) in [
            ("texels along a side of a map", side, largest),
            ("layers of a map", layers, most),
        ] {
            check_some(what, found, allowed)?;
        }
        let most_views = gpu.facts.features.max_views;
        gpu.require(by != LayersBy::Views || most_views > 0, "multiview")?;
        let views = match by {
            LayersBy::Views => largest_divisor(layers, most_views),
            LayersBy::Passes | LayersBy::Stage => 1,
        };
        let extent = vk::Extent2D {
            width: side,
            height: side,
        };
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC;
        let kind = ImageKind {
            aspects: vk::ImageAspectFlags::DEPTH,
            shape: ImageShape::Array(layers),
            ..ImageKind::flat(extent, FORMAT, usage)
        };
        let image = Image::new(gpu, "depth maps", &kind)?;
        gpu.work.count_texture(image.bytes(TEXEL_BYTES));
        let colours = (contents == LayerContents::DepthAndColour).then(|| {
            // Left as shaders read it, which asks for that use.
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::SAMPLED
                | vk::ImageUsageFlags::TRANSFER_SRC;
            let kind = ImageKind {
                shape: ImageShape::Array(layers),
                ..ImageKind::flat(extent, COLOUR_FORMAT, usage)
            };
            let colours = Image::new(gpu, "colours of layers", &kind)?;
            gpu.work.count_texture(colours.bytes(TEXEL_BYTES));
            Ok::<_, DeviceError>(colours)
        });
        let colours = colours.transpose()?;
        let render_pass = render_pass(gpu, by, views, contents)?;
        let (step, framebuffer_layers) = match by {
            LayersBy::Passes | LayersBy::Views => (views, 1),
            LayersBy::Stage => (layers, layers),
        };
        let pass = |first: u32| -> Result<LayerPass, DeviceError> {
            let owned = std::iter::once(&image).chain(&colours);
            let owned: Vec<Owned<vk::ImageView>> = owned
                .map(|image| view_of_layers(gpu, image, first, step))
                .collect::<Result<_, _>>()?;
            let raw: Vec<vk::ImageView> = owned.iter().map(|view| view.raw).collect();
            // SAFETY: the views have these layers and this size, in the pass's formats.
            let framebuffer =
                unsafe { framebuffer(gpu, render_pass.raw, &raw, extent, framebuffer_layers) }?;
            Ok(LayerPass {
                framebuffer,
                first,
                _views: owned,
            })
        };
        let passes = (0..layers).step_by(step as usize).map(pass);
        Ok(Arc::new(Self {
            passes: passes.collect::<Result<_, _>>()?,
            gpu: Arc::clone(gpu),
            image,
            colours,
            by,
            views,
            render_pass,
        }))
    }

    /// Passes of a frame.
    #[must_use]
    pub fn passes(&self) -> usize {
        self.passes.len()
    }

    /// Bytes of all maps.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let images = std::iter::once(&self.image).chain(&self.colours);
        images.map(|image| image.bytes(TEXEL_BYTES)).sum()
    }

    pub(crate) fn extent(&self) -> vk::Extent2D {
        self.image.kind.extent
    }

    /// Depths of all layers, one after the other, row by row.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`], [`DeviceError::DeviceLost`].
    pub fn read(&self) -> Result<Vec<f32>, DeviceError> {
        let bytes = self.read_layers(&self.image)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Colours of all layers, in the same order, red in the lowest byte; none where maps have no colours.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`], [`DeviceError::DeviceLost`].
    pub fn read_colours(&self) -> Result<Vec<u32>, DeviceError> {
        let bytes = self.colours.as_ref().map(|image| self.read_layers(image));
        Ok(bytemuck::pod_collect_to_vec(
            &bytes.transpose()?.unwrap_or_default(),
        ))
    }

    fn read_layers(&self, image: &Image) -> Result<Vec<u8>, DeviceError> {
        let maps = Readable {
            image,
            aspect: image.kind.aspects,
            texel_bytes: TEXEL_BYTES,
            layout: READABLE,
        };
        // SAFETY: the maps were drawn, which leaves them in this layout, with as many bytes a texel.
        let [bytes] = unsafe { read_images(&self.gpu, [maps]) }?;
        Ok(bytes)
    }
}

/// A view of so many layers, from the first.
fn view_of_layers(
    gpu: &Arc<Gpu>,
    image: &Image,
    first: u32,
    count: u32,
) -> Result<Owned<vk::ImageView>, DeviceError> {
    let range = vk::ImageSubresourceRange {
        base_array_layer: first,
        layer_count: count,
        ..image.kind.whole()
    };
    let info = vk::ImageViewCreateInfo::default()
        .image(image.raw)
        .view_type(vk::ImageViewType::TYPE_2D_ARRAY)
        .format(image.kind.format)
        .subresource_range(range);
    // SAFETY: the structure lives through the call, and the layers are the image's, which lives as long.
    unsafe {
        let made = gpu.device.create_image_view(&info, None);
        Owned::new(gpu, "view of layers", made)
    }
}

/// Largest divisor of a number that is at most so much.
fn largest_divisor(number: u32, most: u32) -> u32 {
    let divisors = (1..=most.min(number)).rev();
    let mut divisors = divisors.filter(|divisor| number.is_multiple_of(*divisor));
    divisors.next().unwrap_or(1)
}

fn render_pass(
    gpu: &Arc<Gpu>,
    by: LayersBy,
    views: u32,
    contents: LayerContents,
) -> Result<Owned<vk::RenderPass>, DeviceError> {
    let has_colour = contents == LayerContents::DepthAndColour;
    let kept = vk::AttachmentDescription::default()
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::CLEAR)
        .store_op(vk::AttachmentStoreOp::STORE)
        .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
        .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
        .initial_layout(vk::ImageLayout::UNDEFINED)
        .final_layout(READABLE);
    let attachments = [kept.format(FORMAT), kept.format(COLOUR_FORMAT)];
    let attachments = &attachments[..1 + usize::from(has_colour)];
    let coloured = [vk::AttachmentReference {
        attachment: 1,
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
    }];
    let attached = vk::AttachmentReference {
        attachment: 0,
        layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    };
    let subpasses = [vk::SubpassDescription::default()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&coloured[..usize::from(has_colour)])
        .depth_stencil_attachment(&attached)];
    let tests = vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS
        | vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
    let written =
        vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE | vk::AccessFlags::COLOR_ATTACHMENT_WRITE;
    // Whoever read the maps before is done, and whoever reads them next waits.
    let dependencies = [
        vk::SubpassDependency::default()
            .src_subpass(vk::SUBPASS_EXTERNAL)
            .dst_subpass(0)
            .src_stage_mask(vk::PipelineStageFlags::ALL_COMMANDS)
            .dst_stage_mask(tests)
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(written | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ),
        vk::SubpassDependency::default()
            .src_subpass(0)
            .dst_subpass(vk::SUBPASS_EXTERNAL)
            .src_stage_mask(tests)
            .dst_stage_mask(vk::PipelineStageFlags::ALL_COMMANDS)
            .src_access_mask(written)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ),
    ];
    let masks = [u32::MAX >> (32 - views.clamp(1, 32))];
    let mut multiview = vk::RenderPassMultiviewCreateInfo::default().view_masks(&masks);
    let mut info = vk::RenderPassCreateInfo::default()
        .attachments(attachments)
        .subpasses(&subpasses)
        .dependencies(&dependencies);
    if by == LayersBy::Views {
        info = info.push_next(&mut multiview);
    }
    // SAFETY: the structures live through the call; framebuffers and pipelines are done with before it.
    unsafe {
        let made = gpu.device.create_render_pass(&info, None);
        Owned::new(gpu, "passes of depth maps", made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_views_are_alike() {
        assert_eq!(largest_divisor(16, 6), 4);
        assert_eq!(largest_divisor(4, 6), 4);
        assert_eq!(largest_divisor(12, 6), 6);
        assert_eq!(largest_divisor(7, 6), 1);
    }
}
