// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture's colours against the layers' functions, in `f64`.

use super::device::Shading;
use super::layers::{colour, lights};
use crate::error::shares;
use crate::list::Eye;
use glam::DVec3;
use terrafill_reference::SurfaceTriangles;
use terrafill_surface::SurfaceFrame;

/// How far a shaded picture is from the functions, channels as numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ShadingErrors {
    /// Of each compared pixel, the largest channel's difference from the functions.
    pub(super) all: Vec<f64>,
    /// Within 5° of a pole.
    pub(super) polar: Vec<f64>,
    pub(super) non_finite: usize,
    pub(super) shown: usize,
}

/// Sine of 85°.
const POLAR_SINE: f64 = 0.996_194_698_091_745_5;

/// Compares a picture with the functions, by the place that each pixel's ray meets.
pub(super) fn judge(
    eye: &Eye,
    frame: &SurfaceFrame,
    shading: Shading,
    picture: &[[f32; 4]],
) -> ShadingErrors {
    let triangles = SurfaceTriangles::new(frame);
    let lights = lights(eye);
    let judged = eye.by_pixel(|pixel, _, direction| {
        let (depth, facet) = triangles.hit_facet(direction, eye.camera.near_m)?;
        let shown = picture[pixel];
        if shown[3] == 0.0 {
            return None;
        }
        // Normal and direction to the eye are interpolated as the device does: from the triangle's corners.
        let shares = shares(facet, direction * depth);
        let mixed = |of: [DVec3; 3]| {
            let terms = of.iter().zip(shares);
            terms.fold(DVec3::ZERO, |sum, (of, share)| sum + *of * share)
        };
        let n = mixed(facet.map(|corner| normal(eye, corner))).normalize();
        let to_eye = mixed(facet.map(|corner| -corner));
        let expected = colour(&lights, shading.removed, n, to_eye);
        let off = (0..3).map(|i| (f64::from(shown[i]) - expected[i]).abs());
        // What is no number must not be lost in a maximum.
        let larger = |worst: f64, off: f64| if off <= worst { worst } else { off };
        Some((off.fold(0.0, larger), n.z.abs() > POLAR_SINE))
    });
    let mut found = ShadingErrors {
        non_finite: picture.iter().filter(|colour| is_lost(colour)).count(),
        shown: picture.iter().filter(|colour| colour[3] != 0.0).count(),
        ..ShadingErrors::default()
    };
    let judged = judged.into_iter().flatten();
    for (off, is_polar) in judged.filter(|(off, _)| off.is_finite()) {
        found.all.push(off);
        if is_polar {
            found.polar.push(off);
        }
    }
    found
}

/// Geodetic normal of a place relative to the eye.
pub(super) fn normal(eye: &Eye, relative_m: DVec3) -> DVec3 {
    let radii = eye.body.radii_m();
    ((eye.camera.eye_ecef + relative_m) / (radii * radii)).normalize()
}

/// Whether a colour is no number.
pub(super) fn is_lost(colour: &[f32; 4]) -> bool {
    colour.iter().any(|channel| !channel.is_finite())
}

/// As pictures show it: what is not finite is magenta.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of 255 after clamping"
)]
pub(super) fn bytes(colour: [f32; 4]) -> [u8; 3] {
    if is_lost(&colour) {
        [255, 0, 255]
    } else {
        [0, 1, 2].map(|i| (255.0 * colour[i].clamp(0.0, 1.0)).round() as u8)
    }
}
