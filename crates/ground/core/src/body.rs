// SPDX-License-Identifier: MIT OR Apache-2.0
//! Oblate ellipsoids, and geodetic ↔ earth-centred earth-fixed (ECEF) coordinates on them.
//!
//! Angles in radians, lengths in metres, `f64`; longitude in `[-π, π]`, latitude geodetic.
//! The forward map is closed-form. The inverse iterates Bowring's step until the parametric
//! latitude stands still: one step is enough for the Earth, but not for a body as flat as Saturn.
//! Sources: NIMA TR8350.2 (WGS 84 constants), Bowring (1976, 1985), IAU WGCCRE (2015) for the others.

use glam::DVec3;

/// A point on or near a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodetic {
    /// East positive, radians.
    pub longitude_rad: f64,
    /// Angle between the equator's plane and the surface normal, radians.
    pub latitude_rad: f64,
    /// Along the surface normal, metres.
    pub height_m: f64,
}

impl Geodetic {
    /// From degrees and metres, as files and people write positions.
    #[must_use]
    pub fn from_degrees(longitude_deg: f64, latitude_deg: f64, height_m: f64) -> Self {
        Self {
            longitude_rad: longitude_deg.to_radians(),
            latitude_rad: latitude_deg.to_radians(),
            height_m,
        }
    }
}

/// An ellipsoid of revolution about the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    name: &'static str,
    equatorial_radius_m: f64,
    polar_radius_m: f64,
}

impl Ellipsoid {
    /// World Geodetic System 1984.
    pub const WGS84: Self = Self {
        name: "wgs84",
        equatorial_radius_m: 6_378_137.0,
        polar_radius_m: 6_356_752.314_245_179,
    };
    /// The Moon as a sphere of its mean radius.
    pub const MOON: Self = Self {
        name: "moon",
        equatorial_radius_m: 1_737_400.0,
        polar_radius_m: 1_737_400.0,
    };
    /// Mars.
    pub const MARS: Self = Self {
        name: "mars",
        equatorial_radius_m: 3_396_190.0,
        polar_radius_m: 3_376_200.0,
    };
    /// Saturn's 1 bar level: the flattest large body, 0.098, where approximations for small
    /// flattening fail.
    pub const SATURN_LIKE: Self = Self {
        name: "saturn-like",
        equatorial_radius_m: 60_268_000.0,
        polar_radius_m: 54_364_000.0,
    };
    /// A sphere of radius 1 m: any constant in metres that hides in the code shows up here.
    pub const UNIT_SPHERE: Self = Self {
        name: "unit-sphere",
        equatorial_radius_m: 1.0,
        polar_radius_m: 1.0,
    };
    /// A 250 m asteroid, slightly flattened.
    pub const ASTEROID_250M: Self = Self {
        name: "asteroid-250m",
        equatorial_radius_m: 250.0,
        polar_radius_m: 230.0,
    };
    /// Every named body.
    pub const ALL: [Self; 6] = [
        Self::WGS84,
        Self::MOON,
        Self::MARS,
        Self::SATURN_LIKE,
        Self::UNIT_SPHERE,
        Self::ASTEROID_250M,
    ];

    /// The body called `name` in scene files and on the command line.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|body| body.name == name)
    }

    /// An ellipsoid with the given radii.
    ///
    /// Returns `None` unless `0 < polar_radius_m <= equatorial_radius_m` and both are finite:
    /// prolate bodies are outside what the formulas here promise.
    #[must_use]
    pub fn new(name: &'static str, equatorial_radius_m: f64, polar_radius_m: f64) -> Option<Self> {
        let valid = polar_radius_m > 0.0
            && polar_radius_m <= equatorial_radius_m
            && equatorial_radius_m.is_finite();
        valid.then_some(Self {
            name,
            equatorial_radius_m,
            polar_radius_m,
        })
    }

    /// Name in scene files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Semi-major axis a, metres.
    #[must_use]
    pub fn equatorial_radius_m(&self) -> f64 {
        self.equatorial_radius_m
    }

    /// Semi-minor axis b, metres.
    #[must_use]
    pub fn polar_radius_m(&self) -> f64 {
        self.polar_radius_m
    }

    /// The three radii, metres.
    #[must_use]
    pub fn radii_m(&self) -> DVec3 {
        DVec3::new(
            self.equatorial_radius_m,
            self.equatorial_radius_m,
            self.polar_radius_m,
        )
    }

    /// Radii of an ellipsoid certainly below a surface that is nowhere lower than `lowest_m`, metres; not
    /// positive where nothing is left of it. Shrinking all axes by δ moves the ellipsoid inwards by at
    /// least δ·b/a everywhere.
    #[must_use]
    pub fn radii_below_m(&self, lowest_m: f64) -> DVec3 {
        let flattening = self.equatorial_radius_m / self.polar_radius_m;
        self.radii_m() - DVec3::splat((-lowest_m).max(0.0) * flattening)
    }

    /// First eccentricity squared, `e² = 1 − b²/a²`.
    #[must_use]
    pub fn eccentricity_squared(&self) -> f64 {
        let ratio = self.polar_radius_m / self.equatorial_radius_m;
        1.0 - ratio * ratio
    }

    /// Smallest radius of curvature anywhere on the body, metres: the meridian's at the equator,
    /// `b²/a`. Chords sag most where the curvature radius is smallest, so bounds use this one.
    #[must_use]
    pub fn smallest_curvature_radius_m(&self) -> f64 {
        self.polar_radius_m * self.polar_radius_m / self.equatorial_radius_m
    }

    /// Largest radius of curvature anywhere on the body, metres: that of every direction at a pole, `a²/b`.
    #[must_use]
    pub fn largest_curvature_radius_m(&self) -> f64 {
        self.equatorial_radius_m * self.equatorial_radius_m / self.polar_radius_m
    }

    /// Radii of curvature of the surface at a latitude, metres: across the meridian, which is the distance along
    /// the normal to the polar axis, and along it.
    #[must_use]
    pub fn curvature_radii_m(&self, latitude_rad: f64) -> [f64; 2] {
        let (sin, e2) = (latitude_rad.sin(), self.eccentricity_squared());
        let w2 = 1.0 - e2 * sin * sin;
        let prime_vertical_m = self.equatorial_radius_m / w2.sqrt();
        [prime_vertical_m, prime_vertical_m * (1.0 - e2) / w2]
    }

    /// Unit outward normal of the surface, ECEF.
    #[must_use]
    pub fn geodetic_surface_normal(&self, longitude_rad: f64, latitude_rad: f64) -> DVec3 {
        let (sin_lon, cos_lon) = longitude_rad.sin_cos();
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
    }

    /// Geodetic → ECEF, metres; closed form.
    #[must_use]
    pub fn geodetic_to_ecef(&self, position: Geodetic) -> DVec3 {
        let normal = self.geodetic_surface_normal(position.longitude_rad, position.latitude_rad);
        self.surface_point(normal) + normal * position.height_m
    }

    /// The place on the surface whose unit outward normal this is, ECEF, metres.
    #[must_use]
    pub fn surface_point(&self, normal: DVec3) -> DVec3 {
        let scaled = self.radii_m() * self.radii_m() * normal;
        scaled / normal.dot(scaled).sqrt()
    }

    /// Unit outward normal of the surface below a place, and the height above it along that, metres.
    ///
    /// [`Ellipsoid::ecef_to_geodetic`] without its angles: sines and cosines of Bowring's step are shares of a length, so
    /// that no trigonometric function is called for each pixel of a picture.
    #[must_use]
    pub fn normal_and_height(&self, ecef: DVec3) -> (DVec3, f64) {
        let (a, b) = (self.equatorial_radius_m, self.polar_radius_m);
        let e2 = self.eccentricity_squared();
        let second_e2 = e2 / (1.0 - e2);
        let rho = (ecef.x * ecef.x + ecef.y * ecef.y).sqrt();
        if rho == 0.0 {
            let sign = if ecef.z < 0.0 { -1.0 } else { 1.0 };
            return (DVec3::new(0.0, 0.0, sign), ecef.z.abs() - b);
        }
        let unit = |sine: f64, cosine: f64| {
            let length = (sine * sine + cosine * cosine).sqrt();
            [sine / length, cosine / length]
        };
        let mut beta = unit(ecef.z * a, rho * b);
        let mut latitude = beta;
        for _ in 0..12 {
            let [sine, cosine] = beta;
            latitude = unit(
                ecef.z + second_e2 * b * sine * sine * sine,
                rho - e2 * a * cosine * cosine * cosine,
            );
            let next = unit(b * latitude[0], a * latitude[1]);
            // Sine of the angle between both.
            let moved = (next[0] * cosine - next[1] * sine).abs();
            beta = next;
            if moved < 1e-15 {
                break;
            }
        }
        let [sine, cosine] = latitude;
        let normal = DVec3::new(ecef.x / rho * cosine, ecef.y / rho * cosine, sine);
        let height_m = rho * cosine + ecef.z * sine - a * (1.0 - e2 * sine * sine).sqrt();
        (normal, height_m)
    }

    /// ECEF → geodetic.
    ///
    /// Bowring's step `tan φ = (z + e'² b sin³β) / (ρ − e² a cos³β)` repeated until β moves less
    /// than 1e-15 rad or 12 times. On the axis the longitude is 0; at the very centre of the body,
    /// where no latitude exists, the result is the north pole at height −b.
    #[must_use]
    pub fn ecef_to_geodetic(&self, ecef: DVec3) -> Geodetic {
        let a = self.equatorial_radius_m;
        let b = self.polar_radius_m;
        let e2 = self.eccentricity_squared();
        let second_e2 = e2 / (1.0 - e2);
        let rho = ecef.x.hypot(ecef.y);
        let longitude_rad = if rho > 0.0 { ecef.y.atan2(ecef.x) } else { 0.0 };
        if rho == 0.0 {
            let sign = if ecef.z < 0.0 { -1.0 } else { 1.0 };
            return Geodetic {
                longitude_rad,
                latitude_rad: sign * std::f64::consts::FRAC_PI_2,
                height_m: ecef.z.abs() - b,
            };
        }
        let mut beta = (ecef.z * a).atan2(rho * b);
        let mut latitude_rad = beta;
        for _ in 0..12 {
            let (sin_beta, cos_beta) = beta.sin_cos();
            latitude_rad =
                (ecef.z + second_e2 * b * sin_beta.powi(3)).atan2(rho - e2 * a * cos_beta.powi(3));
            let (sin_lat, cos_lat) = latitude_rad.sin_cos();
            let next = (b * sin_lat).atan2(a * cos_lat);
            let moved = (next - beta).abs();
            beta = next;
            if moved < 1e-15 {
                break;
            }
        }
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        // ρ cos φ + z sin φ − a √(1 − e² sin² φ) is well conditioned at every latitude, unlike
        // ρ / cos φ − N, which loses the pole.
        let height_m = rho * cos_lat + ecef.z * sin_lat - a * (1.0 - e2 * sin_lat * sin_lat).sqrt();
        Geodetic {
            longitude_rad,
            latitude_rad,
            height_m,
        }
    }

    /// Surface area between two latitudes and two longitudes, square metres (closed form).
    ///
    /// - source: Snyder (1987), USGS PP 1395, eq. 3-12 (authalic `q`)
    #[must_use]
    pub fn quadrangle_area_m2(&self, width_rad: f64, south_rad: f64, north_rad: f64) -> f64 {
        width_rad * (self.zone_area_per_radian(north_rad) - self.zone_area_per_radian(south_rad))
    }

    /// Area between the equator and `latitude_rad` per radian of longitude, square metres; odd in
    /// the latitude. `b²/2 · (sin φ / (1 − e² sin² φ) + artanh(e sin φ) / e)`.
    #[must_use]
    pub fn zone_area_per_radian(&self, latitude_rad: f64) -> f64 {
        let s = latitude_rad.sin();
        let e2 = self.eccentricity_squared();
        let e = e2.sqrt();
        let artanh_over_e = if e < 1e-9 { s } else { (e * s).atanh() / e };
        0.5 * self.polar_radius_m * self.polar_radius_m * (s / (1.0 - e2 * s * s) + artanh_over_e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn forward_then_inverse_returns_the_position_on_every_body() {
        for body in Ellipsoid::ALL {
            let a = body.equatorial_radius_m();
            for lat in [-90.0, -89.9999, -45.0, -1e-9, 0.0, 30.0, 45.0, 85.0, 90.0] {
                for lon in [-180.0, -90.0, 0.0, 1e-7, 135.0, 179.999] {
                    for height in [-0.002, 0.0, 0.0015, 5.0] {
                        let start = Geodetic::from_degrees(lon, lat, height * a);
                        let ecef = body.geodetic_to_ecef(start);
                        let back = body.geodetic_to_ecef(body.ecef_to_geodetic(ecef));
                        let error = (back - ecef).length();
                        assert!(
                            error < 4e-15 * a * (1.0 + height.abs()),
                            "{} {lon} {lat} {height}: {error}",
                            body.name()
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_normal_is_that_of_the_angles_and_a_foot_lies_below_its_place() {
        for body in Ellipsoid::ALL {
            let a = body.equatorial_radius_m();
            for lat in [-90.0, -89.9999, -45.0, -1e-9, 0.0, 30.0, 45.0, 85.0, 90.0] {
                for lon in [-180.0, -90.0, 0.0, 1e-7, 135.0, 179.999] {
                    for height in [-0.002, 0.0, 0.0015, 5.0] {
                        let start = Geodetic::from_degrees(lon, lat, height * a);
                        let ecef = body.geodetic_to_ecef(start);
                        let place = body.ecef_to_geodetic(ecef);
                        let (normal, height_m) = body.normal_and_height(ecef);
                        let angles = (place.longitude_rad, place.latitude_rad);
                        let expected = body.geodetic_surface_normal(angles.0, angles.1);
                        let off = (normal - expected).length();
                        assert!(off < 4e-15, "{} {lon} {lat} {height}: {off}", body.name());
                        let off_m = (height_m - place.height_m).abs();
                        assert!(off_m < 4e-15 * a * (1.0 + height.abs()), "{off_m}");
                        let back = body.surface_point(normal) + normal * height_m;
                        assert!((back - ecef).length() < 4e-15 * a * (1.0 + height.abs()));
                        // Negative control: towards the centre is another direction, but on a sphere, at the equator and
                        // at a pole.
                        let is_oblate = body.eccentricity_squared() > 0.0;
                        let central = (normal - ecef.normalize()).length();
                        assert_eq!(
                            central > 1e-5,
                            is_oblate && [-45.0, 30.0, 45.0, 85.0].contains(&lat)
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn known_points_of_wgs84() {
        let body = Ellipsoid::WGS84;
        let equator = body.geodetic_to_ecef(Geodetic::from_degrees(90.0, 0.0, 0.0));
        assert!((equator - DVec3::new(0.0, 6_378_137.0, 0.0)).length() < 1e-8);
        let pole = body.geodetic_to_ecef(Geodetic::from_degrees(0.0, -90.0, 1.0));
        assert!((pole.z + 6_356_753.314_245_179).abs() < 1e-8);
        // Prime-vertical radius at 45° from the series in NIMA TR8350.2: N = 6388838.2901 m.
        let at_45 = body.geodetic_to_ecef(Geodetic::from_degrees(0.0, 45.0, 0.0));
        assert!((at_45.x - 6_388_838.290_1 * 0.5_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn whole_body_area_matches_the_closed_form() {
        let sphere = Ellipsoid::UNIT_SPHERE.quadrangle_area_m2(2.0 * PI, -FRAC_PI_2, FRAC_PI_2);
        assert!((sphere - 4.0 * PI).abs() < 1e-14);
        // WGS 84 total area, NIMA TR8350.2 authalic radius 6371007.1809 m.
        let earth = Ellipsoid::WGS84.quadrangle_area_m2(2.0 * PI, -FRAC_PI_2, FRAC_PI_2);
        let authalic = 4.0 * PI * 6_371_007.180_9_f64.powi(2);
        assert!((earth / authalic - 1.0).abs() < 1e-10);
    }

    #[test]
    fn dropping_the_eccentricity_is_noticed() {
        // Negative control of the round trip: the same test on a wrong body must fail.
        let sphere = Ellipsoid::new("mutant", 6_378_137.0, 6_378_137.0);
        let ecef = Ellipsoid::WGS84.geodetic_to_ecef(Geodetic::from_degrees(0.0, 45.0, 0.0));
        let wrong = sphere.map(|body| body.ecef_to_geodetic(ecef).latitude_rad);
        assert!(wrong.is_some_and(|latitude| (latitude.to_degrees() - 45.0).abs() > 0.1));
    }
}
