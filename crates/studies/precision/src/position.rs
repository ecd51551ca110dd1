// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes: from pixel and depth to the offset.

use crate::coordinate::put_operations;
use crate::error::{AGREEMENT, ErrorSum, judge};
use crate::kernel::{Kernels, PositionKernel, ask};
use crate::metrics::*;
use crate::place::halton;
use crate::row::{PrecisionPart, PrecisionRow};
use crate::sight::{CLEARED_PIXEL, DISTANCE_SPREAD, IMAGE, ProbeView};
use crate::special::put_answers;
use glam::{DVec2, DVec3};
use terrafill_results::Status;
use terrafill_study::StudyError;
use terrafill_texture::{Arithmetic, MapRegion, PerspectiveView, PositionRoute};

/// A pixel, its distance, its depth as read back, and where it is.
struct Seen {
    input: [f32; 4],
    exact_m: DVec3,
}

fn seen(view: &PerspectiveView, region: &MapRegion, distance_m: f64, count: u32) -> Vec<Seen> {
    let size = DVec2::from_array(IMAGE.map(f64::from));
    let seen = (1..=count).map(halton).map(|at| {
        let pixel = (at.truncate() * size).floor() + 0.5;
        let distance_m = distance_m * (1.0 + DISTANCE_SPREAD * (at.z - 0.5));
        let depth = view.depth.stored(distance_m);
        let [x, y] = pixel.as_vec2().to_array();
        Seen {
            input: [x, y, depth, 0.0],
            exact_m: view.exact_offset_m(region, pixel.to_array(), distance_m),
        }
    });
    seen.collect()
}

fn errors_of(seen: &[Seen], answers: impl Iterator<Item = [f32; 3]>) -> ErrorSum {
    let mut errors = ErrorSum::default();
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
    let mapping = sight.format.mapping();
    let kernels = kernels.position.iter();
    let kernels = kernels.filter(|kernel| kernel.mapping == mapping);
    let Some(distance_m) = sight.distance_m else {
        let rows = kernels.map(|kernel| cleared_row(sight, &view, &region, kernel));
        return rows.collect();
    };
    let seen = seen(&view, &region, distance_m, points);
    let row = |kernel| drawn_row(sight, &view, &region, distance_m, &seen, kernel);
    kernels.map(row).collect()
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

/// What a route makes of a pixel in which nothing was drawn. No fragment is there, so nothing is
/// wrong: the row says what would come of asking.
fn cleared_row(
    sight: &ProbeView,
    view: &PerspectiveView,
    region: &MapRegion,
    kernel: &PositionKernel,
) -> Result<PrecisionRow, StudyError> {
    let (route, depth) = (kernel.route, sight.cleared_depth());
    let constants = route.constants(view, region);
    let mut row = identity(sight, route);
    put_operations(&mut row, &route.operations(&sight.format));
    row.reason = "cleared depth: no fragment is there".to_owned();
    let emulated = route.emulate(&sight.format, &constants, CLEARED_PIXEL, depth);
    let [x, y] = CLEARED_PIXEL;
    let device = ask(&kernel.device, &constants, &[[x, y, depth, 0.0]])?;
    put_answers(&mut row, emulated, device, |answer| format!("{answer:?}"));
    Ok(row)
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

fn drawn_row(
    sight: &ProbeView,
    view: &PerspectiveView,
    region: &MapRegion,
    distance_m: f64,
    seen: &[Seen],
    kernel: &PositionKernel,
) -> Result<PrecisionRow, StudyError> {
    let route = kernel.route;
    let constants = route.constants(view, region);
    let residual = route.residual(view, region, distance_m);
    let emulated = seen.iter().map(|seen| {
        let [x, y, depth, _] = seen.input;
        route.emulate(&sight.format, &constants, [x, y], depth)
    });
    let emulated = errors_of(seen, emulated);
    let mut row = identity(sight, route);
    put_operations(&mut row, &route.operations(&sight.format));
    row.put(POINTS, seen.len() as f64);
    let of_emulated = [EMULATED_MAX_M, EMULATED_RMS_M];
    emulated.put(&mut row, NON_FINITE_EMULATED, of_emulated);
    row.put(RESIDUAL_MAX_M, residual.max_m);
    row.put(RESIDUAL_RMS_M, residual.rms_m);
    let inputs: Vec<[f32; 4]> = seen.iter().map(|seen| seen.input).collect();
    let device = ask(&kernel.device, &constants, &inputs)?;
    if let Ok(answers) = &device {
        let answers = answers.values.iter().map(|[x, y, z, _]| [*x, *y, *z]);
        let errors = errors_of(seen, answers);
        errors.put(&mut row, NON_FINITE_DEVICE, [DEVICE_MAX_M, DEVICE_RMS_M]);
    }
    row.put_pixels(view.pixel_size_m(distance_m), [DEVICE_MAX_M, DEVICE_RMS_M]);
    judge(&mut row, 1.0);
    let ratio = row.figure(MEASURED_OVER_EXPECTED);
    if ratio.is_some_and(|ratio| ratio < 1.0 / AGREEMENT) {
        row.residual_reason = sight.why_less_than_expected(route).to_owned();
    }
    let is_more = ratio.is_some_and(|ratio| ratio > AGREEMENT);
    let rms_m = row.figure(DEVICE_RMS_M);
    if is_more && rounds_products(route, sight, &constants, seen, rms_m) {
        row.residual_reason = "the device rounds a fused product and sum twice, as WGSL lets it: \
                               emulated so, the error is the same"
            .to_owned();
    }
    if let Err(why) = device {
        (row.status, row.reason) = (Status::Skipped, why);
    }
    Ok(row)
}
