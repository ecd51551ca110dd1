// SPDX-License-Identifier: MIT OR Apache-2.0
//! How finely `f32` holds places on the map, in texels of the finest level that a view asks for.
//!
//! U and V' are shares of the whole map. Just below 1 a step of `f32` is 2⁻²⁴, so 64 texels of level 22: no way that
//! counts from the map's edge can place what is seen from the ground. `local` counts from the eye, where steps are small.

use super::options::Seam;
use super::truth::{ALLOWED_TEXELS, finest_level, texels_along};
use terrafill_globe_views::Eye;

/// Step of `f32` below 1.
const STEP: f64 = f32::EPSILON as f64 / 2.0;

/// Roundings between a corner's U and a fragment's, each by up to a step where U is near 1. One is the corner's own. U ÷ w
/// and its sum over three corners take four: a quotient, a product and two sums. 1 ÷ w takes as many, and the quotient of
/// both sums is the last.
const ROUNDINGS: f64 = 10.0;

/// Texels of the finest level that a step of `f32` just below 1 is.
///
/// - `way`: how the seam is seen to; `None` where places are counted from the eye, which has no such step
pub(crate) fn step_texels(eye: &Eye, way: Seam) -> Option<f64> {
    (way != Seam::Local).then(|| STEP * texels_along(finest_level(eye)))
}

/// Whether roundings alone may put a place farther beyond its texel than is allowed, for want of digits.
pub(crate) fn may_lose_texels(step_texels: f64) -> bool {
    ROUNDINGS * step_texels > ALLOWED_TEXELS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::shipped;

    #[test]
    fn single_precision_loses_texels_near_the_ground_alone() {
        let lost = |side_px, seam| -> Vec<String> {
            let views = shipped().expect("a list");
            let lost = |view: &&terrafill_globe_views::ViewRow| {
                step_texels(&view.eye(side_px), seam).is_some_and(may_lose_texels)
            };
            views
                .iter()
                .filter(lost)
                .map(|view| view.name.clone())
                .collect()
        };
        let near = ["nadir-10km", "horizon-2km", "ground-1.7m"];
        assert_eq!(lost(1024, Seam::Split(0.5)), near);
        // Negative controls: counted from the eye nothing is lost, and larger pixels show coarser texels.
        assert!(lost(1024, Seam::Local).is_empty());
        assert_eq!(lost(64, Seam::None), near[2..]);
    }

    #[test]
    fn a_step_is_what_f32_has_beside_1() {
        let below = f64::from(1.0_f32.next_down());
        assert!((1.0 - below - STEP).abs() < f64::EPSILON);
        let ground = crate::views::tiled_view("ground-1.7m").eye(1024);
        assert_eq!(step_texels(&ground, Seam::Rotated), Some(64.0));
    }
}
