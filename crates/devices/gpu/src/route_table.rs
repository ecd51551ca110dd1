// SPDX-License-Identifier: MIT OR Apache-2.0
//! What some coordinate routes read besides constants: a table of the arctangent, or a cube texture
//! of longitude and latitude. Group 3 of a textured cover, and 1 of a kernel.

use crate::Gpu;
use terrafill_contract::DeviceError;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};

/// A route's texture, bound: the texture at binding 0, its sampler at 1.
#[derive(Debug)]
pub(crate) struct RouteTable {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) group: wgpu::BindGroup,
    /// Of the texture.
    pub(crate) bytes: u64,
}

impl RouteTable {
    /// - `stage`: which reads it
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks the format or its filtering.
    pub(crate) fn new(
        gpu: &Gpu,
        texels: &RouteTexels,
        stage: wgpu::ShaderStages,
    ) -> Result<Self, DeviceError> {
        let label = "route";
        let is_filtered = texels.is_filtered;
        let (format, is_wide) = match texels.format {
            RouteTexelFormat::R8Unorm => (wgpu::TextureFormat::R8Unorm, false),
            RouteTexelFormat::R16Unorm => (wgpu::TextureFormat::R16Unorm, false),
            RouteTexelFormat::R16Float => (wgpu::TextureFormat::R16Float, false),
            RouteTexelFormat::R32Float => (wgpu::TextureFormat::R32Float, true),
            RouteTexelFormat::Rg32Float => (wgpu::TextureFormat::Rg32Float, true),
            RouteTexelFormat::Rgba32Float => (wgpu::TextureFormat::Rgba32Float, true),
        };
        if format == wgpu::TextureFormat::R16Unorm {
            let needed = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
            gpu.require(needed, "textures of 16-bit fractions")?;
        }
        if is_filtered && is_wide {
            let needed = wgpu::Features::FLOAT32_FILTERABLE;
            gpu.require(needed, "filtering of 32-bit floats")?;
        }
        let (faces, dimension) = if texels.is_cube {
            (6, wgpu::TextureViewDimension::Cube)
        } else {
            (1, wgpu::TextureViewDimension::D2)
        };
        let (filter, sampler) = if is_filtered {
            (
                wgpu::FilterMode::Linear,
                wgpu::SamplerBindingType::Filtering,
            )
        } else {
            let sampler = wgpu::SamplerBindingType::NonFiltering;
            (wgpu::FilterMode::Nearest, sampler)
        };
        let [width, height] = texels.size;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = gpu.texture(label, [width, height, faces], 1, format, usage);
        let bytes = texels.bytes.len() as u64;
        gpu.work.count_texture(bytes);
        gpu.work.count_upload(bytes);
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: format.block_copy_size(None).map(|texel| texel * width),
            rows_per_image: Some(height),
        };
        let (whole, size) = (texture.as_image_copy(), texture.size());
        gpu.queue.write_texture(whole, &texels.bytes, rows, size);
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            ..Default::default()
        });
        let types = [
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float {
                    filterable: is_filtered,
                },
                view_dimension: dimension,
                multisampled: false,
            },
            wgpu::BindingType::Sampler(sampler),
        ];
        let layout = gpu.mixed_layout(label, types.map(|ty| (stage, ty)));
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(label),
            mag_filter: filter,
            min_filter: filter,
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(&sampler),
        ];
        Ok(Self {
            group: gpu.bind(label, &layout, resources),
            layout,
            bytes,
        })
    }
}
