// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums of two `f64`, 32 digits: what the generator of coefficients calculates in.
//!
//! The coefficients of a rational minimax approximation move by 10⁷ times what its error moves, and
//! an error of 4e-10 is itself a difference of numbers near 1, so `f64` would leave seven digits.
//! Sources: Dekker (1971) for the splitting, Hida, Li and Bailey (2001) for the operations.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`, `|low|` at most half a unit in the last place of `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// 0
    pub(crate) const ZERO: Self = Self {
        high: 0.0,
        low: 0.0,
    };
    /// 1
    pub(crate) const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };

    /// The nearest `f64`.
    pub(crate) fn to_f64(self) -> f64 {
        self.high
    }

    /// Magnitude.
    pub(crate) fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Square root of a number that is not negative: one Newton step from that of `f64`.
    pub(crate) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        let root = Self::from(self.high.sqrt());
        root + (self - root * root) / (root + root)
    }

    /// Arctangent of a number in [0, 1].
    ///
    /// Six times the half angle, `atan x = 2 atan(x / (1 + √(1 + x²)))`, and the series at what is
    /// left, below 2⁻⁶: 12 terms leave (2⁻⁶)²⁴.
    pub(crate) fn arctangent(self) -> Self {
        const HALVINGS: i32 = 6;
        const TERMS: i32 = 12;
        let mut x = self;
        for _ in 0..HALVINGS {
            x = x / (Self::ONE + (Self::ONE + x * x).sqrt());
        }
        let square = x * x;
        let mut sum = Self::ZERO;
        for k in (0..TERMS).rev() {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            sum = sum * square + Self::from(sign) / Self::from(f64::from(2 * k + 1));
        }
        sum * x * Self::from(f64::from(1 << HALVINGS))
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

/// `a + b` and what its rounding lost, for any `a` and `b` (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// The same where `|a| ≥ |b|` (Dekker).
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    DoubleDouble {
        high,
        low: b - (high - a),
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, lost) = two_sum(self.high, other.high);
        let (low, lost_low) = two_sum(self.low, other.low);
        let first = quick_two_sum(high, lost + low);
        quick_two_sum(first.high, first.low + lost_low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.high * other.high;
        let lost = self.high.mul_add(other.high, -product);
        quick_two_sum(
            product,
            lost + (self.high * other.low + self.low * other.high),
        )
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        // Long division with three digits of 53 bits.
        let first = self.high / other.high;
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        let third = rest.high / other.high;
        quick_two_sum(first, second) + Self::from(third)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_and_a_root_are_exact_to_31_digits() {
        let third = DoubleDouble::ONE / DoubleDouble::from(3.0);
        let rest = third * DoubleDouble::from(3.0) - DoubleDouble::ONE;
        assert!(rest.to_f64().abs() < 1e-31, "{rest:?}");
        let two = DoubleDouble::from(2.0);
        let rest = two.sqrt() * two.sqrt() - two;
        assert!(rest.to_f64().abs() < 1e-31, "{rest:?}");
        // Negative control: a third of f64 alone leaves 1e-17.
        let plain = DoubleDouble::from(1.0 / 3.0) * DoubleDouble::from(3.0) - DoubleDouble::ONE;
        assert!(plain.to_f64().abs() > 1e-18, "{plain:?}");
    }

    #[test]
    fn the_arctangent_obeys_machins_formula() {
        // π/4 = 4 atan(1/5) − atan(1/239), and atan 1 by the same series from another argument.
        let atan_of = |n: f64| (DoubleDouble::ONE / DoubleDouble::from(n)).arctangent();
        let machin = DoubleDouble::from(4.0) * atan_of(5.0) - atan_of(239.0);
        let direct = DoubleDouble::ONE.arctangent();
        assert!((machin - direct).to_f64().abs() < 1e-30);
        assert!((direct.to_f64() - std::f64::consts::FRAC_PI_4).abs() < 1e-16);
        // π/4 − its f64 = 3.0616…e-17, from π's published digits.
        let beyond = direct - DoubleDouble::from(std::f64::consts::FRAC_PI_4);
        assert!((beyond.to_f64() - 3.061_616_997_868_383e-17).abs() < 1e-31);
        // Negative control: another machine's formula with one number changed is noticed.
        let wrong = DoubleDouble::from(4.0) * atan_of(5.0) - atan_of(238.0);
        assert!((wrong - direct).to_f64().abs() > 1e-6);
    }
}
