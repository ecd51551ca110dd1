// SPDX-License-Identifier: MIT OR Apache-2.0
//! Images that shaders sample: pictures with all their levels, tables, cubes; and how they are bound.

use crate::bindings::SetPool;
use crate::failure::failure;
use crate::memory::{Image, ImageKind, ImageShape};
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_scene::MipChain;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};

/// An image in device memory, ready to be read by fragment shaders.
#[derive(Debug)]
pub struct SampledImage {
    gpu: Arc<Gpu>,
    image: Image,
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
        let kind = ImageKind {
            extent: vk::Extent2D { width, height },
            format: vk::Format::R8G8B8A8_SRGB,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
            aspects: vk::ImageAspectFlags::COLOR,
            levels: u32::try_from(levels.len()).unwrap_or(u32::MAX),
            shape: ImageShape::Flat,
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
        };
        let needed = if texels.is_filtered {
            vk::FormatFeatureFlags::SAMPLED_IMAGE
                | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR
        } else {
            vk::FormatFeatureFlags::SAMPLED_IMAGE
        };
        if !gpu.format_features(format).contains(needed) {
            let how = if texels.is_filtered {
                "filtering"
            } else {
                "reading"
            };
            let capability = format!("{how} of {name}");
            return Err(DeviceError::unsupported(&capability, &gpu.facts.name));
        }
        let [width, height] = texels.size;
        let extent = vk::Extent2D { width, height };
        let kind = ImageKind {
            extent,
            format,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
            aspects: vk::ImageAspectFlags::COLOR,
            levels: 1,
            shape: match texels.is_cube {
                true => ImageShape::Cube,
                false => ImageShape::Flat,
            },
        };
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
        if found > allowed {
            return Err(DeviceError::OverCapacity {
                what: format!("texels along a side of a {label}"),
                found: u64::from(found),
                allowed: u64::from(allowed),
            });
        }
        let image = Image::new(gpu, label, kind)?;
        let (mut texels, mut copies) = (Vec::new(), Vec::new());
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
            texels.resize(texels.len().next_multiple_of(8), 0);
            gpu.work.count_upload(bytes.len() as u64);
        }
        let staging = Buffer::staging(gpu, label, &texels)?;
        let to = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let barrier = |old_layout, new_layout| {
            vk::ImageMemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
                .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
                .old_layout(old_layout)
                .new_layout(new_layout)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(image.raw)
                .subresource_range(kind.whole())
        };
        let before = [barrier(vk::ImageLayout::UNDEFINED, to)];
        let after = [barrier(to, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        let none = vk::DependencyFlags::empty();
        // SAFETY: the buffer holds every level at its offset, the levels are the image's, and both
        // live until the submission is done.
        unsafe {
            gpu.submit(|device, commands| {
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &before);
                device.cmd_copy_buffer_to_image(commands, staging.raw, image.raw, to, &copies);
                device.cmd_pipeline_barrier(commands, all, all, none, &[], &[], &after);
            })?;
        }
        let bytes = sizes_of(&copies, kind.layers(), texel_bytes(kind.format));
        gpu.work.count_texture(bytes);
        Ok(Self {
            gpu: Arc::clone(gpu),
            image,
            bytes,
        })
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.image.view
    }

    /// Bytes of its texels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

fn sizes_of(copies: &[vk::BufferImageCopy], layers: u32, texel_bytes: u64) -> u64 {
    let texels = copies
        .iter()
        .map(|copy| u64::from(copy.image_extent.width) * u64::from(copy.image_extent.height));
    texels.sum::<u64>() * u64::from(layers) * texel_bytes
}

fn texel_bytes(format: vk::Format) -> u64 {
    match format {
        vk::Format::R8_UNORM => 1,
        vk::Format::R16_UNORM | vk::Format::R16_SFLOAT => 2,
        vk::Format::R32G32_SFLOAT => 8,
        _ => 4,
    }
}

/// A sampled image as a set of its own: the image at binding 0, its sampler, if it is filtered, at 1.
#[derive(Debug)]
pub struct ImageBindings {
    gpu: Arc<Gpu>,
    sampler: vk::Sampler,
    is_sampled: bool,
    pool: SetPool,
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
        let gpu = &image.gpu;
        let layout = gpu.fixtures.image_set_layout(address.is_some());
        let kinds = [
            vk::DescriptorType::SAMPLED_IMAGE,
            vk::DescriptorType::SAMPLER,
        ];
        let pool = SetPool::new(gpu, layout, &kinds[..1 + usize::from(address.is_some())])?;
        let mut bindings = Self {
            gpu: Arc::clone(gpu),
            sampler: vk::Sampler::null(),
            is_sampled: address.is_some(),
            pool,
            _image: Arc::clone(image),
        };
        if let Some([u, v]) = address {
            let info = vk::SamplerCreateInfo::default()
                .mag_filter(vk::Filter::LINEAR)
                .min_filter(vk::Filter::LINEAR)
                .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
                .address_mode_u(u)
                .address_mode_v(v)
                .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
                .max_lod(vk::LOD_CLAMP_NONE);
            // SAFETY: the structure lives through the call.
            bindings.sampler = unsafe { gpu.device.create_sampler(&info, None) }
                .map_err(|error| failure(error, "sampler", 0))?;
        }
        let images = [vk::DescriptorImageInfo {
            sampler: vk::Sampler::null(),
            image_view: image.image.view,
            image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        }];
        let samplers = [vk::DescriptorImageInfo {
            sampler: bindings.sampler,
            ..vk::DescriptorImageInfo::default()
        }];
        let write = |binding, kind, info| {
            vk::WriteDescriptorSet::default()
                .dst_set(bindings.pool.set)
                .dst_binding(binding)
                .descriptor_type(kind)
                .image_info(info)
        };
        let writes = [write(0, kinds[0], &images), write(1, kinds[1], &samplers)];
        // SAFETY: of the kinds that the layout has; image and sampler live as long as the set.
        unsafe {
            gpu.device
                .update_descriptor_sets(&writes[..1 + usize::from(bindings.is_sampled)], &[]);
        }
        Ok(bindings)
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }

    pub(crate) fn set(&self) -> vk::DescriptorSet {
        self.pool.set
    }

    /// Whether it has a sampler.
    #[must_use]
    pub fn is_sampled(&self) -> bool {
        self.is_sampled
    }
}

impl Drop for ImageBindings {
    fn drop(&mut self) {
        // SAFETY: every submission that used it has been waited for; null is ignored.
        unsafe { self.gpu.device.destroy_sampler(self.sampler, None) };
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
