// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes: from pixel and depth to the offset.

use crate::coordinate::put_operations;
use crate::error::{AGREEMENT, LengthErrors, judge};
use crate::kernel::{Kernels, ask};
use crate::keys::*;
use crate::place::radical_inverse;
use crate::row::{PrecisionPart, PrecisionRow};
use crate::sight::{CLEARED_PIXEL, DISTANCE_SPREAD, IMAGE, ProbeView, TIMED_DISTANCE_M};
use glam::DVec3;
use terrafill_results::Status;
use terrafill_study::StudyError;
use terrafill_texture::{Arithmetic, MapRegion, PerspectiveView, PositionRoute};

/// A pixel, its distance, its depth as read back, and where it is.
struct Seen {
    input: [f32; 4],
    exact_m: DVec3,
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "pixel centres are exact in f32"
)]
fn seen(view: &PerspectiveView, region: &MapRegion, distance_m: f64, count: u32) -> Vec<Seen> {
    let [width, height] = IMAGE.map(f64::from);
    (1..=count)
        .map(|i| {
            let pixel = [
                (radical_inverse(i, 2) * width).floor() + 0.5,
                (radical_inverse(i, 3) * height).floor() + 0.5,
            ];
            let distance_m = distance_m * (1.0 + DISTANCE_SPREAD * (radical_inverse(i, 5) - 0.5));
            let depth = view.depth.stored(distance_m);
            Seen {
                input: [pixel[0] as f32, pixel[1] as f32, depth, 0.0],
                exact_m: view.exact_offset_m(region, pixel, distance_m),
            }
        })
        .collect()
}

fn errors_of(seen: &[Seen], answers: impl Iterator<Item = [f32; 3]>) -> LengthErrors {
    let mut errors = LengthErrors::default();
    for (seen, answer) in seen.iter().zip(answers) {
        let found = DVec3::from_array(answer.map(f64::from));
        errors.add((found - seen.exact_m).length());
    }
    errors
}

/// Rows of every route for what is seen.
pub(crate) fn rows(
    sight: &ProbeView,
    points: u32,
    kernels: &Kernels,
) -> Result<Vec<PrecisionRow>, StudyError> {
    let Some(place) = sight.place() else {
        return Ok(Vec::new());
    };
    let view = sight.view(&place);
    let Some(region) = sight.region(&place, &view) else {
        return Ok(Vec::new());
    };
    match sight.distance_m {
        Some(_) => drawn_rows(sight, &view, &region, points, kernels),
        None => cleared_rows(sight, &view, &region, kernels),
    }
}

/// A route's row before anything is measured.
pub(crate) fn identity(sight: &ProbeView, route: PositionRoute) -> PrecisionRow {
    PrecisionRow {
        extent_deg: Some(sight.extent_deg),
        latitude_deg: Some(sight.latitude_deg),
        anchor: sight.anchor.name().to_owned(),
        distance_m: sight.distance_m,
        depth_format: sight.format.name(),
        ..PrecisionRow::new(PrecisionPart::Position, route.name(), sight.name())
    }
}

/// What the routes make of a pixel in which nothing was drawn. No fragment is there, so nothing is
/// wrong: the rows say what would come of asking.
fn cleared_rows(
    sight: &ProbeView,
    view: &PerspectiveView,
    region: &MapRegion,
    kernels: &Kernels,
) -> Result<Vec<PrecisionRow>, StudyError> {
    let mut rows = Vec::new();
    let depth = sight.cleared_depth();
    let mapping = sight.format.mapping();
    for kernel in kernels.position.iter().filter(|k| k.mapping == mapping) {
        let route = kernel.route;
        let constants = route.constants(view, region);
        let mut row = identity(sight, route);
        put_operations(&mut row, &route.operations(&sight.format));
        row.put(POINTS, 1.0);
        row.status = Status::Ok;
        row.reason = "cleared depth: no fragment is there".to_owned();
        let non_finite =
            |answer: [f32; 3]| f64::from(u8::from(answer.iter().any(|v| !v.is_finite())));
        let emulated = route.emulate(&sight.format, &constants, CLEARED_PIXEL, depth);
        row.emulated_answer = format!("{emulated:?}");
        row.put(NON_FINITE_EMULATED, non_finite(emulated));
        let [x, y] = CLEARED_PIXEL;
        match ask(&kernel.device, &constants, &[[x, y, depth, 0.0]])? {
            Ok(answers) => {
                let [x, y, z, _] = answers.values[0];
                row.device_answer = format!("{:?}", [x, y, z]);
                row.put(NON_FINITE_DEVICE, non_finite([x, y, z]));
            }
            Err(why) => (row.status, row.reason) = (Status::Skipped, why),
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Whether the device's error is that of `fma` rounded after the product and after the sum.
fn rounds_products(
    route: PositionRoute,
    sight: &ProbeView,
    constants: &[[f32; 4]],
    seen: &[Seen],
    device_rms_m: Option<f64>,
) -> bool {
    let program = route.program(&sight.format);
    let answers = seen.iter().map(|seen| {
        let [x, y, depth, _] = seen.input;
        let all = program.emulate_all(constants, [x, y, depth], Arithmetic::Separate);
        [all[0], all[1], all[2]]
    });
    let [_, rms_m] = errors_of(seen, answers).figures().unwrap_or([f64::NAN; 2]);
    let same = device_rms_m.map(|device| device / rms_m);
    same.is_some_and(|ratio| (0.8..1.25).contains(&ratio))
}

fn drawn_rows(
    sight: &ProbeView,
    view: &PerspectiveView,
    region: &MapRegion,
    points: u32,
    kernels: &Kernels,
) -> Result<Vec<PrecisionRow>, StudyError> {
    let mut rows = Vec::new();
    let distance_m = sight.distance_m.unwrap_or(TIMED_DISTANCE_M);
    let seen = seen(view, region, distance_m, points);
    let inputs: Vec<[f32; 4]> = seen.iter().map(|seen| seen.input).collect();
    let pixel_m = view.pixel_size_m(distance_m);
    let mapping = sight.format.mapping();
    for kernel in kernels.position.iter().filter(|k| k.mapping == mapping) {
        let route = kernel.route;
        let constants = route.constants(view, region);
        let residual = route.residual(view, region, distance_m);
        let emulated = seen.iter().map(|seen| {
            let [x, y, depth, _] = seen.input;
            route.emulate(&sight.format, &constants, [x, y], depth)
        });
        let emulated = errors_of(&seen, emulated);
        let mut row = identity(sight, route);
        put_operations(&mut row, &route.operations(&sight.format));
        row.put(POINTS, f64::from(points));
        emulated.put(
            &mut row,
            NON_FINITE_EMULATED,
            [EMULATED_MAX_M, EMULATED_RMS_M],
        );
        row.put(PIXEL_M, pixel_m);
        row.put(RESIDUAL_MAX_M, residual.max_m);
        row.put(RESIDUAL_RMS_M, residual.rms_m);
        let mut unmeasured = String::new();
        match ask(&kernel.device, &constants, &inputs)? {
            Ok(answers) => {
                let answers = answers.values.iter().map(|[x, y, z, _]| [*x, *y, *z]);
                let device = errors_of(&seen, answers);
                device.put(&mut row, NON_FINITE_DEVICE, [DEVICE_MAX_M, DEVICE_RMS_M]);
                row.put(MAX_PX, row.figure(DEVICE_MAX_M).map(|m| m / pixel_m));
                row.put(RMS_PX, row.figure(DEVICE_RMS_M).map(|m| m / pixel_m));
            }
            Err(why) => unmeasured = why,
        }
        judge(&mut row, 1.0);
        let ratio = row.figure(MEASURED_OVER_EXPECTED);
        if ratio.is_some_and(|ratio| ratio < 1.0 / AGREEMENT) {
            row.residual_reason = sight.why_less_than_expected(route).to_owned();
        }
        let is_more = ratio.is_some_and(|ratio| ratio > AGREEMENT);
        let rms_m = row.figure(DEVICE_RMS_M);
        if is_more && rounds_products(route, sight, &constants, &seen, rms_m) {
            row.residual_reason =
                "the device rounds a fused product and sum twice, as WGSL lets it: \
                                   emulated so, the error is the same"
                    .to_owned();
        }
        if !unmeasured.is_empty() {
            (row.status, row.reason) = (Status::Skipped, unmeasured);
        }
        rows.push(row);
    }
    Ok(rows)
}
