// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far an edge is from the vertices and edges that it stands for, metres.
//!
//! What comes out is never less than the distance (Hausdorff, both ways) between the old edges and
//! the new one, both by their rule. Every old vertex is matched with a place on the new edge; an
//! old edge's points are matched with the places between its ends' matches, which lie on the new
//! edge too, and the distance to the match is largest at an end. The matches of a connected line
//! that starts and ends where the new edge does cover all of it, so the bound holds both ways.

use super::arcs::{Entry, Vertex, metres_per_deg};
use crate::{EdgeRule, Ellipsoid};
use glam::DVec3;

/// Longest edge that may replace others, degrees of longitude or latitude (of arc for great
/// ellipses).
pub(super) const LONGEST_EDGE_DEG: f64 = 30.0;

/// Judges edges on one body by one rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge {
    rule: EdgeRule,
    equator_metres_per_deg: f64,
    /// Metres on the body per radian between its normals are never more: `a²/b`.
    largest_radius_m: f64,
}

impl Judge {
    pub(super) fn new(body: &Ellipsoid, rule: EdgeRule) -> Self {
        Self {
            rule,
            equator_metres_per_deg: metres_per_deg(body, 0.0)[0],
            largest_radius_m: body.equatorial_radius_m().powi(2) / body.polar_radius_m(),
        }
    }

    /// Deviation of the edge between the ends of `chain` from the chain; `None` for an edge too long to be
    /// judged.
    pub(super) fn deviation_m(&self, vertices: &[Vertex], chain: &[Entry]) -> Option<f64> {
        match self.rule {
            EdgeRule::Planar => self.planar_m(chain),
            EdgeRule::GreatEllipse => self.great_ellipse_m(vertices, chain),
        }
    }

    /// Distances in a flat metric in which no step is shorter than it is on the body anywhere
    /// between the chain's southernmost and northernmost latitude: metres per degree of longitude
    /// from where they are most, and of latitude likewise.
    fn planar_m(&self, chain: &[Entry]) -> Option<f64> {
        let (first, last) = (chain.first()?, chain.last()?);
        let [x0, y0] = first.position;
        let span = [last.position[0] - x0, last.position[1] - y0];
        if span.iter().any(|span| span.abs() > LONGEST_EDGE_DEG) {
            return None;
        }
        let mut metres = [0.0_f64; 2];
        let (mut south, mut north) = (f64::INFINITY, f64::NEG_INFINITY);
        for entry in chain {
            metres[0] = metres[0].max(entry.metres_per_deg[0]);
            metres[1] = metres[1].max(entry.metres_per_deg[1]);
            south = south.min(entry.position[1]);
            north = north.max(entry.position[1]);
        }
        if south < 0.0 && north > 0.0 {
            metres[0] = self.equator_metres_per_deg;
        }
        let along = [span[0] * metres[0], span[1] * metres[1]];
        let squared_length = along[0] * along[0] + along[1] * along[1];
        let mut worst = 0.0_f64;
        for entry in chain {
            let from_first = [
                (entry.position[0] - x0) * metres[0],
                (entry.position[1] - y0) * metres[1],
            ];
            let share = if squared_length > 0.0 {
                let dot = from_first[0] * along[0] + from_first[1] * along[1];
                (dot / squared_length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let off = [0, 1].map(|axis| from_first[axis] - share * along[axis]);
            worst = worst.max(off[0] * off[0] + off[1] * off[1]);
        }
        Some(worst.sqrt())
    }

    /// Distances between normals: the body's curvature radii bound what they mean in metres.
    fn great_ellipse_m(&self, vertices: &[Vertex], chain: &[Entry]) -> Option<f64> {
        let normal_of = |entry: &Entry| vertices[entry.vertex as usize].normal;
        let (a, c) = (normal_of(chain.first()?), normal_of(chain.last()?));
        if a.dot(c) < LONGEST_EDGE_DEG.to_radians().cos() {
            return None;
        }
        let plane = a.cross(c - a).normalize_or_zero();
        let (ahead_of_a, behind_c) = (plane.cross(a), c.cross(plane));
        let mut longest = (c - a).length_squared();
        let mut worst = 0.0_f64;
        let mut before = a;
        for entry in chain {
            let p = normal_of(entry);
            longest = longest.max((p - before).length_squared());
            before = p;
            let is_beside = ahead_of_a.dot(p) > 0.0 && behind_c.dot(p) > 0.0;
            let nearest: DVec3 = if is_beside {
                (p - plane * plane.dot(p)).normalize()
            } else if (p - a).length_squared() < (p - c).length_squared() {
                a
            } else {
                c
            };
            worst = worst.max((p - nearest).length_squared());
        }
        // Points between are matched on chords, which lie this deep inside the unit sphere at
        // most; bringing them up to it stretches no more than by the inverse.
        let depth = 1.0 - 0.25 * longest;
        if depth <= 0.5 {
            return None;
        }
        let chord = (worst / depth).sqrt();
        Some(2.0 * (0.5 * chord).min(1.0).asin() * self.largest_radius_m)
    }
}
