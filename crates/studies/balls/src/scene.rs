// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain and the balls on it in one picture on wgpu, and rays in `f64` by which it is judged.
//!
//! A ball is a disc that faces the view and stands on the ball's place: a point would hardly be seen. Pixels hold numbers
//! of balls and of the terrain's triangles; their colours come from the slopes of the heights that the device has.

use crate::arithmetic::Real as _;
use crate::flight::normal_of;
use crate::terrain::{
    BLOCKS, CELL_M, CELLS, PointConstants, SIDE_M, State, TAN_HALF_VIEW, Terrain, ball_view,
};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use terrafill_contract::{DeviceError, ids_of};
use terrafill_gpu::{DirectPipeline, Gpu, RenderTargets};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::rays::{BAND_PX, Judged, distance_to_triangle};

const SHADER: &str = "balls/scene.wgsl";
/// The number of the terrain's first triangle: above all balls that are drawn.
const GROUND: u32 = 0x40_0000;
const CELLS_ACROSS: u32 = BLOCKS * CELLS;
const TRIANGLES: u32 = 2 * CELLS_ACROSS * CELLS_ACROSS;
/// Radius of a ball's disc, metres.
const RADIUS_M: f64 = 0.5;
/// Pixels that are held against rays, about.
const PIXELS: usize = 1 << 14;

/// Twin of `SceneConstants` in `balls/scene.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SceneConstants {
    view: PointConstants,
    radius_m: f32,
    radius_clip: f32,
    ground: u32,
    cells: u32,
    across: u32,
    cell_m: f32,
    padding: [u32; 2],
}

/// What draws terrain and balls.
pub(crate) struct BallScene {
    gpu: Arc<Gpu>,
    targets: RenderTargets,
    /// Of the ground, and of the balls.
    pipelines: [wgpu::RenderPipeline; 2],
    bound: wgpu::BindGroup,
}

impl BallScene {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        balls: &wgpu::Buffer,
        heights: &wgpu::Texture,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let constants = SceneConstants {
            view: PointConstants::new(&ball_view()),
            radius_m: f32::of(RADIUS_M),
            radius_clip: f32::of(RADIUS_M / TAN_HALF_VIEW),
            ground: GROUND,
            cells: CELLS,
            across: CELLS_ACROSS,
            cell_m: f32::of(CELL_M),
            padding: [0; 2],
        };
        let bytes = bytemuck::bytes_of(&constants);
        let constants = gpu.upload("scene of balls", bytes, wgpu::BufferUsages::UNIFORM)?;
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let types = [
            buffer(wgpu::BufferBindingType::Uniform),
            buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
        ];
        let layout = gpu.mixed_layout(
            "scene of balls",
            types.map(|ty| (wgpu::ShaderStages::VERTEX, ty)),
        );
        let view = heights.create_view(&Default::default());
        let resources = [
            constants.as_entire_binding(),
            balls.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
        ];
        let pipeline = |entry_point| {
            gpu.direct_pipeline(&DirectPipeline {
                path: SHADER,
                entry_point,
                topology: wgpu::PrimitiveTopology::TriangleList,
                format: None,
                layout: &layout,
            })
        };
        Ok(Self {
            gpu: Arc::clone(gpu),
            targets: RenderTargets::new(gpu, size)?,
            pipelines: [pipeline("ground_main")?, pipeline("ball_main")?],
            bound: gpu.bind("scene of balls", &layout, resources),
        })
    }

    /// Numbers of a picture's pixels, row by row; 0 is the sky.
    pub(crate) fn draw(&self, balls: u32) -> Result<Vec<u32>, DeviceError> {
        let mut frame = self.targets.direct_frame();
        let mut pass = self.targets.cleared_pass(&mut frame);
        pass.set_bind_group(0, &self.bound, &[]);
        let counts = [CELLS_ACROSS * CELLS_ACROSS, balls];
        for (pipeline, count) in self.pipelines.iter().zip(counts) {
            pass.set_pipeline(pipeline);
            pass.draw(0..6 * count, 0..1);
        }
        drop(pass);
        self.gpu.queue.submit([frame.encoder.finish()]);
        self.gpu.wait()?;
        Ok(ids_of(&self.targets.read()?))
    }
}

/// Terrain and balls, for rays.
pub(crate) struct SceneRays<'a> {
    terrain: &'a Terrain,
    view: GridCamera,
    size: [u32; 2],
    /// Lowest and highest height, metres.
    heights: [f64; 2],
    /// Of each ball's disc the middle and the radius on the picture, pixels, and its distance along the view's axis.
    discs: Vec<(DVec2, f64, f64)>,
}

impl<'a> SceneRays<'a> {
    pub(crate) fn new(terrain: &'a Terrain, balls: &[State], size: ImageSize) -> Self {
        let view = ball_view();
        let size = [size.width, size.height];
        let disc = |ball: &State| {
            let place = DVec3::from_slice(&ball[0].map(f64::from)) + DVec3::Z * RADIUS_M;
            let (at, away) = view.project(place, size);
            (
                at,
                0.5 * f64::from(size[0]) * RADIUS_M / (TAN_HALF_VIEW * away),
                away,
            )
        };
        let all = terrain.blocks.iter().flatten().copied().map(f64::from);
        let heights = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], of| {
            [low.min(of), high.max(of)]
        });
        Self {
            terrain,
            view,
            size,
            heights,
            discs: balls.iter().map(disc).collect(),
        }
    }

    /// What a ray through a place of the picture meets first, and how far along the view's axis.
    fn meet(&self, at_px: DVec2) -> (u32, f64) {
        let ground = self
            .ground(at_px)
            .map_or((0, f64::INFINITY), |(triangle, away)| {
                (GROUND + triangle, away)
            });
        let balls = (1..).zip(&self.discs);
        let covers =
            balls.filter(|(_, (at, radius, _))| at.distance_squared(at_px) <= radius * radius);
        let hits = covers.map(|(number, (.., away))| (number, *away));
        hits.fold(
            ground,
            |nearest, hit| if hit.1 < nearest.1 { hit } else { nearest },
        )
    }

    fn ground(&self, at_px: DVec2) -> Option<(u32, f64)> {
        let ray = [self.view.eye, self.view.direction(at_px, self.size)];
        let [eye, along] = ray;
        // Where the ray is over the terrain, and between its lowest and highest height.
        let ends = [
            DVec3::new(0.0, 0.0, self.heights[0]),
            DVec3::new(SIDE_M, SIDE_M, self.heights[1]),
        ];
        let [one, other] = ends.map(|end| (end - eye) / along);
        let [from, to] = [
            one.min(other).max_element().max(0.0),
            one.max(other).min_element(),
        ];
        if from > to {
            return None;
        }
        self.terrain.triangle(&ray, [from, to])
    }

    /// Holds every so many pixels against rays. A pixel may show what a ray within 1/32 pixel of its middle meets, or a
    /// triangle that lies within as much and is no farther.
    pub(crate) fn judge(&self, numbers: &[u32]) -> Judged {
        let width = self.size[0] as usize;
        // Shares no factor with the width, so that no column is left out.
        let mut every = (numbers.len() / PIXELS).max(1);
        while common_divisor(every, width) > 1 {
            every += 1;
        }
        let mut judged = Judged::default();
        for (pixel, &shown) in numbers.iter().enumerate().step_by(every) {
            let middle = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
            judged.add(shown, self.meet(middle).0, || self.may_show(middle, shown));
        }
        judged
    }

    /// Whether a picture shows any ball.
    pub(crate) fn shows_balls(numbers: &[u32]) -> bool {
        numbers.iter().any(|number| (1..GROUND).contains(number))
    }

    fn may_show(&self, middle: DVec2, shown: u32) -> bool {
        let ring = (0..8).map(|turn| {
            let angle = std::f64::consts::FRAC_PI_4 * f64::from(turn);
            self.meet(middle + BAND_PX * DVec2::from_angle(angle))
        });
        let ring: Vec<_> = ring.collect();
        if ring.iter().any(|(number, _)| *number == shown) {
            return true;
        }
        // A ball's disc hides the ground behind it.
        let is_ball = |number: u32| (1..GROUND).contains(&number);
        let around = ring.iter().filter(|(number, _)| !is_ball(*number));
        let farthest = around
            .map(|(_, away)| *away)
            .fold(f64::NEG_INFINITY, f64::max);
        let Some(triangle) = shown.checked_sub(GROUND) else {
            return false;
        };
        if triangle >= TRIANGLES {
            return false;
        }
        let corners = self.terrain.corners(triangle);
        let corners = corners.map(|place| self.view.project(place, self.size));
        let nearest = corners
            .iter()
            .map(|(_, away)| *away)
            .fold(f64::INFINITY, f64::min);
        nearest <= farthest && distance_to_triangle(middle, corners.map(|(at, _)| at)) <= BAND_PX
    }

    /// Colours of numbers: balls, the sky, and ground as light from the upper left shows its slopes.
    pub(crate) fn colours<'n>(&'n self, numbers: &'n [u32]) -> impl Iterator<Item = [u8; 3]> + 'n {
        let light = DVec3::new(-0.6, 0.3, 0.5).normalize();
        numbers
            .iter()
            .map(move |&number| match number.checked_sub(GROUND) {
                None if number == 0 => [205, 225, 240],
                None => [150, 30, 30],
                // A number of nothing, which the verdict names.
                Some(TRIANGLES..) => [255, 0, 255],
                Some(triangle) => {
                    let [one, other, end] = self.terrain.corners(triangle);
                    let rises = if triangle % 2 == 0 {
                        DVec2::new(one.z - end.z, other.z - end.z)
                    } else {
                        DVec2::new(end.z - other.z, end.z - one.z)
                    };
                    let slopes = rises / CELL_M;
                    #[allow(clippy::cast_possible_truncation, reason = "held between 0 and 255")]
                    let shade = |of: f64| {
                        (of * (0.2 + 0.9 * normal_of(slopes).dot(light).max(0.0))).min(255.0) as u8
                    };
                    [shade(190.0), shade(200.0), shade(160.0)]
                }
            })
    }
}

/// The greatest number that divides both.
fn common_divisor(mut one: usize, mut other: usize) -> usize {
    while other > 0 {
        (one, other) = (other, one % other);
    }
    one
}
