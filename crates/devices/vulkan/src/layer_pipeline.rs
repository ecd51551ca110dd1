// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines that draw depth, and colours where maps have them, into layers, and their draws.

use crate::draw_pipeline::check_output;
use crate::layered::LayerPass;
use crate::pipeline::{Assembly, OwnedPipeline, PipelineState, ShaderStage, depth_stencil};
use crate::queries::{Queries, QueryKind, Span};
use crate::shader_modules::ModuleKey;
use crate::{DirectReport, GeometryOutput, Gpu, LayeredDepth, LayersBy, Measured, Resources};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::{DeviceError, SurfaceLook};

/// Compiled shaders that draw into layers.
#[derive(Debug)]
pub struct LayerPipeline {
    pipeline: OwnedPipeline,
    resources: Arc<Resources>,
    by: LayersBy,
    views: u32,
    has_colour: bool,
}

impl LayerPipeline {
    /// Makes a pipeline for maps of this kind. Vertices are numbers, three a triangle.
    ///
    /// - `vertex`: SPIR-V that was compiled beforehand, by its name
    /// - `fragment`: likewise, of maps with colours
    /// - `chooses_layer`: the vertex shader does
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks a stage or what it does, [`DeviceError::OverCapacity`]
    /// when a geometry shader emits more than it allows, [`DeviceError::Shader`],
    /// [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        maps: &LayeredDepth,
        resources: &Arc<Resources>,
        vertex: &'static str,
        geometry: Option<GeometryOutput>,
        fragment: Option<&'static str>,
        chooses_layer: bool,
    ) -> Result<Self, DeviceError> {
        let are_own = resources.is_on(gpu) && maps.image.is_on(gpu);
        gpu.require(are_own, "resources of another device")?;
        let can_choose = !chooses_layer || gpu.facts.features.vertex_layer;
        gpu.require(can_choose, "VK_EXT_shader_viewport_index_layer")?;
        let has_colour = maps.colours.is_some();
        let fits = fragment.is_some() == has_colour;
        gpu.require(
            fits,
            "colours of layers by a pipeline of depth alone, or depth by one of colours",
        )?;
        // A fragment's number of its triangle is of that feature.
        let can_number = fragment.is_none() || gpu.facts.features.geometry_shader;
        gpu.require(can_number, "geometryShader")?;
        let stage = |flag, name| ShaderStage::new(gpu, flag, ModuleKey::Compiled(name), "main");
        let mut stages = vec![stage(vk::ShaderStageFlags::VERTEX, vertex)?];
        if let Some(output) = geometry {
            check_output(gpu, output)?;
            stages.push(stage(vk::ShaderStageFlags::GEOMETRY, output.name)?);
        }
        if let Some(fragment) = fragment {
            stages.push(stage(vk::ShaderStageFlags::FRAGMENT, fragment)?);
        }
        let blends = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)];
        let depth = depth_stencil(PipelineState::Surface(SurfaceLook::default()));
        Ok(Self {
            pipeline: Assembly {
                stages: &stages,
                blends: &blends[..usize::from(has_colour)],
                ..Assembly::new(resources.layout(), maps.render_pass.raw, depth)
            }
            .create(gpu)?,
            resources: Arc::clone(resources),
            by: maps.by,
            views: maps.views,
            has_colour,
        })
    }
}

impl LayeredDepth {
    /// Draws into all layers and waits. Instances are numbered from the first layer of their pass.
    ///
    /// - `instances`: of each pass
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for a pipeline of other maps' kind, [`DeviceError::DeviceLost`].
    pub fn draw(
        &self,
        pipeline: &LayerPipeline,
        vertices: u32,
        instances: u32,
        measured: Measured,
    ) -> Result<DirectReport, DeviceError> {
        let gpu = &self.gpu;
        let own = (self.by, self.views, self.colours.is_some());
        let is_alike = (pipeline.by, pipeline.views, pipeline.has_colour) == own;
        let fits = pipeline.pipeline.is_on(gpu) && is_alike;
        gpu.require(fits, "drawing depth maps by a pipeline of another kind")?;
        // A pass of several views takes as many queries.
        let passes = u32::try_from(self.passes.len()).unwrap_or(u32::MAX);
        let counts = measured == Measured::Statistics;
        let queries = passes * self.views * u32::from(counts);
        let counted = Queries::new(gpu, QueryKind::Statistics, queries)?;
        // llvmpipe 25.0.7 crashes in a pass of several views after a timestamp.
        let can_time = self.views == 1 || gpu.facts.driver != "llvmpipe";
        let is_timed = can_time && measured == Measured::Times;
        let stamps = Queries::new(gpu, QueryKind::Timestamps, 2 * u32::from(is_timed))?;
        let span = Span::new(stamps.as_ref(), 0);
        // SAFETY: everything is of this device and lives until the submission is done.
        unsafe {
            gpu.submit(|_, commands| {
                span.begin(commands);
                if let Some(counted) = &counted {
                    counted.reset(commands);
                }
                for (number, pass) in (0..).zip(&self.passes) {
                    let query = counted.as_ref().map(|of| (of, number * self.views));
                    self.record(commands, pass, pipeline, [vertices, instances], query);
                }
                span.end(commands);
            })?;
        }
        let counted = counted.as_ref();
        let statistics = counted.map(|counted| counted.read_statistics(counted.count));
        Ok(DirectReport {
            gpu_ms: span.ms()?,
            statistics: statistics.transpose()?,
            samples: None,
        })
    }

    /// # Safety
    /// Recording is under way, outside of a pass, with a pipeline of these maps' kind on their device.
    unsafe fn record(
        &self,
        commands: vk::CommandBuffer,
        pass: &LayerPass,
        pipeline: &LayerPipeline,
        [vertices, instances]: [u32; 2],
        query: Option<(&Queries, u32)>,
    ) {
        let device = &self.gpu.device;
        let area = self.extent().into();
        let side = self.extent().width as f32;
        // Texels' rows grow with y, unlike pictures'.
        let viewport = vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: side,
            height: side,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        // Colours are cleared to 0 too, and ignored where maps have none.
        let clears = [
            vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue::default(),
            },
            vk::ClearValue::default(),
        ];
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.render_pass.raw)
            .framebuffer(pass.framebuffer.raw)
            .render_area(area)
            .clear_values(&clears);
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the caller's promise.
        unsafe {
            device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_bind_pipeline(commands, graphics, pipeline.pipeline.raw);
            pipeline.resources.bind(commands, graphics);
            if let Some((counted, at)) = query {
                counted.begin(commands, at);
            }
            device.cmd_draw(commands, vertices, instances, 0, pass.first);
            if let Some((counted, at)) = query {
                counted.end(commands, at);
            }
            device.cmd_end_render_pass(commands);
        }
    }
}
