// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks on wgpu. Blocks that have a texture each have a bind group each, set between draws of one
//! pass.

use super::ground::{BlockGround, shader};
use crate::cache::keep::{Keep, Store};
use crate::draws::{Counted, Draws, Times};
use crate::on_wgpu::{texture_type, uniform_type};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_gpu::{DirectPipeline, Gpu, RenderTargets};
use terrafill_scene::ImageSize;

/// Ground on wgpu.
pub(super) struct OnWgpu {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    pipeline: wgpu::RenderPipeline,
    /// What each draw finds, and its vertices.
    draws: Vec<(wgpu::BindGroup, Range<u32>)>,
}

/// Of blocks.
fn texture(
    gpu: &Gpu,
    [width, height, depth_or_array_layers]: [u32; 3],
    dimension: wgpu::TextureDimension,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("blocks"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Writes heights of a block; done when the device next is.
fn write(gpu: &Gpu, texture: &wgpu::Texture, [x, y, z]: [u32; 3], side: u32, heights: &[f32]) {
    let place = wgpu::TexelCopyTextureInfo {
        origin: wgpu::Origin3d { x, y, z },
        ..texture.as_image_copy()
    };
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * side),
        rows_per_image: Some(side),
    };
    let size = wgpu::Extent3d {
        width: side,
        height: side,
        depth_or_array_layers: 1,
    };
    let bytes = bytemuck::cast_slice(heights);
    gpu.queue.write_texture(place, bytes, rows, size);
}

impl OnWgpu {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        keep: Keep,
        ground: &BlockGround,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let path = shader(keep, "wgpu")?;
        let limits = gpu.device.limits();
        let (side, blocks) = (ground.samples(), ground.blocks());
        let flat = wgpu::TextureDimension::D2;
        let atlas_side = side * ground.across;
        let (texels, dimension, view, checked) = match keep.store() {
            Store::Layers => (
                [side, side, blocks],
                flat,
                wgpu::TextureViewDimension::D2Array,
                (
                    "layers of an array texture",
                    blocks,
                    limits.max_texture_array_layers,
                ),
            ),
            Store::SideBySide => (
                [atlas_side, atlas_side, 1],
                flat,
                wgpu::TextureViewDimension::D2,
                (
                    "texels along a side of an atlas",
                    atlas_side,
                    limits.max_texture_dimension_2d,
                ),
            ),
            Store::Slices => (
                [side, side, blocks],
                wgpu::TextureDimension::D3,
                wgpu::TextureViewDimension::D3,
                (
                    "slices of a volume texture",
                    blocks,
                    limits.max_texture_dimension_3d,
                ),
            ),
            Store::Each | Store::Buffer => (
                [side, side, 1],
                flat,
                wgpu::TextureViewDimension::D2,
                (
                    "texels along a side of a block",
                    side,
                    limits.max_texture_dimension_2d,
                ),
            ),
        };
        let (what, found, allowed) = checked;
        DeviceError::check_capacity(what, found, allowed)?;
        let count = if keep.store() == Store::Each {
            blocks
        } else {
            1
        };
        let textures: Vec<_> = (0..count)
            .map(|_| texture(gpu, texels, dimension))
            .collect();
        for block in 0..blocks {
            let holds = &textures[(block % count) as usize];
            let first = ground.first_texel(keep.store(), block);
            write(gpu, holds, first, side, &ground.heights(block));
        }
        let constants = ground.constants();
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("ground in blocks", bytes, wgpu::BufferUsages::UNIFORM)?;
        let types = [uniform_type(), texture_type(view)];
        let layout = gpu.mixed_layout("blocks", types.map(|ty| (wgpu::ShaderStages::VERTEX, ty)));
        let bind = |texture: &wgpu::Texture| {
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(view),
                ..Default::default()
            });
            let view = wgpu::BindingResource::TextureView(&view);
            gpu.bind("blocks", &layout, [constants.as_entire_binding(), view])
        };
        let draws = textures.iter().map(bind).zip(ground.ranges(keep));
        Ok(Self {
            targets: RenderTargets::new(gpu, size)?,
            pipeline: gpu.direct_pipeline(&DirectPipeline {
                path,
                entry_point: "vertex_main",
                topology: wgpu::PrimitiveTopology::TriangleList,
                format: None,
                layout: &layout,
            })?,
            draws: draws.collect(),
            gpu: Arc::clone(gpu),
        })
    }

    fn frame(&mut self) -> Result<(), DeviceError> {
        let mut frame = self.targets.direct_frame();
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_pipeline(&self.pipeline);
        for (bound, vertices) in &self.draws {
            pass.set_bind_group(0, bound, &[]);
            pass.draw(vertices.clone(), 0..1);
        }
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()
    }
}

impl Draws for OnWgpu {
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError> {
        self.frame()?;
        Ok((self.targets.read()?, Counted::default()))
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.frame()?;
        let times = Times::since(&watch, None);
        let gpu_ms = self.targets.direct_ms()?;
        Ok(Times { gpu_ms, ..times })
    }
}
