// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers by one way, those of lights or others, and the picture, on Vulkan itself, which has every stage.

use super::scene::{DistantLight, LightConstants};
use super::way::LightWay;
use crate::draws::{Counted, FrameTimes, Looked, LooksUp, Times, count};
use crate::on_vulkan::{heights, numbered, uniform, wgsl};
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, DeviceError};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridConstants};
use terrafill_vulkan::{
    DirectDraw, DirectReport, DrawCall, DrawPipeline, GeometryOutput, Gpu, LayerContents,
    LayerPipeline, LayeredDepth, Measured, RenderTargets, Resource, Resources, Topology,
};

const LIT: &str = "pipelines/lit.wgsl";

/// Layers by one way, and the picture that looks them up.
pub(crate) struct OnVulkan {
    /// Of the layers.
    instances: u32,
    /// Of the layers, and of the picture.
    vertices: [u32; 2],
    maps: Arc<LayeredDepth>,
    maps_pipeline: LayerPipeline,
    targets: RenderTargets,
    pipeline: DrawPipeline,
}

/// What layers and picture are made of.
pub(crate) struct LayerParts {
    pub(crate) way: LightWay,
    pub(crate) layers: u32,
    /// Of a layer, texels.
    pub(crate) side: u32,
    pub(crate) vertex: &'static str,
    /// As of [`LightWay::geometry`].
    pub(crate) geometry: Option<Option<GeometryOutput>>,
    /// SPIR-V that colours layers, where they have colours.
    pub(crate) fragment: Option<&'static str>,
    /// Of the layers, and of the picture.
    pub(crate) vertices: [u32; 2],
    /// At bindings 0 to 2; the layers come behind them.
    pub(crate) resources: Vec<Resource>,
    /// At binding 4, where the picture needs it.
    pub(crate) behind: Option<Resource>,
    /// WGSL of the picture.
    pub(crate) picture: &'static str,
    pub(crate) size: ImageSize,
}

impl OnVulkan {
    /// Lights over a grid.
    ///
    /// - `side`: of a map, texels
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        way: LightWay,
        grid: &Grid,
        lights: &[DistantLight],
        side: u32,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let layers = count(lights);
        let constants = GridConstants::new(grid);
        let of_lights = LightConstants::new(grid, lights, side);
        let parts = LayerParts {
            way,
            layers,
            side,
            vertex: way.vertex(),
            geometry: way.geometry(layers),
            fragment: None,
            vertices: [6 * grid.cells * grid.cells; 2],
            resources: vec![
                uniform(gpu, "grid constants", bytemuck::bytes_of(&constants))?,
                Resource::Image(heights(gpu, grid)?),
                uniform(gpu, "lights", bytemuck::bytes_of(&of_lights))?,
            ],
            behind: None,
            picture: LIT,
            size,
        };
        Self::with(gpu, parts)
    }

    pub(crate) fn with(gpu: &Arc<Gpu>, parts: LayerParts) -> Result<Self, DeviceError> {
        let LayerParts { way, layers, .. } = parts;
        let geometry = parts.geometry.ok_or_else(|| {
            let what = format!("a geometry shader compiled for {layers} layers");
            DeviceError::unsupported(&what, &gpu.facts.name)
        })?;
        let of_maps = Resources::new(gpu, parts.resources.clone())?;
        let contents = match parts.fragment {
            Some(_) => LayerContents::DepthAndColour,
            None => LayerContents::Depth,
        };
        let maps = LayeredDepth::new(gpu, parts.side, layers, way.layers_by(), contents)?;
        let chooses = way == LightWay::Instanced;
        let maps_pipeline = LayerPipeline::new(
            gpu,
            &maps,
            &of_maps,
            parts.vertex,
            geometry,
            parts.fragment,
            chooses,
        )?;
        let mut resources = parts.resources;
        resources.push(Resource::Depths(Arc::clone(&maps)));
        resources.extend(parts.behind);
        let resources = Resources::new(gpu, resources)?;
        let vertex = wgsl(parts.picture, "vertex_main");
        let stages = numbered(vertex, None, Topology::Triangles);
        let fragment = wgsl(parts.picture, "fragment_main");
        Ok(Self {
            instances: way.instances(layers),
            vertices: parts.vertices,
            maps,
            maps_pipeline,
            targets: RenderTargets::new(gpu, parts.size)?,
            pipeline: DrawPipeline::new(gpu, &resources, stages, fragment)?,
        })
    }

    /// Numbers that layers show, one after the other; none where they have no colours.
    pub(crate) fn numbers(&self) -> Result<Vec<u32>, DeviceError> {
        let colours = self.maps.read_colours()?;
        Ok(colours
            .into_iter()
            .map(|colour| colour & 0xff_ffff)
            .collect())
    }

    fn draw_maps(&mut self, measured: Measured) -> Result<DirectReport, DeviceError> {
        let instances = self.instances;
        let pipeline = &self.maps_pipeline;
        self.maps
            .draw(pipeline, self.vertices[0], instances, measured)
    }

    fn draw_picture(&mut self, measured: Measured) -> Result<Option<f64>, DeviceError> {
        let ranges: Vec<_> = std::iter::once(0..self.vertices[1]).collect();
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call: DrawCall::Vertices(&ranges),
        };
        Ok(self.targets.draw_directly(None, &draw, measured)?.gpu_ms)
    }
}

impl LooksUp for OnVulkan {
    fn draw(&mut self) -> Result<Looked, DeviceError> {
        let report = self.draw_maps(Measured::Statistics)?;
        self.draw_picture(Measured::Nothing)?;
        Ok(Looked {
            picture: self.targets.read()?,
            depths: self.maps.read()?,
            counted: Counted::from(report.statistics),
        })
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        let report = self.draw_maps(Measured::Times)?;
        let maps = Times::since(&watch, report.gpu_ms);
        let picture_ms = self.draw_picture(Measured::Times)?;
        let both = maps.gpu_ms.zip(picture_ms);
        let all = Times::since(&watch, both.map(|(maps, picture)| maps + picture));
        Ok(FrameTimes { all, maps })
    }

    fn passes(&self) -> usize {
        self.maps.passes() + 1
    }

    fn bytes(&self) -> u64 {
        self.maps.bytes()
    }
}
