// SPDX-License-Identifier: MIT OR Apache-2.0
//! What both inside tests read and say: rings, points, bounds, verdicts, and what makes a ring refused.
//!
//! Longitude and latitude in degrees, geodetic.

use glam::DVec3;
use terrafill_core::NEARLY_OPPOSITE_RAD;

/// Longitudes are rounded to multiples of 2⁻⁴³ degrees, 13 nm at the equator. So adding or subtracting
/// whole turns is exact below 1024 degrees, and no point falls between the end of a ring and its start
/// one turn on.
const LONGITUDE_STEPS_PER_DEG: f64 = 8_796_093_022_208.0;

/// How a ring lies round the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RingCourse {
    /// Eastwards positive.
    pub(crate) turns: i32,
    /// Signed area between the equator and the ring on its way east, square metres.
    pub(crate) above_equator_m2: f64,
}

/// Why a ring cannot be tested.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LocatorError {
    /// A planar ring ends neither where it started nor one turn on.
    #[error("{place} ends {found}° from its start, needs 0 or ±360")]
    Winding {
        /// Region and ring.
        place: String,
        /// Longitude of the end minus that of the start.
        found: f64,
    },
    /// A planar ring lies over itself.
    #[error("{place} is {found}° wide, allowed 360")]
    WiderThanATurn {
        /// Region and ring.
        place: String,
        /// Its width.
        found: f64,
    },
    /// Turns cannot be added exactly that far out.
    #[error("{place} reaches longitude ±{found}, allowed ±{allowed}")]
    LongitudeOutOfRange {
        /// Region and ring.
        place: String,
        /// Largest absolute longitude.
        found: f64,
        /// The limit.
        allowed: f64,
    },
    /// Two rings of a region say two things of one place.
    #[error(
        "{place} {what} {other} at longitude {longitude_deg:.7}, latitude {latitude_deg:.7}, allowed: \
         parts apart, holes in their shell and apart; --repair union joins them"
    )]
    Overlap {
        /// Region and ring.
        place: String,
        /// What is wrong with it beside the other.
        what: &'static str,
        /// The other ring.
        other: String,
        /// Of a place in both, or in the one and not the other.
        longitude_deg: f64,
        /// Of that place.
        latitude_deg: f64,
    },
    /// Every plane through the ends of a great-ellipse edge holds the centre, or all but.
    #[error(
        "{place}: the edge from vertex {vertex} joins the opposite points {start:?} and {end:?}, \
         allowed: over {NEARLY_OPPOSITE_RAD:e} rad from opposite"
    )]
    OppositeEnds {
        /// Region and ring.
        place: String,
        /// Vertex that the edge starts at.
        vertex: usize,
        /// Longitude and latitude of its start, degrees.
        start: [f64; 2],
        /// Longitude and latitude of its end, degrees.
        end: [f64; 2],
    },
}

/// A ring as the tests read it, with its place for messages.
#[derive(Debug, Clone)]
pub(crate) struct RingSource<'a> {
    pub(crate) place: String,
    pub(crate) vertices_deg: &'a [[f64; 2]],
    pub(crate) winding_deg: f64,
    /// Whether the south pole and the north pole are inside.
    pub(crate) holds_poles: [bool; 2],
}

impl RingSource<'_> {
    pub(crate) fn winding_error(&self) -> LocatorError {
        LocatorError::Winding {
            place: self.place.clone(),
            found: self.winding_deg,
        }
    }

    pub(crate) fn width_error(&self, found: f64) -> LocatorError {
        LocatorError::WiderThanATurn {
            place: self.place.clone(),
            found,
        }
    }

    pub(crate) fn longitude_error(&self, found: f64, allowed: f64) -> LocatorError {
        LocatorError::LongitudeOutOfRange {
            place: self.place.clone(),
            found,
            allowed,
        }
    }

    pub(crate) fn opposite_error(&self, vertex: usize) -> LocatorError {
        LocatorError::OppositeEnds {
            place: self.place.clone(),
            vertex,
            start: self.vertices_deg[vertex],
            end: self.vertices_deg[(vertex + 1) % self.vertices_deg.len()],
        }
    }
}

/// A point as both kinds of ring want it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// −180 … 180, on the grid of [`on_longitude_grid`].
    pub(crate) longitude_deg: f64,
    /// Strictly within ±90.
    pub(crate) latitude_deg: f64,
    /// Unit geodetic normal.
    pub(crate) normal: DVec3,
}

impl Point {
    /// A pole is every longitude at once, and on the rim of whatever is straight in longitude and
    /// latitude. So it is read as the nearest latitude to it that a double can hold, 10⁻⁹ m away.
    pub(crate) fn new(longitude_deg: f64, latitude_deg: f64) -> Option<Self> {
        if !longitude_deg.is_finite() || latitude_deg.is_nan() || latitude_deg.abs() > 90.0 {
            return None;
        }
        let turns = (longitude_deg / 360.0).round();
        Some(Self {
            longitude_deg: on_longitude_grid(longitude_deg - 360.0 * turns),
            latitude_deg: latitude_deg.clamp((-90.0_f64).next_up(), 90.0_f64.next_down()),
            normal: normal(longitude_deg, latitude_deg),
        })
    }
}

/// Unit geodetic normal.
///
/// One place has one vector to the bit, under whichever longitude it is written, and the
/// antimeridian lies in one plane to the bit: parts cut there or run to a pole meet without a gap.
pub(crate) fn normal(longitude_deg: f64, latitude_deg: f64) -> DVec3 {
    if latitude_deg.abs() >= 90.0 {
        return DVec3::new(0.0, 0.0, latitude_deg.signum());
    }
    let turns = ((longitude_deg + 180.0) / 360.0).floor();
    let longitude_deg = longitude_deg - 360.0 * turns;
    let (sin_lon, cos_lon) = if longitude_deg == -180.0 {
        (0.0, -1.0)
    } else {
        longitude_deg.to_radians().sin_cos()
    };
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// What the two tests say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Verdicts {
    pub(crate) first: bool,
    pub(crate) second: bool,
}

/// A rectangle in longitude and latitude, degrees; `west..east` may lie beyond ±180.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) west: f64,
    pub(crate) south: f64,
    pub(crate) east: f64,
    pub(crate) north: f64,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self {
        west: f64::INFINITY,
        south: f64::INFINITY,
        east: f64::NEG_INFINITY,
        north: f64::NEG_INFINITY,
    };

    pub(crate) fn include(&mut self, vertex: [f64; 2]) {
        self.west = self.west.min(vertex[0]);
        self.east = self.east.max(vertex[0]);
        self.south = self.south.min(vertex[1]);
        self.north = self.north.max(vertex[1]);
    }
}

/// Rounds a longitude to where turns can be added exactly.
pub(crate) fn on_longitude_grid(longitude_deg: f64) -> f64 {
    (longitude_deg * LONGITUDE_STEPS_PER_DEG).round() / LONGITUDE_STEPS_PER_DEG
}
