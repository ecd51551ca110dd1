// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls on wgpu whose first impacts change the array texture that they read heights from.

use crate::scene::BallScene;
use crate::stepping::{OnWgpu, write_layer};
use crate::steps::{BallConstants, Steps as _};
use crate::terrain::{BLOCKS, CELLS, SAMPLES, State, Terrain};
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;
use terrafill_contract::{DeviceError, Devices};
use terrafill_scene::ImageSize;

const SHADER: &str = "balls/craters.wgsl";
const LAYERS: u32 = BLOCKS * BLOCKS;

terrafill_results::named! {
    /// How craters come into the ground.
    all pub(crate) enum CraterWay {
        /// Not at all: what a step costs without craters.
        Nothing = "none",
        /// Layers are drawn into.
        Drawn = "drawn-into-layers",
        /// The CPU reads the balls and writes the layers that they strike.
        Written = "written-by-cpu",
    }
}

/// Balls and ground at a time.
#[derive(PartialEq)]
pub(crate) struct Snapshot {
    pub(super) balls: Vec<State>,
    pub(super) ground: Terrain,
}

impl Snapshot {
    pub(super) fn new(balls: &[State], ground: &Terrain) -> Self {
        Self {
            balls: balls.to_vec(),
            ground: ground.clone(),
        }
    }
}

/// Balls, the ground that they change, and what changes it.
pub(crate) struct Cratering {
    balls: OnWgpu,
    heights: wgpu::Texture,
    way: CraterWay,
    constants: BallConstants,
    layers: Vec<wgpu::TextureView>,
    /// Of craters that are drawn.
    pipeline: Option<wgpu::RenderPipeline>,
    /// By the state before a step.
    bound: [wgpu::BindGroup; 2],
    /// As the CPU has them, which writes layers anew.
    known: Snapshot,
    /// Bytes of heights that the CPU wrote since the start.
    pub(crate) written_bytes: u64,
}

impl Cratering {
    pub(crate) fn new(
        devices: &Devices,
        way: CraterWay,
        constants: &BallConstants,
        first: &[State],
        terrain: &Terrain,
    ) -> Result<Self, DeviceError> {
        let mut balls = OnWgpu::new(devices, constants, first, Some(terrain))?;
        let gpu = &balls.gpu;
        let is_drawn = way == CraterWay::Drawn;
        let heights = balls.heights.take();
        let heights = heights.ok_or_else(|| gpu.lacks("terrain under balls"))?;
        let layer = |base_array_layer: u32| {
            heights.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let types = [wgpu::BufferBindingType::Uniform, storage, storage];
        let layout = gpu.buffer_layout("craters", wgpu::ShaderStages::VERTEX, &types);
        let bound = [[0, 1], [1, 0]].map(|[before, after]| {
            let buffers = [
                &balls.constants,
                &balls.states[before],
                &balls.states[after],
            ];
            gpu.bind_buffers("craters", &layout, &buffers)
        });
        Ok(Self {
            way,
            constants: *constants,
            layers: (0..LAYERS).map(layer).collect(),
            pipeline: is_drawn.then(|| pipeline(gpu, &layout)).transpose()?,
            bound,
            known: Snapshot::new(first, terrain),
            written_bytes: 0,
            heights,
            balls,
        })
    }

    /// Puts everything back to where it began.
    pub(crate) fn begin(&mut self, first: &[State], terrain: &Terrain) -> Result<(), DeviceError> {
        let gpu = &self.balls.gpu;
        gpu.queue
            .write_buffer(&self.balls.states[0], 0, bytemuck::cast_slice(first));
        for (layer, heights) in (0..).zip(&terrain.blocks) {
            write_layer(gpu, &self.heights, layer, heights);
        }
        gpu.queue.submit([]);
        self.balls.current = 0;
        self.known = Snapshot::new(first, terrain);
        self.written_bytes = 0;
        self.balls.gpu.wait()
    }

    /// Takes a step, lets its craters into the layers, and waits.
    pub(crate) fn step(&mut self) -> Result<(), DeviceError> {
        match self.way {
            CraterWay::Nothing => self.balls.step(1),
            CraterWay::Drawn => self.step_and_draw(),
            CraterWay::Written => self.step_and_write(),
        }
    }

    fn step_and_draw(&mut self) -> Result<(), DeviceError> {
        let pipeline = self.pipeline.as_ref();
        let pipeline = pipeline.ok_or(DeviceError::Missing("what draws craters"))?;
        let before = self.balls.current;
        let count = self.constants.count;
        let gpu = std::sync::Arc::clone(&self.balls.gpu);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.balls.record(&mut encoder, 1);
        for (number, layer) in (0..).zip(&self.layers) {
            let target = terrafill_gpu::attached(layer, wgpu::LoadOp::Load);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("craters of a layer"),
                color_attachments: &[Some(target)],
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.bound[before], &[]);
            pass.draw(0..4, number * count..(number + 1) * count);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()
    }

    /// The CPU reads the balls, computes the heights that their craters reach, and writes those layers.
    fn step_and_write(&mut self) -> Result<(), DeviceError> {
        self.balls.step(1)?;
        let after = self.balls.read()?;
        let Snapshot {
            balls: before,
            ground: terrain,
        } = &mut self.known;
        let mut struck = BTreeSet::new();
        for (was, is) in before.iter().zip(&after) {
            if was[1][3] == 0.0 && is[1][3] != 0.0 {
                struck.extend(dig(&self.constants, was, is[1][3], terrain));
            }
        }
        for &block in &struck {
            let heights = &terrain.blocks[block as usize];
            write_layer(&self.balls.gpu, &self.heights, block, heights);
            self.written_bytes += 4 * heights.len() as u64;
        }
        *before = after;
        self.balls.gpu.queue.submit([]);
        self.balls.gpu.wait()
    }

    /// Balls and heights that the device has.
    pub(crate) fn read(&self) -> Result<Snapshot, DeviceError> {
        let whole = wgpu::TextureAspect::All;
        let bytes = terrafill_gpu::read_texture(&self.balls.gpu, &self.heights, whole)?;
        let blocks = bytes.chunks(4 * (SAMPLES * SAMPLES) as usize);
        let blocks = blocks.map(bytemuck::pod_collect_to_vec).collect();
        Ok(Snapshot {
            balls: self.balls.read()?,
            ground: Terrain { blocks },
        })
    }

    /// A picture of the ground and the balls as they are, numbers of each pixel.
    pub(crate) fn picture(&self, size: ImageSize) -> Result<Vec<u32>, DeviceError> {
        let balls = &self.balls.states[self.balls.current];
        BallScene::new(&self.balls.gpu, balls, &self.heights, size)?.draw(self.constants.count)
    }
}

/// What fragments write is taken off what the layer holds.
fn pipeline(
    gpu: &terrafill_gpu::Gpu,
    layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::RenderPipeline, DeviceError> {
    let needed = wgpu::Features::FLOAT32_BLENDABLE;
    gpu.require(needed, "blending of 32-bit floats")?;
    let module = gpu.shader(SHADER)?;
    let layout = gpu.pipeline_layout(SHADER, &[Some(layout)]);
    let less = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::ReverseSubtract,
    };
    let targets = [Some(wgpu::ColorTargetState {
        format: wgpu::TextureFormat::R32Float,
        blend: Some(wgpu::BlendState {
            color: less,
            alpha: less,
        }),
        write_mask: wgpu::ColorWrites::ALL,
    })];
    let mut described = terrafill_gpu::described(SHADER, &layout, &module, &targets);
    described.primitive.topology = wgpu::PrimitiveTopology::TriangleStrip;
    Ok(gpu.create_render_pipeline(&described))
}

/// Twin of `balls/craters.wgsl` in `f32`: lets a crater into all blocks that it reaches.
///
/// - `was`: the ball before the step in which it meets the ground
/// - `met`: when it does, steps
/// - returns: those blocks
fn dig(constants: &BallConstants, was: &State, met: f32, terrain: &mut Terrain) -> Vec<u32> {
    let [place, velocity] = was.map(|of| Vec3::from_slice(&of));
    let time = (met - was[0][3]) * constants.step_s;
    let speed = (velocity - Vec3::Z * (constants.gravity * time)).length();
    let radius = constants.crater_s * speed;
    let at = (place + time * velocity).truncate() / constants.cell_m;
    let cells = radius / constants.cell_m;
    let last = Vec2::splat(CELLS as f32);
    let mut reached = Vec::new();
    for (block, heights) in (0..).zip(&mut terrain.blocks) {
        let first = [block % BLOCKS, block / BLOCKS].map(|of| (of * CELLS) as f32);
        let local = at - Vec2::from(first);
        let [low, high] = [local - cells, local + cells];
        if low.cmpgt(last).any() || high.cmplt(Vec2::ZERO).any() {
            continue;
        }
        let held = |of: Vec2| of.clamp(Vec2::ZERO, last).as_uvec2();
        let [low, high] = [held(low.ceil()), held(high.floor())];
        for (x, y) in (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| (x, y))) {
            let away = (Vec2::new(x as f32, y as f32) - local) / cells;
            let below = constants.crater_depth * radius * (1.0 - away.length_squared()).max(0.0);
            heights[(y * SAMPLES + x) as usize] -= below;
        }
        reached.push(block);
    }
    reached
}
