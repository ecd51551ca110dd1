// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ground drawn from its blocks on Vulkan itself. Blocks that have an image each have a descriptor set each, bound
//! between draws of one pass; bindless ones are an array of images.

use super::ground::{BlockGround, shader};
use crate::cache::keep::{Keep, Store};
use crate::draws::{Counted, Draws, Times};
use crate::on_vulkan::{numbered, uniform, wgsl};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError, Picture};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    BlockImage, DirectDraw, DirectReport, DrawCall, DrawPipeline, Gpu, ImageShape, Measured,
    RenderTargets, Resource, Resources, Topology,
};

/// Ground on Vulkan.
pub(super) struct OnVulkan {
    targets: RenderTargets,
    pipeline: DrawPipeline,
    /// What each draw finds, and its vertices.
    draws: Vec<(Arc<Resources>, Range<u32>)>,
}

fn images(
    gpu: &Arc<Gpu>,
    keep: Keep,
    ground: &BlockGround,
) -> Result<Vec<Arc<BlockImage>>, DeviceError> {
    let (side, blocks) = (ground.samples(), ground.blocks());
    let (size, shape, count) = match keep.store() {
        Store::Layers => ([side; 2], ImageShape::Array(blocks), 1),
        Store::Slices => ([side; 2], ImageShape::Volume(blocks), 1),
        Store::SideBySide => ([side * ground.across; 2], ImageShape::Flat, 1),
        Store::Each | Store::Buffer => ([side; 2], ImageShape::Flat, blocks),
    };
    let images = (0..count).map(|_| BlockImage::new(gpu, size, shape).map(Arc::new));
    let images: Vec<Arc<BlockImage>> = images.collect::<Result<_, _>>()?;
    for block in 0..blocks {
        let first = ground.first_texel(keep.store(), block);
        let image = &images[(block % count) as usize];
        image.write(first, [side; 2], &ground.heights(block))?;
    }
    Ok(images)
}

impl OnVulkan {
    pub(super) fn new(
        gpu: &Arc<Gpu>,
        keep: Keep,
        ground: &BlockGround,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let path = shader(keep, &gpu.facts.name)?;
        let images = images(gpu, keep, ground)?;
        let constants = ground.constants();
        let constants = uniform(gpu, "ground in blocks", bytemuck::bytes_of(&constants))?;
        let bound = if keep == Keep::Bindless {
            vec![Resources::with_array(gpu, vec![constants], images)?]
        } else {
            let bind = |image| {
                let resources = vec![constants.clone(), Resource::Blocks(image)];
                Resources::new(gpu, resources)
            };
            images.into_iter().map(bind).collect::<Result<_, _>>()?
        };
        let stages = numbered(wgsl(path, "vertex_main"), None, Topology::Triangles);
        let fragment = wgsl(path, "fragment_main");
        Ok(Self {
            targets: RenderTargets::new(gpu, size)?,
            pipeline: DrawPipeline::new(gpu, &bound[0], stages, fragment)?,
            draws: bound.into_iter().zip(ground.ranges(keep)).collect(),
        })
    }

    fn frame(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call: DrawCall::Rebound(&self.draws),
        };
        self.targets.draw_directly(None, &draw, measured)
    }
}

impl Draws for OnVulkan {
    fn draw(&mut self) -> Result<(Picture, Counted), DeviceError> {
        let report = self.frame(Measured::Statistics)?;
        Ok((self.targets.read()?, Counted::from(report.statistics)))
    }

    fn time(&mut self) -> Result<Times, DeviceError> {
        let watch = CpuStopwatch::start();
        let report = self.frame(Measured::Times)?;
        Ok(Times::since(&watch, report.gpu_ms))
    }
}
