// SPDX-License-Identifier: MIT OR Apache-2.0
//! Large regions drawn in parts: what is seen of them, as ranges of the indices that a technique stores.

use std::collections::BTreeMap;
use std::ops::Range;
use terrafill_contract::FillInput;
use terrafill_core::{RegionMesh, index_u32};
use terrafill_plan::SeenParts;

/// What is drawn of each mesh of which not all is, by its number.
pub type DrawnOfMeshes = BTreeMap<usize, DrawnParts>;

/// How many indices walls take, loop after loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WallIndices {
    /// For each edge.
    pub per_edge: u32,
    /// For each loop beside that: its first vertex again, and what ends a strip.
    pub per_loop: u32,
    /// That a draw of some edges reads beyond their own.
    pub closing: u32,
}

impl WallIndices {
    /// Two triangles for each edge.
    pub const LIST: Self = Self {
        per_edge: 6,
        per_loop: 0,
        closing: 0,
    };
    /// A triangle strip for each loop, closed and followed by a restart.
    pub const STRIP: Self = Self {
        per_edge: 2,
        per_loop: 3,
        closing: 2,
    };
    /// A line strip for each loop, closed and followed by a restart.
    pub const LINE_STRIP: Self = Self {
        per_edge: 1,
        per_loop: 2,
        closing: 1,
    };
    /// Six vertices without indices for each entry of a list of loops, closed and followed by a separator.
    pub const PULLED: Self = Self {
        per_edge: 6,
        per_loop: 12,
        closing: 0,
    };
}

/// What is drawn of a mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DrawnParts {
    /// Of the indices of a cap whose triangles lie part by part ([`terrafill_plan::PartOrder`]).
    pub caps: Vec<Range<u32>>,
    /// Of the indices of the walls.
    pub walls: Vec<Range<u32>>,
}

impl DrawnParts {
    /// Of the meshes of which a view leaves parts out.
    #[must_use]
    pub fn of_view(input: &FillInput, walls: WallIndices) -> DrawnOfMeshes {
        let seen = input.plan.seen_parts.iter();
        let some = seen.filter(|(_, seen)| seen.facets_left_out > 0);
        some.map(|(&mesh, seen)| (mesh, Self::new(&input.scene.meshes[mesh], seen, walls)))
            .collect()
    }

    /// Of one mesh.
    #[must_use]
    pub fn new(mesh: &RegionMesh, seen: &SeenParts, indices: WallIndices) -> Self {
        let mut firsts = Vec::with_capacity(mesh.boundary_loops.len());
        let mut first = 0;
        for ring in &mesh.boundary_loops {
            firsts.push(first);
            first += indices.per_edge * index_u32(ring.len()) + indices.per_loop;
        }
        let wall = |(ring, edges): (usize, Range<u32>)| {
            let [start, end] = [edges.start, edges.end].map(|edge| edge * indices.per_edge);
            firsts[ring] + start..firsts[ring] + end + indices.closing
        };
        let caps = seen.caps.iter();
        Self {
            caps: caps.map(|range| 3 * range.start..3 * range.end).collect(),
            walls: seen.walls_by_loop(mesh).into_iter().map(wall).collect(),
        }
    }

    /// Ranges of both caps, or of the top alone.
    ///
    /// - `cap`: indices of one cap
    #[must_use]
    pub fn both_caps(&self, cap: u32, with_bottom: bool) -> Vec<Range<u32>> {
        let bottom = self.caps.iter().filter(|_| with_bottom);
        let bottom = bottom.map(|range| cap + range.start..cap + range.end);
        self.caps.iter().cloned().chain(bottom).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_caps_are_drawn_where_the_bottom_is() {
        let parts = DrawnParts {
            caps: vec![0..6, 12..15],
            walls: Vec::new(),
        };
        assert_eq!(parts.both_caps(30, false), [0..6, 12..15]);
        assert_eq!(parts.both_caps(30, true), [0..6, 12..15, 30..36, 42..45]);
    }
}
