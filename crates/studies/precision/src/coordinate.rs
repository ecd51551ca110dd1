// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes over a region.

use crate::error::{AngleErrors, judge};
use crate::kernel::{CoordinateKernel, Kernels, ask};
use crate::metrics::*;
use crate::place::RegionPicture;
use crate::routes::family;
use crate::row::{PrecisionPart, PrecisionRow};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use terrafill_results::Status;
use terrafill_study::StudyError;
use terrafill_texture::{
    Arithmetic, CoordinateRoute, Operations, Program, Residual, ResidualSum, Sample,
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
    place: &RegionPicture,
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
        let mut row = identity(place, &kernel.route);
        put_operations(&mut row, &kernel.program.operations());
        row.put(POINTS, samples.len() as f64);
        row.put(TEXTURE_PX, f64::from(place.texture_px()));
        let is_chosen = chosen == Some(kernel.route);
        row.put(CHOSEN, f64::from(u8::from(is_chosen)));
        put_cpu(&mut row, cpu);
        let device = ask(&kernel.device, &cpu.constants, &inputs)?;
        if let Ok(answers) = &device {
            put_device(&mut row, place, &samples, &answers.values);
        }
        row.put_pixels(place.pixel_m(), [DEVICE_MAX_M, DEVICE_RMS_M]);
        let exact = cpu.residual.approximation_max_rad / cpu.residual.expected_max_rad;
        judge(&mut row, 1.0 - exact);
        if let Err(why) = device {
            (row.status, row.reason) = (Status::Skipped, why);
        }
        rows.push(row);
    }
    Ok(rows)
}

/// A route's row in a region before anything is measured.
pub(crate) fn identity(place: &RegionPicture, route: &CoordinateRoute) -> PrecisionRow {
    PrecisionRow {
        extent_deg: Some(place.extent_deg),
        latitude_deg: Some(place.latitude_deg),
        heights_m: Some([place.heights.1, place.heights.2]),
        ..of_route(PrecisionPart::Coordinate, route, place.name())
    }
}

/// A route's row before its region is known.
pub(crate) fn of_route(
    part: PrecisionPart,
    route: &CoordinateRoute,
    condition: String,
) -> PrecisionRow {
    let (family, knob) = family(route);
    PrecisionRow {
        family,
        knob,
        ..PrecisionRow::new(part, &route.name(), condition)
    }
}

/// Counts of operations, and what the chooser makes of them.
pub(crate) fn put_operations(row: &mut PrecisionRow, operations: &Operations) {
    for (metric, count) in [
        (ADD_MUL_FMA, operations.add_mul_fma),
        (DIVISIONS, operations.divisions),
        (COMPARES_SELECTS, operations.compares_selects),
        (SQRT, operations.sqrt),
        (TRANSCENDENTAL, operations.transcendental),
        (TEXTURE_FETCHES, operations.texture_fetches),
    ] {
        row.put(metric, f64::from(count));
    }
    row.put(OPERATIONS_COST, operations.cost());
}

fn input(sample: &Sample) -> [f32; 4] {
    let [x, y, z] = sample.offset_m;
    [x, y, z, 0.0]
}

fn on_cpu(
    kernel: &CoordinateKernel,
    place: &RegionPicture,
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
    place: &RegionPicture,
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
    let emulated = &cpu.errors.ground;
    emulated.put(row, NON_FINITE_EMULATED, [EMULATED_MAX_M, EMULATED_RMS_M]);
    row.put(RESIDUAL_MAX_M, cpu.residual.max_m);
    row.put(RESIDUAL_MAX_RAD, cpu.residual.max_rad);
    row.put(RESIDUAL_RMS_RAD, cpu.residual.rms_rad);
    row.put(EXPECTED_MAX_RAD, cpu.residual.expected_max_rad);
}

fn put_device(
    row: &mut PrecisionRow,
    place: &RegionPicture,
    samples: &[Sample],
    values: &[[f32; 4]],
) {
    let answers = values.iter().map(|value| [value[0], value[1]]);
    let errors = errors_of(place, samples, answers);
    let ground = [DEVICE_MAX_M, DEVICE_RMS_M];
    errors.ground.put(row, NON_FINITE_DEVICE, ground);
    row.put_both([DEVICE_MAX_RAD, DEVICE_RMS_RAD], errors.rad());
    row.put_both([MAX_TEXELS, RMS_TEXELS], errors.texels());
}
