// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference: which triangle a pixel's ray meets first, and which point covers a pixel, in `f64`.
//!
//! Rays walk the cells below them one after the other and are intersected with both halves of each.
//! Nothing of what draws is used: no matrix, no list of vertices, no projection. Devices snap vertices to
//! 1/16 pixel or finer (the standard asks for four bits), so a pixel whose centre lies within [`BAND_PX`] of
//! a border may show either side. Every other difference is an error.

use crate::grid::{Grid, GridCamera};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use terrafill_scene::ImageSize;

/// Half a step of the coarsest grid that vertices may be snapped to.
pub const BAND_PX: f64 = 1.0 / 32.0;
/// Depths of points closer than this share are equal to `f32`: 2⁻²⁴ for the depth, a few times as much
/// for the sums behind it.
pub const EQUAL_DEPTH: f64 = 1e-6;

/// Bits of a number that a picture holds.
const SHOWN: u32 = 0xff_ffff;

/// How the cells of a grid are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cut {
    /// From (column + 1, row) to (column, row + 1), as published.
    Published,
    /// The other diagonal: what a wrong picture shows.
    #[cfg(test)]
    Other,
}

/// What a picture shows that it should not.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Judged {
    /// Pixels that show another triangle or point than they may.
    pub mismatched: usize,
    /// Pixels that differ from the centre's ray, within the band along a border.
    pub in_band: usize,
    /// Pixels that show the grid.
    pub shown: usize,
    /// Of each pixel, whether it is among the mismatched.
    pub wrong: Vec<bool>,
}

impl Judged {
    /// Counts a pixel.
    ///
    /// - `shown`, `truth`: number that the picture has and number that the ray meets; 0 is the sky
    /// - `may`: whether the picture may show it all the same
    pub fn add(&mut self, shown: u32, truth: u32, may: impl FnOnce() -> bool) {
        self.shown += usize::from(shown != 0);
        let differs = shown != truth;
        let is_wrong = differs && !may();
        self.in_band += usize::from(differs && !is_wrong);
        self.mismatched += usize::from(is_wrong);
        self.wrong.push(is_wrong);
    }
}

/// A grid and its view, for rays.
pub struct Rays<'a> {
    grid: &'a Grid,
    view: GridCamera,
    /// Pixels, across and down.
    size: [u32; 2],
    cut: Cut,
    lowest: f64,
    highest: f64,
}

/// What a ray meets.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// From 1, as it is drawn.
    pub number: u32,
    /// Distance along the view's axis, metres; of any ray, how many times its direction long it is.
    pub away_m: f64,
}

impl<'a> Rays<'a> {
    /// Rays over a grid that is seen so.
    #[must_use]
    pub fn new(grid: &'a Grid, view: GridCamera, size: ImageSize) -> Self {
        let heights = grid.heights.iter().copied().map(f64::from);
        Self {
            grid,
            view,
            size: [size.width, size.height],
            cut: Cut::Published,
            lowest: heights.clone().fold(f64::INFINITY, f64::min),
            highest: heights.fold(f64::NEG_INFINITY, f64::max),
        }
    }

    fn height(&self, column: u32, row: u32) -> f64 {
        f64::from(self.grid.heights[self.grid.index(column, row)])
    }

    /// Numbers of triangles at the centres of every so many pixels, 0 for none, each behind its pixel's number.
    pub fn picture(&self, every: usize) -> Vec<(usize, u32)> {
        let count = self.size[0] as usize * self.size[1] as usize;
        let pixels = (0..count).into_par_iter().step_by(every);
        pixels.map(|pixel| (pixel, self.number(pixel))).collect()
    }

    /// Number that the ray of a pixel's middle meets, 0 for the sky.
    #[must_use]
    pub fn number(&self, pixel: usize) -> u32 {
        self.meet(self.centre(pixel)).map_or(0, |hit| hit.number)
    }

    fn centre(&self, pixel: usize) -> DVec2 {
        let width = self.size[0] as usize;
        DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5
    }

    /// Middles of all pixels, row by row.
    pub fn centres(&self) -> impl Iterator<Item = DVec2> + use<> {
        centres(self.size)
    }

    /// Where a direction's part along the view's axis is 1.
    fn direction(&self, at_px: DVec2) -> DVec3 {
        self.view.direction(at_px, self.size)
    }

    /// The first triangle on the ray through a place of the picture.
    fn meet(&self, at_px: DVec2) -> Option<Hit> {
        self.follow(self.view.eye, self.direction(at_px))
    }

    /// Where the ray through a place of the picture, pixels, meets the ground, metres.
    pub fn place(&self, at_px: DVec2) -> Option<DVec3> {
        let hit = self.meet(at_px)?;
        Some(self.view.eye + self.direction(at_px) * hit.away_m)
    }

    /// Whether a ray meets the ground.
    pub fn hits(&self, from: DVec3, along: DVec3) -> bool {
        self.follow(from, along).is_some()
    }

    /// The first triangle on a ray.
    pub fn follow(&self, eye: DVec3, along: DVec3) -> Option<Hit> {
        let step_m = self.grid.step_m();
        // Columns, rows and metres from here on.
        let scale = DVec3::new(1.0 / step_m, 1.0 / step_m, 1.0);
        let (eye, along) = (eye * scale, along * scale);
        let side = f64::from(self.grid.cells);
        let (mut from, mut to) = (0.0_f64, f64::INFINITY);
        let slabs = [
            (eye.x, along.x, 0.0, side),
            (eye.y, along.y, 0.0, side),
            (eye.z, along.z, self.lowest, self.highest),
        ];
        for (start, slope, low, high) in slabs {
            if slope.abs() < 1e-300 {
                if start < low || start > high {
                    return None;
                }
                continue;
            }
            let ends = [(low - start) / slope, (high - start) / slope];
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        }
        // A flat grid has no thickness.
        if from > to + 1e-9 {
            return None;
        }
        let last = self.grid.cells - 1;
        let clamp = |value: f64| {
            // Floor of what lies in the grid.
            #[allow(
                clippy::cast_possible_truncation,
                reason = "held between 0 and the number of cells"
            )]
            let cell = value.floor().clamp(0.0, f64::from(last)) as u32;
            cell
        };
        let start = eye + along * from;
        let (mut column, mut row) = (clamp(start.x), clamp(start.y));
        loop {
            let hit = self.meet_cell(eye, along, column, row);
            if hit.is_some() {
                return hit;
            }
            let border = |start: f64, slope: f64, cell: u32| match slope {
                slope if slope > 0.0 => (f64::from(cell) + 1.0 - start) / slope,
                slope if slope < 0.0 => (f64::from(cell) - start) / slope,
                _ => f64::INFINITY,
            };
            let next_x = border(eye.x, along.x, column);
            let next_y = border(eye.y, along.y, row);
            if next_x.min(next_y) > to {
                return None;
            }
            let (cell, slope) = if next_x < next_y {
                (&mut column, along.x)
            } else {
                (&mut row, along.y)
            };
            match slope > 0.0 {
                true if *cell < last => *cell += 1,
                false if *cell > 0 => *cell -= 1,
                _ => return None,
            }
        }
    }

    fn meet_cell(&self, eye: DVec3, along: DVec3, column: u32, row: u32) -> Option<Hit> {
        let corner = |x, y| self.height(column + x, row + y);
        let [near, right, below, far] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        let local = eye - DVec3::new(f64::from(column), f64::from(row), 0.0);
        // A half is a plane, height = base + x · across + y · down, over a triangle of the cell.
        let meet = |base: f64, across: f64, down: f64, is_inside: &dyn Fn(f64, f64) -> bool| {
            let rate = along.z - across * along.x - down * along.y;
            let gap = base + across * local.x + down * local.y - local.z;
            let away = gap / rate;
            let (x, y) = (local.x + along.x * away, local.y + along.y * away);
            (away.is_finite() && away > 0.0 && is_inside(x, y)).then_some(away)
        };
        // Rounding must not open a crack between halves: the band has a pixel's share anyway.
        const SLACK: f64 = 1e-9;
        let in_cell =
            |x: f64, y: f64| x >= -SLACK && y >= -SLACK && x <= 1.0 + SLACK && y <= 1.0 + SLACK;
        let halves = match self.cut {
            Cut::Published => [
                meet(near, right - near, below - near, &|x, y| {
                    in_cell(x, y) && x + y <= 1.0 + SLACK
                }),
                meet(right + below - far, far - below, far - right, &|x, y| {
                    in_cell(x, y) && x + y >= 1.0 - SLACK
                }),
            ],
            #[cfg(test)]
            Cut::Other => [
                meet(near, far - below, below - near, &|x, y| {
                    in_cell(x, y) && y >= x - SLACK
                }),
                meet(near, right - near, far - right, &|x, y| {
                    in_cell(x, y) && y <= x + SLACK
                }),
            ],
        };
        let first = 2 * (row * self.grid.cells + column) + 1;
        let hits = (first..).zip(halves).filter_map(|(number, away)| {
            Some(Hit {
                number,
                away_m: away?,
            })
        });
        hits.min_by(|a, b| a.away_m.total_cmp(&b.away_m))
    }

    /// A vertex on the picture, pixels, and its distance along the view's axis.
    fn project(&self, column: u32, row: u32) -> (DVec2, f64) {
        self.view.project(self.vertex(column, row), self.size)
    }

    fn vertex(&self, column: u32, row: u32) -> DVec3 {
        let step_m = self.grid.step_m();
        let height = self.height(column, row);
        (DVec2::new(f64::from(column), f64::from(row)) * step_m).extend(height)
    }

    /// Holds a picture of triangles' numbers against the rays. Of numbers, what a picture holds is compared.
    ///
    /// - `truth`: [`Rays::picture`]
    pub fn judge_triangles(&self, numbers: &[u32], truth: &[(usize, u32)]) -> Judged {
        let mut judged = Judged::default();
        for &(pixel, met) in truth {
            let shown = numbers[pixel];
            let project = |place| self.view.project(place, self.size);
            judged.add(shown, met & SHOWN, || {
                self.may_show(self.centre(pixel), shown, |at| self.meet(at), project)
            });
        }
        judged
    }

    /// Whether the border of what is shown passes within the band of a place, and nothing hides it there.
    ///
    /// - `meet`: what the ray through a place of the picture meets
    /// - `project`: where a place is on the picture, pixels, and how far along its axis
    pub fn may_show(
        &self,
        at: DVec2,
        shown: u32,
        meet: impl Fn(DVec2) -> Option<Hit>,
        project: impl Fn(DVec3) -> (DVec2, f64),
    ) -> bool {
        let hits: Vec<Option<Hit>> = around(BAND_PX).map(|off| meet(at + off)).collect();
        if hits
            .iter()
            .any(|hit| hit.map_or(0, |hit| hit.number & SHOWN) == shown)
        {
            return true;
        }
        let last = 2 * self.grid.cells * self.grid.cells;
        let numbers = (shown..=last).step_by(SHOWN as usize + 1);
        let mut numbers = numbers.filter(|number| *number > 0);
        numbers.any(|number| {
            let corners = self.corners(number).map(&project);
            is_thin_at(at, corners, &hits)
        })
    }

    /// Corners of a triangle, by its number from 1.
    fn corners(&self, number: u32) -> [DVec3; 3] {
        let cell = (number - 1) / 2;
        let (column, row) = (cell % self.grid.cells, cell / self.grid.cells);
        let end = 1 - number % 2;
        [(1, 0), (0, 1), (end, end)].map(|(x, y)| self.vertex(column + x, row + y))
    }

    /// Holds a picture of points' numbers against their projections: a point covers the pixel that it
    /// lies in.
    pub fn judge_points(&self, numbers: &[u32]) -> Judged {
        let cells = self.grid.cells;
        let all = (0..cells).flat_map(|row| (0..cells).map(move |column| (column, row)));
        let places: Vec<(DVec2, f64)> =
            all.map(|(column, row)| self.project(column, row)).collect();
        judge_points(numbers, self.size, &places)
    }
}

/// Whether a triangle that may be thinner than the band lies within it and is seen.
///
/// - `corners`: on the picture, pixels, and away from the eye
/// - `hits`: what is met about the place, within the band
#[must_use]
pub fn is_thin_at(at: DVec2, corners: [(DVec2, f64); 3], hits: &[Option<Hit>]) -> bool {
    let nearest = corners
        .iter()
        .map(|corner| corner.1)
        .fold(f64::INFINITY, f64::min);
    let farthest = hits
        .iter()
        .map(|hit| hit.map_or(f64::INFINITY, |hit| hit.away_m));
    let is_seen = nearest <= farthest.fold(0.0, f64::max) * (1.0 + EQUAL_DEPTH);
    is_seen && distance_to_triangle(at, corners.map(|corner| corner.0)) <= BAND_PX
}

/// Holds a picture of points' numbers against their projections.
///
/// - `places`: on the picture, pixels, and away from the eye, of the points 1, 2 …
pub fn judge_points(numbers: &[u32], size: [u32; 2], places: &[(DVec2, f64)]) -> Judged {
    // Nearest point that is in each pixel whatever the rounding, and nearest by its place alone.
    let mut sure = vec![f64::INFINITY; numbers.len()];
    let mut plain = vec![(0, f64::INFINITY); numbers.len()];
    for (number, &(at, away)) in (1..).zip(places) {
        let Some(pixel) = pixel_of(at, size) else {
            continue;
        };
        let inside = at - at.floor();
        let is_sure = inside.min_element() >= BAND_PX && inside.max_element() <= 1.0 - BAND_PX;
        if is_sure {
            sure[pixel] = sure[pixel].min(away);
        }
        if away < plain[pixel].1 {
            plain[pixel] = (number, away);
        }
    }
    let mut judged = Judged::default();
    for (pixel, &shown) in numbers.iter().enumerate() {
        judged.add(shown, plain[pixel].0, || match shown.checked_sub(1) {
            None => sure[pixel].is_infinite(),
            Some(index) => places.get(index as usize).is_some_and(|&(at, away)| {
                is_near_pixel(at, pixel, size[0]) && away <= sure[pixel] * (1.0 + EQUAL_DEPTH)
            }),
        });
    }
    judged
}

/// Middles of a picture's pixels, row by row.
pub fn centres([width, height]: [u32; 2]) -> impl Iterator<Item = DVec2> {
    let rows = 0..height;
    rows.flat_map(move |y| {
        (0..width).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
    })
}

/// A place and its eight neighbours so far away.
pub fn around(distance: f64) -> impl Iterator<Item = DVec2> {
    let steps = [-distance, 0.0, distance];
    steps
        .into_iter()
        .flat_map(move |x| steps.map(|y| DVec2::new(x, y)))
}

/// The same, or the place alone where there is no distance.
pub fn within(distance: f64) -> impl Iterator<Item = DVec2> {
    let alone = (distance <= 0.0).then_some(DVec2::ZERO);
    let all = around(distance).filter(move |_| alone.is_none());
    alone.into_iter().chain(all)
}

/// Number of the pixel that a place lies in.
fn pixel_of(at: DVec2, [width, height]: [u32; 2]) -> Option<usize> {
    let is_inside = at.min_element() >= 0.0 && at.x < f64::from(width) && at.y < f64::from(height);
    #[allow(clippy::cast_possible_truncation, reason = "inside the picture")]
    let number = |at: DVec2| at.y as usize * width as usize + at.x as usize;
    is_inside.then(|| number(at))
}

fn is_near_pixel(at: DVec2, pixel: usize, width: u32) -> bool {
    let width = width as usize;
    let corner = DVec2::new((pixel % width) as f64, (pixel / width) as f64);
    let inside = at - corner;
    inside.min_element() >= -BAND_PX && inside.max_element() <= 1.0 + BAND_PX
}

/// Distance of a place from a triangle of the picture, pixels; 0 inside.
pub fn distance_to_triangle(at: DVec2, corners: [DVec2; 3]) -> f64 {
    let [a, b, c] = corners;
    let sides = [(a, b), (b, c), (c, a)];
    let turns = sides.map(|(from, to)| (to - from).perp_dot(at - from));
    if turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0) {
        return 0.0;
    }
    let distances = sides.map(|(from, to)| {
        let side = to - from;
        let share = (at - from).dot(side) / side.length_squared();
        (at - from - side * share.clamp(0.0, 1.0)).length()
    });
    distances.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
