// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers that a ball's state is made of: `f32`, `f64`, and sums of `f32` that keep what was rounded off.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A floating-point number.
pub(crate) trait Real:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest one.
    fn of(value: f64) -> Self;
    fn as_f64(self) -> f64;
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn as_f64(self) -> f64 {
        self
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for f32 {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to f32 is what is measured"
    )]
    fn of(value: f64) -> Self {
        value as Self
    }

    fn as_f64(self) -> f64 {
        f64::from(self)
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// A sum that a step adds to.
pub(crate) trait Sum<R: Real>: Copy {
    fn start(value: R) -> Self;
    fn add(&mut self, change: R);
    /// Rounded once.
    fn minus(self, other: R) -> R;
    fn total(self) -> f64;
}

/// Every addition rounds.
impl<R: Real> Sum<R> for R {
    fn start(value: R) -> Self {
        value
    }

    fn add(&mut self, change: R) {
        *self = *self + change;
    }

    fn minus(self, other: R) -> R {
        self - other
    }

    fn total(self) -> f64 {
        self.as_f64()
    }
}

/// A sum and what its roundings left out (Knuth's two-sum: no branch, no larger number is assumed).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Compensated<R> {
    sum: R,
    rest: R,
}

impl<R: Real> Sum<R> for Compensated<R> {
    fn start(value: R) -> Self {
        Self {
            sum: value,
            rest: R::of(0.0),
        }
    }

    fn add(&mut self, change: R) {
        let change = change + self.rest;
        let sum = self.sum + change;
        let added = sum - self.sum;
        self.rest = (self.sum - (sum - added)) + (change - added);
        self.sum = sum;
    }

    fn minus(self, other: R) -> R {
        (self.sum - other) + self.rest
    }

    fn total(self) -> f64 {
        self.sum.as_f64() + self.rest.as_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compensated_sums_keep_what_plain_ones_lose() {
        fn sum<S: Sum<f32>>() -> f64 {
            let mut sum = S::start(1_000.0);
            for _ in 0..100_000 {
                sum.add(1e-6);
            }
            sum.total()
        }
        let exact = 1_000.0 + 100_000.0 * f64::from(1e-6_f32);
        // What is kept is below half a unit of the sum, 3e-5, and itself rounded to 2⁻²⁴ each time.
        assert!((sum::<Compensated<f32>>() - exact).abs() < 100_000.0 * 3e-5 / 16_777_216.0);
        // Negative control: each addition is below half a unit in the last place and changes nothing.
        assert!((sum::<f32>() - exact).abs() > 0.09);
    }
}
