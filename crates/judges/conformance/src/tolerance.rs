// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every tolerance, with its cause.
//!
//! | tolerance | value | cause |
//! |---|---|---|
//! | [`BAND_RADIUS_PX`] | 1 | rasterisers snap vertices to 1/256 pixel and round depth, so the pixel that a boundary crosses may fall to either side, and no other pixel may; a boundary between the centres of the reference's pixels is one too ([`crate::compare_closely`]) |
//! | [`MAX_MISMATCHED_OUTSIDE_BAND_PX`] | 0 | beyond the band no rounding reaches; what is wrong there is a leak, a missing wall or another region's colour |
//! | [`MAX_HAUSDORFF_PX`] | 1 | a boundary that moved by less than a pixel moves its pixels by one at most; what stays in the band but goes missing over a length, such as a strip two pixels wide, shows up here only |
//! | [`allowed_moved_px`] | what is stated, 1/16 and 1/256 | a boundary drawn aside on purpose moves by as much as was stated for it; it is looked for in steps of [`MOVED_STEP_PX`], and then snapped to [`RASTERISER_PX`] |
//! | [`MAX_FOREIGN_PX`] | 4 | two neighbours' positions round each by themselves, to a ten-thousandth of a pixel from afar, and ten thousand pixels lie on borders: one of them belongs to both or to none; 1 is the most that was seen |
//! | [`SMALLEST_PIECE_PX`] | 4 | a piece of 1 to 3 pixels exists by the luck of where pixel centres fall; rounding may take it whole, or give it whole where the reference shows it between its pixels, and the distance to the next boundary is then anything |
//! | [`MAX_NON_FINITE`] | 0 | NaN compares false with everything, so it would hide in any other figure |
//! | [`MAX_TEXELS_RMS`] | ¼ | filtering with 8-bit weights blends neighbours in steps of 1/256 texel and eyes tell a quarter of one at best; a route to coordinates is chosen by that |
//! | [`MAX_TEXELS`] | ½ | twice the mean: a pixel that is off by more shows a neighbour's texel |
//! | [`DEPTH_JUMP`] | 5 % | seen from 2 km the reciprocal distance of neighbouring rows bends by 2 % of itself two pixels below the horizon, and by less everywhere else on a smooth surface |

use crate::{MOST_MEASURED, TextureErrors};
use terrafill_results::legacy::ErrorFigures;

/// How far from a boundary pixel of the reference a mismatch is put down to rounding; counted in
/// steps to the eight neighbours.
pub const BAND_RADIUS_PX: u32 = 1;

/// Mismatched pixels allowed outside the band.
pub const MAX_MISMATCHED_OUTSIDE_BAND_PX: u64 = 0;

/// Largest symmetric Hausdorff distance between the boundaries, pixels.
pub const MAX_HAUSDORFF_PX: f64 = 1.0;

/// Steps in which [`crate::boundary_movement`] looks for a boundary, pixels: what it finds may be as much
/// farther than the truth.
pub const MOVED_STEP_PX: f64 = 1.0 / 16.0;

/// How far it looks, pixels: twice the band, in which all that moved on purpose stays.
pub const MOVED_SEARCH_PX: f64 = 2.0;

/// Pixels allowed on borders that were drawn aside that show neither side ([`crate::Movement`]).
pub const MAX_FOREIGN_PX: u64 = 4;

/// Rasterisers snap corners to this part of a pixel (Vulkan 1.3, `subPixelPrecisionBits` of 8).
pub const RASTERISER_PX: f64 = 1.0 / 256.0;

/// How far boundaries may be found to have moved that were drawn up to `moved_px` pixels aside.
#[must_use]
pub fn allowed_moved_px(moved_px: f64) -> f64 {
    moved_px + MOVED_STEP_PX + RASTERISER_PX
}

/// Pieces of the reference with fewer pixels are left out of the Hausdorff distance.
pub const SMALLEST_PIECE_PX: u64 = 4;

/// NaN or infinite results allowed.
pub const MAX_NON_FINITE: u64 = 0;

/// Root of the mean square of the texture coordinates' errors allowed, texels, of `u` and of `v`.
pub const MAX_TEXELS_RMS: f64 = 0.25;

/// Largest error of a texture coordinate allowed, texels.
pub const MAX_TEXELS: f64 = 0.5;

/// Between two pixels is a silhouette where the reciprocal distance foretold from either side is
/// off by more than this share.
pub const DEPTH_JUMP: f64 = 0.05;

/// Whether a picture may be called right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Every figure is within its tolerance.
    Pass,
    /// What is not: one phrase a figure, with the value found and the value allowed.
    Fail(Vec<String>),
}

impl Verdict {
    /// Whether this is [`Verdict::Pass`].
    #[must_use]
    pub fn is_pass(&self) -> bool {
        *self == Self::Pass
    }
}

/// Holds `figures` against the tolerances of this module.
///
/// An absent Hausdorff distance passes: neither picture has a boundary then, and mismatches are
/// all outside the band. A distance that is not a number fails.
#[must_use]
pub fn verdict(figures: &ErrorFigures) -> Verdict {
    verdict_of_moved(figures, 0.0)
}

/// The same for a picture whose boundaries were drawn up to `moved_px` pixels aside on purpose, such
/// as by levels of detail.
///
/// How far they moved is measured ([`crate::boundary_movement`]) and held against [`allowed_moved_px`];
/// a figure that was not measured fails. It stands for the Hausdorff distance, which no movement bounds:
/// a feature thinner than twice the movement may vanish over any length. 0 outside the band holds as
/// ever. Where `moved_px` is 0 this is [`verdict`].
#[must_use]
pub fn verdict_of_moved(figures: &ErrorFigures, moved_px: f64) -> Verdict {
    let mut reasons = Vec::new();
    let outside = figures.mismatched_px_outside_band;
    if outside > MAX_MISMATCHED_OUTSIDE_BAND_PX {
        reasons.push(format!(
            "{outside} mismatched pixels outside the boundary band, allowed \
             {MAX_MISMATCHED_OUTSIDE_BAND_PX}"
        ));
    }
    if moved_px > 0.0 {
        reasons.extend(objection_to_movement(figures, allowed_moved_px(moved_px)));
        reasons.extend(objection_to_foreign(figures));
    } else {
        reasons.extend(objection_to_distance(figures));
    }
    if figures.non_finite > MAX_NON_FINITE {
        reasons.push(format!(
            "{} NaN or infinite results, allowed {MAX_NON_FINITE}",
            figures.non_finite
        ));
    }
    if reasons.is_empty() {
        Verdict::Pass
    } else {
        Verdict::Fail(reasons)
    }
}

fn objection_to_distance(figures: &ErrorFigures) -> Option<String> {
    let distance = figures.hausdorff_px?;
    (distance.is_nan() || distance > MAX_HAUSDORFF_PX).then(|| {
        format!("boundary Hausdorff distance {distance:.2} px, allowed {MAX_HAUSDORFF_PX:.2}")
    })
}

fn objection_to_movement(figures: &ErrorFigures, allowed_px: f64) -> Option<String> {
    let Some(moved) = figures.boundary_moved_px else {
        return Some(format!(
            "how far boundaries moved was not measured: {} pixels mismatch, at most \
             {MOST_MEASURED} are asked about",
            figures.mismatched_px
        ));
    };
    (moved.is_nan() || moved > allowed_px)
        .then(|| format!("boundaries moved by {moved:.3} px, allowed {allowed_px:.3}"))
}

fn objection_to_foreign(figures: &ErrorFigures) -> Option<String> {
    let found = figures.foreign_px.filter(|px| *px > MAX_FOREIGN_PX)?;
    Some(format!(
        "{found} pixels show what the reference shows nowhere near them, allowed {MAX_FOREIGN_PX}"
    ))
}

/// Holds the errors of a textured frame against the tolerances of this module. Errors of nothing at
/// all fail: they have checked nothing.
#[must_use]
pub fn texture_verdict(errors: &TextureErrors) -> Verdict {
    let mut reasons = Vec::new();
    if errors.compared_px == 0 {
        reasons.push("no textured pixel compared, needs 1".to_owned());
    }
    if errors.missing_px > 0 {
        let missing = errors.missing_px;
        reasons.push(format!("{missing} pixels without coordinates, allowed 0"));
    }
    if errors.non_finite > MAX_NON_FINITE {
        let found = errors.non_finite;
        reasons.push(format!(
            "{found} NaN or infinite texture coordinates, allowed {MAX_NON_FINITE}"
        ));
    }
    for (what, found, allowed) in [
        ("RMS", errors.rms_texels, MAX_TEXELS_RMS),
        ("largest", errors.max_texels, MAX_TEXELS),
    ] {
        let worst = if found[1].is_nan() {
            found[1]
        } else {
            found[0].max(found[1])
        };
        if found
            .iter()
            .any(|&texels| texels.is_nan() || texels > allowed)
        {
            reasons.push(format!("{what} error {worst:.3} texels, allowed {allowed}"));
        }
    }
    if reasons.is_empty() {
        Verdict::Pass
    } else {
        Verdict::Fail(reasons)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_moved_on_purpose_are_judged_by_how_far_they_moved() {
        let figures = |moved_px: f64, hausdorff_px: f64, outside: u64| ErrorFigures {
            hausdorff_px: Some(hausdorff_px),
            boundary_moved_px: Some(moved_px),
            mismatched_px_outside_band: outside,
            ..ErrorFigures::default()
        };
        let diagonal = 2_f64.sqrt();
        assert!(verdict_of_moved(&figures(0.5, diagonal, 0), 0.5).is_pass());
        assert!(!verdict(&figures(0.5, diagonal, 0)).is_pass());
        assert!(verdict_of_moved(&figures(0.5, 5_f64.sqrt(), 0), 0.5).is_pass());
        assert!(!verdict_of_moved(&figures(0.75, diagonal, 0), 0.5).is_pass());
        assert!(!verdict_of_moved(&figures(0.5, diagonal, 1), 0.5).is_pass());
        assert!(!verdict_of_moved(&figures(f64::NAN, 0.0, 0), 0.5).is_pass());
    }

    #[test]
    fn each_figure_at_its_limit_passes_and_beyond_it_fails_alone() {
        let at_limit = ErrorFigures {
            mismatched_px: 7,
            hausdorff_px: Some(MAX_HAUSDORFF_PX),
            ..ErrorFigures::default()
        };
        assert!(verdict(&at_limit).is_pass());
        assert!(verdict(&ErrorFigures::default()).is_pass());
        let beyond = [
            ErrorFigures {
                mismatched_px_outside_band: 1,
                ..at_limit
            },
            ErrorFigures {
                hausdorff_px: Some(2_f64.sqrt()),
                ..at_limit
            },
            ErrorFigures {
                hausdorff_px: Some(f64::NAN),
                ..at_limit
            },
            ErrorFigures {
                hausdorff_px: Some(f64::INFINITY),
                ..at_limit
            },
            ErrorFigures {
                non_finite: 1,
                ..at_limit
            },
        ];
        for figures in beyond {
            match verdict(&figures) {
                Verdict::Fail(reasons) => assert_eq!(reasons.len(), 1, "{reasons:?}"),
                Verdict::Pass => panic!("{figures:?} passed"),
            }
        }
    }

    #[test]
    fn every_reason_is_given() {
        let figures = ErrorFigures {
            mismatched_px: 12,
            mismatched_px_outside_band: 3,
            hausdorff_px: Some(5.0),
            non_finite: 2,
            ..ErrorFigures::default()
        };
        let Verdict::Fail(reasons) = verdict(&figures) else {
            panic!("passed")
        };
        assert_eq!(reasons.len(), 3);
        assert!(
            reasons[0].starts_with('3') && reasons[2].starts_with('2'),
            "{reasons:?}"
        );
        assert!(reasons[1].contains("5.00"), "{reasons:?}");
    }
}
