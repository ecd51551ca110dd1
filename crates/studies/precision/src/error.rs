// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums of measured errors, and what is said where formula and measurement part.

use crate::metrics::*;
use crate::row::PrecisionRow;
use std::f64::consts::{PI, TAU};
use terrafill_results::{Metric, Status};
use terrafill_texture::{SAMPLING_SLACK, Sample};

/// Measured and computed error that differ by more need a reason.
pub(crate) const AGREEMENT: f64 = 2.0;

/// Errors over places, all of one unit.
#[derive(Debug, Clone, Default)]
pub(crate) struct ErrorSum {
    non_finite: u64,
    count: f64,
    max: f64,
    squares: f64,
}

impl ErrorSum {
    pub(crate) fn add(&mut self, error: f64) {
        if !error.is_finite() {
            self.non_finite += 1;
            return;
        }
        self.count += 1.0;
        self.max = self.max.max(error);
        self.squares += error * error;
    }

    /// Into a row: how many are not finite, and the others' largest and root mean square.
    pub(crate) fn put(
        &self,
        row: &mut PrecisionRow,
        non_finite: &'static Metric,
        max_and_rms: [&'static Metric; 2],
    ) {
        row.put(non_finite, self.non_finite as f64);
        row.put_both(max_and_rms, self.figures());
    }

    /// Largest and root mean square; `None` without a finite error.
    pub(crate) fn figures(&self) -> Option<[f64; 2]> {
        (self.count > 0.0).then(|| [self.max, (self.squares / self.count).sqrt()])
    }
}

/// Errors of angles over places.
#[derive(Debug, Clone, Default)]
pub(crate) struct AngleErrors {
    /// Metres. Answers that are not finite are counted here and nowhere else.
    pub(crate) ground: ErrorSum,
    /// Of longitude and latitude.
    rad: [ErrorSum; 2],
    texels: [ErrorSum; 2],
}

impl AngleErrors {
    /// Takes an answer at a place.
    ///
    /// - `texel_rad`: radians per texel along both axes
    /// - `is_polar`: nearer to a pole than a texel, where a row of texels is one place and its
    ///   longitude has no meaning
    pub(crate) fn add(
        &mut self,
        answer: [f32; 2],
        sample: &Sample,
        texel_rad: [f64; 2],
        is_polar: bool,
    ) {
        if answer.iter().any(|angle| !angle.is_finite()) {
            self.ground.non_finite += 1;
            return;
        }
        let [longitude, latitude] = answer.map(f64::from);
        let errors = [
            if sample.on_axis {
                0.0
            } else {
                short_way(longitude - sample.angles_rad[0])
            },
            (latitude - sample.angles_rad[1]).abs(),
        ];
        let metres = (errors[0] * sample.metres_per_radian[0])
            .hypot(errors[1] * sample.metres_per_radian[1]);
        self.ground.add(metres);
        for axis in 0..2 {
            self.rad[axis].add(errors[axis]);
            if !is_polar {
                self.texels[axis].add(errors[axis] / texel_rad[axis]);
            }
        }
    }

    /// Largest and root mean square in radians, of the axis that has the larger; `None` without a finite answer.
    pub(crate) fn rad(&self) -> Option<[f64; 2]> {
        larger(&self.rad)
    }

    /// The same in texels; 0 where every answer is polar.
    pub(crate) fn texels(&self) -> Option<[f64; 2]> {
        let is_answered = self.ground.figures().is_some();
        is_answered.then(|| larger(&self.texels).unwrap_or_default())
    }
}

fn larger(axes: &[ErrorSum; 2]) -> Option<[f64; 2]> {
    let (longitude, latitude) = (axes[0].figures()?, axes[1].figures()?);
    Some([0, 1].map(|figure: usize| longitude[figure].max(latitude[figure])))
}

/// Magnitude of a difference of longitudes, the short way round.
fn short_way(difference: f64) -> f64 {
    ((difference + PI).rem_euclid(TAU) - PI).abs()
}

/// From here on an error is as large as the body: half the Earth's circumference, metres.
const NO_MAP_M: f64 = 2e7;

/// Sets status, ratios and reasons of a row whose errors are in it.
///
/// - `rounding_share`: how much of the expected error is rounding
pub(crate) fn judge(row: &mut PrecisionRow, rounding_share: f64) {
    let over = |measured: &Metric, computed: &Metric| {
        let (measured, computed) = (row.figure(measured)?, row.figure(computed)?);
        (computed.is_finite() && computed > 0.0).then(|| measured / computed)
    };
    let max = over(DEVICE_MAX_M, RESIDUAL_MAX_M);
    let rms = match row.figure(RESIDUAL_RMS_RAD) {
        Some(_) => over(DEVICE_RMS_RAD, RESIDUAL_RMS_RAD),
        None => over(DEVICE_RMS_M, RESIDUAL_RMS_M),
    };
    let bound_m = row.figure(RESIDUAL_MAX_M);
    let is_map = bound_m.is_none_or(|bound| bound < NO_MAP_M);
    let of_expected = match row.figure(EXPECTED_MAX_RAD) {
        _ if !is_map => None,
        Some(_) => over(DEVICE_MAX_RAD, EXPECTED_MAX_RAD),
        None => rms,
    };
    row.put(MAX_OVER_RESIDUAL, max);
    row.put(RMS_OVER_RESIDUAL, rms);
    row.put(MEASURED_OVER_EXPECTED, of_expected);
    row.residual_reason = residual_reason(row, rounding_share);
    (row.status, row.reason) = if row.non_finite() > 0 {
        let [all, emulated, device] = [POINTS, NON_FINITE_EMULATED, NON_FINITE_DEVICE]
            .map(|metric| row.figure(metric).unwrap_or(0.0));
        let reason = format!("not finite: {emulated} of {all} emulated, {device} on the device");
        (Status::Wrong, reason)
    } else if !is_map {
        let reason = "no answer here: by its formula the error is as large as the body";
        (Status::Wrong, reason.to_owned())
    } else if max.is_some_and(|ratio| ratio > SAMPLING_SLACK) {
        (Status::Wrong, "the error is above its bound".to_owned())
    } else {
        (Status::Ok, String::new())
    };
}

pub(crate) fn agrees(ratio: f64) -> bool {
    (1.0 / AGREEMENT..=AGREEMENT).contains(&ratio)
}

fn residual_reason(row: &PrecisionRow, rounding_share: f64) -> String {
    let ratio = row.figure(MEASURED_OVER_EXPECTED);
    let Some(ratio) = ratio.filter(|ratio| !agrees(*ratio)) else {
        return String::new();
    };
    let calls = |metric| row.figure(metric).is_some_and(|count| count > 0.0);
    let is_exact = |metric| row.figure(metric) == Some(0.0);
    let reason = if calls(TRANSCENDENTAL) {
        "expected is a correctly rounded function; the device's own is another, within what WGSL grants"
    } else if row.figure(RMS_OVER_RESIDUAL).is_some_and(agrees) && ratio < 1.0 {
        "few of the measured places come near the largest error; root mean squares agree"
    } else if calls(TEXTURE_FETCHES) {
        "the sampler's own error: expected by the largest that it was seen to make, which other texels do not meet"
    } else if rounding_share > 0.5 && ratio < 1.0 {
        "rounding: steps that are exact here, such as products with 0, are taken for rounded ones"
    } else if is_exact(DEVICE_MAX_M) || is_exact(DEVICE_RMS_M) {
        "no error at all at the measured places"
    } else {
        "no reason known"
    };
    reason.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(angles_rad: [f64; 2]) -> Sample {
        Sample {
            offset_m: [0.0; 3],
            angles_rad,
            metres_per_radian: [3e6, 6e6],
            on_axis: false,
        }
    }

    #[test]
    fn errors_by_hand() {
        let mut errors = AngleErrors::default();
        errors.add([0.5, 0.25], &sample([0.5, 0.25]), [1e-3; 2], false);
        errors.add([0.5, 0.25], &sample([0.5, 0.25 - 1e-6]), [1e-3; 2], false);
        let [max_m, rms_m] = errors.ground.figures().expect("finite");
        assert!((max_m - 6.0).abs() < 1e-6);
        assert!((rms_m - 6.0 / 2.0_f64.sqrt()).abs() < 1e-6);
        assert!((errors.texels().expect("finite")[0] - 1e-3).abs() < 1e-9);
        // Negative control: longitude and latitude swapped are far off.
        let mut swapped = AngleErrors::default();
        swapped.add([0.25, 0.5], &sample([0.5, 0.25]), [1e-3; 2], false);
        assert!(swapped.ground.figures().expect("finite")[0] > 1e5);
    }

    #[test]
    fn the_antimeridian_is_one_place() {
        let mut errors = AngleErrors::default();
        let pi = std::f32::consts::PI;
        errors.add([-pi, 0.0], &sample([f64::from(pi), 0.0]), [1e-3; 2], false);
        assert!(errors.ground.figures().expect("finite")[0] < 1.0);
        // Negative control: the same in latitude is not.
        let mut wrong = AngleErrors::default();
        wrong.add([0.0, -pi], &sample([0.0, f64::from(pi)]), [1e-3; 2], false);
        assert!(wrong.ground.figures().expect("finite")[0] > 1e6);
    }

    #[test]
    fn what_is_not_finite_is_counted_and_hides_nothing() {
        let mut errors = AngleErrors::default();
        errors.add([f32::NAN, 0.0], &sample([0.0; 2]), [1e-3; 2], false);
        errors.add([0.0, f32::INFINITY], &sample([0.0; 2]), [1e-3; 2], false);
        assert_eq!(errors.ground.non_finite, 2);
        assert!(errors.ground.figures().is_none() && errors.texels().is_none());
        errors.add([1e-3, 0.0], &sample([0.0; 2]), [1e-3; 2], true);
        let [max_m, _] = errors.ground.figures().expect("one answer");
        assert!((max_m - 3000.0).abs() < 0.01, "metres count at a pole too");
        let texels = errors.texels().expect("one answer");
        assert_eq!(texels, [0.0; 2], "texels do not");
    }

    fn row(device: f64, bound: f64, non_finite: u64) -> PrecisionRow {
        let mut row = bare(device, bound);
        row.put(NON_FINITE_DEVICE, non_finite as f64);
        row.put(TRANSCENDENTAL, 2.0);
        judge(&mut row, 0.0);
        row
    }

    fn bare(device: f64, bound: f64) -> PrecisionRow {
        let mut row = PrecisionRow::default();
        row.put(DEVICE_MAX_M, device);
        row.put(RESIDUAL_MAX_M, bound);
        row.put(DEVICE_MAX_RAD, device);
        row.put(EXPECTED_MAX_RAD, 0.5);
        row
    }

    #[test]
    fn a_row_is_wrong_above_its_bound_and_says_why_far_from_what_was_expected() {
        let near = row(0.9, 1.0, 0);
        assert_eq!(
            (near.status, near.residual_reason.as_str()),
            (Status::Ok, "")
        );
        let below = row(0.1, 1.0, 0);
        assert_eq!(below.status, Status::Ok);
        assert!(below.residual_reason.contains("the device's own"));
        let above = row(1.1, 1.0, 0);
        assert_eq!(above.status, Status::Wrong);
        assert!(above.residual_reason.contains("the device's own"));
        assert_eq!(row(0.9, 1.0, 1).status, Status::Wrong, "NaN is no answer");
        let nowhere = row(3e7, 4e7, 0);
        assert_eq!(
            (nowhere.status, nowhere.figure(MEASURED_OVER_EXPECTED)),
            (Status::Wrong, None)
        );
        assert_eq!(row(0.9, f64::INFINITY, 0).status, Status::Wrong);
        // Negative control: without a call of the device's own there is no such excuse.
        let mut bare = bare(1.1, 2.0);
        judge(&mut bare, 0.0);
        assert_eq!(bare.residual_reason, "no reason known");
    }
}
