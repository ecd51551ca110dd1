// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two states of all balls on a device, each step from one into the other; the CPU writes the first only. Beside them
//! balls that the CPU steps, and writes for the device that draws them.

use crate::by_cpu::ByCpu;
use crate::drawing::{DrawsBalls, VulkanPoints, WgpuPoints};
use crate::steps::{BallConstants, Steps};
use crate::terrain::{BLOCKS, SAMPLES, State, Terrain};
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices};
use terrafill_gpu::{PassTimer, TimedPass};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    BlockImage, Buffer, BufferUse, CapturePipeline, ComputePipeline, Dispatch, ImageShape,
    Resource, Resources, Shader, StateStep, advance,
};

const STEP: &str = "balls/step.wgsl";
const STEP_OVER_TERRAIN: &str = "balls/fly.wgsl";
const ENTRY: &str = "step_main";
/// A workgroup of the shader.
const GROUP: u32 = 64;

/// A way to step on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stepping {
    WgpuCompute,
    VulkanCompute,
    VulkanFeedback,
    /// By a thread of the CPU, which writes the balls for Vulkan to draw.
    Cpu,
}

impl Stepping {
    pub(crate) const ALL: [Self; 4] = [
        Self::WgpuCompute,
        Self::VulkanCompute,
        Self::VulkanFeedback,
        Self::Cpu,
    ];

    /// Interface and way, as in tables.
    pub(crate) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::WgpuCompute => ("wgpu", "compute"),
            Self::VulkanCompute => ("vulkan", "compute"),
            Self::VulkanFeedback => ("vulkan", "transform-feedback"),
            Self::Cpu => ("cpu", "one-thread"),
        }
    }

    /// Bytes that must be written for the device in so many submissions of steps: none where it steps the balls itself.
    pub(crate) fn uploads(self, balls: u32, submissions: u32) -> u64 {
        let state = if self == Self::Cpu {
            size_of::<State>()
        } else {
            0
        };
        state as u64 * u64::from(balls) * u64::from(submissions)
    }

    /// Puts the balls onto the device, over terrain or over level ground at height 0.
    pub(crate) fn open(
        self,
        devices: &Devices,
        constants: &BallConstants,
        balls: &[State],
        terrain: Option<&Terrain>,
    ) -> Result<Box<dyn Steps>, DeviceError> {
        Ok(match self {
            Self::WgpuCompute => Box::new(OnWgpu::new(devices, constants, balls, terrain)?),
            Self::Cpu => Box::new(ByCpu::new(devices, constants, balls, terrain)?),
            _ => Box::new(OnVulkan::new(self, devices, constants, balls, terrain)?),
        })
    }
}

pub(crate) struct OnWgpu {
    pub(crate) gpu: Arc<terrafill_gpu::Gpu>,
    pub(crate) states: [wgpu::Buffer; 2],
    /// As [`BallConstants`], and blocks of the terrain, which may be drawn into.
    pub(crate) constants: wgpu::Buffer,
    pub(crate) heights: Option<wgpu::Texture>,
    /// From the first state, from the second.
    bound: [wgpu::BindGroup; 2],
    pipeline: wgpu::ComputePipeline,
    groups: u32,
    pub(crate) current: usize,
    timer: Option<PassTimer>,
}

impl OnWgpu {
    pub(crate) fn new(
        devices: &Devices,
        constants: &BallConstants,
        balls: &[State],
        terrain: Option<&Terrain>,
    ) -> Result<Self, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let bytes = bytemuck::cast_slice(balls);
        let first = gpu.upload("balls", bytes, usage)?;
        let second = gpu.unwritten("balls", first.size(), usage);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let constants = gpu.upload("ball constants", bytemuck::bytes_of(constants), uniform)?;
        let stage = wgpu::ShaderStages::COMPUTE;
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
        let mut types = vec![
            buffer(wgpu::BufferBindingType::Uniform),
            storage(true),
            storage(false),
        ];
        let heights = terrain.map(|terrain| layers(&gpu, terrain)).transpose()?;
        types.extend(heights.as_ref().map(|_| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        }));
        let layout = gpu.mixed_layout("balls", types.into_iter().map(|ty| (stage, ty)));
        let views = heights
            .as_ref()
            .map(|of| of.create_view(&Default::default()));
        let bound = [(&first, &second), (&second, &first)].map(|(from, to)| {
            let buffers = [&constants, from, to].map(wgpu::Buffer::as_entire_binding);
            let heights = views.iter().map(wgpu::BindingResource::TextureView);
            gpu.bind("balls", &layout, buffers.into_iter().chain(heights))
        });
        let module = gpu.shader(step_shader(terrain))?;
        Ok(Self {
            pipeline: gpu.compute_pipeline("step balls", &module, ENTRY, &[Some(&layout)], &[]),
            timer: PassTimer::new(&gpu),
            gpu,
            states: [first, second],
            constants,
            heights,
            bound,
            groups: groups(balls),
            current: 0,
        })
    }

    /// Records steps, with their time where the device keeps it.
    pub(crate) fn record(&mut self, encoder: &mut wgpu::CommandEncoder, count: u32) {
        let timer = self.timer.as_ref();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("step balls"),
            timestamp_writes: timer.map(|timer| timer.around_compute(TimedPass::Surface)),
        });
        pass.set_pipeline(&self.pipeline);
        for _ in 0..count {
            pass.set_bind_group(0, &self.bound[self.current], &[]);
            pass.dispatch_workgroups(self.groups, 1, 1);
            self.current = 1 - self.current;
        }
    }
}

impl Steps for OnWgpu {
    fn step(&mut self, count: u32) -> Result<(), DeviceError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, count);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    fn gpu_ms(&self) -> Result<Option<f64>, DeviceError> {
        let timer = self.timer.as_ref();
        let timed = timer.map(|timer| timer.pass_ms(&self.gpu, TimedPass::Surface));
        Ok(timed.transpose()?.flatten())
    }

    fn read(&self) -> Result<Vec<State>, DeviceError> {
        let bytes = terrafill_gpu::read_buffer(&self.gpu, &self.states[self.current])?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn uploaded(&self) -> u64 {
        self.gpu.work_done().upload_bytes
    }

    fn current(&self) -> usize {
        self.current
    }

    fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError> {
        Ok(Box::new(WgpuPoints::new(&self.gpu, &self.states, size)?))
    }
}

/// The terrain's blocks as layers of an array texture.
fn layers(gpu: &terrafill_gpu::Gpu, terrain: &Terrain) -> Result<wgpu::Texture, DeviceError> {
    let limit = gpu.device.limits().max_texture_array_layers;
    let layers = BLOCKS * BLOCKS;
    DeviceError::check_capacity("layers of an array texture", layers, limit)?;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::RENDER_ATTACHMENT
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST;
    let size = [SAMPLES, SAMPLES, layers];
    let format = wgpu::TextureFormat::R32Float;
    let texture = gpu.texture("blocks of terrain", size, 1, format, usage);
    for (layer, heights) in (0..).zip(&terrain.blocks) {
        write_layer(gpu, &texture, layer, heights);
    }
    Ok(texture)
}

/// Writes heights of a block; done when the device next is.
pub(crate) fn write_layer(
    gpu: &terrafill_gpu::Gpu,
    texture: &wgpu::Texture,
    layer: u32,
    heights: &[f32],
) {
    let mut place = texture.as_image_copy();
    place.origin.z = layer;
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * SAMPLES),
        rows_per_image: Some(SAMPLES),
    };
    let size = wgpu::Extent3d {
        width: SAMPLES,
        height: SAMPLES,
        depth_or_array_layers: 1,
    };
    let bytes = bytemuck::cast_slice(heights);
    gpu.queue.write_texture(place, bytes, rows, size);
}

/// The same on Vulkan.
fn layers_on_vulkan(
    gpu: &Arc<terrafill_vulkan::Gpu>,
    terrain: &Terrain,
) -> Result<Resource, DeviceError> {
    let size = [SAMPLES; 2];
    let image = BlockImage::new(gpu, size, ImageShape::Array(BLOCKS * BLOCKS))?;
    for (layer, heights) in (0..).zip(&terrain.blocks) {
        image.write([0, 0, layer], size, heights)?;
    }
    Ok(Resource::Blocks(Arc::new(image)))
}

fn step_shader(terrain: Option<&Terrain>) -> &'static str {
    terrain.map_or(STEP, |_| STEP_OVER_TERRAIN)
}

/// By what a step on Vulkan is taken, from the first state and from the second.
enum Stepper {
    Compute([ComputePipeline; 2]),
    Feedback([CapturePipeline; 2]),
}

struct OnVulkan {
    gpu: Arc<terrafill_vulkan::Gpu>,
    states: [Arc<Buffer>; 2],
    stepper: Stepper,
    balls: u32,
    groups: u32,
    current: usize,
    gpu_ms: Option<f64>,
}

fn groups(balls: &[State]) -> u32 {
    count(balls).div_ceil(GROUP)
}

fn count(balls: &[State]) -> u32 {
    u32::try_from(balls.len()).unwrap_or(u32::MAX)
}

impl OnVulkan {
    fn new(
        way: Stepping,
        devices: &Devices,
        constants: &BallConstants,
        balls: &[State],
        terrain: Option<&Terrain>,
    ) -> Result<Self, DeviceError> {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        let bytes: &[u8] = bytemuck::cast_slice(balls);
        let first = Buffer::upload(&gpu, "balls", bytes, BufferUse::State)?;
        let second = Buffer::unwritten(&gpu, "balls", first.size(), BufferUse::State)?;
        let states = [first, second].map(Arc::new);
        let bytes = bytemuck::bytes_of(constants);
        let constants = Buffer::upload(&gpu, "ball constants", bytes, BufferUse::Uniform)?;
        let constants = Arc::new(constants);
        let heights = terrain.map(|terrain| layers_on_vulkan(&gpu, terrain));
        let heights = heights.transpose()?;
        let bind = |from: usize| {
            let mut all = vec![
                Resource::Uniform(Arc::clone(&constants)),
                Resource::Storage(Arc::clone(&states[from])),
                Resource::Storage(Arc::clone(&states[1 - from])),
            ];
            all.extend(heights.clone());
            Resources::new(&gpu, all)
        };
        let bound = [bind(0)?, bind(1)?];
        let stepper = if way == Stepping::VulkanFeedback {
            let shader = terrain.map_or("native/balls.spv", |_| "native/balls.terrain.spv");
            let make = |from: usize| CapturePipeline::new(&gpu, &bound[from], shader);
            Stepper::Feedback([make(0)?, make(1)?])
        } else {
            let shader = Shader::Wgsl {
                path: step_shader(terrain),
                entry_point: ENTRY,
            };
            let make = |from: usize| ComputePipeline::new(&gpu, &bound[from], shader);
            Stepper::Compute([make(0)?, make(1)?])
        };
        Ok(Self {
            gpu,
            states,
            stepper,
            balls: count(balls),
            groups: groups(balls),
            current: 0,
            gpu_ms: None,
        })
    }
}

impl Steps for OnVulkan {
    fn step(&mut self, count: u32) -> Result<(), DeviceError> {
        let mut steps = Vec::new();
        for _ in 0..count {
            let from = self.current;
            self.current = 1 - from;
            steps.push(match &self.stepper {
                Stepper::Compute(pipelines) => StateStep::Dispatch(Dispatch {
                    pipeline: &pipelines[from],
                    groups: [self.groups, 1, 1],
                }),
                Stepper::Feedback(pipelines) => StateStep::Capture {
                    pipeline: &pipelines[from],
                    into: &self.states[self.current],
                    vertices: self.balls,
                },
            });
        }
        self.gpu_ms = advance(&self.gpu, &steps)?.gpu_ms;
        Ok(())
    }

    fn gpu_ms(&self) -> Result<Option<f64>, DeviceError> {
        Ok(self.gpu_ms)
    }

    fn current(&self) -> usize {
        self.current
    }

    fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError> {
        Ok(Box::new(VulkanPoints::new(&self.gpu, &self.states, size)?))
    }

    fn read(&self) -> Result<Vec<State>, DeviceError> {
        let bytes = self.states[self.current].contents(&self.gpu)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn uploaded(&self) -> u64 {
        self.gpu.work_done().upload_bytes
    }
}
