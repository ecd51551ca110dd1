// SPDX-License-Identifier: MIT OR Apache-2.0
//! What may be chosen for a scene within the reader's limits: right fills, and approximate ones by the error that they
//! had in this run. Points of sweeps may not.

use super::data::{Data, ViewCases, label};
use crate::keys::*;
use crate::purpose::{is_approximate, is_point};
use terrafill_conformance::{BAND_RADIUS_PX, MAX_PICTURE_SEARCH_PX, MAX_ROUNDED_PX};
use terrafill_lab::{Contender, cheapest_within, in_every_group};
use terrafill_results::{Block, Budget, Case, Metric, Outcome};

/// What a fill holds of its own.
const HELD: [&Metric; 3] = [CONSTANT_BYTES, TARGET_BYTES, TEXTURE_BYTES];

/// The section; nothing where no fill of any scene was timed in all its views.
pub(super) fn block(data: &Data<'_>, budget: &Budget) -> Option<Block> {
    let scenes = data.scenes().into_iter();
    let scenes = scenes.map(|(scene, views)| (scene, contenders(&views)));
    cheapest_within(data.run, data.timings, budget, scenes)
}

fn contenders<'a>(views: &[&ViewCases<'a>]) -> Vec<Contender<'a>> {
    let largest = |figures: Vec<Option<f64>>| {
        let known: Option<Vec<f64>> = figures.into_iter().collect();
        known.map(|known| known.into_iter().fold(0.0, f64::max))
    };
    let of_view = |view: &&ViewCases<'a>| view.cases.iter().copied().filter(competes).collect();
    let of_views: Vec<Vec<&Case>> = views.iter().map(of_view).collect();
    let fills = in_every_group(&of_views, label).into_iter();
    let fills = fills.map(|(name, cases)| Contender {
        name,
        error_px: largest(cases.iter().map(|case| error_px(case)).collect())
            .ok_or(f64::from(MAX_PICTURE_SEARCH_PX)),
        bytes: largest(cases.iter().map(|case| held_bytes(case)).collect()),
        is_approximate: cases.iter().any(|case| is_approximate(case)),
        cases,
    });
    fills.collect()
}

/// How far a picture's boundaries are from the reference's, pixels: 0 for a right fill that simplifies none, whose
/// boundary pixels alone are rounded; `None` for more than could be measured.
///
/// Of an approximate fill whole pixels are compared, so that a picture without a difference may be off by one.
fn error_px(case: &Case) -> Option<f64> {
    let moved = case.value(BOUNDARY_MOVED_PX);
    if !is_approximate(case) {
        let simplified = moved.filter(|px| *px > MAX_ROUNDED_PX);
        return Some(simplified.unwrap_or(0.0));
    }
    // Both ways: what the picture has too much of, and what it lacks.
    let lacks = case.value(HAUSDORFF_PX).unwrap_or(0.0);
    Some(moved?.max(lacks).max(f64::from(BAND_RADIUS_PX)))
}

/// Bytes of geometry, constants, targets and textures; `None` where the technique counts none.
pub(super) fn held_bytes(case: &Case) -> Option<f64> {
    let others = HELD.iter().filter_map(|metric| case.value(*metric));
    Some(case.value(GEOMETRY_BYTES)? + others.sum::<f64>())
}

/// Right, or approximate by nature, with a picture that was compared.
fn competes(case: &&Case) -> bool {
    let is_usable = if is_approximate(case) {
        matches!(case.outcome, Outcome::Ok | Outcome::Wrong)
    } else {
        case.counts()
    };
    !is_point(case) && is_usable && case.value(MISMATCHED_PX).is_some()
}

#[cfg(test)]
mod tests;
