// SPDX-License-Identifier: MIT OR Apache-2.0
//! A closed surface of triangles that are the same in every view.
//!
//! ECEF metres, `f64`.

use crate::{HeightRange, SurfaceBlocks, SurfaceError, SurfaceFrame};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic, index_u32, nearest_f32};
use terrafill_scene::{Camera, ImageSize};

/// Triangles of a planet's surface.
#[derive(Debug, Clone)]
pub struct SurfaceMesh {
    /// What heights are counted from.
    pub body: Ellipsoid,
    /// ECEF metres.
    pub vertices_ecef: Vec<DVec3>,
    /// Of each vertex, metres above the ellipsoid.
    pub heights_m: Vec<f64>,
    /// Counter-clockwise seen from outside.
    pub triangles: Arc<[[u32; 3]]>,
    /// Of all triangles as drawn.
    pub heights: HeightRange,
    /// Blocks that a view draws or leaves out as one; none where all triangles are always drawn.
    pub blocks: SurfaceBlocks,
}

/// Blocks of a grid from pole to pole at most, and cells on a block's side at least.
const MOST_BLOCK_ROWS: u32 = 64;
const FEWEST_BLOCK_CELLS: u32 = 9;

impl SurfaceMesh {
    /// The bare ellipsoid as a [grid](SurfaceMesh::grid).
    ///
    /// The lowest point is bounded by the sagitta of a chord as long as a cell's diagonal where
    /// the body is most curved: `c² / 8R`.
    #[must_use]
    pub fn ellipsoid(body: &Ellipsoid, rows: u32) -> Self {
        let rows = rows.max(4);
        let step = PI / f64::from(rows);
        let longest = body.equatorial_radius_m() * step * 2_f64.sqrt();
        let sagitta = longest * longest / (8.0 * body.smallest_curvature_radius_m());
        Self {
            heights: HeightRange {
                lowest_m: -sagitta,
                highest_m: 0.0,
            },
            ..Self::grid(body, rows, |_, _| 0.0)
        }
    }

    /// Grid of `rows` × `2·rows` cells of longitude and latitude from the south pole and 180° west,
    /// two triangles a cell, one in the rows at the poles. Both triangles of a cell begin with its
    /// south-western vertex, `row · 2 · rows + column`. They come block by block: square pieces of the grid.
    ///
    /// - `rows`: at least 4
    /// - `height_m`: height of a vertex by row and column; at the poles that of column 0
    #[must_use]
    pub fn grid(body: &Ellipsoid, rows: u32, height_m: impl Fn(u32, u32) -> f64) -> Self {
        let columns = 2 * rows;
        let step = PI / f64::from(rows);
        let mut vertices_ecef = Vec::new();
        let mut heights_m = Vec::new();
        for row in 0..=rows {
            for column in 0..columns {
                let is_pole = row == 0 || row == rows;
                let height_m = height_m(row, if is_pole { 0 } else { column });
                heights_m.push(height_m);
                // A column's own rounding of the pole would leave a hole of a nanometre there.
                vertices_ecef.push(if row == 0 {
                    DVec3::new(0.0, 0.0, -(body.polar_radius_m() + height_m))
                } else if row == rows {
                    DVec3::new(0.0, 0.0, body.polar_radius_m() + height_m)
                } else {
                    body.geodetic_to_ecef(Geodetic {
                        longitude_rad: f64::from(column) * step - PI,
                        latitude_rad: f64::from(row) * step - PI / 2.0,
                        height_m,
                    })
                });
            }
        }
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        let mut starts = Vec::new();
        let side = rows.div_ceil(MOST_BLOCK_ROWS).max(FEWEST_BLOCK_CELLS);
        for south in (0..rows).step_by(side as usize) {
            for west in (0..columns).step_by(side as usize) {
                starts.push(index_u32(triangles.len()));
                for column in west..columns.min(west + side) {
                    for row in south..rows.min(south + side) {
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
            }
        }
        let ends = starts.iter().copied().skip(1);
        let ends = ends.chain([index_u32(triangles.len())]);
        let ranges = starts.iter().zip(ends).map(|(&start, end)| start..end);
        let blocks = SurfaceBlocks::new(ranges, &triangles, &vertices_ecef);
        let mut mesh = Self {
            body: *body,
            vertices_ecef,
            heights_m,
            triangles: triangles.into(),
            heights: HeightRange {
                lowest_m: f64::INFINITY,
                highest_m: f64::NEG_INFINITY,
            },
            blocks,
        };
        let facets = mesh.triangles.iter().map(|facet| mesh.facet_heights(facet));
        mesh.heights = facets.fold(mesh.heights, HeightRange::union);
        mesh
    }

    /// Heights between which a flat triangle lies.
    ///
    /// The height above an ellipsoid is its signed distance, which is convex, so that no point of a
    /// triangle is higher than its highest corner. With `m` the lowest corner's height, all corners lie
    /// outside the surface at height `m`, in which a ball of the radius `R + m` rolls freely (Blaschke; R
    /// is the body's smallest curvature radius). Where a point of the triangle is `d` below that surface,
    /// the ball that touches it above has its centre `R + m − d` away, and the corners lie outside the
    /// ball. The point is a weighted mean of the corners. So its squared distance from the centre is the
    /// mean of theirs, less the mean of their squared distances from the point, which is at most `r²` in
    /// a circle of the radius `r`: `(R + m − d)² ≥ (R + m)² − r²`. The circle around a triangle with a
    /// longest edge `c` has at most `r² = c² / 3` (Jung).
    #[must_use]
    pub fn facet_heights(&self, triangle: &[u32; 3]) -> HeightRange {
        let corners = triangle.map(|vertex| self.vertices_ecef[vertex as usize]);
        let heights = triangle.map(|vertex| self.heights_m[vertex as usize]);
        let lowest_m = heights.into_iter().fold(f64::INFINITY, f64::min);
        let squared_edge = |from: usize, to: usize| (corners[from] - corners[to]).length_squared();
        let longest = squared_edge(0, 1)
            .max(squared_edge(1, 2))
            .max(squared_edge(2, 0));
        let ball_m = self.body.smallest_curvature_radius_m() + lowest_m;
        let circle = (longest / 3.0).min(ball_m * ball_m);
        // Without the cancellation of R − √(R² − r²).
        let sagitta_m = circle / (ball_m + (ball_m * ball_m - circle).sqrt());
        HeightRange {
            lowest_m: lowest_m - sagitta_m,
            highest_m: heights.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// What is drawn in a view of a surface of this kind.
    ///
    /// # Errors
    /// [`SurfaceError::EyeBelow`].
    pub fn frame(&self, kind: &'static str, camera: &Camera) -> Result<SurfaceFrame, SurfaceError> {
        self.check_above(kind, camera.eye_ecef)?;
        let to_rte = |vertex: &DVec3| {
            let relative = *vertex - camera.eye_ecef;
            [
                nearest_f32(relative.x),
                nearest_f32(relative.y),
                nearest_f32(relative.z),
            ]
        };
        Ok(SurfaceFrame {
            vertices_rte: self.vertices_ecef.iter().map(to_rte).collect(),
            triangles: Arc::clone(&self.triangles),
            heights: self.heights,
            parts: Arc::default(),
            shown: None,
        })
    }

    /// As [`SurfaceMesh::frame`], of which the view draws the blocks that it may show.
    ///
    /// # Errors
    /// [`SurfaceError::EyeBelow`].
    pub fn frame_by_blocks(
        &self,
        kind: &'static str,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<SurfaceFrame, SurfaceError> {
        Ok(SurfaceFrame {
            shown: self.blocks.shown(camera, size),
            ..self.frame(kind, camera)?
        })
    }

    /// Whether a ray from the eye straight up leaves without meeting the surface. Cost: O(triangles)
    /// for an eye below the highest of them.
    fn check_above(&self, kind: &'static str, eye_ecef: DVec3) -> Result<(), SurfaceError> {
        let eye = self.body.ecef_to_geodetic(eye_ecef);
        if eye.height_m > self.heights.highest_m {
            return Ok(());
        }
        let up = self
            .body
            .geodetic_surface_normal(eye.longitude_rad, eye.latitude_rad);
        let is_above = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| self.vertices_ecef[vertex as usize] - eye_ecef);
            let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| from.cross(to).dot(up));
            let normal = (b - a).cross(c - a);
            // Seen from inside, triangles turn the other way round than from outside.
            sides.into_iter().all(|side| side >= 0.0) && normal.dot(a) / normal.dot(up) > 0.0
        };
        if self.triangles.iter().any(is_above) {
            return Err(SurfaceError::EyeBelow {
                kind,
                eye_height_m: eye.height_m,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use terrafill_scene::CameraPose;

    /// Checkers of hills and valleys this high and deep.
    fn checkers(body: &Ellipsoid, rows: u32, height_m: f64) -> SurfaceMesh {
        SurfaceMesh::grid(body, rows, |row, column| match (row + column) % 2 {
            0 => height_m,
            _ => -height_m,
        })
    }

    /// Panics unless every edge is used once in each direction; gives the lowest and highest of a few
    /// points of each triangle.
    fn closed_and_sampled(mesh: &SurfaceMesh) -> HeightRange {
        let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
        let mut found = HeightRange {
            lowest_m: f64::INFINITY,
            highest_m: f64::NEG_INFINITY,
        };
        // The rows at the poles have one vertex per column: same place to the bit, other index.
        let pole = |i: u32| {
            let v = mesh.vertices_ecef[i as usize];
            let at_pole = (v.x == 0.0 && v.y == 0.0).then_some(v.z > 0.0);
            at_pole.map_or(i, |is_north| u32::MAX - u32::from(is_north))
        };
        for triangle in mesh.triangles.iter() {
            let corners = triangle.map(|i| mesh.vertices_ecef[i as usize]);
            for k in 0..3 {
                let (a, b) = (pole(triangle[k]), pole(triangle[(k + 1) % 3]));
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
            let stated = mesh.facet_heights(triangle);
            for (u, v) in [
                (1.0 / 3.0, 1.0 / 3.0),
                (0.5, 0.5),
                (0.5, 0.0),
                (0.25, 0.25),
                (0.0, 0.0),
                (1.0, 0.0),
                (0.0, 1.0),
            ] {
                let p = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                let height = mesh.body.ecef_to_geodetic(p).height_m;
                // A corner's height comes back with the rounding of its position.
                let rounding = 1e-14 * mesh.body.equatorial_radius_m();
                assert!(height >= stated.lowest_m - rounding, "{height} {stated:?}");
                assert!(height <= stated.highest_m + rounding, "{height} {stated:?}");
                found.lowest_m = found.lowest_m.min(height);
                found.highest_m = found.highest_m.max(height);
            }
        }
        let is_closed = edges.values().all(|&sum| sum == 0);
        assert!(is_closed, "an edge is used once only");
        found
    }

    #[test]
    fn the_ellipsoid_is_closed_and_stays_above_its_stated_lowest_height() {
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            let mesh = SurfaceMesh::ellipsoid(&body, 18);
            let lowest = closed_and_sampled(&mesh).lowest_m;
            let stated = mesh.heights.lowest_m;
            assert!(lowest >= stated, "{lowest} below {stated}");
            assert!(
                lowest < 0.4 * stated,
                "the bound is far too loose: {lowest}"
            );
        }
    }

    #[test]
    fn facets_between_hills_and_valleys_stay_within_their_stated_heights() {
        for (body, height_m) in [
            (Ellipsoid::WGS84, 11e3),
            (Ellipsoid::WGS84, 0.0),
            (Ellipsoid::SATURN_LIKE, -2e6),
            (Ellipsoid::ASTEROID_250M, 60.0),
        ] {
            let mesh = checkers(&body, 16, height_m);
            let found = closed_and_sampled(&mesh);
            let stated = mesh.heights;
            // Corners are reached; below them the bound is for a facet with all corners as low.
            let low = -height_m.abs();
            assert!(found.lowest_m <= low && found.highest_m >= -low - 1e-6);
            let (sags, may_sag) = (low - found.lowest_m, low - stated.lowest_m);
            assert!(
                may_sag < 5.0 * sags || height_m.abs() > 0.0,
                "{found:?}, {stated:?}"
            );
        }
    }

    #[test]
    fn vertices_of_the_bare_ellipsoid_lie_where_they_always_did() {
        let body = Ellipsoid::WGS84;
        let mesh = SurfaceMesh::ellipsoid(&body, 18);
        let place = body.geodetic_to_ecef(Geodetic::from_degrees(-170.0, -80.0, 0.0));
        assert!((mesh.vertices_ecef[37] - place).length() < 1e-8);
        assert_eq!(
            mesh.vertices_ecef[0],
            DVec3::new(0.0, 0.0, -body.polar_radius_m())
        );
        assert_eq!(
            (mesh.vertices_ecef.len(), mesh.triangles.len()),
            (19 * 36, 34 * 36)
        );
    }

    #[test]
    fn an_eye_below_the_surface_is_refused() {
        let body = Ellipsoid::WGS84;
        let mesh = checkers(&body, 18, 9e3);
        let frame = |longitude: f64, latitude: f64, height_m: f64| {
            let pose = CameraPose {
                eye: Geodetic::from_degrees(longitude, latitude, height_m),
                heading_rad: 0.0,
                pitch_rad: 0.0,
                fov_y_rad: 1.0,
                near_m: 1.0,
            };
            mesh.frame("checkers", &Camera::new(&body, &pose))
        };
        // Over a hill and over a valley, exactly above a vertex and beside it. At 10° a facet hangs
        // some 24 km below its corners.
        for (longitude, high, low) in [(10.0, 9_001.0, 8_999.0), (0.0, -8_999.0, -9_001.0)] {
            assert!(frame(longitude, 0.0, high).is_ok());
            let below = frame(longitude, 0.0, low).map(|frame| frame.heights);
            let error = below.expect_err("below").to_string();
            assert!(error.contains(&format!("{low:.1} m")), "{error}");
            assert!(error.contains("checkers"), "{error}");
        }
        assert!(frame(4.0, 3.0, 0.0).is_ok());
        assert!(frame(4.0, 3.0, -7e4).is_err());
        let eye = DVec3::new(0.0, 0.0, 7e6);
        let seen = frame(0.0, 90.0, 7e6 - body.polar_radius_m()).expect("above");
        let first = mesh.vertices_ecef[50] - eye;
        let rounded = DVec3::from(seen.vertices_rte[50].map(f64::from));
        assert!((first - rounded).length() < 1.0);
    }
}
