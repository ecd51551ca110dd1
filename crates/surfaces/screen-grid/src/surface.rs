// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface: what scenes say of it, and the heights and parts of a view's triangles.

use crate::facet::{extent, heights, united};
use crate::mesh::{GridOptions, Limb, ScreenMesh};
use crate::rays::Rays;
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent};
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::{
    HeightRange, Parameters, Surface, SurfaceError, SurfaceFrame, SurfaceKind, SurfacePart,
};

/// Name in scene files.
const KIND: &str = "screen-grid";

/// Cells along a side where a scene names none: the paper's normal use.
const DEFAULT_CELLS: u32 = 10;
/// The finest grid: 12,800 triangles.
const MAX_CELLS: u32 = 80;
/// Parts along a side of the screen: a region asks each part of a view whether it lies there.
const MAX_PARTS: u32 = 20;
/// How deep triangles may reach, of the smallest curvature radius: there normals begin to cross, and a
/// volume's bottom is lower than the surface by a thousandth and a clearance.
const DEEPEST: f64 = 0.99;
/// How high rounded vertices may lie in any view, of the radius: `f32` rounds an eye's distance to 2⁻²⁴ of it,
/// so this is enough from 16,000 radii away.
const HIGHEST: f64 = 1e-3;

/// Scenes over a grid on the screen: `kind = "screen-grid"` and
///
/// - `n`: cells along each side of the screen
/// - `limb`: what becomes of corners that miss the body, [`Limb`]
/// - `rays`: in what arithmetic vertices are found, [`Rays`]
#[derive(Debug, Clone, Copy)]
pub struct ScreenGridKind;

impl SurfaceKind for ScreenGridKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        let cells = parameters.count("n", DEFAULT_CELLS, 1..=MAX_CELLS)?;
        Ok(Arc::new(ScreenGrid {
            body: *body,
            options: GridOptions {
                cells,
                limb: parameters.one_of("limb", Limb::ALL)?,
                rays: parameters.one_of("rays", Rays::ALL)?,
            },
        }))
    }
}

#[derive(Debug)]
struct ScreenGrid {
    body: Ellipsoid,
    options: GridOptions,
}

impl ScreenGrid {
    fn deepest_m(&self) -> f64 {
        -DEEPEST * self.body.smallest_curvature_radius_m()
    }

    /// Part of the screen that a cell belongs to.
    fn part_of(&self, cell: u32) -> u32 {
        let n = self.options.cells;
        let side = n.div_ceil(MAX_PARTS);
        cell / n / side * MAX_PARTS + cell % n / side
    }

    fn mesh(&self, camera: &Camera, size: ImageSize) -> Result<ScreenMesh, SurfaceError> {
        let mesh = ScreenMesh::new(&self.body, camera, size, self.options);
        mesh.ok_or_else(|| SurfaceError::EyeBelow {
            kind: KIND,
            eye_height_m: self.body.ecef_to_geodetic(camera.eye_ecef).height_m,
        })
    }
}

impl Surface for ScreenGrid {
    fn kind(&self) -> &'static str {
        KIND
    }

    /// A cell as large as the body hangs nearly to its centre, wherever it is: what a view draws, its frame
    /// says.
    fn heights(&self, _extent: &Extent) -> HeightRange {
        HeightRange {
            lowest_m: self.deepest_m(),
            highest_m: HIGHEST * self.body.equatorial_radius_m(),
        }
    }

    /// The bare body.
    fn true_height_m(&self, _longitude_deg: f64, _latitude_deg: f64) -> Option<f64> {
        Some(0.0)
    }

    fn exact_vertices(
        &self,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<Option<Vec<DVec3>>, SurfaceError> {
        Ok(Some(self.mesh(camera, size)?.vertices_rte))
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        let body = &self.body;
        let mesh = self.mesh(camera, size)?;
        let vertices_rte = mesh.rounded();
        let corner =
            |index: u32| DVec3::from(vertices_rte[index as usize].map(f64::from)) + camera.eye_ecef;
        let mut parts: BTreeMap<u32, SurfacePart> = BTreeMap::new();
        for (triangle, &cell) in mesh.triangles.iter().zip(&mesh.cells) {
            let corners = triangle.map(corner);
            let facet = SurfacePart {
                extent: extent(body, corners),
                heights: heights(body, corners),
            };
            let part = parts.entry(self.part_of(cell)).or_insert(facet);
            part.extent = united(part.extent, facet.extent);
            part.heights = part.heights.union(facet.heights);
        }
        let parts: Vec<SurfacePart> = parts.into_values().collect();
        let all = parts.iter().map(|part| part.heights);
        let heights = all.reduce(HeightRange::union).unwrap_or(HeightRange {
            lowest_m: 0.0,
            highest_m: 0.0,
        });
        if heights.lowest_m < self.deepest_m() {
            return Err(SurfaceError::TooDeep {
                kind: KIND,
                lowest_m: heights.lowest_m,
                allowed_m: self.deepest_m(),
            });
        }
        Ok(SurfaceFrame {
            vertices_rte: vertices_rte.into(),
            triangles: mesh.triangles.into(),
            heights,
            parts: parts.into(),
            shown: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;
    use terrafill_scene::{CameraPose, Scene};
    use terrafill_surface::open_surface;

    const SIZE: ImageSize = ImageSize::new(300, 200);

    fn opened(body: &str, keys: &str) -> Result<Arc<dyn Surface>, String> {
        let text = format!(
            "name = \"t\"\ndescription = \"d\"\nbody = \"{body}\"\n\
             [regions]\nembedded = \"california.geojson\"\n[surface]\nkind = \"screen-grid\"\n{keys}\n\
             [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
             heading_deg = 0\npitch_deg = 0\n"
        );
        let scene = Scene::from_toml(&text, "t.toml", None).expect("a scene");
        open_surface(&[&ScreenGridKind], &scene).map_err(|error| error.to_string())
    }

    fn camera(body: &Ellipsoid, latitude_deg: f64, height_m: f64) -> Camera {
        let pose = CameraPose {
            eye: Geodetic::from_degrees(170.0, latitude_deg, height_m),
            heading_rad: 0.3,
            pitch_rad: (-80_f64).to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: height_m * 1e-3,
        };
        Camera::new(body, &pose)
    }

    #[test]
    fn what_is_wrong_is_named_with_file_key_value_and_what_is_allowed() {
        for keys in ["", "n = 1", "n = 80\nlimb = \"ring\"\nrays = \"f32-c64\""] {
            assert_eq!(opened("wgs84", keys).expect(keys).kind(), "screen-grid");
        }
        for (keys, expected) in [
            ("n = 0", "t.toml: surface.n: found 0, allowed: 1 to 80"),
            ("n = 81", "t.toml: surface.n: found 81, allowed: 1 to 80"),
            (
                "limb = \"raycast\"",
                "t.toml: surface.limb: found \"raycast\", allowed: snap, ring",
            ),
            (
                "rays = \"f16\"",
                "t.toml: surface.rays: found \"f16\", allowed: f64, f32-c64, f32",
            ),
            (
                "rows = 4",
                "t.toml: surface.rows: found 4, allowed: only the keys kind, n, limb, rays",
            ),
        ] {
            assert_eq!(opened("wgs84", keys).expect_err(keys), expected);
        }
    }

    #[test]
    fn a_disc_through_the_middle_of_a_body_is_refused() {
        let body = Ellipsoid::SATURN_LIKE;
        let frame = |n: u32, radii: f64| {
            let surface = opened("saturn-like", &format!("n = {n}")).expect("a surface");
            let camera = camera(&body, 20.0, radii * body.equatorial_radius_m());
            let square = ImageSize::new(200, 200);
            let frame = surface.frame(&camera, square);
            frame.map(|_| ()).map_err(|error| error.to_string())
        };
        let error = frame(1, 20.0).expect_err("too deep");
        assert!(
            error
                .starts_with("the screen-grid surface is so coarse in this view that it reaches -")
                && error.ends_with("allowed: -48547987 m or more"),
            "{error}"
        );
        // Negative controls: from nearer, and with cells smaller than the body.
        assert_eq!(frame(1, 1.25), Ok(()));
        assert_eq!(frame(80, 20.0), Ok(()));
    }

    #[test]
    fn every_point_of_a_facet_lies_in_a_part_and_between_its_heights() {
        let body = Ellipsoid::WGS84;
        for (keys, latitude, height_m) in [
            ("n = 10", 20.0, 8e6),
            ("n = 40\nlimb = \"ring\"", 88.0, 8e6),
            ("n = 3", -50.0, 2e3),
            ("n = 10\nrays = \"f32\"", 70.0, 1e6),
        ] {
            let surface = opened("wgs84", keys).expect("a surface");
            let camera = camera(&body, latitude, height_m);
            let frame = surface.frame(&camera, SIZE).expect("above");
            let (mut points, mut low_elsewhere) = (0_u32, 0_u32);
            for triangle in frame.triangles.iter() {
                let [a, b, c] = triangle.map(|i| {
                    DVec3::from(frame.vertices_rte[i as usize].map(f64::from)) + camera.eye_ecef
                });
                for (u, v) in [(0.0, 0.0), (0.3, 0.3), (0.5, 0.5), (0.9, 0.05)] {
                    let place = body.ecef_to_geodetic(a * (1.0 - u - v) + b * u + c * v);
                    let [west_deg, south_deg] =
                        [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
                    let here = Extent {
                        west_deg,
                        south_deg,
                        east_deg: west_deg,
                        north_deg: south_deg,
                    };
                    let heights = frame.heights_over(&here, surface.heights(&here));
                    let rounding = 1e-8;
                    assert!(
                        heights.lowest_m <= place.height_m + rounding,
                        "{keys}: {place:?}"
                    );
                    assert!(
                        heights.highest_m >= place.height_m - rounding,
                        "{keys}: {place:?}"
                    );
                    // Negative control: the lowest corner of all is too high.
                    low_elsewhere += u32::from(place.height_m < -1e-3);
                    points += 1;
                }
            }
            assert!(
                4 * low_elsewhere > points,
                "{keys}: {low_elsewhere} of {points}"
            );
        }
    }
}
