// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames against the number of cells of the grid: the only experiment of StuCoSReC 2018 (section 3).
//!
//! A view's cases have the tiles that the body asks for, whatever the grid. So N alone changes, and with it the
//! triangles, and no draw comes or goes.

pub(crate) mod line;
mod section;

pub(crate) use section::SECTION;
#[cfg(test)]
pub(crate) use section::{PUBLISHED_FPS, published};

use super::options::{Drawing, Options};
use super::{Tiled, TilesOf, choose};
use crate::list::ViewRow;
use crate::opened::Opened;
use std::rc::Rc;
use terrafill_study::CaseGroup;

/// Name of this part in cases.
pub(crate) const PART: &str = "cells";

/// Cells along each side of the screen: as published, and finer ones that a trend must reach to.
const CELLS: [u32; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 20, 40];

/// Timed frames in a process where each tile has a draw of the whole grid: they last tens of the others.
const FEW_SAMPLES: u32 = 3;

/// Each number of cells, as published and in one draw.
fn options() -> Vec<Options> {
    let drawings = [Drawing::DrawEach, Drawing::Array];
    let of = |n| {
        drawings.map(|drawing| Options {
            n,
            drawing,
            ..Options::BASE
        })
    };
    CELLS.into_iter().flat_map(of).collect()
}

/// A view through all of them.
pub(crate) fn planned(view: &ViewRow, sizes: (u32, u32), opened: &Rc<Opened>) -> CaseGroup<Tiled> {
    let part = (PART, TilesOf::Body);
    let mut group = Tiled::of_part(part, view, sizes, options(), opened);
    for (case, options) in group.cases.iter_mut().zip(&group.work.options) {
        if options.drawing == Drawing::DrawEach {
            case.samples = case.samples.min(FEW_SAMPLES);
        }
    }
    group
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
