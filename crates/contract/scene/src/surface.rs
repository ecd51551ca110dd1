// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface that regions are filled on: for now the bare ellipsoid, tessellated.
//!
//! ECEF metres, `f64`. The fill never looks at this mesh: it sees only the depth it leaves behind.
//! The reference intersects exactly these triangles, so the tessellation is no source of error.

use glam::DVec3;
use std::f64::consts::PI;
use terrafill_core::{Ellipsoid, Geodetic};

/// Triangles of the planet's surface.
#[derive(Debug, Clone)]
pub struct SurfaceMesh {
    /// ECEF metres.
    pub vertices_ecef: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// No point of the surface lies lower, metres above the ellipsoid.
    pub lowest_m: f64,
    /// No point of the surface lies higher, metres above the ellipsoid.
    pub highest_m: f64,
}

impl SurfaceMesh {
    /// Grid of `rows` × `2·rows` cells of longitude and latitude, two triangles a cell, one in the
    /// rows at the poles.
    ///
    /// The lowest point is bounded by the sagitta of a chord as long as a cell's diagonal where
    /// the body is most curved: `c² / 8R`.
    #[must_use]
    pub fn ellipsoid(body: &Ellipsoid, rows: u32) -> Self {
        let rows = rows.max(4);
        let columns = 2 * rows;
        let step = PI / f64::from(rows);
        let mut vertices_ecef = Vec::new();
        for row in 0..=rows {
            for column in 0..columns {
                // A column's own rounding of the pole would leave a hole of a nanometre there.
                vertices_ecef.push(if row == 0 {
                    DVec3::new(0.0, 0.0, -body.polar_radius_m())
                } else if row == rows {
                    DVec3::new(0.0, 0.0, body.polar_radius_m())
                } else {
                    body.geodetic_to_ecef(Geodetic {
                        longitude_rad: f64::from(column) * step - PI,
                        latitude_rad: f64::from(row) * step - PI / 2.0,
                        height_m: 0.0,
                    })
                });
            }
        }
        let mut triangles = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let south_west = row * columns + column;
                let south_east = row * columns + (column + 1) % columns;
                let (north_west, north_east) = (south_west + columns, south_east + columns);
                if row > 0 {
                    triangles.push([south_west, south_east, north_east]);
                }
                if row + 1 < rows {
                    triangles.push([south_west, north_east, north_west]);
                }
            }
        }
        let longest = body.equatorial_radius_m() * step * 2_f64.sqrt();
        let sagitta = longest * longest / (8.0 * body.smallest_curvature_radius_m());
        Self {
            vertices_ecef,
            triangles,
            lowest_m: -sagitta,
            highest_m: 0.0,
        }
    }

    /// The vertices as the GPU gets them: relative to the eye, subtracted in f64, then rounded.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    pub fn relative_to_eye(&self, eye_ecef: DVec3) -> Vec<[f32; 3]> {
        self.vertices_ecef
            .iter()
            .map(|vertex| {
                let relative = *vertex - eye_ecef;
                [relative.x as f32, relative.y as f32, relative.z as f32]
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn the_ellipsoid_is_closed_and_stays_above_its_stated_lowest_height() {
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            let mesh = SurfaceMesh::ellipsoid(&body, 18);
            let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
            let mut lowest = 0.0_f64;
            // The rows at the poles have one vertex per column: same place to the bit, other index.
            let pole = |i: u32| {
                let v = mesh.vertices_ecef[i as usize];
                let at_pole = (v.x == 0.0 && v.y == 0.0).then_some(v.z > 0.0);
                at_pole.map_or(i, |is_north| u32::MAX - u32::from(is_north))
            };
            for triangle in &mesh.triangles {
                let corners = triangle.map(|i| mesh.vertices_ecef[i as usize]);
                for k in 0..3 {
                    let (a, b) = (pole(triangle[k]), pole(triangle[(k + 1) % 3]));
                    *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
                }
                for (u, v) in [(1.0 / 3.0, 1.0 / 3.0), (0.5, 0.5), (0.5, 0.0), (0.25, 0.25)] {
                    let p = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                    lowest = lowest.min(body.ecef_to_geodetic(p).height_m);
                }
            }
            assert!(
                edges.values().all(|&sum| sum == 0),
                "an edge is used once only"
            );
            assert!(lowest >= mesh.lowest_m, "{lowest} below {}", mesh.lowest_m);
            assert!(
                lowest < 0.4 * mesh.lowest_m,
                "the bound is far too loose: {lowest}"
            );
        }
    }
}
