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

/// Error of a route over a region.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// Largest error of longitude or latitude, radians: approximation and arithmetic bound.
    pub max_rad: f64,
    /// Root mean square of the errors of longitude and latitude, the larger of the two, radians.
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
    /// Takes one place: the route's answer there in exact arithmetic, with its rounding bound.
    pub fn add(&mut self, sample: &Sample, answer: [Bounded; 2]) {
        let r = &mut self.residual;
        r.samples += 1;
        if answer.iter().any(|a| !(a.value + a.bound).is_finite()) {
            r.non_finite += 1;
            return;
        }
        let mut square_m = 0.0;
        for axis in 0..2 {
            let difference = answer[axis].value - sample.angles_rad[axis];
            let difference = if axis == 0 {
                short_way(difference)
            } else {
                difference.abs()
            };
            let error = difference + answer[axis].bound;
            r.max_axis_rad[axis] = r.max_axis_rad[axis].max(error);
            r.approximation_max_rad = r.approximation_max_rad.max(difference);
            r.arithmetic_max_rad = r.arithmetic_max_rad.max(answer[axis].bound);
            self.squares[axis] += difference * difference + answer[axis].variance;
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
