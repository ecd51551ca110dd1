// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fan and turns of the static spiral on devices, with the pixels of each. Vulkan counts them by precise occlusion
//! queries, wgpu by a target of numbers and a histogram. Draw arguments alone say what a frame draws, so that one whose
//! eye stands still sends nothing.

use super::rule::{Counted, Drawn, PER_TURN};
use super::view::{SIDE_PX, View, stored};
use crate::counts::device::{Histogram, PixelCount};
use crate::made::device::SpiralConstants;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices, ViewConstants};
use terrafill_globe_views::{Canvas, Stages, uniform, view_constants};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    Buffer, BufferUse, DirectDraw, DrawCall, DrawPipeline, Measured, PrimitiveStages, Resource,
    Resources, Shader, Topology, VertexFormat,
};

const SIZE: ImageSize = ImageSize::new(SIDE_PX, SIDE_PX);
const SHADER: &str = "globes/fan.wgsl";

/// Of a view, as shaders read them.
type Constants = (ViewConstants, SpiralConstants);

/// Draws a range of the spiral.
trait FanTargets {
    fn send(&mut self, constants: &Constants) -> Result<(), DeviceError>;

    /// Pixels of the fan and of all; none where they are not counted.
    fn draw(
        &mut self,
        ranges: &[Range<u32>; 4],
        is_counted: bool,
    ) -> Result<Option<Counted>, DeviceError>;
}

/// Targets, what they were sent, and how many vertices they keep.
pub(super) struct FanDevice {
    targets: Box<dyn FanTargets>,
    sent: Vec<u8>,
    stored: u32,
}

impl FanDevice {
    pub(super) fn new(way: PixelCount, devices: &Devices) -> Result<Self, DeviceError> {
        let vertices: Vec<[f32; 3]> = stored().iter().map(|at| at.as_vec3().to_array()).collect();
        let bytes = bytemuck::cast_slice(&vertices);
        Ok(Self {
            targets: match way {
                PixelCount::Histogram => Box::new(OnWgpu::new(devices, bytes)?),
                PixelCount::Queries => Box::new(OnVulkan::new(devices, bytes)?),
            },
            sent: Vec::new(),
            stored: u32::try_from(vertices.len()).unwrap_or(u32::MAX),
        })
    }

    /// Hands a view to the device unless it has it; bytes that were sent.
    pub(super) fn send(&mut self, view: &View) -> Result<usize, DeviceError> {
        let constants = (
            view_constants(&view.eye),
            SpiralConstants::new(&view.spiral),
        );
        let bytes = [
            bytemuck::bytes_of(&constants.0),
            bytemuck::bytes_of(&constants.1),
        ];
        let bytes = bytes.concat();
        if bytes == self.sent {
            return Ok(0);
        }
        self.targets.send(&constants)?;
        self.sent = bytes;
        Ok(self.sent.len())
    }

    /// Forgets what the device has, so that the next view is sent again.
    pub(super) fn forget(&mut self) {
        self.sent.clear();
    }

    /// Pixels of the fan and of all.
    pub(super) fn count(&mut self, drawn: Drawn) -> Result<Counted, DeviceError> {
        let counted = self.targets.draw(&self.ranges(drawn), true)?;
        counted.ok_or(DeviceError::Missing("counts of pixels"))
    }

    /// Draws without counting, and waits.
    pub(super) fn draw(&mut self, drawn: Drawn) -> Result<(), DeviceError> {
        let drawn = self.targets.draw(&self.ranges(drawn), false);
        drawn.map(|_| ())
    }

    /// Numbers of corners: the fan and what closes it; what begins the turns, and the turns.
    fn ranges(&self, Drawn { first, last }: Drawn) -> [Range<u32>; 4] {
        let count = self.stored;
        let [fan, closes, begins] =
            [first, count + first, 2 * count + first].map(|triangle| 3 * triangle);
        let turns = 9 * count;
        [
            fan..fan + 3 * (PER_TURN - 1),
            closes..closes + 3,
            begins..begins + 3,
            turns + 6 * first..turns + 6 * last,
        ]
    }
}

struct OnWgpu {
    canvas: Canvas,
    pipeline: wgpu::RenderPipeline,
    bound: wgpu::BindGroup,
    view: wgpu::Buffer,
    spiral: wgpu::Buffer,
    histogram: Histogram,
}

impl OnWgpu {
    fn new(devices: &Devices, stored: &[u8]) -> Result<Self, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let uniforms = [wgpu::BufferBindingType::Uniform; 2];
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let types = [uniforms[0], uniforms[1], storage];
        let layout = gpu.buffer_layout("fan", wgpu::ShaderStages::VERTEX, &types);
        let view = uniform::<ViewConstants>(&gpu, "view constants");
        let spiral = uniform::<SpiralConstants>(&gpu, "spiral");
        let stored = gpu.upload("stored spiral", stored, wgpu::BufferUsages::STORAGE)?;
        let module = gpu.shader(SHADER)?;
        let canvas = Canvas::new(&gpu, SIZE, wgpu::TextureFormat::R32Uint);
        let stages = Stages {
            module: &module,
            entry_points: ["vertex_main", "number_main"],
            constants: &[],
            buffers: &[],
        };
        let of_pipeline = gpu.pipeline_layout("fan", &[Some(&layout)]);
        Ok(Self {
            pipeline: canvas.pipeline("fan", &of_pipeline, &stages),
            bound: gpu.bind_buffers("fan", &layout, &[&view, &spiral, &stored]),
            view,
            spiral,
            histogram: Histogram::new(&gpu)?,
            canvas,
        })
    }
}

impl FanTargets for OnWgpu {
    fn send(&mut self, (view, spiral): &Constants) -> Result<(), DeviceError> {
        let gpu = &self.canvas.gpu;
        gpu.write_buffer(&self.view, 0, bytemuck::bytes_of(view));
        gpu.write_buffer(&self.spiral, 0, bytemuck::bytes_of(spiral));
        Ok(())
    }

    fn draw(
        &mut self,
        ranges: &[Range<u32>; 4],
        is_counted: bool,
    ) -> Result<Option<Counted>, DeviceError> {
        let mut encoder = self.canvas.frame();
        self.canvas.record(&mut encoder, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.bound, &[]);
            for range in ranges {
                pass.draw(range.clone(), 0..1);
            }
        });
        if !is_counted {
            return self.canvas.finish(encoder).map(|_| None);
        }
        let counts = self.histogram.count(&self.canvas, encoder, 2)?;
        Ok(Some(Counted {
            fan: counts[0],
            all: counts.iter().sum(),
        }))
    }
}

struct OnVulkan {
    gpu: Arc<terrafill_vulkan::Gpu>,
    targets: terrafill_vulkan::RenderTargets,
    pipeline: DrawPipeline,
    view: Arc<Buffer>,
    spiral: Arc<Buffer>,
}

impl OnVulkan {
    fn new(devices: &Devices, stored: &[u8]) -> Result<Self, DeviceError> {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        let streamed = |label: &str, bytes: usize| {
            let buffer = Buffer::streamed(&gpu, label, bytes as u64, BufferUse::Uniform);
            buffer.map(Arc::new)
        };
        let view = streamed("view constants", size_of::<ViewConstants>())?;
        let spiral = streamed("spiral", size_of::<SpiralConstants>())?;
        let stored = Buffer::upload(&gpu, "stored spiral", stored, BufferUse::Storage)?;
        let resources = vec![
            Resource::Uniform(Arc::clone(&view)),
            Resource::Uniform(Arc::clone(&spiral)),
            Resource::Storage(Arc::new(stored)),
        ];
        let resources = Resources::new(&gpu, resources)?;
        let shader = |entry_point| Shader::Wgsl {
            path: SHADER,
            entry_point,
        };
        let stages = PrimitiveStages::Vertices {
            vertex: shader("vertex_main"),
            geometry: None,
            format: VertexFormat::Number,
            topology: Topology::Triangles,
        };
        Ok(Self {
            targets: terrafill_vulkan::RenderTargets::new(&gpu, SIZE)?,
            pipeline: DrawPipeline::new(&gpu, &resources, stages, shader("colour_main"))?,
            view,
            spiral,
            gpu,
        })
    }
}

impl FanTargets for OnVulkan {
    fn send(&mut self, (view, spiral): &Constants) -> Result<(), DeviceError> {
        self.view.stream(bytemuck::bytes_of(view))?;
        self.spiral.stream(bytemuck::bytes_of(spiral))
    }

    fn draw(
        &mut self,
        ranges: &[Range<u32>; 4],
        is_counted: bool,
    ) -> Result<Option<Counted>, DeviceError> {
        let draw = DirectDraw {
            pipeline: &self.pipeline,
            vertices: None,
            call: DrawCall::Vertices(ranges),
        };
        let measured = if is_counted {
            Measured::Samples
        } else {
            Measured::Nothing
        };
        let samples = self.targets.draw_directly(None, &draw, measured)?.samples;
        let counted = samples.map(|samples| Counted {
            fan: samples[..2].iter().sum(),
            all: samples.iter().sum(),
        });
        if is_counted && counted.is_none() {
            let name = &self.gpu.facts.name;
            return Err(DeviceError::unsupported("occlusionQueryPrecise", name));
        }
        Ok(counted)
    }
}
