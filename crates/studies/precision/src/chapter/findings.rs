// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was computed before the measurement, and whether the measurement agrees.

use super::data::{
    DEFAULT_POSITION, Data, MIDDLE, NO_REASON, PLAN, QUARTER, is_chosen, non_finite, number,
};
use crate::error::agrees;
use crate::metrics::{self, *};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Case, Finding, Metric, Outcome};

/// Largest error of a plan's route, texels.
const MAX_TEXELS: f64 = 0.5;

/// What a bound found at some thousand places may miss of a peak between them.
const BOUND_SLACK: f64 = 1.02;

/// What the default position must not exceed, metres, at this distance.
const DEFAULT_LIMIT: (f64, f64) = (20.0, 1e-4);

fn finding(holds: bool, text: String) -> Finding {
    terrafill_lab::finding(text, Some(holds), "")
}

fn largest<'a>(rows: impl Iterator<Item = &'a Case>, metric: &Metric) -> Option<(f64, &'a Case)> {
    rows.filter_map(|row| Some((row.value(metric)?, row)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

pub(super) fn findings(data: &Data<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let chosen = || data.formulas.iter().filter(|row| is_chosen(row));
    let not_finite: u64 = chosen().map(non_finite).sum();
    let contradicted = chosen().filter(|row| row.outcome != Outcome::Ok).count();
    let places = data.of("coordinate").distinct(CONDITION);
    let rms = largest(chosen(), RMS_TEXELS);
    let max = largest(chosen(), metrics::MAX_TEXELS);
    if let (Some((rms, rms_at)), Some((max, max_at))) = (rms, max) {
        let unchosen = places.len() - chosen().count();
        let within = rms <= QUARTER && max <= MAX_TEXELS;
        let holds = within && not_finite + (contradicted + unchosen) as u64 == 0;
        findings.push(finding(
            holds,
            format!(
                "Routes that a plan takes, on the device: at most {} texel RMS ({} at {}) and {} texel \
                 ({} at {}); {not_finite} answers not finite; {contradicted} contradicted by \
                 measurement; {unchosen} of {} regions without such a route.",
                significant(rms),
                rms_at.condition(ROUTE),
                rms_at.condition(CONDITION),
                significant(max),
                max_at.condition(ROUTE),
                max_at.condition(CONDITION),
                places.len(),
            ),
        ));
    }
    let (route, depth) = DEFAULT_POSITION;
    let default = data.of("position");
    let default = default.with(&[(ROUTE, route), (DEPTH_FORMAT, depth)]);
    let anchored = |anchor: &str| default.with(&[(ANCHOR, anchor)]);
    let at_20_m = |anchor| {
        let near = |row: &Case| number(row, DISTANCE_M) == Some(DEFAULT_LIMIT.0);
        largest(anchored(anchor).fitting(near).iter(), DEVICE_MAX_M)
    };
    let beside = |middle: Option<(f64, &Case)>, unit: &str| {
        middle.map_or_else(String::new, |(most, row)| {
            let most = significant(most);
            format!(
                " Anchored in the middle of the region: {most} {unit} ({}).",
                row.condition(CONDITION)
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
                row.condition(CONDITION),
                beside(at_20_m(MIDDLE), "m"),
            ),
        ));
    }
    if let Some((pixels, row)) = largest(anchored(PLAN).iter(), MAX_PX) {
        let middle = largest(anchored(MIDDLE).iter(), MAX_PX);
        findings.push(finding(
            pixels <= QUARTER,
            format!(
                "The same from 10 m to 30,000 km, over every extent and latitude: at most {} of a pixel \
                 ({}).{}",
                significant(pixels),
                row.condition(CONDITION),
                beside(middle, "of a pixel"),
            ),
        ));
    }
    // Where a route is no map at all there is nothing to bound.
    let is_measured = |row: &&Case| row.value(MEASURED_OVER_EXPECTED).is_some();
    let measured = || data.formulas.iter().filter(is_measured);
    let all = count(measured().count() as u64);
    let ratios = measured().filter_map(|row| row.value(MAX_OVER_RESIDUAL));
    let above = ratios.filter(|ratio| *ratio > BOUND_SLACK).count();
    if let Some((ratio, row)) = largest(measured(), MAX_OVER_RESIDUAL) {
        findings.push(finding(
            above == 0,
            format!(
                "Largest measured error over its bound: {} ({}, {}); {above} of {all} rows are above it by \
                 more than the 2 % that sampling may miss of a peak.",
                significant(ratio),
                row.condition(ROUTE),
                row.condition(CONDITION),
            ),
        ));
    }
    let agreeing = measured().filter(|row| row.value(MEASURED_OVER_EXPECTED).is_some_and(agrees));
    let unexplained = measured()
        .filter(|row| row.note("residual_reason").contains(NO_REASON))
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
