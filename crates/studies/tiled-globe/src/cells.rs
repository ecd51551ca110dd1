// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames against the number of cells of the grid: the only experiment of StuCoSReC 2018 (section 3).
//!
//! A view's cases have the tiles that the body asks for, whatever the grid, and the ground fills it. So N alone changes,
//! and with it the triangles: no draw comes or goes, and no pixel.

pub(crate) mod line;
mod section;

pub use section::{PUBLISHED_FPS, SECTION, published};

use super::choose;
use super::options::{Drawing, Options};
use super::tiles::{Tiled, TilesOf};
use std::rc::Rc;
use terrafill_globe_views::{Opened, ViewRow};
use terrafill_study::CaseGroup;

/// Name of this part in cases.
pub(crate) const PART: &str = "cells";

/// Cells along each side of the screen: as published, and finer ones that a trend must reach to.
const CELLS: [u32; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 20, 40];

/// Of these a grid is drawn once for each tile, as published: a frame lasts tens of the others.
const MOST_PUBLISHED: u32 = 10;

/// Each number of cells in one draw, and those that were published with a draw for each tile.
fn options() -> Vec<Options> {
    let of = |n| {
        let each = (n <= MOST_PUBLISHED).then_some(Drawing::DrawEach);
        let drawings = each.into_iter().chain([Drawing::Array]);
        drawings.map(move |drawing| Options {
            n,
            drawing,
            ..Options::BASE
        })
    };
    CELLS.into_iter().flat_map(of).collect()
}

/// A view through all of them.
pub(crate) fn planned(view: &ViewRow, sizes: (u32, u32), opened: &Rc<Opened>) -> CaseGroup<Tiled> {
    Tiled::of_part((PART, TilesOf::Body), view, sizes, options(), opened)
}

/// Cells along each side of the screen by whose corners tiles are chosen.
const CHOOSING: [u32; 4] = [5, 10, 20, 40];

/// A view whose tiles are chosen by the corners of each of these grids.
pub(crate) fn choosing(view: &ViewRow, sizes: (u32, u32), opened: &Rc<Opened>) -> CaseGroup<Tiled> {
    let options = CHOOSING.map(|n| Options { n, ..Options::BASE });
    let part = (choose::PART, TilesOf::Corners);
    Tiled::of_part(part, view, sizes, options.into(), opened)
}

#[cfg(test)]
mod tests;
