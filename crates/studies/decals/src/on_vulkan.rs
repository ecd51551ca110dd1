// SPDX-License-Identifier: MIT OR Apache-2.0
//! Data drawn on Vulkan itself, whose queries say how many samples they counted.

use crate::divided::{DecalConstants, Divided, TEXELS};
use crate::draws::{ADDRESSES, Draws, ranges, shader};
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture};
use terrafill_scene::ImageSize;
use terrafill_stencil::{RouteTexelFormat, RouteTexels};
use terrafill_vulkan::{
    Buffer, BufferUse, DirectDraw, DirectReport, DrawCall, DrawPipeline, Gpu, Measured,
    PrimitiveStages, RenderTargets, Resource, Resources, SampledImage, Shader, Topology,
    VertexFormat,
};

pub(crate) struct OnVulkan {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    pipeline: DrawPipeline,
    vertices: Buffer,
    constants: Arc<Buffer>,
    sent: DecalConstants,
    ranges: Vec<Range<u32>>,
}

/// Texels that say their own address.
pub(crate) fn addressed(gpu: &Arc<Gpu>) -> Result<Arc<SampledImage>, DeviceError> {
    let texels = RouteTexels {
        format: RouteTexelFormat::R32Float,
        is_filtered: false,
        size: [TEXELS; 2],
        is_cube: false,
        bytes: bytemuck::cast_slice(&ADDRESSES).to_vec(),
    };
    Ok(Arc::new(SampledImage::route(gpu, &texels)?))
}

impl OnVulkan {
    /// - `addressed`: as of [`addressed`]
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        divided: &Divided,
        addressed: Arc<SampledImage>,
    ) -> Result<Self, DeviceError> {
        let bytes = size_of::<DecalConstants>() as u64;
        let constants = Buffer::streamed(gpu, "decal constants", bytes, BufferUse::Uniform)?;
        let constants = Arc::new(constants);
        let resources = vec![
            Resource::Uniform(Arc::clone(&constants)),
            Resource::Image(addressed),
        ];
        let resources = Resources::new(gpu, resources)?;
        let shader = |entry_point| Shader::Wgsl {
            path: shader(divided),
            entry_point,
        };
        let stages = PrimitiveStages::Vertices {
            vertex: shader("vertex_main"),
            geometry: None,
            format: VertexFormat::Metres,
            topology: Topology::Triangles,
        };
        let side = divided.eye.side;
        Ok(Self {
            targets: RenderTargets::new(gpu, ImageSize::new(side, side))?,
            pipeline: DrawPipeline::new(gpu, &resources, stages, shader("fragment_main"))?,
            vertices: uploaded(gpu, divided)?,
            constants,
            sent: divided.constants(),
            ranges: ranges(divided),
            gpu: Arc::clone(gpu),
        })
    }

    fn draw(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        self.constants.stream(bytemuck::bytes_of(&self.sent))?;
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: Some(&self.vertices),
            call: DrawCall::Vertices(&self.ranges),
        };
        self.targets.draw_directly(None, &draw, measured)
    }
}

fn uploaded(gpu: &Arc<Gpu>, divided: &Divided) -> Result<Buffer, DeviceError> {
    let vertices = divided.vertices();
    let bytes = bytemuck::cast_slice(&vertices);
    Buffer::upload(gpu, "decal", bytes, BufferUse::Vertex)
}

impl Draws for OnVulkan {
    fn frame(&mut self) -> Result<Option<f64>, DeviceError> {
        Ok(self.draw(Measured::Times)?.gpu_ms)
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
        let samples = self.draw(Measured::Samples)?.samples;
        let counted = samples.and_then(|samples| samples.last().copied());
        counted
            .ok_or_else(|| DeviceError::unsupported("occlusionQueryPrecise", &self.gpu.facts.name))
    }
}
