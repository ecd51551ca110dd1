// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks on Vulkan itself: texels loaded from all that may keep them, bindless by descriptor indexing.

use super::keep::{Keep, Keeps, Store};
use super::queries::{Blocks, CacheConstants, SIDE, TexelQuery};
use crate::draws::{Times, count};
use crate::on_vulkan::uniform;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_vulkan::{
    BlockImage, Buffer, BufferUse, ComputePipeline, Dispatch, Gpu, ImageShape, Resource, Resources,
    Shader, StateStep, advance,
};

const GROUP: u32 = 64;
const BLOCK_BYTES: u64 = 4 * SIDE as u64 * SIDE as u64;

/// What holds the texels.
enum Texels {
    /// One image, blocks in its layers, in its slices or side by side.
    One(Arc<BlockImage>),
    /// One a block.
    Each(Vec<Arc<BlockImage>>),
    Buffer(Arc<Buffer>),
}

/// Blocks kept in one way, and what is looked up in them.
pub(super) struct Cache {
    gpu: Arc<Gpu>,
    keep: Keep,
    blocks: Blocks,
    texels: Texels,
    pipeline: ComputePipeline,
    groups: u32,
    answers: Arc<Buffer>,
}

fn texels(gpu: &Arc<Gpu>, keep: Keep, blocks: Blocks) -> Result<Texels, DeviceError> {
    let held = blocks.count();
    let image = |size, shape| BlockImage::new(gpu, size, shape).map(Arc::new);
    if keep.rounds() {
        return Err(gpu.lacks("a way that rounds, which is asked about on wgpu"));
    }
    Ok(match keep.store() {
        Store::Layers => Texels::One(image([SIDE; 2], ImageShape::Array(held))?),
        Store::Slices => Texels::One(image([SIDE; 2], ImageShape::Volume(held))?),
        Store::SideBySide => {
            let size = [SIDE * blocks.across, SIDE * blocks.down];
            Texels::One(image(size, ImageShape::Flat)?)
        }
        Store::Each => {
            let each = (0..held).map(|_| image([SIDE; 2], ImageShape::Flat));
            Texels::Each(each.collect::<Result<_, _>>()?)
        }
        Store::Buffer => {
            let size = u64::from(held) * BLOCK_BYTES;
            let buffer = Buffer::unwritten(gpu, "blocks", size, BufferUse::Storage)?;
            Texels::Buffer(Arc::new(buffer))
        }
    })
}

impl Cache {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        keep: Keep,
        blocks: Blocks,
        queries: &[TexelQuery],
    ) -> Result<Self, DeviceError> {
        let texels = texels(gpu, keep, blocks)?;
        let bytes = bytemuck::cast_slice(queries);
        let asked = Buffer::upload(gpu, "queries", bytes, BufferUse::Storage)?;
        let asked = Resource::Storage(Arc::new(asked));
        let size = 4 * queries.len() as u64;
        let answers = Arc::new(Buffer::unwritten(gpu, "answers", size, BufferUse::State)?);
        let [path, entry_point] = keep.shader();
        let shader = Shader::Wgsl { path, entry_point };
        let constants = CacheConstants::new(blocks, count(queries));
        let mut resources = vec![
            uniform(gpu, "cache", bytemuck::bytes_of(&constants))?,
            asked,
            Resource::Storage(Arc::clone(&answers)),
        ];
        let resources = match &texels {
            Texels::Each(images) => Resources::with_array(gpu, resources, images.clone())?,
            Texels::One(image) => {
                resources.push(Resource::Blocks(Arc::clone(image)));
                Resources::new(gpu, resources)?
            }
            Texels::Buffer(buffer) => {
                resources.push(Resource::Storage(Arc::clone(buffer)));
                Resources::new(gpu, resources)?
            }
        };
        let pipeline = ComputePipeline::new(gpu, &resources, shader)?;
        let cache = Self {
            gpu: Arc::clone(gpu),
            keep,
            blocks,
            texels,
            pipeline,
            groups: count(queries).div_ceil(GROUP),
            answers,
        };
        for block in 0..blocks.count() {
            cache.write(block, &Blocks::texels(block, 0))?;
        }
        Ok(cache)
    }

    fn write(&self, block: u32, texels: &[f32]) -> Result<(), DeviceError> {
        match &self.texels {
            Texels::Each(images) => images[block as usize].write([0; 3], [SIDE; 2], texels),
            Texels::One(image) => {
                let first = self.keep.store().first_texel(block, self.blocks);
                image.write(first, [SIDE; 2], texels)
            }
            Texels::Buffer(buffer) => {
                let offset = u64::from(block) * BLOCK_BYTES;
                buffer.rewrite_parts(&[(offset, bytemuck::cast_slice(texels))])
            }
        }
    }
}

impl Keeps for Cache {
    fn look_up(&self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let steps = [StateStep::Dispatch(Dispatch {
            pipeline: &self.pipeline,
            groups: [self.groups, 1, 1],
        })];
        let report = advance(&self.gpu, &steps)?;
        Ok(Times::since(&watch, report.gpu_ms))
    }

    fn update(&self, block: u32, texels: &[f32]) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        self.write(block, texels)?;
        Ok(Times::since(&watch, None))
    }

    fn read(&self) -> Result<Vec<f32>, DeviceError> {
        let bytes = self.answers.contents(&self.gpu)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}
