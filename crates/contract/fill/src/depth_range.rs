// SPDX-License-Identifier: MIT OR Apache-2.0
//! The range of the surface's depth in which a volume can lie at all.
//!
//! Where the surface is nearer than the volume or farther, every ray crosses the volume an
//! even number of times on either side. So its fragments may be dropped before they touch the
//! stencil. The range is that of the corners of a box that holds the volume, along the viewing
//! direction; with reversed depth the farthest corner gives the lower end.

use crate::FillInput;
use terrafill_scene::PlannedRegion;

/// Reversed depth, `0 ≤ low ≤ high ≤ 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// At the farthest corner, or below.
    pub low: f32,
    /// At the nearest corner, or above.
    pub high: f32,
}

impl DepthRange {
    /// Every depth there is.
    pub const ANY: Self = Self {
        low: 0.0,
        high: 1.0,
    };
}

/// Depth of a large facet is interpolated between its corners: each of them is rounded to 2⁻²⁴ of
/// itself, and the nearest may have depth 1. Four such steps hold it.
const INTERPOLATION: f64 = 1.0 / (1 << 22) as f64;

/// Rounding of the box, far more than `f64` and the constants' `f32` need.
const RELATIVE: f64 = 1.0 / (1 << 10) as f64;

/// Depth of the surface wherever `planned` may be seen.
#[allow(
    clippy::cast_possible_truncation,
    reason = "rounding to f32 is far less than what the range is widened by"
)]
pub(crate) fn depth_range(input: &FillInput, planned: &PlannedRegion) -> DepthRange {
    let camera = &input.camera;
    let region = &input.scene.bounds[planned.mesh];
    let top = planned.heights.top_m - region.heights.top_m;
    let bottom = region.heights.bottom_m - planned.heights.bottom_m;
    let grown = top.max(bottom).max(0.0);
    let mut bounds = region.bounds;
    bounds.half_extents_m += glam::DVec3::splat(grown);
    let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in bounds.corners_ecef() {
        let distance = -(camera.view_from_ecef * (corner - camera.eye_ecef)).z;
        nearest = nearest.min(distance);
        farthest = farthest.max(distance);
    }
    let depth = |distance: f64| {
        if distance > camera.near_m {
            camera.near_m / distance
        } else {
            1.0
        }
    };
    let low = depth(farthest) * (1.0 - RELATIVE) - INTERPOLATION;
    let high = depth(nearest) * (1.0 + RELATIVE) + INTERPOLATION;
    DepthRange {
        low: low.clamp(0.0, 1.0) as f32,
        high: high.clamp(0.0, 1.0) as f32,
    }
}
