// SPDX-License-Identifier: MIT OR Apache-2.0
//! Data drawn on wgpu.

use crate::divided::{DecalConstants, Divided, TEXELS};
use crate::draws::{ADDRESSES, Draws, ranges, shader};
use glam::DVec4;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture};
use terrafill_gpu::{DirectPipeline, Gpu, RenderTargets, read_buffer};
use terrafill_scene::ImageSize;

pub(crate) struct OnWgpu {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    constants: wgpu::Buffer,
    sent: DecalConstants,
    ranges: Vec<Range<u32>>,
}

fn buffer_type(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

impl OnWgpu {
    /// - `addressed`: as of [`addressed`]
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        divided: &Divided,
        addressed: &wgpu::Texture,
    ) -> Result<Self, DeviceError> {
        let bytes = size_of::<DecalConstants>() as u64;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let constants = gpu.unwritten("decal constants", bytes, usage);
        let texture = addressed.create_view(&Default::default());
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let picture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let uniform = buffer_type(wgpu::BufferBindingType::Uniform);
        let types = [
            (wgpu::ShaderStages::VERTEX | fragment, uniform),
            (fragment, picture),
        ];
        let layout = gpu.mixed_layout("decal", types);
        let resources = [
            constants.as_entire_binding(),
            wgpu::BindingResource::TextureView(&texture),
        ];
        let side = divided.eye.side;
        Ok(Self {
            pipeline: gpu.direct_pipeline(&DirectPipeline {
                path: shader(divided),
                entry_point: "vertex_main",
                topology: wgpu::PrimitiveTopology::TriangleList,
                format: Some(wgpu::VertexFormat::Float32x3),
                layout: &layout,
            })?,
            bound: gpu.bind("decal", &layout, resources),
            vertices: uploaded(gpu, divided)?,
            constants,
            sent: divided.constants(),
            ranges: ranges(divided),
            targets: RenderTargets::new(gpu, ImageSize::new(side, side))?,
            gpu: Arc::clone(gpu),
        })
    }
}

fn uploaded(gpu: &Gpu, divided: &Divided) -> Result<wgpu::Buffer, DeviceError> {
    let vertices = divided.vertices();
    gpu.upload(
        "decal",
        bytemuck::cast_slice(&vertices),
        wgpu::BufferUsages::VERTEX,
    )
}

impl Draws for OnWgpu {
    fn frame(&mut self) -> Result<Option<f64>, DeviceError> {
        let bytes = bytemuck::bytes_of(&self.sent);
        self.gpu.write_buffer(&self.constants, 0, bytes);
        let mut frame = self.targets.direct_frame();
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bound, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        for range in &self.ranges {
            pass.draw(range.clone(), 0..1);
        }
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()?;
        self.targets.direct_ms()
    }

    fn read(&self) -> Result<Picture, DeviceError> {
        self.targets.read()
    }

    fn divide(&mut self, divided: &Divided) -> Result<(), DeviceError> {
        self.vertices = uploaded(&self.gpu, divided)?;
        self.sent = divided.constants();
        self.ranges = ranges(divided);
        Ok(())
    }

    fn count(&mut self) -> Result<u64, DeviceError> {
        let what = "numbers of samples by occlusion queries";
        Err(DeviceError::unsupported(what, "WebGPU"))
    }
}

/// Texels that say their own address.
pub(crate) fn addressed(gpu: &Gpu) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let format = wgpu::TextureFormat::R32Float;
    let texture = gpu.texture("addresses", [TEXELS, TEXELS, 1], 1, format, usage);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * TEXELS),
        rows_per_image: None,
    };
    let bytes = bytemuck::cast_slice(&ADDRESSES);
    gpu.queue
        .write_texture(texture.as_image_copy(), bytes, layout, texture.size());
    texture
}

/// Clip positions of a decal's vertices as the device's arithmetic has them.
pub(crate) fn clips(gpu: &Arc<Gpu>, divided: &Divided) -> Result<Vec<DVec4>, DeviceError> {
    let constants = divided.constants();
    let bytes = bytemuck::bytes_of(&constants);
    let constants = gpu.upload("decal constants", bytes, wgpu::BufferUsages::UNIFORM)?;
    let vertices = divided.vertices();
    let storage = wgpu::BufferUsages::STORAGE;
    let sent = gpu.upload("decal", bytemuck::cast_slice(&vertices), storage)?;
    let bytes = 16 * vertices.len() as u64;
    let clips = gpu.unwritten(
        "clip positions",
        bytes,
        storage | wgpu::BufferUsages::COPY_SRC,
    );
    let types = [
        wgpu::BufferBindingType::Uniform,
        wgpu::BufferBindingType::Storage { read_only: true },
        wgpu::BufferBindingType::Storage { read_only: false },
    ];
    let layout = gpu.buffer_layout("places", wgpu::ShaderStages::COMPUTE, &types);
    let bound = gpu.bind_buffers("places", &layout, &[&constants, &sent, &clips]);
    let module = gpu.shader("decals/places.wgsl")?;
    let pipeline = gpu.compute_pipeline("places", &module, "place_main", &[Some(&layout)], &[]);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bound, &[]);
    pass.dispatch_workgroups(
        u32::try_from(vertices.len().div_ceil(64)).unwrap_or(1),
        1,
        1,
    );
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let bytes = read_buffer(gpu, &clips)?;
    let clips: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
    Ok(clips
        .into_iter()
        .map(|clip| DVec4::from(clip.map(f64::from)))
        .collect())
}
