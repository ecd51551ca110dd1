// SPDX-License-Identifier: MIT OR Apache-2.0
//! What some coordinate routes read besides constants: a table of the arctangent, or a cube texture
//! of longitude and latitude. Group 3 of a textured cover.

use crate::Gpu;
use terrafill_frame::BackendError;
use terrafill_texture::{CubeTexture, Filter, LookupTable, Program, TexelFormat};

/// A route's texture, bound.
#[derive(Debug)]
pub(crate) struct RouteTable {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) group: wgpu::BindGroup,
    /// Of the texture.
    pub(crate) bytes: u64,
}

impl RouteTable {
    /// The table of `program`; `None` if it reads none.
    ///
    /// # Errors
    /// [`BackendError::Unsupported`] when the device lacks the format or its filtering.
    pub(crate) fn new(gpu: &Gpu, program: &Program) -> Result<Option<Self>, BackendError> {
        if let Some(table) = program.table() {
            return Self::lookup(gpu, table).map(Some);
        }
        program.cube().map(|cube| Self::cube(gpu, cube)).transpose()
    }

    fn lookup(gpu: &Gpu, table: &LookupTable) -> Result<Self, BackendError> {
        let format = match table.format() {
            TexelFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
            TexelFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
            TexelFormat::R16Float => wgpu::TextureFormat::R16Float,
            TexelFormat::R32Float => wgpu::TextureFormat::R32Float,
        };
        if format == wgpu::TextureFormat::R16Unorm {
            let needed = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
            require(gpu, needed, "textures of 16-bit fractions")?;
        }
        let is_sampled = table.filter() == Filter::Linear;
        if is_sampled && format == wgpu::TextureFormat::R32Float {
            let needed = wgpu::Features::FLOAT32_FILTERABLE;
            require(gpu, needed, "filtering of 32-bit floats")?;
        }
        let size = wgpu::Extent3d {
            width: u32::try_from(table.texels()).unwrap_or(u32::MAX),
            height: 1,
            depth_or_array_layers: 1,
        };
        let bytes = table.bytes();
        let texture = upload(gpu, format, size, &bytes);
        let view = texture.create_view(&Default::default());
        Ok(Self::bound(gpu, &view, bytes.len() as u64, is_sampled))
    }

    fn cube(gpu: &Gpu, cube: &CubeTexture) -> Result<Self, BackendError> {
        let needed = wgpu::Features::FLOAT32_FILTERABLE;
        require(gpu, needed, "filtering of 32-bit floats")?;
        let size = wgpu::Extent3d {
            width: cube.size(),
            height: cube.size(),
            depth_or_array_layers: 6,
        };
        let faces: Vec<[f32; 2]> = (0..6).flat_map(|face| cube.face(face)).collect();
        let bytes = bytemuck::cast_slice(&faces);
        let texture = upload(gpu, wgpu::TextureFormat::Rg32Float, size, bytes);
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::Cube),
            ..Default::default()
        });
        let layout_view = wgpu::TextureViewDimension::Cube;
        Ok(Self::bound_as(gpu, &view, cube.bytes(), layout_view, true))
    }

    fn bound(gpu: &Gpu, view: &wgpu::TextureView, bytes: u64, is_sampled: bool) -> Self {
        Self::bound_as(gpu, view, bytes, wgpu::TextureViewDimension::D2, is_sampled)
    }

    fn bound_as(
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

fn require(gpu: &Gpu, needed: wgpu::Features, capability: &str) -> Result<(), BackendError> {
    if gpu.device.features().contains(needed) {
        return Ok(());
    }
    Err(BackendError::unsupported(capability, &gpu.facts.name))
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
