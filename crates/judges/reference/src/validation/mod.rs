// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference held against arithmetic, and mutants of it that the same checks must refuse.
//!
//! Nothing here compares with a stored picture or with another renderer: areas come from closed
//! forms, outlines from tangent cones, memberships from geography.

mod agreement;
mod areas;
mod pictures;
mod places;
mod textures;

use crate::locator::{Locator, RingRole};
use crate::point::{LocatorError, RingSource};
use crate::sides::poles_held_alone;
use terrafill_core::{EdgeRule, Ellipsoid};

/// A ring of a test: position of its region, vertices, winding.
pub(super) type TestRing = (usize, Vec<[f64; 2]>, f64);

pub(super) fn try_locator(rings: &[TestRing], rule: EdgeRule) -> Result<Locator, LocatorError> {
    let sources = rings.iter().map(|(region, vertices_deg, winding_deg)| {
        let source = RingSource {
            place: format!("region {region}"),
            vertices_deg,
            winding_deg: *winding_deg,
            holds_poles: poles_held_alone(vertices_deg, *winding_deg, rule, &Ellipsoid::WGS84),
        };
        (*region, source, RingRole::Toggles)
    });
    Locator::from_rings(sources, rule)
}

pub(super) fn locator(rings: &[TestRing], rule: EdgeRule) -> Locator {
    try_locator(rings, rule).expect("the test's rings can be judged")
}

pub(super) fn rectangle(west: f64, south: f64, east: f64, north: f64) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// A parallel written all the way round, uncut.
pub(super) fn parallel(latitude: f64) -> Vec<[f64; 2]> {
    (0..36)
        .map(|i| [f64::from(i) * 10.0 - 175.0, latitude])
        .collect()
}

/// Numbers in 0 … 1 without a pattern: splitmix64.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of the sphere, longitude and latitude in degrees.
    pub(super) fn place(&mut self) -> [f64; 2] {
        let longitude = self.next() * 360.0 - 180.0;
        [longitude, (self.next() * 2.0 - 1.0).asin().to_degrees()]
    }

    /// A ring that goes once round `center`, its radius jumping between 0.3 and 1 times `radius`
    /// degrees: many edges nearly point at the centre, and many are long.
    pub(super) fn star(&mut self, center: [f64; 2], radius: f64, count: u32) -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| {
                let (sin, cos) =
                    (f64::from(i) / f64::from(count) * std::f64::consts::TAU).sin_cos();
                let reach = radius * (0.3 + 0.7 * self.next());
                [center[0] + reach * cos, center[1] + reach * sin]
            })
            .collect()
    }
}
