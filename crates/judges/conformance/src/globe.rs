// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture whose depth at every pixel follows from a formula: a bare ellipsoid. For whoever must know that targets
//! come back as they were drawn.
//!
//! A pixel's ray enters the drawn facets between the ellipsoid itself and the same one lowered by as
//! much as facets hang below it. Both are widened by what rasterisation and `f32` may move. A ray that
//! misses the outer one must show the sky. A ray that meets the inner one must show a depth between
//! both. Lengths in metres, ECEF axes.

use crate::tolerance::{COARSEST_SNAP_PX, DEPTH_ROUNDING_M};
use glam::{DMat3, DVec3};
use terrafill_contract::{FillInput, Picture, PreparedScene, SKY};
use terrafill_plan::{PlanOptions, RegionSet};
use terrafill_scene::{ImageSize, Scene, SceneError};
use terrafill_surface::{EllipsoidKind, SurfaceError};

/// Why there is no such globe: a defect of the scene that it is made from.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
#[non_exhaustive]
pub enum GlobeError {
    /// The scene.
    Scene(#[from] SceneError),
    /// Its surface in the view.
    Surface(#[from] SurfaceError),
}

/// The globe in an image of this size: with sky on every side, not in the middle and rolled, so that a picture that is
/// mirrored or turned is wrong.
///
/// # Errors
/// [`GlobeError`].
pub fn rolled_globe(size: ImageSize) -> Result<FillInput, GlobeError> {
    // Its regions are not drawn, and its view of the globe looks straight down.
    let scene = Scene::shipped("hills", None)?;
    let mut view = scene.views[0].clone();
    view.pose.pitch_rad = (-87_f64).to_radians();
    // Facets of 1° hang at most 490 m below the ellipsoid.
    let surface = EllipsoidKind::surface(&scene.body, 180);
    let scene = PreparedScene::new(&scene, RegionSet::default(), surface);
    let mut input = FillInput::new(&scene, &view, size, PlanOptions::default())?;
    // The surface lies about the eye, which a roll leaves where it is.
    let roll = DMat3::from_rotation_z(30_f64.to_radians());
    input.camera.view_from_ecef = roll * input.camera.view_from_ecef;
    Ok(input)
}

/// How a picture of a bare ellipsoid, in which nothing is filled, differs from what the formula says; `None` where it does
/// not.
#[must_use]
pub fn globe_mismatch(picture: &Picture, input: &FillInput) -> Option<String> {
    let (size, camera) = (input.size, &input.camera);
    let found = (picture.size, picture.rgba.len(), picture.depth.len());
    let expected = (size, 4 * size.pixel_count(), size.pixel_count());
    if found != expected {
        return Some(format!(
            "size, bytes and depths: {found:?}, expected {expected:?}"
        ));
    }
    let body = &input.scene.body;
    let radius_m = body.equatorial_radius_m();
    let axes_m = DVec3::new(radius_m, radius_m, body.polar_radius_m());
    let snapped_m = COARSEST_SNAP_PX * camera.pixel_size_m(size, camera.eye_ecef.length());
    let (margin_m, terrain) = (snapped_m + DEPTH_ROUNDING_M, input.terrain());
    let outer_m = axes_m + terrain.highest_m + margin_m;
    let inner_m = axes_m + terrain.lowest_m - margin_m;
    let columns_of = |row| (0..size.width).map(move |column| (column, row));
    let places = (0..size.height).flat_map(columns_of);
    let (pixels, _) = picture.rgba.as_chunks::<4>();
    let mut shown = places.zip(pixels.iter().zip(&picture.depth));
    shown.find_map(|((column, row), (&pixel, &depth))| {
        let direction = camera.pixel_direction_ecef(size, column, row);
        let [enters_m, inside_m] =
            [outer_m, inner_m].map(|axes_m| entry_m(camera.eye_ecef, direction, axes_m));
        let is_right = if depth > 0.0 {
            let distance_m = camera.near_m / f64::from(depth);
            let is_on_globe = enters_m.is_some_and(|from_m| from_m <= distance_m);
            // At the silhouette a ray may pass the inner one by.
            let is_before = inside_m.is_none_or(|to_m| distance_m <= to_m);
            is_on_globe && is_before && !is_sky(pixel) && pixel[3] == 0
        } else {
            // Neither a negative depth nor a NaN is the sky's.
            depth.to_bits() == 0 && is_sky(pixel) && inside_m.is_none()
        };
        (!is_right).then(|| {
            format!(
                "column {column}, row {row}: colour {pixel:?} and depth {depth} are not the globe's"
            )
        })
    })
}

/// View depth at which a ray enters an ellipsoid about the origin; `None` where it passes by.
///
/// - `direction`: its component along the viewing direction is 1
fn entry_m(eye: DVec3, direction: DVec3, axes_m: DVec3) -> Option<f64> {
    let (eye, direction) = (eye / axes_m, direction / axes_m);
    let square = direction.length_squared();
    let half = eye.dot(direction);
    let discriminant = half * half - square * (eye.length_squared() - 1.0);
    let is_ahead = half < 0.0 && discriminant >= 0.0;
    is_ahead.then(|| (-half - discriminant.sqrt()) / square)
}

fn is_sky(pixel: [u8; 4]) -> bool {
    let mut channels = pixel.iter().zip(SKY);
    channels.all(|(&found, sky)| (f32::from(found) - 255.0 * sky).abs() <= 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize::new(101, 67);

    /// The picture of the ellipsoid itself.
    fn drawn(input: &FillInput) -> Picture {
        let body = &input.scene.body;
        let radius_m = body.equatorial_radius_m();
        let axes_m = DVec3::new(radius_m, radius_m, body.polar_radius_m());
        let mut picture = Picture {
            size: SIZE,
            rgba: Vec::new(),
            depth: Vec::new(),
        };
        for row in 0..SIZE.height {
            for column in 0..SIZE.width {
                let direction = input.camera.pixel_direction_ecef(SIZE, column, row);
                let entry = entry_m(input.camera.eye_ecef, direction, axes_m);
                #[allow(clippy::cast_possible_truncation, reason = "as a device stores them")]
                let depth = entry.map_or(0.0, |entry| (input.camera.near_m / entry) as f32);
                let sky = [5, 5, 10, 0];
                picture.depth.push(depth);
                picture.rgba.extend(entry.map_or(sky, |_| [90, 90, 90, 0]));
            }
        }
        picture
    }

    #[test]
    fn a_ray_enters_where_the_ellipsoid_is() {
        let axes_m = DVec3::new(2.0, 2.0, 1.0);
        let enter = |eye, direction| entry_m(eye, direction, axes_m);
        assert_eq!(enter(DVec3::Z * 5.0, DVec3::NEG_Z), Some(4.0));
        assert_eq!(enter(DVec3::X * 5.0, DVec3::NEG_X), Some(3.0));
        assert_eq!(enter(DVec3::X * 5.0, DVec3::X), None, "behind the eye");
        assert_eq!(enter(DVec3::new(5.0, 0.0, 1.1), DVec3::NEG_X), None);
    }

    #[test]
    fn the_globe_is_right_and_any_other_picture_is_wrong() {
        let input = rolled_globe(SIZE).expect("a surface");
        let right = drawn(&input);
        assert_eq!(globe_mismatch(&right, &input), None);
        let depths = || right.depth.iter().enumerate();
        let sky = depths().min_by(|a, b| a.1.total_cmp(b.1)).expect("sky").0;
        // Nearest to the eye, far from the silhouette.
        let ground = depths().max_by(|a, b| a.1.total_cmp(b.1));
        let ground = ground.expect("ground").0;
        // Negative controls: everything that can be wrong.
        let mirrored = |picture: &mut Picture| {
            let width = SIZE.width as usize;
            picture.depth.chunks_mut(width).for_each(<[f32]>::reverse);
            let (pixels, _) = picture.rgba.as_chunks_mut::<4>();
            pixels.chunks_mut(width).for_each(<[[u8; 4]]>::reverse);
        };
        let changes: [&dyn Fn(&mut Picture); 10] = [
            &|picture| picture.size.width -= 1,
            &|picture| picture.rgba.truncate(4),
            &|picture| picture.depth.truncate(1),
            &|picture| picture.rgba[4 * sky] += 1,
            &|picture| picture.rgba[4 * ground + 3] = 255,
            &|picture| picture.depth[sky] = f32::NAN,
            &|picture| picture.depth[ground] *= 1.01,
            &|picture| picture.rgba.rotate_right(4),
            &|picture| picture.depth.reverse(),
            &mirrored,
        ];
        for (number, change) in changes.into_iter().enumerate() {
            let mut picture = right.clone();
            change(&mut picture);
            assert!(
                globe_mismatch(&picture, &input).is_some(),
                "change {number}"
            );
        }
    }
}
