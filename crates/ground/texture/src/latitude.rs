// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which latitude a route computes, from geocentric (wrong by up to 11.5′ on Earth) to geodetic.
//!
//! Every form is a vector (`V_ρ`, `V_z`) of the meridian's half-plane whose direction is taken for the
//! normal's. Geocentric: the position itself. Parametric: ((1 − e²) ρ, z), one product more and exact
//! on the surface (Torge, "Geodesy", §4.1.3); off by 37 m at −11 km. Bowring (1976): from the centre of
//! curvature of the meridian, `(ρ − e² a cos³ β, z + e′² b sin³ β)`, β being the parametric latitude.
//! It is taken first from `tan β = z / ((1 − f) ρ)`, then from `tan β = (1 − f) tan φ`.

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

    /// Steps of Bowring's.
    #[must_use]
    pub(crate) fn bowring_steps(self) -> u32 {
        match self {
            Self::Geocentric | Self::Parametric => 0,
            Self::Bowring1 => 1,
            Self::Bowring2 => 2,
        }
    }
}
