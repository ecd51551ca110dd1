// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether each pixel shows the texel of the finest tile that is there, and nothing else.

use super::flight::{OPTIONS, wanted_tile};
use crate::tile_set::Shown;
use crate::truth::{ALLOWED_TEXELS, Tile, Truth, off_texels, tiles_of};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// What pixels of a frame show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Judged {
    /// Pixels that were judged.
    pub(crate) pixels: usize,
    /// Of them, those that show what is right neither at their middle nor as near to it as rounding may take them.
    pub(crate) wrong: usize,
    /// Those that are right beside their middle alone.
    pub(crate) in_band: usize,
    /// Those that show a coarser level than they want.
    pub(crate) coarse: usize,
}

impl Judged {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            wrong: self.wrong + other.wrong,
            in_band: self.in_band + other.in_band,
            coarse: self.coarse + other.coarse,
        }
    }
}

/// The finest tile that is there of one and those that it is a part of.
fn finest(tile: Tile, held: &BTreeSet<Tile>) -> Option<Tile> {
    let mut tiles = std::iter::successors(Some(tile), Tile::parent);
    tiles.find(|tile| held.contains(tile))
}

/// - `held`: the tiles that were there when the frame was drawn
pub(crate) fn judge(truths: &[Option<Truth>], shown: &[Shown], held: &BTreeSet<Tile>) -> Judged {
    let pixels = truths.par_iter().zip(shown);
    let pixels = pixels.map(|(truth, shown)| match truth {
        Some(truth) => of_pixel(truth, *shown, held),
        // A surface where there is none; the ground fills each picture.
        None => Judged {
            pixels: 1,
            wrong: usize::from(*shown != Shown::Nothing),
            ..Judged::default()
        },
    });
    pixels.reduce(Judged::default, Judged::and)
}

fn of_pixel(truth: &Truth, shown: Shown, held: &BTreeSet<Tile>) -> Judged {
    let mut judged = Judged {
        pixels: 1,
        ..Judged::default()
    };
    let wanted = wanted_tile(truth);
    let Shown::Texel(texel) = shown else {
        judged.wrong = 1;
        return judged;
    };
    let off = off_texels(texel, &truth.drawn, OPTIONS.by_fragment);
    let is_middle = Some(texel.tile) == finest(wanted, held) && off == 0.0;
    let is_beside = || {
        let [from, to] = truth.levels;
        let mut beside = tiles_of(&truth.drawn, OPTIONS.by_fragment, from..=to);
        let is_finest = texel.tile == wanted && truth.drawn.cap.is_some()
            || beside.any(|tile| finest(tile, held) == Some(texel.tile));
        is_finest && off <= ALLOWED_TEXELS + texel.tile.texels() * truth.snapped
    };
    judged.coarse = usize::from(is_coarse(truth, &shown));
    if !is_middle {
        let is_beside = is_beside();
        judged.in_band = usize::from(is_beside);
        judged.wrong = usize::from(!is_beside);
    }
    judged
}

/// Whether a pixel shows a coarser tile than it wants, which the wanted one is a part of.
pub(crate) fn is_coarse(truth: &Truth, shown: &Shown) -> bool {
    let Shown::Texel(texel) = shown else {
        return false;
    };
    let mut coarser = std::iter::successors(Some(wanted_tile(truth)), Tile::parent).skip(1);
    coarser.any(|tile| tile == texel.tile)
}
