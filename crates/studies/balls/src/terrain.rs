// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain under the balls in blocks, its view, and where a ball in free flight meets it, in `f64`: what devices are
//! held against.
//!
//! Metres from the terrain's corner, z up. Blocks share the samples of their borders. Sides of cells and blocks are
//! powers of two, so that `f32` chooses a block without rounding.

use crate::arithmetic::Real as _;
use crate::closed_form::GRAVITY;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;
use terrafill_shapes::grid::{GridCamera, NEAR_M};
use terrafill_shapes::rays::{Judged, judge_points};

/// Place and velocity of a ball, four numbers each as published. Over terrain the place's fourth is the steps taken. The
/// velocity's fourth is the time of the first impact in steps, 0 before it.
pub(crate) type State = [[f32; 4]; 2];

/// Blocks along a side of the terrain.
pub(crate) const BLOCKS: u32 = 4;
/// Cells along a side of a block, as published.
pub(crate) const CELLS: u32 = 256;
/// Samples along a side of a block.
pub(crate) const SAMPLES: u32 = CELLS + 1;
/// A side of a cell.
pub(crate) const CELL_M: f64 = 0.25;
pub(crate) const SIDE_M: f64 = 256.0;
/// Of shares of a cell, and of lengths of a ray.
const SLACK: f64 = 1e-9;
/// No ball begins nearer to the terrain's border: in a second none flies as far.
const MARGIN_M: f64 = 8.0;
/// Balls begin as high as this above the ground, metres, and as fast as this at most, metres a second.
const ABOVE_M: [f64; 2] = [0.1, 1.3];
const FASTEST: f64 = 3.0;

/// Heights of samples in blocks, bilinear between.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Terrain {
    /// Of each block [`SAMPLES`]² heights, row by row; blocks row by row.
    pub(crate) blocks: Vec<Vec<f32>>,
}

impl Terrain {
    /// Waves of 2 m, 40 m and 30 m long, with ripples of 10 cm, 5 m long.
    pub(crate) fn new() -> Self {
        Self::of(|x, y| {
            let wave = 2.0 * (TAU * x / 40.0).sin() * (TAU * y / 30.0 + 0.3).sin();
            wave + 0.1 * (TAU * (x + 0.7 * y) / 5.0).sin()
        })
    }

    /// Level ground at height 0: other ground than that of devices.
    #[cfg(test)]
    pub(crate) fn flat() -> Self {
        Self::of(|_, _| 0.0)
    }

    fn of(height: impl Fn(f64, f64) -> f64) -> Self {
        let block = |number: u32| {
            let first = [number % BLOCKS, number / BLOCKS].map(|at| at * CELLS);
            let sample = |at: u32| {
                let [x, y] = [first[0] + at % SAMPLES, first[1] + at / SAMPLES];
                // The nearest f32 is the height that device and reference share.
                f32::of(height(f64::from(x) * CELL_M, f64::from(y) * CELL_M))
            };
            (0..SAMPLES * SAMPLES).map(sample).collect()
        };
        Self {
            blocks: (0..BLOCKS * BLOCKS).map(block).collect(),
        }
    }

    /// The cell that a place lies in, or the nearest one; numbered from the terrain's corner.
    pub(crate) fn cell_of(place: DVec2) -> DVec2 {
        let last = f64::from(BLOCKS * CELLS - 1);
        (place / CELL_M)
            .floor()
            .clamp(DVec2::ZERO, DVec2::splat(last))
    }

    /// A cell's surface: the height is `a + b x + c y + d x y` of shares of the cell.
    pub(crate) fn surface(&self, cell: DVec2) -> [f64; 4] {
        let [x, y] = cell.to_array().map(whole);
        let block = &self.blocks[(y / CELLS * BLOCKS + x / CELLS) as usize];
        let side = SAMPLES as usize;
        let first = (y % CELLS) as usize * side + (x % CELLS) as usize;
        let corner = |offset: usize| f64::from(block[first + offset]);
        let (a, b, c) = (corner(0), corner(1) - corner(0), corner(side) - corner(0));
        [a, b, c, corner(side + 1) - corner(side) - b]
    }

    /// Height of the ground at a place, and its slopes along x and y.
    pub(crate) fn at(&self, place: DVec2) -> (f64, DVec2) {
        self.at_in(Self::cell_of(place), place)
    }

    /// The same of a cell's own surface, which goes on beyond its borders.
    pub(crate) fn at_in(&self, cell: DVec2, place: DVec2) -> (f64, DVec2) {
        let share = place / CELL_M - cell;
        let [a, b, c, d] = self.surface(cell);
        let height = a + b * share.x + c * share.y + d * share.x * share.y;
        let slopes = DVec2::new(b + d * share.y, c + d * share.x) / CELL_M;
        (height, slopes)
    }

    /// When a ball in free flight first meets the ground, seconds from now, exact but for rounding: over a cell the
    /// gap is a quadratic of time. `None` where it does not within this time, or leaves the terrain.
    ///
    /// - `ball`: place and velocity
    pub(crate) fn meets(&self, ball: &[DVec3; 2], within_s: f64) -> Option<f64> {
        let first =
            |cell, [now, until]: [f64; 2]| first_at_or_below(self.gap(cell, ball), now, until);
        walk(ball, [0.0, within_s], first)
    }

    /// The first triangle on a ray: its number from 0, and how many times the direction long the ray is. `None` where it
    /// meets none. Cells are cut as they are drawn, from the right sample to the one below.
    ///
    /// - `ray`: an eye outside of the terrain, and a direction
    /// - `within`: between which lengths the ray is over the terrain
    pub(crate) fn triangle(&self, ray: &[DVec3; 2], within: [f64; 2]) -> Option<(u32, f64)> {
        walk(ray, within, |cell, reach| {
            let [a, b, c, d] = self.surface(cell);
            let [at, by] = [
                ray[0].truncate() / CELL_M - cell,
                ray[1].truncate() / CELL_M,
            ];
            let meet = |half: u32, [base, across, down]: [f64; 3]| {
                let gap = ray[0].z - base - across * at.x - down * at.y;
                let length = gap / (across * by.x + down * by.y - ray[1].z);
                let place = at + length * by;
                // Rounding must not open a crack between halves or cells.
                let is_inside = length >= reach[0] - SLACK && length <= reach[1] + SLACK;
                let beyond_cut = place.x + place.y - 1.0;
                let is_own = if half == 0 { beyond_cut } else { -beyond_cut } <= SLACK;
                (is_inside && is_own).then_some((half, length))
            };
            let halves = [meet(0, [a, b, c]), meet(1, [a - d, b + d, c + d])];
            let (half, length) = halves
                .into_iter()
                .flatten()
                .min_by(|one, other| one.1.total_cmp(&other.1))?;
            let [x, y] = cell.to_array().map(whole);
            Some((2 * (y * BLOCKS * CELLS + x) + half, length))
        })
    }

    /// Corners of a triangle of [`Self::triangle`], metres.
    pub(crate) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let (cell, half) = (triangle / 2, f64::from(triangle % 2));
        let [x, y] = [cell % (BLOCKS * CELLS), cell / (BLOCKS * CELLS)].map(f64::from);
        let [a, b, c, d] = self.surface(DVec2::new(x, y));
        let corner = |[across, down]: [f64; 2]| {
            let height = a + b * across + c * down + d * across * down;
            (CELL_M * DVec2::new(x + across, y + down)).extend(height)
        };
        [[1.0, 0.0], [0.0, 1.0], [half, half]].map(corner)
    }

    /// Gap of a ball in free flight over a cell's surface: coefficients of time, its square last.
    fn gap(&self, cell: DVec2, [place, velocity]: &[DVec3; 2]) -> [f64; 3] {
        let [a, b, c, d] = self.surface(cell);
        let at = place.truncate() / CELL_M - cell;
        let by = velocity.truncate() / CELL_M;
        [
            place.z - (a + b * at.x + c * at.y + d * at.x * at.y),
            velocity.z - (b * by.x + c * by.y + d * (at.x * by.y + at.y * by.x)),
            -0.5 * GRAVITY - d * by.x * by.y,
        ]
    }

    /// Balls above the ground that fly level in all directions. Places follow a sequence that fills the terrain evenly
    /// (Roberts 2018), so that a ball is the same however many there are.
    pub(crate) fn balls(&self, count: u32) -> Vec<State> {
        let ball = |number: u32| {
            let of = |step: f64| (0.5 + step * f64::from(number)).fract();
            let share = DVec2::new(of(0.754_877_666_246_692_8), of(0.569_840_290_998_053_2));
            let place = MARGIN_M + (SIDE_M - 2.0 * MARGIN_M) * share;
            let rising = of(0.618_033_988_749_894_9);
            let above = ABOVE_M[0] + (ABOVE_M[1] - ABOVE_M[0]) * rising;
            let speed = FASTEST * of(0.819_172_513_396_164_4);
            let velocity = speed * DVec2::from_angle(TAU * of(0.671_043_606_703_789_2));
            let place = place.extend(self.at(place).0 + above).as_vec3();
            let velocity = velocity.extend(0.0).as_vec3();
            [place, velocity].map(|of| of.extend(0.0).to_array())
        };
        (0..count).map(ball).collect()
    }
}

/// Visits the cells below a path one after the other, with the times at which it enters and leaves each, until one
/// answers or it leaves the terrain.
///
/// - `path`: place and velocity; what bends it vertically does not matter
fn walk<T>(
    [place, velocity]: &[DVec3; 2],
    [mut now, end]: [f64; 2],
    mut visit: impl FnMut(DVec2, [f64; 2]) -> Option<T>,
) -> Option<T> {
    let [place, velocity] = [place.truncate(), velocity.truncate()];
    let mut cell = Terrain::cell_of(place + now * velocity);
    loop {
        let mut until = end;
        let mut onward = DVec2::ZERO;
        for axis in [DVec2::X, DVec2::Y] {
            let speed = velocity.dot(axis);
            let border = (cell.dot(axis) + f64::from(speed > 0.0)) * CELL_M;
            let leaves = (border - place.dot(axis)) / speed;
            if speed.abs() > 0.0 && leaves < until {
                until = leaves;
                onward = axis * speed.signum();
            }
        }
        let until = until.max(now);
        if let Some(found) = visit(cell, [now, until]) {
            return Some(found);
        }
        now = until;
        cell += onward;
        let is_there = Terrain::cell_of((cell + 0.5) * CELL_M) == cell;
        if onward == DVec2::ZERO || !is_there {
            return None;
        }
    }
}

/// First time from `now` to `until` at which a quadratic is not above 0.
fn first_at_or_below([constant, linear, square]: [f64; 3], now: f64, until: f64) -> Option<f64> {
    let at = |time: f64| constant + time * (linear + time * square);
    if at(now) <= 0.0 {
        return Some(now);
    }
    let discriminant = linear * linear - 4.0 * square * constant;
    if discriminant < 0.0 {
        return None;
    }
    // Both roots without cancellation; what is no number lies nowhere.
    let half = -0.5 * (linear + discriminant.sqrt().copysign(linear));
    let roots = [half / square, constant / half].into_iter();
    let inside = roots.filter(|root| (now..=until).contains(root));
    inside.min_by(f64::total_cmp)
}

/// A place in a picture or among cells without its fraction. Whoever calls makes sure that it lies there.
#[allow(
    clippy::cast_possible_truncation,
    reason = "not negative, and at most some thousands"
)]
pub(crate) fn whole(place: f64) -> u32 {
    place as u32
}

/// 60°, which hold the whole terrain.
pub(crate) const TAN_HALF_VIEW: f64 = 0.577_350_269_189_625_8;

/// From where the balls are seen.
pub(crate) fn ball_view() -> GridCamera {
    let (eye, target) = (
        DVec3::new(120.0, -160.0, 152.0),
        DVec3::new(128.0, 96.0, 0.0),
    );
    GridCamera::looking(eye, target, TAN_HALF_VIEW)
}

/// Twin of `PointConstants` in `balls/points.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PointConstants([[f32; 4]; 4]);

impl PointConstants {
    /// Reversed depth with the far plane at infinity.
    pub(crate) fn new(view: &GridCamera) -> Self {
        let clip = view.clip_from_world();
        let columns = [clip.x_axis, clip.y_axis, clip.z_axis, clip.w_axis];
        Self(columns.map(|column| column.as_vec4().to_array()))
    }
}

/// Holds a picture of numbers against the balls' places: a ball covers the pixel that it lies in, the nearest one
/// before others.
pub(crate) fn judge(view: &GridCamera, size: [u32; 2], balls: &[State], numbers: &[u32]) -> Judged {
    let project = |ball: &State| {
        let (at, away) = view.project(DVec3::from_slice(&ball[0].map(f64::from)), size);
        // What is nearer than the near plane is in no pixel.
        if away < NEAR_M {
            (DVec2::NAN, away)
        } else {
            (at, away)
        }
    };
    let places: Vec<(DVec2, f64)> = balls.iter().map(project).collect();
    judge_points(numbers, size, &places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_those_of_samples_in_every_block_and_slopes_those_of_differences() {
        let terrain = Terrain::new();
        // Sample 20, 10 of the block in column 2, row 1.
        let (height, _) = terrain.at(DVec2::new(2.0, 1.0) * 64.0 + DVec2::new(5.0, 2.5));
        let sample = terrain.blocks[6][10 * SAMPLES as usize + 20];
        assert!((height - f64::from(sample)).abs() < 1e-12);
        // Negative control: another layer has another height there.
        assert!((height - f64::from(terrain.blocks[9][10 * SAMPLES as usize + 20])).abs() > 1e-3);
        let place = DVec2::new(100.3, 200.6);
        let (height, slopes) = terrain.at(place);
        let beside = |off: DVec2| (terrain.at(place + off).0 - height) / 1e-4;
        assert!((beside(DVec2::X * 1e-4) - slopes.x).abs() < 1e-6);
        assert!((beside(DVec2::Y * 1e-4) - slopes.y).abs() < 1e-6);
        assert!(slopes.length() > 1e-3);
        // Blocks agree at their border.
        let border = DVec2::new(64.0, 17.2);
        let one = terrain.at(border - DVec2::X * 1e-9).0;
        assert!((one - terrain.at(border).0).abs() < 1e-8);
    }

    #[test]
    fn balls_meet_the_ground_when_small_steps_say_so() {
        let (terrain, level) = (Terrain::new(), Terrain::flat());
        for ball in terrain.balls(300) {
            let ball = ball.map(|of| DVec3::from_slice(&of.map(f64::from)));
            let exact = terrain.meets(&ball, 1.0).expect("it falls");
            let gap = |time: f64| {
                let fallen = DVec3::Z * (0.5 * GRAVITY * time * time);
                let place = ball[0] + ball[1] * time - fallen;
                place.z - terrain.at(place.truncate()).0
            };
            assert!(gap(exact).abs() < 1e-9, "{ball:?}: {}", gap(exact));
            let is_above = (0..1_000).all(|part| gap(exact * f64::from(part) / 1e3) > 0.0);
            assert!(is_above, "{ball:?}");
            // Negative control: over level ground it is another time.
            let other = level.meets(&ball, 1.0);
            assert!(other.is_none_or(|other| (other - exact).abs() > 1e-6));
        }
    }

    #[test]
    fn every_ball_is_on_screen() {
        let view = ball_view();
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
        let view = ball_view();
        let balls = Terrain::flat().balls(100);
        let nothing = vec![0; 256 * 256];
        assert!(judge(&view, [256; 2], &balls, &nothing).mismatched > 50);
        let all = vec![1; 256 * 256];
        assert!(judge(&view, [256; 2], &balls, &all).mismatched > 60_000);
    }
}
