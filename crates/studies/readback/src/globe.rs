// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture that is read back: a bare ellipsoid, whose depth at every pixel follows from a formula.
//!
//! A pixel's ray enters the drawn facets between the ellipsoid itself and the same one lowered by as
//! much as facets hang below it. Both are widened by what rasterisation and `f32` may move. A ray that
//! misses the outer one must show the sky. A ray that meets the inner one must show a depth between
//! both. Lengths in metres, ECEF axes.

use glam::{DMat3, DVec3};
use std::hash::{DefaultHasher, Hasher as _};
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_fill::{FillInput, Picture, PreparedScene, RegionSet, SKY, SceneBounds};
use terrafill_scene::{CameraPose, ImageSize, Overlap, PlanOptions, View};
use terrafill_surface::{EllipsoidKind, SurfaceError};

/// From here the globe is 41° wide and leaves sky on every side of a view of 60°.
const EYE_HEIGHT_M: f64 = 1.2e7;
/// The globe is above the middle of the picture …
const PITCH_DEG: f64 = -85.0;
/// … and the picture is rolled by this: a picture that is mirrored or turned is wrong.
const ROLL_DEG: f64 = 30.0;
/// Far in front of the surface.
const NEAR_M: f64 = 1000.0;
/// Rows of facets, 1° each: they hang at most 490 m below the ellipsoid.
const ROWS: u32 = 180;

/// Vertices are snapped to steps of at most 1/16 of a pixel, the coarsest `subPixelPrecisionBits` that
/// Vulkan allows.
const SNAPPED_PX: f64 = 1.0 / 16.0;
/// Positions and depths in `f32` are rounded to 1 m at this distance; interpolation of depth loses a
/// few bits more.
const ROUNDED_M: f64 = 100.0;

/// The globe in an image of this size.
pub(crate) fn globe(size: ImageSize) -> Result<FillInput, SurfaceError> {
    let body = Ellipsoid::WGS84;
    let scene = PreparedScene {
        name: "bare".to_owned(),
        body,
        edge_rule: Default::default(),
        overlap: Overlap::Disjoint,
        regions: Arc::new([]),
        meshes: RegionSet::default(),
        levels: Arc::default(),
        footprints: Arc::default(),
        bounds: SceneBounds::default(),
        parts: terrafill_fill::LazyParts::default(),
        surface: EllipsoidKind::surface(&body, ROWS),
        picture: None,
        texture: None,
    };
    let view = View {
        name: "globe".to_owned(),
        pose: CameraPose {
            eye: Geodetic::from_degrees(15.0, 20.0, EYE_HEIGHT_M),
            heading_rad: 0.0,
            pitch_rad: PITCH_DEG.to_radians(),
            fov_y_rad: 60_f64.to_radians(),
            near_m: NEAR_M,
        },
        note: None,
    };
    let mut input = FillInput::new(&scene, &view, size, PlanOptions::default())?;
    // The surface lies about the eye, which a roll leaves where it is.
    let roll = DMat3::from_rotation_z(ROLL_DEG.to_radians());
    input.camera.view_from_ecef = roll * input.camera.view_from_ecef;
    Ok(input)
}

/// Whether two pictures read from the same targets are the globe of `input` and the same bytes.
///
/// # Errors
/// What is wrong first, with found and expected values.
pub(crate) fn check(pictures: [&Picture; 2], input: &FillInput) -> Result<(), String> {
    let [first, second] = pictures;
    check_globe(first, input)?;
    if first.size != second.size || fingerprint(first) != fingerprint(second) {
        return Err("read twice, the same targets gave different bytes".to_owned());
    }
    Ok(())
}

/// Of all bytes of a picture.
pub(crate) fn fingerprint(picture: &Picture) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(&picture.rgba);
    hasher.write(bytemuck::cast_slice(&picture.depth));
    hasher.finish()
}

/// Bytes of colour and depth.
pub(crate) fn byte_count(picture: &Picture) -> u64 {
    (picture.rgba.len() + size_of_val(picture.depth.as_slice())) as u64
}

fn check_globe(picture: &Picture, input: &FillInput) -> Result<(), String> {
    let size = input.size;
    let (pixels, _) = picture.rgba.as_chunks::<4>();
    let found = (picture.size, picture.rgba.len(), picture.depth.len());
    let expected = (size, 4 * size.pixel_count(), size.pixel_count());
    if found != expected {
        return Err(format!(
            "size, bytes of colour and depths: found {found:?}, expected {expected:?}"
        ));
    }
    let shells = Shells::new(input);
    let columns_of = |row| (0..size.width).map(move |column| (column, row));
    let places = (0..size.height).flat_map(columns_of);
    for ((column, row), (pixel, &depth)) in places.zip(pixels.iter().zip(&picture.depth)) {
        if !shells.allow(input, [column, row], *pixel, depth) {
            return Err(format!(
                "column {column}, row {row}: found colour {pixel:?} and depth {depth}, which the \
                 globe has not there"
            ));
        }
    }
    Ok(())
}

/// Ellipsoids between which the drawn facets lie, semi-axes.
struct Shells {
    outer_m: DVec3,
    inner_m: DVec3,
}

impl Shells {
    fn new(input: &FillInput) -> Self {
        let body = &input.scene.body;
        let radius_m = body.equatorial_radius_m();
        let axes_m = DVec3::new(radius_m, radius_m, body.polar_radius_m());
        let farthest_m = input.camera.eye_ecef.length();
        let snapped_m = SNAPPED_PX * input.camera.pixel_size_m(input.size, farthest_m);
        let margin_m = snapped_m + ROUNDED_M;
        let terrain = input.terrain();
        Self {
            outer_m: axes_m + terrain.highest_m + margin_m,
            inner_m: axes_m + terrain.lowest_m - margin_m,
        }
    }

    /// Whether a pixel may look so.
    fn allow(
        &self,
        input: &FillInput,
        [column, row]: [u32; 2],
        pixel: [u8; 4],
        depth: f32,
    ) -> bool {
        let camera = &input.camera;
        let direction = camera.pixel_direction_ecef(input.size, column, row);
        let entered_m = |axes_m| entry_m(camera.eye_ecef, direction, axes_m);
        if depth > 0.0 {
            let distance_m = camera.near_m / f64::from(depth);
            let from_m = entered_m(self.outer_m);
            // At the silhouette a ray may pass the inner one by.
            let to_m = entered_m(self.inner_m).unwrap_or(f64::INFINITY);
            let is_on_globe = from_m.is_some_and(|from_m| from_m <= distance_m);
            is_on_globe && distance_m <= to_m && !is_sky(pixel) && pixel[3] == 0
        } else {
            // Neither a negative depth nor a NaN is the sky's.
            depth.to_bits() == 0 && is_sky(pixel) && entered_m(self.inner_m).is_none()
        }
    }
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
    use crate::api::INTERFACES;
    use terrafill_fill::{Devices, device_for_test};

    /// Odd, so that rows are padded.
    const SIZE: ImageSize = ImageSize {
        width: 101,
        height: 67,
    };

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
    fn the_globe_is_read_and_any_other_picture_is_wrong() {
        for interface in INTERFACES {
            let opened = (interface.open)(&Devices::default(), SIZE);
            let Some(mut targets) = device_for_test(opened) else {
                continue;
            };
            let input = globe(SIZE).expect("a surface");
            targets.draw(&input).expect("drawn");
            let read = || targets.read().expect("read");
            let right = read();
            assert_eq!(check([&right, &read()], &input), Ok(()));
            assert_eq!(byte_count(&right), 101 * 67 * 8);
            // Twins: everything that can be wrong.
            let depths = || right.depth.iter().enumerate();
            let sky = depths().min_by(|a, b| a.1.total_cmp(b.1)).expect("sky").0;
            // Nearest to the eye, far from the silhouette.
            let ground = depths()
                .max_by(|a, b| a.1.total_cmp(b.1))
                .expect("ground")
                .0;
            let wrong = |change: &dyn Fn(&mut Picture)| {
                let mut picture = right.clone();
                change(&mut picture);
                check([&picture, &picture], &input)
            };
            assert_eq!(wrong(&|_| {}), Ok(()));
            let changes: [&dyn Fn(&mut Picture); 9] = [
                &|picture| picture.size.width -= 1,
                &|picture| picture.rgba.truncate(4),
                &|picture| picture.depth.truncate(1),
                &|picture| picture.rgba[4 * sky] += 1,
                &|picture| picture.rgba[4 * ground + 3] = 255,
                &|picture| picture.depth[sky] = f32::NAN,
                &|picture| picture.depth[ground] *= 1.01,
                &|picture| picture.rgba.rotate_right(4),
                &|picture| picture.depth.reverse(),
            ];
            for (number, change) in changes.into_iter().enumerate() {
                assert!(wrong(change).is_err(), "change {number}");
            }
            // A byte of the globe's colour is checked by reading again.
            let mut other = right.clone();
            other.rgba[4 * ground] += 1;
            assert!(check([&right, &other], &input).is_err());
        }
    }

    #[test]
    fn a_mirrored_picture_is_wrong() {
        let (name, open) = (INTERFACES[0].api.name, INTERFACES[0].open);
        let Some(mut targets) = device_for_test(open(&Devices::default(), SIZE)) else {
            return;
        };
        let input = globe(SIZE).expect("a surface");
        targets.draw(&input).expect("drawn");
        let mut picture = targets.read().expect("read");
        let width = SIZE.width as usize;
        picture.depth.chunks_mut(width).for_each(<[f32]>::reverse);
        let (pixels, _) = picture.rgba.as_chunks_mut::<4>();
        pixels.chunks_mut(width).for_each(<[[u8; 4]]>::reverse);
        assert!(check([&picture, &picture], &input).is_err(), "{name}");
    }
}
