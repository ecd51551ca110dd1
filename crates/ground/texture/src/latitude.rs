// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which latitude a route computes, from geocentric (wrong by up to 11.5′ on Earth) to geodetic.
//!
//! Every form is a vector (V_ρ, V_z) of the meridian's half-plane whose direction is taken for the
//! normal's. Geocentric: the position itself. Parametric: ((1 − e²) ρ, z), one product more and exact
//! on the surface (Torge, "Geodesy", §4.1.3); off by 37 m at −11 km. Bowring (1976): from the centre of
//! curvature of the meridian, `(ρ − e² a cos³ β, z + e′² b sin³ β)`, β being the parametric latitude.
//! It is taken first from `tan β = z / ((1 − f) ρ)`, then from `tan β = (1 − f) tan φ`.

use terrafill_core::Ellipsoid;

/// How latitude is computed from a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatitudeForm {
    /// The angle at the body's centre.
    Geocentric,
    /// z over (1 − e²) ρ.
    Parametric,
    /// One step of Bowring's.
    Bowring1,
    /// Two steps of Bowring's.
    Bowring2,
}

impl LatitudeForm {
    /// Every form, cheapest first.
    pub const ALL: [Self; 4] = [
        Self::Geocentric,
        Self::Parametric,
        Self::Bowring1,
        Self::Bowring2,
    ];

    /// Name within a route's.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Geocentric => "geocentric",
            Self::Parametric => "parametric",
            Self::Bowring1 => "bowring-1",
            Self::Bowring2 => "bowring-2",
        }
    }

    /// The form called so.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.name() == name)
    }

    /// Steps of Bowring's.
    #[must_use]
    pub(crate) fn bowring_steps(self) -> u32 {
        match self {
            Self::Geocentric | Self::Parametric => 0,
            Self::Bowring1 => 1,
            Self::Bowring2 => 2,
        }
    }

    /// The form's latitude of a point of a meridian's half-plane, in `f64`: what the form itself leaves
    /// out, without any rounding to `f32`.
    ///
    /// - `rho`: distance from the axis, metres, not negative
    /// - `z`: along the axis to the north, metres
    #[must_use]
    pub fn latitude_rad(self, body: &Ellipsoid, rho: f64, z: f64) -> f64 {
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let e2 = body.eccentricity_squared();
        match self {
            Self::Geocentric => z.atan2(rho),
            Self::Parametric => z.atan2((1.0 - e2) * rho),
            Self::Bowring1 | Self::Bowring2 => {
                let mut beta = (a * z).atan2(b * rho);
                let mut latitude = beta;
                for _ in 0..self.bowring_steps() {
                    let (sin, cos) = beta.sin_cos();
                    let along_z = z + e2 / (1.0 - e2) * b * sin.powi(3);
                    let along_rho = rho - e2 * a * cos.powi(3);
                    latitude = along_z.atan2(along_rho);
                    beta = (b * along_z).atan2(a * along_rho);
                }
                latitude
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ExactGeodetic;
    use terrafill_core::Geodetic;

    /// Largest error of a form over all latitudes at heights between two, metres on the surface.
    fn worst_m(form: LatitudeForm, body: &Ellipsoid, heights_m: (f64, f64)) -> f64 {
        let exact = ExactGeodetic::new(body);
        let mut worst = 0.0_f64;
        for step in 0..=900 {
            for part in 0..=10 {
                let height_m = heights_m.0 + f64::from(part) / 10.0 * (heights_m.1 - heights_m.0);
                let position = body.geodetic_to_ecef(Geodetic {
                    longitude_rad: 0.0,
                    latitude_rad: (f64::from(step) / 10.0).to_radians(),
                    height_m,
                });
                let rho = position.x.max(0.0);
                let (truth, _) = exact.from_meridian(rho, position.z);
                let found = form.latitude_rad(body, rho, position.z);
                worst = worst.max((found - truth).abs() * body.equatorial_radius_m());
            }
        }
        worst
    }

    #[test]
    fn errors_of_the_forms_are_those_of_another_implementation() {
        let earth = Ellipsoid::WGS84;
        let saturn = Ellipsoid::SATURN_LIKE;
        let radius = saturn.equatorial_radius_m();
        let terrain = (-11e3, 9e3);
        let saturn_heights = (-0.0017 * radius, 0.0014 * radius);
        let cases = [
            (LatitudeForm::Geocentric, earth, (0.0, 0.0), 21.4e3),
            (LatitudeForm::Parametric, earth, terrain, 37.0),
            (LatitudeForm::Parametric, earth, (4e5, 4e5), 1270.0),
            (LatitudeForm::Parametric, earth, (3.57e7, 3.57e7), 18e3),
            (LatitudeForm::Bowring1, earth, terrain, 1e-6),
            (LatitudeForm::Bowring1, earth, (4e5, 4e5), 1e-3),
            (LatitudeForm::Bowring1, earth, (3.57e7, 3.57e7), 0.04),
            (LatitudeForm::Bowring1, saturn, saturn_heights, 0.33),
            (LatitudeForm::Parametric, saturn, saturn_heights, 11.4e3),
        ];
        for (form, body, heights, expected) in cases {
            let found = worst_m(form, &body, heights) / expected;
            let name = form.name();
            // The published figures have one to three digits.
            assert!((0.8..1.25).contains(&found), "{name} {heights:?}: {found}");
        }
        // Two steps: the last place of f64 on Earth, and on Saturn no more than 2e-8 m.
        assert!(worst_m(LatitudeForm::Bowring2, &earth, terrain) < 1e-8);
        assert!(worst_m(LatitudeForm::Bowring2, &saturn, saturn_heights) < 4e-8);
    }

    #[test]
    fn a_form_taken_for_another_is_noticed() {
        let heights = (-11e3, 9e3);
        let worst = LatitudeForm::ALL.map(|form| worst_m(form, &Ellipsoid::WGS84, heights));
        // Each is at least a hundred times better than the one before.
        for pair in worst.windows(2) {
            assert!(pair[1] < 0.01 * pair[0], "{worst:?}");
        }
        // On a sphere all are exact.
        for form in LatitudeForm::ALL {
            assert!(worst_m(form, &Ellipsoid::MOON, heights) < 1e-8);
        }
    }

    #[test]
    fn names_return() {
        for form in LatitudeForm::ALL {
            assert_eq!(LatitudeForm::parse(form.name()), Some(form));
        }
        assert_eq!(LatitudeForm::parse("bowring-3"), None);
    }
}
