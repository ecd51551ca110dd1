// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where Gebbie and Bailey's projections put a place: the globe, a flat map, a hyperbolic one by polar or by Cartesian
//! coordinates, and a dome. Their formulas are those of Bailey's shader textbook, since the paper prints none.
//!
//! Flat and hyperbolic maps take longitude and latitude from the place below the eye, in units of the body's radius:
//! about it, to the east and to the north. What comes out fills −1 … 1.

use crate::list::Eye;
use glam::{DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, TAU};

terrafill_results::named! {
    /// A projection.
    all pub(crate) enum Projection {
        Globe = "globe",
        Flat = "flat",
        HyperbolicPolar = "hyperbolic-polar",
        HyperbolicCartesian = "hyperbolic-cartesian",
        Dome = "dome",
    }
}

/// How far from the focus half of the rim is reached, radii.
pub(crate) const K: f64 = 0.5;

impl Projection {
    /// Another one, which a picture must not be taken for.
    pub(crate) fn next(self) -> Self {
        let mut from_here = Self::ALL.iter().cycle();
        from_here.find(|known| **known == self);
        from_here.next().copied().unwrap_or(self)
    }

    /// Clip position of a place, reversed depth.
    ///
    /// - `relative_m`: from the eye, ECEF axes
    pub(crate) fn clip(self, eye: &Eye, relative_m: DVec3) -> DVec4 {
        let (camera, size, focus) = (&eye.camera, eye.size, eye.pose.eye);
        let view = camera.view_from_ecef * relative_m;
        let near = camera.near_m / relative_m.length();
        let map = || {
            let place = eye.body.ecef_to_geodetic(camera.eye_ecef + relative_m);
            let turn = place.longitude_rad - focus.longitude_rad;
            let turn = turn - TAU * (turn / TAU).round();
            [turn, place.latitude_rad - focus.latitude_rad]
        };
        // On the map nothing hides anything else; what is nearer to the eye stays so.
        let flat = |[x, y]: [f64; 2]| DVec4::new(x / size.aspect(), y, near.clamp(0.0, 1.0), 1.0);
        match self {
            Self::Globe => {
                let tan = camera.tan_half_fov();
                let x = view.x / (tan * size.aspect());
                DVec4::new(x, view.y / tan, camera.near_m, -view.z)
            }
            Self::Flat => flat(map().map(|at| at / FRAC_PI_2)),
            Self::HyperbolicPolar => flat(hyperbolic_polar(map(), K)),
            Self::HyperbolicCartesian => flat(map().map(|at| hyperbolic_cartesian(at, K))),
            Self::Dome => flat(dome(view)),
        }
    }
}

/// `(x, y) / (ρ + K)`: radius `r' = ρ / (ρ + K)`, the angle stays.
pub(crate) fn hyperbolic_polar([x, y]: [f64; 2], k: f64) -> [f64; 2] {
    let from = x.hypot(y) + k;
    // At the middle of a map with K = 0 all directions are one.
    if from > 0.0 {
        [x / from, y / from]
    } else {
        [0.0; 2]
    }
}

/// `x / √(x² + K²)`, each axis by itself.
pub(crate) fn hyperbolic_cartesian(x: f64, k: f64) -> f64 {
    let from = x.hypot(k);
    if from > 0.0 { x / from } else { 0.0 }
}

/// Share of a quarter turn from straight ahead, in the direction where it is seen; the view looks along −z.
pub(crate) fn dome(view: DVec3) -> [f64; 2] {
    let across = view.x.hypot(view.y);
    let share = across.atan2(-view.z) / FRAC_PI_2;
    if across > 0.0 {
        [view.x, view.y].map(|at| share * at / across)
    } else {
        [0.0; 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use terrafill_core::Geodetic;

    #[test]
    fn maps_go_to_their_rim_and_back() {
        for at in [0.1, 1.0, 3.0] {
            let [x, y] = hyperbolic_polar([0.6 * at, 0.8 * at], K);
            let radius = x.hypot(y);
            assert!((K * radius / (1.0 - radius) - at).abs() < 1e-12);
            assert!((y / x - 0.8 / 0.6).abs() < 1e-12);
            let x = hyperbolic_cartesian(at, K);
            assert!((K * x / (1.0 - x * x).sqrt() - at).abs() < 1e-12);
        }
        // K = 0 sends all to the rim, K = ∞ to the middle.
        assert_eq!(hyperbolic_polar([3.0, 4.0], 0.0), [0.6, 0.8]);
        assert_eq!(hyperbolic_polar([3.0, 4.0], f64::INFINITY), [0.0; 2]);
        assert_eq!(hyperbolic_cartesian(-2.0, 0.0), -1.0);
        assert_eq!(hyperbolic_cartesian(-2.0, f64::INFINITY), 0.0);
        for at in [
            hyperbolic_polar([0.0; 2], 0.0),
            dome(DVec3::ZERO),
            dome(DVec3::NEG_Z),
        ] {
            assert_eq!(at, [0.0; 2]);
        }
        assert!((dome(DVec3::X)[0] - 1.0).abs() < 1e-12);
        assert!((dome(DVec3::new(1.0, 0.0, -1.0))[0] - 0.5).abs() < 1e-12);
        assert!(hyperbolic_cartesian(0.0, 0.0).abs() < 1e-12);
    }

    #[test]
    fn every_place_of_every_projection_is_finite() {
        for focus_deg in [[15.0, 20.0], [180.0, -89.0], [0.0, 90.0]] {
            let row = crate::list::ViewRow {
                longitude_deg: focus_deg[0],
                latitude_deg: focus_deg[1],
                height_m: 8e6,
                pitch_deg: -90.0,
                ..Default::default()
            };
            let eye = row.eye(100);
            for projection in Projection::ALL {
                for i in 0..200_u32 {
                    let place = Geodetic {
                        longitude_rad: f64::from(i) * 0.9 - PI,
                        latitude_rad: (f64::from(i) * 0.37).sin() * FRAC_PI_2,
                        height_m: 0.0,
                    };
                    let relative_m = eye.body.geodetic_to_ecef(place) - eye.camera.eye_ecef;
                    let clip = projection.clip(&eye, relative_m);
                    assert!(clip.is_finite(), "{projection:?} {place:?}");
                    if matches!(
                        projection,
                        Projection::HyperbolicPolar | Projection::HyperbolicCartesian
                    ) {
                        assert!(clip.x.abs() < 1.0 && clip.y.abs() < 1.0);
                    }
                }
            }
        }
    }
}
