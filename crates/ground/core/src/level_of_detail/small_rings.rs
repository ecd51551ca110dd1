// SPDX-License-Identifier: MIT OR Apache-2.0
//! Islands and lakes too small for a level: left out, and told.
//!
//! A level is drawn where its tolerance is half a pixel at most. A ring of half a tolerance is then a quarter
//! of a pixel at most; three vertices of it cost as much as those of a coast. Leaving it out moves the
//! boundary by less than its own size, which is within the tolerance. A ring that has a vertex in common
//! with another stays, or a border would have one side; and so does the largest of a region's shells.

use super::arcs::{Arcs, RingVertices};
use crate::{Ellipsoid, Region};

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
pub(super) fn sizes_m(arcs: &Arcs, body: &Ellipsoid) -> Vec<f64> {
    let mut uses = vec![0_u32; arcs.vertices.len()];
    for ring in &arcs.rings {
        for &vertex in &ring.vertices {
            uses[vertex as usize] += 1;
        }
    }
    let size_m = |ring: &RingVertices| {
        let is_alone = |vertex: &u32| uses[*vertex as usize] == 1;
        if ring.vertices.iter().all(is_alone) {
            arcs.size_m(body, ring)
        } else {
            f64::INFINITY
        }
    };
    arcs.rings.iter().map(size_m).collect()
}

/// The rings of `regions` that are too small for a level: whether each is, and what that is of each region.
///
/// - `sizes_m`: of each ring, by [`sizes_m`]
pub(super) fn too_small(
    sizes_m: &[f64],
    tolerance_m: f64,
    regions: &[Region],
) -> (Vec<bool>, Vec<LeftOutRings>) {
    let smallest_m = DROPPED_SHARE * tolerance_m;
    let mut is_left_out = vec![false; sizes_m.len()];
    let mut first = 0;
    let of_region = |region: &Region| {
        let mut left_out = LeftOutRings::default();
        let mut shells = Vec::with_capacity(region.polygons.len());
        for polygon in &region.polygons {
            let holes = first + 1..first + 1 + polygon.holes.len();
            shells.push((first, holes.clone()));
            first = holes.end;
            for hole in holes {
                is_left_out[hole] = sizes_m[hole] < smallest_m;
            }
        }
        let sizes = shells.iter().map(|(shell, _)| sizes_m[*shell]);
        let largest = sizes.fold(0.0, f64::max);
        let mut has_largest = false;
        for (shell, holes) in shells {
            let is_first_largest = !has_largest && sizes_m[shell] >= largest;
            has_largest |= is_first_largest;
            // In a hole that stays lies something else.
            let is_empty = holes.clone().all(|hole| is_left_out[hole]);
            is_left_out[shell] = sizes_m[shell] < smallest_m && !is_first_largest && is_empty;
            let rings = std::iter::once(shell).chain(holes);
            for ring in rings.filter(|&ring| is_left_out[ring]) {
                left_out.add(sizes_m[ring]);
            }
        }
        left_out
    };
    let left_out = regions.iter().map(of_region).collect();
    (is_left_out, left_out)
}

/// Takes the rings out of `regions`, which have all of them, that [`too_small`] names.
pub(super) fn leave_out(is_left_out: &[bool], regions: &mut [Region]) {
    let mut is_left_out = is_left_out.iter();
    let mut stays = || is_left_out.next() != Some(&true);
    for polygons in regions.iter_mut().map(|region| &mut region.polygons) {
        polygons.retain_mut(|polygon| {
            let shell_stays = stays();
            polygon.holes.retain(|_| stays());
            shell_stays
        });
    }
}
