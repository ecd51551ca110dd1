// SPDX-License-Identifier: MIT OR Apache-2.0
//! The figures of a comparison.

use crate::ErrorFigures;
use crate::boundary::Grid;
use crate::distance::{Measured, hausdorff_px};
use crate::tolerance::{MAX_FOREIGN_PX, MAX_HAUSDORFF_PX};
use terrafill_contract::Frame;

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The pictures differ in size.
    #[error(
        "the frame is {}×{} pixels, the reference {}×{}",
        found.0, found.1, required.0, required.1
    )]
    SizeMismatch {
        /// Width and height of the frame.
        found: (u32, u32),
        /// Width and height of the reference.
        required: (u32, u32),
    },
    /// A picture holds another number of ids than it has pixels.
    #[error("the {which} has {found} ids, needs {required}")]
    MalformedFrame {
        /// `reference` or `frame`.
        which: &'static str,
        /// Ids there are.
        found: usize,
        /// Pixels there are.
        required: usize,
    },
    /// A frame was drawn without a texture.
    #[error("the {which} has no texture coordinates")]
    NoTexture {
        /// `reference` or `frame`.
        which: &'static str,
    },
    /// The pictures on the regions differ in size.
    #[error(
        "the frame's picture has {}×{} texels, the reference's {}×{}",
        found.0, found.1, required.0, required.1
    )]
    PictureMismatch {
        /// Columns and rows of the frame's picture.
        found: (u32, u32),
        /// Columns and rows of the reference's.
        required: (u32, u32),
    },
    /// A frame has texture coordinates for another number of pixels than it has.
    #[error("the {which} has texture coordinates of {found} pixels, needs {required}")]
    MalformedTexture {
        /// `reference` or `frame`.
        which: &'static str,
        /// Coordinates there are.
        found: usize,
        /// Pixels there are.
        required: usize,
    },
    /// A judge with NaN in its own results judges nothing.
    #[error("the reference itself has {found} NaN or infinite results, allowed 0")]
    ReferenceNotFinite {
        /// How many.
        found: u64,
    },
}

/// The frame with all regions as one: what a fill in one colour can be compared with.
#[must_use]
pub fn filled_only(frame: &Frame) -> Frame {
    Frame {
        ids: frame.ids.iter().map(|&id| id.min(1)).collect(),
        ..frame.clone()
    }
}

/// How `frame` differs from `reference`.
///
/// - The Hausdorff distance is between the boundary pixels of both pictures. Pieces of fewer than
///   [`crate::SMALLEST_PIECE_PX`] pixels in the reference are counted in `tiny_regions`, and of no
///   boundary within one pixel of them is it asked how far the other picture's is. That of a larger piece
///   there still is one that the other picture's may be near.
/// - It is `None` when no boundary is left in either. When one picture lacks a boundary that the other has, the
///   distance is infinite. The image's diagonal, which no distance in it exceeds, stands in for that, so that the
///   figure stays a number in every file.
/// - cost: O(pixels)
///
/// # Errors
/// [`CompareError`] when the two cannot be laid over one another, or the reference is broken.
pub fn compare(reference: &Frame, frame: &Frame) -> Result<ErrorFigures, CompareError> {
    compare_closely(reference, frame, |_, _| false, |_, _| false)
}

/// The same by a reference that can be asked between the centres of its pixels. What is smaller than a
/// pixel leaves no trace in its picture, and the band lies around what does. In the frame rounding may
/// give such a piece a pixel all the same.
///
/// - `may_round_to`: whether the surface in the centre of the pixel of that index lies within
///   [`crate::BORDER_ROUNDING`] of a wall of the region with that id. Such a pixel is inside the band, and
///   counts for the Hausdorff distance as the reference has it.
/// - `shows`: whether it shows the id within [`crate::BAND_RADIUS_PX`] of the centre of the pixel of
///   that index. A pixel for which it does is inside the band; and a piece of the frame of fewer than
///   [`crate::SMALLEST_PIECE_PX`] pixels counts as little for the Hausdorff distance as one of the
///   reference does.
/// - Two neighbours' borders round each by itself, so that a pixel there may belong to both or to neither: it
///   has an id that the reference shows nowhere near. At a corner such a pixel is √2 from the next
///   boundary. Up to [`crate::MAX_FOREIGN_PX`] of them within the band count for the Hausdorff distance as the
///   reference has them.
/// - At most [`MAX_PROBED`] pixels are asked about by `shows`. Rounding flips no more of them outside the band.
///   Boundaries that are moved on purpose may: of those [`crate::boundary_movement`] asks about all.
///
/// # Errors
/// As [`compare`].
pub fn compare_closely(
    reference: &Frame,
    frame: &Frame,
    may_round_to: impl Fn(usize, u32) -> bool,
    shows: impl Fn(usize, u32) -> bool,
) -> Result<ErrorFigures, CompareError> {
    check(reference, frame)?;
    let grid = Grid::of(reference);
    let mismatched = |index: &usize| reference.ids[*index] != frame.ids[*index];
    let mut band = grid.band(&reference.ids);
    // Asked within the band only where one outside is such, since getting ready to answer takes time.
    let mut ids = frame.ids.clone();
    let rounded = |in_band: bool| -> Vec<usize> {
        let all = (0..band.len()).filter(mismatched);
        all.filter(|&index| band[index] == in_band && may_round_to(index, frame.ids[index]))
            .collect()
    };
    let decided = rounded(false);
    if !decided.is_empty() {
        let around = rounded(true).into_iter();
        for index in around.chain(decided.iter().copied()) {
            ids[index] = reference.ids[index];
        }
    }
    for index in decided {
        band[index] = true;
    }
    let mismatches: Vec<usize> = (0..band.len()).filter(mismatched).collect();
    let mut outside = mismatches.iter().filter(|&&index| !band[index]).count();

    let mut tiny = grid.tiny_pieces(&reference.ids);
    let made = grid.tiny_pieces(&ids).pixels;
    let doubtful = |index: &&usize| !band[**index] || made[**index];
    if mismatches.iter().filter(doubtful).count() <= MAX_PROBED {
        for &index in mismatches.iter().filter(doubtful) {
            if shows(index, frame.ids[index]) {
                outside -= usize::from(!band[index]);
                tiny.count += u64::from(made[index] && !tiny.pixels[index]);
                tiny.pixels[index] |= made[index];
            }
        }
    }
    // One pixel around them too: a piece that rounding moved by a pixel is the same luck. A boundary of
    // larger pieces there is one all the same, which the other picture may have a pixel farther off.
    let ignored = grid.dilated(&tiny.pixels, 1);
    let distance = |ids: &[u32]| {
        let [expected, found] = [&reference.ids, ids].map(|ids| Measured {
            counted: grid.boundary(ids, Some(&ignored)),
            all: grid.boundary(ids, Some(&tiny.pixels)),
        });
        hausdorff_px(grid, &expected, &found)
    };
    let mut hausdorff = distance(&ids);
    if hausdorff.is_some_and(|px| px > MAX_HAUSDORFF_PX) {
        let in_band = mismatches.iter().filter(|index| band[**index]);
        let foreign: Vec<usize> = in_band
            .copied()
            .take(MAX_PROBED)
            .filter(|&index| shows(index, reference.ids[index]) && !shows(index, frame.ids[index]))
            .collect();
        if foreign.len() as u64 <= MAX_FOREIGN_PX {
            for index in foreign {
                ids[index] = reference.ids[index];
            }
            hausdorff = distance(&ids);
        }
    }
    let diagonal = (grid.width as f64).hypot(grid.height as f64);
    let filled_px = frame.filled_px();
    let required_px = reference.filled_px();
    Ok(ErrorFigures {
        filled_px,
        mismatched_px: mismatches.len() as u64,
        mismatched_px_outside_band: outside as u64,
        hausdorff_px: hausdorff.map(|distance| distance.min(diagonal)),
        boundary_moved_px: None,
        foreign_px: None,
        area_error: (required_px > 0).then(|| filled_px as f64 / required_px as f64 - 1.0),
        tiny_regions: tiny.count,
        non_finite: frame.non_finite,
    })
}

/// Pixels about which [`compare_closely`] asks what the reference shows around them.
pub const MAX_PROBED: usize = 64;

/// Whether the two can be compared at all.
pub(crate) fn check(reference: &Frame, frame: &Frame) -> Result<(), CompareError> {
    for (which, picture) in [("reference", reference), ("frame", frame)] {
        if picture.ids.len() != picture.size.pixel_count() {
            return Err(CompareError::MalformedFrame {
                which,
                found: picture.ids.len(),
                required: picture.size.pixel_count(),
            });
        }
    }
    if reference.size != frame.size {
        return Err(CompareError::SizeMismatch {
            found: (frame.size.width, frame.size.height),
            required: (reference.size.width, reference.size.height),
        });
    }
    if reference.non_finite > 0 {
        return Err(CompareError::ReferenceNotFinite {
            found: reference.non_finite,
        });
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::verdict::{Verdict, verdict};
    use terrafill_scene::ImageSize;

    /// A frame from rows of digits; `.` is no region.
    pub(crate) fn picture(rows: &[&str]) -> Frame {
        let ids: Vec<u32> = rows
            .iter()
            .flat_map(|row| row.chars())
            .map(|mark| mark.to_digit(10).unwrap_or(0))
            .collect();
        let width = rows.first().map_or(0, |row| row.len());
        Frame {
            size: ImageSize::new(
                u32::try_from(width).expect("small"),
                u32::try_from(rows.len()).expect("small"),
            ),
            surface: vec![true; ids.len()],
            ids,
            non_finite: 0,
            counters: None,
            texture: None,
        }
    }

    /// Id by pixel from a rule, 40 × 30.
    fn drawn(id: impl Fn(i32, i32) -> u32) -> Frame {
        let mut frame = picture(&[&"."; 30].map(|_| "........................................"));
        for (index, pixel) in frame.ids.iter_mut().enumerate() {
            let index = i32::try_from(index).expect("small");
            *pixel = id(index % 40, index / 40);
        }
        frame
    }

    fn square(x: i32, y: i32) -> u32 {
        u32::from((10..25).contains(&x) && (8..20).contains(&y))
    }

    fn figures(reference: &Frame, frame: &Frame) -> ErrorFigures {
        compare(reference, frame).expect("same size")
    }

    fn passes(reference: &Frame, frame: &Frame) -> bool {
        verdict(&figures(reference, frame)) == Verdict::Pass
    }

    #[test]
    fn a_picture_equals_itself() {
        let reference = drawn(square);
        let expected = ErrorFigures {
            filled_px: 180,
            hausdorff_px: Some(0.0),
            area_error: Some(0.0),
            ..ErrorFigures::default()
        };
        assert_eq!(figures(&reference, &reference), expected);
        assert!(passes(&reference, &reference));
    }

    #[test]
    fn one_wrong_pixel_far_from_every_boundary_fails() {
        let reference = drawn(square);
        for (column, row, id) in [(17, 14, 0), (17, 14, 2), (35, 25, 1), (0, 0, 1)] {
            let mut frame = reference.clone();
            frame.ids[row * 40 + column] = id;
            let found = figures(&reference, &frame);
            assert_eq!(found.mismatched_px, 1);
            assert_eq!(found.mismatched_px_outside_band, 1);
            assert!(found.hausdorff_px.is_some_and(|px| px > 1.0));
            assert!(!passes(&reference, &frame), "{column},{row}");
        }
    }

    #[test]
    fn one_wrong_pixel_on_the_boundary_is_counted_and_forgiven() {
        let reference = drawn(square);
        let mut frame = reference.clone();
        frame.ids[14 * 40 + 10] = 0;
        let found = figures(&reference, &frame);
        assert_eq!(
            (found.mismatched_px, found.mismatched_px_outside_band),
            (1, 0)
        );
        assert_eq!(found.hausdorff_px, Some(1.0));
        assert!(
            found
                .area_error
                .is_some_and(|error| (error + 1.0 / 180.0).abs() < 1e-15)
        );
        assert!(passes(&reference, &frame));
    }

    #[test]
    fn a_shift_by_one_pixel_is_forgiven_and_by_two_is_caught() {
        let reference = drawn(square);
        assert!(passes(&reference, &drawn(|x, y| square(x - 1, y))));
        for (dx, dy) in [(2, 0), (-2, 0), (0, 2), (0, -2), (2, 2)] {
            let found = figures(&reference, &drawn(|x, y| square(x - dx, y - dy)));
            let distance = f64::from(dx).hypot(f64::from(dy));
            assert!(
                found
                    .hausdorff_px
                    .is_some_and(|px| px > 1.0 && px <= distance)
            );
            assert_ne!(verdict(&found), Verdict::Pass, "{dx},{dy}");
            // The filled area is the same, so the area alone would not have noticed.
            assert_eq!(found.area_error, Some(0.0));
        }
    }

    #[test]
    fn swapped_colours_of_two_neighbours_fail_although_the_coverage_is_right() {
        let reference = drawn(|x, y| square(x, y) * if x < 17 { 1 } else { 2 });
        let swapped = drawn(|x, y| square(x, y) * if x < 17 { 2 } else { 1 });
        let found = figures(&reference, &swapped);
        assert_eq!(found.area_error, Some(0.0));
        assert_eq!(found.hausdorff_px, Some(0.0));
        assert!(found.mismatched_px_outside_band > 0);
        assert!(!passes(&reference, &swapped));
    }

    #[test]
    fn a_pixel_of_neither_neighbour_at_a_corner_is_forgiven_and_five_are_not() {
        // Corners of a border between 1 and 2; the frame's pixel there belongs to neither.
        let reference = drawn(|x, y| if x >= 20 && (y / 5) % 2 == 0 { 2 } else { 1 });
        let frame = |corners: &[i32], id: u32| {
            let mut frame = reference.clone();
            for row in corners {
                frame.ids[usize::try_from(row * 40 + 19).expect("inside")] = id;
            }
            frame
        };
        let shows = |index: usize, id: u32| {
            let near = [index - 1, index, index + 1, index + 40, index + 41];
            near.iter().any(|&near| reference.ids[near] == id)
        };
        let found = |frame: &Frame| {
            let found = compare_closely(&reference, frame, |_, _| false, shows);
            found.expect("same size")
        };
        // Diagonally below the block of 2: its neighbours to the left and below are √2 from a boundary.
        let one = frame(&[5], 0);
        assert_eq!(figures(&reference, &one).hausdorff_px, Some(2.0_f64.sqrt()));
        assert_eq!(verdict(&found(&one)), Verdict::Pass);
        let five = frame(&[5, 9, 15, 19, 25], 0);
        assert_ne!(verdict(&found(&five)), Verdict::Pass);
        // Negative control: an id that is near is no rounding of two borders.
        let other = frame(&[5], 2);
        let strict = compare_closely(&reference, &other, |_, _| false, |_, _| true);
        assert_eq!(
            strict.expect("same size").hausdorff_px,
            figures(&reference, &other).hausdorff_px
        );
    }

    #[test]
    fn a_missing_strip_inside_the_band_is_caught_by_the_distance_alone() {
        // All of a strip two pixels wide lies in the band, so the band forgives its loss.
        let strip = |x: i32, y: i32| square(x, y) | u32::from(x > 30 && (4..6).contains(&y));
        let reference = drawn(strip);
        let found = figures(&reference, &drawn(square));
        assert_eq!(found.mismatched_px_outside_band, 0);
        assert_eq!(found.tiny_regions, 0);
        assert!(!passes(&reference, &drawn(square)));
        // Also when nothing else is in the picture: an empty frame has no boundary at all.
        let alone = drawn(|x, y| u32::from(x > 30 && (4..6).contains(&y)));
        let empty = drawn(|_, _| 0);
        assert_eq!(figures(&alone, &empty).hausdorff_px, Some(50.0));
        assert!(!passes(&alone, &empty));
        assert!(!passes(&empty, &alone));
    }

    #[test]
    fn tiny_pieces_are_left_out_of_the_distance_and_counted() {
        let islet = |x: i32, y: i32| u32::from(x == 35 && (25..28).contains(&y));
        let reference = drawn(|x, y| square(x, y) | islet(x, y));
        let missing = drawn(square);
        let moved = drawn(|x, y| square(x, y) | islet(x - 1, y));
        for frame in [&reference, &missing, &moved] {
            let found = figures(&reference, frame);
            assert_eq!((found.hausdorff_px, found.tiny_regions), (Some(0.0), 1));
        }
        assert_eq!(figures(&reference, &missing).mismatched_px, 3);
        // Moved farther than rounding can, or grown by one pixel in the reference: caught.
        assert!(!passes(
            &reference,
            &drawn(|x, y| square(x, y) | islet(x - 3, y))
        ));
        let four = drawn(|x, y| square(x, y) | islet(x, y) | islet(x, y + 1));
        assert!(!passes(&four, &missing));
    }

    #[test]
    fn next_to_a_tiny_piece_a_boundary_may_move_by_a_pixel_and_no_farther() {
        // From the globe of countries under 200 sensors: rounding decides the 6 in the middle. The boundary
        // above it lies beside the 5 that is tiny and does not count; those to its right and below do.
        let reference = picture(&[
            "11128888888",
            "11166888885",
            "66666658855",
            "666.66..555",
            "666..6....5",
            "6666.......",
            "66666......",
        ]);
        let mut frame = reference.clone();
        frame.ids[4 * 11 + 5] = 0;
        let found = figures(&reference, &frame);
        assert_eq!((found.mismatched_px, found.tiny_regions), (1, 2));
        assert_eq!(found.hausdorff_px, Some(1.0));
        assert!(passes(&reference, &frame) && passes(&frame, &reference));
        // Negative control: where it reaches a pixel farther down.
        let mut longer = reference.clone();
        longer.ids[5 * 11 + 5] = 6;
        let found = figures(&longer, &frame);
        assert!(found.hausdorff_px > Some(1.0), "{found:?}");
    }

    #[test]
    fn a_speck_is_luck_only_where_the_reference_shows_it_between_its_pixels() {
        let reference = drawn(square);
        let speck = drawn(|x, y| square(x, y) | u32::from((x, y) == (35, 25)));
        let place = 25 * 40 + 35;
        let asked = |frame: &Frame, shows: &dyn Fn(usize, u32) -> bool| {
            compare_closely(&reference, frame, |_, _| false, shows).expect("same size")
        };
        let found = asked(&speck, &|pixel, id| (pixel, id) == (place, 1));
        assert_eq!(verdict(&found), Verdict::Pass);
        let counted = (found.mismatched_px, found.mismatched_px_outside_band);
        assert_eq!((counted, found.tiny_regions), ((1, 0), 1));
        // Negative controls: a reference that is not asked, one that shows another id there, and one elsewhere.
        assert!(!passes(&reference, &speck));
        let another_id = |_: usize, id: u32| id == 2;
        let elsewhere = |pixel: usize, _: u32| pixel != place;
        for found in [asked(&speck, &another_id), asked(&speck, &elsewhere)] {
            assert_eq!(found.mismatched_px_outside_band, 1);
            assert_ne!(verdict(&found), Verdict::Pass);
        }
        // Four pixels are a piece, whatever is shown there: the distance tells.
        let piece = drawn(|x, y| square(x, y) | u32::from(x == 35 && (20..24).contains(&y)));
        let found = asked(&piece, &|_, id| id == 1);
        assert_eq!(found.mismatched_px_outside_band, 0);
        assert_ne!(verdict(&found), Verdict::Pass);
    }

    #[test]
    fn where_rounding_decides_a_frame_may_differ_and_nowhere_else() {
        let reference = drawn(square);
        let other = drawn(|x, y| {
            if x < 12 {
                square(x, y)
            } else {
                2 * square(x, y)
            }
        });
        let asked = |may_round_to: &dyn Fn(usize, u32) -> bool| {
            compare_closely(&reference, &other, may_round_to, |_, _| false).expect("same size")
        };
        let found = asked(&|pixel, id| pixel % 40 >= 12 && id == 2);
        assert!(
            found.mismatched_px > MAX_PROBED as u64,
            "{}",
            found.mismatched_px
        );
        assert_eq!(verdict(&found), Verdict::Pass);
        // Negative controls: another region's id, where it decides nothing, and where a column of what
        // differs is left.
        let found = asked(&|pixel, id| pixel % 40 >= 12 && id == 3);
        assert_ne!(verdict(&found), Verdict::Pass);
        for first in [40, 13] {
            let found = asked(&|pixel, id| pixel % 40 >= first && id == 2);
            assert!(found.mismatched_px_outside_band > 0, "{first}");
            assert_ne!(verdict(&found), Verdict::Pass, "{first}");
        }
    }

    #[test]
    fn more_specks_than_luck_could_make_are_not_asked_about() {
        let reference = drawn(|_, _| 0);
        let dots = |count: i32| {
            drawn(move |x, y| u32::from(x % 3 == 0 && y % 3 == 0 && x / 3 + 14 * (y / 3) < count))
        };
        let most = i32::try_from(MAX_PROBED).expect("few");
        let figures = |count| compare_closely(&reference, &dots(count), |_, _| false, |_, _| true);
        let found = figures(most).expect("same size");
        assert_eq!(found.mismatched_px, MAX_PROBED as u64);
        assert_eq!(verdict(&found), Verdict::Pass);
        let found = figures(most + 1).expect("same size");
        assert_eq!(found.mismatched_px_outside_band, MAX_PROBED as u64 + 1);
        assert_ne!(verdict(&found), Verdict::Pass);
    }

    #[test]
    fn the_order_of_the_operands_matters() {
        let reference = drawn(|x, y| square(x, y) | u32::from(x == 35 && y == 25));
        let frame = drawn(square);
        let (there, back) = (figures(&reference, &frame), figures(&frame, &reference));
        // A pixel that only the reference has is within its band; one it lacks is not.
        assert_eq!(
            (there.mismatched_px_outside_band, there.tiny_regions),
            (0, 1)
        );
        assert_eq!((back.mismatched_px_outside_band, back.tiny_regions), (1, 0));
        assert_eq!(there.mismatched_px, back.mismatched_px);
        assert!(there.area_error < Some(0.0) && back.area_error > Some(0.0));
        assert_eq!((there.filled_px, back.filled_px), (180, 181));
    }

    #[test]
    fn pictures_without_a_boundary_have_no_distance() {
        let full = drawn(|_, _| 1);
        let found = figures(&full, &full);
        assert_eq!(found.hausdorff_px, None);
        assert!(crate::checks_nothing(&full));
        // Even there, another region's colour is wrong.
        assert!(!passes(&full, &drawn(|_, _| 2)));
        let empty = drawn(|_, _| 0);
        assert_eq!(figures(&empty, &empty).area_error, None);
    }

    #[test]
    fn non_finite_results_fail() {
        let reference = drawn(square);
        let mut frame = reference.clone();
        frame.non_finite = 1;
        assert_eq!(figures(&reference, &frame).non_finite, 1);
        assert!(!passes(&reference, &frame));
        assert_eq!(
            compare(&frame, &reference).map(|_| ()),
            Err(CompareError::ReferenceNotFinite { found: 1 })
        );
    }

    #[test]
    fn pictures_of_different_shape_are_refused() {
        let reference = picture(&["..", "..", ".."]);
        let turned = picture(&["...", "..."]);
        assert_eq!(
            compare(&reference, &turned).map(|_| ()),
            Err(CompareError::SizeMismatch {
                found: (3, 2),
                required: (2, 3)
            })
        );
        let mut short = reference.clone();
        short.ids.pop();
        assert_eq!(
            compare(&reference, &short).map(|_| ()),
            Err(CompareError::MalformedFrame {
                which: "frame",
                found: 5,
                required: 6
            })
        );
        assert!(crate::difference_rgb(&reference, &turned, 1).is_err());
    }
}
