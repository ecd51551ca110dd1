// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where the near plane, as far as the image shows it, may meet a region's volume.
//!
//! Counting the faces in front of the surface starts at the near plane, so it is right exactly where
//! every pixel's ray starts outside the volume there: where the near rectangle and the volume are
//! disjoint. What lies between eye and near plane is clipped, and matters to no count.

use crate::{Camera, ImageSize};
use glam::DVec3;
use terrafill_core::OrientedBox;

/// The rectangle of the near plane that the image shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearPlane {
    corners_ecef: [DVec3; 4],
    /// What clipping in `f32` may move, metres.
    margin_m: f64,
}

/// Rounding of a clip position against the near plane, as a share of the eye's distance to what is
/// clipped; 2⁻²⁴ each for the position, its rotation and the comparison, and a margin of 16.
const CLIP_ROUNDING: f64 = 1.0 / (1 << 20) as f64;

impl NearPlane {
    pub(crate) fn new(camera: &Camera, size: ImageSize) -> Self {
        let half_y = camera.near_m * camera.tan_half_fov();
        let half_x = half_y * size.aspect();
        let ecef_from_view = camera.view_from_ecef.transpose();
        let corner = |x: f64, y: f64| {
            let view = DVec3::new(x * half_x, y * half_y, -camera.near_m);
            camera.eye_ecef + ecef_from_view * view
        };
        Self {
            corners_ecef: [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            margin_m: camera.near_m * CLIP_ROUNDING,
        }
    }

    /// Whether rectangle and box may share a point: true unless one of the box's own axes parts them.
    pub(crate) fn meets_box(&self, bounds: &OrientedBox) -> bool {
        (0..3).all(|axis| {
            let along = |corner: &DVec3| (*corner - bounds.center_ecef).dot(bounds.axes.col(axis));
            let extents = self.corners_ecef.iter().map(along);
            let (low, high) = extents
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                    (low.min(at), high.max(at))
                });
            let half = bounds.half_extents_m[axis] + self.margin_m;
            low <= half && -half <= high
        })
    }
}
