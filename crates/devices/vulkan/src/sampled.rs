// SPDX-License-Identifier: MIT OR Apache-2.0
//! Images that shaders sample: pictures with all their levels, tables, cubes; and how they are bound.

use crate::bindings::{Bound, Set};
use crate::image::{Image, ImageKind};
use crate::owned::Owned;
use crate::{Buffer, Gpu, ImageShape};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_scene::MipChain;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};

const SAMPLED: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::SAMPLED.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// An image in device memory, ready to be read by fragment shaders.
#[derive(Debug)]
pub struct SampledImage {
    pub(crate) image: Image,
    bytes: u64,
}

impl SampledImage {
    /// A picture with its levels. The sampler filters it in linear light, as the levels were made.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the device has no images that large,
    /// [`DeviceError::OutOfMemory`].
    pub fn picture(gpu: &Arc<Gpu>, picture: &MipChain) -> Result<Self, DeviceError> {
        let levels = picture.levels();
        let [width, height] = picture.size_px();
        let extent = vk::Extent2D { width, height };
        let kind = ImageKind {
            levels: u32::try_from(levels.len()).unwrap_or(u32::MAX),
            ..ImageKind::flat(extent, vk::Format::R8G8B8A8_SRGB, SAMPLED)
        };
        let sizes = levels.iter().map(|level| vk::Extent2D {
            width: level.width,
            height: level.height,
        });
        let texels = levels.iter().map(|level| &*level.rgba);
        Self::upload(gpu, "picture", &kind, sizes.zip(texels))
    }

    /// A coordinate route's table.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks the format or its filtering;
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    pub fn route(gpu: &Arc<Gpu>, texels: &RouteTexels) -> Result<Self, DeviceError> {
        let (format, name) = match texels.format {
            RouteTexelFormat::R8Unorm => (vk::Format::R8_UNORM, "R8_UNORM"),
            RouteTexelFormat::R16Unorm => (vk::Format::R16_UNORM, "R16_UNORM"),
            RouteTexelFormat::R16Float => (vk::Format::R16_SFLOAT, "R16_SFLOAT"),
            RouteTexelFormat::R32Float => (vk::Format::R32_SFLOAT, "R32_SFLOAT"),
            RouteTexelFormat::Rg32Float => (vk::Format::R32G32_SFLOAT, "R32G32_SFLOAT"),
            RouteTexelFormat::Rgba32Float => {
                (vk::Format::R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT")
            }
        };
        let read = vk::FormatFeatureFlags::SAMPLED_IMAGE;
        let (needed, how) = if texels.is_filtered {
            let linear = vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
            (read | linear, "filtering")
        } else {
            (read, "reading")
        };
        let is_there = gpu.format_features(format).contains(needed);
        gpu.require(is_there, &format!("{how} of {name}"))?;
        let [width, height] = texels.size;
        let extent = vk::Extent2D { width, height };
        let mut kind = ImageKind::flat(extent, format, SAMPLED);
        if texels.is_cube {
            kind.shape = ImageShape::Cube;
        }
        let level = (extent, &*texels.bytes);
        Self::upload(gpu, "route", &kind, std::iter::once(level))
    }

    /// - `levels`: each with its size, as many as `kind` has
    fn upload<'t>(
        gpu: &Arc<Gpu>,
        label: &str,
        kind: &ImageKind,
        levels: impl Iterator<Item = (vk::Extent2D, &'t [u8])>,
    ) -> Result<Self, DeviceError> {
        let allowed = if kind.shape == ImageShape::Cube {
            gpu.limits.max_image_dimension_cube
        } else {
            gpu.limits.max_image_dimension2_d
        };
        let found = kind.extent.width.max(kind.extent.height);
        let what = format!("texels along a side of a {label}");
        DeviceError::check_capacity(&what, found, allowed)?;
        let image = Image::new(gpu, label, kind)?;
        let (mut texels, mut copies, mut all_bytes) = (Vec::new(), Vec::new(), 0);
        for (mip_level, (extent, bytes)) in (0..).zip(levels) {
            copies.push(
                vk::BufferImageCopy::default()
                    .buffer_offset(texels.len() as u64)
                    .image_subresource(vk::ImageSubresourceLayers {
                        aspect_mask: kind.aspects,
                        mip_level,
                        base_array_layer: 0,
                        layer_count: kind.layers(),
                    })
                    .image_extent(extent.into()),
            );
            texels.extend_from_slice(bytes);
            // Offsets of copies are multiples of a texel, and of 4.
            texels.resize(texels.len().next_multiple_of(16), 0);
            gpu.work.count_upload(bytes.len() as u64);
            all_bytes += bytes.len() as u64;
        }
        let staging = Buffer::staging(gpu, label, &texels)?;
        let to = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        // SAFETY: the buffer holds every level at its offset, the levels are the image's, and both
        // live until the submission is done.
        unsafe {
            gpu.submit(|device, commands| {
                image.change_layout(device, commands, vk::ImageLayout::UNDEFINED, to);
                device.cmd_copy_buffer_to_image(commands, staging.raw, image.raw, to, &copies);
                image.change_layout(
                    device,
                    commands,
                    to,
                    vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                );
            })?;
        }
        gpu.work.count_texture(all_bytes);
        Ok(Self {
            image,
            bytes: all_bytes,
        })
    }

    /// Bytes of its texels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// A sampled image as a set of its own: the image at binding 0, its sampler, if it is filtered, at 1.
#[derive(Debug)]
pub struct ImageBindings {
    pub(crate) set: Set,
    /// Where it is filtered.
    sampler: Option<Owned<vk::Sampler>>,
    /// The set points at it.
    _image: Arc<SampledImage>,
}

impl ImageBindings {
    /// A picture, linear in and between its levels.
    ///
    /// - `address`: along u and along v
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    pub fn picture(
        image: &Arc<SampledImage>,
        address: [AddressMode; 2],
    ) -> Result<Self, DeviceError> {
        Self::new(image, Some(address.map(sampled)))
    }

    /// A route's table, linear within its one level where it is filtered.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    pub fn route(image: &Arc<SampledImage>, is_filtered: bool) -> Result<Self, DeviceError> {
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        Self::new(image, is_filtered.then_some([edge; 2]))
    }

    fn new(
        image: &Arc<SampledImage>,
        address: Option<[vk::SamplerAddressMode; 2]>,
    ) -> Result<Self, DeviceError> {
        let gpu = image.image.gpu();
        let layout = gpu.fixtures.image_set_layout(address.is_some());
        let sampler = match address {
            None => None,
            Some([u, v]) => {
                let info = vk::SamplerCreateInfo::default()
                    .mag_filter(vk::Filter::LINEAR)
                    .min_filter(vk::Filter::LINEAR)
                    .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
                    .address_mode_u(u)
                    .address_mode_v(v)
                    .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                    .max_lod(vk::LOD_CLAMP_NONE);
                // SAFETY: the structure lives through the call.
                Some(unsafe {
                    let made = gpu.device.create_sampler(&info, None);
                    Owned::new(gpu, "sampler", made)
                }?)
            }
        };
        let mut bound = vec![Bound::readable(image.image.view)];
        bound.extend(sampler.iter().map(|sampler| Bound::Sampler(sampler.raw)));
        Ok(Self {
            // SAFETY: of the kinds that the layout has; image and sampler live as long as the set.
            set: unsafe { Set::new(gpu, layout, &bound) }?,
            sampler,
            _image: Arc::clone(image),
        })
    }

    /// Whether it has a sampler.
    #[must_use]
    pub fn is_sampled(&self) -> bool {
        self.sampler.is_some()
    }
}

fn sampled(mode: AddressMode) -> vk::SamplerAddressMode {
    match mode {
        AddressMode::Repeat => vk::SamplerAddressMode::REPEAT,
        AddressMode::ClampToEdge | AddressMode::Transparent => {
            vk::SamplerAddressMode::CLAMP_TO_EDGE
        }
    }
}
