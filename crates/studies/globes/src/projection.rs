// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where Gebbie and Bailey's projections put a place: the globe, a flat map, a hyperbolic one by polar or by Cartesian
//! coordinates, and a dome. Their formulas are those of Bailey's shader textbook, since the paper prints none.
//!
//! Flat and hyperbolic maps take longitude and latitude from the place below the eye, in units of the body's radius:
//! about it, to the east and to the north. What comes out fills −1 … 1.

use glam::{DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_globe_views::Eye;
use terrafill_maps::HALF_RIM;
pub(crate) use terrafill_maps::{dome, hyperbolic_cartesian, hyperbolic_polar};

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
pub(crate) const K: f64 = HALF_RIM;

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use terrafill_core::Geodetic;

    #[test]
    fn every_place_of_every_projection_is_finite() {
        for focus_deg in [[15.0, 20.0], [180.0, -89.0], [0.0, 90.0]] {
            let row = terrafill_globe_views::ViewRow {
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
