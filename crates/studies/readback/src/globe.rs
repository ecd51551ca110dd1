// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture that is read back: a bare ellipsoid, whose depth at every pixel follows from a formula.
//!
//! A pixel's ray enters the drawn facets between the ellipsoid itself and the same one lowered by as
//! much as facets hang below it. Both are widened by what rasterisation and `f32` may move. A ray that
//! misses the outer one must show the sky. A ray that meets the inner one must show a depth between
//! both. Lengths in metres, ECEF axes.

use glam::{DMat3, DVec3};
use std::hash::{DefaultHasher, Hasher as _};
use terrafill_fill::{
    Api, DeviceError, Devices, FillInput, Picture, PreparedScene, RegionSet, SKY,
};
use terrafill_scene::{ImageSize, PlanOptions, Scene};
use terrafill_study::Failure;
use terrafill_surface::EllipsoidKind;

/// Vertices are snapped to steps of at most 1/16 of a pixel, the coarsest `subPixelPrecisionBits` that
/// Vulkan allows.
const SNAPPED_PX: f64 = 1.0 / 16.0;
/// Positions and depths in `f32` are rounded to 1 m at this distance; interpolation of depth loses a
/// few bits more.
const ROUNDED_M: f64 = 100.0;

/// Copies colour and depth to the CPU, rows tightly packed.
pub(crate) type Reader = Box<dyn Fn() -> Result<Picture, DeviceError>>;

/// Draws a surface into new targets of an interface.
pub(crate) type Draw = fn(&Devices, &FillInput) -> Result<Reader, DeviceError>;

/// Interfaces in the order in which they are reported.
pub(crate) const INTERFACES: [(Api, Draw); 2] = [
    (terrafill_gpu::API, |devices, input| {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let mut targets = terrafill_gpu::RenderTargets::new(&gpu, input.size)?;
        targets.prepare(input)?;
        targets.draw_surface()?;
        Ok(Box::new(move || targets.read()))
    }),
    (terrafill_vulkan::API, |devices, input| {
        let gpu = terrafill_vulkan::shared_gpu(devices)?;
        let mut targets = terrafill_vulkan::RenderTargets::new(&gpu, input.size)?;
        targets.prepare(input)?;
        targets.draw_surface()?;
        Ok(Box::new(move || targets.read()))
    }),
];

/// The globe in an image of this size: with sky on every side, not in the middle and rolled, so that a picture that is
/// mirrored or turned is wrong.
pub(crate) fn globe(size: ImageSize) -> Result<FillInput, Failure> {
    // Its regions are not drawn, and its view of the globe looks straight down.
    let scene = Scene::shipped("hills", None).map_err(Failure::broken)?;
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

/// Whether two pictures read from the same targets are the globe of `input` and the same bytes.
///
/// # Errors
/// What is wrong first, with found and expected values.
pub(crate) fn check([first, second]: [&Picture; 2], input: &FillInput) -> Result<(), String> {
    let (size, camera) = (input.size, &input.camera);
    let found = (first.size, first.rgba.len(), first.depth.len());
    let expected = (size, 4 * size.pixel_count(), size.pixel_count());
    if found != expected {
        return Err(format!(
            "size, bytes and depths: {found:?}, expected {expected:?}"
        ));
    }
    let body = &input.scene.body;
    let radius_m = body.equatorial_radius_m();
    let axes_m = DVec3::new(radius_m, radius_m, body.polar_radius_m());
    let snapped_m = SNAPPED_PX * camera.pixel_size_m(size, camera.eye_ecef.length());
    let (margin_m, terrain) = (snapped_m + ROUNDED_M, input.terrain());
    let outer_m = axes_m + terrain.highest_m + margin_m;
    let inner_m = axes_m + terrain.lowest_m - margin_m;
    let columns_of = |row| (0..size.width).map(move |column| (column, row));
    let places = (0..size.height).flat_map(columns_of);
    let (pixels, _) = first.rgba.as_chunks::<4>();
    for ((column, row), (&pixel, &depth)) in places.zip(pixels.iter().zip(&first.depth)) {
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
        if !is_right {
            return Err(format!(
                "column {column}, row {row}: colour {pixel:?} and depth {depth} are not the globe's"
            ));
        }
    }
    if fingerprint(first) != fingerprint(second) {
        return Err("read twice, the same targets gave different bytes".to_owned());
    }
    Ok(())
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
        for (_, draw) in INTERFACES {
            let input = globe(SIZE).expect("a surface");
            let drawn = draw(&Devices::default(), &input);
            let Some(reader) = device_for_test(drawn) else {
                continue;
            };
            let read = || reader().expect("read");
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
        let input = globe(SIZE).expect("a surface");
        let drawn = (INTERFACES[0].1)(&Devices::default(), &input);
        let Some(reader) = device_for_test(drawn) else {
            return;
        };
        let mut picture = reader().expect("read");
        let width = SIZE.width as usize;
        picture.depth.chunks_mut(width).for_each(<[f32]>::reverse);
        let (pixels, _) = picture.rgba.as_chunks_mut::<4>();
        pixels.chunks_mut(width).for_each(<[[u8; 4]]>::reverse);
        assert!(check([&picture, &picture], &input).is_err());
    }
}
