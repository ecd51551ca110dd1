// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far each tile is from the elevation at its full resolution.
//!
//! A tile's triangles miss the heights of its children's vertices by what is measured at each of them, and
//! the children miss the full resolution by their own error. The sum bounds the tile's error (as in
//! Lindstrom and Pascucci, 2002, §3.2), and is never below a child's. It takes one height for each vertex of
//! the finest tiles and a third more for all others.

use crate::tile::{CELLS, TileId};
use rayon::prelude::*;
use terrafill_elevation::{Elevation, Heights};

/// Cells as wide as this many samples show all that there is: what lies between is measured and added.
const STEPS_A_SAMPLE: f64 = 1.5;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// No height at full resolution is further from the tile's triangles than this, metres.
    pub(crate) error_m: f64,
    /// Of all vertices of the tile and of tiles in it.
    pub(crate) heights: Heights,
    /// Index of the first of four children.
    pub(crate) children: Option<usize>,
}

/// Tiles down to the elevation's full resolution.
#[derive(Debug)]
pub(crate) struct Tree {
    /// Of each root, the root first.
    roots: Vec<Vec<Node>>,
}

impl Tree {
    pub(crate) fn new(elevation: &Elevation) -> Self {
        let roots: Vec<TileId> = TileId::roots().collect();
        let grow = |id: &TileId| {
            let mut nodes = vec![measured(elevation, *id)];
            refine(elevation, *id, 0, &mut nodes);
            nodes
        };
        Self {
            roots: roots.par_iter().map(grow).collect(),
        }
    }

    pub(crate) fn root(&self, index: usize) -> Node {
        self.roots[index][0]
    }

    /// Children of a node of the tree of a root.
    pub(crate) fn children(&self, root: usize, node: Node) -> Option<[Node; 4]> {
        let first = node.children?;
        Some(std::array::from_fn(|i| self.roots[root][first + i]))
    }

    /// The largest error of any tile.
    pub(crate) fn max_error_m(&self) -> f64 {
        self.roots
            .iter()
            .map(|nodes| nodes[0].error_m)
            .fold(0.0, f64::max)
    }

    /// Tiles that were measured.
    #[cfg(test)]
    pub(crate) fn node_count(&self) -> usize {
        self.roots.iter().map(Vec::len).sum()
    }
}

/// Replaces the own error of the node at `index` by that against full resolution.
fn refine(elevation: &Elevation, id: TileId, index: usize, nodes: &mut Vec<Node>) {
    let spacing_deg = elevation.spacing_deg(&id.extent());
    let is_coarse = spacing_deg.is_some_and(|spacing| id.step_deg() > STEPS_A_SAMPLE * spacing);
    if !is_coarse || id.level >= crate::tile::MAX_LEVEL {
        // Detail below the last measured step is at most as large again: each step halves it.
        let error_m = 2.0 * nodes[index].error_m;
        let own = nodes[index].heights;
        nodes[index].error_m = error_m;
        nodes[index].heights = Heights {
            lowest_m: own.lowest_m - error_m,
            highest_m: own.highest_m + error_m,
        };
        return;
    }
    let first = nodes.len();
    nodes[index].children = Some(first);
    nodes.extend(id.children().map(|child| measured(elevation, child)));
    let mut below: f64 = 0.0;
    for (i, child) in id.children().into_iter().enumerate() {
        refine(elevation, child, first + i, nodes);
        below = below.max(nodes[first + i].error_m);
        nodes[index].heights = nodes[index].heights.union(nodes[first + i].heights);
    }
    nodes[index].error_m += below;
}

/// A tile by itself: how far its triangles are from its children's vertices.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a tile's vertices are a few hundred"
)]
fn measured(elevation: &Elevation, id: TileId) -> Node {
    let parts = 2 * CELLS;
    let side = parts + 1;
    let heights: Vec<f64> = (0..side * side)
        .map(|i| {
            let [longitude, latitude] = id.place([i % side, i / side], parts);
            elevation.height_m(longitude, latitude)
        })
        .collect();
    let at = |x: u32, y: u32| heights[(y * side + x) as usize];
    let mut error_m: f64 = 0.0;
    for y in 0..side {
        for x in 0..side {
            // Ends of the edge that a child's vertex halves; a cell's diagonal rises to the east.
            let ends = match (x % 2, y % 2) {
                (0, 0) => continue,
                (1, 0) => [(x - 1, y), (x + 1, y)],
                (0, _) => [(x, y - 1), (x, y + 1)],
                _ => [(x - 1, y - 1), (x + 1, y + 1)],
            };
            let between = 0.5 * (at(ends[0].0, ends[0].1) + at(ends[1].0, ends[1].1));
            error_m = error_m.max((at(x, y) - between).abs());
        }
    }
    let ranges = heights.iter().map(|&height_m| Heights {
        lowest_m: height_m,
        highest_m: height_m,
    });
    let start = Heights {
        lowest_m: f64::INFINITY,
        highest_m: f64::NEG_INFINITY,
    };
    Node {
        error_m,
        heights: ranges.fold(start, Heights::union),
        children: None,
    }
}
