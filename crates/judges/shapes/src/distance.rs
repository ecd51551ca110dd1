// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far triangles are from the surface that they stand for, gathered over places of each.

use crate::grid::GridCamera;
use glam::DVec3;

/// Seven places of a triangle: its middle, those of its sides, and towards each corner.
pub const PLACES: [[f64; 3]; 7] = [
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
];

/// Distances of places from a surface.
#[derive(Debug, Clone, Copy, Default)]
pub struct Distances {
    max_m: f64,
    /// The largest as it is seen, of the picture's height.
    max_seen: f64,
    squares: f64,
    count: f64,
}

impl Distances {
    /// Adds a place of the surface.
    ///
    /// - `place`: metres
    /// - `distance_m`: from the exact surface
    pub fn add(&mut self, place: DVec3, distance_m: f64, view: &GridCamera) {
        self.max_m = self.max_m.max(distance_m);
        let away = (place - view.eye).dot(view.forward);
        self.max_seen = self.max_seen.max(0.5 * distance_m / (away * view.tan_half));
        self.squares += distance_m * distance_m;
        self.count += 1.0;
    }

    /// - `height`: of the picture, pixels
    pub fn figures(&self, height: u32) -> [(&'static str, f64); 3] {
        [
            ("surface_error_max_m", self.max_m),
            (
                "surface_error_rms_m",
                (self.squares / self.count.max(1.0)).sqrt(),
            ),
            ("surface_error_px", self.max_seen * f64::from(height)),
        ]
    }
}
