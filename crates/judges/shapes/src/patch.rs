// SPDX-License-Identifier: MIT OR Apache-2.0
//! A bicubic Bézier patch in `f64`: its places, its slopes, and how far a place is from it.

use crate::grid::nearest;
use glam::{DVec2, DVec3};

/// Gauss–Newton steps. The start is at most a cell's width off. Near the patch each step nearly squares the error.
const STEPS: usize = 4;
/// Of the squared slopes: keeps a step finite where a side of a patch is a point.
const DAMPING: f64 = 1e-9;

/// Twin of `on_patch` in `shared/bezier.wgsl`: 16 control points, metres, row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch(pub [[DVec3; 4]; 4]);

/// Bernstein's weights at `t`.
fn weights(t: f64) -> [f64; 4] {
    let rest = 1.0 - t;
    [
        rest * rest * rest,
        3.0 * rest * rest * t,
        3.0 * rest * t * t,
        t * t * t,
    ]
}

/// Their derivatives.
fn slopes(t: f64) -> [f64; 4] {
    let rest = 1.0 - t;
    [
        -3.0 * rest * rest,
        3.0 * rest * (rest - 2.0 * t),
        3.0 * t * (2.0 * rest - t),
        3.0 * t * t,
    ]
}

impl Patch {
    /// Control points as a device reads them.
    pub fn rounded(&self) -> Self {
        Self(
            self.0
                .map(|row| row.map(|point| point.as_vec3().as_dvec3())),
        )
    }

    /// The same points, four numbers each.
    pub fn sent(&self) -> impl Iterator<Item = [f32; 4]> {
        let points = self.0.into_iter().flatten();
        points.map(|point| {
            let [x, y, z] = point.to_array().map(nearest);
            [x, y, z, 1.0]
        })
    }

    fn sum(&self, across: [f64; 4], down: [f64; 4]) -> DVec3 {
        let row = |row: &[DVec3; 4]| -> DVec3 { row.iter().zip(across).map(|(p, w)| *p * w).sum() };
        self.0.iter().zip(down).map(|(of, w)| row(of) * w).sum()
    }

    /// A place of it, metres.
    ///
    /// - `at`: across and down, from 0 to 1
    pub fn place(&self, at: DVec2) -> DVec3 {
        self.sum(weights(at.x), weights(at.y))
    }

    /// Changes of a place along either way.
    pub fn slopes(&self, at: DVec2) -> [DVec3; 2] {
        let (across, down) = (weights(at.x), weights(at.y));
        [self.sum(slopes(at.x), down), self.sum(across, slopes(at.y))]
    }

    /// Distance of a place from the patch near `at`, metres: never less than the true one.
    pub fn distance(&self, place: DVec3, mut at: DVec2) -> f64 {
        let mut least = (self.place(at) - place).length();
        for _ in 0..STEPS {
            let gap = place - self.place(at);
            let [across, down] = self.slopes(at);
            // Gauss–Newton: the step whose change along the slopes is the gap's.
            let (a, b, c) = (
                across.length_squared() + DAMPING,
                across.dot(down),
                down.length_squared() + DAMPING,
            );
            let by = DVec2::new(gap.dot(across), gap.dot(down));
            let step = DVec2::new(c * by.x - b * by.y, a * by.y - b * by.x) / (a * c - b * b);
            at = (at + step).clamp(DVec2::ZERO, DVec2::ONE);
            least = least.min((self.place(at) - place).length());
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit square, its height bent in both directions.
    fn bent() -> Patch {
        let point = |row: usize, column: usize| {
            let (x, y) = (column as f64 / 3.0, row as f64 / 3.0);
            DVec3::new(x, y, x * x - y + 2.0 * x * y * y)
        };
        Patch([0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| point(row, column))))
    }

    #[test]
    fn corners_are_control_points_and_slopes_are_those_of_differences() {
        let patch = bent();
        assert_eq!(patch.place(DVec2::ZERO), patch.0[0][0]);
        assert_eq!(patch.place(DVec2::X), patch.0[0][3]);
        assert_eq!(patch.place(DVec2::Y), patch.0[3][0]);
        let at = DVec2::new(0.3, 0.8);
        for (slope, axis) in patch.slopes(at).into_iter().zip(DVec2::AXES) {
            const STEP: f64 = 1e-6;
            let difference = (patch.place(at + axis * STEP) - patch.place(at)) / STEP;
            assert!((difference - slope).length() < 1e-4, "{axis}");
            // Negative control: half the slope is noticed.
            assert!((difference - 0.5 * slope).length() > 0.1);
        }
    }

    #[test]
    fn a_place_beside_the_patch_is_as_far_as_it_was_moved() {
        let patch = bent();
        let at = DVec2::new(0.4, 0.6);
        let [across, down] = patch.slopes(at);
        let normal = across.cross(down).normalize();
        for moved in [0.0, 1e-4, 0.01] {
            let place = patch.place(at) + moved * normal;
            let found = patch.distance(place, at + DVec2::new(0.05, -0.05));
            assert!((found - moved).abs() < 1e-9, "{moved}: {found}");
        }
        // Negative control: it is not the distance from the start.
        let place = patch.place(at);
        let start = at + DVec2::new(0.05, -0.05);
        assert!((patch.place(start) - place).length() > 0.01);
    }
}
