// SPDX-License-Identifier: MIT OR Apache-2.0
//! Perspective camera on a body: where the eye is, where it looks, and which ray a pixel is.
//!
//! View space: x right, y up, z towards the viewer. Depth is reversed with an infinite far plane,
//! `depth = near / distance`, so it is 1 at the near plane and 0 at infinity, and float depth keeps
//! its relative precision over the whole range (Reed, 2015, "Depth Precision Visualized").

use glam::{DMat3, DVec3};
use terrafill_core::{Ellipsoid, Geodetic};

/// Size of the drawn image, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl ImageSize {
    /// So many columns and rows of pixels.
    #[must_use]
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Width over height.
    #[must_use]
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    /// Pixels in the image.
    #[must_use]
    pub fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Camera in the words of a scene file: geodetic position, compass heading, pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Eye.
    pub eye: Geodetic,
    /// Clockwise from north, radians.
    pub heading_rad: f64,
    /// Above the local horizontal; −π/2 looks straight down, radians.
    pub pitch_rad: f64,
    /// Vertical field of view, radians.
    pub fov_y_rad: f64,
    /// Distance of the near plane, metres.
    pub near_m: f64,
}

/// A camera ready to draw with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Eye, ECEF metres.
    pub eye_ecef: DVec3,
    /// Rotation; rows are the camera's right, up and backward axes in ECEF.
    pub view_from_ecef: DMat3,
    /// Vertical field of view, radians.
    pub fov_y_rad: f64,
    /// Distance of the near plane, metres.
    pub near_m: f64,
}

impl Camera {
    /// Places the camera on `body`.
    ///
    /// Looking straight down, "up" on the screen is the heading; so a heading of 0 has north up.
    #[must_use]
    pub fn new(body: &Ellipsoid, pose: &CameraPose) -> Self {
        let eye_ecef = body.geodetic_to_ecef(pose.eye);
        let up = body.geodetic_surface_normal(pose.eye.longitude_rad, pose.eye.latitude_rad);
        let (sin_lon, cos_lon) = pose.eye.longitude_rad.sin_cos();
        let east = DVec3::new(-sin_lon, cos_lon, 0.0);
        let north = up.cross(east);
        let (sin_h, cos_h) = pose.heading_rad.sin_cos();
        let (sin_p, cos_p) = pose.pitch_rad.sin_cos();
        let ahead = north * cos_h + east * sin_h;
        let forward = ahead * cos_p + up * sin_p;
        let camera_up = up * cos_p - ahead * sin_p;
        let right = forward.cross(camera_up);
        Self {
            eye_ecef,
            view_from_ecef: DMat3::from_cols(right, camera_up, -forward).transpose(),
            fov_y_rad: pose.fov_y_rad,
            near_m: pose.near_m,
        }
    }

    /// Half height of the image plane at distance 1.
    #[must_use]
    pub fn tan_half_fov(&self) -> f64 {
        (self.fov_y_rad * 0.5).tan()
    }

    /// Direction, ECEF, not normalised, from the eye through the centre of pixel (`column`, `row`),
    /// row 0 at the top; its component along the viewing direction is 1.
    #[must_use]
    pub fn pixel_direction_ecef(&self, size: ImageSize, column: u32, row: u32) -> DVec3 {
        self.direction_ecef(size, [column, row].map(|at| f64::from(at) + 0.5))
    }

    /// The same through any place of the image, pixels from its upper left corner.
    #[must_use]
    pub fn direction_ecef(&self, size: ImageSize, [x_px, y_px]: [f64; 2]) -> DVec3 {
        let tan = self.tan_half_fov();
        let x = (2.0 * x_px / f64::from(size.width) - 1.0) * tan * size.aspect();
        let y = (1.0 - 2.0 * y_px / f64::from(size.height)) * tan;
        self.view_from_ecef.transpose() * DVec3::new(x, y, -1.0)
    }

    /// Inward unit normals, ECEF, of the five planes through the eye that bound what the image shows. Four are its
    /// left, right, lower and upper sides; behind the last, across the viewing direction, nothing is seen.
    ///
    /// - `margin`: by how much the image is wider on each side, share of its half
    #[must_use]
    pub fn side_planes_ecef(&self, size: ImageSize, margin: f64) -> [DVec3; 5] {
        let tan_y = self.tan_half_fov() * (1.0 + margin);
        let tan_x = tan_y * size.aspect();
        let normals = [
            DVec3::new(1.0, 0.0, -tan_x),
            DVec3::new(-1.0, 0.0, -tan_x),
            DVec3::new(0.0, 1.0, -tan_y),
            DVec3::new(0.0, -1.0, -tan_y),
            DVec3::NEG_Z,
        ];
        let ecef_from_view = self.view_from_ecef.transpose();
        normals.map(|normal| ecef_from_view * normal.normalize())
    }

    /// Width of a pixel at `distance_m` from the eye, metres.
    #[must_use]
    pub fn pixel_size_m(&self, size: ImageSize, distance_m: f64) -> f64 {
        2.0 * self.tan_half_fov() * distance_m / f64::from(size.height)
    }

    /// Position in pixels (fractional, row 0 at the top) of an ECEF point, or `None` when it is
    /// not in front of the near plane.
    #[must_use]
    pub fn project_px(&self, size: ImageSize, ecef: DVec3) -> Option<[f64; 2]> {
        let view = self.view_from_ecef * (ecef - self.eye_ecef);
        let distance = -view.z;
        if distance < self.near_m {
            return None;
        }
        let tan = self.tan_half_fov();
        let x = view.x / (distance * tan * size.aspect());
        let y = view.y / (distance * tan);
        Some([
            (x + 1.0) * 0.5 * f64::from(size.width),
            (1.0 - y) * 0.5 * f64::from(size.height),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn pose(heading_deg: f64, pitch_deg: f64) -> CameraPose {
        CameraPose {
            eye: Geodetic::from_degrees(10.0, 50.0, 1000.0),
            heading_rad: heading_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: 1.0,
        }
    }

    const SIZE: ImageSize = ImageSize::new(200, 100);

    #[test]
    fn straight_down_has_the_heading_up_and_the_foot_in_the_middle() {
        let body = Ellipsoid::WGS84;
        for (heading, lon, lat) in [(0.0, 10.0, 50.001), (90.0, 10.001, 50.0)] {
            let camera = Camera::new(&body, &pose(heading, -90.0));
            let foot = body.geodetic_to_ecef(Geodetic::from_degrees(10.0, 50.0, 0.0));
            let middle = camera.project_px(SIZE, foot).expect("in front");
            assert!((middle[0] - 100.0).abs() < 1e-6 && (middle[1] - 50.0).abs() < 1e-6);
            let ahead = body.geodetic_to_ecef(Geodetic::from_degrees(lon, lat, 0.0));
            let above = camera.project_px(SIZE, ahead).expect("in front");
            assert!(
                above[1] < 45.0 && (above[0] - 100.0).abs() < 0.1,
                "{above:?}"
            );
        }
    }

    #[test]
    fn planes_tell_what_lies_beside_the_image_and_behind_the_eye() {
        let camera = Camera::new(&Ellipsoid::WGS84, &pose(343.6, -2.0));
        let beyond = |place_px: [f64; 2], along: f64, margin: f64| {
            let from_eye = along * camera.direction_ecef(SIZE, place_px);
            let planes = camera.side_planes_ecef(SIZE, margin);
            planes.map(|plane| plane.dot(from_eye) < 0.0)
        };
        let none = [false; 5];
        for corner_px in [[0.01, 0.01], [199.99, 99.99]] {
            assert_eq!(beyond(corner_px, 1e4, 0.0), none);
        }
        for (side, place_px) in [
            [-0.01, 50.0],
            [200.01, 50.0],
            [100.0, 100.01],
            [100.0, -0.01],
        ]
        .into_iter()
        .enumerate()
        {
            let mut expected = none;
            expected[side] = true;
            assert_eq!(beyond(place_px, 1e4, 0.0), expected);
            assert_eq!(beyond(place_px, 1e4, 1e-3), none, "within the margin");
        }
        assert!(beyond([100.0, 50.0], -1.0, 0.0)[4], "behind the eye");
    }

    #[test]
    fn a_pixels_ray_projects_back_to_its_centre() {
        let camera = Camera::new(&Ellipsoid::WGS84, &pose(343.6, -2.0));
        for (column, row) in [(0, 0), (199, 99), (17, 63)] {
            let direction = camera.pixel_direction_ecef(SIZE, column, row);
            let back = camera
                .project_px(SIZE, camera.eye_ecef + direction * 1234.5)
                .expect("in front");
            assert!((back[0] - f64::from(column) - 0.5).abs() < 1e-6);
            assert!((back[1] - f64::from(row) - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn the_rotation_is_one() {
        let camera = Camera::new(&Ellipsoid::WGS84, &pose(12.0, -34.0));
        assert!((camera.view_from_ecef.determinant() - 1.0).abs() < 1e-14);
        assert!(camera.fov_y_rad < FRAC_PI_2);
    }
}
