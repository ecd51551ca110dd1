// SPDX-License-Identifier: MIT OR Apache-2.0
//! The paper's one buffer: a whole spiral as (sine, cosine, radius), from a metre-wide fan to a quarter of the body,
//! made once. A frame draws a range of it; nothing of it is sent again.

use super::spiral::{Spiral, number_of, stored_radius};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;
use terrafill_core::nearest_f32;

/// Vertices and indices that never change, and how a frame draws them.
#[derive(Debug, Clone)]
pub(crate) struct StoredSpiral {
    /// Sine and cosine of the direction, and the radius in radians.
    pub(crate) vertices: Vec<[f32; 3]>,
    /// The fan's, about vertex 0, then those between turns.
    pub(crate) indices: Vec<u32>,
    per_turn: u32,
}

/// Draw arguments: of the fan, whose vertex 0 is that before the first of the view, and of the turns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DrawnRange {
    pub(crate) fan: Range<u32>,
    pub(crate) base_vertex: i32,
    pub(crate) turns: Range<u32>,
}

impl StoredSpiral {
    pub(crate) fn new(per_turn: u32) -> Self {
        let n = per_turn;
        // Past the farthest horizon there is one turn more, which ends on it.
        let last = number_of(FRAC_PI_2, n) + 2 * n;
        let vertices = (0..=last).map(|k| {
            let (sin, cos) = (TAU * f64::from(k % n) / f64::from(n)).sin_cos();
            [sin, cos, stored_radius(k, n)].map(nearest_f32)
        });
        let mut indices = Vec::new();
        for k in 0..n - 1 {
            indices.extend([0, k + 2, k + 1]);
        }
        // The first turn begins on the fan's last spoke: two triangles for one, so that its first vertex is no T.
        indices.extend([0, 1, n, 1, n + 1, n]);
        for k in 0..last - n {
            indices.extend([k, k + 1, k + n, k + 1, k + n + 1, k + n]);
        }
        Self {
            vertices: vertices.collect(),
            indices,
            per_turn,
        }
    }

    /// What of it a view draws.
    pub(crate) fn range(&self, spiral: &Spiral) -> DrawnRange {
        let fan = 3 * (self.per_turn + 1);
        let first = fan + 6 * spiral.first;
        DrawnRange {
            fan: 0..fan,
            // Directions go round with the number, so a fan may begin anywhere.
            base_vertex: i32::try_from(spiral.first).unwrap_or(i32::MAX) - 1,
            turns: first..first + 6 * spiral.rim() - 3,
        }
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(self.vertices.as_slice()) + size_of_val(self.indices.as_slice())) as u64
    }

    /// Triangles of a range, as a device draws them.
    #[cfg(test)]
    fn drawn(&self, range: &DrawnRange) -> Vec<[u32; 3]> {
        let whole = |range: &Range<u32>, base: i32| {
            let indices = &self.indices[range.start as usize..range.end as usize];
            let indices = indices.iter().map(|index| index.wrapping_add_signed(base));
            indices.collect::<Vec<u32>>()
        };
        let mut all = whole(&range.fan, range.base_vertex);
        all.extend(whole(&range.turns, 0));
        all.chunks_exact(3)
            .map(|three| [three[0], three[1], three[2]])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::List;
    use crate::made::spiral::Law;

    #[test]
    fn a_range_of_the_buffer_is_the_mesh_of_its_view() {
        let list = List::shipped().expect("a list");
        for n in [36, 47, 72] {
            let stored = StoredSpiral::new(n);
            for view in ["globe", "nadir-10km", "ground-1.7m"] {
                let eye = list.view(view).expect("the view").eye(160);
                let spiral = Spiral::new(&eye, n, Law::Exponential, None);
                let range = stored.range(&spiral);
                // The vertex before the first of the view is the centre, as number 0 is in a mesh of its own.
                let before = spiral.first - 1;
                let own = stored.drawn(&range).into_iter();
                let own: Vec<[u32; 3]> = own.map(|three| three.map(|k| k - before)).collect();
                assert_eq!(own, spiral.triangles(), "{view} {n}");
                let last = own.as_flattened().iter().max().copied();
                assert_eq!(last, Some(spiral.count() - 1));
                // Negative control: a range that begins one later is another mesh.
                let later = DrawnRange {
                    base_vertex: range.base_vertex + 1,
                    ..range.clone()
                };
                assert_ne!(stored.drawn(&later), stored.drawn(&range));
            }
        }
    }
}
