// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks on wgpu, which has all that may keep them; bindless arrays where the device indexes them freely.

use super::keep::{Keep, Keeps, Store};
use super::queries::{Blocks, CacheConstants, SIDE, TexelQuery};
use crate::draws::{Times, count};
use crate::on_wgpu::{compute_pipeline, storage_type, texture_type, uniform_type};
use std::num::NonZeroU32;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_gpu::{Gpu, PassTimer, TimedPass, read_buffer};

const GROUP: u32 = 64;
const TEXEL_BYTES: u32 = 4;

/// What holds the texels.
enum Texels {
    /// One texture, blocks in its layers, in its slices or side by side.
    One(wgpu::Texture),
    /// One a block.
    Each(Vec<wgpu::Texture>),
    Buffer(wgpu::Buffer),
}

/// Blocks kept in one way, and what is looked up in them.
pub(super) struct Cache {
    gpu: Arc<Gpu>,
    keep: Keep,
    blocks: Blocks,
    texels: Texels,
    pipeline: wgpu::ComputePipeline,
    bound: wgpu::BindGroup,
    groups: u32,
    /// The array of textures, which may not stand beside a uniform.
    bindless: Option<wgpu::BindGroup>,
    answers: wgpu::Buffer,
    timer: Option<PassTimer>,
}

/// Refuses what the device has no room for.
fn check(gpu: &Gpu, keep: Keep, blocks: Blocks) -> Result<(), DeviceError> {
    let limits = gpu.device.limits();
    let (what, found, allowed) = match keep.store() {
        Store::Layers => (
            "layers of an array texture",
            blocks.count(),
            limits.max_texture_array_layers,
        ),
        Store::SideBySide => (
            "texels along a side of an atlas",
            SIDE * blocks.across.max(blocks.down),
            limits.max_texture_dimension_2d,
        ),
        Store::Slices => (
            "slices of a volume texture",
            blocks.count(),
            limits.max_texture_dimension_3d,
        ),
        Store::Each if keep == Keep::Bindless => {
            let needed = wgpu::Features::TEXTURE_BINDING_ARRAY
                | wgpu::Features::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING;
            gpu.require(needed, "freely indexed arrays of textures")?;
            let allowed = limits
                .max_binding_array_elements_per_shader_stage
                .min(limits.max_sampled_textures_per_shader_stage);
            ("textures of a bindless array", blocks.count(), allowed)
        }
        Store::Each | Store::Buffer => return Ok(()),
    };
    DeviceError::check_capacity(what, found, allowed)
}

impl Cache {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        keep: Keep,
        blocks: Blocks,
        queries: &[TexelQuery],
    ) -> Result<Self, DeviceError> {
        check(gpu, keep, blocks)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let asked = gpu.upload("queries", bytemuck::cast_slice(queries), storage)?;
        let answer_bytes = 4 * queries.len() as u64;
        let copied = storage | wgpu::BufferUsages::COPY_SRC;
        let answers = gpu.unwritten("answers", answer_bytes, copied);
        let texels = texels(gpu, keep, blocks)?;
        let layout = layout(gpu, keep);
        let of_array = (keep == Keep::Bindless).then(|| array_layout(gpu, blocks));
        let [path, entry_point] = keep.shader();
        let mut layouts = vec![Some(&layout)];
        layouts.extend(of_array.as_ref().map(Some));
        let pipeline = compute_pipeline(gpu, path, entry_point, &layouts)?;
        let views: Vec<wgpu::TextureView> = match &texels {
            Texels::One(texture) => {
                let is_array = keep.store() == Store::Layers;
                // A single layer is an array too.
                let dimension = is_array.then_some(wgpu::TextureViewDimension::D2Array);
                vec![texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension,
                    ..Default::default()
                })]
            }
            Texels::Each(textures) => {
                let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
                textures.iter().map(view).collect()
            }
            Texels::Buffer(_) => Vec::new(),
        };
        let references: Vec<&wgpu::TextureView> = views.iter().collect();
        let bindless = of_array.as_ref().map(|layout| {
            let textures = [wgpu::BindingResource::TextureViewArray(&references)];
            gpu.bind("pipelines", layout, textures)
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("nearest texel, clamped to the edge"),
            ..Default::default()
        });
        let constants = CacheConstants::new(blocks, count(queries));
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("cache", bytes, wgpu::BufferUsages::UNIFORM)?;
        let of_blocks = match (&texels, keep) {
            (Texels::Buffer(buffer), _) => Some(buffer.as_entire_binding()),
            (_, Keep::Bindless) => None,
            _ => Some(wgpu::BindingResource::TextureView(&views[0])),
        };
        let mut resources = vec![
            constants.as_entire_binding(),
            asked.as_entire_binding(),
            answers.as_entire_binding(),
        ];
        resources.extend(of_blocks);
        if has_sampler(keep) {
            resources.push(wgpu::BindingResource::Sampler(&sampler));
        }
        let bound = gpu.bind("pipelines", &layout, resources);
        let cache = Self {
            gpu: Arc::clone(gpu),
            keep,
            blocks,
            texels,
            pipeline,
            bound,
            groups: count(queries).div_ceil(GROUP),
            bindless,
            answers,
            timer: PassTimer::new(gpu),
        };
        for block in 0..blocks.count() {
            cache.write(block, &Blocks::texels(block, 0));
        }
        Ok(cache)
    }

    /// Writes a block; done when the device next is.
    fn write(&self, block: u32, texels: &[f32]) {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        let (texture, origin) = match &self.texels {
            Texels::Buffer(buffer) => {
                let offset = u64::from(block) * bytes.len() as u64;
                self.gpu.write_buffer(buffer, offset, bytes);
                return;
            }
            Texels::Each(textures) => (&textures[block as usize], wgpu::Origin3d::ZERO),
            Texels::One(texture) => {
                let [x, y, z] = self.keep.store().first_texel(block, self.blocks);
                let origin = wgpu::Origin3d { x, y, z };
                (texture, origin)
            }
        };
        let place = wgpu::TexelCopyTextureInfo {
            origin,
            ..texture.as_image_copy()
        };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(TEXEL_BYTES * SIDE),
            rows_per_image: Some(SIDE),
        };
        let size = wgpu::Extent3d {
            width: SIDE,
            height: SIDE,
            depth_or_array_layers: 1,
        };
        self.gpu.queue.write_texture(place, bytes, layout, size);
    }
}

impl Keeps for Cache {
    fn look_up(&self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let timer = self.timer.as_ref();
        let writes = timer.map(|timer| timer.around_compute(TimedPass::Surface));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("look up"),
            timestamp_writes: writes,
        });
        pass.set_pipeline(&self.pipeline);
        if let Some(textures) = &self.bindless {
            pass.set_bind_group(1, textures, &[]);
        }
        pass.set_bind_group(0, &self.bound, &[]);
        pass.dispatch_workgroups(self.groups, 1, 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        let times = Times::since(&watch, None);
        let timed = timer.map(|timer| timer.pass_ms(&self.gpu, TimedPass::Surface));
        let gpu_ms = timed.transpose()?.flatten();
        Ok(Times { gpu_ms, ..times })
    }

    fn update(&self, block: u32, texels: &[f32]) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.write(block, texels);
        self.gpu.queue.submit([]);
        self.gpu.wait()?;
        Ok(Times::since(&watch, None))
    }

    fn read(&self) -> Result<Vec<f32>, DeviceError> {
        let bytes = read_buffer(&self.gpu, &self.answers)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

fn has_sampler(keep: Keep) -> bool {
    !matches!(keep, Keep::Bindless | Keep::Buffer)
}

fn array_layout(gpu: &Gpu, blocks: Blocks) -> wgpu::BindGroupLayout {
    let textures = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: texture_type(wgpu::TextureViewDimension::D2),
        count: NonZeroU32::new(blocks.count()),
    };
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("pipelines"),
            entries: &[textures],
        })
}

fn layout(gpu: &Gpu, keep: Keep) -> wgpu::BindGroupLayout {
    let stage = wgpu::ShaderStages::COMPUTE;
    let of_blocks = match keep.store() {
        Store::Layers => texture_type(wgpu::TextureViewDimension::D2Array),
        Store::Slices => texture_type(wgpu::TextureViewDimension::D3),
        Store::Buffer => storage_type(true),
        Store::SideBySide | Store::Each => texture_type(wgpu::TextureViewDimension::D2),
    };
    let mut types = vec![uniform_type(), storage_type(true), storage_type(false)];
    if keep != Keep::Bindless {
        types.push(of_blocks);
    }
    if has_sampler(keep) {
        let nearest = wgpu::SamplerBindingType::NonFiltering;
        types.push(wgpu::BindingType::Sampler(nearest));
    }
    gpu.mixed_layout("pipelines", types.into_iter().map(|ty| (stage, ty)))
}

fn texels(gpu: &Gpu, keep: Keep, blocks: Blocks) -> Result<Texels, DeviceError> {
    let texture = |[width, height, depth_or_array_layers]: [u32; 3], dimension| {
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
    };
    let flat = wgpu::TextureDimension::D2;
    let blocks_held = blocks.count();
    Ok(match keep.store() {
        Store::Layers => Texels::One(texture([SIDE, SIDE, blocks_held], flat)),
        Store::SideBySide => {
            Texels::One(texture([SIDE * blocks.across, SIDE * blocks.down, 1], flat))
        }
        Store::Slices => Texels::One(texture(
            [SIDE, SIDE, blocks_held],
            wgpu::TextureDimension::D3,
        )),
        Store::Each => {
            let each = (0..blocks_held).map(|_| texture([SIDE, SIDE, 1], flat));
            Texels::Each(each.collect())
        }
        Store::Buffer => {
            let size = u64::from(blocks_held * SIDE * SIDE * TEXEL_BYTES);
            let allowed = gpu.device.limits().max_storage_buffer_binding_size;
            DeviceError::check_capacity("bytes of blocks", size, allowed)?;
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            Texels::Buffer(gpu.unwritten("blocks", size, usage))
        }
    })
}
