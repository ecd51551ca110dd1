// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which triangles are near a box: a hash of cubes.
//!
//! Metres from the eye, ECEF axes, `f64`. A cube is as wide as a triangle is on average, so that most
//! triangles lie in a few.

use glam::{DVec3, I64Vec3};
use std::collections::HashMap;

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Bounds {
    pub(crate) fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        let nothing = Self {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        points.into_iter().fold(nothing, |bounds, point| Self {
            low: bounds.low.min(point),
            high: bounds.high.max(point),
        })
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Boxes of triangles, by the cubes that they touch.
#[derive(Debug)]
pub(crate) struct Grid {
    cube_m: f64,
    cubes: HashMap<I64Vec3, Vec<u32>>,
    bounds: Vec<Bounds>,
    /// Of each box, the last search that found it.
    found_by: Vec<u32>,
    searches: u32,
}

impl Grid {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a surface has fewer than 2^32 triangles"
    )]
    pub(crate) fn new(bounds: Vec<Bounds>) -> Self {
        let widths = bounds.iter().map(|own| (own.high - own.low).max_element());
        let cube_m = (widths.sum::<f64>() / bounds.len().max(1) as f64).max(1e-3);
        let mut grid = Self {
            cube_m,
            cubes: HashMap::new(),
            found_by: vec![0; bounds.len()],
            searches: 0,
            bounds: Vec::new(),
        };
        for (index, own) in bounds.iter().enumerate() {
            for cube in grid.touched(own) {
                grid.cubes.entry(cube).or_default().push(index as u32);
            }
        }
        grid.bounds = bounds;
        grid
    }

    fn touched(&self, bounds: &Bounds) -> impl Iterator<Item = I64Vec3> + use<> {
        let [low, high] =
            [bounds.low, bounds.high].map(|end| (end / self.cube_m).floor().as_i64vec3());
        (low.x..=high.x).flat_map(move |x| {
            (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| I64Vec3::new(x, y, z)))
        })
    }

    /// Indices of the boxes that overlap `wanted`, each once, ascending.
    pub(crate) fn near(&mut self, wanted: &Bounds) -> Vec<usize> {
        self.searches += 1;
        let mut near = Vec::new();
        for cube in self.touched(wanted) {
            for &index in self.cubes.get(&cube).map_or(&[][..], Vec::as_slice) {
                let index = index as usize;
                let is_new = self.found_by[index] != self.searches;
                self.found_by[index] = self.searches;
                if is_new && self.bounds[index].overlaps(wanted) {
                    near.push(index);
                }
            }
        }
        near.sort_unstable();
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f64, y: f64, width: f64) -> Bounds {
        let low = DVec3::new(x, y, -x);
        Bounds {
            low,
            high: low + width,
        }
    }

    #[test]
    fn every_box_that_overlaps_is_found_once() {
        let boxes: Vec<Bounds> = (0..400_i32)
            .map(|i| {
                let [x, y] = [i % 20, i / 20].map(f64::from);
                cube(
                    3.0 * x - 31.0,
                    2.0 * y - 11.0,
                    1.0 + 0.07 * f64::from(i % 13),
                )
            })
            .collect();
        let mut grid = Grid::new(boxes.clone());
        for wanted in [
            cube(-4.0, 3.0, 0.5),
            cube(-20.0, -20.0, 60.0),
            cube(1.0, 1.0, 7.0),
        ] {
            let one_by_one: Vec<usize> = (0..boxes.len())
                .filter(|&index| boxes[index].overlaps(&wanted))
                .collect();
            assert!(!one_by_one.is_empty());
            assert_eq!(grid.near(&wanted), one_by_one);
        }
        // Twin: what is far off finds nothing.
        assert!(grid.near(&cube(1e6, 0.0, 1.0)).is_empty());
    }
}
