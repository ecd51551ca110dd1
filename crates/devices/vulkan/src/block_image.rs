// SPDX-License-Identifier: MIT OR Apache-2.0
//! Images of 32-bit floats whose parts are written one by one, and whose texels shaders load by their number.

use crate::image::{Image, ImageKind};
use crate::memory::check_some;
use crate::{Buffer, Gpu, ImageShape};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

const READABLE: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const WRITABLE: vk::ImageLayout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
const TEXEL_BYTES: u64 = 4;

/// An image that is written in parts.
#[derive(Debug)]
pub struct BlockImage {
    gpu: Arc<Gpu>,
    pub(crate) image: Image,
}

impl BlockImage {
    /// An image of zeros or whatever was there.
    ///
    /// - `size`: width and height, texels
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no such image, [`DeviceError::Unsupported`] for a cube,
    /// [`DeviceError::OutOfMemory`].
    pub fn new(gpu: &Arc<Gpu>, size: [u32; 2], shape: ImageShape) -> Result<Self, DeviceError> {
        let limits = &gpu.limits;
        let (side, behind) = match shape {
            ImageShape::Cube => return Err(gpu.lacks("cubes that are written in parts")),
            ImageShape::Flat => (limits.max_image_dimension2_d, ("images", 1, 1)),
            ImageShape::Array(layers) => (
                limits.max_image_dimension2_d,
                ("layers of an image", layers, limits.max_image_array_layers),
            ),
            ImageShape::Volume(slices) => (
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
            check_some(what, found, allowed)?;
        }
        let [width, height] = size;
        let extent = vk::Extent2D { width, height };
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let kind = ImageKind {
            shape,
            ..ImageKind::flat(extent, vk::Format::R32_SFLOAT, usage)
        };
        let made = Self {
            gpu: Arc::clone(gpu),
            image: Image::new(gpu, "blocks", &kind)?,
        };
        gpu.work.count_texture(made.bytes());
        // SAFETY: the image is of this device and lives until the submission is done.
        unsafe {
            gpu.submit(|device, commands| {
                made.image
                    .change_layout(device, commands, vk::ImageLayout::UNDEFINED, READABLE);
            })?;
        }
        Ok(made)
    }

    /// Bytes of all texels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.image.bytes(TEXEL_BYTES)
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
        let kind = &self.image.kind;
        let inside = [
            kind.extent.width,
            kind.extent.height,
            kind.layers() * kind.depth(),
        ];
        let count = size[0] as usize * size[1] as usize;
        let is_inside = ends.iter().zip(inside).all(|(end, most)| *end <= most);
        if !is_inside || texels.len() != count {
            return Err(DeviceError::OverCapacity {
                what: "texels written into a part of an image".to_owned(),
                found: texels.len() as u64,
                allowed: if is_inside { count as u64 } else { 0 },
            });
        }
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        let staging = Buffer::staging(&self.gpu, "block", bytes)?;
        let (layer, slice) = match kind.shape {
            ImageShape::Volume(_) => (0, first[2]),
            _ => (first[2], 0),
        };
        let signed = |at: u32| i32::try_from(at).unwrap_or(i32::MAX);
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: kind.aspects,
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
        // SAFETY: the rectangle lies in the image, as checked, and the buffer holds all of it; both live until the
        // submission is done.
        unsafe {
            self.gpu.submit(|device, commands| {
                let image = &self.image;
                image.change_layout(device, commands, READABLE, WRITABLE);
                let (from, to) = (staging.raw, image.raw);
                device.cmd_copy_buffer_to_image(commands, from, to, WRITABLE, &region);
                image.change_layout(device, commands, WRITABLE, READABLE);
            })?;
        }
        self.gpu.work.count_upload(bytes.len() as u64);
        Ok(())
    }
}
