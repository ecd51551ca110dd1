// SPDX-License-Identifier: MIT OR Apache-2.0
//! Polygons as triangles: a fan where a polygon is convex, a constrained Delaunay triangulation by `spade` where not.

use crate::mesh::fan_normal;
use glam::DVec3;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeMap;

/// A corner of a polygon may turn back by this share of its edges' lengths, as rounding makes it.
const TURN_SHARE: f64 = 1e-9;
/// Corners of a polygon that is not convex: every triangle is compared with every edge, and `spade` panics on a star
/// of 40,000.
const MAX_DENTED: usize = 2_000;
/// Smaller shares of a polygon's size are 0: `spade` refuses numbers of which it would lose bits.
const LEAST_SHARE: f64 = 1e-30;
/// Triangles cover a polygon when their areas differ by less than this share.
const AREA_SHARE: f64 = 1e-6;

/// Corners of triangles that cover a polygon, by their places in its ring; wound as it is.
///
/// - `ring`: 3 places or more, none equal to the next
/// - returns: why there are none
pub(super) fn triangles(ring: &[DVec3]) -> Result<Vec<[usize; 3]>, String> {
    if ring.len() > 3 && has_no_area(ring) {
        return Err("edges that cross, so that areas of both sides are equal".to_owned());
    }
    let Some(corner) = dent(ring) else {
        return Ok((1..ring.len() - 1).map(|at| [0, at, at + 1]).collect());
    };
    if ring.len() > MAX_DENTED {
        let (count, at) = (ring.len(), ring[corner]);
        return Err(format!(
            "{count} corners with a dent at {at}, more than {MAX_DENTED}"
        ));
    }
    // What `spade` cannot do is a panic, and no file may end the program.
    let found = std::panic::catch_unwind(|| by_spade(ring));
    let found = found.map_err(|_| "a dented polygon that spade cannot triangulate".to_owned())?;
    found.ok_or_else(|| "edges that cross or lie upon each other".to_owned())
}

/// Whether a polygon encloses as much on the one side as on the other, and does not lie on a line.
fn has_no_area(ring: &[DVec3]) -> bool {
    let steps = (0..ring.len()).map(|at| ring[(at + 1) % ring.len()] - ring[at]);
    let around: f64 = steps.clone().map(DVec3::length).sum();
    let next = steps.clone().cycle().skip(1);
    let turns = |(one, other): (DVec3, DVec3)| {
        one.cross(other).length() > TURN_SHARE * one.length() * other.length()
    };
    fan_normal(ring).length() <= 8.0 * f64::EPSILON * around * around && steps.zip(next).any(turns)
}

/// A corner at which a polygon turns the other way; a fan over it would lie beside the polygon.
fn dent(ring: &[DVec3]) -> Option<usize> {
    let up = fan_normal(ring).normalize_or_zero();
    let count = ring.len();
    (0..count).find(|at| {
        let (before, after) = (ring[(at + count - 1) % count], ring[(at + 1) % count]);
        let (way, on) = (ring[*at] - before, after - ring[*at]);
        way.cross(on).dot(up) < -TURN_SHARE * way.length() * on.length()
    })
}

/// `None` where edges cross, or where the polygon has no area.
fn by_spade(ring: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let flat = flattened(ring)?;
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut corners: BTreeMap<usize, usize> = BTreeMap::new();
    let mut handles: Vec<FixedVertexHandle> = Vec::with_capacity(flat.len());
    for (corner, [x, y]) in flat.iter().enumerate() {
        let handle = triangulation.insert(Point2::new(*x, *y)).ok()?;
        corners.entry(handle.index()).or_insert(corner);
        handles.push(handle);
    }
    for at in 0..handles.len() {
        let (from, to) = (handles[at], handles[(at + 1) % handles.len()]);
        if from == to || !triangulation.can_add_constraint(from, to) {
            return None;
        }
        triangulation.add_constraint(from, to);
    }
    let mut area = 0.0;
    let mut triangles = Vec::with_capacity(flat.len());
    for face in triangulation.inner_faces() {
        let [a, b, c] = face.positions();
        let middle = [(a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0];
        if is_inside(middle, &flat) {
            area += face.area();
            triangles.push(face.vertices().map(|vertex| corners[&vertex.fix().index()]));
        }
    }
    let whole = 0.5
        * edges(&flat)
            .map(|([ax, ay], [bx, by])| ax * by - ay * bx)
            .sum::<f64>();
    ((area - whole).abs() <= AREA_SHARE * whole).then_some(triangles)
}

/// The polygon in its plane, counter-clockwise, about 1 in size.
fn flattened(ring: &[DVec3]) -> Option<Vec<[f64; 2]>> {
    let up = fan_normal(ring).try_normalize()?;
    let right = up.any_orthonormal_vector();
    let ahead = up.cross(right);
    let from = ring.iter().map(|place| *place - ring[0]);
    let size = from.clone().map(DVec3::length).fold(0.0, f64::max);
    let share = |along: f64| match along / size {
        small if small.abs() < LEAST_SHARE => 0.0,
        share => share,
    };
    let flat = from.map(|place| [place.dot(right), place.dot(ahead)].map(share));
    let flat: Vec<[f64; 2]> = flat.collect();
    flat.iter()
        .flatten()
        .all(|share| share.is_finite())
        .then_some(flat)
}

fn edges(ring: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().copied().zip(next.copied())
}

/// By the even-odd rule.
fn is_inside([x, y]: [f64; 2], ring: &[[f64; 2]]) -> bool {
    let crossed = edges(ring).filter(|([ax, ay], [bx, by])| {
        (*ay > y) != (*by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax
    });
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn area(ring: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        let up = fan_normal(ring).normalize();
        let areas = triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|at| ring[at]);
            0.5 * (b - a).cross(c - a).dot(up)
        });
        areas.inspect(|area| assert!(*area > 0.0, "{area}")).sum()
    }

    /// Places of a plane that leans, 10⁶ m away.
    fn leaning(flat: &[[f64; 2]]) -> Vec<DVec3> {
        let far = DVec3::new(1e6, -2e6, 50.0);
        let place = |[x, y]: &[f64; 2]| far + DVec3::new(0.6 * x, *y, 0.8 * x);
        flat.iter().map(place).collect()
    }

    #[test]
    fn a_dented_polygon_is_covered_once_and_one_that_crosses_itself_is_refused() {
        let ell = [
            [0.0, 0.0],
            [8.0, 0.0],
            [8.0, 3.0],
            [3.0, 3.0],
            [3.0, 7.0],
            [0.0, 7.0],
        ];
        for turned in [false, true] {
            let mut ring = leaning(&ell);
            if turned {
                ring.reverse();
            }
            let found = triangles(&ring).expect("simple");
            assert_eq!(found.len(), 4);
            assert!((area(&ring, &found) - 36.0).abs() < 1e-6);
        }
        // Control: a fan from the first corner of this one lies beside it.
        let arrow = leaning(&[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0], [0.5, 0.5]]);
        let found = triangles(&arrow).expect("simple");
        let exact = fan_normal(&arrow).length() / 2.0;
        assert!((area(&arrow, &found) - exact).abs() < 1e-6);
        let fan: Vec<[usize; 3]> = (1..4).map(|at| [0, at, at + 1]).collect();
        let is_covered = std::panic::catch_unwind(|| area(&arrow, &fan));
        assert!(is_covered.is_err(), "the control's fan turns over");
        let crossed = leaning(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [1.0, 5.0]]);
        assert!(triangles(&crossed).expect_err("crossed").contains("cross"));
    }

    #[test]
    fn convex_polygons_stay_fans() {
        let square = leaning(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles(&square), Ok(vec![[0, 1, 2], [0, 2, 3]]));
    }

    #[test]
    fn as_many_corners_as_are_allowed_are_covered_and_more_are_refused() {
        let star = |corners: usize| {
            let corner = |at: usize| {
                let turn = std::f64::consts::TAU * at as f64 / corners as f64;
                let radius = if at.is_multiple_of(2) { 10.0 } else { 3.0 };
                [radius * turn.cos(), radius * turn.sin()]
            };
            let flat: Vec<[f64; 2]> = (0..corners).map(corner).collect();
            leaning(&flat)
        };
        let largest = star(MAX_DENTED);
        let found = triangles(&largest).expect("simple");
        assert_eq!(found.len(), MAX_DENTED - 2);
        let error = triangles(&star(MAX_DENTED + 2)).expect_err("too many");
        assert!(error.contains("2002 corners with a dent at"), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_polygon_is_covered_once_or_refused(
            // Few places, so that many corners meet and many edges lie upon each other.
            lattice in prop::collection::vec((0..6_u8, 0..6_u8), 3..12),
            radii in prop::collection::vec(1e-9..1.0, 3..40),
        ) {
            let lattice: Vec<[f64; 2]> = lattice.iter().map(|(x, y)| [f64::from(*x), f64::from(*y)]).collect();
            let turn = |at: usize| std::f64::consts::TAU * at as f64 / radii.len() as f64;
            let star = radii.iter().enumerate();
            let star = star.map(|(at, radius)| [radius * turn(at).cos(), radius * turn(at).sin()]);
            for flat in [lattice, star.collect()] {
                let ring = leaning(&flat);
                if let Ok(found) = triangles(&ring) {
                    let normals = found.iter().map(|own| fan_normal(&own.map(|at| ring[at])));
                    let whole = fan_normal(&ring);
                    let off = (normals.sum::<DVec3>() - whole).length();
                    prop_assert!(off <= 1e-6 * (1.0 + whole.length()), "{off}");
                }
            }
        }
    }
}
