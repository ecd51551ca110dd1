// SPDX-License-Identifier: MIT OR Apache-2.0
//! Inside tests for a ring whose edges are cut by planes through the body's centre.
//!
//! Unit vectors: geodetic surface normals. Geocentric and geodetic latitude differ by a constant
//! factor of their tangents, which is a linear map of space. It takes planes through the centre to
//! planes through the centre, so in normals every such edge is the shorter arc of a great circle.
//!
//! A ring on a sphere has two sides; which poles are inside is decided by `sides`. An edge between
//! opposite meridians passes through the nearer pole. A ring with a vertex there passes it on the side of the smaller
//! angle between its neighbours, and on longitudes −180 … 180, the latter excluded, where both angles
//! are 180°. So a pole is never on a ring, and its side is known. Two tests:
//!
//! - *Meridian*: parity of the arcs crossed on the way from the point south to the pole. Which arcs span its meridian
//!   is said by longitudes on a grid, exactly. Whether the point is north of such an arc is said by the exact sign of
//!   a determinant of three vectors (Shewchuk, 1997, by the crate `robust`). Spans are half-open, so a vertex between
//!   two of them counts once.
//! - *Angles*: the signed solid angles of the triangles between the point's antipode and each
//!   edge. Their sum is the ring's signed area, modulo 4π, and jumps by 4π wherever the point
//!   crosses the ring; so it tells the point's side from that of a pole. Van Oosterom and Strackee
//!   (1983): half the angle is `atan2(det(q, a, b), 1 + q·a + a·b + b·q)`. With `q = −p` the second
//!   argument is `(a − p)·(b − p)`, free of cancellation for short edges.

use crate::point::{
    Bounds, LocatorError, Point, RingCourse, RingSource, Verdicts, normal, on_longitude_grid,
};
use crate::slabs::Slabs;
use glam::DVec3;
use robust::{Coord3D, orient3d};
use std::f64::consts::{FRAC_PI_2, PI};
use terrafill_core::{Ellipsoid, NEARLY_OPPOSITE_RAD};

/// Closer than this to the ring (6 mm on the Earth), a pole is no place to compare angles with.
const AT_POLE: f64 = 1e-9;

/// Places to compare angles with where both poles are on the ring.
const OTHER_PLACES: u32 = 32;

/// Rounding of a dot product of unit vectors, with room.
const DOT_MARGIN: f64 = 1e-14;

/// Rounding of the northernmost and southernmost latitude of an arc, with room.
const LATITUDE_MARGIN_DEG: f64 = 1e-6;

/// Slope that borders have that nobody draws.
const TIE_SLOPE: f64 = 0.754_877_666_2;

/// Longitude that a pole is looked at from: no border that people draw runs along it.
const LONGITUDE_AT_POLES_DEG: f64 = 61.442_342;

/// A ring with an index for each of the two tests.
#[derive(Debug, Clone)]
pub(crate) struct GreatEllipseRing {
    /// First vertex repeated at the end.
    vertices: Vec<DVec3>,
    /// What the way south may cross.
    spans: Vec<Span>,
    /// Spans by longitude.
    by_longitude: Slabs,
    south_pole_is_inside: bool,
    /// Halves of halves of the ring; the last one is the whole.
    chains: Vec<Chain>,
    /// Sum of angles at a place, and whether that is inside.
    compared_with: (f64, bool),
    bounds: Bounds,
}

/// Longitudes that a part of a ring spans, from `west_deg` (included) to the east (excluded).
#[derive(Debug, Clone, Copy)]
struct Span {
    /// −180 ≤ `west_deg` < 180.
    west_deg: f64,
    /// 0 … 180.
    width_deg: f64,
    /// Whether the ring passes from west to east.
    is_eastward: bool,
    part: SpanPart,
}

#[derive(Debug, Clone, Copy)]
enum SpanPart {
    /// From west to east.
    Arc([DVec3; 2]),
    /// Past the north pole, north of everything.
    NorthPole,
    /// Past the south pole, south of everything.
    SouthPole,
}

/// Consecutive edges, from vertex `start` to vertex `end`.
///
/// Outside of a cap that holds them, the edges count like the one arc from start to end plus the
/// area between the two, which is known beforehand. So a point far from most of a ring needs few
/// of its edges.
#[derive(Debug, Clone, Copy)]
struct Chain {
    start: usize,
    end: usize,
    cap_center: DVec3,
    /// At most 0 when the chain reaches farther than a hemisphere, so that no point is outside.
    cos_radius: f64,
    /// Signed area between the edges and the arc from end back to start.
    area: f64,
    /// Indices of the two halves; `None` for a single edge.
    halves: Option<[usize; 2]>,
}

/// How a ring lies round the axis; `None` where opposite ends leave open how it lies.
///
/// - `of_any`: also of one that lies within half a turn of longitude, which is `None` otherwise
pub(crate) fn course(
    vertices_deg: &[[f64; 2]],
    of_any: bool,
    body: &Ellipsoid,
) -> Option<RingCourse> {
    let corners = corners_of(vertices_deg).ok()?;
    let course = Course::along(&corners);
    let [west, east] = course.reach_deg;
    if east - west < 180.0 && !of_any {
        return None;
    }
    let turned_deg: f64 = course.spans.iter().map(Span::step_deg).sum();
    Some(RingCourse {
        turns: whole_turns(turned_deg),
        above_equator_m2: course
            .spans
            .iter()
            .map(|span| span.above_equator_m2(body))
            .sum(),
    })
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a turn takes three vertices: no more turns than memory has bytes"
)]
fn whole_turns(turned_deg: f64) -> i32 {
    (turned_deg / 360.0).round() as i32
}

impl GreatEllipseRing {
    /// # Errors
    /// [`LocatorError::OppositeEnds`].
    pub(crate) fn new(source: &RingSource<'_>) -> Result<Self, LocatorError> {
        let corners =
            corners_of(source.vertices_deg).map_err(|vertex| source.opposite_error(vertex))?;
        let mut vertices: Vec<DVec3> = corners.iter().map(|corner| corner.normal).collect();
        vertices.extend(vertices.first().copied());
        let course = Course::along(&corners);
        let [south_pole_is_inside, north_pole_is_inside] = source.holds_poles;
        let mut chains = Vec::new();
        if vertices.len() > 1 {
            build_chain(&vertices, 0, vertices.len() - 1, &mut chains);
        }
        let mut ring = Self {
            by_longitude: index(&course.spans),
            bounds: bounds_of(
                &course,
                &vertices,
                south_pole_is_inside,
                north_pole_is_inside,
            ),
            spans: course.spans,
            south_pole_is_inside,
            chains,
            compared_with: (0.0, false),
            vertices,
        };
        ring.compared_with = ring.place_to_compare_with(north_pole_is_inside);
        Ok(ring)
    }

    /// Nothing of the ring's inside lies beyond.
    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Both tests, by the index.
    pub(crate) fn holds(&self, point: &Point) -> Verdicts {
        let latitude_deg = point.latitude_deg;
        if latitude_deg < self.bounds.south || latitude_deg > self.bounds.north {
            return Verdicts::default();
        }
        let longitude_deg = longitude_of(point);
        let near = self.by_longitude.at(longitude_deg).iter();
        let near = near.map(|&span| &self.spans[span as usize]);
        Verdicts {
            first: self.parity(longitude_deg, point.normal, near),
            second: self.is_inside_by(self.sum_of_angles(point.normal)),
        }
    }

    /// Both tests over every edge.
    #[cfg(test)]
    pub(crate) fn holds_brute(&self, point: &Point) -> Verdicts {
        let pairs = self.vertices.windows(2);
        let angles = pairs.map(|pair| angle(pair[0], pair[1], point.normal));
        Verdicts {
            first: self.parity(longitude_of(point), point.normal, self.spans.iter()),
            second: self.is_inside_by(angles.sum()),
        }
    }

    /// Whether `p` is inside, by the parts of the ring between it and the south pole.
    fn parity<'a>(
        &self,
        longitude_deg: f64,
        p: DVec3,
        spans: impl Iterator<Item = &'a Span>,
    ) -> bool {
        let is_crossed = |span: &&Span| {
            span.holds(longitude_deg)
                && match span.part {
                    SpanPart::Arc([west, east]) => side_of(west, east, p) > 0.0,
                    SpanPart::NorthPole => false,
                    SpanPart::SouthPole => true,
                }
        };
        self.south_pole_is_inside != (spans.filter(is_crossed).count() % 2 == 1)
    }

    /// Whether a place with this sum of angles is inside.
    fn is_inside_by(&self, sum: f64) -> bool {
        let (sum_there, is_inside_there) = self.compared_with;
        let jumps = ((sum - sum_there) / (4.0 * PI)).round();
        is_inside_there != (jumps.rem_euclid(2.0) == 1.0)
    }

    fn sum_of_angles(&self, p: DVec3) -> f64 {
        let whole = self.chains.len().checked_sub(1);
        whole.map_or(0.0, |whole| self.angle(whole, p))
    }

    /// Sum of the solid angles of a chain seen from the antipode of `p`.
    fn angle(&self, chain: usize, p: DVec3) -> f64 {
        let chain = &self.chains[chain];
        let is_outside =
            chain.cos_radius > 0.0 && p.dot(chain.cap_center) < chain.cos_radius - DOT_MARGIN;
        match chain.halves {
            Some([first, second]) if !is_outside => self.angle(first, p) + self.angle(second, p),
            _ => chain.area + angle(self.vertices[chain.start], self.vertices[chain.end], p),
        }
    }

    /// The pole farther from the ring, whose side is known; where the ring passes both, whatever
    /// place is far from it, by the first test.
    fn place_to_compare_with(&self, north_pole_is_inside: bool) -> (f64, bool) {
        let (south, north) = (DVec3::NEG_Z, DVec3::Z);
        let (from_south, from_north) = (self.distance(south), self.distance(north));
        if from_south.max(from_north) > AT_POLE {
            return if from_south > from_north {
                (self.sum_of_angles(south), self.south_pole_is_inside)
            } else {
                (self.sum_of_angles(north), north_pole_is_inside)
            };
        }
        let golden_turn = (5_f64.sqrt() - 1.0) / 2.0;
        let places = (0..OTHER_PLACES).filter_map(|i| {
            let z = (f64::from(i) + 0.5) / f64::from(OTHER_PLACES) * 2.0 - 1.0;
            let longitude_deg = 360.0 * (f64::from(i) * golden_turn).fract();
            Point::new(longitude_deg, z.asin().to_degrees())
        });
        let distance = |point: &Point| self.distance(point.normal);
        let farthest = places.max_by(|a, b| distance(a).total_cmp(&distance(b)));
        farthest.map_or((0.0, false), |point| {
            let is_inside = self.parity(longitude_of(&point), point.normal, self.spans.iter());
            (self.sum_of_angles(point.normal), is_inside)
        })
    }

    /// Chord or angle from `q` to the nearest place of the ring: good enough to choose by.
    fn distance(&self, q: DVec3) -> f64 {
        let to_arc = |pair: &[DVec3]| {
            let (a, b) = (pair[0], pair[1]);
            let n = a.cross(b - a);
            if n.cross(a).dot(q) > 0.0 && n.cross(b).dot(q) < 0.0 {
                (n.dot(q) / n.length()).abs()
            } else {
                q.distance(a).min(q.distance(b))
            }
        };
        self.vertices
            .windows(2)
            .map(to_arc)
            .fold(f64::INFINITY, f64::min)
    }
}

impl Span {
    /// From one corner to the next, perhaps over a `pole`, and how far east that leads: between
    /// the two numbers, or the other way round the axis should that be shorter.
    fn between(from: &Corner, to: &Corner, pole: Option<&Corner>) -> (Option<Self>, f64) {
        let step_deg = to.longitude_deg - from.longitude_deg;
        let step_deg = if step_deg.abs() > 180.0 {
            step_deg - 360.0_f64.copysign(step_deg)
        } else {
            step_deg
        };
        let (west, east) = if step_deg > 0.0 {
            (from, to)
        } else {
            (to, from)
        };
        let span = Self {
            west_deg: west_of_180(west.longitude_deg),
            width_deg: step_deg.abs(),
            is_eastward: step_deg > 0.0,
            part: match pole {
                None => SpanPart::Arc([west.normal, east.normal]),
                Some(pole) if pole.latitude_deg < 0.0 => SpanPart::SouthPole,
                Some(_) => SpanPart::NorthPole,
            },
        };
        ((step_deg != 0.0).then_some(span), step_deg)
    }

    fn step_deg(&self) -> f64 {
        if self.is_eastward {
            self.width_deg
        } else {
            -self.width_deg
        }
    }

    /// Signed area between the equator and this part of the ring.
    fn above_equator_m2(&self, body: &Ellipsoid) -> f64 {
        let hemisphere_m2 = body.zone_area_per_radian(FRAC_PI_2);
        let on_the_way_east = match self.part {
            SpanPart::Arc([west, east]) => arc_above_equator_m2(west, east, body),
            SpanPart::NorthPole => self.width_deg.to_radians() * hemisphere_m2,
            SpanPart::SouthPole => -self.width_deg.to_radians() * hemisphere_m2,
        };
        if self.is_eastward {
            on_the_way_east
        } else {
            -on_the_way_east
        }
    }

    fn holds(&self, longitude_deg: f64) -> bool {
        let east_of_west = longitude_deg - self.west_deg;
        let turn = if east_of_west < 0.0 { 360.0 } else { 0.0 };
        east_of_west + turn < self.width_deg
    }
}

/// A vertex of a ring.
#[derive(Debug, Clone, Copy)]
struct Corner {
    /// −180 … 180, 180 excluded, on the grid of [`on_longitude_grid`].
    longitude_deg: f64,
    latitude_deg: f64,
    normal: DVec3,
}

impl Corner {
    fn new([longitude_deg, latitude_deg]: [f64; 2]) -> Self {
        let turns = (longitude_deg / 360.0).round();
        Self {
            longitude_deg: west_of_180(on_longitude_grid(longitude_deg - 360.0 * turns)),
            latitude_deg,
            normal: normal(longitude_deg, latitude_deg),
        }
    }

    fn is_pole(&self) -> bool {
        self.latitude_deg.abs() == 90.0
    }
}

/// What a ring spans, in its order.
struct Course {
    spans: Vec<Span>,
    /// Longitudes reached without a jump, from west to east.
    reach_deg: [f64; 2],
}

impl Course {
    fn along(corners: &[Corner]) -> Self {
        let mut course = Self {
            spans: Vec::with_capacity(corners.len()),
            reach_deg: [0.0; 2],
        };
        // A ring that never leaves its pole spans nothing.
        let Some(first) = corners.iter().position(|corner| !corner.is_pole()) else {
            return course;
        };
        let mut from = &corners[first];
        let mut at_deg = from.longitude_deg;
        course.reach_deg = [at_deg; 2];
        let mut pole = None;
        for to in corners[first + 1..].iter().chain(&corners[..=first]) {
            if to.is_pole() {
                pole = Some(to);
                continue;
            }
            let (span, step_deg) = Span::between(from, to, pole.take());
            at_deg += step_deg;
            let [west, east] = course.reach_deg;
            course.reach_deg = [west.min(at_deg), east.max(at_deg)];
            course.spans.extend(span);
            from = to;
        }
        course
    }
}

/// A ring's vertices, and the poles that its edges pass through.
///
/// # Errors
/// The vertex at which an edge between opposite places starts: any plane through them will do.
fn corners_of(vertices_deg: &[[f64; 2]]) -> Result<Vec<Corner>, usize> {
    let mut corners = Vec::with_capacity(vertices_deg.len());
    let next = vertices_deg.iter().cycle().skip(1);
    for (vertex, (from, to)) in vertices_deg.iter().zip(next).enumerate() {
        let (from, to) = (Corner::new(*from), Corner::new(*to));
        corners.push(from);
        let is_meridional = (to.longitude_deg - from.longitude_deg).abs() == 180.0;
        let sum_deg = from.latitude_deg + to.latitude_deg;
        match (from.is_pole(), to.is_pole()) {
            (false, false) if is_nearly_opposite(&from, &to) => return Err(vertex),
            (false, false) if is_meridional && sum_deg != 0.0 => {
                corners.push(Corner::new([0.0, 90.0_f64.copysign(sum_deg)]));
            }
            (true, true) if sum_deg == 0.0 => return Err(vertex),
            _ => {}
        }
    }
    Ok(corners)
}

/// By the angle from one end to the antipode of the other.
fn is_nearly_opposite(from: &Corner, to: &Corner) -> bool {
    let (ahead, behind) = (from.normal, to.normal);
    ahead.cross(behind).length().atan2(-ahead.dot(behind)) < NEARLY_OPPOSITE_RAD
}

/// The antimeridian has one number only.
fn west_of_180(longitude_deg: f64) -> f64 {
    if longitude_deg == 180.0 {
        -180.0
    } else {
        longitude_deg
    }
}

/// −180 included, 180 excluded.
fn longitude_of(point: &Point) -> f64 {
    if point.normal.x == 0.0 && point.normal.y == 0.0 {
        on_longitude_grid(LONGITUDE_AT_POLES_DEG)
    } else {
        west_of_180(point.longitude_deg)
    }
}

fn index(spans: &[Span]) -> Slabs {
    let mut intervals = Vec::with_capacity(spans.len());
    for (span, item) in spans.iter().zip(0_u32..) {
        let east_deg = span.west_deg + span.width_deg;
        intervals.push((item, span.west_deg, east_deg.min(180.0)));
        if east_deg > 180.0 {
            intervals.push((item, -180.0, east_deg - 360.0));
        }
    }
    Slabs::new(-180.0, 180.0, &intervals)
}

/// Longitudes and latitudes of the inside: without a pole in it, it lies between those of the ring.
fn bounds_of(
    course: &Course,
    vertices: &[DVec3],
    south_pole_is_inside: bool,
    north_pole_is_inside: bool,
) -> Bounds {
    let Some(first) = vertices.first() else {
        return Bounds::EMPTY;
    };
    let latitude_deg = |z: f64| z.clamp(-1.0, 1.0).asin().to_degrees();
    let (mut south, mut north) = (first.z, first.z);
    for pair in vertices.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        south = south.min(b.z);
        north = north.max(b.z);
        // The plane's farthest place from the equator, if it is between the ends.
        let n = a.cross(b - a);
        let top = (1.0 - (n.z / n.length()).powi(2)).max(0.0).sqrt();
        let (rises_at_a, rises_at_b) = (n.cross(a).z > 0.0, n.cross(b).z > 0.0);
        match (rises_at_a, rises_at_b) {
            (true, false) => north = north.max(top),
            (false, true) => south = south.min(-top),
            _ => {}
        }
    }
    let goes_round = south_pole_is_inside || north_pole_is_inside;
    let [west, east] = if goes_round {
        [-180.0, 180.0]
    } else {
        course.reach_deg
    };
    let south = latitude_deg(south) - LATITUDE_MARGIN_DEG;
    let north = latitude_deg(north) + LATITUDE_MARGIN_DEG;
    Bounds {
        west,
        south: if south_pole_is_inside {
            -90.0
        } else {
            south.max(-90.0)
        },
        east,
        north: if north_pole_is_inside {
            90.0
        } else {
            north.min(90.0)
        },
    }
}

/// Signed area between the equator and the arc from `a` to `b`, for unit normals.
///
/// Along an arc `x dy − y dx` is the same everywhere, the polar component of its plane's normal, and
/// longitude changes by that over `x² + y²`. What is left between the arc and the nearer pole, over
/// `x² + y²`, is smooth, and Simpson's rule integrates it even past a pole.
fn arc_above_equator_m2(a: DVec3, b: DVec3, body: &Ellipsoid) -> f64 {
    if a.z * b.z < 0.0 {
        let middle = (a * b.z.abs() + b * a.z.abs()).normalize();
        let middle = DVec3::new(middle.x, middle.y, 0.0);
        return arc_above_equator_m2(a, middle, body) + arc_above_equator_m2(middle, b, body);
    }
    /// An error of 1e-13.
    const STEP_RAD: f64 = 0.004;
    let normal = a.cross(b - a);
    let angle = 2.0 * (0.5 * a.distance(b)).min(1.0).asin();
    if angle == 0.0 || normal.length_squared() == 0.0 {
        return 0.0;
    }
    let steps = (angle / STEP_RAD).ceil().max(1.0);
    let to_pole = |step: f64| {
        let share = step / steps;
        let place = a * ((1.0 - share) * angle).sin() + b * (share * angle).sin();
        zone_to_pole_m2(place.normalize().z.abs(), body)
    };
    let (mut sum, mut step) = (0.0, 0.0);
    while step < steps {
        sum += to_pole(step) + 4.0 * to_pole(step + 0.5) + to_pole(step + 1.0);
        step += 1.0;
    }
    let to_pole_m2 = normal.z / normal.length() * angle * sum / (6.0 * steps);
    let width_rad = (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y);
    let above_m2 = width_rad * body.zone_area_per_radian(FRAC_PI_2) - to_pole_m2;
    if a.z + b.z < 0.0 { -above_m2 } else { above_m2 }
}

/// Area between a latitude of sine `s`, at least 0, and its pole per radian of longitude, over
/// `1 − s²`, without cancellation.
fn zone_to_pole_m2(s: f64, body: &Ellipsoid) -> f64 {
    let e2 = body.eccentricity_squared();
    let rational = (1.0 + e2 * s) / ((1.0 - e2) * (1.0 - e2 * s * s));
    let u = e2.sqrt() * (1.0 - s) / (1.0 - e2 * s);
    let artanh_over_u = if u < 1e-9 { 1.0 } else { u.atanh() / u };
    let half_b2 = 0.5 * body.polar_radius_m() * body.polar_radius_m();
    half_b2 * (rational + artanh_over_u / (1.0 - e2 * s)) / (1.0 + s)
}

/// Appends the chain from `start` to `end`, its halves before it, and returns its index.
fn build_chain(vertices: &[DVec3], start: usize, end: usize, chains: &mut Vec<Chain>) -> usize {
    let part = &vertices[start..=end];
    let cap_center = part
        .iter()
        .copied()
        .sum::<DVec3>()
        .try_normalize()
        .unwrap_or(DVec3::Z);
    let cos_radius = part.iter().map(|v| v.dot(cap_center)).fold(1.0, f64::min);
    let (halves, area) = if end - start == 1 {
        (None, 0.0)
    } else {
        let middle = usize::midpoint(start, end);
        let first = build_chain(vertices, start, middle, chains);
        let second = build_chain(vertices, middle, end, chains);
        let between = area(vertices[start], vertices[middle], vertices[end]);
        (
            Some([first, second]),
            chains[first].area + chains[second].area + between,
        )
    };
    chains.push(Chain {
        start,
        end,
        cap_center,
        cos_radius,
        area,
        halves,
    });
    chains.len() - 1
}

/// Sign of `det(a, b, p)`: positive when `p` lies on the left of the way from `a` to `b`.
///
/// Where it is 0, `p` counts as moved by next to nothing eastwards, as it does among half-open
/// spans, and by [`TIE_SLOPE`] times as much to the north. All rings see the same move, so a place
/// on a border or a vertex belongs to exactly one of those that meet there (Edelsbrunner and Mücke,
/// 1990, "Simulation of Simplicity").
fn side_of(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    let sign = exact_sign(a, b, p);
    if sign == 0.0 {
        exact_sign(a, b, DVec3::new(-p.y, p.x, TIE_SLOPE))
    } else {
        sign
    }
}

/// Sign of `det(a, b, c)`, exact for the numbers given.
fn exact_sign(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let coordinate = |v: DVec3| Coord3D {
        x: v.x,
        y: v.y,
        z: v.z,
    };
    orient3d(
        coordinate(a),
        coordinate(b),
        coordinate(c),
        coordinate(DVec3::ZERO),
    )
}

/// Signed solid angle of the triangle between the antipode of `p` and the arc from `a` to `b`.
fn angle(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    // det(a, b, p) from differences: short edges lose nothing.
    let determinant = a.dot((b - a).cross(p - a));
    2.0 * (-determinant).atan2((a - p).dot(b - p))
}

/// Signed area of the triangle `a`, `b`, `c`; counter-clockwise from outside is positive.
fn area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let determinant = a.dot((b - a).cross(c - a));
    2.0 * determinant.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
