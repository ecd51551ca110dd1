// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a route is from the exact map over a region: computed, never a constant.
//!
//! Two parts. What the formula itself leaves out: the route's steps in `f64`, from the very `f32`
//! constants and coefficients that the shader gets, against the exact map, by dense sampling. And
//! what `f32` adds: the running error bound of the same steps at the same places.

use crate::operations::{Bounded, Program};
use crate::region::{MapRegion, Sample};
use std::f64::consts::{PI, TAU};

/// Places at which a residual is computed, besides corners, edges and middle.
pub(crate) const RESIDUAL_SAMPLES: u32 = 4096;

/// How many standard deviations the largest of some thousand errors is expected to be: a single even
/// rounding has no error beyond √3 of them, a sum of many reaches 3.7.
const EXPECTED_DEVIATIONS: f64 = 2.5;

/// Error of a route over a region.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// Largest error of longitude or latitude on any device that conforms to WGSL, radians: the
    /// approximation's and the bound of the arithmetic's.
    pub max_rad: f64,
    /// The same on a device that rounds every step correctly, as it is to be expected: 2.5 standard
    /// deviations of independent roundings in the bound's place, radians.
    pub expected_max_rad: f64,
    /// Root mean square of the errors of longitude and latitude, the larger of the two, radians, on
    /// such a device.
    pub rms_rad: f64,
    /// Largest distance on the body's surface, metres.
    pub max_m: f64,
    /// Largest error of longitude and of latitude, radians.
    pub max_axis_rad: [f64; 2],
    /// Root mean square error of longitude and of latitude, radians.
    pub rms_axis_rad: [f64; 2],
    /// The part of `max_rad` that exact arithmetic would leave, radians.
    pub approximation_max_rad: f64,
    /// The largest bound of what `f32` adds, radians.
    pub arithmetic_max_rad: f64,
    /// Samples at which the route has no finite answer or no finite bound.
    pub non_finite: u32,
    /// Samples in all.
    pub samples: u32,
}

/// Adds up errors sample by sample.
#[derive(Debug, Clone, Default)]
pub struct ResidualSum {
    residual: Residual,
    squares: [f64; 2],
}

impl ResidualSum {
    /// Takes one place: the route's answer there in exact arithmetic, with its rounding bound. On the
    /// axis only the latitude counts.
    pub fn add(&mut self, sample: &Sample, answer: [Bounded; 2]) {
        let r = &mut self.residual;
        r.samples += 1;
        let counted = &answer[usize::from(sample.on_axis)..];
        let infinite = |number: f64| !number.is_finite();
        if answer.iter().any(|a| infinite(a.value)) || counted.iter().any(|a| infinite(a.bound)) {
            r.non_finite += 1;
            return;
        }
        let mut square_m = 0.0;
        for (axis, found) in answer.iter().enumerate().skip(usize::from(sample.on_axis)) {
            let difference = found.value - sample.angles_rad[axis];
            let difference = if axis == 0 {
                short_way(difference)
            } else {
                difference.abs()
            };
            let error = difference + found.bound;
            r.max_axis_rad[axis] = r.max_axis_rad[axis].max(error);
            r.approximation_max_rad = r.approximation_max_rad.max(difference);
            let deviations = EXPECTED_DEVIATIONS * found.variance.sqrt();
            let expected = difference + deviations.min(found.bound);
            r.expected_max_rad = r.expected_max_rad.max(expected);
            r.arithmetic_max_rad = r.arithmetic_max_rad.max(found.bound);
            self.squares[axis] += difference * difference + found.variance;
            square_m += (error * sample.metres_per_radian[axis]).powi(2);
        }
        r.max_m = r.max_m.max(square_m.sqrt());
    }

    /// The residual of all that was taken. With a non-finite sample every maximum is infinite.
    #[must_use]
    pub fn finish(self) -> Residual {
        let mut r = self.residual;
        let finite = f64::from(r.samples - r.non_finite).max(1.0);
        r.rms_axis_rad = self.squares.map(|sum| (sum / finite).sqrt());
        if r.non_finite > 0 || r.samples == 0 {
            r.max_axis_rad = [f64::INFINITY; 2];
            r.rms_axis_rad = [f64::INFINITY; 2];
            r.max_m = f64::INFINITY;
            r.expected_max_rad = f64::INFINITY;
        }
        r.max_rad = r.max_axis_rad[0].max(r.max_axis_rad[1]);
        r.rms_rad = r.rms_axis_rad[0].max(r.rms_axis_rad[1]);
        r
    }
}

/// Residual of `program` over `region`.
#[must_use]
pub(crate) fn residual_of(
    program: &Program,
    constants: &[[f32; 4]],
    region: &MapRegion,
    count: u32,
) -> Residual {
    let mut sum = ResidualSum::default();
    for sample in region.samples(count) {
        sum.add(&sample, program.bounded(constants, sample.offset_m));
    }
    sum.finish()
}

/// Magnitude of a difference of longitudes where one may be π and the other −π for the same place.
pub(crate) fn short_way(difference: f64) -> f64 {
    let magnitude = difference.abs();
    if magnitude > PI {
        (TAU - magnitude).abs()
    } else {
        magnitude
    }
}
