// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a surface as drawn is from the body, seen by the eye: pixel by pixel, in `f64`.
//!
//! A pixel's ray meets the body at its true place and the surface at the drawn one. The foot of the drawn
//! place on the body, along the geodetic normal, is what a texture by direction shows there. Its distance
//! from the pixel's centre after projection is the error in pixels. A texture of a map is interpolated
//! from the corners of the triangle instead: longitude and Mercator's latitude, which gives a second one.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use terrafill_contract::Picture;
use terrafill_core::Geodetic;
use terrafill_globe_views::{Eye, shares, sorted};
use terrafill_reference::SurfaceTriangles;
use terrafill_results::quantile;
use terrafill_surface::SurfaceFrame;

/// Where Mercator's square ends, radians: `atan(sinh π)`.
const MERCATOR_END_RAD: f64 = 1.484_422_229_745_332_4;

/// Median, 99 % and the largest of something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) max: f64,
}

impl Range {
    fn of(values: Vec<f64>) -> Option<Self> {
        let values = sorted(values);
        Some(Self {
            median: quantile(&values, 0.5)?,
            p99: quantile(&values, 0.99)?,
            max: quantile(&values, 1.0)?,
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
pub(crate) fn of_frame(eye: &Eye, frame: &SurfaceFrame) -> Errors {
    let triangles = SurfaceTriangles::new(frame);
    let lost = usize::try_from(triangles.non_finite()).unwrap_or(usize::MAX);
    let mut errors = measure(eye, |_, direction| {
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
pub(crate) fn of_depth(eye: &Eye, picture: &Picture) -> Errors {
    measure(eye, |pixel, _| {
        let depth = f64::from(picture.depth[pixel]);
        (depth != 0.0).then(|| Met {
            depth: eye.camera.near_m / depth,
            facet: None,
        })
    })
}

fn measure(eye: &Eye, met: impl Fn(usize, DVec3) -> Option<Met> + Sync) -> Errors {
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let pixels = eye.by_pixel_with(|corners: &mut MapCorners, pixel, centre, direction| {
        let met = met(pixel, direction);
        judge(eye, &body, (centre, direction), met, corners)
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
        px: Range::of(all(&|error| error.px)),
        max_m: largest(all(&|error| error.metres)),
        map_px: Range::of(map_px),
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
    body: &SurfaceTriangles,
    (centre, direction): ([f64; 2], DVec3),
    met: Option<Met>,
    corners: &mut MapCorners,
) -> Pixel {
    let (camera, size) = (&eye.camera, eye.size);
    let true_depth = body.hit(direction, camera.near_m);
    let mut pixel = Pixel {
        is_body: true_depth.is_some(),
        is_shown: met.is_some(),
        ..Pixel::default()
    };
    let Some(true_depth) = true_depth else {
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
        let true_ecef = camera.eye_ecef + direction * true_depth;
        let drawn_ecef = camera.eye_ecef + direction * met.depth;
        let drawn = eye.body.ecef_to_geodetic(drawn_ecef);
        let shift = |place: Geodetic| {
            let foot = eye.below(place);
            [shift_px(eye, foot, centre), (foot - true_ecef).length()]
        };
        let [px, metres] = shift(drawn);
        PixelError {
            px,
            metres,
            map: met
                .facet
                .map(|facet| shift(corners.between(eye, facet, direction * met.depth))),
            depth_m: (met.depth - true_depth).abs() * direction.length(),
            height_m: drawn.height_m,
        }
    });
    pixel
}

/// How far from `centre` a place is seen, pixels; at most the image's diagonal, as behind the eye.
pub(crate) fn shift_px(eye: &Eye, ecef: DVec3, centre: [f64; 2]) -> f64 {
    let diagonal = f64::from(eye.size.width).hypot(f64::from(eye.size.height));
    let view = eye.camera.view_from_ecef * (ecef - eye.camera.eye_ecef);
    if view.z >= 0.0 {
        return diagonal;
    }
    let per_tangent = eye.focal_px();
    let x = 0.5 * f64::from(eye.size.width) - per_tangent * view.x / view.z - centre[0];
    let y = 0.5 * f64::from(eye.size.height) + per_tangent * view.y / view.z - centre[1];
    x.hypot(y).min(diagonal)
}

/// Longitude and Mercator's y of a triangle's corners, remembered: pixels beside each other mostly show the same one.
#[derive(Debug, Default)]
pub(crate) struct MapCorners {
    facet: [DVec3; 3],
    corners: [[f64; 2]; 3],
}

impl MapCorners {
    /// The place that they give, interpolated, for a point of the triangle.
    pub(crate) fn between(&mut self, eye: &Eye, facet: [DVec3; 3], point: DVec3) -> Geodetic {
        if self.facet != facet {
            self.facet = facet;
            self.corners = facet.map(|corner| {
                let place = eye.body.ecef_to_geodetic(corner + eye.camera.eye_ecef);
                [place.longitude_rad, mercator(place.latitude_rad)]
            });
        }
        let [first, _] = self.corners[0];
        let (mut east, mut up) = (0.0, 0.0);
        for ([longitude, y], share) in self.corners.iter().zip(shares(facet, point)) {
            let across = longitude - first;
            east += share * (across - TAU * (across / TAU).round());
            up += share * y;
        }
        Geodetic {
            longitude_rad: first + east,
            latitude_rad: up.sinh().atan(),
            height_m: 0.0,
        }
    }
}

/// Mercator's y of a latitude, ±π at the ends of its square and beyond.
fn mercator(latitude_rad: f64) -> f64 {
    let latitude = latitude_rad.clamp(-MERCATOR_END_RAD, MERCATOR_END_RAD);
    (FRAC_PI_4 + 0.5 * latitude).tan().ln().clamp(-PI, PI)
}
