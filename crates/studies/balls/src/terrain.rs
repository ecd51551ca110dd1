// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain under the balls, its view, and a step over it in `f64`: what devices are held against.
//!
//! Metres from the terrain's corner, z up. The tile is small, so that `f32` moves a ball by 2 µm at
//! worst when it rounds a place.

use crate::arithmetic::Real as _;
use crate::closed_form::GRAVITY;
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::f64::consts::TAU;

/// Place and velocity of a ball, four numbers each as published.
pub(crate) type State = [[f32; 4]; 2];

/// A side, cells.
pub(crate) const CELLS: u32 = 64;
/// A side of a cell.
pub(crate) const CELL_M: f64 = 1.0;
pub(crate) const SIDE_M: f64 = 64.0;

/// Heights of (cells + 1)² vertices, bilinear between.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Terrain {
    pub(crate) heights: Vec<f32>,
}

impl Terrain {
    /// Waves of 2 m, 40 m and 30 m long.
    pub(crate) fn new() -> Self {
        let wave = |column: u32, row: u32| {
            let x = TAU * f64::from(column) * CELL_M / 40.0;
            let y = TAU * f64::from(row) * CELL_M / 30.0 + 0.3;
            // The nearest f32 is the height that device and reference share.
            f32::of(2.0 * x.sin() * y.sin())
        };
        let rows = 0..=CELLS;
        let vertices = rows.flat_map(|row| (0..=CELLS).map(move |column| wave(column, row)));
        Self {
            heights: vertices.collect(),
        }
    }

    /// Level ground at height 0: other ground than that of devices.
    #[cfg(test)]
    pub(crate) fn flat() -> Self {
        Self {
            heights: vec![0.0; (CELLS as usize + 1).pow(2)],
        }
    }

    /// The cell that a place lies in, or the nearest one.
    pub(crate) fn cell_of(place: DVec2) -> DVec2 {
        let last = f64::from(CELLS - 1);
        (place / CELL_M)
            .floor()
            .clamp(DVec2::ZERO, DVec2::splat(last))
    }

    /// Height of the ground at a place, and its slopes along x and y.
    pub(crate) fn at(&self, place: DVec2) -> (f64, DVec2) {
        self.at_in(Self::cell_of(place), place)
    }

    /// The same of a cell's own surface, which goes on beyond its borders.
    fn at_in(&self, cell: DVec2, place: DVec2) -> (f64, DVec2) {
        let share = place / CELL_M - cell;
        let side = CELLS as usize + 1;
        let first = whole(cell.y) as usize * side + whole(cell.x) as usize;
        let corner = |offset: usize| f64::from(self.heights[first + offset]);
        // h = a + b x + c y + d x y on a cell.
        let (a, b, c) = (corner(0), corner(1) - corner(0), corner(side) - corner(0));
        let d = corner(side + 1) - corner(side) - b;
        let height = a + b * share.x + c * share.y + d * share.x * share.y;
        let slopes = DVec2::new(b + d * share.y, c + d * share.x) / CELL_M;
        (height, slopes)
    }

    /// Whether a ball at a place pushes the ground of a cell in.
    pub(crate) fn touches(&self, cell: DVec2, place: DVec3) -> bool {
        self.at_in(cell, place.truncate()).0 > place.z
    }

    /// Takes a step of symplectic Euler: a spring pushes along the normal.
    pub(crate) fn step(&self, ball: &mut [DVec3; 2], step_s: f64, stiffness: f64) {
        let cell = Self::cell_of(ball[0].truncate());
        self.step_in(cell, ball, step_s, stiffness);
    }

    /// The same over a cell's own surface.
    pub(crate) fn step_in(&self, cell: DVec2, ball: &mut [DVec3; 2], step_s: f64, stiffness: f64) {
        let [place, velocity] = ball;
        let (height, slopes) = self.at_in(cell, place.truncate());
        let mut acceleration = DVec3::new(0.0, 0.0, -GRAVITY);
        let under = height - place.z;
        if under > 0.0 {
            let normal = (-slopes).extend(1.0).normalize();
            acceleration += normal * (stiffness * under * normal.z);
        }
        *velocity += acceleration * step_s;
        *place += *velocity * step_s;
    }

    /// Balls at rest from 0.1 to 0.3 m above the ground, evenly over all of it.
    pub(crate) fn balls(&self, count: u32) -> Vec<State> {
        let side = whole(f64::from(count).sqrt().ceil());
        let along = |number: u32| (f64::from(number) + 0.5) / f64::from(side) * SIDE_M;
        let ball = |number: u32| {
            let place = DVec2::new(along(number % side), along(number / side));
            let above = 0.1 + 0.2 * (f64::from(number) + 0.5) / f64::from(count);
            let place = place.extend(self.at(place).0 + above).as_vec3();
            [place.extend(1.0).to_array(), [0.0; 4]]
        };
        (0..count).map(ball).collect()
    }
}

/// A place in a picture or among cells without its fraction. Whoever calls makes sure that it lies there.
#[allow(
    clippy::cast_possible_truncation,
    reason = "not negative, and at most some thousands"
)]
fn whole(place: f64) -> u32 {
    place as u32
}

/// From where the balls are seen: an eye, the axes of the screen, and the tangent of half the field of view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BallView {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

/// 60°, which hold the whole terrain.
const TAN_HALF_VIEW: f64 = 0.577_350_269_189_625_8;
const NEAR_M: f64 = 1.0;

impl BallView {
    pub(crate) fn new() -> Self {
        let eye = DVec3::new(30.0, -40.0, 38.0);
        let forward = (DVec3::new(32.0, 24.0, 0.0) - eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
        }
    }

    /// Place on a picture, pixels, and distance along the view's axis.
    pub(crate) fn project(&self, place: DVec3, size: [u32; 2]) -> (DVec2, f64) {
        let from_eye = place - self.eye;
        let away = from_eye.dot(self.forward);
        let [width, height] = size.map(f64::from);
        let across = from_eye.dot(self.right) / (away * TAN_HALF_VIEW);
        let upwards = from_eye.dot(self.up) / (away * TAN_HALF_VIEW);
        let at = DVec2::new(0.5 * width * (1.0 + across), 0.5 * height * (1.0 - upwards));
        (at, away)
    }
}

/// Twin of `PointConstants` in `balls/points.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PointConstants([[f32; 4]; 4]);

impl PointConstants {
    /// Reversed depth with the far plane at infinity.
    pub(crate) fn new(view: &BallView) -> Self {
        let axes = [view.right, view.up, -view.forward];
        let rows = axes.map(|axis| axis.extend(-axis.dot(view.eye)));
        let view_from_place = DMat4::from_cols(rows[0], rows[1], rows[2], DVec4::W).transpose();
        let scale = TAN_HALF_VIEW.recip();
        let clip_from_view = DMat4::from_cols(
            DVec4::X * scale,
            DVec4::Y * scale,
            DVec4::NEG_W,
            DVec4::Z * NEAR_M,
        );
        let clip = clip_from_view * view_from_place;
        let columns = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis];
        Self(columns.map(|column| column.as_vec4().to_array()))
    }
}

/// What a picture of balls shows that it should not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct JudgedBalls {
    pub(crate) mismatched: usize,
    pub(crate) shown: usize,
}

/// Half a step of the coarsest grid that points may be snapped to, pixels.
const BAND_PX: f64 = 1.0 / 32.0;
/// Depths closer than this share are equal to `f32`.
const EQUAL_DEPTH: f64 = 1e-6;

/// Holds a picture of numbers against the balls' places: a ball covers the pixel that it lies in, the nearest one
/// before others.
pub(crate) fn judge(
    view: &BallView,
    size: [u32; 2],
    balls: &[State],
    numbers: &[u32],
) -> JudgedBalls {
    let width = size[0] as usize;
    let project = |ball: &State| {
        let [x, y, z, _] = ball[0].map(f64::from);
        view.project(DVec3::new(x, y, z), size)
    };
    // Nearest ball that is in each pixel whatever the rounding.
    let mut sure = vec![f64::INFINITY; numbers.len()];
    for ball in balls {
        let (at, away) = project(ball);
        let inside = at - at.floor();
        let is_sure = inside.min_element() >= BAND_PX && inside.max_element() <= 1.0 - BAND_PX;
        let end = DVec2::from(size.map(f64::from));
        if !is_sure || at.min_element() < 0.0 || at.cmpge(end).any() || away < NEAR_M {
            continue;
        }
        let pixel = whole(at.y) as usize * width + whole(at.x) as usize;
        sure[pixel] = sure[pixel].min(away);
    }
    let mut judged = JudgedBalls::default();
    for (pixel, &number) in numbers.iter().enumerate() {
        let is_right = match number
            .checked_sub(1)
            .and_then(|ball| balls.get(ball as usize))
        {
            None => number == 0 && sure[pixel].is_infinite(),
            Some(ball) => {
                let (at, away) = project(ball);
                let corner = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
                let inside = at - corner;
                let is_here =
                    inside.min_element() >= -BAND_PX && inside.max_element() <= 1.0 + BAND_PX;
                is_here && away <= sure[pixel] * (1.0 + EQUAL_DEPTH)
            }
        };
        judged.shown += usize::from(number > 0);
        judged.mismatched += usize::from(!is_right);
    }
    judged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_those_of_vertices_and_slopes_those_of_differences() {
        let terrain = Terrain::new();
        let (height, _) = terrain.at(DVec2::new(10.0, 20.0));
        assert!((height - f64::from(terrain.heights[20 * 65 + 10])).abs() < 1e-12);
        let place = DVec2::new(10.3, 20.6);
        let (height, slopes) = terrain.at(place);
        let beside = |off: DVec2| (terrain.at(place + off).0 - height) / 1e-4;
        assert!((beside(DVec2::X * 1e-4) - slopes.x).abs() < 1e-6);
        assert!((beside(DVec2::Y * 1e-4) - slopes.y).abs() < 1e-6);
        assert!(slopes.length() > 1e-3);
    }

    #[test]
    fn every_ball_is_on_screen() {
        let view = BallView::new();
        for ball in Terrain::new().balls(1_000) {
            let [x, y, z, _] = ball[0].map(f64::from);
            let (at, away) = view.project(DVec3::new(x, y, z), [256; 2]);
            assert!(
                away > NEAR_M && at.min_element() > 0.0 && at.max_element() < 256.0,
                "{at}"
            );
        }
    }

    #[test]
    fn an_empty_picture_and_one_of_other_balls_are_wrong() {
        let view = BallView::new();
        let balls = Terrain::flat().balls(100);
        let nothing = vec![0; 256 * 256];
        assert!(judge(&view, [256; 2], &balls, &nothing).mismatched > 50);
        let all = vec![1; 256 * 256];
        assert!(judge(&view, [256; 2], &balls, &all).mismatched > 60_000);
    }
}
