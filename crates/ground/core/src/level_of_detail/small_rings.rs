// SPDX-License-Identifier: MIT OR Apache-2.0
//! Islands and lakes too small for a level: left out, and told.
//!
//! A level is drawn where its tolerance is half a pixel at most. A ring of half a tolerance is then a quarter
//! of a pixel at most; three vertices of it cost as much as those of a coast. Leaving it out moves the
//! boundary by less than its own size, which is within the tolerance. A ring that has a vertex in common
//! with another stays, or a border would have one side; and so does the largest of a region's shells.

use super::arcs::{Arcs, RingVertices};
use crate::{Ellipsoid, Polygon, Region};

/// Rings of less than this share of a level's tolerance are left out.
pub(super) const DROPPED_SHARE: f64 = 0.5;

/// Rings that a level leaves out of a region.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeftOutRings {
    /// How many.
    pub rings: usize,
    /// All of them together are no larger, square metres.
    pub area_m2: f64,
    /// The largest is no wider, metres.
    pub size_m: f64,
}

impl LeftOutRings {
    fn add(&mut self, size_m: f64) {
        self.rings += 1;
        // A box of this diagonal.
        self.area_m2 += size_m * size_m / 2.0;
        self.size_m = self.size_m.max(size_m);
    }
}

/// Of each ring in the order of the regions, its size where it may be left out; infinite where it has a
/// vertex in common with another or with itself.
pub(super) fn sizes_m(arcs: &Arcs<'_>, body: &Ellipsoid) -> Vec<f64> {
    let mut uses = vec![0_u32; arcs.vertices.len()];
    for ring in &arcs.rings {
        for &vertex in &ring.vertices {
            uses[vertex as usize] += 1;
        }
    }
    let size_m = |ring: &RingVertices<'_>| {
        let is_alone = |vertex: &u32| uses[*vertex as usize] == 1;
        match ring.vertices.iter().all(is_alone) {
            true => arcs.size_m(body, ring),
            false => f64::INFINITY,
        }
    };
    arcs.rings.iter().map(size_m).collect()
}

/// Takes the rings out of `regions`, which have all of them, that are too small for a level.
///
/// - `sizes_m`: of each ring, by [`sizes_m`]
pub(super) fn leave_out(
    sizes_m: &[f64],
    tolerance_m: f64,
    regions: &mut [Region],
) -> Vec<LeftOutRings> {
    let smallest_m = DROPPED_SHARE * tolerance_m;
    let mut sizes = sizes_m.iter().copied();
    let mut next = move || sizes.next().unwrap_or(f64::INFINITY);
    let of_region = |region: &mut Region| {
        let mut left_out = LeftOutRings::default();
        let mut shells = Vec::with_capacity(region.polygons.len());
        for polygon in &mut region.polygons {
            shells.push(next());
            polygon.holes.retain(|_| {
                let size_m = next();
                if size_m < smallest_m {
                    left_out.add(size_m);
                }
                size_m >= smallest_m
            });
        }
        let largest = shells.iter().copied().fold(0.0, f64::max);
        let mut has_largest = false;
        let polygons: Vec<Polygon> = std::mem::take(&mut region.polygons);
        for (polygon, size_m) in polygons.into_iter().zip(shells) {
            let is_first_largest = !has_largest && size_m >= largest;
            has_largest |= is_first_largest;
            // In a hole that stays lies something else.
            if size_m >= smallest_m || is_first_largest || !polygon.holes.is_empty() {
                region.polygons.push(polygon);
            } else {
                left_out.add(size_m);
            }
        }
        left_out
    };
    regions.iter_mut().map(of_region).collect()
}
