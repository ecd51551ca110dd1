// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arctangents of a fragment: the device's own, a table, polynomials and rationals.
//!
//! A core knows `atan` on [0, 1] (odd ones on [−1, 1]); `full`, `right_half` and `near` add as much
//! of the range reduction by octants as their arguments need: `t = min / max`, then `π/2 − r` above the
//! diagonal, `π − r` left of the axis, the sign last. `max(…, 2⁻¹⁰⁰)` keeps 0 / 0 away, and (0, 0)
//! gives 0 in the place of what a driver's `atan2` makes of it.

use crate::coefficients::COEFFICIENTS;
use crate::lookup::{Filter, LookupTable, TexelFormat};
use crate::operations::{ProgramBuilder, Step, Value, rounded};

/// What error a family's coefficients make smallest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// The absolute error.
    Absolute,
    /// The error relative to the angle.
    Relative,
    /// The absolute error with slope 1 at 0 and π/4 at 1 kept, so that octants meet.
    Pinned,
}

/// How the arctangent of a ratio is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleCore {
    /// The device's own `atan2`, whatever that is.
    Native,
    /// A table.
    Lookup {
        /// Entries.
        texels: u16,
        /// How they are stored.
        format: TexelFormat,
        /// How they are read.
        filter: Filter,
    },
    /// `x P(x²)`.
    Odd {
        /// Highest power of x: 3, 5, … 15.
        degree: u8,
        /// What its coefficients make smallest.
        weight: Weight,
    },
    /// `x P(x)` on [0, 1].
    Dense {
        /// Highest power of x: 2 … 8.
        degree: u8,
    },
    /// `x P(x²) / Q(x²)`.
    Rational {
        /// Degree of P.
        numerator: u8,
        /// Degree of Q.
        denominator: u8,
        /// What its coefficients make smallest.
        weight: Weight,
    },
}

impl AngleCore {
    /// Stable name: `atan2-native`, `lut-256-r16-linear`, `odd-7`, `odd-pin-7`, `dense-5`,
    /// `rat-2-2`, `rat-rel-2-2`.
    #[must_use]
    pub fn name(self) -> String {
        let infix = |weight| match weight {
            Weight::Absolute => "",
            Weight::Relative => "rel-",
            Weight::Pinned => "pin-",
        };
        match self {
            Self::Native => "atan2-native".to_owned(),
            Self::Lookup {
                texels,
                format,
                filter,
            } => format!("lut-{texels}-{}-{}", format.name(), filter.name()),
            Self::Odd { degree, weight } => format!("odd-{}{degree}", infix(weight)),
            Self::Dense { degree } => format!("dense-{degree}"),
            Self::Rational {
                numerator,
                denominator,
                weight,
            } => format!("rat-{}{numerator}-{denominator}", infix(weight)),
        }
    }

    /// Every core: what [`Self::name`] may say.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::Native];
        let weights = [Weight::Absolute, Weight::Relative, Weight::Pinned];
        for degree in (3..=15).step_by(2) {
            for weight in weights {
                // One coefficient is left over after pinning from degree 5 on.
                if degree > 3 || weight != Weight::Pinned {
                    all.push(Self::Odd { degree, weight });
                }
            }
        }
        all.extend((2..=8).map(|degree| Self::Dense { degree }));
        for (numerator, denominator) in [(0, 1), (1, 1), (1, 2), (2, 2), (2, 3), (3, 3)] {
            all.extend(
                [Weight::Absolute, Weight::Relative].map(|weight| Self::Rational {
                    numerator,
                    denominator,
                    weight,
                }),
            );
        }
        for power in 4..=12 {
            for format in TexelFormat::ALL {
                all.extend(Filter::ALL.map(|filter| Self::Lookup {
                    texels: 1 << power,
                    format,
                    filter,
                }));
            }
        }
        all
    }

    /// The table it reads, if it reads one.
    #[must_use]
    pub fn table(self) -> Option<LookupTable> {
        match self {
            Self::Lookup {
                texels,
                format,
                filter,
            } => Some(LookupTable::arctangent(texels, format, filter)),
            _ => None,
        }
    }
}

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
            Self::Dense { .. } | Self::Lookup { .. } => {
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
            Self::Odd { .. } | Self::Dense { .. } | Self::Rational { .. } => {
                let (numerator, denominator) = self.coefficients_f32();
                let variable = match self {
                    Self::Dense { .. } => t,
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
        let to_f32 = |list: &[f64]| list.iter().map(|c| rounded(*c)).collect();
        let (numerator, denominator) = self.coefficients().unwrap_or((&[], &[]));
        (to_f32(numerator), to_f32(denominator))
    }

    /// Coefficients of numerator and denominator, ascending; `None` where a core has none.
    #[must_use]
    pub fn coefficients(self) -> Option<(&'static [f64], &'static [f64])> {
        let found = COEFFICIENTS.iter().find(|row| row.core == self);
        found.map(|row| (row.numerator, row.denominator))
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
        let found = COEFFICIENTS.iter().find(|row| row.core == self);
        found.map(|row| row.error)
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
    use crate::operations::{Arithmetic, Program};
    use crate::residual::short_way;

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
            let (y, x) = (rounded(length * angle.sin()), rounded(length * angle.cos()));
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
}
