// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where two edges intersect between their ends.
//!
//! Degrees for planar edges, unit normals for great ellipses. Planar decisions are exact
//! (`robust::orient2d`); arcs cross only where rounding cannot feign it.

use crate::Degrees;
use glam::DVec3;

/// Two edges, by index, the lower first, and where they cross.
pub type Crossing = ([usize; 2], Degrees);

/// Coordinates below this are 0, since the exact predicates must not underflow. A billionth of an
/// atom, in degrees of the Earth.
pub const SMALLEST_COORDINATE_DEG: f64 = 1e-25;

/// Turns that two longitudes within ±540 can be apart, degrees.
const TURNS_APART_DEG: [f64; 5] = [-720.0, -360.0, 0.0, 360.0, 720.0];

/// A coordinate, or 0 below [`SMALLEST_COORDINATE_DEG`].
pub fn without_underflow(coordinate: f64) -> f64 {
    if coordinate.abs() < SMALLEST_COORDINATE_DEG {
        0.0
    } else {
        coordinate
    }
}

/// Twice the area of a triangle, positive if it turns left; exact in its sign.
pub fn orient(a: Degrees, b: Degrees, c: Degrees) -> f64 {
    let coord = |[x, y]: Degrees| robust::Coord { x, y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Where two straight edges cross, each strictly between its ends. The decision is exact.
///
/// Rounded, but into the box of either edge: a repair makes a vertex of it, which must not lie
/// beyond a pole.
pub fn planar_crossing(a: [Degrees; 2], b: [Degrees; 2]) -> Option<Degrees> {
    let [a, b] = [a, b].map(|ends| ends.map(|end| end.map(without_underflow)));
    // Only the signs are exact. Their sizes, which say where, have the rounding of differences from the
    // third place: from an end of the edge itself they are as good as the edge is short.
    let side = |[p, q]: [Degrees; 2], r| orient(q, r, p);
    let (a0, a1) = (side(b, a[0]), side(b, a[1]));
    let (b0, b1) = (side(a, b[0]), side(a, b[1]));
    (opposite(a0, a1) && opposite(b0, b1)).then(|| {
        let along = a0 / (a0 - a1);
        [0, 1].map(|i| {
            let low = a[0][i].min(a[1][i]).max(b[0][i].min(b[1][i]));
            let high = a[0][i].max(a[1][i]).min(b[0][i].max(b[1][i]));
            (a[0][i] + (a[1][i] - a[0][i]) * along).max(low).min(high)
        })
    })
}

/// Where two arcs cross, each strictly between its ends and by more than rounding can feign; by the unit normals at
/// their ends.
pub fn unit_arcs_crossing(a: [DVec3; 2], b: [DVec3; 2]) -> Option<Degrees> {
    let off_b = a.map(|end| certain_side(b, end));
    let apart =
        opposite(off_b[0], off_b[1]) && opposite(certain_side(a, b[0]), certain_side(a, b[1]));
    if !apart {
        return None;
    }
    // Between the ends of one arc as they lie off the other. The line in which the planes meet is the
    // same, but the product of normals that hardly differ is off both planes by its rounding: metres
    // on the Earth.
    let point = a[0] * off_b[1].abs() + a[1] * off_b[0].abs();
    // The planes also meet on the far side of the body.
    (point.dot(b[0] + b[1]) > 0.0).then(|| {
        [
            point.y.atan2(point.x).to_degrees(),
            point.z.atan2(point.x.hypot(point.y)).to_degrees(),
        ]
    })
}

/// Side of the plane through the centre and an arc that a point lies on: positive to the left, 0
/// where moving the three unit vectors by their rounding could change the answer.
fn certain_side([from, to]: [DVec3; 2], point: DVec3) -> f64 {
    // Differences before products: the products of the unit vectors themselves would lose what
    // tells neighbours apart.
    let (along, beside) = (to - from, point - from);
    let volume = from.cross(along).dot(beside);
    let uncertain = 8.0 * f64::EPSILON * (along.length() + beside.length());
    if volume.abs() > uncertain {
        volume
    } else {
        0.0
    }
}

fn opposite(a: f64, b: f64) -> bool {
    a > 0.0 && b < 0.0 || a < 0.0 && b > 0.0
}

/// Whether two planar edges of the file cross between their ends, whichever turn each was written
/// in.
pub fn edges_cross(a: [Degrees; 2], b: [Degrees; 2]) -> bool {
    TURNS_APART_DEG.into_iter().any(|turns_deg| {
        let b = b.map(|[x, y]| [x + turns_deg, y]);
        planar_crossing(a, b).is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the find `a_crossing_told_half_a_millimetre_off_its_edge`: a long edge, the tiny edge of a
    /// sliver over it, and the ends of another. Coordinates are those of the file.
    #[test]
    fn a_crossing_of_a_long_edge_and_a_tiny_one_is_on_both() {
        let long = [
            [-132.40000055, 51.07631785420905],
            [-179.95000065, 60.1000007],
        ];
        let tiny = [
            [-156.175000575, 55.58815932710453],
            [-156.1750006, 55.58815927710452],
        ];
        let off = |[from, to]: [Degrees; 2], [x, y]: Degrees| {
            let along = [to[0] - from[0], to[1] - from[1]];
            let product = along[0] * (y - from[1]) - along[1] * (x - from[0]);
            (product / along[0].hypot(along[1])).abs()
        };
        for (a, b) in [(long, tiny), (tiny, long)] {
            let at = planar_crossing(a, b).expect("cross");
            assert!(off(long, at) < 5e-14 && off(tiny, at) < 5e-14, "{at:?}");
        }
        // Negative control: the sides of the long edge's ends as seen from these ends.
        let coord = |[x, y]: Degrees| robust::Coord { x, y };
        let side = |r| robust::orient2d(coord(tiny[0]), coord(tiny[1]), coord(r));
        let (from, to) = (side(long[0]), side(long[1]));
        let share = from / (from - to);
        let at = [0, 1].map(|i| long[0][i] + (long[1][i] - long[0][i]) * share);
        assert!(off(tiny, at) > 1e-8, "{at:?}");
    }
}
