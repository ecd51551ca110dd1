// SPDX-License-Identifier: MIT OR Apache-2.0
//! Maps of all lights by one way, and the picture, on Vulkan itself, which has every stage.

use super::scene::{DistantLight, LightConstants};
use super::way::LightWay;
use crate::draws::{Counted, Times};
use crate::grid::{Grid, GridConstants, View};
use std::sync::Arc;
use terrafill_fill::{CpuStopwatch, DeviceError, Picture, RouteTexelFormat, RouteTexels};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    Buffer, BufferUse, DirectDraw, DrawCall, DrawPipeline, Gpu, LayerPipeline, LayeredDepth,
    Measured, PrimitiveStages, RenderTargets, Resource, Resources, SampledImage, Shader, Topology,
    VertexFormat,
};

const LIT: &str = "pipelines/lit.wgsl";

/// Lights over a grid by one way.
pub(crate) struct OnVulkan {
    way: LightWay,
    lights: u32,
    vertices: u32,
    maps: Arc<LayeredDepth>,
    maps_pipeline: LayerPipeline,
    targets: RenderTargets,
    pipeline: DrawPipeline,
}

/// What a frame showed.
pub(crate) struct Shown {
    pub(crate) picture: Picture,
    pub(crate) depths: Vec<f32>,
    /// Of the maps.
    pub(crate) counted: Counted,
}

/// Times of a frame, and of its maps alone.
pub(crate) struct FrameTimes {
    pub(crate) all: Times,
    pub(crate) maps: Times,
}

impl OnVulkan {
    /// - `side`: of a map, texels
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: LightWay,
        grid: &Grid,
        lights: &[DistantLight],
        side: u32,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let count = u32::try_from(lights.len()).unwrap_or(u32::MAX);
        let geometry = way.geometry(count).ok_or_else(|| {
            let what = format!("a geometry shader compiled for {count} invocations");
            DeviceError::unsupported(&what, &gpu.facts.name)
        })?;
        let uniform = |label, bytes: &[u8]| -> Result<Resource, DeviceError> {
            let buffer = Buffer::upload(gpu, label, bytes, BufferUse::Uniform)?;
            Ok(Resource::Uniform(Arc::new(buffer)))
        };
        let constants = GridConstants::new(grid, &View::new());
        let of_lights = LightConstants::new(grid, lights, side);
        let texels = RouteTexels {
            format: RouteTexelFormat::R32Float,
            is_filtered: false,
            size: [grid.cells + 1; 2],
            is_cube: false,
            bytes: bytemuck::cast_slice(&grid.heights).to_vec(),
        };
        let mut resources = vec![
            uniform("grid constants", bytemuck::bytes_of(&constants))?,
            Resource::Image(Arc::new(SampledImage::route(gpu, &texels)?)),
            uniform("lights", bytemuck::bytes_of(&of_lights))?,
        ];
        let of_maps = Resources::new(gpu, resources.clone())?;
        let maps = LayeredDepth::new(gpu, side, count, way.layers_by())?;
        let chooses = way == LightWay::Instanced;
        let maps_pipeline =
            LayerPipeline::new(gpu, &maps, &of_maps, way.vertex(), geometry, chooses)?;
        resources.push(Resource::Depths(Arc::clone(&maps)));
        let resources = Resources::new(gpu, resources)?;
        let wgsl = |entry_point| Shader::Wgsl {
            path: LIT,
            entry_point,
        };
        let stages = PrimitiveStages::Vertices {
            vertex: wgsl("vertex_main"),
            geometry: None,
            format: VertexFormat::Number,
            topology: Topology::Triangles,
        };
        Ok(Self {
            way,
            lights: count,
            vertices: 6 * grid.cells * grid.cells,
            maps,
            maps_pipeline,
            targets: RenderTargets::new(gpu, size)?,
            pipeline: DrawPipeline::new(gpu, &resources, stages, wgsl("fragment_main"))?,
        })
    }

    /// Passes of a frame: those of the maps and that of the picture.
    pub(crate) fn passes(&self) -> usize {
        self.maps.passes() + 1
    }

    pub(crate) fn map_bytes(&self) -> u64 {
        self.maps.bytes()
    }

    pub(crate) fn draw(&mut self) -> Result<Shown, DeviceError> {
        let instances = self.way.instances(self.lights);
        let pipeline = &self.maps_pipeline;
        let measured = Measured::Statistics;
        let report = self
            .maps
            .draw(pipeline, self.vertices, instances, measured)?;
        self.picture(Measured::Nothing)?;
        Ok(Shown {
            picture: self.targets.read()?,
            depths: self.maps.read()?,
            counted: report
                .statistics
                .map_or_else(Counted::default, Counted::from),
        })
    }

    fn picture(&mut self, measured: Measured) -> Result<Option<f64>, DeviceError> {
        let ranges: Vec<_> = std::iter::once(0..self.vertices).collect();
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call: DrawCall::Vertices(&ranges),
        };
        Ok(self.targets.draw_directly(None, &draw, measured)?.gpu_ms)
    }

    pub(crate) fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        let instances = self.way.instances(self.lights);
        let pipeline = &self.maps_pipeline;
        let measured = Measured::Times;
        let report = self
            .maps
            .draw(pipeline, self.vertices, instances, measured)?;
        let maps = Times {
            cpu_ms: watch.cpu_ms(),
            wall_ms: watch.wall_ms(),
            gpu_ms: report.gpu_ms,
        };
        let picture_ms = self.picture(measured)?;
        let all = Times {
            cpu_ms: watch.cpu_ms(),
            wall_ms: watch.wall_ms(),
            gpu_ms: maps
                .gpu_ms
                .zip(picture_ms)
                .map(|(maps, picture)| maps + picture),
        };
        Ok(FrameTimes { all, maps })
    }
}
