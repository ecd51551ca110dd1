// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a device's rounding alone may make the difference.

use super::Scene;
use super::side_grid::SideGrid;
use glam::DVec3;
use terrafill_casters::Side;
use terrafill_shadow_views::{
    DeckCamera, Light, Reference, SeenPlace, is_joint, is_within_rounding,
};

impl Scene {
    /// Whether a device's rounding may give a pixel this light.
    pub(crate) fn is_within_rounding(
        &self,
        reference: &Reference<'_>,
        view: &DeckCamera,
        at: usize,
        light: Light,
    ) -> bool {
        let look = |ray: DVec3| {
            let seen = reference.seen(view.eye, ray, view.near);
            (seen, reference.light(view, ray, seen))
        };
        let is_side_between = |own, other| self.is_side_between(own, other);
        let begins_between = |own: SeenPlace, other: SeenPlace| {
            self.sides.iter().any(|side| {
                let edge = side.map(|vertex| self.mesh().vertices[vertex as usize]);
                is_joint(view.eye, own, other, edge, |seen, place| {
                    reference.away(seen, place)
                })
            })
        };
        is_within_rounding(view, at, light, look, is_side_between, begins_between)
    }

    /// Whether the boundary of a part's shadow lies between two places: a silhouette edge crosses what is
    /// sunwards of the way from one to the other.
    pub(super) fn is_side_between(&self, own: DVec3, other: DVec3) -> bool {
        let mut near = self.side_grid().near(own, other);
        near.any(|side| self.crosses(side, own, other))
    }

    pub(super) fn side_grid(&self) -> &SideGrid {
        self.side_grid.get_or_init(|| {
            let ends = |side: &Side| side.map(|vertex| self.mesh().vertices[vertex as usize]);
            let sides: Vec<[DVec3; 2]> = self.sides.iter().map(ends).collect();
            SideGrid::of(&sides, self.to_light)
        })
    }

    /// Whether a silhouette edge is sunwards of the way from one place to another.
    pub(super) fn crosses(&self, side: usize, own: DVec3, other: DVec3) -> bool {
        let way = other - own;
        let normal = way.cross(self.to_light);
        let (across, sunwards) = (self.to_light.cross(normal), way.cross(normal));
        let ends = self.sides[side].map(|vertex| self.mesh().vertices[vertex as usize] - own);
        let [of_a, of_b] = ends.map(|place| place.dot(normal));
        if (of_a < 0.0) == (of_b < 0.0) {
            return false;
        }
        let [a, b] = ends;
        let met = a + (b - a) * (of_a / (of_a - of_b));
        let share = met.dot(across) / way.dot(across);
        let height = met.dot(sunwards) / self.to_light.dot(sunwards);
        (0.0..=1.0).contains(&share) && height > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_casters::row;

    #[test]
    fn rounding_excuses_few_pixels_outside_the_band() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let reference = Reference::new(scene.mesh(), scene.to_light);
        let (mut excused, mut all) = (0, 0);
        for (view, truth) in scene.channels() {
            for at in (0..truth.light.len()).filter(|at| !truth.band[*at]) {
                let other = match truth.light[at] {
                    Light::Lit => Light::Shadow,
                    Light::Shadow => Light::Lit,
                    _ => continue,
                };
                all += 1;
                let is_excused = scene.is_within_rounding(&reference, view, at, other);
                excused += usize::from(is_excused);
            }
        }
        // 116 of 9,170.
        assert!(all > 5_000 && 50 * excused < all, "{excused} of {all}");
        assert!(excused > 0);
    }

    #[test]
    fn a_side_lies_between_light_and_shadow_and_not_within_either() {
        let plate = [3.0, 5.0].map(|y| DVec3::new(0.0, y, 0.0));
        let scene = Scene::of(row(1), [30.0, 180.0], Vec::new()).expect("a plate");
        // 25 m high, under a sun at 30°: 43.3 m of shadow.
        let at = |x: f64| plate[0] + DVec3::X * x;
        assert!(scene.is_side_between(at(40.0), at(50.0)));
        assert!(!scene.is_side_between(at(10.0), at(40.0)));
        assert!(!scene.is_side_between(at(50.0), at(60.0)));
    }
}
