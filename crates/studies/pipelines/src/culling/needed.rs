// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference: patches of which a cell is not wholly outside of one plane of the view, in `f64`.
//!
//! Every vertex of the ground is projected; no box, no plane and no matrix of what culls is used.

use super::ground::PATCH_CELLS;
use glam::DVec3;
use terrafill_shapes::grid::{Grid, GridCamera, NEAR_M};

/// What a list of kept patches has too few and too many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Missed {
    /// Needed and not kept.
    pub(crate) lost: usize,
    /// Kept and not needed.
    pub(crate) extra: usize,
}

/// Of each patch whether it is needed, row by row.
pub(crate) fn needed(grid: &Grid, view: &GridCamera) -> Vec<bool> {
    let patches = (grid.cells / PATCH_CELLS) as usize;
    let mut needed = vec![false; patches * patches];
    let mut above = sides_of_row(grid, view, 0);
    for row in 0..grid.cells {
        let below = sides_of_row(grid, view, row + 1);
        let first = (row / PATCH_CELLS) as usize * patches;
        let pairs = above.windows(2).zip(below.windows(2));
        for (column, (over, under)) in pairs.enumerate() {
            // Outside where one side has all four corners.
            if over[0] & over[1] & under[0] & under[1] == 0 {
                needed[first + column / PATCH_CELLS as usize] = true;
            }
        }
        above = below;
    }
    needed
}

/// Of each vertex of a row a bit for every plane that it is outside of.
fn sides_of_row(grid: &Grid, view: &GridCamera, row: u32) -> Vec<u8> {
    let step_m = grid.step_m();
    let first = grid.index(0, row);
    let heights = &grid.heights[first..=first + grid.cells as usize];
    let y = f64::from(row) * step_m;
    let columns = (0_u32..).zip(heights);
    let sides = columns.map(|(column, &height)| {
        let place = DVec3::new(f64::from(column) * step_m, y, f64::from(height));
        let from_eye = place - view.eye;
        let away = from_eye.dot(view.forward);
        let (across, upwards) = (from_eye.dot(view.right), from_eye.dot(view.up));
        let edge = away * view.tan_half;
        u8::from(across > edge)
            | u8::from(-across > edge) << 1
            | u8::from(upwards > edge) << 2
            | u8::from(-upwards > edge) << 3
            | u8::from(away < NEAR_M) << 4
    });
    sides.collect()
}

/// Holds a list against what is needed; `None` where a number is no patch's or is listed twice.
pub(crate) fn missed(needed: &[bool], kept: &[u32]) -> Option<Missed> {
    let mut is_kept = vec![false; needed.len()];
    for &patch in kept {
        let first = is_kept.get_mut(patch as usize)?;
        if std::mem::replace(first, true) {
            return None;
        }
    }
    let count = |lost: bool| {
        let pairs = needed.iter().zip(&is_kept);
        pairs.filter(move |(needed, kept)| **needed == lost && **kept != lost)
    };
    Some(Missed {
        lost: count(true).count(),
        extra: count(false).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::frustum::Frustum;
    use super::super::ground::Ground;
    use super::super::way::VIEWS;
    use super::*;

    #[test]
    fn boxes_lose_nothing_and_keep_little_and_a_wider_view_says_that_they_lose() {
        let ground = Ground::new(64);
        for kind in VIEWS {
            let view = ground.view(&kind);
            let frustum = Frustum::new(&view);
            let kept = frustum.patches(&ground, &frustum.tiles(&ground));
            let reference = needed(&ground.grid, &view);
            let all = reference.iter().filter(|needed| **needed).count();
            let missed = missed(&reference, &kept).expect("a list of patches");
            eprintln!(
                "{}: {} kept, {all} needed, {missed:?}",
                kind.name,
                kept.len()
            );
            assert_eq!(missed.lost, 0, "{}", kind.name);
            // On so little ground few patches are needed, and those along the view's edges weigh more.
            assert!(
                all > 0 && missed.extra <= all / 50 + 20,
                "{}: {missed:?}",
                kind.name
            );
            // Negative control: the reference sees more than what is culled for.
            let wide = GridCamera {
                tan_half: 1.1 * view.tan_half,
                ..view
            };
            let lost = super::missed(&needed(&ground.grid, &wide), &kept).expect("a list");
            assert!(lost.lost > 0, "{}", kind.name);
        }
    }

    #[test]
    fn a_list_is_counted_both_ways_and_refused_where_it_is_none() {
        let needed = [true, true, false, false];
        let of = |kept: &[u32]| missed(&needed, kept);
        assert_eq!(of(&[0, 1]), Some(Missed { lost: 0, extra: 0 }));
        assert_eq!(of(&[1, 3]), Some(Missed { lost: 1, extra: 1 }));
        assert_eq!(of(&[1, 1]), None);
        assert_eq!(of(&[4]), None);
    }
}
