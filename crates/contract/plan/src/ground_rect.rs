// SPDX-License-Identifier: MIT OR Apache-2.0
//! The part of an image that shows ground: beyond its rectangle there is only sky.
//!
//! A line of the image and the eye span a plane. Where the whole body lies on one side of it, all rays on the other
//! side meet the sky. Points of an ellipsoid with the semi-axes `A` reach as far as `|A n|` along a normal `n` from
//! its centre. So the plane through the eye `e` leaves the body behind where `|A n| ≤ n · e`. For lines along the
//! image's sides `n` is linear in their place, and the outermost planes are roots of a quadratic equation.

use crate::PixelRect;
use crate::pixel_rect::pixel;
use glam::DVec3;
use terrafill_core::Ellipsoid;
use terrafill_scene::{Camera, ImageSize};

/// Pixels by which the ground's rectangle is wider: rounding of corners to `f32` and to the rasteriser's grid moves
/// them by less.
const MARGIN_PX: f64 = 1.0;

/// No pixel outside shows the surface. The whole image where no side of it is certainly sky.
///
/// - `highest_m`: no point of the surface lies higher above the ellipsoid
#[must_use]
pub(crate) fn ground_rect(
    body: &Ellipsoid,
    camera: &Camera,
    size: ImageSize,
    highest_m: f64,
) -> PixelRect {
    // Scaled so, the ellipsoid holds all points up to that height.
    let scale = 1.0 + highest_m.max(0.0) / body.polar_radius_m();
    let unit = body.equatorial_radius_m().recip();
    let axes = body.radii_m() * (scale * unit);
    let eye = camera.eye_ecef * unit;
    let ecef_from_view = camera.view_from_ecef.transpose();
    let [right, up, back] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| ecef_from_view * axis);
    let tan = camera.tan_half_fov();
    let [width, height] = [size.width, size.height].map(f64::from);
    let [left, right] = sides(axes, eye, right, back);
    let [bottom, top] = sides(axes, eye, up, back);
    let column = |tangent: f64| (1.0 + tangent / (tan * size.aspect())) * 0.5 * width;
    let row = |tangent: f64| (1.0 - tangent / tan) * 0.5 * height;
    PixelRect {
        left: left.map_or(0, |at| first(column(at), size.width)),
        right: right.map_or(size.width, |at| past(column(at), size.width)),
        top: top.map_or(0, |at| first(row(at), size.height)),
        bottom: bottom.map_or(size.height, |at| past(row(at), size.height)),
    }
    .within(PixelRect::full(size))
}

/// First pixel of those from `at` on.
fn first(at: f64, count: u32) -> u32 {
    pixel((at - MARGIN_PX).floor(), count)
}

/// One past the last pixel of those before `at`.
fn past(at: f64, count: u32) -> u32 {
    pixel((at + MARGIN_PX).ceil(), count)
}

/// Along an axis of the image, where the ground begins and ends at most, as tangents of the angle from its middle;
/// `None` where no such line is known.
///
/// - `axes`, `eye`: in units of the same length
/// - `along`, `back`: unit vectors along the axis and away from what is looked at
fn sides(axes: DVec3, eye: DVec3, along: DVec3, back: DVec3) -> [Option<f64>; 2] {
    // The plane of the rays at the tangent t has the normal along + t · back.
    let [from_along, from_back] = [along.dot(eye), back.dot(eye)];
    let [to_along, to_back] = [along * axes, back * axes];
    let a = from_back * from_back - to_back.length_squared();
    let b = from_along * from_back - to_along.dot(to_back);
    let c = from_along * from_along - to_along.length_squared();
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return [None; 2];
    }
    // Of the two forms of a root the one in which nothing cancels.
    let q = -(b + discriminant.sqrt().copysign(b));
    let roots = [q / a, c / q].into_iter().filter(|root| root.is_finite());
    let [mut begin, mut end] = [None::<f64>; 2];
    for root in roots {
        // The normal points to where the line moves: the body lies behind it, or in front.
        if from_along + root * from_back > 0.0 {
            end = Some(end.map_or(root, |known| known.min(root)));
        } else {
            begin = Some(begin.map_or(root, |known| known.max(root)));
        }
    }
    [begin, end]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;
    use terrafill_scene::CameraPose;

    const SIZE: ImageSize = ImageSize::new(80, 60);

    fn camera(body: &Ellipsoid, height_m: f64, heading_deg: f64, pitch_deg: f64) -> Camera {
        let pose = CameraPose {
            eye: Geodetic::from_degrees(25.0, 40.0, height_m),
            heading_rad: heading_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 45_f64.to_radians(),
            near_m: 1.0,
        };
        Camera::new(body, &pose)
    }

    /// Smallest rectangle of the pixels whose rays meet the ellipsoid with these semi-axes.
    fn shown(camera: &Camera, axes_m: DVec3) -> Option<PixelRect> {
        let eye = camera.eye_ecef / axes_m;
        let mut found: Option<PixelRect> = None;
        for row in 0..SIZE.height {
            for column in 0..SIZE.width {
                let ray = camera.pixel_direction_ecef(SIZE, column, row) / axes_m;
                let along = eye.dot(ray);
                let reaches = along * along >= ray.length_squared() * (eye.length_squared() - 1.0);
                if along < 0.0 && reaches {
                    let own = PixelRect {
                        left: column,
                        top: row,
                        right: column + 1,
                        bottom: row + 1,
                    };
                    found = Some(found.map_or(own, |known| known.around(own)));
                }
            }
        }
        found
    }

    #[test]
    fn no_pixel_that_shows_ground_lies_outside_and_little_sky_inside() {
        let (mut cut, mut controls) = (0, 0);
        for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
            let unit_m = body.equatorial_radius_m();
            for height in [1e-7, 1e-4, 3e-2, 0.5, 2.0, 20.0] {
                for pitch_deg in [-90.0, -60.0, -20.0, -2.0, 10.0] {
                    for heading_deg in [0.0, 70.0, 200.0] {
                        let camera = camera(&body, height * unit_m, heading_deg, pitch_deg);
                        let rect = ground_rect(&body, &camera, SIZE, 0.0);
                        let what = format!("{height} {pitch_deg} {heading_deg}: {rect:?}");
                        let Some(hit) = shown(&camera, body.radii_m()) else {
                            continue;
                        };
                        assert_eq!(hit.within(rect), hit, "{what}, {hit:?}");
                        // The margin on each side, and what rounding to pixels takes. The widest place of a body
                        // that is not seen whole may lie outside the image, but its top is near the middle.
                        let is_whole = hit.left > 0
                            && hit.top > 0
                            && hit.right < SIZE.width
                            && hit.bottom < SIZE.height;
                        let slack = [
                            hit.top - rect.top,
                            hit.left - rect.left,
                            rect.right - hit.right,
                            rect.bottom - hit.bottom,
                        ];
                        let sides = if is_whole { 4 } else { 1 };
                        assert!(
                            slack[..sides].iter().all(|&side| side <= 3),
                            "{what}, {hit:?}"
                        );
                        cut += usize::from(rect != PixelRect::full(SIZE));
                        // Negative control: a body a tenth larger is not held.
                        let larger = shown(&camera, body.radii_m() * 1.1);
                        controls += usize::from(larger.is_some_and(|hit| hit.within(rect) != hit));
                    }
                }
            }
        }
        assert!(cut > 40 && controls > 20, "{cut} {controls}");
    }

    #[test]
    fn mountains_reach_into_the_sky() {
        let body = Ellipsoid::WGS84;
        let camera = camera(&body, 20_000.0, 0.0, -2.0);
        let bare = ground_rect(&body, &camera, SIZE, 0.0);
        let high = ground_rect(&body, &camera, SIZE, 9_000.0);
        assert!(bare.top > 20 && high.top < bare.top, "{bare:?} {high:?}");
        let highest = body.radii_m() * (1.0 + 9_000.0 / body.polar_radius_m());
        let hit = shown(&camera, highest).expect("ground");
        assert_eq!(hit.within(high), hit);
        // Between mountains nothing of the image is certainly sky.
        let among = ground_rect(&body, &camera, SIZE, 21_000.0);
        assert_eq!(among, PixelRect::full(SIZE));
    }
}
