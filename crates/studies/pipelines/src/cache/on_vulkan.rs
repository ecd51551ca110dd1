// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks on Vulkan itself: texels loaded from all that may keep them, bindless by descriptor indexing.

use super::keep::{Keep, Keeps, Store};
use super::queries::{Blocks, CacheConstants, SIDE, TexelQuery};
use crate::draws::Times;
use crate::on_vulkan::uniform;
use std::ops::Range;
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
    /// With their workgroups, one after the other.
    bound: Vec<(ComputePipeline, u32)>,
    answers: Arc<Buffer>,
}

fn texels(gpu: &Arc<Gpu>, keep: Keep, blocks: Blocks) -> Result<Texels, DeviceError> {
    let count = blocks.count();
    let image = |size, shape| BlockImage::new(gpu, size, shape).map(Arc::new);
    if keep.rounds() {
        return Err(gpu.lacks("a way that rounds, which is asked about on wgpu"));
    }
    Ok(match keep.store() {
        Store::Layers => Texels::One(image([SIDE; 2], ImageShape::Array(count))?),
        Store::Slices => Texels::One(image([SIDE; 2], ImageShape::Volume(count))?),
        Store::SideBySide => {
            let size = [SIDE * blocks.across, SIDE * blocks.down];
            Texels::One(image(size, ImageShape::Flat)?)
        }
        Store::Each => {
            let each = (0..count).map(|_| image([SIDE; 2], ImageShape::Flat));
            Texels::Each(each.collect::<Result<_, _>>()?)
        }
        Store::Buffer => {
            let size = u64::from(count) * BLOCK_BYTES;
            let buffer = Buffer::unwritten(gpu, "blocks", size, BufferUse::Storage)?;
            Texels::Buffer(Arc::new(buffer))
        }
    })
}

impl Cache {
    /// - `ranges`: the queries of each block, where blocks are bound in turn; else all of them
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        keep: Keep,
        blocks: Blocks,
        queries: &[TexelQuery],
        ranges: &[Range<u32>],
    ) -> Result<Self, DeviceError> {
        let texels = texels(gpu, keep, blocks)?;
        let bytes = bytemuck::cast_slice(queries);
        let asked = Buffer::upload(gpu, "queries", bytes, BufferUse::Storage)?;
        let asked = Resource::Storage(Arc::new(asked));
        let size = 4 * queries.len() as u64;
        let answers = Arc::new(Buffer::unwritten(gpu, "answers", size, BufferUse::State)?);
        let [path, entry_point] = keep.shader();
        let shader = Shader::Wgsl { path, entry_point };
        let mut bound: Vec<(ComputePipeline, u32)> = Vec::new();
        for (block, range) in ranges.iter().enumerate() {
            if range.is_empty() {
                continue;
            }
            let constants = CacheConstants::new(blocks, range.clone());
            let mut resources = vec![
                uniform(gpu, "cache", bytemuck::bytes_of(&constants))?,
                asked.clone(),
                Resource::Storage(Arc::clone(&answers)),
            ];
            let resources = match (&texels, keep) {
                (Texels::Each(images), Keep::Bindless) => {
                    Resources::with_array(gpu, resources, images.clone())?
                }
                (texels, _) => {
                    resources.push(match texels {
                        Texels::One(image) => Resource::Blocks(Arc::clone(image)),
                        Texels::Each(images) => Resource::Blocks(Arc::clone(&images[block])),
                        Texels::Buffer(buffer) => Resource::Storage(Arc::clone(buffer)),
                    });
                    Resources::new(gpu, resources)?
                }
            };
            let pipeline = match bound.first() {
                Some((first, _)) => first.rebound(&resources)?,
                None => ComputePipeline::new(gpu, &resources, shader)?,
            };
            bound.push((pipeline, (range.end - range.start).div_ceil(GROUP)));
        }
        let cache = Self {
            gpu: Arc::clone(gpu),
            keep,
            blocks,
            texels,
            bound,
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
        let steps: Vec<StateStep<'_>> = self
            .bound
            .iter()
            .map(|(pipeline, groups)| {
                StateStep::Dispatch(Dispatch {
                    pipeline,
                    groups: [*groups, 1, 1],
                })
            })
            .collect();
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

    fn binds(&self) -> usize {
        self.bound.len()
    }
}
