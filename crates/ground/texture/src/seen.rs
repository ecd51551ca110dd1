// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an eye sees of a region, and where its anchor then stands.
//!
//! A frame plan and the numerical suite both ask here, so what is measured is what is drawn. Extents
//! are geodetic, radians; eyes in body axes (ECEF), metres.

use crate::{MapExtent, MapRegion, MapRegionError};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_core::Ellipsoid;

impl MapRegion {
    /// The part of `extent` that the body does not hide from the eye. It is anchored in its middle, or
    /// at the pole that it touches, where charts are smooth. Where an `f32` offset from there would be
    /// rounded by more than 1/512 of a pixel, it is anchored below the eye: what is nearest to the eye
    /// is then nearest to the anchor.
    ///
    /// - `height_range_m`: of the surface as drawn
    /// - `pixel_m`: size of a pixel on the ground at the nearest point of the region
    ///
    /// # Errors
    /// As [`MapRegion::new`].
    pub fn seen_from(
        body: Ellipsoid,
        extent: MapExtent,
        height_range_m: (f64, f64),
        eye_ecef: DVec3,
        pixel_m: f64,
    ) -> Result<Self, MapRegionError> {
        let extent = visible_part(&body, eye_ecef, height_range_m, extent);
        let mut middle = Self::new(body, extent, height_range_m)?;
        if middle.touches_pole() {
            let pole = FRAC_PI_2.copysign(middle.anchor_latitude_rad());
            let longitude = middle.anchor_longitude_rad();
            middle = Self::with_anchor(body, longitude, pole, extent, height_range_m)?;
        }
        let is_unseen =
            |longest_m: f64| longest_m * f64::from(f32::EPSILON) / 2.0 <= ROUNDED_PX * pixel_m;
        let longest_m = if middle.touches_pole() {
            // What is nearest to the eye lies below it, wherever the extent ends.
            eye_ecef.x.hypot(eye_ecef.y)
        } else {
            let [width, height] = extent.size_rad();
            0.5 * width.hypot(height) * body.equatorial_radius_m()
        };
        if is_unseen(longest_m) {
            return Ok(middle);
        }
        let eye = body.ecef_to_geodetic(eye_ecef);
        let longitude = unwrapped(eye.longitude_rad, middle.anchor_longitude_rad());
        Self::with_anchor(
            body,
            longitude.clamp(extent.west_rad, extent.east_rad),
            eye.latitude_rad.clamp(extent.south_rad, extent.north_rad),
            extent,
            height_range_m,
        )
    }
}

/// Rounding of an offset that is left to an anchor away from the eye, pixels. Some four such roundings
/// meet in a position, and from 20 m, where a pixel is 2 cm, they are to stay below a tenth of a
/// millimetre.
const ROUNDED_PX: f64 = 1.0 / 512.0;

/// The angle closest to `near` that is `angle` but for whole turns, radians.
fn unwrapped(angle: f64, near: f64) -> f64 {
    angle - ((angle - near) / TAU).round() * TAU
}

/// What of an extent may be seen from `eye`: no point of the surface is farther from the point below the
/// eye than the horizon is, and the horizon of the highest terrain beyond. Measured where the body is a
/// sphere of radius 1, its axes divided by its radii; latitudes there are the reduced ones. The whole
/// extent where that says nothing.
///
/// - `heights`: of the surface as drawn, metres
fn visible_part(
    body: &Ellipsoid,
    eye_ecef: DVec3,
    heights: (f64, f64),
    extent: MapExtent,
) -> MapExtent {
    let (low, high) = heights;
    let [a, b] = [body.equatorial_radius_m(), body.polar_radius_m()].map(|radius| radius + low);
    let eye = eye_ecef / DVec3::new(a, a, b);
    // Under the ground there is no horizon.
    if eye.length() <= 1.0 {
        return extent;
    }
    let to_the_horizon = |radius: f64| radius.max(1.0).recip().acos();
    let radius = to_the_horizon(eye.length()) + to_the_horizon(1.0 + (high - low) / a.min(b));
    // Points above the ellipsoid have another reduced latitude than those below them on it.
    let radius = radius * 1.01 + body.eccentricity_squared() * (high.abs().max(low.abs()) / b);
    let middle = eye.z.atan2(eye.x.hypot(eye.y));
    let [south, north] = [middle - radius, middle + radius];
    let geodetic = |reduced: f64| (a / b * reduced.tan()).atan();
    let mut part = extent;
    if north < FRAC_PI_2 {
        part.north_rad = part.north_rad.min(geodetic(north));
    }
    if south > -FRAC_PI_2 {
        part.south_rad = part.south_rad.max(geodetic(south));
    }
    if north < FRAC_PI_2 && south > -FRAC_PI_2 && extent.east_rad - extent.west_rad < PI {
        let reach = (radius.sin() / middle.cos()).min(1.0).asin();
        let below = eye.y.atan2(eye.x);
        let below = unwrapped(below, 0.5 * (extent.west_rad + extent.east_rad));
        part.west_rad = part.west_rad.max(below - reach);
        part.east_rad = part.east_rad.min(below + reach);
    }
    let [width, height] = part.size_rad();
    if width > 0.0 && height > 0.0 {
        part
    } else {
        extent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVERYWHERE: MapExtent = MapExtent {
        west_rad: -1.5,
        south_rad: -FRAC_PI_2,
        east_rad: 1.5,
        north_rad: FRAC_PI_2,
    };

    /// Whether the ellipsoid `low` metres above the body's hides `point` from `eye`.
    fn is_hidden(body: &Ellipsoid, low: f64, eye: DVec3, point: DVec3) -> bool {
        let [a, b] = [body.equatorial_radius_m(), body.polar_radius_m()].map(|r| r + low);
        let [from, to] = [eye, point].map(|p| p / DVec3::new(a, a, b));
        let way = to - from;
        let nearest = (-from.dot(way) / way.length_squared()).clamp(0.0, 1.0);
        (from + way * nearest).length() < 1.0 - 1e-12
    }

    fn holds(part: &MapExtent, longitude: f64, latitude: f64) -> bool {
        (part.west_rad..=part.east_rad).contains(&longitude)
            && (part.south_rad..=part.north_rad).contains(&latitude)
    }

    #[test]
    fn what_the_eye_sees_lies_in_the_visible_part() {
        let saturn_like = Ellipsoid::new("saturn-like", 6e7, 5.4e7).expect("a body");
        let (mut seen, mut beyond_half) = (0, 0);
        for body in [Ellipsoid::WGS84, saturn_like] {
            for (eye_latitude, height_m) in [
                (0.0, 2.0),
                (0.8, 50.0),
                (-0.8, 3e4),
                (1.2, 1e6),
                (1.5, 500.0),
                (0.3, 2e7),
            ] {
                for heights in [(0.0, 0.0), (-400.0, 9_000.0)] {
                    let eye_at = terrafill_core::Geodetic {
                        longitude_rad: 0.2,
                        latitude_rad: eye_latitude,
                        height_m: heights.1 + height_m,
                    };
                    let eye = body.geodetic_to_ecef(eye_at);
                    let part = visible_part(&body, eye, heights, EVERYWHERE);
                    // Negative control: half as far to every side.
                    let half = |edge: f64, middle: f64| 0.5 * (edge + middle);
                    let less = MapExtent {
                        west_rad: half(part.west_rad, 0.2),
                        east_rad: half(part.east_rad, 0.2),
                        south_rad: half(part.south_rad, eye_latitude),
                        north_rad: half(part.north_rad, eye_latitude),
                    };
                    let reach = 2.0 * (heights.1 + height_m - heights.0) / body.polar_radius_m();
                    let reach = reach.sqrt().min(1.2);
                    for i in 0..=60 {
                        for j in 0..=60 {
                            let step = |k: i32| 2.0 * reach * f64::from(k - 30) / 30.0;
                            let longitude = 0.2 + step(i) / f64::cos(eye_latitude);
                            let latitude = eye_latitude + step(j);
                            if !(-1.5..=1.5).contains(&longitude) || latitude.abs() > FRAC_PI_2 {
                                continue;
                            }
                            let point = body.geodetic_to_ecef(terrafill_core::Geodetic {
                                longitude_rad: longitude,
                                latitude_rad: latitude,
                                height_m: heights.1,
                            });
                            if is_hidden(&body, heights.0, eye, point) {
                                continue;
                            }
                            seen += 1;
                            assert!(holds(&part, longitude, latitude), "{part:?} {latitude}");
                            beyond_half += usize::from(!holds(&less, longitude, latitude));
                        }
                    }
                }
            }
        }
        assert!(seen > 5_000, "{seen} points seen");
        assert!(beyond_half > 500, "{beyond_half} of {seen}");
    }

    #[test]
    fn close_to_the_ground_little_of_a_country_is_visible() {
        let body = Ellipsoid::WGS84;
        let eye = |height_m| {
            body.geodetic_to_ecef(terrafill_core::Geodetic {
                longitude_rad: 0.1,
                latitude_rad: 0.7,
                height_m,
            })
        };
        let part = visible_part(&body, eye(20.0), (0.0, 0.0), EVERYWHERE);
        // The horizon is 16 km away.
        for size in part.size_rad() {
            assert!((0.005..0.008).contains(&size), "{part:?}");
        }
        let middle = 0.5 * (part.south_rad + part.north_rad);
        assert!((middle - 0.7).abs() < 1e-3, "{middle}");
        // Under the ground nothing is known, and elsewhere nothing is in sight.
        let all = visible_part(&body, eye(-20.0), (0.0, 0.0), EVERYWHERE);
        assert_eq!(all, EVERYWHERE);
        let far = MapExtent {
            west_rad: 1.0,
            south_rad: -1.0,
            east_rad: 1.1,
            north_rad: -0.9,
        };
        assert_eq!(visible_part(&body, eye(20.0), (0.0, 0.0), far), far);
    }

    const WHOLE: MapExtent = MapExtent {
        west_rad: -PI,
        south_rad: -FRAC_PI_2,
        east_rad: PI,
        north_rad: FRAC_PI_2,
    };

    fn eye(latitude_rad: f64, height_m: f64) -> DVec3 {
        Ellipsoid::WGS84.geodetic_to_ecef(terrafill_core::Geodetic {
            longitude_rad: 0.2,
            latitude_rad,
            height_m,
        })
    }

    /// Degrees from the point below the eye to the anchor.
    fn away_deg(latitude_rad: f64, height_m: f64, extent: MapExtent) -> f64 {
        // A pixel of 60° over 1080 rows.
        let pixel_m = height_m * 1.07e-3;
        let eye_ecef = eye(latitude_rad, height_m);
        let seen = MapRegion::seen_from(Ellipsoid::WGS84, extent, (0.0, 0.0), eye_ecef, pixel_m);
        let anchor = seen.expect("bounds").anchor_ecef();
        let below = eye(latitude_rad, 0.0);
        (anchor.distance(below) / 6.37e6).to_degrees()
    }

    #[test]
    fn an_anchor_comes_below_the_eye_where_its_distance_would_be_seen() {
        let square = MapExtent::from_degrees(0.0, 30.0, 20.0, 50.0);
        for height_m in [2.0, 20.0, 200.0, 2_000.0] {
            let away = away_deg(0.7, height_m, square);
            assert!(away < 1e-6, "{height_m} m: {away}°");
        }
        let close_to_a_pole = FRAC_PI_2 - 2e-4;
        for height_m in [2.0, 20.0] {
            let away = away_deg(close_to_a_pole, height_m, WHOLE);
            assert!(away < 1e-6, "1.3 km from the pole, {height_m} m: {away}°");
        }
        // From where a pixel is larger than what the middle's distance loses, it stays there, and over a
        // pole at the pole.
        assert!(away_deg(0.62, 3e6, square) > 1.0);
        assert!((away_deg(close_to_a_pole, 2e5, WHOLE) - 2e-4_f64.to_degrees()).abs() < 1e-3);
    }

    #[test]
    fn close_to_a_pole_a_route_still_holds_with_the_anchor_below_the_eye() {
        let chooser = crate::Chooser::of_plan();
        let mut below = 0_u32;
        for from_pole_rad in [1e-6, 1e-5, 1e-4, 5e-4, 2e-3] {
            for height_m in [5.0, 13.0, 100.0, 2e3] {
                let latitude_rad = FRAC_PI_2 - from_pole_rad;
                let pixel_m = height_m * 1.07e-3;
                let eye_ecef = eye(latitude_rad, height_m);
                let body = Ellipsoid::WGS84;
                let cap = MapExtent::from_degrees(-180.0, 85.0, 180.0, 90.0);
                let region = MapRegion::seen_from(body, cap, (0.0, 0.0), eye_ecef, pixel_m);
                let region = region.expect("bounds");
                below += u32::from(
                    region.touches_pole() && region.anchor_latitude_rad() < FRAC_PI_2 - 1e-9,
                );
                let texels = |axis: usize| {
                    let share = region.extent().size_rad()[axis] / cap.size_rad()[axis];
                    (1..=4096).rev().find(|n| f64::from(*n) <= 4096.0 * share)
                };
                let choice = chooser.choose(&crate::Demand {
                    region,
                    texture_size: [0, 1].map(|axis| texels(axis).unwrap_or(1)),
                    pixel_m,
                });
                assert!(
                    choice.chosen.is_some(),
                    "{from_pole_rad} {height_m}: {:?}",
                    choice.left_out
                );
            }
        }
        assert!(
            below >= 5,
            "{below} regions with the pole in sight and the anchor below the eye"
        );
    }
}
