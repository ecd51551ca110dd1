// SPDX-License-Identifier: MIT OR Apache-2.0
//! Silhouette edges by where they lie across the light, so that few are asked whether a short way crosses them.

use glam::{DVec2, DVec3};

/// Cells along either axis.
const CELLS: usize = 512;
/// A way is looked for so far beside itself, m: places of kilometres are rounded by 10⁻¹² m.
const MARGIN_M: f64 = 1e-6;

/// Edges sorted into cells.
pub(crate) struct SideGrid {
    axes: [DVec3; 2],
    low: DVec2,
    /// Cells a metre.
    scale: DVec2,
    cells: Vec<Vec<u32>>,
}

impl SideGrid {
    /// - `sides`: ends of each edge, m
    pub(crate) fn of(sides: &[[DVec3; 2]], to_light: DVec3) -> Self {
        let (first, second) = to_light.any_orthonormal_pair();
        let mut grid = Self {
            axes: [first, second],
            low: DVec2::ZERO,
            scale: DVec2::ONE,
            cells: vec![Vec::new(); CELLS * CELLS],
        };
        let places = || sides.iter().flatten().map(|place| grid.across(*place));
        let low = places().reduce(DVec2::min).unwrap_or_default();
        let extent = places().reduce(DVec2::max).unwrap_or_default() - low;
        grid.low = low;
        grid.scale = DVec2::splat(CELLS as f64) / extent.max(DVec2::splat(MARGIN_M));
        for (at, side) in (0_u32..).zip(sides) {
            for cell in grid.cells_between(*side) {
                grid.cells[cell].push(at);
            }
        }
        grid
    }

    fn across(&self, place: DVec3) -> DVec2 {
        DVec2::from(self.axes.map(|axis| place.dot(axis)))
    }

    /// Cells that the rectangle round two places meets.
    fn cells_between(&self, ends: [DVec3; 2]) -> impl Iterator<Item = usize> + use<> {
        let [a, b] = ends.map(|place| self.across(place));
        let cell = |place: DVec2| {
            let at = (place - self.low) * self.scale;
            at.to_array().map(inside)
        };
        let [first_column, first_row] = cell(a.min(b) - MARGIN_M);
        let [last_column, last_row] = cell(a.max(b) + MARGIN_M);
        let rows = first_row..=last_row;
        rows.flat_map(move |row| (first_column..=last_column).map(move |at| row * CELLS + at))
    }

    /// Edges that may cross a way, some of them more than once.
    pub(crate) fn near(&self, own: DVec3, other: DVec3) -> impl Iterator<Item = usize> + '_ {
        let cells = self.cells_between([own, other]);
        cells.flat_map(|cell| self.cells[cell].iter().map(|at| *at as usize))
    }
}

/// The nearest cell: beyond the last one nothing lies, and to be asked in vain does no harm.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "whole and within the cells"
)]
fn inside(at: f64) -> usize {
    at.clamp(0.0, (CELLS - 1) as f64) as usize
}

#[cfg(test)]
mod tests {
    use crate::work::Scene;
    use terrafill_shadow_views::bridge;

    #[test]
    fn edges_near_a_way_are_all_that_cross_it_and_few_others() {
        let views = vec![bridge([48, 36])[4]];
        let scene = Scene::of_port([10.0, -60.0], views).expect("a port");
        let (view, truth) = (&scene.views[0], &scene.truths()[0]);
        let (mut crossed, mut asked, mut ways) = (0, 0, 0);
        for at in 0..view.pixel_count() {
            let [column, row] = view.pixel(at);
            let place = |beside| {
                let ray = view.ray_beside(column, row, beside);
                truth.seen[at].depth().map(|depth| view.eye + ray * depth)
            };
            let Some((own, other)) = place([0.0; 2]).zip(place([0.5; 2])) else {
                continue;
            };
            let of_all = (0..scene.sides.len()).any(|side| scene.crosses(side, own, other));
            assert_eq!(scene.is_side_between(own, other), of_all, "pixel {at}");
            asked += scene.side_grid().near(own, other).count();
            crossed += usize::from(of_all);
            ways += 1;
        }
        // Negative control: some are crossed, and most are not.
        assert!(crossed > 50 && crossed < ways / 2, "{crossed} of {ways}");
        assert!(asked < ways * scene.sides.len() / 50, "{asked}");
    }
}
