// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two states of all balls on a device, each step from one into the other; the CPU writes the first only.

use crate::drawing::{DrawsBalls, VulkanPoints, WgpuPoints};
use crate::terrain::{State, Terrain};
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices};
use terrafill_gpu::{PassTimer, TimedPass};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{
    Buffer, BufferUse, CapturePipeline, ComputePipeline, Dispatch, Resource, Resources, Shader,
    StateStep, advance,
};

const STEP: &str = "balls/step.wgsl";
const STEP_OVER_TERRAIN: &str = "balls/step_terrain.wgsl";
const ENTRY: &str = "step_main";
/// A workgroup of the shader.
const GROUP: u32 = 64;

/// As all shaders have it; those of flat ground need none of the last.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct BallConstants {
    pub(crate) step_s: f32,
    pub(crate) gravity: f32,
    /// k/m, 1/s².
    pub(crate) stiffness: f32,
    pub(crate) count: u32,
    /// A side of the terrain, and of a cell in metres.
    pub(crate) cells: u32,
    pub(crate) cell_m: f32,
    pub(crate) padding: [u32; 2],
}

/// A way to step on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stepping {
    WgpuCompute,
    VulkanCompute,
    VulkanFeedback,
}

impl Stepping {
    pub(crate) const ALL: [Self; 3] =
        [Self::WgpuCompute, Self::VulkanCompute, Self::VulkanFeedback];

    /// Interface and way, as in tables.
    pub(crate) fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::WgpuCompute => ("wgpu", "compute"),
            Self::VulkanCompute => ("vulkan", "compute"),
            Self::VulkanFeedback => ("vulkan", "transform-feedback"),
        }
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
            _ => Box::new(OnVulkan::new(self, devices, constants, balls, terrain)?),
        })
    }
}

/// Balls on a device.
pub(crate) trait Steps {
    /// Takes `count` steps and waits.
    fn step(&mut self, count: u32) -> Result<(), DeviceError>;
    /// GPU time of the last steps, milliseconds, where the device keeps time.
    fn gpu_ms(&self) -> Result<Option<f64>, DeviceError>;
    fn read(&self) -> Result<Vec<State>, DeviceError>;
    /// Bytes that the CPU has written for the device so far.
    fn uploaded(&self) -> u64;
    /// Which of the two states is the last.
    fn current(&self) -> usize;
    /// What draws the balls.
    fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError>;
}

struct OnWgpu {
    gpu: Arc<terrafill_gpu::Gpu>,
    states: [wgpu::Buffer; 2],
    /// From the first state, from the second.
    bound: [wgpu::BindGroup; 2],
    pipeline: wgpu::ComputePipeline,
    groups: u32,
    current: usize,
    timer: Option<PassTimer>,
}

impl OnWgpu {
    fn new(
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
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let mut types = vec![
            wgpu::BufferBindingType::Uniform,
            storage(true),
            storage(false),
        ];
        types.extend(terrain.map(|_| storage(true)));
        let heights = terrain.map(|terrain| {
            let bytes = bytemuck::cast_slice(&terrain.heights);
            gpu.upload("heights", bytes, wgpu::BufferUsages::STORAGE)
        });
        let heights = heights.transpose()?;
        let layout = gpu.buffer_layout("balls", wgpu::ShaderStages::COMPUTE, &types);
        let bound = [(&first, &second), (&second, &first)].map(|(from, to)| {
            let mut buffers = vec![&constants, from, to];
            buffers.extend(&heights);
            gpu.bind_buffers("balls", &layout, &buffers)
        });
        let module = gpu.shader(step_shader(terrain))?;
        Ok(Self {
            pipeline: gpu.compute_pipeline("step balls", &module, ENTRY, &[Some(&layout)], &[]),
            timer: PassTimer::new(&gpu),
            gpu,
            states: [first, second],
            bound,
            groups: groups(balls),
            current: 0,
        })
    }
}

impl Steps for OnWgpu {
    fn step(&mut self, count: u32) -> Result<(), DeviceError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
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
        drop(pass);
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
        let heights = terrain.map(|terrain| {
            let bytes = bytemuck::cast_slice(&terrain.heights);
            Buffer::upload(&gpu, "heights", bytes, BufferUse::Storage)
        });
        let heights = heights.transpose()?.map(Arc::new);
        let bind = |from: usize| {
            let mut all = vec![
                Resource::Uniform(Arc::clone(&constants)),
                Resource::Storage(Arc::clone(&states[from])),
                Resource::Storage(Arc::clone(&states[1 - from])),
            ];
            all.extend(heights.clone().map(Resource::Storage));
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
