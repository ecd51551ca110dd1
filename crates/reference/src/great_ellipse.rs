// SPDX-License-Identifier: MIT OR Apache-2.0
//! Inside tests for a ring whose edges are cut by planes through the body's centre.
//!
//! Unit vectors: geodetic surface normals. Geocentric and geodetic latitude differ by a constant
//! factor of their tangents, which is a linear map of space; it takes planes through the centre to
//! planes through the centre, so in normals every such edge is the shorter arc of a great circle.
//!
//! A ring on a sphere has two sides. It must lie in an open hemisphere, and its inside is what it
//! cuts off there: the side that does not reach the antipode of its centre. Any other ring is
//! refused, since nothing in the file says which side is meant. Two tests:
//!
//! - *Planes*: parity of the arcs crossed on the great circle from the ring's centre through the
//!   point outwards, where nothing is inside any more. Every decision is the exact sign of a
//!   determinant of three vectors (Shewchuk, 1997, by the crate `robust`). A point at the centre
//!   itself is judged from a second centre close by.
//! - *Angles*: the signed solid angles of the triangles between the point's antipode and each
//!   edge. Their sum is the ring's signed area as long as the point is outside, and jumps by 4π
//!   when the point crosses into it; areas below 2π cannot be taken for a jump. Van Oosterom and
//!   Strackee (1983): half the angle is `atan2(det(q, a, b), 1 + q·a + a·b + b·q)`; with `q = −p`
//!   the second argument is `(a − p)·(b − p)`, free of cancellation for short edges.

use crate::locator::{Bounds, LocatorError, Point, RingSource, Verdicts, normal};
use crate::slabs::Slabs;
use glam::DVec3;
use robust::{Coord3D, orient3d};
use std::f64::consts::PI;

/// Closer to the centre than this (6 m on the Earth), directions seen from it are no longer good
/// enough to choose a slab by.
const AT_CENTER: f64 = 1e-6;

/// Directions seen from the centre are good to 1e-16 / [`AT_CENTER`]; this is ten times that.
const AZIMUTH_MARGIN_RAD: f64 = 1e-9;

/// A ring reaching closer than this to the rim of its hemisphere is refused: its area comes too
/// near to 2π to be told from a jump, and arcs become ambiguous.
const SMALLEST_COSINE: f64 = 1e-4;

/// Steps towards the smallest cap; the error of the centre shrinks as their inverse. A cap a few
/// percent too large only costs time.
const CENTER_STEPS: u32 = 30;

/// Steps before a ring is said to lie in no hemisphere.
const CENTER_STEPS_AT_MOST: u32 = 400;

/// Rounding of a dot product of unit vectors, with room.
const DOT_MARGIN: f64 = 1e-14;

/// A direction that lies in no plane of borders that people draw.
const TIE_BREAKER: DVec3 = DVec3::new(0.314_159_265_3, 0.577_215_664_9, 0.753_784_612_1);

/// A ring with an index for each of the two tests.
#[derive(Debug, Clone)]
pub(crate) struct GreatEllipseRing {
    /// First vertex repeated at the end.
    vertices: Vec<DVec3>,
    center: Center,
    /// Stands in for `center` close to it.
    second_center: DVec3,
    /// Edges by the direction in which they lie, seen from the centre.
    by_azimuth: Slabs,
    /// Halves of halves of the ring; the last one is the whole.
    chains: Vec<Chain>,
    bounds: Bounds,
}

/// Centre of a cap that holds the ring, and two directions to take azimuths by.
#[derive(Debug, Clone, Copy)]
struct Center {
    at: DVec3,
    axes: [DVec3; 2],
    /// Smallest cosine of the angle to a vertex. Arcs between points of a cap smaller than a
    /// hemisphere stay in the cap, so no part of the ring or its inside is farther out.
    cos_radius: f64,
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

impl GreatEllipseRing {
    /// # Errors
    /// [`LocatorError::NotInAHemisphere`].
    pub(crate) fn new(source: &RingSource<'_>) -> Result<Self, LocatorError> {
        let mut vertices: Vec<DVec3> = source
            .vertices_deg
            .iter()
            .map(|vertex| normal(vertex[0], vertex[1]))
            .collect();
        let center = Center::of(&vertices);
        if center.cos_radius < SMALLEST_COSINE {
            return Err(source.hemisphere_error(
                center.cos_radius.clamp(-1.0, 1.0).acos().to_degrees(),
                SMALLEST_COSINE.acos().to_degrees(),
            ));
        }
        vertices.extend(vertices.first().copied());
        let mut chains = Vec::new();
        build_chain(&vertices, 0, vertices.len() - 1, &mut chains);
        Ok(Self {
            by_azimuth: center.index(&vertices),
            bounds: center.bounds(),
            // Moved by less than the ring is away from the rim, so still a centre.
            second_center: (center.at + center.axes[0] * (1e-3 * center.cos_radius)).normalize(),
            vertices,
            center,
            chains,
        })
    }

    /// Nothing of the ring's inside lies beyond.
    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Both tests, by the index.
    pub(crate) fn holds(&self, point: &Point) -> Verdicts {
        let p = point.normal;
        if p.dot(self.center.at) < self.center.cos_radius - DOT_MARGIN {
            return Verdicts::default();
        }
        let center = self.center_for(p);
        let first = if center == self.center.at {
            let near = self.by_azimuth.at(self.center.azimuth(p));
            self.parity(center, p, near.iter().map(|&edge| edge as usize))
        } else {
            self.parity(center, p, 0..self.vertices.len() - 1)
        };
        let angle = self
            .chains
            .len()
            .checked_sub(1)
            .map_or(0.0, |all| self.angle(all, p));
        Verdicts {
            first,
            second: winds(angle),
        }
    }

    /// Both tests over every edge.
    #[cfg(test)]
    pub(crate) fn holds_brute(&self, point: &Point) -> Verdicts {
        let p = point.normal;
        let edges = 0..self.vertices.len() - 1;
        let angles = edges
            .clone()
            .map(|i| angle(self.vertices[i], self.vertices[i + 1], p));
        let in_hemisphere = p.dot(self.center.at) > 0.0;
        Verdicts {
            second: winds(angles.sum()),
            first: in_hemisphere && self.parity(self.center_for(p), p, edges),
        }
    }

    /// The centre to judge `p` from.
    fn center_for(&self, p: DVec3) -> DVec3 {
        if (p - self.center.at).length() < AT_CENTER {
            self.second_center
        } else {
            self.center.at
        }
    }

    /// Whether the way from `p` away from `center` crosses an odd number of `edges`.
    ///
    /// As in a plane with `center` as its origin, which the hemisphere is in central projection:
    /// an edge with its ends on different sides of the line is crossed beyond `p` when `p` lies on
    /// the left of an edge that passes from right to left.
    fn parity(&self, center: DVec3, p: DVec3, edges: impl Iterator<Item = usize>) -> bool {
        let mut odd = false;
        for i in edges {
            let (a, b) = (self.vertices[i], self.vertices[i + 1]);
            let a_is_left = side_of(center, a, p) <= 0.0;
            let b_is_left = side_of(center, b, p) <= 0.0;
            if a_is_left != b_is_left {
                let side = side_of(a, b, p);
                odd ^= if b_is_left { side > 0.0 } else { side < 0.0 };
            }
        }
        odd
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
}

impl Center {
    /// Centre of nearly the smallest cap: from the mean, a step towards whatever vertex is
    /// farthest, each step shorter (Bădoiu and Clarkson, 2003).
    fn of(vertices: &[DVec3]) -> Self {
        let farthest = |at: DVec3| {
            vertices
                .iter()
                .copied()
                .min_by(|a, b| a.dot(at).total_cmp(&b.dot(at)))
                .unwrap_or(at)
        };
        let sum: DVec3 = vertices.iter().copied().sum();
        let mut at = sum.try_normalize().unwrap_or(DVec3::Z);
        let mut best = (at, farthest(at).dot(at));
        for step in 1..=CENTER_STEPS_AT_MOST {
            if step > CENTER_STEPS && best.1 >= SMALLEST_COSINE {
                break;
            }
            let towards = farthest(at);
            at = (at + (towards - at) / f64::from(step + 1))
                .try_normalize()
                .unwrap_or(at);
            let cos_radius = farthest(at).dot(at);
            if cos_radius > best.1 {
                best = (at, cos_radius);
            }
        }
        let (at, cos_radius) = best;
        let east = at.any_orthonormal_vector();
        Self {
            at,
            axes: [east, at.cross(east)],
            cos_radius,
        }
    }

    fn azimuth(&self, v: DVec3) -> f64 {
        v.dot(self.axes[1]).atan2(v.dot(self.axes[0]))
    }

    /// Edges by azimuth. Those that pass so close by the centre that it is doubtful on which side
    /// of it are entered everywhere.
    fn index(&self, vertices: &[DVec3]) -> Slabs {
        let mut intervals = Vec::new();
        for (pair, item) in vertices.windows(2).zip(0_u32..) {
            let (a, b) = (self.azimuth(pair[0]), self.azimuth(pair[1]));
            let turn = (b - a + PI).rem_euclid(2.0 * PI) - PI;
            let is_doubtful = turn.abs() > PI - 1e-3
                || pair
                    .iter()
                    .any(|vertex| (*vertex - self.at).length() < AT_CENTER);
            if is_doubtful {
                intervals.push((item, -PI, PI));
                continue;
            }
            let low = a.min(a + turn) - AZIMUTH_MARGIN_RAD;
            let high = a.max(a + turn) + AZIMUTH_MARGIN_RAD;
            for shift in [-2.0 * PI, 0.0, 2.0 * PI] {
                if low + shift <= PI && high + shift >= -PI {
                    intervals.push((item, low + shift, high + shift));
                }
            }
        }
        Slabs::new(-PI, PI, &intervals)
    }

    /// Longitudes and latitudes of the cap.
    fn bounds(&self) -> Bounds {
        // A cosine near 1 says little about a small angle; its rounding is 1e-8 rad at most.
        let radius = (self.cos_radius - DOT_MARGIN).clamp(-1.0, 1.0).acos() + 1e-8;
        let latitude = self.at.z.atan2(self.at.x.hypot(self.at.y));
        let longitude = self.at.y.atan2(self.at.x);
        let reach = if latitude.abs() + radius < PI / 2.0 {
            (radius.sin() / latitude.cos()).clamp(-1.0, 1.0).asin() + 1e-8
        } else {
            PI
        };
        Bounds {
            west: (longitude - reach).to_degrees(),
            south: (latitude - radius).to_degrees().max(-90.0),
            east: (longitude + reach).to_degrees(),
            north: (latitude + radius).to_degrees().min(90.0),
        }
    }
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
/// Where it is 0, `p` counts as moved by next to nothing towards [`TIE_BREAKER`]. All rings see the
/// same move, so a place on a border or a vertex belongs to exactly one of those that meet there
/// (Edelsbrunner and Mücke, 1990, "Simulation of Simplicity").
fn side_of(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    let sign = exact_sign(a, b, p);
    if sign == 0.0 {
        exact_sign(a, b, TIE_BREAKER)
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

/// Whether a sum of solid angles is an odd number of jumps away from an area below 2π.
fn winds(angle: f64) -> bool {
    (angle / (4.0 * PI)).round().rem_euclid(2.0) == 1.0
}
