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
use terrafill_fixtures::Random;

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

/// A ring that goes once round `center`, its radius jumping between 0.3 and 1 times `radius`
/// degrees: many edges nearly point at the centre, and many are long.
pub(super) fn star(
    random: &mut Random,
    center: [f64; 2],
    radius: f64,
    count: u32,
) -> Vec<[f64; 2]> {
    (0..count)
        .map(|i| {
            let (sin, cos) = (f64::from(i) / f64::from(count) * std::f64::consts::TAU).sin_cos();
            let reach = radius * (0.3 + 0.7 * random.share());
            [center[0] + reach * cos, center[1] + reach * sin]
        })
        .collect()
}
