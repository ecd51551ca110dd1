// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a surface as drawn is from the body, seen by the eye: pixel by pixel, in `f64`.
//!
//! A pixel's ray meets the body at its true place and the surface at the drawn one. The foot of the drawn
//! place on the body, along the geodetic normal, is what a texture by direction shows there. Its distance
//! from the pixel's centre after projection is the error in pixels. A texture of a map is interpolated
//! from the corners of the triangle instead: longitude and Mercator's latitude, which gives a second one.

use glam::DVec3;
use std::f64::consts::{PI, TAU};
use terrafill_contract::Picture;
use terrafill_globe_views::{Eye, shares};
use terrafill_reference::SurfaceTriangles;
use terrafill_results::quantile;
use terrafill_surface::SurfaceFrame;

/// Median, 99 % and the largest of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
}

impl Range {
    fn of(values: &[f64]) -> Option<Self> {
        Some(Self {
            median: quantile(values, 0.5)?,
            p99: quantile(values, 0.99)?,
            max: quantile(values, 1.0)?,
        })
    }
}

/// A picture's errors.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Errors {
    /// Pixels that show the body and the surface.
    pub(crate) compared_px: usize,
    pub(crate) px: Option<Range>,
    /// On the ground, metres.
    pub(crate) max_m: Option<f64>,
    /// By interpolated longitude and Mercator's latitude.
    pub(crate) map_px: Option<Range>,
    pub(crate) map_max_m: Option<f64>,
    /// Along the rays, metres.
    pub(crate) depth_m: Option<f64>,
    /// Of the drawn places, above the body, metres.
    pub(crate) lowest_m: Option<f64>,
    /// Pixels more than one pixel within the body's outline that show no surface.
    pub(crate) uncovered_px: usize,
    /// Pixels that show surface where the body is not.
    pub(crate) extra_px: usize,
    /// Figures that are NaN or infinite.
    pub(crate) non_finite: usize,
    /// Which pixels show surface.
    pub(crate) shown: Vec<bool>,
}

/// What a ray meets.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// View depth.
    depth: f64,
    /// Corners of the triangle, relative to the eye.
    facet: Option<[DVec3; 3]>,
}

/// Where a pixel's ray meets the body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Truth {
    /// View depth.
    depth: f64,
    /// Metres.
    pub(crate) ecef: DVec3,
    /// Unit outward normal of the body there.
    pub(crate) normal: DVec3,
}

/// Pixels in rows; the same for all surfaces in a view.
pub(crate) fn truths(eye: &Eye) -> Vec<Option<Truth>> {
    let camera = &eye.camera;
    let body = SurfaceTriangles::of_body(&eye.body, camera.eye_ecef);
    eye.by_pixel(|_, _, direction| {
        let depth = body.hit(direction, camera.near_m)?;
        let ecef = camera.eye_ecef + direction * depth;
        let (normal, _) = eye.body.normal_and_height(ecef);
        Some(Truth {
            depth,
            ecef,
            normal,
        })
    })
}

/// A pixel that shows the body and the surface.
#[derive(Debug, Clone, Copy)]
struct PixelError {
    px: f64,
    metres: f64,
    map: Option<[f64; 2]>,
    depth_m: f64,
    height_m: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    is_body: bool,
    is_well_inside: bool,
    is_shown: bool,
    error: Option<PixelError>,
}

/// Of the triangles of a frame.
///
/// - `truths`: of the same eye
pub(crate) fn of_frame(eye: &Eye, truths: &[Option<Truth>], frame: &SurfaceFrame) -> Errors {
    let triangles = SurfaceTriangles::new(frame);
    let lost = usize::try_from(triangles.non_finite()).unwrap_or(usize::MAX);
    let mut errors = measure(eye, truths, |_, direction| {
        let (depth, facet) = triangles.hit_facet(direction, eye.camera.near_m)?;
        Some(Met {
            depth,
            facet: Some(facet),
        })
    });
    errors.non_finite += lost;
    errors
}

/// Of the depth that a device wrote.
///
/// - `truths`: of the same eye
pub(crate) fn of_depth(eye: &Eye, truths: &[Option<Truth>], picture: &Picture) -> Errors {
    measure(eye, truths, |pixel, _| {
        let depth = f64::from(picture.depth[pixel]);
        (depth != 0.0).then(|| Met {
            depth: eye.camera.near_m / depth,
            facet: None,
        })
    })
}

fn measure(
    eye: &Eye,
    truths: &[Option<Truth>],
    met: impl Fn(usize, DVec3) -> Option<Met> + Sync,
) -> Errors {
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let pixels = eye.by_pixel_with(|corners: &mut MapCorners, pixel, centre, direction| {
        let met = met(pixel, direction);
        judge(
            eye,
            (&body, truths[pixel]),
            (centre, direction),
            met,
            corners,
        )
    });
    let found: Vec<PixelError> = pixels.iter().filter_map(|pixel| pixel.error).collect();
    let is_finite = |error: &PixelError| {
        [error.px, error.metres, error.depth_m, error.height_m]
            .into_iter()
            .chain(error.map.into_iter().flatten())
            .all(f64::is_finite)
    };
    let all = |of: &dyn Fn(&PixelError) -> f64| -> Vec<f64> { found.iter().map(of).collect() };
    let maps: Vec<[f64; 2]> = found.iter().filter_map(|error| error.map).collect();
    let map_px: Vec<f64> = maps.iter().map(|map| map[0]).collect();
    let largest = |values: Vec<f64>| values.into_iter().max_by(f64::total_cmp);
    let count = |of: &dyn Fn(&Pixel) -> bool| pixels.iter().filter(|pixel| of(pixel)).count();
    Errors {
        compared_px: found.len(),
        px: Range::of(&all(&|error| error.px)),
        max_m: largest(all(&|error| error.metres)),
        map_px: Range::of(&map_px),
        map_max_m: largest(maps.iter().map(|map| map[1]).collect()),
        depth_m: largest(all(&|error| error.depth_m)),
        lowest_m: all(&|error| error.height_m)
            .into_iter()
            .min_by(f64::total_cmp),
        uncovered_px: count(&|pixel| pixel.is_well_inside && !pixel.is_shown),
        extra_px: count(&|pixel| pixel.is_shown && !pixel.is_body),
        non_finite: found.iter().filter(|error| !is_finite(error)).count(),
        shown: pixels.iter().map(|pixel| pixel.is_shown).collect(),
    }
}

fn judge(
    eye: &Eye,
    (body, truth): (&SurfaceTriangles, Option<Truth>),
    (centre, direction): ([f64; 2], DVec3),
    met: Option<Met>,
    corners: &mut MapCorners,
) -> Pixel {
    let (camera, size) = (&eye.camera, eye.size);
    let mut pixel = Pixel {
        is_body: truth.is_some(),
        is_shown: met.is_some(),
        ..Pixel::default()
    };
    let Some(truth) = truth else {
        return pixel;
    };
    if !pixel.is_shown {
        let beside = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
        pixel.is_well_inside = beside.iter().all(|[x, y]| {
            let ray = camera.direction_ecef(size, [centre[0] + x, centre[1] + y]);
            body.hit(ray, camera.near_m).is_some()
        });
    }
    pixel.error = met.map(|met| {
        let drawn_ecef = camera.eye_ecef + direction * met.depth;
        let (normal, height_m) = eye.body.normal_and_height(drawn_ecef);
        let shift = |normal: DVec3| {
            let foot = eye.body.surface_point(normal);
            [shift_px(eye, foot, centre), (foot - truth.ecef).length()]
        };
        let [px, metres] = shift(normal);
        PixelError {
            px,
            metres,
            map: met
                .facet
                .map(|facet| shift(corners.between(eye, facet, direction * met.depth))),
            depth_m: (met.depth - truth.depth).abs() * direction.length(),
            height_m,
        }
    });
    pixel
}

/// How far from `centre` a place is seen, pixels; at most the image's diagonal, as behind the eye.
pub(crate) fn shift_px(eye: &Eye, ecef: DVec3, centre: [f64; 2]) -> f64 {
    let [width, height] = [eye.size.width, eye.size.height].map(f64::from);
    let diagonal = (width * width + height * height).sqrt();
    let view = eye.camera.view_from_ecef * (ecef - eye.camera.eye_ecef);
    if view.z >= 0.0 {
        return diagonal;
    }
    let per_tangent = eye.focal_px();
    let x = 0.5 * width - per_tangent * view.x / view.z - centre[0];
    let y = 0.5 * height + per_tangent * view.y / view.z - centre[1];
    (x * x + y * y).sqrt().min(diagonal)
}

/// Longitude and Mercator's y of a triangle's corners, remembered: pixels beside each other mostly show the same one.
#[derive(Debug, Default)]
pub(crate) struct MapCorners {
    facet: [DVec3; 3],
    corners: [[f64; 2]; 3],
}

impl MapCorners {
    /// Normal of the body at the place that they give, interpolated, for a point of the triangle.
    pub(crate) fn between(&mut self, eye: &Eye, facet: [DVec3; 3], point: DVec3) -> DVec3 {
        if self.facet != facet {
            self.facet = facet;
            self.corners = facet.map(|corner| {
                let (normal, _) = eye.body.normal_and_height(corner + eye.camera.eye_ecef);
                [normal.y.atan2(normal.x), mercator(normal)]
            });
        }
        let [first, _] = self.corners[0];
        let (mut east, mut up) = (0.0, 0.0);
        for ([longitude, y], share) in self.corners.iter().zip(shares(facet, point)) {
            let across = longitude - first;
            east += share * (across - TAU * (across / TAU).round());
            up += share * y;
        }
        // Sine and cosine of the latitude are tanh and 1 / cosh of Mercator's y.
        let (sine, cosine) = (first + east).sin_cos();
        let grown = up.exp();
        let across = 2.0 * grown / (grown * grown + 1.0);
        let north = (grown * grown - 1.0) / (grown * grown + 1.0);
        DVec3::new(across * cosine, across * sine, north)
    }
}

/// Mercator's y of a place by its normal, ±π at the ends of its square and beyond.
fn mercator(normal: DVec3) -> f64 {
    let across = normal.x.hypot(normal.y);
    // From the nearer pole, where nothing cancels.
    let y = ((1.0 + normal.z.abs()) / across).ln();
    y.min(PI).copysign(normal.z)
}
