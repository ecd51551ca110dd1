// SPDX-License-Identifier: MIT OR Apache-2.0
//! The bare globe as both devices draw it: what is asked of the surface through wgpu is asked through
//! Vulkan as well.

use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_fill::{FrameInput, Picture, PreparedScene, RegionSet};
use terrafill_scene::{CameraPose, ImageSize, Overlap, PlanOptions, View};
use terrafill_surface::EllipsoidKind;

/// Odd, so that rows are padded and the middle is a pixel.
pub(crate) const SIZE: ImageSize = ImageSize {
    width: 101,
    height: 67,
};

const NEAR_M: f64 = 1000.0;

/// Straight down, without regions.
pub(crate) fn globe_from(height_m: f64) -> FrameInput {
    let body = Ellipsoid::WGS84;
    let scene = PreparedScene {
        name: "bare".to_owned(),
        body,
        edge_rule: Default::default(),
        overlap: Overlap::Disjoint,
        regions: Arc::new([]),
        meshes: RegionSet::default(),
        levels: Arc::default(),
        bounds: Arc::new([]),
        surface: EllipsoidKind::surface(&body, 180),
        texture: None,
    };
    let view = View {
        name: "globe".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(15.0, 20.0, height_m),
            heading_rad: 0.0,
            pitch_rad: -std::f64::consts::FRAC_PI_2,
            fov_y_rad: 60_f64.to_radians(),
            near_m: NEAR_M,
        },
        note: None,
    };
    FrameInput::new(&scene, &view, SIZE, PlanOptions::default()).expect("a surface")
}

/// Asserts that `picture` holds the depth of the globe from 8,000 km, and no colour.
pub(crate) fn assert_depth_of_the_ellipsoid(picture: &Picture) {
    let at = |column: usize, row: usize| picture.depth[row * SIZE.width as usize + column];
    // Reversed depth is near / distance; facets of 1° hang up to 488 m below the ellipsoid.
    let distance = NEAR_M / f64::from(at(50, 33));
    assert!((7.99999e6..8.0005e6).contains(&distance), "{distance}");
    assert_eq!(at(0, 0), 0.0, "the sky keeps the cleared depth");
    let mut alphas = picture.rgba.chunks_exact(4).map(|pixel| pixel[3]);
    assert!(alphas.all(|alpha| alpha == 0));
    // The disc's area against the silhouette of a sphere: sin θ = R / (R + h).
    let covered = picture.depth.iter().filter(|&&depth| depth > 0.0).count();
    let sin = 6.371e6 / (6.371e6 + 8e6);
    let radius_px = sin / f64::sqrt(1.0 - sin * sin) / 30_f64.to_radians().tan() * 33.5;
    let area = std::f64::consts::PI * radius_px * radius_px;
    assert!(
        (covered as f64 / area - 1.0).abs() < 0.02,
        "{covered} of {area}"
    );
}
