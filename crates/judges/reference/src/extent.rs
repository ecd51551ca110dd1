// SPDX-License-Identifier: MIT OR Apache-2.0
//! The part of a body that a region spans in longitude and latitude, from its rings alone.
//!
//! Radians; west at −π or above and below π, east above west by at most a turn. Of all intervals
//! that begin at the western end of a polygon the narrowest is taken: slower than sorting gaps, and
//! nothing to go wrong. Edges along great ellipses are followed to the point nearest to a pole.

use crate::sides::poles_held;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_core::{EdgeRule, Ellipsoid, Region, Ring};

/// Bounds of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegionExtent {
    pub(crate) west: f64,
    pub(crate) south: f64,
    pub(crate) east: f64,
    pub(crate) north: f64,
}

impl RegionExtent {
    pub(crate) fn new(region: &Region, rule: EdgeRule, body: &Ellipsoid) -> Self {
        let mut latitudes = [FRAC_PI_2, -FRAC_PI_2];
        let mut spans = Vec::new();
        for polygon in &region.polygons {
            let shell = RingSpan::new(&polygon.shell, rule);
            let [mut south, mut north] = shell.latitudes;
            let [holds_south, holds_north] = poles_held(polygon, rule, body, region.inside)[0];
            // As far as the poles it holds, or as far as a hole about the same pole leaves anything.
            let rims = polygon.holes.iter().map(|hole| RingSpan::new(hole, rule));
            let rims = rims.filter(|hole| hole.goes_round && holds_south != holds_north);
            if holds_north {
                let rim = rims.clone().map(|hole| hole.latitudes[1]);
                north = north.max(rim.fold(FRAC_PI_2, f64::min));
            }
            if holds_south {
                let rim = rims.map(|hole| hole.latitudes[0]);
                south = south.min(rim.fold(-FRAC_PI_2, f64::max));
            }
            latitudes = [latitudes[0].min(south), latitudes[1].max(north)];
            let is_round = holds_south || holds_north;
            let width = if is_round { TAU } else { shell.width };
            spans.push((shell.west, width));
        }
        let [west, east] = narrowest(&spans);
        Self {
            west,
            south: latitudes[0],
            east,
            north: latitudes[1],
        }
    }

    pub(crate) fn middle_longitude(&self) -> f64 {
        (self.west + self.east) / 2.0
    }

    /// Whether it goes all the way round; sums of degrees lose a little.
    pub(crate) fn is_round(&self) -> bool {
        self.east - self.west > TAU - 1e-9
    }
}

/// Radians from `from` eastwards to `to`, 0 … 2π.
fn eastwards(from: f64, to: f64) -> f64 {
    (to - from).rem_euclid(TAU)
}

/// The narrowest interval from the western end of one of the spans (west, width) that holds all;
/// −π … π if none leaves a gap.
fn narrowest(spans: &[(f64, f64)]) -> [f64; 2] {
    let mut best = [-PI, PI];
    let mut best_width = TAU - 1e-9;
    for &(west, _) in spans {
        let reach = spans.iter().map(|&(start, width)| {
            let offset = eastwards(west, start);
            // Rounding may make the same place a whole turn.
            let offset = if offset > TAU - 1e-12 { 0.0 } else { offset };
            offset + width
        });
        let width = reach.fold(0.0, f64::max);
        if width < best_width {
            let start = eastwards(-PI, west) - PI;
            best = [start, start + width];
            best_width = width;
        }
    }
    best
}

struct RingSpan {
    west: f64,
    width: f64,
    latitudes: [f64; 2],
    goes_round: bool,
}

impl RingSpan {
    fn new(ring: &Ring, rule: EdgeRule) -> Self {
        let start = ring.vertices_deg()[0][0];
        let mut offset_deg = 0.0;
        let (mut west_deg, mut east_deg) = (0.0_f64, 0.0_f64);
        let mut latitudes = [FRAC_PI_2, -FRAC_PI_2];
        let mut reach = |latitude: f64| {
            latitudes = [latitudes[0].min(latitude), latitudes[1].max(latitude)];
        };
        for (from, to) in ring.edges_deg() {
            let step = to[0] - from[0];
            offset_deg += match rule {
                EdgeRule::Planar => step,
                EdgeRule::GreatEllipse => step - 360.0 * (step / 360.0).round(),
            };
            west_deg = west_deg.min(offset_deg);
            east_deg = east_deg.max(offset_deg);
            reach(from[1].to_radians());
            if rule == EdgeRule::GreatEllipse
                && let Some(latitude) = nearest_to_a_pole(normal(from), normal(to))
            {
                reach(latitude);
            }
        }
        Self {
            west: (start + west_deg).to_radians(),
            width: (east_deg - west_deg).to_radians(),
            latitudes,
            goes_round: offset_deg.abs() > 180.0,
        }
    }
}

fn normal([longitude_deg, latitude_deg]: [f64; 2]) -> DVec3 {
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    let (sin_lat, cos_lat) = latitude_deg.to_radians().sin_cos();
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
}

/// Latitude of the northernmost or southernmost point of the great circle through `a` and `b`, if
/// it lies between them. Normals, since a plane through the centre stays one when the body's axis
/// is scaled until positions are normals.
fn nearest_to_a_pole(a: DVec3, b: DVec3) -> Option<f64> {
    let axis = a.cross(b);
    let top = (DVec3::Z - axis * (axis.z / axis.length_squared())).normalize();
    [top, -top]
        .into_iter()
        .find(|point| a.cross(*point).dot(axis) > 0.0 && point.cross(b).dot(axis) > 0.0)
        .map(|point| point.z.atan2(point.x.hypot(point.y)))
}
