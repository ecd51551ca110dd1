// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles across the antimeridian, where `U` jumps from 1 to 0: four ways to keep a fragment's `U` from
//! running back over the whole map.
//!
//! Weights are those of a triangle's corners at a point of it; a result is right up to whole turns.

use glam::DVec3;

/// How the seam is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seam {
    /// Vertices are inserted where two corners' `U` differ by more than this: 0.7 as published, 0.5 is exact.
    Split(f64),
    /// `U` and `fract(U + ½) − ½` are both interpolated, and the fragment takes the one that changes less
    /// from pixel to pixel (Tarini, 2012).
    Derivative,
    /// `U` is counted from this one, the eye's, so that the seam lies behind the body.
    Rotated(f64),
}

/// A corner of a part of a triangle: weights of the triangle's corners there, and its `U`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamCorner {
    /// Of the whole triangle's corners.
    pub weights: [f64; 3],
    /// Texture coordinate.
    pub u: f64,
}

/// The parts that a geometry shader emits for a triangle: itself, or up to three.
///
/// - `us`: `U` of its corners
/// - `limit`: edges whose ends differ by more are split
#[must_use]
pub fn split(us: [f64; 3], limit: f64) -> Vec<[SeamCorner; 3]> {
    let corner = |i: usize| SeamCorner {
        weights: [0, 1, 2].map(|j| f64::from(u8::from(i == j))),
        u: us[i],
    };
    let is_split = |i: usize, j: usize| (us[i] - us[j]).abs() > limit;
    // The corner that is alone on its side: both of its edges are split, the third is not.
    let alone = (0..3).find(|&i| {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        is_split(i, j) && is_split(i, k) && !is_split(j, k)
    });
    if let Some(i) = alone {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        let [p, q] = [j, k].map(|other| inserted(us, i, other));
        let [near, far] = [us[i], us[j]].map(|side| if side > 0.5 { 1.0 } else { 0.0 });
        let at = |weights, u| SeamCorner { weights, u };
        return vec![
            [corner(i), at(p, near), at(q, near)],
            [at(p, far), corner(j), corner(k)],
            [at(p, far), corner(k), at(q, far)],
        ];
    }
    // One edge alone: what is right on one of its sides is not on the other.
    let one = (0..3).find(|&i| is_split(i, (i + 1) % 3));
    let Some(i) = one else {
        return vec![[0, 1, 2].map(corner)];
    };
    let [j, k] = [(i + 1) % 3, (i + 2) % 3];
    let p = inserted(us, i, j);
    let [at_i, at_j] = [us[i], us[j]].map(|side| SeamCorner {
        weights: p,
        u: if side > 0.5 { 1.0 } else { 0.0 },
    });
    vec![[corner(i), at_i, corner(k)], [at_j, corner(j), corner(k)]]
}

/// Weights of the vertex inserted between two corners. From the same operands in the same order on either side
/// of the edge, so that no crack opens.
fn inserted(us: [f64; 3], one: usize, other: usize) -> [f64; 3] {
    let (high, low) = if us[one] > us[other] {
        (one, other)
    } else {
        (other, one)
    };
    let from_high = (1.0 - us[high]) / (1.0 - us[high] + us[low]);
    [0, 1, 2].map(|i| match i {
        i if i == high => 1.0 - from_high,
        i if i == low => from_high,
        _ => 0.0,
    })
}

/// How often a triangle's edges cross the half plane of ±180°, by no angle: 0 or 2, and an odd number where the
/// axis passes through it, so that `U` is no function on it.
///
/// - `corners_ecef`: from the body's centre
#[must_use]
pub fn half_plane_crossings([a, b, c]: [DVec3; 3]) -> usize {
    let crosses = |p: DVec3, q: DVec3| {
        let changes = (p.y < 0.0) != (q.y < 0.0);
        // x where y is 0, times a positive number.
        let x = (p.x * q.y - q.x * p.y) * (q.y - p.y).signum();
        changes && x < 0.0
    };
    let edges = [(a, b), (b, c), (c, a)].into_iter();
    edges.filter(|&(p, q)| crosses(p, q)).count()
}

/// `U` of a fragment.
///
/// - `us`: of the triangle's corners
/// - `weights`: of the fragment, and of the pixels to its right and below it
#[must_use]
pub fn fragment_u(seam: Seam, us: [f64; 3], weights: [[f64; 3]; 3]) -> f64 {
    let mixed = |us: [f64; 3], weights: [f64; 3]| {
        us[0] * weights[0] + us[1] * weights[1] + us[2] * weights[2]
    };
    match seam {
        Seam::Split(limit) => {
            let parts = split(us, limit);
            // Rounding leaves a point on a border outside both: the part that it is least outside of.
            let depth = |part: &[SeamCorner; 3]| {
                let inner = barycentric(part.map(|corner| corner.weights), weights[0]);
                (inner.into_iter().fold(f64::INFINITY, f64::min), inner)
            };
            let mut best = (f64::NEG_INFINITY, us[0]);
            for part in &parts {
                let (least, inner) = depth(part);
                if least > best.0 {
                    best = (least, mixed(part.map(|corner| corner.u), inner));
                }
            }
            best.1
        }
        Seam::Derivative => {
            let turned = us.map(|u| (u + 0.5).rem_euclid(1.0) - 0.5);
            let changes = |us: [f64; 3]| {
                let [here, right, below] = weights.map(|weights| mixed(us, weights));
                (right - here).abs() + (below - here).abs()
            };
            mixed(
                if changes(us) <= changes(turned) {
                    us
                } else {
                    turned
                },
                weights[0],
            )
        }
        Seam::Rotated(origin) => {
            let from = us.map(|u| (u - origin + 0.5).rem_euclid(1.0) - 0.5);
            origin + mixed(from, weights[0])
        }
    }
}

/// Weights of a part's corners at a point, all given as weights of the whole triangle.
fn barycentric(part: [[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    // The first two weights are coordinates of the plane.
    let [a, b, c] = part;
    let area = |p: [f64; 3], q: [f64; 3], r: [f64; 3]| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    let whole = area(a, b, c);
    [area(point, b, c), area(a, point, c), area(a, b, point)].map(|part| part / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_split_triangle_is_whole_and_each_part_is_on_one_side() {
        for (us, count) in [
            ([0.9, 0.95, 0.1], 3),
            ([0.1, 0.95, 0.05], 3),
            ([0.05, 0.1, 0.98], 3),
            ([0.4, 0.5, 0.6], 1),
        ] {
            let parts = split(us, 0.5);
            assert_eq!(parts.len(), count);
            let mut sum = 0.0_f64;
            for part in &parts {
                let [a, b, c] = part.map(|corner| corner.weights);
                let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                // All turn the way the whole does.
                assert!(doubled > 0.0, "{us:?}");
                sum += doubled;
                let us = part.map(|corner| corner.u);
                let spread =
                    us.into_iter().fold(0.0, f64::max) - us.into_iter().fold(1.0, f64::min);
                assert!(spread <= 0.5, "{us:?}");
            }
            assert!((sum - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn neighbours_insert_the_same_vertex() {
        let one = inserted([0.93, 0.08, 0.5], 0, 1);
        let other = inserted([0.08, 0.93, 0.2], 0, 1);
        assert_eq!([one[0], one[1]], [other[1], other[0]]);
        // Negative control: counted from the other end, the sum is 1 but for rounding.
        assert!((one[0] - 0.08 / (0.08 + 0.07)).abs() < 1e-12);
    }
}
