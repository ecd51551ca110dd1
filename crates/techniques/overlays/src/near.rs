// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles are near a box: an R*-tree of their boxes.
//!
//! Metres from the eye, ECEF axes, `f64`. Sizes may differ by any factor: a surface made for a view has triangles
//! of centimetres at the eye and of hundreds of kilometres at the horizon.

use glam::DVec3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// A box along the axes.
pub(crate) type Bounds = AABB<[f64; 3]>;

/// The box of some points.
pub(crate) fn bounds_of(points: &[DVec3]) -> Bounds {
    let fold = |bound: fn(DVec3, DVec3) -> DVec3| points.iter().copied().reduce(bound);
    let [low, high] = [fold(DVec3::min), fold(DVec3::max)].map(Option::unwrap_or_default);
    AABB::from_corners(low.to_array(), high.to_array())
}

/// Boxes of triangles.
#[derive(Debug)]
pub(crate) struct Boxes(RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>);

impl Boxes {
    pub(crate) fn new(boxes: impl IntoIterator<Item = Bounds>) -> Self {
        let boxes = boxes.into_iter().enumerate();
        let entries = boxes.map(|(index, own)| GeomWithData::new(Rectangle::from_aabb(own), index));
        Self(RTree::bulk_load(entries.collect()))
    }

    /// Indices of the boxes that overlap `wanted`, each once, ascending.
    pub(crate) fn near(&self, wanted: &Bounds) -> Vec<usize> {
        let found = self.0.locate_in_envelope_intersecting(*wanted);
        let mut near: Vec<usize> = found.map(|entry| entry.data).collect();
        near.sort_unstable();
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64, width: f64) -> Bounds {
        let low = DVec3::new(x, y, -x);
        bounds_of(&[low, low + width])
    }

    fn overlap(a: &Bounds, b: &Bounds) -> bool {
        (0..3).all(|axis| a.lower()[axis] <= b.upper()[axis] && b.lower()[axis] <= a.upper()[axis])
    }

    #[test]
    fn every_box_that_overlaps_is_found_once() {
        let all: Vec<Bounds> = (0..400_i32)
            .map(|i| {
                let [x, y] = [i % 20, i / 20].map(f64::from);
                cube(
                    3.0 * x - 31.0,
                    2.0 * y - 11.0,
                    1.0 + 0.07 * f64::from(i % 13),
                )
            })
            .collect();
        let boxes = Boxes::new(all.iter().copied());
        for wanted in [
            cube(-4.0, 3.0, 0.5),
            cube(-20.0, -20.0, 60.0),
            cube(1.0, 1.0, 7.0),
        ] {
            let one_by_one: Vec<usize> = (0..all.len())
                .filter(|&index| overlap(&all[index], &wanted))
                .collect();
            assert!(!one_by_one.is_empty());
            assert_eq!(boxes.near(&wanted), one_by_one);
        }
        // Negative control: what is far off finds nothing.
        assert!(boxes.near(&cube(1e6, 0.0, 1.0)).is_empty());
    }

    /// A search through pieces of space as wide as the boxes are on average, 1.2 km, would visit 10¹² of them.
    #[test]
    fn a_search_as_wide_as_a_planet_among_boxes_of_centimetres_ends() {
        let small = (0..10_000).map(|i| cube(f64::from(i) * 0.01, 0.0, 0.01));
        let around = |low: f64, high: f64| bounds_of(&[low, high].map(DVec3::splat));
        let boxes = Boxes::new(small.chain([around(-6e6, 6e6)]));
        assert_eq!(boxes.near(&around(-7e6, 7e6)).len(), 10_001);
        assert_eq!(boxes.near(&around(1e6, 2e6)), [10_000]);
    }
}
