// SPDX-License-Identifier: MIT OR Apache-2.0
//! Polar caps, where a Mercator map has nothing: a stereographic picture about each pole.
//!
//! Both coordinates run from 0 to 1 over the square around the circle of [`max_latitude_rad`]. Its middle is the
//! pole, so no coordinate jumps and none is undefined there.

use crate::tile::END_SINE;
use glam::DVec3;

/// Half of a cap's side on the plane that touches the unit sphere's middle: `tan((90° − 85.05°) / 2)`.
pub const CAP_SPAN: f64 = 0.043_213_918_263_772_18;

/// Coordinates in the cap of the nearer pole; `None` where the map reaches.
///
/// - `normal`: geodetic, of length 1: a place of the sphere that a stereographic picture is of
#[must_use]
pub fn cap_point(normal: DVec3) -> Option<[f64; 2]> {
    if normal.z.abs() <= END_SINE {
        return None;
    }
    // tan(45° − φ/2) = cos φ / (1 + sin φ), where nothing cancels.
    let span = (1.0 + normal.z.abs()) * CAP_SPAN;
    Some([normal.x, normal.y].map(|along| 0.5 + 0.5 * along / span))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::max_latitude_rad;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    use terrafill_core::Ellipsoid;

    #[test]
    fn a_cap_begins_where_the_map_ends_and_holds_the_pole_in_its_middle() {
        let body = Ellipsoid::WGS84;
        let at = |longitude_rad: f64, latitude_rad: f64| {
            cap_point(body.geodetic_surface_normal(longitude_rad, latitude_rad))
        };
        let edge = max_latitude_rad();
        assert!((CAP_SPAN - (FRAC_PI_4 - 0.5 * edge).tan()).abs() < 1e-15);
        for sign in [1.0, -1.0] {
            assert_eq!(at(1.0, sign * (edge - 1e-9)), None);
            let [x, y] = at(0.0, sign * (edge + 1e-9)).expect("a cap");
            assert!((x - 1.0).abs() < 1e-6 && (y - 0.5).abs() < 1e-9, "{x} {y}");
            let [x, y] = at(0.3, sign * FRAC_PI_2).expect("a cap");
            assert!((x - 0.5).abs() < 1e-9 && (y - 0.5).abs() < 1e-9);
            // Nothing jumps at ±180°. Negative control: a quarter of a turn apart does not meet.
            let near = |a: f64, b: f64| {
                let [p, q] = [a, b].map(|at_| at(at_, sign * 1.53).expect("a cap"));
                (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-8
            };
            assert!(near(PI - 1e-9, 1e-9 - PI) && !near(0.0, FRAC_PI_2));
        }
    }
}
