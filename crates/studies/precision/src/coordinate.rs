// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes over a region.

use crate::error::{AngleErrors, AngleFigures, judge};
use crate::kernel::{CoordinateKernel, Kernels, ask};
use crate::place::Place;
use crate::routes::family;
use crate::row::{PrecisionPart, PrecisionRow};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use terrafill_results::Status;
use terrafill_study::StudyError;
use terrafill_texture::{
    Arithmetic, CoordinateRoute, CostTable, Operations, Program, Residual, ResidualSum, Sample,
};

/// Places at which residuals are computed: as many as `CoordinateRoute::residual` takes, found once for
/// all routes of a region.
const RESIDUAL_PLACES: u32 = 4096;

/// What a region's rows need of a route on the CPU.
struct OnCpu {
    constants: Vec<[f32; 4]>,
    residual: Residual,
    errors: AngleErrors,
}

/// Rows of every route in a region; `chosen` is the one that a frame plan takes there.
pub(crate) fn rows(
    place: &Place,
    chosen: Option<CoordinateRoute>,
    points: u32,
    kernels: &Kernels,
) -> Result<Vec<PrecisionRow>, StudyError> {
    let samples = place.points(points);
    let residual_samples: Vec<Sample> = place.region.samples(RESIDUAL_PLACES).collect();
    let on_cpu: Vec<OnCpu> = kernels
        .coordinate
        .par_iter()
        .map(|kernel| on_cpu(kernel, place, &samples, &residual_samples))
        .collect();
    let inputs: Vec<[f32; 4]> = samples.iter().map(input).collect();
    let mut rows = Vec::new();
    for (kernel, cpu) in kernels.coordinate.iter().zip(&on_cpu) {
        let mut row = blank_row(kernel);
        put_place(&mut row, place);
        row.points = u32::try_from(samples.len()).unwrap_or(u32::MAX);
        row.texture_px = Some(place.texture_px());
        row.pixel_m = Some(place.pixel_m());
        row.chosen = chosen == Some(kernel.route);
        put_cpu(&mut row, cpu);
        match ask(&kernel.device, &cpu.constants, &inputs)? {
            Ok(answers) => put_device(&mut row, place, &samples, &answers.values),
            Err(why) => row.reason = why,
        }
        let unmeasured = std::mem::take(&mut row.reason);
        let exact = cpu.residual.approximation_max_rad / cpu.residual.expected_max_rad;
        judge(&mut row, 1.0 - exact);
        if !unmeasured.is_empty() {
            (row.status, row.reason) = (Status::Skipped, unmeasured);
        }
        rows.push(row);
    }
    Ok(rows)
}

/// A route's row in a region before anything is measured.
pub(crate) fn identity(place: &Place, route: &CoordinateRoute) -> PrecisionRow {
    let mut row = of_route(route);
    put_place(&mut row, place);
    row
}

fn put_place(row: &mut PrecisionRow, place: &Place) {
    row.condition = place.name();
    row.extent_deg = Some(place.extent_deg);
    row.latitude_deg = Some(place.latitude_deg);
    row.lowest_m = Some(place.heights.1);
    row.highest_m = Some(place.heights.2);
}

/// What names a route's row whatever the condition.
pub(crate) fn of_route(route: &CoordinateRoute) -> PrecisionRow {
    let (family, knob) = family(route);
    PrecisionRow {
        part: PrecisionPart::Coordinate,
        route: route.name(),
        family,
        knob,
        ..PrecisionRow::default()
    }
}

/// The same with what its program counts.
pub(crate) fn blank_row(kernel: &CoordinateKernel) -> PrecisionRow {
    let mut row = of_route(&kernel.route);
    put_operations(&mut row, &kernel.program.operations());
    row
}

/// Counts of operations, and what the chooser makes of them.
pub(crate) fn put_operations(row: &mut PrecisionRow, operations: &Operations) {
    row.add_mul_fma = Some(operations.add_mul_fma);
    row.divisions = Some(operations.divisions);
    row.compares_selects = Some(operations.compares_selects);
    row.sqrt = Some(operations.sqrt);
    row.transcendental = Some(operations.transcendental);
    row.texture_fetches = Some(operations.texture_fetches);
    row.operations_cost = Some(CostTable::default().cost(operations));
}

fn input(sample: &Sample) -> [f32; 4] {
    let [x, y, z] = sample.offset_m;
    [x, y, z, 0.0]
}

fn on_cpu(
    kernel: &CoordinateKernel,
    place: &Place,
    samples: &[Sample],
    residual_samples: &[Sample],
) -> OnCpu {
    let constants = kernel.route.constants(&place.region);
    let residual_by = |program: &Program| {
        let mut sum = ResidualSum::default();
        for sample in residual_samples {
            sum.add(sample, program.bounded(&constants, sample.offset_m));
        }
        sum.raise_to_peak(&place.region, |sample| {
            program.bounded(&constants, sample.offset_m)
        });
        sum.finish()
    };
    let mut residual = residual_by(&kernel.program);
    if let Some(sampler) = kernel.sampler {
        // The bound holds on all devices; what is expected is expected of this one's sampler.
        let here = residual_by(&kernel.program.on_sampler(sampler));
        residual.expected_max_rad = here.expected_max_rad;
        residual.rms_rad = here.rms_rad;
        residual.approximation_max_rad = here.approximation_max_rad;
    }
    let answers = samples.iter().map(|sample| {
        let offset = sample.offset_m;
        kernel
            .program
            .emulate(&constants, offset, Arithmetic::Fused)
    });
    OnCpu {
        errors: errors_of(place, samples, answers),
        residual,
        constants,
    }
}

fn errors_of(
    place: &Place,
    samples: &[Sample],
    answers: impl Iterator<Item = [f32; 2]>,
) -> AngleErrors {
    let texel_rad = place.demand().texel_rad();
    let anchor = place.region.anchor_latitude_rad();
    let mut errors = AngleErrors::default();
    for (sample, answer) in samples.iter().zip(answers) {
        let latitude = anchor + sample.angles_rad[1];
        let is_polar = FRAC_PI_2 - latitude.abs() < texel_rad[1];
        errors.add(answer, sample, texel_rad, is_polar);
    }
    errors
}

fn put_cpu(row: &mut PrecisionRow, cpu: &OnCpu) {
    row.non_finite_emulated = Some(cpu.errors.non_finite);
    let figures = cpu.errors.figures();
    row.emulated_max_m = figures.map(|f| f.max_m);
    row.emulated_rms_m = figures.map(|f| f.rms_m);
    row.residual_max_m = Some(cpu.residual.max_m);
    row.residual_max_rad = Some(cpu.residual.max_rad);
    row.residual_rms_rad = Some(cpu.residual.rms_rad);
    row.expected_max_rad = Some(cpu.residual.expected_max_rad);
}

fn put_device(row: &mut PrecisionRow, place: &Place, samples: &[Sample], values: &[[f32; 4]]) {
    let answers = values.iter().map(|value| [value[0], value[1]]);
    let errors = errors_of(place, samples, answers);
    row.non_finite_device = Some(errors.non_finite);
    let figures: Option<AngleFigures> = errors.figures();
    row.device_max_m = figures.map(|f| f.max_m);
    row.device_rms_m = figures.map(|f| f.rms_m);
    row.device_max_rad = figures.map(|f| f.max_rad);
    row.device_rms_rad = figures.map(|f| f.rms_rad);
    row.max_texels = figures.map(|f| f.max_texels);
    row.rms_texels = figures.map(|f| f.rms_texels);
    row.max_px = figures.map(|f| f.max_m / place.pixel_m());
    row.rms_px = figures.map(|f| f.rms_m / place.pixel_m());
}
