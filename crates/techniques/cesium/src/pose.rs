// SPDX-License-Identifier: MIT OR Apache-2.0
//! The same camera on both sides: what CesiumJS is given, and whether it looks where ours looks.

use glam::{DMat4, DVec3};
use serde::{Deserialize, Serialize};
use terrafill_scene::{Camera, ImageSize};

/// Farthest apart that the two cameras may show a point, pixels: rounding of `f64`, far below what
/// a picture shows.
pub(crate) const MAX_APART_PX: f64 = 1.0 / 1024.0;

/// Points in a row of those whose places are compared.
const POINTS: u32 = 5;

/// Distance of these points from the eye along the viewing direction, metres.
const AHEAD_M: f64 = 1000.0;

/// A camera as CesiumJS takes it: ECEF, metres and unit vectors; radians.
#[derive(Debug, Serialize)]
pub(crate) struct Pose {
    eye: [f64; 3],
    direction: [f64; 3],
    up: [f64; 3],
    right: [f64; 3],
    /// Of the image's longer side.
    angle: f64,
}

/// What CesiumJS makes of it: matrices in columns, ECEF to clip space by way of the view.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Matrices {
    view: [f64; 16],
    projection: [f64; 16],
}

impl Pose {
    pub(crate) fn new(camera: &Camera, size: ImageSize) -> Self {
        let axes = camera.view_from_ecef.transpose();
        let longer = camera.tan_half_fov() * size.aspect().max(1.0);
        Self {
            eye: camera.eye_ecef.to_array(),
            direction: (-axes.z_axis).to_array(),
            up: axes.y_axis.to_array(),
            right: axes.x_axis.to_array(),
            angle: 2.0 * longer.atan(),
        }
    }
}

/// Largest distance between the places at which the two cameras show the same point, pixels; infinite
/// where one is not a number.
pub(crate) fn apart_px(camera: &Camera, size: ImageSize, theirs: &Matrices) -> f64 {
    let view = DMat4::from_cols_array(&theirs.view);
    let projection = DMat4::from_cols_array(&theirs.projection);
    let at = |index: u32, side: u32| f64::from(side) * f64::from(index) / f64::from(POINTS - 1);
    let mut most = 0.0_f64;
    for row in 0..POINTS {
        for column in 0..POINTS {
            let ours = [at(column, size.width), at(row, size.height)];
            let point = camera.eye_ecef + camera.direction_ecef(size, ours) * AHEAD_M;
            let found = place_px(&(projection * view), size, point);
            let apart = (found[0] - ours[0]).hypot(found[1] - ours[1]);
            most = if apart.is_nan() {
                f64::INFINITY
            } else {
                most.max(apart)
            };
        }
    }
    most
}

/// Pixels from the upper left corner.
fn place_px(clip_from_ecef: &DMat4, size: ImageSize, point: DVec3) -> [f64; 2] {
    let clip = *clip_from_ecef * point.extend(1.0);
    [
        (clip.x / clip.w + 1.0) * 0.5 * f64::from(size.width),
        (1.0 - clip.y / clip.w) * 0.5 * f64::from(size.height),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::{Ellipsoid, Geodetic};
    use terrafill_scene::CameraPose;

    const SIZES: [ImageSize; 2] = [ImageSize::new(1024, 1024), ImageSize::new(1000, 400)];

    fn camera(heading_deg: f64) -> Camera {
        let pose = CameraPose {
            eye: Geodetic::from_degrees(105.05, 41.42, 2_000.0),
            heading_rad: heading_deg.to_radians(),
            pitch_rad: -2_f64.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: 1.0,
        };
        Camera::new(&Ellipsoid::WGS84, &pose)
    }

    /// What a camera of this pose should answer: a right-handed view with −z ahead, and the usual
    /// perspective of an angle that is the longer side's.
    fn matrices(pose: &Pose, size: ImageSize) -> Matrices {
        let [eye, ahead, up, right] =
            [pose.eye, pose.direction, pose.up, pose.right].map(DVec3::from_array);
        let to_view = DMat4::from_cols(
            right.extend(0.0),
            up.extend(0.0),
            (-ahead).extend(0.0),
            DVec3::ZERO.extend(1.0),
        );
        let view = to_view.transpose() * DMat4::from_translation(-eye);
        let tan = (pose.angle * 0.5).tan() / size.aspect().max(1.0);
        // Near 1 m, far without end (OpenGL's clip space).
        let projection = DMat4::from_cols_array(&[
            1.0 / (tan * size.aspect()),
            0.0,
            0.0,
            0.0, //
            0.0,
            1.0 / tan,
            0.0,
            0.0, //
            0.0,
            0.0,
            -1.0,
            -1.0, //
            0.0,
            0.0,
            -2.0,
            0.0,
        ]);
        Matrices {
            view: view.to_cols_array(),
            projection: projection.to_cols_array(),
        }
    }

    #[test]
    fn the_same_camera_shows_points_at_the_same_places_and_another_one_does_not() {
        for size in SIZES {
            let own = camera(343.6);
            let right = matrices(&Pose::new(&own, size), size);
            let apart = apart_px(&own, size, &right);
            assert!(apart < MAX_APART_PX, "{apart}");
            // Negative controls: turned by a hundredth of a pixel, a wider angle, and not a number.
            let turned = matrices(&Pose::new(&camera(343.6005), size), size);
            assert!(apart_px(&own, size, &turned) > MAX_APART_PX);
            let mut pose = Pose::new(&own, size);
            pose.angle += 1e-4;
            assert!(apart_px(&own, size, &matrices(&pose, size)) > MAX_APART_PX);
            let mut broken = right;
            broken.view[0] = f64::NAN;
            assert_eq!(apart_px(&own, size, &broken), f64::INFINITY);
        }
    }
}
