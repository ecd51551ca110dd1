// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geodesics on an oblate ellipsoid: where one ends (the direct problem), and how far it is the
//! shortest way.
//!
//! Bessel's auxiliary sphere, as in Karney (2013), "Algorithms for geodesics", eqs. 7–12 and 22–23.
//! The series in the flattening that Vincenty (1975) and Karney truncate lose digits on bodies as
//! flat as Saturn. Here the two integrands, which are even and have period π, are sampled and turned
//! into cosine series for the geodesic at hand. The coefficients fall geometrically, so the sampling
//! takes as many as doubles can see. The result is good to a few roundings: tested to 3e-13°, 33 nm
//! on the Earth, on both the Earth and a body like Saturn.

use crate::edge::Degrees;
use crate::{Ellipsoid, Geodetic};
use std::f64::consts::{PI, TAU};

/// Coefficients below this share of the first do not change a double.
const SMALLEST_COEFFICIENT: f64 = 1e-17;
/// Enough for a body a hundred times as wide as it is high.
const MAX_SAMPLES: u32 = 2048;
/// Newton's steps for the arc; the function is close to a straight line, three do for any planet.
const MAX_STEPS: u32 = 30;

/// A geodesic that starts at a place in a direction.
pub(super) struct Geodesic {
    polar_radius_m: f64,
    flattening: f64,
    /// At the node, where the geodesic crosses the equator northwards.
    sin_alpha0: f64,
    cos_alpha0: f64,
    /// `k² = e'² cos² α₀`.
    k2: f64,
    /// Arc on the auxiliary sphere from the node to the start.
    sigma1: f64,
    /// Longitude of the start, less what the series and ω make of it.
    longitude_of_node_rad: f64,
    distance: CosineIntegral,
    longitude: CosineIntegral,
}

impl Geodesic {
    /// - `azimuth_rad`: clockwise from north; at a pole, from the direction that is north there on
    ///   the start's own meridian
    pub(super) fn new(body: &Ellipsoid, start: Geodetic, azimuth_rad: f64) -> Self {
        let (sin_alpha1, cos_alpha1) = azimuth_rad.sin_cos();
        let (sin_beta1, cos_beta1) = parametric_latitude(body, start.latitude_rad);
        let sin_alpha0 = sin_alpha1 * cos_beta1;
        let cos_alpha0 = cos_alpha1.hypot(sin_alpha1 * sin_beta1);
        // As pairs, not from the angle: next to a pole the cosine is all that tells directions apart.
        let sigma1 = sin_beta1.atan2(cos_alpha1 * cos_beta1);
        let omega1 = (sin_alpha0 * sin_beta1).atan2(cos_alpha1 * cos_beta1);
        let ratio = body.polar_radius_m() / body.equatorial_radius_m();
        let flattening = 1.0 - ratio;
        let k2 = second_eccentricity_squared(body) * cos_alpha0 * cos_alpha0;
        let samples = samples_needed(k2);
        let distance = CosineIntegral::new(samples, |sin2| (1.0 + k2 * sin2).sqrt());
        let longitude = CosineIntegral::new(samples, |sin2| {
            (2.0 - flattening) / (1.0 + ratio * (1.0 + k2 * sin2).sqrt())
        });
        let correction1 = flattening * sin_alpha0 * longitude.at(sigma1);
        Self {
            polar_radius_m: body.polar_radius_m(),
            flattening,
            sin_alpha0,
            cos_alpha0,
            k2,
            sigma1,
            longitude_of_node_rad: start.longitude_rad - omega1 + correction1,
            distance,
            longitude,
        }
    }

    /// The place `distance_m` along; longitude within ±180.
    pub(super) fn at(&self, distance_m: f64) -> Degrees {
        let sigma = self.sigma_at(distance_m);
        let (sin_sigma, cos_sigma) = sigma.sin_cos();
        let omega = (self.sin_alpha0 * sin_sigma).atan2(cos_sigma);
        let correction = self.flattening * self.sin_alpha0 * self.longitude.at(sigma);
        let longitude_rad = self.longitude_of_node_rad + omega - correction;
        let sin_beta = self.cos_alpha0 * sin_sigma;
        let cos_beta = self.sin_alpha0.hypot(self.cos_alpha0 * cos_sigma);
        let latitude_rad = sin_beta.atan2((1.0 - self.flattening) * cos_beta);
        [
            (longitude_rad - TAU * (longitude_rad / TAU).round()).to_degrees(),
            latitude_rad.to_degrees(),
        ]
    }

    fn sigma_at(&self, distance_m: f64) -> f64 {
        let wanted = distance_m / self.polar_radius_m;
        let at_start = self.distance.at(self.sigma1);
        let mut sigma = self.sigma1 + wanted / self.distance.mean;
        for _ in 0..MAX_STEPS {
            let slope = (1.0 + self.k2 * sigma.sin().powi(2)).sqrt();
            let step = (self.distance.at(sigma) - at_start - wanted) / slope;
            sigma -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        sigma
    }
}

/// Length within which no two geodesics from a place at `latitude_rad` meet: circles with smaller
/// radii are closed curves without a crossing.
///
/// On an oblate body geodesics that leave to the north and to the south of east meet half a turn of
/// the auxiliary sphere on, `σ = π` (Karney 2013, § 3). That is `b ∫₀^π √(1 + k² sin² σ) dσ`. The two
/// that leave due east, `cos² α₀ = sin² β₁`, do so first.
pub(super) fn shortest_cut_m(body: &Ellipsoid, latitude_rad: f64) -> f64 {
    let (sin_beta1, _) = parametric_latitude(body, latitude_rad);
    let k2 = second_eccentricity_squared(body) * sin_beta1 * sin_beta1;
    let distance = CosineIntegral::new(samples_needed(k2), |sin2| (1.0 + k2 * sin2).sqrt());
    body.polar_radius_m() * PI * distance.mean
}

/// Sine and cosine of `β`, `tan β = (1 − f) tan φ`. The cosine is never 0: π/2 has no double.
fn parametric_latitude(body: &Ellipsoid, latitude_rad: f64) -> (f64, f64) {
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    let (sin, cos) = (
        body.polar_radius_m() * sin_lat,
        body.equatorial_radius_m() * cos_lat,
    );
    let norm = sin.hypot(cos);
    (sin / norm, cos / norm)
}

fn second_eccentricity_squared(body: &Ellipsoid) -> f64 {
    let e2 = body.eccentricity_squared();
    e2 / (1.0 - e2)
}

/// Coefficients fall like powers of Karney's ε, `(√(1 + k²) − 1) / (√(1 + k²) + 1)`.
fn samples_needed(k2: f64) -> u32 {
    let epsilon = k2 / ((1.0 + k2).sqrt() + 1.0).powi(2);
    let mut samples = 1;
    let mut power = epsilon;
    while power > SMALLEST_COEFFICIENT && samples < MAX_SAMPLES {
        power *= epsilon;
        samples += 1;
    }
    samples
}

/// `∫₀^σ g dσ = mean · σ + Σ sines[j − 1] · sin 2jσ`.
struct CosineIntegral {
    mean: f64,
    sines: Vec<f64>,
}

impl CosineIntegral {
    /// - `integrand`: of sin² σ
    fn new(samples: u32, integrand: impl Fn(f64) -> f64) -> Self {
        let count = f64::from(samples);
        let mut sums = vec![0.0; samples as usize];
        for sample in 0..samples {
            // Midpoints of a quarter turn: the integrand is even about both its ends.
            let cosine = (PI * (f64::from(sample) + 0.5) / count).cos();
            let value = integrand(0.5 * (1.0 - cosine));
            // cos 2jσ by the recurrence of the Chebyshev polynomials.
            let (mut previous, mut current) = (cosine, 1.0);
            for sum in &mut sums {
                *sum += value * current;
                (previous, current) = (current, 2.0 * cosine * current - previous);
            }
        }
        let sines = (1_u32..)
            .zip(&sums[1..])
            .map(|(j, sum)| sum / (count * f64::from(j)))
            .collect();
        Self {
            mean: sums[0] / count,
            sines,
        }
    }

    /// By Clenshaw's recurrence.
    fn at(&self, sigma: f64) -> f64 {
        let (sin, cos) = (2.0 * sigma).sin_cos();
        let (mut next, mut after) = (0.0, 0.0);
        for coefficient in self.sines.iter().rev() {
            (next, after) = (coefficient + 2.0 * cos * next - after, next);
        }
        self.mean * sigma + next * sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// Longitude, latitude, azimuth in degrees, distance; longitude and latitude reached. From
    /// Karney's GeographicLib (Python, 2.x), which is good to 15 nm on the Earth.
    const WGS84: [([f64; 4], Degrees); 4] = [
        (
            [-73.8, 40.6, 51.0, 5_500e3],
            [-1.141_172_861_200_829, 51.884_564_505_606_76],
        ),
        ([0.0, 0.0, 90.0, 19_900e3], [178.764_741_539_784_78, 0.0]),
        (
            [10.0, 89.9999, 123.0, 1_000e3],
            [66.999_467_663_794_72, 81.046_178_338_319_86],
        ),
        (
            [170.0, -45.0, 200.0, 12_000e3],
            [11.060_687_743_065_557, -24.671_129_909_989_038],
        ),
    ];
    /// The same on the Saturn-like body, where GeographicLib's series have lost digits (it is 5e-9°
    /// off): from integrating the equation of motion in 20,000 Runge–Kutta steps, of which 10,000
    /// agree with it to 1e-15.
    const SATURN_LIKE: [([f64; 4], Degrees); 2] = [
        (
            [-73.8, 40.6, 51.0, 55_000e3],
            [0.158_516_187_048_805_93, 52.365_381_222_772_236],
        ),
        (
            [170.0, -45.0, 200.0, 120_000e3],
            [11.292_518_479_958_34, -19.272_269_837_790_557],
        ),
    ];

    fn largest_error_deg(body: &Ellipsoid, cases: &[([f64; 4], Degrees)]) -> f64 {
        cases
            .iter()
            .map(|([longitude, latitude, azimuth, distance_m], expected)| {
                let start = Geodetic::from_degrees(*longitude, *latitude, 0.0);
                let found = Geodesic::new(body, start, azimuth.to_radians()).at(*distance_m);
                let longitude_error = (found[0] - expected[0]).abs();
                longitude_error.max((found[1] - expected[1]).abs())
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_direct_problem_agrees_with_published_software() {
        let error = largest_error_deg(&Ellipsoid::WGS84, &WGS84);
        assert!(error < 3e-13, "{error:e}");
        let error = largest_error_deg(&Ellipsoid::SATURN_LIKE, &SATURN_LIKE);
        assert!(error < 3e-13, "{error:e}");
        // Twin: a sphere of the mean radius is out by a fifth of a degree.
        let sphere = Ellipsoid::new("mutant", 6_371_008.8, 6_371_008.8).expect("a sphere");
        assert!(largest_error_deg(&sphere, &WGS84) > 0.05);
    }

    #[test]
    fn on_a_sphere_geodesics_are_great_circles() {
        let body = Ellipsoid::UNIT_SPHERE;
        for k in 0..50 {
            let (latitude, azimuth) = (f64::from(k) * 0.06 - 1.5, f64::from(k) * 0.5);
            let distance = 0.05 * f64::from(k) + 0.01;
            let start = Geodetic {
                longitude_rad: 0.0,
                latitude_rad: latitude,
                height_m: 0.0,
            };
            let [_, found] = Geodesic::new(&body, start, azimuth).at(distance);
            let sine =
                latitude.sin() * distance.cos() + latitude.cos() * distance.sin() * azimuth.cos();
            assert!((found.to_radians().sin() - sine).abs() < 2e-15);
        }
    }

    #[test]
    fn every_direction_leaves_a_pole() {
        for (latitude, sign) in [(90.0, 1.0), (-90.0, -1.0)] {
            for azimuth_deg in [0.0_f64, 30.0, 90.0, 200.0, 300.0] {
                let start = Geodetic::from_degrees(20.0, latitude, 0.0);
                let geodesic = Geodesic::new(&Ellipsoid::WGS84, start, azimuth_deg.to_radians());
                let [longitude, latitude] = geodesic.at(1_000e3);
                let expected = if sign > 0.0 {
                    20.0 + 180.0 - azimuth_deg
                } else {
                    20.0 + azimuth_deg
                };
                let difference = (longitude - expected).rem_euclid(360.0);
                assert!(
                    difference.min(360.0 - difference) < 1e-12,
                    "{longitude} {expected}"
                );
                // As GeographicLib has it, whatever the azimuth.
                assert!((latitude * sign - 81.046_232_815_950_62).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_cut_is_where_it_is_known_to_be() {
        let body = Ellipsoid::WGS84;
        // From the equator geodesics meet again at π b, from a pole at the other one.
        let equator = shortest_cut_m(&body, 0.0);
        assert!((equator / (PI * body.polar_radius_m()) - 1.0).abs() < 1e-15);
        let half_meridian_m = 20_003_931.458_625_447;
        let pole = shortest_cut_m(&body, FRAC_PI_2);
        assert!((pole - half_meridian_m).abs() < 1e-6, "{pole}");
        // In between, those leaving 0.1 mrad to either side of east meet there.
        let start = Geodetic::from_degrees(0.0, 30.0, 0.0);
        let cut_m = shortest_cut_m(&body, start.latitude_rad);
        let end = |azimuth: f64| Geodesic::new(&body, start, azimuth).at(cut_m);
        let (north, south) = (end(FRAC_PI_2 - 1e-4), end(FRAC_PI_2 + 1e-4));
        assert!((north[0] - south[0]).abs() < 1e-9 && (north[1] - south[1]).abs() < 1e-6);
        assert!((north[1] + 30.0).abs() < 1e-6);
        // Twin: a little earlier they are apart by far more.
        let earlier = |azimuth: f64| Geodesic::new(&body, start, azimuth).at(0.9 * cut_m);
        assert!((earlier(FRAC_PI_2 - 1e-4)[1] - earlier(FRAC_PI_2 + 1e-4)[1]).abs() > 1e-3);
    }
}
