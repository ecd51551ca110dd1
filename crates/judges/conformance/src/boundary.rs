// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boundaries between ids, the band around them, and pieces too small to have a boundary.
//!
//! Pixels, row 0 at the top. A boundary pixel is one whose neighbour to the left, right, above or
//! below has another id: both sides of a border are boundary pixels, and the image's rim is none.
//! A piece is a set of pixels of one id, connected over edges or corners; background too, so that
//! a lake of one pixel counts like an island of one.

use crate::tolerance::{BAND_RADIUS_PX, SMALLEST_PIECE_PX};
use terrafill_contract::Frame;

/// Pixels of `frame` whose left, right, upper or lower neighbour has another id.
#[must_use]
pub fn boundary_pixels(frame: &Frame) -> u64 {
    let grid = Grid::of(frame);
    grid.boundary(&frame.ids, None)
        .iter()
        .filter(|&&set| set)
        .count() as u64
}

/// Per pixel: whether it lies within [`BAND_RADIUS_PX`] of a boundary pixel of `frame`, where a
/// difference is put down to rounding.
#[must_use]
pub fn boundary_band(frame: &Frame) -> Vec<bool> {
    Grid::of(frame).band(&frame.ids)
}

/// Whether a comparison with `reference` can find no boundary error because no boundary is in
/// sight: all sky, all surface without a region, or filled by one region to the last pixel.
#[must_use]
pub fn checks_nothing(reference: &Frame) -> bool {
    boundary_pixels(reference) == 0
}

/// Shape of a picture; turns (column, row) into an index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Grid {
    pub(crate) fn of(frame: &Frame) -> Self {
        Self {
            width: frame.size.width as usize,
            height: frame.size.height as usize,
        }
    }

    /// Indices of the pixels around `index`, `radius` steps to the eight neighbours, itself
    /// included, cut at the rim.
    pub(crate) fn square(self, index: usize, radius: usize) -> impl Iterator<Item = usize> {
        let (column, row) = (index % self.width, index / self.width);
        let columns = column.saturating_sub(radius)..=(column + radius).min(self.width - 1);
        let rows = row.saturating_sub(radius)..=(row + radius).min(self.height - 1);
        rows.flat_map(move |y| columns.clone().map(move |x| y * self.width + x))
    }

    /// Where a pixel and one of its four neighbours differ; pairs with a pixel of `ignored` in
    /// them do not count.
    pub(crate) fn boundary(self, ids: &[u32], ignored: Option<&[bool]>) -> Vec<bool> {
        let mut set = vec![false; ids.len()];
        let mut mark = |p: usize, q: usize| {
            if ignored.is_none_or(|ignored| !ignored[p] && !ignored[q]) {
                set[p] = true;
                set[q] = true;
            }
        };
        for start in (0..ids.len()).step_by(self.width.max(1)) {
            let (row, below) = ids[start..].split_at(self.width);
            for (p, (one, other)) in (start..).zip(row.iter().zip(&row[1..])) {
                if one != other {
                    mark(p, p + 1);
                }
            }
            for (p, (one, other)) in (start..).zip(row.iter().zip(below)) {
                if one != other {
                    mark(p, p + self.width);
                }
            }
        }
        set
    }

    /// `set` and everything within `radius` steps to the eight neighbours of it.
    pub(crate) fn dilated(self, set: &[bool], radius: usize) -> Vec<bool> {
        let mut out = vec![false; set.len()];
        for index in (0..set.len()).filter(|&index| set[index]) {
            for near in self.square(index, radius) {
                out[near] = true;
            }
        }
        out
    }

    /// The band around the boundary of `ids` where a mismatch is put down to rounding.
    pub(crate) fn band(self, ids: &[u32]) -> Vec<bool> {
        self.dilated(&self.boundary(ids, None), BAND_RADIUS_PX as usize)
    }

    /// Pieces of fewer than [`SMALLEST_PIECE_PX`] pixels: where they are, and how many.
    pub(crate) fn tiny_pieces(self, ids: &[u32]) -> TinyPieces {
        let mut tiny = TinyPieces {
            pixels: vec![false; ids.len()],
            count: 0,
        };
        let mut piece = Vec::new();
        for start in 0..ids.len() {
            if tiny.pixels[start] || self.begins_a_block(ids, start) {
                continue;
            }
            piece.clear();
            piece.push(start);
            let is_tiny = |piece: &[usize]| (piece.len() as u64) < SMALLEST_PIECE_PX;
            let mut next = 0;
            // Grown no further than it takes to know.
            while next < piece.len() && is_tiny(&piece) {
                for near in self.square(piece[next], 1) {
                    if ids[near] == ids[start] && !piece.contains(&near) {
                        piece.push(near);
                    }
                }
                next += 1;
            }
            if is_tiny(&piece) {
                tiny.count += 1;
                for &index in &piece {
                    tiny.pixels[index] = true;
                }
            }
        }
        tiny
    }

    /// Whether the pixel and those to the right, below, and below to the right are of one piece. Of most
    /// pixels this says at once that their piece is not tiny.
    fn begins_a_block(self, ids: &[u32], index: usize) -> bool {
        const { assert!(SMALLEST_PIECE_PX <= 4) };
        let last = index + self.width + 1;
        let is_inside = !(index + 1).is_multiple_of(self.width) && last < ids.len();
        is_inside
            && [index + 1, last - 1, last]
                .iter()
                .all(|&near| ids[near] == ids[index])
    }
}

/// What [`Grid::tiny_pieces`] finds.
#[derive(Debug)]
pub(crate) struct TinyPieces {
    pub(crate) pixels: Vec<bool>,
    pub(crate) count: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::picture;

    #[test]
    fn boundary_of_a_single_pixel_is_itself_and_its_four_neighbours() {
        let frame = picture(&["....", ".1..", "....", "...."]);
        assert_eq!(boundary_pixels(&frame), 5);
        let corner = picture(&["1...", "....", "...."]);
        assert_eq!(boundary_pixels(&corner), 3);
    }

    #[test]
    fn one_wrong_pixel_makes_a_boundary_where_there_was_none() {
        let mut frame = picture(&["111", "111", "111"]);
        assert!(checks_nothing(&frame));
        frame.ids[4] = 0;
        assert!(!checks_nothing(&frame));
    }

    #[test]
    fn sky_alone_checks_nothing_and_neighbouring_regions_check_something() {
        assert!(checks_nothing(&picture(&["..", ".."])));
        assert!(!checks_nothing(&picture(&["12", "12"])));
        assert_eq!(boundary_pixels(&picture(&["1"])), 0);
    }

    #[test]
    fn the_band_reaches_one_pixel_over_corners_and_no_farther() {
        let frame = picture(&[
            ".......", ".......", ".......", "...1...", ".......", ".......", ".......",
        ]);
        let band = Grid::of(&frame).band(&frame.ids);
        // The plus of five boundary pixels, grown by one over edges and corners.
        let expected = [
            ".......", "..###..", ".#####.", ".#####.", ".#####.", "..###..", ".......",
        ];
        for (row, line) in expected.iter().enumerate() {
            for (column, mark) in line.chars().enumerate() {
                assert_eq!(band[row * 7 + column], mark == '#', "{column},{row}");
            }
        }
    }

    #[test]
    fn pieces_connect_over_corners_and_four_pixels_are_not_tiny() {
        let diagonal = picture(&["1....", ".1...", "..1..", "...1.", "....."]);
        assert_eq!(Grid::of(&diagonal).tiny_pieces(&diagonal.ids).count, 0);
        let three = picture(&["1....", ".1...", "..1..", ".....", "....."]);
        let tiny = Grid::of(&three).tiny_pieces(&three.ids);
        assert_eq!(tiny.count, 1);
        assert_eq!(tiny.pixels.iter().filter(|&&set| set).count(), 3);
        let lake = picture(&["11111", "11.11", "11111"]);
        assert_eq!(Grid::of(&lake).tiny_pieces(&lake.ids).count, 1);
    }
}
