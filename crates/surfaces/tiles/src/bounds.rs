// SPDX-License-Identifier: MIT OR Apache-2.0
//! What of a tile a view can see. ECEF metres.

use crate::tile::TileId;
use glam::DVec3;
use terrafill_core::{Ellipsoid, Extent, Geodetic};
use terrafill_elevation::Heights;
use terrafill_scene::{Camera, ImageSize};

/// A ball around a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) center_ecef: DVec3,
    pub(crate) radius_m: f64,
}

impl Ball {
    /// Around everything over `extent` between `heights`.
    pub(crate) fn around(body: &Ellipsoid, extent: &Extent, heights: Heights) -> Self {
        let degrees = |longitude: f64, latitude: f64, height_m: f64| {
            body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, height_m))
        };
        let middle = 0.5 * (heights.lowest_m + heights.highest_m);
        let across = [
            extent.west_deg,
            0.5 * (extent.west_deg + extent.east_deg),
            extent.east_deg,
        ];
        let up = [
            extent.south_deg,
            0.5 * (extent.south_deg + extent.north_deg),
            extent.north_deg,
        ];
        let center_ecef = degrees(across[1], up[1], middle);
        let mut radius_m: f64 = 0.0;
        for longitude in across {
            for latitude in up {
                for height_m in [heights.lowest_m, heights.highest_m] {
                    let place = degrees(longitude, latitude, height_m);
                    radius_m = radius_m.max((place - center_ecef).length());
                }
            }
        }
        // Between two of these places the ground bulges by no more than an arc of half the side.
        let half_deg = 0.5 * (across[2] - across[0]).max(up[2] - up[0]);
        let highest = body.equatorial_radius_m() + heights.highest_m.max(0.0);
        Self {
            center_ecef,
            radius_m: radius_m + highest * (1.0 - (0.5 * half_deg.to_radians()).cos()),
        }
    }
}

/// What a view sees, as far as whole tiles are concerned.
#[derive(Debug, Clone)]
pub(crate) struct TileView {
    pub(crate) eye_ecef: DVec3,
    /// Inward normals of the four sides of the picture and of the plane through the eye.
    planes: [DVec3; 5],
    horizon: Option<Horizon>,
    near_m: f64,
    /// Of the body at its equator, metres.
    radius_m: f64,
    /// Height of a pixel at distance 1.
    pixel_per_distance: f64,
}

impl TileView {
    /// - `lowest_m`: no triangle of the surface is lower in whatever view
    pub(crate) fn new(body: &Ellipsoid, camera: &Camera, size: ImageSize, lowest_m: f64) -> Self {
        Self {
            eye_ecef: camera.eye_ecef,
            planes: camera.side_planes_ecef(size, 0.0),
            horizon: Horizon::new(body, camera.eye_ecef, lowest_m),
            near_m: camera.near_m,
            radius_m: body.equatorial_radius_m(),
            pixel_per_distance: camera.pixel_size_m(size, 1.0),
        }
    }

    /// Whether anything in `ball` may be seen.
    pub(crate) fn may_see(&self, ball: &Ball) -> bool {
        let from_eye = ball.center_ecef - self.eye_ecef;
        let is_outside = |plane: &DVec3| plane.dot(from_eye) < -ball.radius_m;
        if self.planes.iter().any(is_outside) {
            return false;
        }
        let hidden = |horizon: &Horizon| horizon.hides(ball.center_ecef, ball.radius_m);
        !self.horizon.as_ref().is_some_and(hidden)
    }

    /// Whether anything between these points may be seen: both what lies outside one side of the picture
    /// and what the horizon hides are convex, so that corners speak for all that lies between them.
    pub(crate) fn may_see_between(&self, points_ecef: &[DVec3]) -> bool {
        let is_outside = |plane: &DVec3| {
            points_ecef
                .iter()
                .all(|point| plane.dot(*point - self.eye_ecef) < 0.0)
        };
        if self.planes.iter().any(is_outside) {
            return false;
        }
        let hidden = |horizon: &Horizon| points_ecef.iter().all(|point| horizon.hides(*point, 0.0));
        !self.horizon.as_ref().is_some_and(hidden)
    }

    /// Pixels that `error_m` spans where `ball` is nearest.
    pub(crate) fn pixels(&self, ball: &Ball, error_m: f64) -> f64 {
        error_m / (self.distance_m(ball) * self.pixel_per_distance)
    }

    /// From the eye to where `ball` is nearest, metres. What is nearer than the near plane is not drawn.
    pub(crate) fn distance_m(&self, ball: &Ball) -> f64 {
        let distance_m = (ball.center_ecef - self.eye_ecef).length() - ball.radius_m;
        distance_m.max(self.near_m)
    }

    /// Side of a tile's cells along a meridian, metres.
    pub(crate) fn cell_m(&self, id: TileId) -> f64 {
        id.step_deg().to_radians() * self.radius_m
    }
}

/// The shadow that a body throws if the eye is a lamp.
///
/// The body is an ellipsoid that lies within the surface wherever it is drawn: the reference one, shrunk by
/// a factor until it is everywhere as deep as the lowest triangle. (Cozzi and Ring, "3D Engine Design for
/// Virtual Globes", 2011, §12.3.) In coordinates in which it is a ball of radius 1, the shadow is a cone cut
/// off by a plane.
#[derive(Debug, Clone)]
struct Horizon {
    inverse_radii: DVec3,
    eye: DVec3,
    /// Of the cone around the axis from the eye to the centre.
    sine: f64,
    cosine: f64,
}

impl Horizon {
    fn new(body: &Ellipsoid, eye_ecef: DVec3, lowest_m: f64) -> Option<Self> {
        // By a factor s, each point moves inwards by at least (1 − s) times the smallest radius.
        let factor = 1.0 + lowest_m.min(0.0) / body.polar_radius_m();
        if factor <= 0.0 {
            return None;
        }
        let radii = DVec3::new(
            body.equatorial_radius_m(),
            body.equatorial_radius_m(),
            body.polar_radius_m(),
        );
        let inverse_radii = (radii * factor).recip();
        let eye = eye_ecef * inverse_radii;
        let sine = eye.length().recip();
        (sine < 1.0).then(|| Self {
            inverse_radii,
            eye,
            sine,
            cosine: (1.0 - sine * sine).sqrt(),
        })
    }

    fn hides(&self, center_ecef: DVec3, radius_m: f64) -> bool {
        let center = center_ecef * self.inverse_radii;
        let radius = radius_m * self.inverse_radii.max_element();
        if center.dot(self.eye) + radius * self.eye.length() >= 1.0 {
            return false;
        }
        let from_eye = center - self.eye;
        let along = -from_eye.dot(self.eye) * self.sine;
        let across = (from_eye.length_squared() - along * along).max(0.0).sqrt();
        along * self.sine - across * self.cosine >= radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_scene::CameraPose;

    #[test]
    fn what_is_culled_cannot_be_seen_and_what_is_seen_is_not_culled() {
        let body = Ellipsoid::WGS84;
        let pose = CameraPose {
            eye: Geodetic::from_degrees(0.0, 30.0, 50e3),
            heading_rad: 0.0,
            pitch_rad: -0.3,
            fov_y_rad: 1.0,
            near_m: 10.0,
        };
        let camera = Camera::new(&body, &pose);
        let size = ImageSize::new(100, 100);
        let sight = TileView::new(&body, &camera, size, -11e3);
        let place = |longitude: f64, latitude: f64, height_m: f64| {
            body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, height_m))
        };
        let (mut seen, mut hidden, mut beside) = (0, 0, 0);
        for i in -40..40 {
            for j in -60..80 {
                let point = place(f64::from(i), f64::from(j), 0.0);
                let pixel = camera.project_px(size, point);
                let is_framed =
                    pixel.is_some_and(|px| px.iter().all(|at| (0.0..=100.0).contains(at)));
                // Above the plane that touches the ellipsoid below it.
                let faces = body
                    .geodetic_surface_normal(f64::from(i).to_radians(), f64::from(j).to_radians())
                    .dot(camera.eye_ecef - point)
                    > 0.0;
                let small = Ball {
                    center_ecef: point,
                    radius_m: 1.0,
                };
                let may = sight.may_see(&small);
                assert_eq!(may, sight.may_see_between(&[point]), "{i} {j}");
                assert!(may || !(is_framed && faces), "{i} {j}");
                seen += usize::from(may);
                hidden += usize::from(!may && is_framed);
                beside += usize::from(!may && faces);
            }
        }
        assert!(
            seen > 10 && hidden > 100 && beside > 10,
            "{seen} {hidden} {beside}"
        );
    }

    #[test]
    fn a_ball_holds_its_tile() {
        let body = Ellipsoid::SATURN_LIKE;
        let heights = Heights {
            lowest_m: -3e5,
            highest_m: 2e5,
        };
        for (west_deg, south_deg, side) in
            [(-45.0, -45.0, 45.0), (0.0, 45.0, 45.0), (10.0, 3.0, 0.7)]
        {
            let extent = Extent {
                west_deg,
                south_deg,
                east_deg: west_deg + side,
                north_deg: south_deg + side,
            };
            let ball = Ball::around(&body, &extent, heights);
            for i in 0..=20 {
                for j in 0..=20 {
                    for height_m in [heights.lowest_m, heights.highest_m] {
                        let [x, y] = [i, j].map(|k| f64::from(k) / 20.0 * side);
                        let place = Geodetic::from_degrees(west_deg + x, south_deg + y, height_m);
                        let distance = (body.geodetic_to_ecef(place) - ball.center_ecef).length();
                        assert!(distance <= ball.radius_m, "{i} {j}");
                    }
                }
            }
        }
    }
}
