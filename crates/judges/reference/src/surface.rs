// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays from the eye against the surface's triangles as drawn.
//!
//! Metres relative to the eye, ECEF axes; the vertices are the f32 values that the GPU reads,
//! widened without loss. A ray starts at the origin, and its direction has length 1 along the
//! viewing axis, so its parameter is the view depth.
//!
//! Whether a ray meets a triangle is decided by the exact signs of three determinants (Shewchuk,
//! 1997, by the crate `robust`). Two triangles with a common edge see the same number there with
//! opposite sign, and 0 counts as met by both: no ray falls through between them. A tree of boxes
//! (median split on the longest axis) only says which triangles to ask.

use glam::DVec3;
use robust::{Coord3D, orient3d};
use terrafill_surface::SurfaceFrame;

/// Triangles in a leaf.
const LEAF_SIZE: usize = 4;

/// Box distances are compared with this much to spare, a few thousand times their rounding.
const BOX_MARGIN: f64 = 1e-12;

/// Triangles seen from the eye, ready for rays.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceTriangles {
    triangles: Vec<[DVec3; 3]>,
    /// The first one holds all.
    nodes: Vec<Node>,
    non_finite: u64,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Range of triangles.
    first: usize,
    last: usize,
    /// Indices of the two halves; `None` in a leaf.
    halves: Option<[usize; 2]>,
}

impl SurfaceTriangles {
    /// Triangles with a NaN or infinite corner cannot be met; they are counted instead.
    pub(crate) fn new(frame: &SurfaceFrame) -> Self {
        let vertices = &frame.vertices_rte;
        let corner = |index: u32| DVec3::from(vertices[index as usize].map(f64::from));
        let mut all: Vec<[DVec3; 3]> = frame.triangles.iter().map(|ids| ids.map(corner)).collect();
        let count = all.len();
        all.retain(|corners| corners.iter().all(|corner| corner.is_finite()));
        let non_finite = (count - all.len()) as u64;
        let mut nodes = Vec::new();
        let last = all.len();
        if last > 0 {
            build(&mut all, 0, last, &mut nodes);
        }
        Self {
            triangles: all,
            nodes,
            non_finite,
        }
    }

    /// Triangles left out because a corner is NaN or infinite.
    pub(crate) fn non_finite(&self) -> u64 {
        self.non_finite
    }

    /// View depth of the nearest hit not closer than `near_m`.
    pub(crate) fn hit(&self, direction: DVec3, near_m: f64) -> Option<f64> {
        let ray = Ray::new(direction);
        let mut nearest = f64::INFINITY;
        let mut pending = Vec::with_capacity(64);
        pending.extend(
            self.nodes
                .first()
                .and_then(|all| ray.enters(all))
                .map(|t| (t, 0)),
        );
        while let Some((entry, index)) = pending.pop() {
            if entry > nearest * (1.0 + BOX_MARGIN) {
                continue;
            }
            let node = &self.nodes[index];
            let Some(halves) = node.halves else {
                for triangle in &self.triangles[node.first..node.last] {
                    if let Some(t) = meet(triangle, direction)
                        && t >= near_m
                    {
                        nearest = nearest.min(t);
                    }
                }
                continue;
            };
            let mut entries =
                halves.map(|half| ray.enters(&self.nodes[half]).map(|entry| (entry, half)));
            // The nearer half is searched first, so it goes on the stack last.
            if let [Some(a), Some(b)] = entries
                && a.0 < b.0
            {
                entries.swap(0, 1);
            }
            pending.extend(entries.into_iter().flatten());
        }
        nearest.is_finite().then_some(nearest)
    }

    /// [`SurfaceTriangles::hit`] without the tree.
    #[cfg(test)]
    pub(crate) fn hit_brute(&self, direction: DVec3, near_m: f64) -> Option<f64> {
        self.triangles
            .iter()
            .filter_map(|triangle| meet(triangle, direction))
            .filter(|&t| t >= near_m)
            .min_by(f64::total_cmp)
    }
}

/// Appends the node of `triangles[first..last]`, its halves after it, and returns its index.
fn build(triangles: &mut [[DVec3; 3]], first: usize, last: usize, nodes: &mut Vec<Node>) -> usize {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for corner in triangles[first..last].iter().flatten() {
        low = low.min(*corner);
        high = high.max(*corner);
    }
    let index = nodes.len();
    nodes.push(Node {
        low,
        high,
        first,
        last,
        halves: None,
    });
    if last - first > LEAF_SIZE {
        let size = (high - low).to_array();
        let axis = (0..3)
            .max_by(|&a, &b| size[a].total_cmp(&size[b]))
            .unwrap_or(0);
        let middle = usize::midpoint(first, last);
        let along = |t: &[DVec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        triangles[first..last]
            .select_nth_unstable_by(middle - first, |a, b| along(a).total_cmp(&along(b)));
        let halves = [
            build(triangles, first, middle, nodes),
            build(triangles, middle, last, nodes),
        ];
        nodes[index].halves = Some(halves);
    }
    index
}

/// A direction from the origin, ready for boxes.
struct Ray {
    reciprocal: DVec3,
}

impl Ray {
    fn new(direction: DVec3) -> Self {
        // A reciprocal of ∞ would make 0 · ∞ of a box that starts at 0.
        let component = |c: f64| if c.abs() < 1e-300 { 1e-300 } else { c };
        Self {
            reciprocal: DVec3::from(direction.to_array().map(component)).recip(),
        }
    }

    /// Where the ray enters the box, at least 0; `None` when it misses.
    fn enters(&self, node: &Node) -> Option<f64> {
        let a = node.low * self.reciprocal;
        let b = node.high * self.reciprocal;
        let entry = a.min(b).max_element().max(0.0);
        let exit = a.max(b).min_element();
        (entry <= exit * (1.0 + BOX_MARGIN)).then_some(entry)
    }
}

/// Parameter of the point where the ray meets a triangle from either side, rim included.
fn meet(corners: &[DVec3; 3], direction: DVec3) -> Option<f64> {
    let [a, b, c] = *corners;
    let sides = [
        exact_side(a, b, direction),
        exact_side(b, c, direction),
        exact_side(c, a, direction),
    ];
    let is_met = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
    if !is_met {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a) / normal.dot(direction);
    // Seen edge-on the quotient is no number; the neighbours are met in that case.
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// Sign of `det(a, b, direction)`, exact for the numbers given.
fn exact_side(a: DVec3, b: DVec3, direction: DVec3) -> f64 {
    let coordinate = |v: DVec3| Coord3D {
        x: v.x,
        y: v.y,
        z: v.z,
    };
    orient3d(
        coordinate(a),
        coordinate(b),
        coordinate(direction),
        coordinate(DVec3::ZERO),
    )
}
