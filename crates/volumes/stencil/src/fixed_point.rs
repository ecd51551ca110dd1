// SPDX-License-Identifier: MIT OR Apache-2.0
//! Positions as three i32 per vertex, and the eye in the same units.
//!
//! Unit = the power of two at or above extent / 2³⁰, so a coordinate needs 31 bits and the sign: 8 mm for
//! a region as large as Russia, 10⁻⁸ m for a square of 10 m. The eye is subtracted in integers, so
//! neighbouring vertices keep their exact difference however far from the body's centre they lie.

use glam::{DVec3, IVec3, Vec3};
use terrafill_core::RegionMesh;

/// How a position is stored. All but the first are variants to be measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PositionFormat {
    /// Three i32 in the region's units: 12 bytes.
    #[default]
    Fixed,
    /// Three f32 metres from the region's origin: 12 bytes.
    LocalF32,
    /// Three f32 metres from the body's centre: 12 bytes, the naive way. On the Earth both position
    /// and eye are off by up to 0.25 m along each axis.
    EcefF32,
    /// The same and three more f32 for what they rounded away: 24 bytes.
    TwoFloat,
}

impl PositionFormat {
    /// Every format.
    pub const ALL: [Self; 4] = [Self::Fixed, Self::LocalF32, Self::EcefF32, Self::TwoFloat];

    /// Name in variants and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::LocalF32 => "local-f32",
            Self::EcefF32 => "ecef-f32",
            Self::TwoFloat => "two-float",
        }
    }

    /// Words of 4 bytes that a position takes.
    #[must_use]
    pub fn words(self) -> usize {
        match self {
            Self::Fixed | Self::LocalF32 | Self::EcefF32 => 3,
            Self::TwoFloat => 6,
        }
    }
}

/// An `f64` vector as the `f32` nearest to it and the `f32` nearest to what is left: 48 bits.
#[must_use]
pub fn two_float(value: DVec3) -> [Vec3; 2] {
    let high = value.as_vec3();
    [high, (value - high.as_dvec3()).as_vec3()]
}

/// Twin of `two_float_difference_m` in `shaders/shared/region.wgsl`, and as that in `f32`: parts of
/// like size are subtracted first. The difference of the high parts is exact where they are within
/// a factor of two of each other (Sterbenz, 1974), and the low parts then put back what was
/// rounded away; summed up the other way round, they would be lost before anything is subtracted.
#[must_use]
pub fn two_float_difference_m([high, low]: [Vec3; 2], [eye_high, eye_low]: [Vec3; 2]) -> Vec3 {
    (high - eye_high) + (low - eye_low)
}

/// A region's origin and unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedPoint {
    /// ECEF metres.
    pub origin_ecef: DVec3,
    /// Metres; a power of two.
    pub unit_m: f64,
}

/// The eye as a region's shader constants hold it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeInUnits {
    /// In units of `unit · 2^shift` from the origin, rounded down.
    pub eye: IVec3,
    /// Bits dropped from stored positions.
    pub shift: u32,
    /// What rounding down left, metres.
    pub remainder_m: DVec3,
}

/// Stored coordinates reach 2³⁰ and, rounded, one more.
const LARGEST_COORDINATE: f64 = (1_u32 << 30) as f64;

/// The eye stays a little below, so that no difference leaves 32 bits.
const LARGEST_EYE: f64 = LARGEST_COORDINATE - 4.0;

impl FixedPoint {
    /// Origin at the middle of the vertices' bounds, rounded to whole units; unit from the longest half axis.
    #[must_use]
    pub fn for_mesh(mesh: &RegionMesh) -> Self {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for vertex in &mesh.vertices_ecef {
            low = low.min(*vertex);
            high = high.max(*vertex);
        }
        let half = ((high - low) * 0.5).max_element();
        let extent = if half.is_finite() && half > 0.0 {
            half
        } else {
            1.0
        };
        let unit_m = (extent / LARGEST_COORDINATE).log2().ceil().exp2();
        let middle = if half.is_finite() {
            (low + high) * 0.5
        } else {
            DVec3::ZERO
        };
        Self {
            origin_ecef: (middle / unit_m).round() * unit_m,
            unit_m,
        }
    }

    /// A position in units from the origin, rounded to nearest.
    #[must_use]
    pub fn quantize(&self, ecef: DVec3) -> IVec3 {
        ((ecef - self.origin_ecef) / self.unit_m).round().as_ivec3()
    }

    /// The eye with the smallest shift that makes it fit.
    #[must_use]
    pub fn eye(&self, eye_ecef: DVec3) -> EyeInUnits {
        let in_units = (eye_ecef - self.origin_ecef) / self.unit_m;
        let mut shift = 0;
        let mut scaled = in_units;
        while scaled.abs().max_element() >= LARGEST_EYE && shift < 31 {
            scaled *= 0.5;
            shift += 1;
        }
        let whole = scaled.floor();
        Self::checked_eye(whole, scaled - whole, shift, self.unit_m)
    }

    fn checked_eye(whole: DVec3, fraction: DVec3, shift: u32, unit_m: f64) -> EyeInUnits {
        EyeInUnits {
            // Saturates for an eye 2³¹ extents away, from where the region is far below a pixel.
            eye: whole
                .clamp(DVec3::splat(-LARGEST_EYE), DVec3::splat(LARGEST_EYE))
                .as_ivec3(),
            shift,
            remainder_m: fraction * unit_m * f64::from(shift).exp2(),
        }
    }
}

/// Twin of `eye_relative_m` in `shaders/shared/region.wgsl` for height 0: integers exact, the rest
/// in f64.
#[must_use]
pub fn eye_relative_m(stored: IVec3, eye: &EyeInUnits, unit_m: f64) -> DVec3 {
    let difference = (stored >> eye.shift) - eye.eye;
    difference.as_dvec3() * unit_m * f64::from(eye.shift).exp2() - eye.remainder_m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fixed(unit_exponent: i32) -> FixedPoint {
        FixedPoint {
            origin_ecef: DVec3::new(4_000_000.0, 3_000_000.0, 3_900_000.0),
            unit_m: f64::from(unit_exponent).exp2(),
        }
    }

    #[test]
    fn an_eye_anywhere_is_subtracted_to_a_billionth_of_its_distance() {
        for (exponent, extent) in [(-27, 8.0), (-10, 1e6), (-7, 5e6)] {
            let fixed = fixed(exponent);
            for distance in [0.5, 50.0, 1e4, 1e6, 3e7] {
                let eye_ecef = fixed.origin_ecef + DVec3::new(0.3, -0.6, 0.74) * distance;
                let eye = fixed.eye(eye_ecef);
                for corner in [DVec3::splat(0.9), DVec3::new(-0.7, 0.2, 0.99)] {
                    let ecef = fixed.origin_ecef + corner * extent;
                    let stored = fixed.quantize(ecef);
                    let got = eye_relative_m(stored, &eye, fixed.unit_m);
                    let error = (got - (ecef - eye_ecef)).abs().max_element();
                    let allowed = fixed.unit_m + distance.max(extent) * 2e-9;
                    assert!(
                        error <= allowed,
                        "2^{exponent} at {distance}: {error} > {allowed}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_farthest_corner_and_the_farthest_eye_do_not_overflow() {
        let fixed = fixed(-27);
        let corner = IVec3::splat((1 << 30) + 1);
        for sign in [-1.0, 1.0] {
            let nearly = fixed.unit_m * (LARGEST_EYE - 1.0) * sign;
            let eye = fixed.eye(fixed.origin_ecef + DVec3::splat(nearly));
            assert_eq!(eye.shift, 0);
            for stored in [corner, -corner] {
                let difference = i64::from(stored.x) - i64::from(eye.eye.x);
                assert!(i32::try_from(difference).is_ok(), "{difference}");
            }
        }
    }

    #[test]
    fn close_up_nothing_is_dropped() {
        let fixed = fixed(-27);
        assert_eq!(fixed.eye(fixed.origin_ecef + DVec3::X * 7.0).shift, 0);
        assert!(fixed.eye(fixed.origin_ecef + DVec3::X * 70.0).shift > 0);
    }

    #[test]
    fn a_wrong_shift_is_noticed() {
        let fixed = fixed(-10);
        let eye_ecef = fixed.origin_ecef + DVec3::splat(3e6);
        let mut eye = fixed.eye(eye_ecef);
        assert!(eye.shift > 0);
        let stored = fixed.quantize(fixed.origin_ecef + DVec3::splat(1e5));
        let right = eye_relative_m(stored, &eye, fixed.unit_m);
        eye.shift += 1;
        let wrong = eye_relative_m(stored, &eye, fixed.unit_m);
        assert!((right - wrong).length() > 1e5);
    }

    #[test]
    fn two_floats_keep_what_one_loses_and_only_in_the_right_order() {
        let eye = DVec3::new(4_120_345.678_9, 731_234.567_8, 4_801_234.543_2);
        let offset = DVec3::new(3.276_543_211, -2.612_345_678, 1.398_765_432);
        let [vertex_parts, eye_parts] = [two_float(eye + offset), two_float(eye)];
        let error = |found: Vec3| (found.as_dvec3() - offset).abs().max_element();
        let right = error(two_float_difference_m(vertex_parts, eye_parts));
        assert!(right < 1e-6, "{right}");
        // Negative controls: one float alone, and the sums first.
        let [high, low] = vertex_parts;
        let [eye_high, eye_low] = eye_parts;
        assert!(error(high - eye_high) > 0.01);
        assert!(error((high + low) - (eye_high + eye_low)) > 0.01);
    }

    #[test]
    fn formats_have_names_of_their_own() {
        let names = PositionFormat::ALL.map(PositionFormat::name);
        for (i, name) in names.iter().enumerate() {
            assert!(!names[..i].contains(name), "{name}");
        }
        assert_eq!(PositionFormat::ALL.map(PositionFormat::words), [3, 3, 3, 6]);
    }
}
