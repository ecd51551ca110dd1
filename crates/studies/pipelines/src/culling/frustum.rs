// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boxes against the planes of a view on the CPU, in `f64`: level 1, and level 2 where the CPU does it.

use super::ground::{Ground, PATCH_CELLS, TILES};
use glam::DVec3;
use terrafill_shapes::grid::{GridCamera, NEAR_M};

/// The four sides and the near plane of a view; normals point inwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frustum([(DVec3, f64); 5]);

impl Frustum {
    pub(crate) fn new(view: &GridCamera) -> Self {
        let side = |axis: DVec3| {
            let normal = view.forward * view.tan_half + axis;
            (normal, -normal.dot(view.eye))
        };
        let near = -view.forward.dot(view.eye) - NEAR_M;
        Self([
            side(view.right),
            side(-view.right),
            side(view.up),
            side(-view.up),
            (view.forward, near),
        ])
    }

    /// Whether a box is not wholly outside of one plane.
    fn may_hold(&self, [low, high]: [DVec3; 2]) -> bool {
        self.0.iter().all(|(normal, offset)| {
            let inner = (*normal * low).max(*normal * high);
            inner.element_sum() + offset >= 0.0
        })
    }

    /// Numbers of the tiles in view.
    pub(crate) fn tiles(&self, ground: &Ground) -> Vec<u32> {
        let cells = ground.tile_cells();
        let numbers = (0..TILES * TILES).zip(&ground.tile_boxes);
        let kept =
            numbers.filter(|(tile, heights)| self.may_hold(ground.bounds(*tile, cells, **heights)));
        kept.map(|(tile, _)| tile).collect()
    }

    /// Numbers of the patches in view among those of some tiles.
    pub(crate) fn patches(&self, ground: &Ground, tiles: &[u32]) -> Vec<u32> {
        let all = tiles.iter().flat_map(|tile| ground.patches_of(*tile));
        let is_kept = |patch: &u32| {
            let heights = ground.patch_boxes[*patch as usize];
            self.may_hold(ground.bounds(*patch, PATCH_CELLS, heights))
        };
        all.filter(is_kept).collect()
    }
}
