// SPDX-License-Identifier: MIT OR Apache-2.0
//! Flights over the Earth, and the globe that is drawn. The eye looks straight down; north is up.

use glam::DVec3;
use std::f64::consts::{PI, TAU};
use terrafill_core::{Ellipsoid, Geodetic, nearest_f32};
use terrafill_scene::{Camera, CameraPose, ImageSize};

/// Frames of a flight at least, in the last of which the eye rests.
pub(crate) const FRAMES: usize = 48;
pub(crate) const REST: usize = 10;
/// The frame in which a jump lands.
pub(crate) const LANDS: usize = 20;
/// From there 1,000 pixels a side want no finer level than the texture has.
pub(crate) const LOWEST_M: f64 = 3.5e6;
const FOV_DEG: f64 = 60.0;
/// Columns and rows of the globe's mesh.
const CELLS: [u32; 2] = [128, 64];

terrafill_results::named! {
    /// What the eye does.
    all pub(crate) enum Path {
        /// It drifts eastwards at one height.
        Smooth = "smooth",
        /// It comes down.
        Zoom = "zoom",
        /// It rests, and is elsewhere from one frame to the next.
        Jump = "jump",
    }
}

/// An eye over the Earth, and its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Eye {
    pub(crate) place: Geodetic,
    pub(crate) camera: Camera,
    pub(crate) size: ImageSize,
}

impl Eye {
    pub(crate) fn over(longitude_deg: f64, latitude_deg: f64, height_m: f64, side_px: u32) -> Self {
        let place = Geodetic::from_degrees(longitude_deg, latitude_deg, height_m);
        Self::at(place, ImageSize::new(side_px, side_px))
    }

    /// An eye above the same place at another height, metres.
    pub(crate) fn above(&self, height_m: f64) -> Self {
        let place = Geodetic {
            height_m,
            ..self.place
        };
        Self::at(place, self.size)
    }

    fn at(place: Geodetic, size: ImageSize) -> Self {
        let pose = CameraPose {
            eye: place,
            heading_rad: 0.0,
            pitch_rad: -PI / 2.0,
            fov_y_rad: FOV_DEG.to_radians(),
            near_m: 0.1 * place.height_m,
        };
        Self {
            place,
            camera: Camera::new(&Ellipsoid::WGS84, &pose),
            size,
        }
    }
}

impl Path {
    /// The eye of a frame, in a square picture.
    pub(crate) fn eye(self, frame: usize, side_px: u32) -> Eye {
        let moving = (FRAMES - REST) as f64;
        let share = (frame as f64 / moving).min(1.0);
        match self {
            Self::Smooth => Eye::over(-60.0 + 90.0 * share, 20.0 + 15.0 * share, LOWEST_M, side_px),
            Self::Zoom => Eye::over(15.0, 40.0, 2e7 * (LOWEST_M / 2e7).powf(share), side_px),
            Self::Jump if frame < LANDS => Eye::over(10.0, 45.0, LOWEST_M, side_px),
            Self::Jump => Eye::over(-100.0, 40.0, LOWEST_M, side_px),
        }
    }
}

/// The globe by meridians and parallels. Those at ±180° are there twice, so that U does not jump within a triangle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Globe {
    /// ECEF, metres.
    pub(crate) places: Vec<[f32; 3]>,
    /// U and V.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Counter-clockwise from above.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Globe {
    pub(crate) fn new() -> Self {
        let [columns, rows] = CELLS;
        let mut globe = Self {
            places: Vec::new(),
            uvs: Vec::new(),
            triangles: Vec::new(),
        };
        for row in 0..=rows {
            for column in 0..=columns {
                let uv =
                    [(column, columns), (row, rows)].map(|(at, of)| f64::from(at) / f64::from(of));
                globe.places.push(on_body(uv).as_vec3().to_array());
                globe.uvs.push(uv.map(nearest_f32));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let west = row * (columns + 1) + column;
                let [a, b] = [west, west + columns + 1];
                // At a pole one of the two has no area.
                globe.triangles.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
            }
        }
        globe
    }
}

/// The place of the body at U and V, ECEF, metres.
pub(crate) fn on_body([u, v]: [f64; 2]) -> DVec3 {
    Ellipsoid::WGS84.geodetic_to_ecef(Geodetic {
        longitude_rad: TAU * (u - 0.5),
        latitude_rad: PI * (0.5 - v),
        height_m: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_rests_at_the_end_and_jumps_between_two_frames() {
        for path in Path::ALL {
            let eye = |frame| path.eye(frame, 64);
            assert_eq!(eye(FRAMES - REST), eye(FRAMES - 1), "{path:?}");
            let before = eye(LANDS - 1) == eye(LANDS - 2);
            assert_eq!(before, path == Path::Jump);
            assert_ne!(eye(LANDS), eye(LANDS - 1));
        }
        let lowest = Path::Zoom.eye(FRAMES, 64).place.height_m;
        assert!((lowest - LOWEST_M).abs() < 1e-3);
    }

    #[test]
    fn the_globe_faces_outwards_and_meets_itself() {
        let globe = Globe::new();
        let mut flat = 0;
        for corners in &globe.triangles {
            let [a, b, c] = corners.map(|at| DVec3::from(globe.places[at as usize].map(f64::from)));
            let normal = (b - a).cross(c - a);
            let outwards = normal.dot(a + b + c);
            flat += usize::from(normal.length() < 1e3);
            assert!(outwards >= -1e12, "{corners:?}");
        }
        assert_eq!(flat, 2 * 128, "one of two at each pole");
        let [first, last] =
            [0, 128].map(|column| DVec3::from(globe.places[32 * 129 + column].map(f64::from)));
        assert!((first - last).length() < 1.0);
        assert_eq!(
            [0, 128].map(|column| globe.uvs[32 * 129 + column][0]),
            [0.0, 1.0]
        );
    }
}
