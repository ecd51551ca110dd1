// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a cone has no footprint.

use crate::Ellipsoid;

/// Why a cone has no footprint, or none with as many vertices as asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FootprintError {
    /// An angle out of its range; most often in degrees.
    #[error("{parameter} is {found} rad; allowed is {smallest} … {largest}")]
    Angle {
        /// Its name.
        parameter: &'static str,
        /// Its value.
        found: f64,
        /// Smallest value allowed.
        smallest: f64,
        /// Largest value allowed.
        largest: f64,
    },
    /// A sensor on or in the body.
    #[error("the apex is at a height of {found_m} m; allowed is {smallest_m} and more")]
    ApexInside {
        /// Height of the apex.
        found_m: f64,
        /// Smallest height allowed.
        smallest_m: f64,
    },
    /// A cone that points past the body.
    #[error(
        "the cone misses {body}: its axis is {found_deg:.4}° from the horizon, its half angle is \
         {half_angle_deg:.4}°"
    )]
    Misses {
        /// Name of the body.
        body: &'static str,
        /// Smallest angle between axis and horizon.
        found_deg: f64,
        /// Would have to be larger.
        half_angle_deg: f64,
    },
    /// A footprint that is no single closed curve with as many vertices as asked for.
    #[error("the cone's edge cannot be followed all round on {body}: {why}")]
    NotAllRound {
        /// Name of the body.
        body: &'static str,
        /// What is in the way.
        why: &'static str,
    },
    /// A footprint so wide that facets across it face inwards.
    #[error("a facet across the footprint faces inwards on {body}")]
    Folded {
        /// Name of the body.
        body: &'static str,
    },
    /// Too few or too many vertices.
    #[error("{found} vertices; allowed are {smallest} … {largest}")]
    VertexCount {
        /// How many.
        found: u32,
        /// Fewest allowed.
        smallest: u32,
        /// Most allowed.
        largest: u32,
    },
}

impl FootprintError {
    pub(super) fn not_all_round(body: &Ellipsoid, why: &'static str) -> Self {
        Self::NotAllRound {
            body: body.name(),
            why,
        }
    }

    /// Whether `found` lies in ± `largest`.
    pub(super) fn check_angle(
        parameter: &'static str,
        found: f64,
        largest: f64,
    ) -> Result<(), Self> {
        if (-largest..=largest).contains(&found) {
            return Ok(());
        }
        Err(Self::Angle {
            parameter,
            found,
            smallest: -largest,
            largest,
        })
    }
}
