// SPDX-License-Identifier: MIT OR Apache-2.0
//! What some coordinate routes read besides constants: a table of the arctangent, or a cube texture
//! of longitude and latitude. Group 3 of a textured cover.

use crate::Gpu;
use terrafill_contract::DeviceError;
use terrafill_stencil::{RouteTexelFormat, RouteTexels, TexturedCover};

/// A route's texture, bound.
#[derive(Debug)]
pub(crate) struct RouteTable {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) group: wgpu::BindGroup,
    /// Of the texture.
    pub(crate) bytes: u64,
}

impl RouteTable {
    /// The table that a cover's route reads; `None` if it reads none.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks the format or its filtering.
    pub(crate) fn new(gpu: &Gpu, cover: &TexturedCover) -> Result<Option<Self>, DeviceError> {
        let table = |texels| Self::upload(gpu, &texels);
        cover.route_texels().map(table).transpose()
    }

    fn upload(gpu: &Gpu, texels: &RouteTexels) -> Result<Self, DeviceError> {
        let format = match texels.format {
            RouteTexelFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
            RouteTexelFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
            RouteTexelFormat::R16Float => wgpu::TextureFormat::R16Float,
            RouteTexelFormat::R32Float => wgpu::TextureFormat::R32Float,
            RouteTexelFormat::Rg32Float => wgpu::TextureFormat::Rg32Float,
        };
        if format == wgpu::TextureFormat::R16Unorm {
            let needed = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
            require(gpu, needed, "textures of 16-bit fractions")?;
        }
        let is_wide = [RouteTexelFormat::R32Float, RouteTexelFormat::Rg32Float];
        if texels.is_filtered && is_wide.contains(&texels.format) {
            let needed = wgpu::Features::FLOAT32_FILTERABLE;
            require(gpu, needed, "filtering of 32-bit floats")?;
        }
        let (faces, dimension) = if texels.is_cube {
            (6, wgpu::TextureViewDimension::Cube)
        } else {
            (1, wgpu::TextureViewDimension::D2)
        };
        let size = wgpu::Extent3d {
            width: texels.size[0],
            height: texels.size[1],
            depth_or_array_layers: faces,
        };
        let texture = upload(gpu, format, size, &texels.bytes);
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            ..Default::default()
        });
        let bytes = texels.bytes.len() as u64;
        Ok(Self::bound(
            gpu,
            &view,
            bytes,
            dimension,
            texels.is_filtered,
        ))
    }

    fn bound(
        gpu: &Gpu,
        view: &wgpu::TextureView,
        bytes: u64,
        view_dimension: wgpu::TextureViewDimension,
        is_sampled: bool,
    ) -> Self {
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float {
                filterable: is_sampled,
            },
            view_dimension,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let types = [texture, sampler];
        let layout = gpu.fragment_layout("route", &types[..1 + usize::from(is_sampled)]);
        let linear = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("route"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let entries = [
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(view),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(&linear),
            },
        ];
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("route"),
            layout: &layout,
            entries: &entries[..1 + usize::from(is_sampled)],
        });
        Self {
            layout,
            group,
            bytes,
        }
    }
}

fn require(gpu: &Gpu, needed: wgpu::Features, capability: &str) -> Result<(), DeviceError> {
    if gpu.device.features().contains(needed) {
        return Ok(());
    }
    Err(DeviceError::unsupported(capability, &gpu.facts.name))
}

fn upload(
    gpu: &Gpu,
    format: wgpu::TextureFormat,
    size: wgpu::Extent3d,
    bytes: &[u8],
) -> wgpu::Texture {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("route"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.work.count_texture(bytes.len() as u64);
    gpu.work.count_upload(bytes.len() as u64);
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: format
                .block_copy_size(None)
                .map(|texel_bytes| texel_bytes * size.width),
            rows_per_image: Some(size.height),
        },
        size,
    );
    texture
}
