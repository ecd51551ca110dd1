// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rounding to `f32`, and values with a bound on the error that steps so rounded have made.

use terrafill_core::nearest_f32;

/// A value in exact arithmetic with what rounding may add to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// As `f64` has it, from the same `f32` constants and coefficients.
    pub value: f64,
    /// Bound of the difference between any conforming device and `value`, to first order.
    pub bound: f64,
    /// Variance of that difference on a device that rounds every step correctly, if the roundings are
    /// independent and even: what to expect, not what is certain.
    pub variance: f64,
}

impl Bounded {
    /// A value without an error.
    pub(crate) fn exact(value: f64) -> Self {
        Self {
            value,
            bound: 0.0,
            variance: 0.0,
        }
    }

    /// Another value with the same error.
    pub(crate) fn map(self, value: f64) -> Self {
        Self { value, ..self }
    }
}

/// A result whose error is its operands' by the given derivatives, and its own.
///
/// - `own_half_ulps`: what the step itself may add to the bound, in halves of a unit in the last
///   place; the variance is that of one correct rounding
pub(crate) fn combine(value: f64, terms: &[(Bounded, f64)], own_half_ulps: f64) -> Bounded {
    let mut result = Bounded {
        value,
        bound: 0.0,
        variance: 0.0,
    };
    for (operand, derivative) in terms {
        result.bound += operand.bound * derivative.abs();
        result.variance += operand.variance * derivative * derivative;
    }
    let half = half_ulp(value);
    result.bound += own_half_ulps * half;
    // Of an even distribution over ±half.
    result.variance += half * half / 3.0;
    result
}

/// A derivative that is infinite at a point where the operand is exact counts as none.
pub(crate) fn slope(derivative: f64) -> f64 {
    if derivative.is_finite() {
        derivative
    } else {
        0.0
    }
}

/// Half the distance between neighbouring `f32` around `value`.
pub(crate) fn half_ulp(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    // The exponent as f64 stores it, 1023 more than it is; 2⁻¹²⁶ is the smallest normal f32. Infinity
    // and NaN give something finite here and are not finite already.
    let stored = (value.to_bits() >> 52) & 0x7ff;
    let stored = stored.max(1023 - 126);
    f64::from_bits((stored - 24) << 52)
}

/// Numbers as a shader's constants have them: four to a vector, the last one filled with zeros.
pub(crate) fn vectors(numbers: &[f64]) -> Vec<[f32; 4]> {
    let vector = |four: &[f64]| {
        let lane = |i: usize| nearest_f32(four.get(i).copied().unwrap_or(0.0));
        std::array::from_fn(lane)
    };
    numbers.chunks(4).map(vector).collect()
}
