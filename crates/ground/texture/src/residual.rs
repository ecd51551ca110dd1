// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a route is from the exact map over a region: computed, never a constant.
//!
//! Two parts. What the formula itself leaves out: the route's steps in `f64`, from the very `f32`
//! constants and coefficients that the shader gets, against the exact map, by dense sampling. And
//! what `f32` adds: the running error bound of the same steps at the same places.

use crate::operations::Program;
use crate::region::{MapRegion, Sample};
use crate::rounding::Bounded;
use std::f64::consts::{PI, TAU};

/// What the suite may measure beyond a residual: a residual is the largest error of some thousand
/// samples, and the largest of all places is up to this much larger.
pub const SAMPLING_SLACK: f64 = 1.02;

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
    /// Root mean square distance on the body's surface, metres, on a device that rounds every step
    /// correctly.
    pub rms_m: f64,
    /// Largest error of longitude and of latitude, radians.
    pub max_axis_rad: [f64; 2],
    /// Root mean square error of longitude and of latitude, radians.
    pub rms_axis_rad: [f64; 2],
    /// The part of `max_rad` that exact arithmetic would leave, radians.
    pub approximation_max_rad: f64,
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
    squares_m: f64,
    /// Where longitude, latitude and both together are farthest off on the ground, and by how much.
    worst: [Option<(f64, Sample)>; 3],
}

/// Reaches to both sides of a place, as shares of the extent, within which [`ResidualSum::raise_to_peak`]
/// looks for a worse one: from a lobe of a coarse polynomial to the distance of the samples.
const PEAK_REACHES: [f64; 3] = [1.0 / 32.0, 1.0 / 256.0, 1.0 / 2048.0];

/// Steps to each side.
const PEAK_STEPS: i32 = 8;

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
        let mut off_m = [0.0; 2];
        for (axis, found) in answer.iter().enumerate().skip(usize::from(sample.on_axis)) {
            let difference = difference(sample, axis, found.value);
            let error = difference + found.bound;
            r.max_axis_rad[axis] = r.max_axis_rad[axis].max(error);
            r.approximation_max_rad = r.approximation_max_rad.max(difference);
            let deviations = EXPECTED_DEVIATIONS * found.variance.sqrt();
            let expected = difference + deviations.min(found.bound);
            r.expected_max_rad = r.expected_max_rad.max(expected);
            let square = difference * difference + found.variance;
            self.squares[axis] += square;
            self.squares_m += square * sample.metres_per_radian[axis].powi(2);
            off_m[axis] = error * sample.metres_per_radian[axis];
        }
        let both_m = off_m[0].hypot(off_m[1]);
        r.max_m = r.max_m.max(both_m);
        for (worst, off_m) in self.worst.iter_mut().zip([off_m[0], off_m[1], both_m]) {
            if worst.is_none_or(|(most, _)| off_m > most) {
                *worst = Some((off_m, *sample));
            }
        }
    }

    /// Raises the largest distance on the ground to its peak between the samples.
    ///
    /// A longitude is farthest off at some longitudes, a latitude at some latitudes, and few samples have
    /// both: each of two errors misses little of its own peak, and their sum misses as much of both. So
    /// the longitude where the one peaks and the latitude where the other does are tried together, and
    /// from there the worst place along one axis after the other.
    ///
    /// - `answer`: the route's, in exact arithmetic, with its rounding bound
    pub fn raise_to_peak(&mut self, region: &MapRegion, answer: impl Fn(&Sample) -> [Bounded; 2]) {
        let [Some(longitude), Some(latitude), Some(both)] = self
            .worst
            .map(|worst| worst.map(|(_, sample)| region.shares_of(&sample)))
        else {
            return;
        };
        let off_m = |place: [f64; 3]| {
            let sample = region.sample_at(place);
            off_m(&sample, answer(&sample))
        };
        let [u, _, _] = longitude;
        for mut place in [
            both,
            [u, latitude[1], latitude[2]],
            [u, both[1], both[2]],
            [u, longitude[1], longitude[2]],
        ] {
            let mut most = off_m(place);
            for reach in PEAK_REACHES {
                for axis in 0..2 {
                    let middle = place[axis];
                    for step in -PEAK_STEPS..=PEAK_STEPS {
                        let mut tried = place;
                        let share = middle + reach * f64::from(step) / f64::from(PEAK_STEPS);
                        tried[axis] = share.clamp(0.0, 1.0);
                        let found = off_m(tried);
                        if found > most {
                            (most, place) = (found, tried);
                        }
                    }
                }
            }
            for w in [0.0, 1.0] {
                most = most.max(off_m([place[0], place[1], w]));
            }
            self.residual.max_m = self.residual.max_m.max(most);
        }
    }

    /// The residual of all that was taken. With a non-finite sample every maximum is infinite.
    #[must_use]
    pub fn finish(self) -> Residual {
        let mut r = self.residual;
        let finite = f64::from(r.samples - r.non_finite).max(1.0);
        r.rms_axis_rad = self.squares.map(|sum| (sum / finite).sqrt());
        r.rms_m = (self.squares_m / finite).sqrt();
        if r.non_finite > 0 || r.samples == 0 {
            r.rms_m = f64::INFINITY;
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
    sum.raise_to_peak(region, |sample| program.bounded(constants, sample.offset_m));
    sum.finish()
}

/// How far off an answer is on the ground with all that rounding may add, metres; nothing where it has
/// no finite bound, which the samples count.
fn off_m(sample: &Sample, answer: [Bounded; 2]) -> f64 {
    let mut off_m = [0.0; 2];
    for (axis, found) in answer.iter().enumerate().skip(usize::from(sample.on_axis)) {
        let error = difference(sample, axis, found.value) + found.bound;
        off_m[axis] = error * sample.metres_per_radian[axis];
    }
    let both_m = off_m[0].hypot(off_m[1]);
    if both_m.is_finite() { both_m } else { 0.0 }
}

/// Magnitude of an angle's error, radians.
fn difference(sample: &Sample, axis: usize, value: f64) -> f64 {
    let difference = value - sample.angles_rad[axis];
    if axis == 0 {
        short_way(difference)
    } else {
        difference.abs()
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Arithmetic, CoordinateRoute, MapExtent};
    use terrafill_core::Ellipsoid;

    /// Largest distance on the ground that emulation finds on a grid of its own.
    fn measured_m(route: CoordinateRoute, region: &MapRegion) -> f64 {
        const STEPS: u32 = 300;
        let (program, constants) = (route.program(), route.constants(region));
        let at = |i: u32| (f64::from(i) + 0.41) / f64::from(STEPS);
        let places = (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| [at(i), at(j), 0.0]));
        places
            .map(|place| {
                let sample = region.sample_at(place);
                let found = program.emulate(&constants, sample.offset_m, Arithmetic::Fused);
                let exact = found.map(|angle| Bounded::exact(f64::from(angle)));
                off_m(&sample, exact)
            })
            .fold(0.0, f64::max)
    }

    /// By the samples alone.
    fn sampled_m(route: CoordinateRoute, region: &MapRegion) -> f64 {
        let (program, constants) = (route.program(), route.constants(region));
        let mut sum = ResidualSum::default();
        for sample in region.samples(RESIDUAL_SAMPLES) {
            sum.add(&sample, program.bounded(&constants, sample.offset_m));
        }
        sum.finish().max_m
    }

    #[test]
    fn two_errors_that_peak_together_stay_below_the_bound() {
        let cap = |south: f64| MapExtent::from_degrees(-160.0, south, 200.0, 90.0);
        let globe = MapExtent::from_degrees(-160.0, -90.0, 200.0, 90.0);
        let mut missed = 0;
        for (name, extent) in [
            ("odd-rel-7+bowring-1", cap(85.0)),
            ("rat-rel-0-1+bowring-1", cap(45.0)),
            ("odd-rel-7+bowring-1", globe),
            ("odd-7+bowring-1", globe),
        ] {
            let route = CoordinateRoute::parse(name).expect("a route");
            let region = MapRegion::anchored(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("bounds");
            let (measured, residual) = (measured_m(route, &region), route.residual(&region));
            assert!(
                measured <= residual.max_m,
                "{name}: {measured} {residual:?}"
            );
            // No bound is so wide that it says nothing.
            assert!(
                measured > 0.9 * residual.max_m,
                "{name}: {measured} {residual:?}"
            );
            missed += u32::from(measured > crate::SAMPLING_SLACK * sampled_m(route, &region));
        }
        // Negative control: by the samples alone the peak is missed.
        assert!(missed >= 2, "{missed}");
    }

    #[test]
    fn a_place_is_found_back_from_its_sample() {
        let extent = MapExtent::from_degrees(150.0, -40.0, 230.0, 10.0);
        let region = MapRegion::new(Ellipsoid::WGS84, extent, (-500.0, 9_000.0)).expect("bounds");
        for place in [
            [0.0, 0.0, 0.0],
            [0.25, 0.9, 0.5],
            [1.0, 1.0, 1.0],
            [0.6, 0.1, 0.75],
        ] {
            let found = region.shares_of(&region.sample_at(place));
            let far = (0..3).any(|i| (found[i] - place[i]).abs() > 1e-4);
            assert!(!far, "{place:?} {found:?}");
        }
    }
}
