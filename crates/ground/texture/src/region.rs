// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a route works on: a body, an anchor, and an extent with a range of heights.

use crate::ExactGeodetic;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_core::{Ellipsoid, Geodetic};

/// Geodetic bounds, radians. The longitude is unwrapped: `east_rad` may lie beyond π.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapExtent {
    /// Western edge.
    pub west_rad: f64,
    /// Southern edge.
    pub south_rad: f64,
    /// Eastern edge, not west of the western one.
    pub east_rad: f64,
    /// Northern edge.
    pub north_rad: f64,
}

impl MapExtent {
    /// From degrees, as people write them.
    #[must_use]
    pub fn from_degrees(west: f64, south: f64, east: f64, north: f64) -> Self {
        Self {
            west_rad: west.to_radians(),
            south_rad: south.to_radians(),
            east_rad: east.to_radians(),
            north_rad: north.to_radians(),
        }
    }

    /// Width and height, radians.
    #[must_use]
    pub fn size_rad(&self) -> [f64; 2] {
        [
            self.east_rad - self.west_rad,
            self.north_rad - self.south_rad,
        ]
    }
}

/// Why a region is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapRegionError {
    /// A bound, the anchor or a height is NaN or infinite.
    #[error("{what} is {found}, must be finite")]
    NotFinite {
        /// Which number.
        what: &'static str,
        /// What it is.
        found: f64,
    },
    /// Bounds in the wrong order or out of range.
    #[error("{what} from {low} to {high}; allowed: {allowed}")]
    Bounds {
        /// Which pair.
        what: &'static str,
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
        /// What would do.
        allowed: &'static str,
    },
}

/// A region whose fragments look for their texture coordinate.
#[derive(Debug, Clone, Copy)]
pub struct MapRegion {
    body: Ellipsoid,
    anchor_longitude_rad: f64,
    anchor_latitude_rad: f64,
    extent: MapExtent,
    height_range_m: (f64, f64),
}

/// One place of a region with the exact answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Position minus the anchor's, meridian axes, metres; rounded to what a fragment has.
    pub offset_m: [f32; 3],
    /// Geodetic longitude and latitude of that rounded position minus the anchor's, radians.
    pub angles_rad: [f64; 2],
    /// Metres on the body's surface per radian of longitude and of latitude here.
    pub metres_per_radian: [f64; 2],
    /// Closer to the axis than the offset's last place, so that it has no longitude.
    pub on_axis: bool,
}

impl MapRegion {
    /// A region anchored at the centre of its extent.
    ///
    /// - `height_range_m`: lowest and highest point drawn, metres above the body's surface
    ///
    /// # Errors
    /// [`MapRegionError`] where a number is not finite, the extent is empty, wider than 2π or
    /// beyond a pole, or the lowest height lies below half of the body's polar radius.
    pub fn new(
        body: Ellipsoid,
        extent: MapExtent,
        height_range_m: (f64, f64),
    ) -> Result<Self, MapRegionError> {
        let longitude = 0.5 * (extent.west_rad + extent.east_rad);
        let latitude = 0.5 * (extent.south_rad + extent.north_rad);
        Self::with_anchor(body, longitude, latitude, extent, height_range_m)
    }

    /// A region anchored at the pole that its extent touches, if it touches one, else at its centre.
    ///
    /// Close to a pole longitude is as exact as the offset from the axis is. With any other anchor
    /// that offset is a difference of `f32` numbers as large as the anchor's distance from the axis.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn anchored(
        body: Ellipsoid,
        extent: MapExtent,
        height_range_m: (f64, f64),
    ) -> Result<Self, MapRegionError> {
        let at_pole = |latitude_rad: f64| latitude_rad.abs() >= FRAC_PI_2 - 1e-12;
        let latitude = match (at_pole(extent.south_rad), at_pole(extent.north_rad)) {
            (false, true) => FRAC_PI_2,
            (true, false) => -FRAC_PI_2,
            _ => 0.5 * (extent.south_rad + extent.north_rad),
        };
        let longitude = 0.5 * (extent.west_rad + extent.east_rad);
        Self::with_anchor(body, longitude, latitude, extent, height_range_m)
    }

    /// A region with an anchor of its own, radians.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_anchor(
        body: Ellipsoid,
        anchor_longitude_rad: f64,
        anchor_latitude_rad: f64,
        extent: MapExtent,
        height_range_m: (f64, f64),
    ) -> Result<Self, MapRegionError> {
        for (what, found) in [
            ("western edge", extent.west_rad),
            ("southern edge", extent.south_rad),
            ("eastern edge", extent.east_rad),
            ("northern edge", extent.north_rad),
            ("anchor's longitude", anchor_longitude_rad),
            ("anchor's latitude", anchor_latitude_rad),
            ("lowest height", height_range_m.0),
            ("highest height", height_range_m.1),
        ] {
            if !found.is_finite() {
                return Err(MapRegionError::NotFinite { what, found });
            }
        }
        let [width, height] = extent.size_rad();
        let bounds = |what, low, high, allowed| MapRegionError::Bounds {
            what,
            low,
            high,
            allowed,
        };
        // 2π in degrees and back is off in the last places.
        if width <= 0.0 || width > TAU + 1e-9 {
            let allowed = "a width above 0 up to 2π";
            return Err(bounds(
                "longitude",
                extent.west_rad,
                extent.east_rad,
                allowed,
            ));
        }
        let pole = FRAC_PI_2 + 1e-12;
        if height <= 0.0 || extent.south_rad < -pole || extent.north_rad > pole {
            let allowed = "ascending within ±π/2";
            return Err(bounds(
                "latitude",
                extent.south_rad,
                extent.north_rad,
                allowed,
            ));
        }
        if anchor_latitude_rad.abs() > pole {
            let allowed = "an anchor within ±π/2";
            let at = anchor_latitude_rad;
            return Err(bounds("latitude", at, at, allowed));
        }
        let (low, high) = height_range_m;
        if low > high || low < -0.5 * body.polar_radius_m() {
            let allowed = "ascending from −b/2";
            return Err(bounds("height", low, high, allowed));
        }
        Ok(Self {
            body,
            anchor_longitude_rad,
            anchor_latitude_rad,
            extent,
            height_range_m,
        })
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Ellipsoid {
        &self.body
    }

    /// The anchor's geodetic longitude, radians, unwrapped as the extent is.
    #[must_use]
    pub fn anchor_longitude_rad(&self) -> f64 {
        self.anchor_longitude_rad
    }

    /// The anchor's geodetic latitude, radians.
    #[must_use]
    pub fn anchor_latitude_rad(&self) -> f64 {
        self.anchor_latitude_rad
    }

    /// The bounds.
    #[must_use]
    pub fn extent(&self) -> &MapExtent {
        &self.extent
    }

    /// Lowest and highest point drawn, metres above the surface.
    #[must_use]
    pub fn height_range_m(&self) -> (f64, f64) {
        self.height_range_m
    }

    /// The anchor, a point of the body's surface, in body axes (ECEF), metres.
    #[must_use]
    pub fn anchor_ecef(&self) -> DVec3 {
        self.body.geodetic_to_ecef(Geodetic {
            longitude_rad: self.anchor_longitude_rad,
            latitude_rad: self.anchor_latitude_rad,
            height_m: 0.0,
        })
    }

    /// The anchor in meridian axes, metres: distance from the axis, 0, height over the equator.
    #[must_use]
    pub fn anchor_meridian(&self) -> DVec3 {
        self.body.geodetic_to_ecef(Geodetic {
            longitude_rad: 0.0,
            latitude_rad: self.anchor_latitude_rad,
            height_m: 0.0,
        })
    }

    /// Position minus the anchor's in meridian axes, metres, `f64`.
    #[must_use]
    pub fn offset_m(&self, position: Geodetic) -> DVec3 {
        let turned = Geodetic {
            longitude_rad: position.longitude_rad - self.anchor_longitude_rad,
            ..position
        };
        self.body.geodetic_to_ecef(turned) - self.anchor_meridian()
    }

    /// Exact longitude and latitude minus the anchor's of an offset in meridian axes, radians.
    #[must_use]
    pub fn exact_angles(&self, offset_m: DVec3) -> [f64; 2] {
        let found = self.exact_place(offset_m);
        [
            found.longitude_rad,
            found.latitude_rad - self.anchor_latitude_rad,
        ]
    }

    /// Of an offset in meridian axes; the anchor's longitude is 0.
    fn exact_place(&self, offset_m: DVec3) -> Geodetic {
        ExactGeodetic::new(&self.body).from_ecef(self.anchor_meridian() + offset_m)
    }

    /// The place at the given geodetic position with its exact answer.
    ///
    /// The offset is rounded to `f32` first and the answer is that of the rounded offset: where the
    /// fragment lies is the position route's error, not the coordinate route's.
    #[must_use]
    pub fn sample(&self, position: Geodetic) -> Sample {
        let offset = self.offset_m(position).as_vec3();
        let rounded = self.anchor_meridian() + offset.as_dvec3();
        // Half a unit in the last place is 2⁻²⁴ of a component.
        let last_place = f64::from(offset.abs().max_element()) * 2.0_f64.powi(-23);
        Sample {
            on_axis: rounded.x.hypot(rounded.y) <= last_place,
            offset_m: offset.to_array(),
            angles_rad: self.exact_angles(offset.as_dvec3()),
            metres_per_radian: self.metres_per_radian(position.latitude_rad),
        }
    }

    /// `count` places spread evenly over extent and heights, with corners, edges and the middle.
    ///
    /// Evenly means the additive recurrence of the plastic number in three dimensions (Roberts 2018,
    /// "The unreasonable effectiveness of quasirandom sequences"). Any single coordinate takes `count`
    /// different, evenly spread values, which a grid of as many points does not. The errors looked for
    /// mostly wave in one coordinate. Last come the extent's edges, lowest and highest: a fitted chart
    /// is worst there, and of evenly spread places few lie close to them.
    pub fn samples(&self, count: u32) -> impl Iterator<Item = Sample> + '_ {
        let corners = (0..27).map(move |i: u32| {
            let half = |n: u32| f64::from(n % 3) * 0.5;
            [half(i), half(i / 3), half(i / 9)]
        });
        // 1.2207440846… solves x⁴ = x + 1.
        const PLASTIC: f64 = 1.220_744_084_605_759_5;
        let spread = (1..=count).map(move |i| {
            let place = |power: i32| (0.5 + f64::from(i) * PLASTIC.powi(-power)).fract();
            [place(1), place(2), place(3)]
        });
        // A sixteenth of all, so that a root mean square hardly knows of them.
        let steps = (count / 128).max(1);
        let edges = (0..8 * steps).map(move |i| {
            let along = (f64::from(i / 8) + 0.5) / f64::from(steps);
            let across = f64::from(i % 2);
            let height = f64::from(i / 2 % 2);
            if i / 4 % 2 == 0 {
                [across, along, height]
            } else {
                [along, across, height]
            }
        });
        let places = corners.chain(spread).chain(edges);
        places.map(|place| self.sample_at(place))
    }

    /// The place at these shares of the way from west to east, south to north and up.
    pub(crate) fn sample_at(&self, [u, v, w]: [f64; 3]) -> Sample {
        let [width, height] = self.extent.size_rad();
        let (low, high) = self.height_range_m;
        self.sample(Geodetic {
            longitude_rad: self.extent.west_rad + u * width,
            latitude_rad: (self.extent.south_rad + v * height).clamp(-FRAC_PI_2, FRAC_PI_2),
            height_m: low + w * (high - low),
        })
    }

    /// The shares that [`Self::sample_at`] takes, found back from a sample.
    pub(crate) fn shares_of(&self, sample: &Sample) -> [f64; 3] {
        let [width, height] = self.extent.size_rad();
        let (low, high) = self.height_range_m;
        let found = self.exact_place(DVec3::from_array(sample.offset_m.map(f64::from)));
        let east = self.anchor_longitude_rad + found.longitude_rad - self.extent.west_rad;
        let north = found.latitude_rad - self.extent.south_rad;
        // Of a flat region every height is the lowest.
        let up = (found.height_m - low) / (high - low).max(1e-9);
        // The turn's beginning and end are one longitude.
        let east = if east < 0.0 { east + TAU } else { east };
        [east / width, north / height, up].map(|share| share.clamp(0.0, 1.0))
    }

    /// Whether the extent holds or touches a pole, where longitude has no meaning.
    #[must_use]
    pub fn touches_pole(&self) -> bool {
        self.extent.north_rad.max(-self.extent.south_rad) >= FRAC_PI_2 - 1e-12
    }

    /// Radius of the parallel and of the meridian's curvature on the surface, metres.
    fn metres_per_radian(&self, latitude_rad: f64) -> [f64; 2] {
        let [prime_vertical, meridian] = self.body.curvature_radii_m(latitude_rad);
        [prime_vertical * latitude_rad.cos(), meridian]
    }
}
