// SPDX-License-Identifier: MIT OR Apache-2.0
//! Images of 32-bit floats whose parts are written one by one, and whose texels shaders load by their number.

use crate::memory::{Image, ImageKind, ImageShape};
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const ASPECT: vk::ImageAspectFlags = vk::ImageAspectFlags::COLOR;
const READABLE: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const WRITABLE: vk::ImageLayout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
const TEXEL_BYTES: u64 = 4;

/// What lies behind the first picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockShape {
    /// Nothing.
    Flat,
    /// Layers.
    Array(u32),
    /// Slices of a volume.
    Volume(u32),
}

/// An image that is written in parts.
#[derive(Debug)]
pub struct BlockImage {
    gpu: Arc<Gpu>,
    image: Image,
    size: [u32; 2],
    shape: BlockShape,
}

impl BlockImage {
    /// An image of zeros or whatever was there.
    ///
    /// - `size`: width and height, texels
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no such image, [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, size: [u32; 2], shape: BlockShape) -> Result<Self, DeviceError> {
        let limits = &gpu.limits;
        let (side, behind) = match shape {
            BlockShape::Flat => (limits.max_image_dimension2_d, ("images", 1, 1)),
            BlockShape::Array(layers) => (
                limits.max_image_dimension2_d,
                ("layers of an image", layers, limits.max_image_array_layers),
            ),
            BlockShape::Volume(slices) => (
                limits.max_image_dimension3_d,
                ("slices of a volume", slices, limits.max_image_dimension3_d),
            ),
        };
        let across = (
            "texels along a side of an image",
            size[0].max(size[1]),
            side,
        );
        for (what, found, allowed) in [across, behind] {
            if found > allowed || found == 0 {
                return Err(DeviceError::OverCapacity {
                    what: what.to_owned(),
                    found: found.into(),
                    allowed: allowed.into(),
                });
            }
        }
        let kind = ImageKind {
            extent: vk::Extent2D {
                width: size[0],
                height: size[1],
            },
            format: vk::Format::R32_SFLOAT,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
            aspects: ASPECT,
            levels: 1,
            shape: match shape {
                BlockShape::Flat => ImageShape::Flat,
                BlockShape::Array(layers) => ImageShape::Array(layers),
                BlockShape::Volume(slices) => ImageShape::Volume(slices),
            },
        };
        let made = Self {
            gpu: Arc::clone(gpu),
            image: Image::new(gpu, "blocks", &kind)?,
            size,
            shape,
        };
        gpu.work.count_texture(made.bytes());
        let ready = [made.barrier(vk::ImageLayout::UNDEFINED, READABLE)];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the image is of this device and lives until the submission is done.
        unsafe {
            gpu.submit(|device, commands| {
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &ready);
            })?;
        }
        Ok(made)
    }

    /// Bytes of all texels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.size.map(u64::from);
        width * height * u64::from(self.behind()) * TEXEL_BYTES
    }

    fn behind(&self) -> u32 {
        match self.shape {
            BlockShape::Flat => 1,
            BlockShape::Array(count) | BlockShape::Volume(count) => count,
        }
    }

    fn barrier(
        &self,
        from: vk::ImageLayout,
        to: vk::ImageLayout,
    ) -> vk::ImageMemoryBarrier<'static> {
        let layers = match self.shape {
            BlockShape::Array(layers) => layers,
            BlockShape::Flat | BlockShape::Volume(_) => 1,
        };
        vk::ImageMemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.image.raw)
            .subresource_range(
                vk::ImageSubresourceRange::default()
                    .aspect_mask(ASPECT)
                    .level_count(1)
                    .layer_count(layers),
            )
    }

    /// Writes a rectangle and waits.
    ///
    /// - `first`: its first texel, and the layer or slice
    /// - `size`: width and height, texels
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when it does not lie in the image or has another number of texels,
    /// [`DeviceError::OutOfMemory`], [`DeviceError::DeviceLost`].
    pub fn write(
        &self,
        first: [u32; 3],
        size: [u32; 2],
        texels: &[f32],
    ) -> Result<(), DeviceError> {
        let ends = [first[0] + size[0], first[1] + size[1], first[2] + 1];
        let inside = [self.size[0], self.size[1], self.behind()];
        let count = size[0] as usize * size[1] as usize;
        let is_inside = ends.iter().zip(inside).all(|(end, most)| *end <= most);
        if !is_inside || texels.len() != count {
            return Err(DeviceError::OverCapacity {
                what: "texels written into a part of an image".to_owned(),
                found: texels.len() as u64,
                allowed: if is_inside { count as u64 } else { 0 },
            });
        }
        let bytes: Vec<u8> = texels
            .iter()
            .flat_map(|texel| texel.to_ne_bytes())
            .collect();
        let staging = Buffer::staging(&self.gpu, "block", &bytes)?;
        let (layer, slice) = match self.shape {
            BlockShape::Volume(_) => (0, first[2]),
            BlockShape::Flat | BlockShape::Array(_) => (first[2], 0),
        };
        let signed = |at: u32| i32::try_from(at).unwrap_or(i32::MAX);
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: ASPECT,
                mip_level: 0,
                base_array_layer: layer,
                layer_count: 1,
            })
            .image_offset(vk::Offset3D {
                x: signed(first[0]),
                y: signed(first[1]),
                z: signed(slice),
            })
            .image_extent(vk::Extent3D {
                width: size[0],
                height: size[1],
                depth: 1,
            })];
        let before = [self.barrier(READABLE, WRITABLE)];
        let after = [self.barrier(WRITABLE, READABLE)];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the rectangle lies in the image, as checked, and the buffer holds all of it; both live until the
        // submission is done.
        unsafe {
            self.gpu.submit(|device, commands| {
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &before);
                let image = self.image.raw;
                device.cmd_copy_buffer_to_image(commands, staging.raw, image, WRITABLE, &region);
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &after);
            })?;
        }
        self.gpu.work.count_upload(bytes.len() as u64);
        Ok(())
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.image.view
    }
}
