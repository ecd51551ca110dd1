// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether figures of error are within the tolerances.

use crate::ErrorFigures;
use crate::moved::MAX_MEASURED;
use crate::texture::TextureErrors;
use crate::tolerance::{
    MAX_FOREIGN_PX, MAX_HAUSDORFF_PX, MAX_MISMATCHED_OUTSIDE_BAND_PX, MAX_NON_FINITE,
    MAX_ROUNDED_PX, MAX_TEXELS, MAX_TEXELS_RMS, allowed_moved_px,
};

/// Whether a picture may be called right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Every figure is within its tolerance.
    Pass,
    /// What is not: one phrase a figure, with the value found and the value allowed.
    Fail(Vec<String>),
}

impl Verdict {
    fn of(reasons: Vec<String>) -> Self {
        if reasons.is_empty() {
            Self::Pass
        } else {
            Self::Fail(reasons)
        }
    }

    /// Whether this is [`Verdict::Pass`].
    #[must_use]
    pub fn is_pass(&self) -> bool {
        *self == Self::Pass
    }
}

/// Compares `figures` with the tolerances.
///
/// An absent Hausdorff distance passes: neither picture has a boundary then, and mismatches are
/// all outside the band. A distance that is not a number fails. One beyond [`MAX_HAUSDORFF_PX`] passes where
/// every mismatched pixel was found within rounding of what it shows ([`crate::boundary_rounding`]).
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
    } else if let Some(objection) = objection_to_distance(figures) {
        let is_by_rounding = objection_to_movement(figures, MAX_ROUNDED_PX).is_none()
            && objection_to_foreign(figures).is_none();
        reasons.extend((!is_by_rounding).then_some(objection));
    }
    if figures.non_finite > MAX_NON_FINITE {
        reasons.push(format!(
            "{} NaN or infinite results, allowed {MAX_NON_FINITE}",
            figures.non_finite
        ));
    }
    Verdict::of(reasons)
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
             {MAX_MEASURED} are measured",
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

/// Compares the errors of a textured frame with the tolerances. Without a compared pixel it fails,
/// because nothing was checked.
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
    Verdict::of(reasons)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_moved_on_purpose_pass_by_how_far_they_moved() {
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
        let beyond: [fn(&mut ErrorFigures); 5] = [
            |figures| figures.mismatched_px_outside_band = 1,
            |figures| figures.hausdorff_px = Some(2_f64.sqrt()),
            |figures| figures.hausdorff_px = Some(f64::NAN),
            |figures| figures.hausdorff_px = Some(f64::INFINITY),
            |figures| figures.non_finite = 1,
        ];
        for change in beyond {
            let mut figures = at_limit;
            change(&mut figures);
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
