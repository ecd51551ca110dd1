// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a device's rounding alone may make the difference.

use crate::reference::{Light, Seen};
use crate::view::DeckCamera;
use glam::DVec3;

/// How far beside a pixel's centre a device may look: rasterisers round corners to 1/256 of a pixel, and a
/// triangle thinner than some of these steps has any depth across it.
pub const ROUNDING_PX: f64 = 8.0 / 256.0;

/// Whether a device's rounding may give a pixel this light.
///
/// It may where the reference, [`ROUNDING_PX`] beside the pixel's centre along rows, columns or both, has that light or
/// judges none. It may too where the boundary of a single part's shadow is crossed on the way there: within the shadow of
/// others it is no boundary of light.
///
/// - `look`: what the reference has on a ray from the eye
/// - `is_side_between`: whether that boundary lies between two places
pub fn is_within_rounding(
    view: &DeckCamera,
    at: usize,
    light: Light,
    look: impl Fn(DVec3) -> (Seen, Light),
    is_side_between: impl Fn(DVec3, DVec3) -> bool,
) -> bool {
    let [column, row] = view.pixel(at);
    let look = |way: [i32; 2]| {
        let beside = way.map(|steps| f64::from(steps) * ROUNDING_PX);
        let ray = view.ray_beside(column, row, beside);
        let (seen, light) = look(ray);
        (light, seen.depth().map(|depth| view.eye + ray * depth))
    };
    let (_, own) = look([0, 0]);
    // In the gap between two containers, which pixels in a row see edge-on, no diagonal place lies.
    let ways = || (-1..=1).flat_map(|right| (-1..=1).map(move |down| [right, down]));
    let is_other_light = |way| {
        let (found, _) = look(way);
        found == light || matches!(found, Light::EdgeOn | Light::Undecided)
    };
    // Every side of every caster is asked, so along the diagonals alone, and last.
    let is_side_crossed = |way: [i32; 2]| {
        let ends = own.zip(look(way).1);
        ends.is_some_and(|(own, other)| is_side_between(own, other))
    };
    ways().any(is_other_light) || ways().filter(|way| !way.contains(&0)).any(is_side_crossed)
}
