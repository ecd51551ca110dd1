// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was computed before the measurement, and whether the measurement agrees.

use super::data::{DEFAULT_POSITION, Data, Formula, MIDDLE, NO_REASON, PLAN, QUARTER, agrees};
use crate::keys::{self, *};
use std::collections::BTreeSet;
use terrafill_plot::number::{count, significant};
use terrafill_results::{Finding, Metric};

/// Largest error of a plan's route, texels.
const MAX_TEXELS: f64 = 0.5;

/// What a bound found at some thousand places may miss of a peak between them.
const BOUND_SLACK: f64 = 1.02;

/// What the default position must not exceed, metres, at this distance.
const DEFAULT_LIMIT: (f64, f64) = (20.0, 1e-4);

fn finding(holds: bool, text: String) -> Finding {
    terrafill_lab::finding(text, Some(holds), "")
}

fn largest<'a>(
    rows: impl Iterator<Item = Formula<'a>>,
    metric: &Metric,
) -> Option<(f64, Formula<'a>)> {
    rows.filter_map(|row| Some((row.figure(metric)?, row)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

pub(super) fn findings(data: &Data<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let chosen = || data.formulas.iter().copied().filter(|row| row.is_chosen());
    let non_finite: u64 = chosen().map(Formula::non_finite).sum();
    let contradicted = chosen().filter(|row| !row.is_ok()).count();
    let places: BTreeSet<&str> = data.of("coordinate").map(|row| row.condition()).collect();
    let rms = largest(chosen(), RMS_TEXELS);
    let max = largest(chosen(), keys::MAX_TEXELS);
    if let (Some((rms, rms_at)), Some((max, max_at))) = (rms, max) {
        let unchosen = places.len() - chosen().count();
        let within = rms <= QUARTER && max <= MAX_TEXELS;
        let holds = within && non_finite + (contradicted + unchosen) as u64 == 0;
        findings.push(finding(
            holds,
            format!(
                "Routes that a plan takes, on the device: at most {} texel RMS ({} at {}) and {} texel \
                 ({} at {}); {non_finite} answers not finite; {contradicted} contradicted by \
                 measurement; {unchosen} of {} regions without such a route.",
                significant(rms),
                rms_at.route(),
                rms_at.condition(),
                significant(max),
                max_at.route(),
                max_at.condition(),
                places.len(),
            ),
        ));
    }
    let default = || {
        data.of("position")
            .filter(|row| (row.route(), row.0.condition(DEPTH_FORMAT)) == DEFAULT_POSITION)
    };
    let anchored = |anchor: &'static str| default().filter(move |row| row.anchor() == anchor);
    let at_20_m = |anchor| {
        let near = anchored(anchor).filter(|row| row.number(DISTANCE_M) == Some(DEFAULT_LIMIT.0));
        largest(near, DEVICE_MAX_M)
    };
    let beside = |middle: Option<(f64, Formula<'_>)>, unit: &str| {
        middle.map_or_else(String::new, |(most, row)| {
            let most = significant(most);
            format!(
                " Anchored in the middle of the region: {most} {unit} ({}).",
                row.condition()
            )
        })
    };
    if let Some((metres, row)) = at_20_m(PLAN) {
        findings.push(finding(
            metres <= DEFAULT_LIMIT.1,
            format!(
                "The default position, {}, at 20 m, its anchor where a plan puts it: {} m at most ({}).{}",
                DEFAULT_POSITION.0,
                significant(metres),
                row.condition(),
                beside(at_20_m(MIDDLE), "m"),
            ),
        ));
    }
    if let Some((pixels, row)) = largest(anchored(PLAN), MAX_PX) {
        let middle = largest(anchored(MIDDLE), MAX_PX);
        findings.push(finding(
            pixels <= QUARTER,
            format!(
                "The same from 10 m to 30,000 km, over every extent and latitude: at most {} of a pixel \
                 ({}).{}",
                significant(pixels),
                row.condition(),
                beside(middle, "of a pixel"),
            ),
        ));
    }
    // Where a route is no map at all there is nothing to bound.
    let is_measured = |row: &Formula<'_>| row.figure(MEASURED_OVER_EXPECTED).is_some();
    let measured = || data.formulas.iter().copied().filter(is_measured);
    let all = count(measured().count() as u64);
    let ratios = measured().filter_map(|row| row.figure(MAX_OVER_RESIDUAL));
    let above = ratios.filter(|ratio| *ratio > BOUND_SLACK).count();
    if let Some((ratio, row)) = largest(measured(), MAX_OVER_RESIDUAL) {
        findings.push(finding(
            above == 0,
            format!(
                "Largest measured error over its bound: {} ({}, {}); {above} of {all} rows are above it by \
                 more than the 2 % that sampling may miss of a peak.",
                significant(ratio),
                row.route(),
                row.condition(),
            ),
        ));
    }
    let agreeing = measured().filter(|row| row.figure(MEASURED_OVER_EXPECTED).is_some_and(agrees));
    let unexplained = measured()
        .filter(|row| row.0.note("residual_reason").contains(NO_REASON))
        .count();
    if measured().count() > 0 {
        findings.push(finding(
            unexplained == 0,
            format!(
                "Formula and measurement agree within 2 × in {} of {all} rows; {unexplained} of the others have \
                 no known reason.",
                count(agreeing.count() as u64),
            ),
        ));
    }
    findings
}
