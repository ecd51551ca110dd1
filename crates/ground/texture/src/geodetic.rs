// SPDX-License-Identifier: MIT OR Apache-2.0
//! The exact map: ECEF → geodetic longitude, latitude and height, in `f64`.
//!
//! The judge of every coordinate route, so it shares no code with the routes, nor with
//! `Ellipsoid::ecef_to_geodetic`, which iterates Bowring's step. Here Halley's method finds the
//! tangent of the parametric latitude as a fraction S / C, which needs no angle before the last
//! line and holds on the axis as well as at the equator: Fukushima (2006), "Transformation from
//! Cartesian to geodetic coordinates accelerated by Halley's method", eq. 9–17, repeated until the
//! direction stands still instead of once.

use glam::DVec3;
use terrafill_core::{Ellipsoid, Geodetic};

/// Rounds after which the direction (S, C) has always stood still: three on Earth, five at the
/// flattening of Saturn close to the evolute.
const ROUNDS: usize = 12;

/// Exact inverse map of one body.
#[derive(Debug, Clone, Copy)]
pub struct ExactGeodetic {
    equatorial_radius_m: f64,
    eccentricity_squared: f64,
    /// `√(1 − e²)`, which is b / a.
    axis_ratio: f64,
}

impl ExactGeodetic {
    /// For `body`.
    #[must_use]
    pub fn new(body: &Ellipsoid) -> Self {
        Self {
            equatorial_radius_m: body.equatorial_radius_m(),
            eccentricity_squared: body.eccentricity_squared(),
            axis_ratio: body.polar_radius_m() / body.equatorial_radius_m(),
        }
    }

    /// Longitude in `[-π, π]`, geodetic latitude and height of an ECEF position in metres.
    ///
    /// Holds outside the body's evolute, that is for every height above `−(1 − e²) b` or so. On the
    /// axis the longitude is 0.
    #[must_use]
    pub fn from_ecef(&self, ecef: DVec3) -> Geodetic {
        let rho = ecef.x.hypot(ecef.y);
        let longitude_rad = if rho > 0.0 { ecef.y.atan2(ecef.x) } else { 0.0 };
        let (latitude_rad, height_m) = self.from_meridian(rho, ecef.z);
        Geodetic {
            longitude_rad,
            latitude_rad,
            height_m,
        }
    }

    /// Geodetic latitude and height of a point of a meridian's half-plane.
    ///
    /// - `rho`: distance from the axis, metres, not negative
    /// - `z`: along the axis to the north, metres
    #[must_use]
    pub fn from_meridian(&self, rho: f64, z: f64) -> (f64, f64) {
        let e2 = self.eccentricity_squared;
        let p = rho / self.equatorial_radius_m;
        let north = self.axis_ratio * z.abs() / self.equatorial_radius_m;
        // f(T) = P T − Z − e² T / √(1 + T²) with T = S / C the tangent of the parametric latitude.
        let (mut s, mut c) = normalized(north, self.axis_ratio * p);
        for _ in 0..ROUNDS {
            let d = north + e2 * s * s * s;
            let f = p - e2 * c * c * c;
            let b = 1.5 * e2 * s * c * c * (p * s - north * c - e2 * s * c);
            let (next_s, next_c) = normalized(d * f - b * s, f * f - b * c);
            let moved = (next_s * c - next_c * s).abs();
            (s, c) = (next_s, next_c);
            if moved < 1e-17 {
                break;
            }
        }
        let (sin_lat, cos_lat) = normalized(s, self.axis_ratio * c);
        let latitude_rad = sin_lat.atan2(cos_lat);
        let foot_scale = (1.0 - e2 * sin_lat * sin_lat).sqrt();
        let height_m = rho * cos_lat + z.abs() * sin_lat - self.equatorial_radius_m * foot_scale;
        (latitude_rad.copysign(z), height_m)
    }
}

/// The direction of (s, c); (0, 0) becomes the axis, as everywhere in this project.
fn normalized(s: f64, c: f64) -> (f64, f64) {
    let length = s.hypot(c);
    if length > 0.0 {
        (s / length, c / length)
    } else {
        (1.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Heights that matter: the ocean floor, the highest mountain exaggerated, low and far orbits.
    const HEIGHTS_M: [f64; 8] = [-11e3, -1.0, 0.0, 1.0, 9e3, 9e4, 4e5, 3e7];

    fn latitudes() -> impl Iterator<Item = f64> {
        let close_to_poles = [1e-9, 1e-6, 1e-3, 0.1];
        let even = (-90..=90).map(f64::from);
        even.chain(close_to_poles.map(|d| 90.0 - d))
            .chain(close_to_poles.map(|d| d - 90.0))
            .chain(close_to_poles)
            .map(f64::to_radians)
    }

    /// Largest round-trip errors `(latitude rad, longitude rad, height m)` of `inverse`.
    fn worst_round_trip(
        body: &Ellipsoid,
        scale: f64,
        inverse: impl Fn(DVec3) -> Geodetic,
    ) -> (f64, f64, f64) {
        let mut worst = (0.0_f64, 0.0_f64, 0.0_f64);
        for latitude_rad in latitudes() {
            for longitude_rad in [-PI, -2.5, -1e-9, 0.0, 1e-9, 1.0, 3.1] {
                for height_m in HEIGHTS_M.map(|h| h * scale) {
                    let start = Geodetic {
                        longitude_rad,
                        latitude_rad,
                        height_m,
                    };
                    let back = inverse(body.geodetic_to_ecef(start));
                    let lon = (back.longitude_rad - longitude_rad).abs();
                    let lon = lon.min(2.0 * PI - lon) * latitude_rad.cos();
                    worst.0 = worst.0.max((back.latitude_rad - latitude_rad).abs());
                    worst.1 = worst.1.max(lon);
                    worst.2 = worst.2.max((back.height_m - height_m).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn round_trips_hold_on_every_body() {
        for body in Ellipsoid::ALL {
            // Heights in proportion, so that the asteroid is not left inside out.
            let scale = body.equatorial_radius_m() / 6_378_137.0;
            let exact = ExactGeodetic::new(&body);
            let (lat, lon, height) = worst_round_trip(&body, scale, |p| exact.from_ecef(p));
            assert!(lat < 1e-14, "{}: latitude {lat}", body.name());
            assert!(lon < 1e-14, "{}: longitude {lon}", body.name());
            let allowed = 4e-14 * body.equatorial_radius_m();
            assert!(height < allowed, "{}: height {height}", body.name());
        }
    }

    /// Foot of the normal by bisection over the parametric latitude: slow, plain and independent.
    ///
    /// The foot β makes `a ρ sin β − b z cos β − (a² − b²) sin β cos β` vanish; outside the evolute
    /// it changes sign once on `[0, π/2]`.
    fn by_bisection(body: &Ellipsoid, rho: f64, z: f64) -> f64 {
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let g = |beta: f64| {
            let (sin, cos) = beta.sin_cos();
            a * rho * sin - b * z.abs() * cos - (a * a - b * b) * sin * cos
        };
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if g(middle) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        let (sin, cos) = low.sin_cos();
        (a * sin).atan2(b * cos).copysign(z)
    }

    #[test]
    fn two_other_methods_agree() {
        for body in Ellipsoid::ALL {
            let exact = ExactGeodetic::new(&body);
            let scale = body.equatorial_radius_m() / 6_378_137.0;
            for latitude_rad in latitudes() {
                for height_m in HEIGHTS_M.map(|h| h * scale) {
                    let position = body.geodetic_to_ecef(Geodetic {
                        longitude_rad: 0.0,
                        latitude_rad,
                        height_m,
                    });
                    let rho = position.x.max(0.0);
                    let (found, _) = exact.from_meridian(rho, position.z);
                    let bisected = by_bisection(&body, rho, position.z);
                    assert!(
                        (found - bisected).abs() < 1e-13,
                        "{} {latitude_rad} {height_m}: {found} {bisected}",
                        body.name()
                    );
                    let bowring = body.ecef_to_geodetic(position).latitude_rad;
                    assert!((found - bowring).abs() < 1e-13, "{}", body.name());
                }
            }
        }
    }

    #[test]
    fn the_centre_and_the_axis_have_an_answer() {
        let exact = ExactGeodetic::new(&Ellipsoid::WGS84);
        let b = Ellipsoid::WGS84.polar_radius_m();
        for (z, latitude, height) in [
            (b + 1.0, FRAC_PI_2, 1.0),
            (-b - 1.0, -FRAC_PI_2, 1.0),
            (0.0, FRAC_PI_2, -b),
        ] {
            let found = exact.from_ecef(DVec3::new(0.0, 0.0, z));
            assert!((found.latitude_rad - latitude).abs() < 1e-15, "{z}");
            assert!((found.height_m - height).abs() < 1e-8, "{z}");
            assert!(found.longitude_rad.abs() < 1e-15, "{z}");
        }
    }

    #[test]
    fn mutants_are_noticed() {
        let body = Ellipsoid::WGS84;
        let exact = ExactGeodetic::new(&body);
        // Longitude and latitude swapped.
        let swapped = |p: DVec3| {
            let g = exact.from_ecef(p);
            Geodetic {
                longitude_rad: g.latitude_rad,
                latitude_rad: g.longitude_rad,
                ..g
            }
        };
        assert!(worst_round_trip(&body, 1.0, swapped).0 > 1.0);
        // e² dropped: the sphere's answer, off by 11.5′.
        let sphere = ExactGeodetic {
            eccentricity_squared: 0.0,
            axis_ratio: 1.0,
            ..exact
        };
        let dropped = worst_round_trip(&body, 1.0, |p| sphere.from_ecef(p)).0;
        assert!((dropped.to_degrees() - 0.1924).abs() < 0.002, "{dropped}");
        // The axis ratio left out of the last line only: the parametric latitude.
        let parametric = |p: DVec3| {
            let g = exact.from_ecef(p);
            Geodetic {
                latitude_rad: (exact.axis_ratio * g.latitude_rad.tan()).atan(),
                ..g
            }
        };
        assert!(worst_round_trip(&body, 1.0, parametric).0 > 1e-3);
    }
}
