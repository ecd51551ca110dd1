// SPDX-License-Identifier: MIT OR Apache-2.0
//! Polar caps, where a Mercator map has nothing: a stereographic picture about each pole.
//!
//! Both coordinates run from 0 to 1 over the square around the circle of [`max_latitude_rad`]. Its middle is the
//! pole, so no coordinate jumps and none is undefined there.

use crate::max_latitude_rad;
use glam::DVec3;
use std::f64::consts::FRAC_PI_4;
use terrafill_core::Ellipsoid;

/// Half of a cap's side on the plane that touches the unit sphere's middle: `tan((90° − 85.05°) / 2)`.
pub const CAP_SPAN: f64 = 0.043_213_918_263_772_18;

/// Coordinates in the cap of the nearer pole; `None` where the map reaches.
///
/// The direction is the geodetic normal, which is the sphere that a stereographic picture is of.
#[must_use]
pub fn cap_point(body: &Ellipsoid, ecef: DVec3) -> Option<[f64; 2]> {
    let place = body.ecef_to_geodetic(ecef);
    if place.latitude_rad.abs() <= max_latitude_rad() {
        return None;
    }
    // tan(45° − φ/2) is exact near the pole, where 1 + sin φ and cos φ are not.
    let radius = (FRAC_PI_4 - 0.5 * place.latitude_rad.abs()).tan();
    let (sin, cos) = place.longitude_rad.sin_cos();
    Some([cos, sin].map(|along| 0.5 + 0.5 * radius * along / CAP_SPAN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};
    use terrafill_core::Geodetic;

    #[test]
    fn a_cap_begins_where_the_map_ends_and_holds_the_pole_in_its_middle() {
        let body = Ellipsoid::WGS84;
        let at = |longitude_rad: f64, latitude_rad: f64| {
            let place = Geodetic {
                longitude_rad,
                latitude_rad,
                height_m: 0.0,
            };
            cap_point(&body, body.geodetic_to_ecef(place))
        };
        let edge = max_latitude_rad();
        assert!((CAP_SPAN - (FRAC_PI_4 - 0.5 * edge).tan()).abs() < 1e-15);
        for sign in [1.0, -1.0] {
            assert_eq!(at(1.0, sign * (edge - 1e-9)), None);
            let [x, y] = at(0.0, sign * (edge + 1e-9)).expect("a cap");
            assert!((x - 1.0).abs() < 1e-6 && (y - 0.5).abs() < 1e-9, "{x} {y}");
            let [x, y] = at(0.3, sign * FRAC_PI_2).expect("a cap");
            assert!((x - 0.5).abs() < 1e-9 && (y - 0.5).abs() < 1e-9);
            // Nothing jumps at ±180°. Twin: a quarter of a turn apart does not meet.
            let near = |a: f64, b: f64| {
                let [p, q] = [a, b].map(|at_| at(at_, sign * 1.53).expect("a cap"));
                (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-8
            };
            assert!(near(PI - 1e-9, 1e-9 - PI) && !near(0.0, FRAC_PI_2));
        }
    }
}
