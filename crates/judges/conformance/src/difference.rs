// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture of where a frame is wrong, for people.

use crate::boundary::Grid;
use crate::compare::{CompareError, check};
use crate::distance::squared_distances;
use terrafill_contract::{Frame, NO_REGION};

/// Neither picture fills the pixel.
const BACKGROUND: [u8; 3] = [18, 20, 26];
/// Both fill it, with the same region.
const AGREED: [u8; 3] = [124, 128, 136];
/// Agreed, and within the boundary band: a shade darker or lighter, so that borders show.
const BAND_BACKGROUND: [u8; 3] = [34, 38, 48];
const BAND_AGREED: [u8; 3] = [98, 102, 112];
/// Wrong, within the band.
const WRONG_IN_BAND: [u8; 3] = [255, 150, 30];
/// Wrong, outside the band.
const WRONG_OUTSIDE: [u8; 3] = [255, 30, 40];

/// Where `frame` differs from `reference`: 3 bytes a pixel, row 0 at the top.
///
/// Agreeing regions grey, the rest dark, the boundary band a shade apart; wrong pixels orange
/// within the band and red outside it, red over orange.
///
/// - `marker_radius`: by how many pixels a wrong one is drawn larger on each side; with 1 a single one
///   can be seen in a picture scaled down for a page
///
/// # Errors
/// As [`crate::compare`].
pub fn difference_rgb(
    reference: &Frame,
    frame: &Frame,
    marker_radius: usize,
) -> Result<Vec<u8>, CompareError> {
    check(reference, frame)?;
    let grid = Grid::of(reference);
    let band = grid.band(&reference.ids);
    let mut pixels: Vec<[u8; 3]> = reference
        .ids
        .iter()
        .zip(&band)
        .map(|(&id, &in_band)| match (id != NO_REGION, in_band) {
            (false, false) => BACKGROUND,
            (false, true) => BAND_BACKGROUND,
            (true, false) => AGREED,
            (true, true) => BAND_AGREED,
        })
        .collect();
    // Red last, so that no orange marker covers it.
    for (in_band, colour) in [(true, WRONG_IN_BAND), (false, WRONG_OUTSIDE)] {
        let wrong = (0..band.len())
            .filter(|&index| reference.ids[index] != frame.ids[index] && band[index] == in_band);
        for near in wrong.flat_map(|index| grid.square(index, marker_radius)) {
            pixels[near] = colour;
        }
    }
    Ok(pixels.concat())
}

/// Column and row of the mismatched pixel that is furthest from the reference's boundary, the first of
/// several from the top; `None` where nothing differs.
///
/// Without a boundary in the reference all are equally far.
///
/// # Errors
/// As [`crate::compare`].
pub fn worst_pixel(reference: &Frame, frame: &Frame) -> Result<Option<[usize; 2]>, CompareError> {
    check(reference, frame)?;
    let grid = Grid::of(reference);
    let far = squared_distances(grid, &grid.boundary(&reference.ids, None));
    let mismatched =
        (0..reference.ids.len()).filter(|&index| reference.ids[index] != frame.ids[index]);
    let worst = mismatched.reduce(|worst, index| {
        if far[index] > far[worst] {
            index
        } else {
            worst
        }
    });
    Ok(worst.map(|index| [index % grid.width, index / grid.width]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::picture;

    #[test]
    fn the_worst_pixel_is_the_one_furthest_from_the_boundary() {
        let reference = picture(&["11......", "11......", "11......", "11......"]);
        let mut frame = reference.clone();
        assert_eq!(worst_pixel(&reference, &frame), Ok(None));
        frame.ids[2] = 1;
        frame.ids[2 * 8 + 6] = 1;
        frame.ids[3 * 8 + 6] = 1;
        assert_eq!(worst_pixel(&reference, &frame), Ok(Some([6, 2])));
        // Negative control: with the reference as operand of its own nothing is worst, and without a boundary the
        // first one is.
        let empty = picture(&["........"; 4]);
        assert_eq!(worst_pixel(&frame, &frame), Ok(None));
        assert_eq!(worst_pixel(&empty, &frame), Ok(Some([0, 0])));
        let small = picture(&["..", ".."]);
        assert!(worst_pixel(&small, &frame).is_err());
    }

    fn count(rgb: &[u8], colour: [u8; 3]) -> usize {
        rgb.chunks(3).filter(|pixel| *pixel == colour).count()
    }

    #[test]
    fn one_wrong_pixel_is_a_marker_of_nine_and_none_is_no_marker() {
        let reference = picture(&["........"; 8]);
        let clean = difference_rgb(&reference, &reference, 1).expect("same size");
        assert_eq!(clean.len(), 64 * 3);
        assert_eq!(count(&clean, BACKGROUND), 64);
        let mut frame = reference.clone();
        frame.ids[3 * 8 + 4] = 1;
        let marked = difference_rgb(&reference, &frame, 1).expect("same size");
        assert_eq!(count(&marked, WRONG_OUTSIDE), 9);
        assert_eq!(count(&marked, WRONG_IN_BAND), 0);
        let exact = difference_rgb(&reference, &frame, 0).expect("same size");
        assert_eq!(count(&exact, WRONG_OUTSIDE), 1);
    }

    #[test]
    fn red_lies_over_orange_and_orange_means_within_the_band() {
        let reference = picture(&["1111....", "1111....", "1111....", "1111...."]);
        let mut frame = reference.clone();
        frame.ids[4] = 1;
        let marked = difference_rgb(&reference, &frame, 1).expect("same size");
        assert_eq!(
            (count(&marked, WRONG_IN_BAND), count(&marked, WRONG_OUTSIDE)),
            (6, 0)
        );
        frame.ids[6] = 1;
        let marked = difference_rgb(&reference, &frame, 1).expect("same size");
        assert_eq!(
            (count(&marked, WRONG_IN_BAND), count(&marked, WRONG_OUTSIDE)),
            (4, 6)
        );
    }
}
