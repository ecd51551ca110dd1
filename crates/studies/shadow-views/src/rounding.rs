// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a device's rounding alone may make the difference.

use crate::reference::{Light, Seen};
use crate::view::DeckCamera;
use glam::DVec3;

/// How far beside a pixel's centre a device may look: rasterisers round corners to 1/256 of a pixel, and a
/// triangle thinner than some of these steps has any depth across it.
pub const ROUNDING_PX: f64 = 8.0 / 256.0;
/// How far beside a pixel's centre an edge may lie that rounding takes to its other side. A corner moves by half a step
/// along either axis, and `f32` moves it by less than that again.
const EDGE_PX: f64 = 1.0 / 256.0;

/// What a ray from the eye sees first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenPlace {
    /// What it is.
    pub seen: Seen,
    /// Where it is, m.
    pub place: DVec3,
}

impl SeenPlace {
    /// Whether both are of one triangle, or of the sea: there is no joint between them.
    fn is_beside(self, other: Self) -> bool {
        match (self.seen, other.seen) {
            (Seen::Triangle(own, _), Seen::Triangle(other, _)) => own == other,
            (Seen::Sea(_), Seen::Sea(_)) => true,
            _ => false,
        }
    }
}

/// Whether a device's rounding may give a pixel this light.
///
/// It may where the reference, [`ROUNDING_PX`] beside the pixel's centre along rows, columns or both, has that light or
/// judges none. It may too where the boundary of a single part's shadow is crossed on the way there: within the shadow of
/// others it is no boundary of light. Last, it may where a volume begins within 1/256 of a pixel: see [`is_joint`].
///
/// - `look`: what the reference has on a ray from the eye
/// - `is_side_between`: whether that boundary lies between two places
/// - `begins_between`: whether a volume begins at a joint of what is seen at two places
pub fn is_within_rounding(
    view: &DeckCamera,
    at: usize,
    light: Light,
    look: impl Fn(DVec3) -> (Seen, Light),
    is_side_between: impl Fn(DVec3, DVec3) -> bool,
    begins_between: impl Fn(SeenPlace, SeenPlace) -> bool,
) -> bool {
    let [column, row] = view.pixel(at);
    let look = |way: [i32; 2], step_px: f64| {
        let beside = way.map(|steps| f64::from(steps) * step_px);
        let ray = view.ray_beside(column, row, beside);
        let (seen, light) = look(ray);
        let place = seen.depth().map(|depth| view.eye + ray * depth);
        (light, place.map(|place| SeenPlace { seen, place }))
    };
    let (_, own) = look([0, 0], 0.0);
    // In the gap between two containers, which pixels in a row see edge-on, no diagonal place lies.
    let ways = || (-1..=1).flat_map(|right| (-1..=1).map(move |down| [right, down]));
    let is_other_light = |way| {
        let (found, _) = look(way, ROUNDING_PX);
        found == light || matches!(found, Light::EdgeOn | Light::Undecided)
    };
    // Every side of every caster is asked, so along the diagonals alone, and last.
    let diagonals = || ways().filter(|way| !way.contains(&0));
    let is_side_crossed = |way: [i32; 2]| {
        let ends = own.zip(look(way, ROUNDING_PX).1);
        ends.is_some_and(|(own, other)| is_side_between(own.place, other.place))
    };
    let is_joint_crossed = |way: [i32; 2]| {
        let ends = own.zip(look(way, EDGE_PX).1);
        ends.is_some_and(|(own, other)| !own.is_beside(other) && begins_between(own, other))
    };
    ways().any(is_other_light)
        || diagonals().any(is_side_crossed)
        || diagonals().any(is_joint_crossed)
}

/// Whether a silhouette edge lies between the rays to two places, in both surfaces that are seen there: the joint where
/// a caster stands on another.
///
/// There three triangles meet: the caster's face, which is its light cap, the side of its volume, and what it stands on.
/// Rounded corners may take the pixel's centre from the face to the other two, but depths are not rounded with them. At
/// that centre the side then lies before what the caster stands on, and it is counted: the pixel is dark, though nothing
/// beside it is.
///
/// - `away`: how far a place is from the surface of what is seen, m
pub fn is_joint(
    eye: DVec3,
    own: SeenPlace,
    other: SeenPlace,
    [from, to]: [DVec3; 2],
    away: impl Fn(Seen, DVec3) -> f64,
) -> bool {
    let (u, v) = (own.place - eye, other.place - eye);
    let normal = u.cross(v);
    let [of_from, of_to] = [from, to].map(|place| (place - eye).dot(normal));
    if (of_from < 0.0) == (of_to < 0.0) {
        return false;
    }
    let met = from + (to - from) * (of_from / (of_from - of_to));
    let along = met - eye;
    let is_between = along.cross(v).dot(normal) >= 0.0 && u.cross(along).dot(normal) >= 0.0;
    // As near as places from the eye are rounded.
    let rounding_m = along.length() * f64::from(f32::EPSILON);
    let lies_in = |at: SeenPlace| away(at.seen, met) <= rounding_m;
    is_between && lies_in(own) && lies_in(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall at y = 0 on a floor at z = 0, seen from y = −100, above.
    #[test]
    fn a_joint_is_an_edge_in_both_surfaces_between_two_rays() {
        let eye = DVec3::new(0.0, -100.0, 15.0);
        let seen = |triangle, place| SeenPlace {
            seen: Seen::Triangle(triangle, 100.0),
            place,
        };
        let wall = |z| seen(0, DVec3::new(0.0, 0.0, z));
        let floor = |y| seen(1, DVec3::new(1e-4, y, 0.0));
        let away = |seen, place: DVec3| match seen {
            Seen::Triangle(0, _) => place.y.abs(),
            _ => place.z.abs(),
        };
        let foot = |y, z| [-1.0, 1.0].map(|x| DVec3::new(x, y, z));
        let holds = |own, other, edge| is_joint(eye, own, other, edge, away);
        assert!(holds(wall(1e-4), floor(-1e-3), foot(0.0, 0.0)));
        assert!(holds(floor(-1e-3), wall(1e-4), foot(0.0, 0.0)));
        // Negative controls: a foot 50 µm over the floor, one before the wall, and one beside both rays.
        assert!(!holds(wall(1e-4), floor(-1e-3), foot(0.0, 5e-5)));
        assert!(!holds(wall(1e-4), floor(-1e-3), foot(-5e-5, 0.0)));
        assert!(!holds(wall(2e-4), wall(1e-4), foot(0.0, 0.0)));
        assert!(!holds(floor(-2e-3), floor(-1e-3), foot(0.0, 0.0)));
    }
}
