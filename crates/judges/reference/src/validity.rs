// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether a region's rings say one thing of every place: parts apart, holes in their shells and apart.
//!
//! Degrees. The mesher compares areas by parity. Here the winding of each ring is counted round places
//! just inside the others, which parity never sees: two equal holes are wound round twice. Rings that
//! cross are not looked for, and polygons that hold a pole are left to the mesher, since of their rings
//! the larger may be shell or hole.
//!
//! Planar windings count the edges that pass a half-line to the east, signed. Those of great ellipses
//! add up by how much the bearing of a ring's vertices turns, seen from the place.

use crate::point::{LocatorError, normal};
use crate::sides::poles_held;
use glam::DVec3;
use robust::{Coord, orient2d};
use std::f64::consts::{PI, TAU};
use terrafill_core::{EdgeRule, Ellipsoid, Polygon, Region};

/// Places looked at inside each ring: a wrong ring is wrong in most of them.
const PLACES_A_RING: usize = 8;

/// Distances from an edge's middle, shares of its length, farthest first: what two neighbours cover
/// both by rounding, or between an arc and its chord, is narrower than any of them.
const SHARES_ASIDE: [f64; 3] = [0.25, 0.05, 1e-3];

/// A ring, and what its winding is counted by.
struct WoundRing {
    vertices_deg: Vec<[f64; 2]>,
    /// Unit normals, for great ellipses only.
    normals: Vec<DVec3>,
    west_deg: f64,
    east_deg: f64,
    /// Places inside.
    places: Vec<[f64; 2]>,
}

impl WoundRing {
    fn new(vertices_deg: &[[f64; 2]], rule: EdgeRule) -> Self {
        let normals = match rule {
            EdgeRule::Planar => Vec::new(),
            EdgeRule::GreatEllipse => vertices_deg.iter().map(|[x, y]| normal(*x, *y)).collect(),
        };
        let longitudes = || vertices_deg.iter().map(|vertex| vertex[0]);
        let mut ring = Self {
            vertices_deg: vertices_deg.to_vec(),
            normals,
            west_deg: longitudes().fold(f64::INFINITY, f64::min),
            east_deg: longitudes().fold(f64::NEG_INFINITY, f64::max),
            places: Vec::new(),
        };
        ring.places = ring.places_inside();
        ring
    }

    fn places_inside(&self) -> Vec<[f64; 2]> {
        let count = self.vertices_deg.len();
        let step = count.div_ceil(PLACES_A_RING);
        let inside = |vertex: usize| {
            let [a, b] = [vertex, (vertex + 1) % count].map(|i| self.vertices_deg[i]);
            let middle = self.middle(vertex, (vertex + 1) % count);
            let [x, y] = [b[0] - a[0], b[1] - a[1]];
            let aside = SHARES_ASIDE.into_iter().flat_map(|share| [share, -share]);
            aside
                .map(|share| [middle[0] - share * y, middle[1] + share * x])
                .find(|place| place[1].abs() < 90.0 && self.winding(*place) % 2 != 0)
        };
        (0..count).step_by(step).filter_map(inside).collect()
    }

    /// Of an edge, in the turn of its start.
    fn middle(&self, from: usize, to: usize) -> [f64; 2] {
        let [a, b] = [from, to].map(|i| self.vertices_deg[i]);
        if self.normals.is_empty() {
            return [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        }
        let sum = self.normals[from] + self.normals[to];
        let longitude = sum.y.atan2(sum.x).to_degrees();
        let turns = ((a[0] - longitude) / 360.0).round();
        let latitude = sum.z.atan2(sum.x.hypot(sum.y)).to_degrees();
        [longitude + 360.0 * turns, latitude]
    }

    /// How often the ring goes round a place, counter-clockwise positive.
    fn winding(&self, place: [f64; 2]) -> i32 {
        if self.normals.is_empty() {
            // Whole turns that bring the place among the ring's longitudes.
            let first = ((self.west_deg - place[0]) / 360.0).ceil();
            let turned = (0..4).map(|turn| place[0] + 360.0 * (first + f64::from(turn)));
            return turned
                .take_while(|longitude| *longitude <= self.east_deg)
                .map(|longitude| self.planar_winding([longitude, place[1]]))
                .sum();
        }
        self.winding_of_arcs(normal(place[0], place[1]))
    }

    fn planar_winding(&self, place: [f64; 2]) -> i32 {
        let coord = |[x, y]: [f64; 2]| Coord { x, y };
        let next = self.vertices_deg.iter().cycle().skip(1);
        let passes = self.vertices_deg.iter().zip(next).map(|(a, b)| {
            let left = || orient2d(coord(*a), coord(*b), coord(place));
            if a[1] <= place[1] && b[1] > place[1] && left() > 0.0 {
                1
            } else if a[1] > place[1] && b[1] <= place[1] && left() < 0.0 {
                -1
            } else {
                0
            }
        });
        passes.sum()
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "a turn takes three vertices: no more turns than memory has bytes"
    )]
    fn winding_of_arcs(&self, place: DVec3) -> i32 {
        let (east, north) = place.any_orthonormal_pair();
        // Right-handed, seen from outside.
        let north = if east.cross(north).dot(place) < 0.0 {
            -north
        } else {
            north
        };
        let bearing = |vertex: &DVec3| vertex.dot(north).atan2(vertex.dot(east));
        let next = self.normals.iter().cycle().skip(1);
        let turned = self.normals.iter().zip(next).map(|(a, b)| {
            let step = bearing(b) - bearing(a);
            step - TAU * ((step + PI) / TAU).floor()
        });
        (turned.sum::<f64>() / TAU).round() as i32
    }

    fn holds(&self, place: [f64; 2]) -> bool {
        self.winding(place) != 0
    }
}

/// A polygon's rings, the shell first.
struct WoundPolygon {
    part: usize,
    rings: Vec<WoundRing>,
}

impl WoundPolygon {
    /// Whether a place lies in the shell and in no hole.
    fn covers(&self, place: [f64; 2]) -> bool {
        self.rings[0].holds(place) && !self.rings[1..].iter().any(|hole| hole.holds(place))
    }
}

/// Refuses a region of which two rings say two things of one place, unless a repair says which counts.
///
/// # Errors
/// [`LocatorError::Overlap`]
pub(crate) fn check_rings(
    region: &Region,
    rule: EdgeRule,
    body: &Ellipsoid,
) -> Result<(), LocatorError> {
    if region.repaired.is_some() || region.rings().count() < 2 {
        return Ok(());
    }
    let is_plain = |polygon: &Polygon| {
        let held = poles_held(polygon, rule, body, region.inside);
        let turns = polygon.rings().any(|ring| ring.winding_deg() != 0.0);
        !turns && held.iter().all(|poles| *poles == [false; 2])
    };
    let plain = region.polygons.iter().enumerate();
    let plain = plain.filter(|(_, polygon)| is_plain(polygon));
    let polygons: Vec<WoundPolygon> = plain
        .map(|(part, polygon)| WoundPolygon {
            part,
            rings: polygon
                .rings()
                .map(|ring| WoundRing::new(ring.vertices_deg(), rule))
                .collect(),
        })
        .collect();
    for (index, polygon) in polygons.iter().enumerate() {
        check_holes(region, polygon)?;
        for place in &polygon.rings[0].places {
            let in_hole = polygon.rings[1..].iter().any(|hole| hole.holds(*place));
            let mut others = polygons.iter().enumerate();
            let other = others.find(|(other, part)| *other != index && part.covers(*place));
            if let Some((_, other)) = other.filter(|_| !in_hole) {
                let rings = [(polygon.part, 0), (other.part, 0)];
                return Err(overlap(region, rings, "lies over", *place));
            }
        }
    }
    Ok(())
}

/// Each hole's places must be in the shell. Two holes may have none in common, or one may lie in the other.
fn check_holes(region: &Region, polygon: &WoundPolygon) -> Result<(), LocatorError> {
    let [shell, holes @ ..] = &polygon.rings[..] else {
        return Ok(());
    };
    for (index, hole) in holes.iter().enumerate() {
        if let Some(place) = hole.places.iter().find(|place| !shell.holds(**place)) {
            let rings = [(polygon.part, index + 1), (polygon.part, 0)];
            return Err(overlap(region, rings, "is a hole outside of", *place));
        }
        for (before, other) in holes[..index].iter().enumerate() {
            let common = |of: &WoundRing, with: &WoundRing| {
                of.places.iter().filter(|place| with.holds(**place)).count()
            };
            let in_other = common(hole, other);
            let of_other = common(other, hole);
            let is_apart = in_other == 0 && of_other == 0;
            let is_within = in_other == hole.places.len() && of_other == 0;
            let has_within = of_other == other.places.len() && in_other == 0;
            if !(is_apart || is_within || has_within) {
                let rings = [(polygon.part, index + 1), (polygon.part, before + 1)];
                let places = hole.places.iter().chain(&other.places);
                let mut both = places.filter(|place| hole.holds(**place) && other.holds(**place));
                let place = both.next().copied().unwrap_or_default();
                return Err(overlap(region, rings, "is a hole over", place));
            }
        }
    }
    Ok(())
}

fn overlap(
    region: &Region,
    rings: [(usize, usize); 2],
    what: &'static str,
    [longitude_deg, latitude_deg]: [f64; 2],
) -> LocatorError {
    let [place, other] = rings.map(|(part, index)| {
        let ring = region.polygons[part].rings().nth(index);
        let [part, index] = ring.map_or([part, index], |ring| {
            [ring.file_polygon(part), ring.file_ring(index)]
        });
        format!("polygon {part}, ring {index}")
    });
    LocatorError::Overlap {
        place: format!("feature {} ({}), {place}", region.index, region.name),
        what,
        other,
        longitude_deg,
        latitude_deg,
    }
}
