// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays from the eye against the surface's triangles as drawn.
//!
//! Metres relative to the eye, ECEF axes; the vertices are the f32 values that the GPU reads,
//! widened without loss. A ray starts at the origin, and its direction has length 1 along the
//! viewing axis, so its parameter is the view depth.
//!
//! Whether a ray meets a triangle is decided by the exact signs of three determinants (Shewchuk,
//! 1997, by the crate `robust`). Two triangles with a common edge see the same number there with
//! opposite sign, and 0 counts as met by both: no ray falls through between them. Where a determinant is
//! larger than its rounding can be, its sign is exact as it is. A tree of boxes (median split on the longest
//! axis) only says which triangles to ask.

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord3D, orient3d};
use terrafill_core::Ellipsoid;
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::SurfaceFrame;

/// Triangles in a leaf.
const LEAF_SIZE: usize = 4;

/// Triangles of a part of the tree that is not worth another thread.
const ON_ONE_CORE: usize = 4_096;

/// By how much the picture is wider on each side whose rays meet triangles, share of its half: rays beside a pixel of its
/// rim lie beyond it.
const PICTURE_MARGIN: f64 = 0.1;

/// Box distances are compared with this much to spare, a few thousand times their rounding.
const BOX_MARGIN: f64 = 1e-12;

/// How far `(a × b) · d` as computed may be from what it is, as a share of |a| |b| |d|. Each of its six products
/// is rounded five times on its way into the sum, and their magnitudes add up to at most √3 |a| |b| |d|: that is
/// 4.4 ε. The rest covers the rounding of the lengths.
const SIDE_ROUNDING: f64 = 6.0 * f64::EPSILON;

/// Triangles seen from the eye, ready for rays.
#[derive(Debug, Clone)]
pub struct SurfaceTriangles {
    triangles: Vec<Facet>,
    /// The first one holds all.
    nodes: Vec<Node>,
    non_finite: u64,
    /// Met in place of triangles.
    body: Option<Body>,
}

/// A triangle with what tells on which side of its edges a ray passes.
#[derive(Debug, Clone, Copy)]
struct Facet {
    corners: [DVec3; 3],
    /// Of the planes through the eye and each edge.
    planes: [DVec3; 3],
    /// What a ray of length 1 must be off a plane for its side to be certain.
    certain: f64,
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let farthest = a.length().max(b.length()).max(c.length());
        Self {
            corners,
            planes: [a.cross(b), b.cross(c), c.cross(a)],
            certain: SIDE_ROUNDING * farthest * farthest + f64::MIN_POSITIVE,
        }
    }

    /// A number with the exact sign of `det(a, b, direction)`, where the edge runs from a to b.
    ///
    /// - `length`: of the direction
    fn side(&self, edge: usize, direction: DVec3, length: f64) -> f64 {
        let side = self.planes[edge].dot(direction);
        if side.abs() > self.certain * length {
            side
        } else {
            exact_side(self.corners[edge], self.corners[(edge + 1) % 3], direction)
        }
    }

    /// Parameter of the point where the ray meets the triangle from either side, rim included.
    fn meet(&self, direction: DVec3, length: f64) -> Option<f64> {
        let [first, second] = [0, 1].map(|edge| self.side(edge, direction, length));
        // Of most triangles two sides tell.
        if (first > 0.0 && second < 0.0) || (first < 0.0 && second > 0.0) {
            return None;
        }
        let sides = [first, second, self.side(2, direction, length)];
        let is_met = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
        if !is_met {
            return None;
        }
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let t = normal.dot(a) / normal.dot(direction);
        // Seen edge-on the quotient is no number; the neighbours are met in that case.
        (t > 0.0 && t.is_finite()).then_some(t)
    }
}

/// A body as rays see it: in the space where it is the unit sphere.
#[derive(Debug, Clone, Copy)]
struct Body {
    /// 1 / radii along the axes.
    scale: DVec3,
    eye: DVec3,
}

impl Body {
    /// The smaller root of |eye + t direction| = 1 that is not closer than `near_m`, by the form of the
    /// quadratic formula in which nothing cancels near the body (Press et al., 2007, 5.6).
    fn hit(&self, direction: DVec3, near_m: f64) -> Option<f64> {
        let d = direction * self.scale;
        let (dd, ed) = (d.dot(d), self.eye.dot(d));
        let height = self.eye.dot(self.eye) - 1.0;
        let discriminant = ed * ed - dd * height;
        // Seen from outside, the body lies ahead.
        if ed >= 0.0 || discriminant < 0.0 {
            return None;
        }
        let t = height / (-ed + discriminant.sqrt());
        (t >= near_m).then_some(t)
    }
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

impl Node {
    const EMPTY: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        first: 0,
        last: 0,
        halves: None,
    };
}

impl SurfaceTriangles {
    /// All of a frame. Triangles with a NaN or infinite corner cannot be met; they are counted instead.
    #[must_use]
    pub fn new(frame: &SurfaceFrame) -> Self {
        Self::of(frame, |_| true)
    }

    /// As [`SurfaceTriangles::new`] without those that no ray of a picture meets: all corners of such a one lie to the
    /// same side of the picture, or behind the eye. Close to the ground that is nearly all, and takes the time that the
    /// tree of all would.
    #[must_use]
    pub fn in_picture(frame: &SurfaceFrame, camera: &Camera, size: ImageSize) -> Self {
        let planes = camera.side_planes_ecef(size, PICTURE_MARGIN);
        Self::of(frame, |corners| {
            let is_beyond = |plane: &DVec3| corners.iter().all(|corner| plane.dot(*corner) < 0.0);
            !planes.iter().any(is_beyond)
        })
    }

    fn of(frame: &SurfaceFrame, is_kept: impl Fn(&[DVec3; 3]) -> bool) -> Self {
        let vertices = &frame.vertices_rte;
        let corner = |index: u32| DVec3::from(vertices[index as usize].map(f64::from));
        let mut non_finite = 0;
        let mut all = Vec::new();
        for corners in frame.triangles.iter().map(|ids| ids.map(corner)) {
            if !corners.iter().all(|corner| corner.is_finite()) {
                non_finite += 1;
            } else if is_kept(&corners) {
                all.push(corners);
            }
        }
        let entry = |(triangle, &[a, b, c]): (u32, &[DVec3; 3])| Entry {
            middle: (a + b + c).to_array(),
            triangle,
        };
        let mut entries: Vec<Entry> = (0..).zip(&all).map(entry).collect();
        let mut nodes = Vec::new();
        if !entries.is_empty() {
            let depth = depth_of(entries.len());
            nodes.resize(nodes_of(depth), Node::EMPTY);
            build(&all, (0, &mut entries), depth, (0, &mut nodes));
        }
        let facet = |entry: &Entry| Facet::new(all[entry.triangle as usize]);
        Self {
            triangles: entries.par_iter().map(facet).collect(),
            nodes,
            non_finite,
            body: None,
        }
    }

    /// The body itself instead of triangles, seen from outside.
    #[must_use]
    pub fn of_body(body: &Ellipsoid, eye_ecef: DVec3) -> Self {
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let scale = DVec3::new(1.0 / a, 1.0 / a, 1.0 / b);
        Self {
            triangles: Vec::new(),
            nodes: Vec::new(),
            non_finite: 0,
            body: Some(Body {
                scale,
                eye: eye_ecef * scale,
            }),
        }
    }

    /// Triangles left out because a corner is NaN or infinite.
    #[must_use]
    pub fn non_finite(&self) -> u64 {
        self.non_finite
    }

    /// View depth of the nearest hit not closer than `near_m`.
    #[must_use]
    pub fn hit(&self, direction: DVec3, near_m: f64) -> Option<f64> {
        match &self.body {
            Some(body) => body.hit(direction, near_m),
            None => self.nearest(direction, near_m).map(|(depth, _)| depth),
        }
    }

    /// The same with the corners of the triangle that is met, relative to the eye; `None` for a body.
    #[must_use]
    pub fn hit_facet(&self, direction: DVec3, near_m: f64) -> Option<(f64, [DVec3; 3])> {
        let (depth, place) = self.nearest(direction, near_m)?;
        Some((depth, self.triangles[place].corners))
    }

    /// View depth of the nearest hit, and the place of its triangle.
    fn nearest(&self, direction: DVec3, near_m: f64) -> Option<(f64, usize)> {
        let ray = Ray::new(direction);
        let length = direction.length();
        let mut nearest = (f64::INFINITY, 0);
        let mut pending = Pending::default();
        if let Some(entry) = self.nodes.first().and_then(|all| ray.enters(all)) {
            pending.push((entry, 0));
        }
        while let Some((entry, index)) = pending.pop() {
            if entry > nearest.0 * (1.0 + BOX_MARGIN) {
                continue;
            }
            let node = &self.nodes[index];
            let Some(halves) = node.halves else {
                for place in node.first..node.last {
                    if let Some(t) = self.triangles[place].meet(direction, length)
                        && t >= near_m
                        && t < nearest.0
                    {
                        nearest = (t, place);
                    }
                }
                continue;
            };
            // One after the other: mapped as an array they are calls, a fifth of a judge's time in a profile.
            let [a, b] = halves;
            let (enters_a, enters_b) = (ray.enters(&self.nodes[a]), ray.enters(&self.nodes[b]));
            // The nearer half is searched first, so it goes on the stack last.
            match (enters_a, enters_b) {
                (Some(to_a), Some(to_b)) if to_a < to_b => {
                    pending.push((to_b, b));
                    pending.push((to_a, a));
                }
                (Some(to_a), Some(to_b)) => {
                    pending.push((to_a, a));
                    pending.push((to_b, b));
                }
                (Some(to_a), None) => pending.push((to_a, a)),
                (None, Some(to_b)) => pending.push((to_b, b)),
                (None, None) => {}
            }
        }
        nearest.0.is_finite().then_some(nearest)
    }

    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// [`SurfaceTriangles::hit`] without the tree.
    #[cfg(test)]
    pub(crate) fn hit_brute(&self, direction: DVec3, near_m: f64) -> Option<f64> {
        self.triangles
            .iter()
            .filter_map(|triangle| triangle.meet(direction, direction.length()))
            .filter(|&t| t >= near_m)
            .min_by(f64::total_cmp)
    }
}

/// A triangle while the tree is made: less than half as large as its corners, which stay where they are.
struct Entry {
    /// Sum of its corners.
    middle: [f64; 3],
    triangle: u32,
}

/// Halvings after which no part has more than [`LEAF_SIZE`] triangles.
fn depth_of(triangles: usize) -> u32 {
    triangles
        .div_ceil(LEAF_SIZE)
        .next_power_of_two()
        .trailing_zeros()
}

/// Nodes of a tree of this depth.
fn nodes_of(depth: u32) -> usize {
    (2 << depth) - 1
}

/// Orders entries so that every half holds one side of the longest axis of its middles, and fills in their nodes: a node,
/// then its first half, then its second.
///
/// - `first`: of the entries, among all
/// - `at`: of the nodes, among all
fn build(
    corners: &[[DVec3; 3]],
    (first, entries): (usize, &mut [Entry]),
    depth: u32,
    (at, nodes): (usize, &mut [Node]),
) {
    let Some((node, rest)) = nodes.split_first_mut() else {
        return;
    };
    (node.first, node.last) = (first, first + entries.len());
    if depth == 0 {
        for corner in entries
            .iter()
            .flat_map(|entry| corners[entry.triangle as usize])
        {
            node.low = node.low.min(corner);
            node.high = node.high.max(corner);
        }
        return;
    }
    let axis = longest_axis(entries);
    let middle = entries.len() / 2;
    entries.select_nth_unstable_by(middle, |a, b| a.middle[axis].total_cmp(&b.middle[axis]));
    let is_large = entries.len() > ON_ONE_CORE;
    let (left, right) = entries.split_at_mut(middle);
    let (of_left, of_right) = rest.split_at_mut(nodes_of(depth - 1));
    let halves = [at + 1, at + 1 + of_left.len()];
    let mut build_left = || build(corners, (first, left), depth - 1, (halves[0], of_left));
    let mut build_right = || {
        let first = first + middle;
        build(corners, (first, right), depth - 1, (halves[1], of_right));
    };
    if is_large {
        rayon::join(build_left, build_right);
    } else {
        build_left();
        build_right();
    }
    node.halves = Some(halves);
    node.low = of_left[0].low.min(of_right[0].low);
    node.high = of_left[0].high.max(of_right[0].high);
}

/// The axis along which middles lie farthest apart.
fn longest_axis(entries: &[Entry]) -> usize {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for entry in entries {
        let middle = DVec3::from(entry.middle);
        low = low.min(middle);
        high = high.max(middle);
    }
    (high - low).max_position()
}

/// Halves of the tree that are not searched yet. On the way down one waits at each step, so that nothing has to be
/// allocated for a ray.
struct Pending {
    halves: [(f64, usize); MAX_PENDING],
    count: usize,
}

/// As many as the tree of 2⁴⁰ triangles has steps.
const MAX_PENDING: usize = 40;

impl Default for Pending {
    fn default() -> Self {
        Self {
            halves: [(0.0, 0); MAX_PENDING],
            count: 0,
        }
    }
}

impl Pending {
    fn push(&mut self, half: (f64, usize)) {
        self.halves[self.count] = half;
        self.count += 1;
    }

    fn pop(&mut self) -> Option<(f64, usize)> {
        self.count = self.count.checked_sub(1)?;
        Some(self.halves[self.count])
    }
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
    #[inline]
    fn enters(&self, node: &Node) -> Option<f64> {
        let a = node.low * self.reciprocal;
        let b = node.high * self.reciprocal;
        let entry = a.min(b).max_element().max(0.0);
        let exit = a.max(b).min_element();
        (entry <= exit * (1.0 + BOX_MARGIN)).then_some(entry)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_body_itself_and_the_sky_beside_it() {
        let body = Ellipsoid::WGS84;
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        // 2 km up, looking along the ground, and 8,000 km up.
        for (height_m, down) in [(2e3, 0.05), (8e6, 1.0)] {
            let eye = DVec3::new(a + height_m, 0.0, 0.0);
            let surface = SurfaceTriangles::of_body(&body, eye);
            let direction = DVec3::new(-down, 0.3, 1.0 - down);
            let depth = surface.hit(direction, 1.0).expect("the body");
            let hit = eye + direction * depth;
            let off = (hit * DVec3::new(1.0 / a, 1.0 / a, 1.0 / b)).length() - 1.0;
            assert!((off * a).abs() < 1e-6, "{off}");
            // Nothing lies between: a step back is outside.
            let before = eye + direction * (depth - 1.0);
            assert!((before * DVec3::new(1.0 / a, 1.0 / a, 1.0 / b)).length() > 1.0);
            // Negative controls: the sky, what is behind, and what is nearer than allowed.
            assert_eq!(surface.hit(DVec3::new(0.1, 0.0, 1.0), 1.0), None);
            assert_eq!(surface.hit(-direction, 1.0), None);
            assert_eq!(surface.hit(direction, depth + 1.0), None);
        }
    }

    #[test]
    fn sides_have_the_exact_sign_where_a_ray_grazes_an_edge() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            f64::from((state >> 32) as u32) / f64::from(u32::MAX) - 0.5
        };
        let mut wrong_as_computed = 0;
        for _ in 0..20_000 {
            let [a, b, c] = [(); 3].map(|()| 8e6 * DVec3::new(random(), random(), random()));
            let facet = Facet::new([a, b, c]);
            for (edge, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                let along = from.lerp(to, random() + 0.5);
                let direction = along / along.z;
                let exact = exact_side(from, to, direction);
                let side = facet.side(edge, direction, direction.length());
                assert_eq!(side.partial_cmp(&0.0), exact.partial_cmp(&0.0));
                let computed = facet.planes[edge].dot(direction);
                wrong_as_computed += usize::from(computed * exact < 0.0);
            }
        }
        // Negative control: the determinant as computed has the other sign of many.
        assert!(wrong_as_computed > 1_000, "{wrong_as_computed}");
    }
}
