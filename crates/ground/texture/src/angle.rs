// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arctangents of a fragment: the device's own, a table, polynomials and rationals.
//!
//! A core knows `atan` on [0, 1] (odd ones on [−1, 1]); `full`, `right_half` and `near` add as much
//! of the range reduction by octants as their arguments need: `t = min / max`, then `π/2 − r` above the
//! diagonal, `π − r` left of the axis, the sign last. `max(…, 2⁻¹⁰⁰)` keeps 0 / 0 away, and (0, 0)
//! gives 0 in the place of what a driver's `atan2` makes of it.

use crate::angle_core::AngleCore;
use crate::coefficients::Coefficients;
use crate::lookup::Filter;
use crate::operations::{ProgramBuilder, Step, Value};
use terrafill_core::nearest_f32;

/// Of [`AngleCore::CesiumCubic`], ascending: the minimax cubic of its shape to four decimals, which a
/// test finds again. Not the generator's, whose coefficients are not rounded.
const CESIUM_CUBIC: [f64; 3] = [1.0301, -0.1784, -0.0663];

/// Its largest error, at 0.3 and 0.8, radians.
const CESIUM_CUBIC_ERROR: f64 = 1.508_2e-3;

/// Smallest divisor of the range reduction: a normal number far below any length in metres.
pub(crate) const TINY: f32 = 7.888_609e-31; // 2⁻¹⁰⁰

impl AngleCore {
    /// `atan2(y, x)` for any signs.
    pub(crate) fn full(self, b: &mut ProgramBuilder, y: Value, x: Value) -> Value {
        if self == Self::Native {
            return b.push(Step::Arctangent2 { y, x });
        }
        let right = self.above_axis(b, y, x);
        let pi = b.literal(std::f32::consts::PI);
        let zero = b.literal(0.0);
        let left = b.subtract(pi, right);
        let magnitude = b.select_less(x, zero, left, right);
        signed(b, y, magnitude)
    }

    /// `atan2(y, x)` for `x ≥ 0`.
    pub(crate) fn right_half(self, b: &mut ProgramBuilder, y: Value, x: Value) -> Value {
        if self == Self::Native {
            return b.push(Step::Arctangent2 { y, x });
        }
        let magnitude = self.above_axis(b, y, x);
        signed(b, y, magnitude)
    }

    /// `atan(y / x)` for `|y| ≤ x`, no octants.
    pub(crate) fn near(self, b: &mut ProgramBuilder, y: Value, x: Value) -> Value {
        let t = b.divide(y, x);
        match self {
            Self::Native => b.push(Step::Arctangent(t)),
            Self::Odd { .. } | Self::Rational { .. } => self.on_unit(b, t),
            Self::Dense { .. } | Self::CesiumCubic | Self::Lookup { .. } => {
                let size = b.absolute(t);
                let magnitude = self.on_unit(b, size);
                signed(b, t, magnitude)
            }
        }
    }

    /// The angle of `(|x|, |y|)`, 0 … π/2.
    fn above_axis(self, b: &mut ProgramBuilder, y: Value, x: Value) -> Value {
        let (size_x, size_y) = (b.absolute(x), b.absolute(y));
        let longer = b.maximum(size_x, size_y);
        let shorter = b.minimum(size_x, size_y);
        let tiny = b.literal(TINY);
        let divisor = b.maximum(longer, tiny);
        let t = b.divide(shorter, divisor);
        let low = self.on_unit(b, t);
        let quarter = b.literal(std::f32::consts::FRAC_PI_2);
        let high = b.subtract(quarter, low);
        b.select_less(size_x, size_y, high, low)
    }

    /// `atan(t)` for t in [0, 1].
    fn on_unit(self, b: &mut ProgramBuilder, t: Value) -> Value {
        match self {
            Self::Native => b.push(Step::Arctangent(t)),
            Self::Lookup { texels, filter, .. } => {
                let fraction = read_table(b, t, f32::from(texels), filter);
                let scale = b.literal(std::f32::consts::FRAC_PI_4);
                b.multiply(fraction, scale)
            }
            Self::Odd { .. } | Self::Dense { .. } | Self::CesiumCubic | Self::Rational { .. } => {
                let (numerator, denominator) = self.coefficients_f32();
                let variable = match self {
                    Self::Dense { .. } | Self::CesiumCubic => t,
                    _ => b.multiply(t, t),
                };
                let top = b.polynomial(variable, &numerator);
                let product = b.multiply(t, top);
                if denominator.is_empty() {
                    return product;
                }
                let bottom = b.polynomial(variable, &denominator);
                b.divide(product, bottom)
            }
        }
    }

    /// Numerator and denominator as the shader has them; empty where there are none.
    fn coefficients_f32(self) -> (Vec<f32>, Vec<f32>) {
        let to_f32 = |list: &[f64]| list.iter().map(|c| nearest_f32(*c)).collect();
        let (numerator, denominator) = self.coefficients().unwrap_or((&[], &[]));
        (to_f32(numerator), to_f32(denominator))
    }

    /// Coefficients of numerator and denominator, ascending; `None` where a core has none.
    #[must_use]
    pub fn coefficients(self) -> Option<(&'static [f64], &'static [f64])> {
        if self == Self::CesiumCubic {
            return Some((&CESIUM_CUBIC, &[]));
        }
        Coefficients::of(self).map(|row| (&row.numerator[..], &row.denominator[..]))
    }

    /// Largest error of the core on [0, 1] in exact arithmetic, by its formula; `None` for the
    /// device's own, whose only promise is WGSL's 4096 ULP.
    ///
    /// - polynomials and rationals: the generator's levelled error; relative where the weight is
    /// - tables: half a texel; or `h² / 8` times the largest `|atan″| = 3√3 / 8`, half a step of
    ///   the sampler's weights, and the format's rounding
    #[must_use]
    pub fn theory_error(self) -> Option<f64> {
        if let Self::Lookup {
            texels,
            format,
            filter,
        } = self
        {
            let step = 1.0 / (f64::from(texels) - 1.0);
            let bend = 3.0 * 3.0_f64.sqrt() / 8.0 * step * step / 8.0;
            let between = match filter {
                Filter::Nearest => 0.5 * step,
                Filter::Linear => bend + step / 512.0,
                Filter::LinearExact => bend,
            };
            return Some(between + format.rounding() * std::f64::consts::FRAC_PI_4);
        }
        if self == Self::CesiumCubic {
            return Some(CESIUM_CUBIC_ERROR);
        }
        Coefficients::of(self).map(|row| row.error)
    }
}

/// `magnitude` with the sign of `like`; −0 counts as positive, as WGSL allows.
fn signed(b: &mut ProgramBuilder, like: Value, magnitude: Value) -> Value {
    let zero = b.literal(0.0);
    let negative = b.negate(magnitude);
    b.select_less(like, zero, negative, magnitude)
}

/// What the table of `texels` entries holds at t.
fn read_table(b: &mut ProgramBuilder, t: Value, texels: f32, filter: Filter) -> Value {
    let last = texels - 1.0;
    match filter {
        Filter::Nearest => {
            let (scale, half) = (b.literal(last), b.literal(0.5));
            let middle = b.fma(t, scale, half);
            let index = b.floor(middle);
            b.push(Step::LoadTexel(index))
        }
        Filter::Linear => {
            // Texel centres lie at (i + ½) / N.
            let (scale, half) = (b.literal(last / texels), b.literal(0.5 / texels));
            let coordinate = b.fma(t, scale, half);
            b.push(Step::SampleTable(coordinate))
        }
        Filter::LinearExact => {
            let scale = b.literal(last);
            let place = b.multiply(t, scale);
            let whole = b.floor(place);
            let last_left = b.literal(last - 1.0);
            let left = b.minimum(whole, last_left);
            let weight = b.subtract(place, left);
            let one = b.literal(1.0);
            let right = b.add(left, one);
            let (from, to) = (
                b.push(Step::LoadTexel(left)),
                b.push(Step::LoadTexel(right)),
            );
            let rise = b.subtract(to, from);
            b.fma(weight, rise, from)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lookup::TexelFormat;
    use crate::operations::{Arithmetic, Program};
    use crate::residual::short_way;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn core(name: &str) -> AngleCore {
        let all = AngleCore::all();
        let found = all.into_iter().find(|core| core.name() == name);
        found.unwrap_or_else(|| panic!("{name}: no such core"))
    }

    /// `atan2(d.y, d.x)` by the three ways of range reduction.
    fn program(
        core: AngleCore,
        way: fn(AngleCore, &mut ProgramBuilder, Value, Value) -> Value,
    ) -> Program {
        let mut b = core
            .table()
            .map_or_else(ProgramBuilder::new, ProgramBuilder::with_table);
        let [x, y, z] = b.offset();
        let angle = way(core, &mut b, y, x);
        b.finish(angle, z)
    }

    /// Largest error of `atan2` in `f32` over the circle, against `f64`, both ways of rounding `fma`.
    fn worst_over_circle(program: &Program, directions: u32, half: bool) -> f64 {
        let mut worst = 0.0_f64;
        let turn = if half {
            std::f64::consts::PI
        } else {
            std::f64::consts::TAU
        };
        for i in 0..directions {
            let angle = turn * ((f64::from(i) + 0.5) / f64::from(directions) - 0.5);
            // Lengths over a factor of two, so that mantissas differ.
            let length = 4e6 * (1.0 + f64::from(i % 977) / 977.0);
            let (y, x) = (
                nearest_f32(length * angle.sin()),
                nearest_f32(length * angle.cos()),
            );
            for arithmetic in [Arithmetic::Fused, Arithmetic::Separate] {
                let [found, _] = program.emulate(&[], [x, y, 0.0], arithmetic);
                let exact = f64::from(y).atan2(f64::from(x));
                worst = worst.max(short_way(f64::from(found) - exact));
            }
        }
        worst
    }

    /// Largest error over the circle as another implementation measured it, radians.
    const MEASURED: [(&str, f64); 10] = [
        ("odd-3", 4.95e-3),
        ("odd-5", 6.09e-4),
        ("odd-7", 8.16e-5),
        ("odd-9", 1.17e-5),
        ("odd-11", 1.91e-6),
        ("odd-13", 5.12e-7),
        ("odd-15", 2.93e-7),
        ("rat-1-1", 9.85e-5),
        ("rat-1-2", 4.64e-6),
        ("rat-2-2", 5.13e-7),
    ];

    #[test]
    fn errors_over_the_circle_are_those_of_another_implementation() {
        let found = MEASURED.map(|(name, expected)| {
            let program = program(core(name), AngleCore::full);
            (name, worst_over_circle(&program, 400_000, false), expected)
        });
        for (name, worst, expected) in found {
            assert!(
                (worst / expected - 1.0).abs() < 0.1,
                "{name}: {worst:e} {expected:e}"
            );
        }
    }

    /// Largest error of a core on [0, 1] in `f32`.
    fn worst_on_unit(core: AngleCore, places: u32) -> f64 {
        let program = program(core, AngleCore::near);
        let at = |i: u32| {
            let t = nearest_f32(f64::from(i) / f64::from(places));
            let [found, _] = program.emulate(&[], [1.0, t, 0.0], Arithmetic::Fused);
            (f64::from(found) - f64::from(t).atan()).abs()
        };
        (0..=places).map(at).fold(0.0, f64::max)
    }

    /// Largest error on [0, 1] as another implementation measured it, radians: entries, nearest, two
    /// loads, sampler on R32F, sampler on `R16Unorm`.
    const TABLES_MEASURED: [(u16, [f64; 4]); 4] = [
        (16, [3.3e-2, 3.6e-4, 4.6e-4, 4.6e-4]),
        (256, [2.0e-3, 1.3e-6, 8.1e-6, 1.3e-5]),
        (1024, [4.9e-4, 9.9e-8, 1.9e-6, 7.8e-6]),
        (4096, [1.2e-4, 2.7e-8, 4.8e-7, 6.4e-6]),
    ];

    #[test]
    fn errors_of_tables_are_those_of_another_implementation() {
        for (texels, expected) in TABLES_MEASURED {
            let columns = [
                (TexelFormat::R32Float, Filter::Nearest),
                (TexelFormat::R32Float, Filter::LinearExact),
                (TexelFormat::R32Float, Filter::Linear),
                (TexelFormat::R16Unorm, Filter::Linear),
            ];
            for ((format, filter), expected) in columns.into_iter().zip(expected) {
                let core = AngleCore::Lookup {
                    texels,
                    format,
                    filter,
                };
                let worst = worst_on_unit(core, 200_000);
                // The published figures have two digits and leave out the interpolation's own
                // rounding in f32, up to 1.1e-7.
                let within = 0.9 * expected..1.05 * expected + 1.1e-7;
                let name = core.name();
                assert!(within.contains(&worst), "{name}: {worst:e} {expected:e}");
            }
        }
    }

    /// What `f32` adds to a core on [0, 1]: a division, the last product or difference, each half a
    /// unit in the last place of up to π/4, and as much again along the way.
    const ROUNDING_ON_UNIT: f64 = 2e-7;

    /// Whether an error is what the formula says: no larger, and no bound is idle.
    fn as_formula(worst: f64, theory: f64) -> bool {
        (0.7 * theory..=theory + ROUNDING_ON_UNIT).contains(&worst)
    }

    /// What the errors of a core are relative to.
    fn is_relative(core: AngleCore) -> bool {
        core.name().contains("-rel-")
    }

    #[test]
    fn every_core_errs_as_its_formula_says() {
        let mut checked = 0;
        for core in AngleCore::all() {
            let Some(theory) = core.theory_error() else {
                continue;
            };
            // A relative error is largest at 1 as well, where the angle is π/4.
            let scale = if is_relative(core) { FRAC_PI_4 } else { 1.0 };
            let worst = worst_on_unit(core, 20_000);
            assert!(
                as_formula(worst, theory * scale),
                "{}: {worst:e} {theory:e}",
                core.name()
            );
            checked += 1;
        }
        assert_eq!(
            checked,
            AngleCore::all().len() - 1,
            "all but the native one"
        );
    }

    /// Largest error on [0, 1] of `t · P(t²)`.
    fn worst_of_odd(coefficients: &[f32]) -> f64 {
        let mut b = ProgramBuilder::new();
        let [t, _, z] = b.offset();
        let square = b.multiply(t, t);
        let sum = b.polynomial(square, coefficients);
        let angle = b.multiply(t, sum);
        let program = b.finish(angle, z);
        let at = |i: u32| {
            let t = nearest_f32(f64::from(i) / 20_000.0);
            let [found, _] = program.emulate(&[], [t, 0.0, 0.0], Arithmetic::Fused);
            (f64::from(found) - f64::from(t).atan()).abs()
        };
        (0..=20_000).map(at).fold(0.0, f64::max)
    }

    #[test]
    fn a_mutant_coefficient_is_noticed() {
        let core = core("odd-7");
        let theory = core.theory_error().expect("in the table");
        let (right, _) = core.coefficients_f32();
        assert!(as_formula(worst_of_odd(&right), theory));
        for place in 0..right.len() {
            for factor in [0.999, 1.001] {
                let mut mutant = right.clone();
                mutant[place] *= factor;
                assert!(
                    !as_formula(worst_of_odd(&mutant), theory),
                    "{place} {factor}"
                );
            }
        }
        let mut swapped = right;
        swapped.swap(2, 3);
        assert!(!as_formula(worst_of_odd(&swapped), theory));
    }

    /// Extrema in (0, 1) of the error of `t (c₀ + c₁ t + c₂ t²)`, in order.
    fn extrema_of_cubic([c0, c1, c2]: [f64; 3]) -> Vec<f64> {
        let error = |i: i32| {
            let t = f64::from(i) / 5000.0;
            t * (c0 + t * (c1 + t * c2)) - t.atan()
        };
        let is_extremum = |i: &i32| (error(*i) - error(i - 1)) * (error(i + 1) - error(*i)) <= 0.0;
        (1..5000).filter(is_extremum).map(error).collect()
    }

    /// Whether no cubic of the shape, π/4 at 1 and two coefficients free, is better but for the
    /// rounding to four decimals: three extrema of alternating signs and equal size (Chebyshev).
    fn is_minimax(coefficients: [f64; 3]) -> bool {
        let extrema = extrema_of_cubic(coefficients);
        let equal = |pair: &[f64]| (pair[0] / pair[1] + 1.0).abs() < 0.02;
        let ends_at_the_octant = (coefficients.iter().sum::<f64>() - FRAC_PI_4).abs() < 1e-5;
        extrema.len() == 3 && extrema.windows(2).all(equal) && ends_at_the_octant
    }

    #[test]
    fn the_web_globes_cubic_is_the_minimax_one_of_its_shape_to_four_decimals() {
        assert!(
            is_minimax(CESIUM_CUBIC),
            "{:?}",
            extrema_of_cubic(CESIUM_CUBIC)
        );
        // 1.51e-3 rad were measured of it elsewhere.
        let worst = worst_on_unit(AngleCore::CesiumCubic, 20_000);
        assert!((worst - CESIUM_CUBIC_ERROR).abs() < 1e-6, "{worst:e}");
        // Negative controls: a coefficient moved in its third decimal, with and without the end kept.
        let [c0, c1, c2] = CESIUM_CUBIC;
        for mutant in [
            [c0 + 1e-3, c1, c2],
            [c0 + 1e-3, c1 - 1e-3, c2],
            [c0, c1 + 1e-3, c2 - 1e-3],
        ] {
            assert!(!is_minimax(mutant), "{mutant:?}");
        }
    }

    #[test]
    fn half_bits_are_those_of_the_standard() {
        // Published bit patterns of IEEE 754 binary16.
        let known = [
            (0.0, 0x0000),
            (2.0_f64.powi(-24), 0x0001),
            (1023.0 * 2.0_f64.powi(-24), 0x03ff),
            (2.0_f64.powi(-14), 0x0400),
            (1.0 / 3.0, 0x3555),
            (0.5, 0x3800),
            (2047.0 / 2048.0, 0x3bff),
            (1.0, 0x3c00),
        ];
        for (number, bits) in known {
            assert_eq!(TexelFormat::R16Float.bits_of(number), bits, "{number}");
        }
        // Ties go to even, and a carry goes into the exponent.
        assert_eq!(
            TexelFormat::R16Float.bits_of(1.0 - 2.0_f64.powi(-12)),
            0x3c00
        );
        assert_eq!(
            TexelFormat::R16Float.bits_of(0.5 + 2.0_f64.powi(-12)),
            0x3800
        );
    }

    /// Jump of the texture where |y| and |x| change places, metres on Earth.
    fn seam_m(name: &str) -> f64 {
        let program = program(core(name), AngleCore::full);
        let at = |y: f32| program.emulate(&[], [1.0, y, 0.0], Arithmetic::Fused)[0];
        (f64::from(at(1.0_f32.next_up())) - f64::from(at(1.0))).abs() * 6_378_137.0
    }

    #[test]
    fn octants_meet_where_they_are_pinned() {
        // Twice the error elsewhere: 1.04 km and 21 m.
        assert!((seam_m("odd-7") - 1038.0).abs() < 2.0);
        assert!((seam_m("odd-11") - 21.2).abs() < 1.0);
        for name in [
            "odd-pin-5",
            "odd-pin-7",
            "odd-pin-9",
            "odd-pin-11",
            "odd-pin-13",
            "odd-pin-15",
        ] {
            let found = seam_m(name);
            // One unit in the last place of π/4 is 0.38 m; two roundings meet.
            assert!(found < 1.6, "{name}: {found}");
        }
    }

    #[test]
    fn operations_are_those_of_the_formulas() {
        // Core alone: fma and products, divisions. Reduction of a full circle: a division, two
        // magnitudes and a negation, π/2 − r and π − r, min, max, the guard, three selects.
        for (name, add_mul_fma, divisions) in [
            ("odd-3", 1 + 2, 0),
            ("odd-7", 3 + 2, 0),
            ("odd-15", 7 + 2, 0),
            ("dense-5", 4 + 1, 0),
            ("rat-1-1", 2 + 2, 1),
            ("rat-2-2", 4 + 2, 1),
        ] {
            let full = program(core(name), AngleCore::full).operations();
            assert_eq!(full.add_mul_fma, add_mul_fma + 2, "{name}");
            assert_eq!(full.divisions, divisions + 1, "{name}");
            assert_eq!(full.compares_selects, 9, "{name}");
            assert_eq!(full.sign_changes, 3, "{name}");
            assert_eq!(
                full.transcendental + full.texture_fetches + full.sqrt,
                0,
                "{name}"
            );
        }
        let near = program(core("odd-7"), AngleCore::near).operations();
        assert_eq!(
            (near.add_mul_fma, near.divisions, near.compares_selects),
            (5, 1, 0)
        );
        let native = program(AngleCore::Native, AngleCore::full).operations();
        assert_eq!((native.transcendental, native.divisions), (1, 0));
        let fetches = |name| {
            program(core(name), AngleCore::full)
                .operations()
                .texture_fetches
        };
        let found = [
            "lut-256-r16-nearest",
            "lut-256-r16-linear",
            "lut-256-r16-linear-exact",
        ]
        .map(fetches);
        assert_eq!(found, [1, 1, 2]);
    }

    /// What `atan2(y, x)` must give at places where an unguarded one goes wrong.
    const SPECIAL: [(f32, f32, f64); 20] = [
        (0.0, 0.0, 0.0),
        // The sign of zero may be ignored in WGSL: −0 counts as 0 everywhere.
        (-0.0, 0.0, 0.0),
        (0.0, -0.0, 0.0),
        (-0.0, -0.0, 0.0),
        (0.0, 1.0, 0.0),
        (-0.0, 1.0, 0.0),
        (0.0, -1.0, PI),
        (-0.0, -1.0, PI),
        (1.0, 0.0, FRAC_PI_2),
        (-1.0, -0.0, -FRAC_PI_2),
        // Subnormals: the divisor is held at 2⁻¹⁰⁰, so they are as good as 0, or π where x is below.
        (1e-40, 0.0, FRAC_PI_2),
        (0.0, 1e-40, 0.0),
        (1e-40, -1e-40, PI),
        (1e-40, 1.0, 0.0),
        (1e-40, -1.0, PI),
        // One infinity.
        (f32::INFINITY, 1.0, FRAC_PI_2),
        (f32::NEG_INFINITY, 1.0, -FRAC_PI_2),
        (1.0, f32::INFINITY, 0.0),
        (1.0, f32::NEG_INFINITY, PI),
        (1e38, 1e38, FRAC_PI_4),
    ];

    #[test]
    fn special_values_are_finite_and_what_they_should_be() {
        for core in AngleCore::all() {
            let Some(theory) = core.theory_error() else {
                continue;
            };
            let program = program(core, AngleCore::full);
            let allowed = 2.0 * theory.max(3e-7);
            for (y, x, expected) in SPECIAL {
                let [found, _] = program.emulate(&[], [x, y, 0.0], Arithmetic::Fused);
                let error = (f64::from(found) - expected).abs();
                // Two subnormals of one size: only that the answer is finite and to the left.
                let coarse = y.is_subnormal() && x.is_subnormal();
                let allowed = if coarse { 1.0 } else { allowed };
                assert!(error < allowed, "{} ({y:e}, {x:e}): {found}", core.name());
            }
            // The inputs with no finite answer, for cores that calculate: two infinities. The larger
            // of NaN and a number is the number here, and a device may do otherwise.
            let infinity = f32::INFINITY;
            let [both, _] = program.emulate(&[], [infinity, infinity, 0.0], Arithmetic::Fused);
            assert!(both.is_nan(), "{}", core.name());
            let [nan, _] = program.emulate(&[], [f32::NAN, f32::NAN, 0.0], Arithmetic::Fused);
            assert!(nan.is_nan() || nan.abs() < 1.6, "{}", core.name());
        }
    }

    #[test]
    fn without_the_guard_the_origin_has_no_angle() {
        // Negative control of the special values: the same steps without `max(…, 2⁻¹⁰⁰)`.
        let mut b = ProgramBuilder::new();
        let [x, y, z] = b.offset();
        let (longer, shorter) = (b.maximum(x, y), b.minimum(x, y));
        let t = b.divide(shorter, longer);
        let program = b.finish(t, z);
        let [found, _] = program.emulate(&[], [0.0; 3], Arithmetic::Fused);
        assert!(found.is_nan());
    }

    #[test]
    fn names_are_different_and_of_the_documented_form() {
        let names: Vec<String> = AngleCore::all().into_iter().map(AngleCore::name).collect();
        let different: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(different.len(), names.len());
        for name in [
            "atan2-native",
            "odd-11",
            "odd-pin-7",
            "odd-rel-9",
            "rat-2-2",
            "dense-5",
            "cubic-cesium",
            "lut-256-r16-linear",
            "lut-4096-r8-nearest",
            "lut-16-r16f-linear-exact",
        ] {
            assert!(names.iter().any(|n| n == name), "{name}");
        }
    }
}
