// SPDX-License-Identifier: MIT OR Apache-2.0
//! Balls that a thread of the CPU steps in `f32`, as devices do, and writes for Vulkan to draw.

use crate::drawing::{DrawsBalls, VulkanPoints};
use crate::flight::Law;
use crate::steps::{BallConstants, Steps};
use crate::terrain::{BLOCKS, CELLS, SAMPLES, State, Terrain};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices};
use terrafill_scene::ImageSize;
use terrafill_vulkan::{Buffer, BufferUse};

/// Chords that find where a step meets the ground, as the shader has them.
const CUTS: u32 = 8;

pub(crate) struct ByCpu {
    gpu: Arc<terrafill_vulkan::Gpu>,
    constants: BallConstants,
    /// As one array, like the device's texture; `None` for level ground with a spring.
    heights: Option<Vec<f32>>,
    balls: Vec<State>,
    drawn: Arc<Buffer>,
}

impl ByCpu {
    pub(crate) fn new(
        devices: &Devices,
        constants: &BallConstants,
        balls: &[State],
        terrain: Option<&Terrain>,
    ) -> Result<Self, DeviceError> {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        let bytes: &[u8] = bytemuck::cast_slice(balls);
        let drawn = Buffer::streamed(&gpu, "balls", bytes.len() as u64, BufferUse::State)?;
        drawn.stream(bytes)?;
        Ok(Self {
            gpu,
            constants: *constants,
            heights: terrain.map(|terrain| terrain.blocks.concat()),
            balls: balls.to_vec(),
            drawn: Arc::new(drawn),
        })
    }
}

impl Steps for ByCpu {
    fn step(&mut self, count: u32) -> Result<(), DeviceError> {
        for _ in 0..count {
            if let Some(heights) = &self.heights {
                let ground = Ground {
                    constants: &self.constants,
                    heights,
                };
                self.balls.iter_mut().for_each(|ball| ground.step(ball));
            } else {
                let constants = &self.constants;
                self.balls.iter_mut().for_each(|ball| push(constants, ball));
            }
        }
        self.drawn.stream(bytemuck::cast_slice(&self.balls))
    }

    fn gpu_ms(&self) -> Result<Option<f64>, DeviceError> {
        Ok(None)
    }

    fn read(&self) -> Result<Vec<State>, DeviceError> {
        Ok(self.balls.clone())
    }

    fn uploaded(&self) -> u64 {
        self.gpu.work_done().upload_bytes
    }

    fn current(&self) -> usize {
        0
    }

    fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError> {
        let states = [Arc::clone(&self.drawn), Arc::clone(&self.drawn)];
        Ok(Box::new(VulkanPoints::new(&self.gpu, &states, size)?))
    }
}

/// A step over level ground with a spring, as `balls/step.wgsl`.
fn push(constants: &BallConstants, [place, velocity]: &mut State) {
    let mut acceleration = -constants.gravity;
    if place[2] < 0.0 {
        acceleration -= constants.stiffness * place[2];
    }
    velocity[2] += constants.step_s * acceleration;
    place[2] += constants.step_s * velocity[2];
}

/// Twin of `balls/fly.wgsl` in `f32`.
struct Ground<'a> {
    constants: &'a BallConstants,
    heights: &'a [f32],
}

impl Ground<'_> {
    /// Slopes along x and y, and height.
    fn at(&self, place: Vec2) -> Vec3 {
        let at = place / self.constants.cell_m;
        let last = Vec2::splat(BLOCKS as f32 - 1.0);
        let block = (at / CELLS as f32).floor().clamp(Vec2::ZERO, last);
        let inside = at - block * CELLS as f32;
        let last = Vec2::splat(CELLS as f32 - 1.0);
        let cell = inside.floor().clamp(Vec2::ZERO, last);
        let share = inside - cell;
        let (block, cell) = (block.as_uvec2(), cell.as_uvec2());
        let row = (block.y * BLOCKS + block.x) * SAMPLES + cell.y;
        let first = (row * SAMPLES + cell.x) as usize;
        let side = SAMPLES as usize;
        let [near, right, below, far] =
            [0, 1, side, side + 1].map(|offset| self.heights[first + offset]);
        let mix = |one: f32, other: f32, share: f32| one + share * (other - one);
        let across = mix(right - near, far - below, share.y);
        let down = mix(below - near, far - right, share.x);
        let height = mix(near, right, share.x) + share.y * down;
        let cell_m = self.constants.cell_m;
        Vec3::new(across / cell_m, down / cell_m, height)
    }

    fn flown(&self, place: Vec3, velocity: Vec3, time: f32) -> Vec3 {
        let upwards = velocity.z - 0.5 * self.constants.gravity * time;
        place + time * velocity.truncate().extend(upwards)
    }

    fn gap(&self, place: Vec3) -> f32 {
        place.z - self.at(place.truncate()).z
    }

    /// The share of a step at which a ball meets the ground that it is below at its end.
    fn meets(&self, place: Vec3, velocity: Vec3, end: f32) -> f32 {
        let (mut low, mut high) = ([0.0, self.gap(place)], [1.0, end]);
        if low[1] <= 0.0 {
            return 0.0;
        }
        let mut side = 0;
        for _ in 0..CUTS {
            let share = (high[0] * low[1] - low[0] * high[1]) / (low[1] - high[1]);
            let found = self.gap(self.flown(place, velocity, share * self.constants.step_s));
            if found > 0.0 {
                low = [share, found];
                high[1] *= if side == 1 { 0.5 } else { 1.0 };
                side = 1;
            } else {
                high = [share, found];
                low[1] *= if side == -1 { 0.5 } else { 1.0 };
                side = -1;
            }
        }
        high[0]
    }

    fn step(&self, ball: &mut State) {
        let BallConstants {
            step_s,
            gravity,
            restitution,
            law,
            ..
        } = *self.constants;
        let is_event = law == Law::Event.number();
        let [place, velocity] = ball.map(|of| Vec3::from_slice(&of));
        let mut to = self.flown(place, velocity, step_s);
        let mut onward = velocity - Vec3::Z * (gravity * step_s);
        let mut ground = self.at(to.truncate());
        if to.z < ground.z {
            let mut share = 1.0;
            if is_event {
                share = self.meets(place, velocity, to.z - ground.z);
                to = self.flown(place, velocity, share * step_s);
                ground = self.at(to.truncate());
                onward.z = velocity.z - gravity * share * step_s;
            }
            let normal = Vec3::new(-ground.x, -ground.y, 1.0).normalize();
            let outwards = onward.dot(normal);
            if outwards < 0.0 || law == Law::Published.number() {
                onward -= (1.0 + restitution) * outwards * normal;
                if ball[1][3] == 0.0 {
                    ball[1][3] = ball[0][3] + share;
                }
            }
            if is_event {
                let rest = (1.0 - share) * step_s;
                to = self.flown(to.truncate().extend(ground.z), onward, rest);
                onward.z -= gravity * rest;
            }
        }
        *ball = [
            to.extend(ball[0][3] + 1.0).to_array(),
            onward.extend(ball[1][3]).to_array(),
        ];
    }
}
