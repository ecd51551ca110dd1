// SPDX-License-Identifier: MIT OR Apache-2.0
//! The hierarchy of tiles, by compute on wgpu.

use crate::casting::{Casting, mask_of};
use std::sync::Arc;
use terrafill_contract::{Counters, CpuStopwatch, DeviceError, Devices, FrameTimes, SurfaceView};
use terrafill_gpu::{Gpu, PassTimer, RenderTargets, TimedPass, read_buffer, shared_gpu};
use terrafill_shadow_views::{Channel, Draws};

const SHADER: &str = "casters/tiles.wgsl";
/// Invocations of a group.
const GROUP: u32 = 64;
/// Pixels along a tile, level by level.
const SIDES: [u32; 3] = [8, 32, 128];

/// Buffers and pipelines for one view.
pub(super) struct Tiles {
    gpu: Arc<Gpu>,
    bound: wgpu::BindGroup,
    /// In order, with their groups.
    steps: Vec<(wgpu::ComputePipeline, u32)>,
    dark: wgpu::Buffer,
    answers: wgpu::Buffer,
    timer: Option<PassTimer>,
}

impl Tiles {
    pub(super) fn open(
        devices: &Devices,
        seen: SurfaceView<'_>,
        casting: &Casting,
    ) -> Result<Channel, DeviceError> {
        let gpu = shared_gpu(devices)?;
        let mut targets = RenderTargets::new(&gpu, seen.size)?;
        targets.prepare(seen)?;
        targets.draw_surface()?;
        let depths = targets.read()?.depth;
        let storage = wgpu::BufferUsages::STORAGE;
        let upload = |label, bytes: &[u8], usage| gpu.upload(label, bytes, usage);
        let receivers = bytemuck::bytes_of(&casting.receivers);
        let receivers = upload("receivers", receivers, wgpu::BufferUsages::UNIFORM)?;
        let depths = upload("depths", bytemuck::cast_slice(&depths), storage)?;
        let places = upload("places", bytemuck::cast_slice(&casting.places), storage)?;
        // A binding of 0 bytes is not allowed.
        let mut triangles = casting.triangles.clone();
        triangles.resize(triangles.len().max(1), [0; 4]);
        let triangles = upload("triangles", bytemuck::cast_slice(&triangles), storage)?;
        let [width, height] = casting.receivers.size;
        let tiles = SIDES.map(|side| width.div_ceil(side) * height.div_ceil(side));
        let all: u32 = tiles.iter().sum();
        let room = |label, words: u32, usage| {
            let size = u64::from(words) * size_of::<u32>() as u64;
            gpu.unwritten(label, size, storage | usage)
        };
        let none = wgpu::BufferUsages::empty();
        let boxes = room("boxes of tiles", 2 * all, none);
        let dark = room("dark", all + tiles[0], wgpu::BufferUsages::COPY_DST);
        let pixels = width * height;
        let answers = room("answers", pixels, wgpu::BufferUsages::COPY_SRC);
        let kind = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let (held, written) = (kind(true), kind(false));
        let uniform = wgpu::BufferBindingType::Uniform;
        let kinds = [uniform, held, held, held, written, written, written];
        let layout = gpu.buffer_layout("tiles", wgpu::ShaderStages::COMPUTE, &kinds);
        let buffers = [
            &receivers, &depths, &places, &triangles, &boxes, &dark, &answers,
        ];
        let bound = gpu.bind_buffers("tiles", &layout, &buffers);
        let module = gpu.shader(SHADER)?;
        let steps = [
            ("bound", tiles[0]),
            ("join_middle", tiles[1]),
            ("join_top", tiles[2]),
            ("throw_shadows", casting.receivers.triangles),
            ("answer", pixels),
        ];
        let step = |(entry_point, invocations): (&str, u32)| {
            let groups = [Some(&layout)];
            let pipeline = gpu.compute_pipeline(entry_point, &module, entry_point, &groups, &[]);
            (pipeline, invocations.div_ceil(GROUP))
        };
        let held = buffers.iter().map(|buffer| buffer.size()).sum();
        // Those that face the sun, and the direction.
        let bytes = [held, triangles.size() + 16];
        let tiles = Self {
            steps: steps.map(step).into(),
            timer: PassTimer::new(&gpu),
            bound,
            dark,
            answers,
            gpu,
        };
        Ok(Channel {
            draws: Box::new(tiles),
            bytes,
            build_ms: None,
            left_out: 0,
        })
    }

    fn run(&self, timer: Option<&PassTimer>) -> Result<(), DeviceError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(timer) = timer {
            timer.begin(&mut encoder, TimedPass::Colour);
        }
        encoder.clear_buffer(&self.dark, 0, None);
        let stamps = timer.map(|timer| timer.writes(None, Some(TimedPass::Colour)));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("tiles"),
            timestamp_writes: stamps.map(|writes| wgpu::ComputePassTimestampWrites {
                query_set: writes.query_set,
                beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
                end_of_pass_write_index: writes.end_of_pass_write_index,
            }),
        });
        pass.set_bind_group(0, &self.bound, &[]);
        for (pipeline, groups) in &self.steps {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(*groups, 1, 1);
        }
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }
}

impl Draws for Tiles {
    fn draw(&mut self) -> Result<(Counters, Vec<bool>), DeviceError> {
        self.run(None)?;
        let mask = mask_of(&read_buffer(&self.gpu, &self.answers)?);
        Ok((Counters::default(), mask))
    }

    fn time(&mut self) -> Result<FrameTimes, DeviceError> {
        let watch = CpuStopwatch::start();
        self.run(self.timer.as_ref())?;
        let mut times = FrameTimes {
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
            ..FrameTimes::default()
        };
        if let Some(timer) = &self.timer {
            times.fill_gpu_ms = timer.pass_ms(&self.gpu, TimedPass::Colour)?;
        }
        Ok(times)
    }
}
