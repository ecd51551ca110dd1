// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far boundaries that are moved on purpose, such as by levels of detail, have really moved.
//!
//! Pixels of the image; places count from its upper left corner, so that a pixel's centre is at half
//! pixels. When no point of a curve moves by more than δ, a pixel's id changes only if some curve swept
//! over its centre, and that curve was within δ of it before. So each mismatched centre lies within δ of a
//! place where the reference shows the id that the frame shows. So the largest such distance is measured,
//! by asking the reference at places on rings about the centre.
//!
//! The distance between two pictures' boundaries as sets of pixels cannot stand in for it. A tongue
//! of sea thinner than 2δ may close over its whole length, and that distance is then the length.
//! Here every pixel of the tongue is within δ of its shore, while in a strip too wide to close the
//! middle is not.
//!
//! The band around the boundary pixels of the reference's picture cannot either. Two shores that run less
//! than a pixel apart, such as those of a lagoon, leave gaps in that picture: where no centre falls
//! between them there is no boundary pixel. Shores moved by half a pixel fill such gaps over any length.
//! So a pixel outside that band counts as inside where the reference shows its id within the band's radius.
//!
//! A limit: between shores less than about a hundredth of a pixel apart no place that is asked may fall. What
//! fills such a gap is then called wrong.

use crate::ErrorFigures;
use crate::boundary::Grid;
use crate::compare::{CompareError, check};
use crate::tolerance::{
    BAND_RADIUS_PX, MAX_ROUNDED_PX, MOVED_SEARCH_PX, MOVED_STEP_PX, RASTERISER_PX,
};
use std::f64::consts::TAU;
use terrafill_contract::Frame;

/// Mismatched pixels that are searched for; what differs at more of them was not moved a little.
///
/// A pixel at distance d asks the reference about 2π (d / step)² times: 400 times at half a pixel
/// and 6,400 at the end of the search. At the limit that is as much as verifying an image of 1024² pixels
/// six times where pixels are off by half of one.
pub const MAX_MEASURED: usize = 16_384;

/// How far [`movement_in_picture`] looks, pixels.
pub const MAX_PICTURE_SEARCH_PX: u32 = 64;

/// How far boundaries that were moved on purpose have moved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Movement {
    /// The farthest that the centre of a mismatched pixel is from where the reference shows the frame's id
    /// for that pixel. Of a foreign pixel, it is from where the reference shows any other id than at the
    /// centre.
    pub farthest_px: f64,
    /// Mismatched pixels whose id the reference shows nowhere within [`MOVED_SEARCH_PX`]. Positions of two
    /// neighbours round each by themselves, so a pixel on their border may belong to both or to none. A
    /// fill that tells regions apart by sums of their numbers then shows a third one's id, or none.
    pub foreign_px: u64,
    /// Mismatched pixels outside the band around the reference's boundary pixels whose id the reference shows
    /// nowhere within [`BAND_RADIUS_PX`] of their centres.
    pub outside_px: u64,
}

/// How far boundaries moved, pixels.
///
/// - `shown_at`: the id that the reference shows at a place
/// - returns: never less than the true distance, since every answer is a place that was found; beyond
///   a straight boundary at most a [`MOVED_STEP_PX`] more. 0 where nothing mismatches. The image's
///   diagonal, which no distance in it exceeds, where nothing is found within [`MOVED_SEARCH_PX`]; and
///   `None` where more than [`MAX_MEASURED`] pixels mismatch.
///
/// # Errors
/// [`CompareError`] when the two cannot be laid over one another, or the reference is broken.
pub fn boundary_movement(
    reference: &Frame,
    frame: &Frame,
    shown_at: impl Fn([f64; 2]) -> u32,
) -> Result<Option<Movement>, CompareError> {
    let rings = Rings {
        step_px: MOVED_STEP_PX,
        reach_px: MOVED_SEARCH_PX,
    };
    movement(reference, frame, shown_at, rings)
}

/// How far boundaries are off that nobody moved, pixels: as [`boundary_movement`], in steps of
/// [`RASTERISER_PX`] up to [`MAX_ROUNDED_PX`].
///
/// Features thinner than a pixel leave boundary pixels far apart. A centre that rounds to the other side is then more
/// than a pixel from the next boundary pixel of the other picture, and still within rounding of what it shows.
///
/// # Errors
/// As [`boundary_movement`].
pub fn boundary_rounding(
    reference: &Frame,
    frame: &Frame,
    shown_at: impl Fn([f64; 2]) -> u32,
) -> Result<Option<Movement>, CompareError> {
    let rings = Rings {
        step_px: RASTERISER_PX,
        reach_px: MAX_ROUNDED_PX,
    };
    movement(reference, frame, shown_at, rings)
}

/// Rings about a centre on which the reference is asked.
#[derive(Debug, Clone, Copy)]
struct Rings {
    step_px: f64,
    reach_px: f64,
}

fn movement(
    reference: &Frame,
    frame: &Frame,
    shown_at: impl Fn([f64; 2]) -> u32,
    rings: Rings,
) -> Result<Option<Movement>, CompareError> {
    check(reference, frame)?;
    let differ = |index: &usize| reference.ids[*index] != frame.ids[*index];
    let mismatches: Vec<usize> = (0..frame.ids.len()).filter(differ).collect();
    if mismatches.len() > MAX_MEASURED {
        return Ok(None);
    }
    let width = frame.size.width.max(1) as usize;
    let band = Grid::of(reference).band(&reference.ids);
    let outside = mismatches.iter().filter(|&&index| !band[index]);
    let mut movement = Movement {
        outside_px: outside.count() as u64,
        ..Movement::default()
    };
    for index in mismatches {
        let centre = [index % width, index / width].map(|at| at as f64 + 0.5);
        let (shown, expected) = (frame.ids[index], reference.ids[index]);
        let mut distance_px = rings.nearest_px(centre, |place| shown_at(place) == shown);
        if !band[index] && distance_px.is_some_and(|px| px <= f64::from(BAND_RADIUS_PX)) {
            movement.outside_px -= 1;
        }
        if distance_px.is_none() {
            movement.foreign_px += 1;
            distance_px = rings.nearest_px(centre, |place| shown_at(place) != expected);
        }
        let Some(distance_px) = distance_px else {
            let [width, height] = [frame.size.width, frame.size.height].map(f64::from);
            movement.farthest_px = width.hypot(height);
            return Ok(Some(movement));
        };
        movement.farthest_px = movement.farthest_px.max(distance_px);
    }
    Ok(Some(movement))
}

/// How far boundaries moved in a picture that is approximate by nature, pixels: the farthest that a
/// mismatched pixel is from one that shows its id in the reference's picture, centre to centre. Places
/// between pixels are not looked at, so that this may be 0.7 pixels more than the true distance.
///
/// - returns: 0 where nothing mismatches; `None` where a pixel has no such one within
///   [`MAX_PICTURE_SEARCH_PX`], as of a region that is shown where none is near
/// - cost: O(mismatched pixels × square of the distance)
///
/// # Errors
/// As [`boundary_movement`].
pub fn movement_in_picture(reference: &Frame, frame: &Frame) -> Result<Option<f64>, CompareError> {
    check(reference, frame)?;
    let [width, height] = [frame.size.width, frame.size.height].map(i64::from);
    let reach = i64::from(MAX_PICTURE_SEARCH_PX);
    let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let squared = |[x, y]: [i64; 2]| x * x + y * y;
    let mut steps: Vec<[i64; 2]> = square
        .filter(|&step| squared(step) <= reach * reach)
        .collect();
    steps.sort_by_key(|&step| squared(step));
    let mut farthest = 0;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    for ([x, y], (&shown, &expected)) in places.zip(frame.ids.iter().zip(&reference.ids)) {
        if shown == expected {
            continue;
        }
        let shows_it = |&[across, down]: &[i64; 2]| {
            let place = [x + across, y + down];
            let is_inside = (0..width).contains(&place[0]) && (0..height).contains(&place[1]);
            let index = usize::try_from(place[1] * width + place[0]);
            is_inside && index.is_ok_and(|index| reference.ids[index] == shown)
        };
        let Some(&nearest) = steps.iter().find(|step| shows_it(step)) else {
            return Ok(None);
        };
        farthest = farthest.max(squared(nearest));
    }
    Ok(Some((farthest as f64).sqrt()))
}

/// The figures with what was measured of it. [`crate::compare_closely`] asks about few pixels outside the band,
/// and at fewer places around each: where all were asked about, no more are outside it than that found.
#[must_use]
pub fn with_movement(figures: ErrorFigures, movement: Option<Movement>) -> ErrorFigures {
    let outside = figures.mismatched_px_outside_band;
    ErrorFigures {
        mismatched_px_outside_band: movement.map_or(outside, |found| outside.min(found.outside_px)),
        boundary_moved_px: movement.map(|movement| movement.farthest_px),
        foreign_px: movement.map(|movement| movement.foreign_px),
        ..figures
    }
}

impl Rings {
    /// Radius of the smallest ring about `centre` on which some place `is_it`.
    fn nearest_px(self, centre: [f64; 2], is_it: impl Fn([f64; 2]) -> bool) -> Option<f64> {
        let mut places = 1_u32;
        let mut ring = 0_u32;
        loop {
            let radius_px = f64::from(ring) * self.step_px;
            if radius_px > self.reach_px {
                return None;
            }
            let on_ring = |place: u32| {
                let (sine, cosine) = (TAU * f64::from(place) / f64::from(places)).sin_cos();
                [centre[0] + radius_px * cosine, centre[1] + radius_px * sine]
            };
            if (0..places).any(|place| is_it(on_ring(place))) {
                return Some(radius_px);
            }
            ring += 1;
            // Half a step apart. A straight boundary that a ring has passed by step² / 32 d is then met by one of
            // its places: by a thousandth of a pixel at steps of 1/16, from a quarter of a pixel on.
            places = 13 * ring;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::picture;
    use crate::{
        MAX_FOREIGN_PX, Verdict, allowed_moved_px, compare, compare_closely, verdict,
        verdict_of_moved,
    };

    /// What a map of the plane looks like at the centres of 40 × 30 pixels.
    fn seen(map: impl Fn([f64; 2]) -> u32) -> Frame {
        let mut frame = picture(&[&"."; 30].map(|_| "........................................"));
        for (index, id) in frame.ids.iter_mut().enumerate() {
            *id = map([index % 40, index / 40].map(|at| at as f64 + 0.5));
        }
        frame
    }

    /// Figures of a picture of `drawn` by a reference of `truth`, as the bench takes them.
    fn figures(truth: impl Fn([f64; 2]) -> u32, drawn: &Frame) -> ErrorFigures {
        let reference = seen(&truth);
        let shows = |pixel: usize, id: u32| {
            let centre = [pixel % 40, pixel / 40].map(|at| at as f64 + 0.5);
            let steps = || (-8..=8).map(|k| f64::from(k) / 8.0);
            steps().any(|y| steps().any(|x| truth([centre[0] + x, centre[1] + y]) == id))
        };
        let figures = compare_closely(&reference, drawn, |_, _| false, shows).expect("same size");
        let movement = boundary_movement(&reference, drawn, &truth).expect("same size");
        with_movement(figures, movement)
    }

    #[test]
    fn in_a_picture_the_farthest_pixel_from_its_own_id_counts() {
        let reference = seen(land(10.0, 0.0));
        let moved =
            |x: f64| movement_in_picture(&reference, &seen(land(x, 0.0))).expect("same size");
        assert_eq!(moved(10.0), Some(0.0));
        assert_eq!(moved(11.0), Some(1.0));
        assert_eq!(moved(17.0), Some(7.0));
        assert_eq!(moved(6.0), Some(4.0));
        // Negative control: an id that the reference shows nowhere.
        let mut foreign = seen(land(10.0, 0.0));
        foreign.ids[3] = 99;
        assert_eq!(movement_in_picture(&reference, &foreign), Ok(None));
    }

    fn moved_px(truth: impl Fn([f64; 2]) -> u32, drawn: &Frame) -> f64 {
        figures(truth, drawn).boundary_moved_px.expect("measured")
    }

    /// Land on the left of a shore through `x` that turns away from upright by `slope`.
    fn land(x: f64, slope: f64) -> impl Fn([f64; 2]) -> u32 {
        move |place| u32::from(place[0] + slope * (place[1] - 15.0) < x)
    }

    #[test]
    fn a_border_has_moved_by_as_much_as_it_was_moved() {
        for slope in [0.0, 0.3, 0.7, 1.0, -2.3] {
            let truth = land(20.3, slope);
            assert_eq!(moved_px(&truth, &seen(&truth)), 0.0);
            for by_px in [0.25, 0.5, 0.9] {
                for side in [-1.0, 1.0] {
                    let drawn = land(20.3 + side * by_px * slope.hypot(1.0), slope);
                    let found = figures(&truth, &seen(drawn));
                    let moved = found.boundary_moved_px.expect("measured");
                    assert!(moved <= by_px + MOVED_STEP_PX, "{slope}: {moved}, {by_px}");
                    assert!(verdict_of_moved(&found, by_px).is_pass(), "{found:?}");
                    // By a shore along rows or diagonals of centres all are as far, and a picture
                    // tells no more; else some is nearly as far as can be. Negative control: a quarter of the
                    // truth is too little to state.
                    if ![0.0, 1.0].contains(&slope) {
                        assert!(moved >= 0.8 * by_px, "{slope}: {moved}, {by_px}");
                        assert!(!verdict_of_moved(&found, by_px / 4.0).is_pass());
                    }
                }
            }
        }
    }

    #[test]
    fn a_pixel_is_too_far_where_half_of_one_was_stated() {
        for slope in [0.0, 0.3, 0.7, -2.3] {
            let truth = land(20.6, slope);
            let drawn = seen(land(20.6 + slope.hypot(1.0), slope));
            let found = figures(&truth, &drawn);
            assert!(!verdict_of_moved(&found, 0.5).is_pass(), "{found:?}");
            assert!(verdict_of_moved(&found, 1.0).is_pass(), "{found:?}");
            // Nothing else would have shown it: it is all in the band, and no farther than two pixels.
            assert_eq!(found.mismatched_px_outside_band, 0);
            assert!(found.hausdorff_px.is_some_and(|px| px <= 2.0), "{found:?}");
        }
    }

    /// Sea on the right, and a tongue of it, `width` pixels from shore to shore, into the land.
    fn tongue(top: f64, width: f64, from: f64) -> impl Fn([f64; 2]) -> u32 {
        move |[x, y]| u32::from(x < 30.0 && !(x > from && y > top && y < top + width))
    }

    #[test]
    fn a_tongue_thinner_than_a_pixel_may_close_over_any_length() {
        for from in [27.2, 22.2, 5.2] {
            // Both shores by half a pixel: nothing is left of it.
            let truth = tongue(10.1, 0.9, from);
            let closed = seen(tongue(10.6, -0.1, from));
            let found = figures(&truth, &closed);
            assert!(found.mismatched_px >= 3, "{found:?}");
            assert!(found.hausdorff_px.is_some_and(|px| px > 2.0), "{found:?}");
            assert!(verdict_of_moved(&found, 0.5).is_pass(), "{found:?}");
            // Negative controls: boundaries that were not moved on purpose, or by a quarter as much.
            assert!(!verdict(&found).is_pass());
            assert!(!verdict_of_moved(&found, 0.125).is_pass());
        }
    }

    #[test]
    fn a_strip_two_pixels_wide_may_not_go_missing() {
        for top in [4.1, 4.25, 4.75, 4.9] {
            let strip = move |[x, y]: [f64; 2]| u32::from(x > 10.0 && y > top && y < top + 2.0);
            let found = figures(strip, &seen(|_| 0));
            // Its two rows of centres are all in the band.
            assert_eq!(found.mismatched_px_outside_band, 0, "{top}");
            assert!(!verdict_of_moved(&found, 0.5).is_pass(), "{top}: {found:?}");
        }
        // Between two rows of centres each is just half a pixel inside: exactly what both shores may
        // move by, and not a sixteenth less.
        let strip = |[x, y]: [f64; 2]| u32::from(x > 10.0 && y > 4.0 && y < 6.0);
        let found = figures(strip, &seen(|_| 0));
        assert!(found.boundary_moved_px.is_some_and(|px| px >= 0.5));
        assert!(!verdict_of_moved(&found, 0.5 - 2.0 * MOVED_STEP_PX).is_pass());
    }

    /// Three lagoons, each `width` pixels from shore to shore, which run along rows of pixels.
    fn lagoons(top: f64, width: f64) -> impl Fn([f64; 2]) -> u32 {
        let is_between = move |y: f64| y > top && y < top + width;
        move |[_, y]| u32::from([5.0, 15.0, 25.0].iter().any(|row| is_between(y - row)))
    }

    #[test]
    fn a_lagoon_between_rows_of_centres_may_move_onto_one() {
        for width in [0.05, 0.2, 0.38] {
            // No centre falls between its shores, so the picture has no boundary at all.
            let truth = lagoons(0.6, width);
            let reference = seen(&truth);
            assert!(crate::checks_nothing(&reference));
            let drawn = seen(lagoons(0.6 - 0.4, width.max(0.31)));
            let found = figures(&truth, &drawn);
            assert_eq!(found.mismatched_px, 3 * 40);
            assert_eq!(found.mismatched_px_outside_band, 0, "{found:?}");
            assert!(verdict_of_moved(&found, 0.5).is_pass(), "{found:?}");
            // Negative control: by the picture's band alone all of it is outside, and so it fails.
            let unmeasured = compare(&reference, &drawn).expect("same size");
            assert_eq!(unmeasured.mismatched_px_outside_band, 3 * 40);
            let without = ErrorFigures {
                mismatched_px_outside_band: unmeasured.mismatched_px_outside_band,
                ..found
            };
            assert!(!verdict_of_moved(&without, 0.5).is_pass());
            // Negative controls: a movement understated, boundaries not moved on purpose, and shores moved
            // too far, which is outside the band as well.
            assert!(!verdict_of_moved(&found, 1.0 / 64.0).is_pass());
            assert!(!verdict(&found).is_pass());
            let far = figures(&truth, &seen(lagoons(0.6 + 1.7, 0.3)));
            assert_eq!(far.mismatched_px_outside_band, 3 * 40, "{far:?}");
            assert!(!verdict_of_moved(&far, 2.0).is_pass(), "{far:?}");
        }
    }

    #[test]
    fn a_tooth_thinner_than_a_pixel_may_round_away_and_not_go_missing() {
        // Centres are in the tooth by so much, and beside it as drawn, over its whole length.
        let tooth = |top: f64| {
            move |[x, y]: [f64; 2]| u32::from(x < 10.0 || y > top && y < top + 0.3 && x < 30.0)
        };
        for (inside_px, passes) in [(0.003, true), (0.014, true), (0.05, false), (0.15, false)] {
            let truth = tooth(15.5 - inside_px);
            let (reference, drawn) = (seen(truth), seen(tooth(15.501)));
            let unmeasured = compare(&reference, &drawn).expect("same size");
            assert_eq!(unmeasured.mismatched_px_outside_band, 0);
            assert!(unmeasured.hausdorff_px.is_some_and(|px| px > 10.0));
            let measured = |drawn: &Frame| {
                let movement = boundary_rounding(&reference, drawn, truth).expect("same size");
                verdict(&with_movement(unmeasured, movement)).is_pass()
            };
            assert_eq!(measured(&drawn), passes, "{inside_px}");
            // Negative controls: not measured, and one more pixel, half of one from the coast.
            assert!(!verdict(&unmeasured).is_pass());
            let mut wrong = drawn;
            wrong.ids[5 * 40 + 10] = 1;
            assert!(!measured(&wrong));
        }
    }

    #[test]
    fn one_wrong_pixel_is_found_wherever_it_is() {
        let truth = |place: [f64; 2]| land(20.3, 0.3)(place) * if place[1] < 15.0 { 1 } else { 2 };
        let diagonal = 40_f64.hypot(30.0);
        // In the middle of the land, of the sea, beside the shore by more than a pixel and a half; and in
        // the land with the id of another one.
        for (column, row, id) in [(5, 5, 0), (35, 25, 1), (27, 5, 1), (10, 5, 2)] {
            let mut drawn = seen(truth);
            drawn.ids[row * 40 + column] = id;
            let found = figures(truth, &drawn);
            assert_eq!(found.mismatched_px, 1);
            let moved = found.boundary_moved_px.expect("measured");
            assert!(moved > 1.5, "{column}, {row}: {moved}");
            assert!(moved <= MOVED_SEARCH_PX || moved == diagonal, "{moved}");
            assert!(!verdict_of_moved(&found, 0.5).is_pass());
            assert!(!verdict_of_moved(&found, 1.0).is_pass());
        }
    }

    #[test]
    fn a_few_pixels_of_a_border_may_belong_to_both_sides_or_none_and_no_more() {
        let truth = |place: [f64; 2]| if place[1] < 15.3 { 1 } else { 2 };
        // Numbers 1 and 2 add up to a third region's; or nobody owns the pixel.
        for foreign in [3, 0] {
            for (count, passes) in [
                (1, true),
                (MAX_FOREIGN_PX, true),
                (MAX_FOREIGN_PX + 1, false),
            ] {
                let mut drawn = seen(truth);
                for (k, _) in (0..count).enumerate() {
                    drawn.ids[15 * 40 + 7 * k] = foreign;
                }
                let found = figures(truth, &drawn);
                assert_eq!(found.foreign_px, Some(count));
                assert!(
                    found.boundary_moved_px.is_some_and(|px| px <= 0.25),
                    "{found:?}"
                );
                assert_eq!(verdict_of_moved(&found, 0.5).is_pass(), passes, "{found:?}");
            }
            // One that is a pixel from the border counts.
            let mut drawn = seen(truth);
            drawn.ids[16 * 40 + 7] = foreign;
            let found = figures(truth, &drawn);
            assert!(!verdict_of_moved(&found, 0.5).is_pass(), "{found:?}");
        }
    }

    #[test]
    fn what_was_not_measured_does_not_pass() {
        let (empty, full) = (seen(|_| 0), seen(|_| 1));
        let many = |rows: u32| {
            let mut frame = empty.clone();
            frame.size.height = rows;
            frame.ids = vec![0; 40 * rows as usize];
            frame
        };
        let rows = 410; // × 40 = 16,400, just above the limit.
        let (reference, mut drawn) = (many(rows), many(rows));
        assert!(drawn.ids.len() > MAX_MEASURED);
        drawn.ids[..MAX_MEASURED].fill(1);
        let everywhere = |_: [f64; 2]| 1;
        let measured = |drawn: &Frame| boundary_movement(&reference, drawn, everywhere);
        assert_eq!(measured(&drawn), Ok(Some(Movement::default())));
        drawn.ids[MAX_MEASURED] = 1;
        assert_eq!(measured(&drawn), Ok(None));
        let unmeasured = ErrorFigures {
            mismatched_px: MAX_MEASURED as u64 + 1,
            ..ErrorFigures::default()
        };
        let Verdict::Fail(reasons) = verdict_of_moved(&unmeasured, 0.5) else {
            panic!("passed")
        };
        assert!(reasons[0].contains("16385") && reasons[0].contains("16384"));
        // Another size is no comparison at all.
        assert!(boundary_movement(&reference, &full, everywhere).is_err());
        assert!(compare(&reference, &full).is_err());
    }

    #[test]
    fn a_border_at_the_limit_passes_and_a_step_farther_fails() {
        let of = |moved: f64| ErrorFigures {
            boundary_moved_px: Some(moved),
            hausdorff_px: Some(9.0),
            ..ErrorFigures::default()
        };
        let allowed = allowed_moved_px(0.5);
        assert!((allowed - 0.5 - 1.0 / 16.0 - 1.0 / 256.0).abs() < 1e-12);
        assert!(verdict_of_moved(&of(allowed), 0.5).is_pass());
        assert!(!verdict_of_moved(&of(allowed + 1e-9), 0.5).is_pass());
        assert!(!verdict_of_moved(&of(f64::NAN), 0.5).is_pass());
        // Where nothing was to move, the distance of the boundaries counts beyond rounding.
        assert!(verdict_of_moved(&of(MAX_ROUNDED_PX), 0.0).is_pass());
        assert!(!verdict_of_moved(&of(MAX_ROUNDED_PX + 1e-9), 0.0).is_pass());
        assert!(!verdict_of_moved(&of(f64::NAN), 0.0).is_pass());
    }
}
