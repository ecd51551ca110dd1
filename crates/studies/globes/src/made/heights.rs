// SPDX-License-Identifier: MIT OR Apache-2.0
//! Heights on the faces of a cube, which vertices look up wherever the spiral puts them.
//!
//! A face has a sample on each of its corners and edges, so that neighbours share those and bilinear heights are
//! continuous all over the body. Directions are those of scaled space, in which the body is a sphere.

use crate::cube::{along_face, face_of, on_cube};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, nearest_f32};
use terrafill_surface::Surface;

/// Faces in WebGPU's order: +x, −x, +y, −y, +z, −z.
const FACES: u32 = 6;

/// Samples of a height field, metres.
#[derive(Debug)]
pub(crate) struct HeightCube {
    /// Where they come from, for cases.
    pub(crate) name: &'static str,
    /// Cells along a side of a face.
    pub(crate) side: u32,
    /// Row by row, face by face.
    pub(crate) samples: Vec<f32>,
    pub(crate) highest_m: f64,
}

/// A place on a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OnFace {
    pub(crate) face: u32,
    /// −1 … 1 along the face.
    pub(crate) place: [f64; 2],
    /// The cell that holds it, and where in it, 0 … 1.
    pub(crate) cell: [u32; 2],
    pub(crate) within: [f64; 2],
}

impl HeightCube {
    /// Land of a surface; what lies below the ellipsoid is drawn on it, as water is.
    ///
    /// # Errors
    /// A surface that has no heights.
    pub(crate) fn of(
        name: &'static str,
        body: &Ellipsoid,
        surface: &Arc<dyn Surface>,
        side: u32,
    ) -> Result<Self, String> {
        let across = side + 1;
        let radii = body.radii_m();
        let sample = |number: u32| {
            let (face, at) = (number / (across * across), number % (across * across));
            let place =
                [at % across, at / across].map(|at| 2.0 * f64::from(at) / f64::from(side) - 1.0);
            let ground = on_cube(face, place).normalize() * radii;
            let place = body.ecef_to_geodetic(ground);
            let height_m = surface.true_height_m(
                place.longitude_rad.to_degrees(),
                place.latitude_rad.to_degrees(),
            )?;
            Some(nearest_f32(height_m.max(0.0)))
        };
        let samples = (0..FACES * across * across).into_par_iter().map(sample);
        let samples: Option<Vec<f32>> = samples.collect();
        let samples = samples.ok_or_else(|| format!("surface of {name} has no heights"))?;
        Ok(Self {
            name,
            side,
            highest_m: samples.iter().copied().fold(0.0, f32::max).into(),
            samples,
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.samples.as_slice()) as u64
    }

    /// - `d`: any length
    pub(crate) fn on_face(&self, d: DVec3) -> OnFace {
        let face = face_of(d);
        let [s, t, out] = along_face(face, d);
        let place = [s / out, t / out];
        let at = place.map(|at| 0.5 * (at + 1.0) * f64::from(self.side));
        #[allow(clippy::cast_possible_truncation, reason = "0 … side")]
        let cell = at.map(|at| (at.max(0.0) as u32).min(self.side - 1));
        OnFace {
            face,
            place,
            cell,
            within: [0, 1].map(|axis| at[axis] - f64::from(cell[axis])),
        }
    }

    /// Bilinear between the samples about a direction.
    pub(crate) fn height_m(&self, d: DVec3) -> f64 {
        let OnFace {
            face, cell, within, ..
        } = self.on_face(d);
        let across = self.side + 1;
        let sample = |x: u32, y: u32| {
            let number = (face * across + cell[1] + y) * across + cell[0] + x;
            f64::from(self.samples[number as usize])
        };
        let [x, y] = within;
        let row = |at: u32| sample(0, at) + x * (sample(1, at) - sample(0, at));
        row(0) + y * (row(1) - row(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_those_of_the_samples_and_continuous_over_edges_of_faces() {
        let mut samples = Vec::new();
        let side = 8;
        for face in 0..FACES {
            for at in 0..(side + 1) * (side + 1) {
                let place = [at % (side + 1), at / (side + 1)];
                let place = place.map(|at| 2.0 * f64::from(at) / f64::from(side) - 1.0);
                let d = on_cube(face, place).normalize();
                samples.push(nearest_f32(1000.0 * (d.x + 2.0 * d.y * d.z + 3.0)));
            }
        }
        let mut cube = HeightCube {
            name: "test",
            side,
            samples,
            highest_m: 0.0,
        };
        for face in 0..FACES {
            for place in [[-1.0, 0.25], [0.5, 1.0], [0.0, 0.0], [-0.75, -0.25]] {
                let d = on_cube(face, place);
                let [s, t, out] = along_face(face, d);
                assert_eq!([s / out, t / out], place);
                let unit = d.normalize();
                let exact = 1000.0 * (unit.x + 2.0 * unit.y * unit.z + 3.0);
                assert!((cube.height_m(d) - exact).abs() < 1e-3, "{face} {place:?}");
                // Just over an edge another face answers, and says the same.
                let beyond = on_cube(face, place.map(|at| at * (1.0 + 1e-9)));
                assert!((cube.height_m(beyond) - cube.height_m(d)).abs() < 1e-3);
            }
        }
        // Negative control: a sample of an edge that one face alone has otherwise.
        let d = on_cube(0, [1.0, 0.25]);
        let OnFace { face, cell, .. } = cube.on_face(d);
        let number = (face * (side + 1) + cell[1]) * (side + 1) + side;
        cube.samples[number as usize] += 500.0;
        let beyond = on_cube(0, [1.0 + 1e-9, 0.25]);
        assert!((cube.height_m(beyond) - cube.height_m(d)).abs() > 1.0);
    }
}
