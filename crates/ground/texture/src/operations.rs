// SPDX-License-Identifier: MIT OR Apache-2.0
//! A coordinate route as a list of steps: the one description that its shader text, its emulation,
//! its operation counts and its rounding bound are made from. Position routes are such lists too,
//! with a pixel and its depth in the place of the offset and three results.
//!
//! Scalars in `f32`, no loops and no branches: a choice is a select, as on a GPU. Steps are shared
//! where they are equal, and steps that no result needs are dropped, as a shader compiler would. A
//! device may differ from the emulation where WGSL leaves it free (WGSL §15.7.4 "Floating point
//! accuracy"): `fma` may be a product and a sum with two roundings, as [`Arithmetic::Separate`]
//! computes it. A division may be off by 2.5 ULP, an inverse square root by 2 ULP, `atan` and `atan2`
//! by 4096 ULP. A sampler may weigh more finely or round to the format it reads, subnormals may be
//! flushed, and minima of NaN are undefined. The bounds of [`Program::bounded`] cover all of these but
//! the flush and the NaN.

mod builder;
mod evaluate;
mod wgsl;

pub use builder::ProgramBuilder;

use crate::cube::CubeTexture;
use crate::lookup::{LookupTable, Sampler};

/// A scalar made by a step of a [`Program`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Value(usize);

/// One step; operands are earlier steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Component 0, 1 or 2 of the fragment's offset from the anchor, metres.
    Offset(usize),
    /// Scalar number `i` of the per-region constants, four to a vector.
    Constant(usize),
    /// A number of the code.
    Literal(f32),
    /// `−a`
    Negate(Value),
    /// `|a|`
    Absolute(Value),
    /// `⌊a⌋`
    Floor(Value),
    /// `a + b`
    Add(Value, Value),
    /// `a − b`
    Subtract(Value, Value),
    /// `a · b`
    Multiply(Value, Value),
    /// `a · b + c`, rounded once or twice
    Fma(Value, Value, Value),
    /// `a / b`
    Divide(Value, Value),
    /// `√a`
    SquareRoot(Value),
    /// `1 / √a`
    InverseSquareRoot(Value),
    /// The smaller one.
    Minimum(Value, Value),
    /// The larger one.
    Maximum(Value, Value),
    /// Condition `a < b`; only selects take conditions.
    Less(Value, Value),
    /// `if_true` where the condition holds, else `if_false`
    Select {
        /// A [`Step::Less`].
        condition: Value,
        /// Taken where it holds.
        if_true: Value,
        /// Taken where it does not.
        if_false: Value,
    },
    /// The device's own `atan(a)`.
    Arctangent(Value),
    /// The device's own `atan2(y, x)`.
    Arctangent2 {
        /// Ordinate.
        y: Value,
        /// Abscissa.
        x: Value,
    },
    /// 2 to the power of `a`.
    PowerOfTwo(Value),
    /// Channel 0 or 1 of the route's cube texture in a direction; both are one fetch.
    CubeTexel {
        /// Of any length but 0.
        direction: [Value; 3],
        /// Longitude or latitude.
        channel: usize,
    },
    /// Texel number `a` of the route's table; `a` is a whole number within it.
    LoadTexel(Value),
    /// The route's table through a linear sampler at texture coordinate `a`.
    SampleTable(Value),
}

/// How `fma` rounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// Once, as hardware with the instruction does.
    Fused,
    /// After the product and after the sum, which WGSL also allows.
    Separate,
}

/// Counts of a route's operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Operations {
    /// Sums, differences, products, fused ones, floors.
    pub add_mul_fma: u32,
    /// Divisions.
    pub divisions: u32,
    /// Comparisons, selects, minima, maxima.
    pub compares_selects: u32,
    /// Square roots and inverse ones.
    pub sqrt: u32,
    /// The device's own `atan`, `atan2` and `exp2`.
    pub transcendental: u32,
    /// Texel loads and samples.
    pub texture_fetches: u32,
    /// Negations and absolute values: free on most hardware, where they modify an operand.
    pub sign_changes: u32,
}

/// The finished list with its results: two angles, or what else it was finished with.
#[derive(Debug, Clone)]
pub struct Program {
    steps: Vec<Step>,
    outputs: Vec<Value>,
    constant_vectors: usize,
    table: Option<LookupTable>,
    cube: Option<CubeTexture>,
    input_names: [&'static str; 3],
}

impl Step {
    /// The values it takes.
    fn operands(&self) -> Vec<Value> {
        let mut operands = Vec::new();
        self.with_operands(|value| {
            operands.push(value);
            value
        });
        operands
    }

    /// The same step with other operands.
    fn with_operands(&self, mut new: impl FnMut(Value) -> Value) -> Self {
        match *self {
            Self::Offset(_) | Self::Constant(_) | Self::Literal(_) => *self,
            Self::Negate(a) => Self::Negate(new(a)),
            Self::Absolute(a) => Self::Absolute(new(a)),
            Self::Floor(a) => Self::Floor(new(a)),
            Self::SquareRoot(a) => Self::SquareRoot(new(a)),
            Self::InverseSquareRoot(a) => Self::InverseSquareRoot(new(a)),
            Self::Arctangent(a) => Self::Arctangent(new(a)),
            Self::PowerOfTwo(a) => Self::PowerOfTwo(new(a)),
            Self::CubeTexel { direction, channel } => Self::CubeTexel {
                direction: direction.map(new),
                channel,
            },
            Self::LoadTexel(a) => Self::LoadTexel(new(a)),
            Self::SampleTable(a) => Self::SampleTable(new(a)),
            Self::Add(a, b) => Self::Add(new(a), new(b)),
            Self::Subtract(a, b) => Self::Subtract(new(a), new(b)),
            Self::Multiply(a, b) => Self::Multiply(new(a), new(b)),
            Self::Divide(a, b) => Self::Divide(new(a), new(b)),
            Self::Minimum(a, b) => Self::Minimum(new(a), new(b)),
            Self::Maximum(a, b) => Self::Maximum(new(a), new(b)),
            Self::Less(a, b) => Self::Less(new(a), new(b)),
            Self::Arctangent2 { y, x } => Self::Arctangent2 {
                y: new(y),
                x: new(x),
            },
            Self::Fma(a, b, c) => Self::Fma(new(a), new(b), new(c)),
            Self::Select {
                condition,
                if_true,
                if_false,
            } => Self::Select {
                condition: new(condition),
                if_true: new(if_true),
                if_false: new(if_false),
            },
        }
    }
}

impl Program {
    /// How many vectors of four constants it reads.
    #[must_use]
    pub fn constant_vectors(&self) -> usize {
        self.constant_vectors
    }

    /// The table it reads, if any.
    #[must_use]
    pub fn table(&self) -> Option<&LookupTable> {
        self.table.as_ref()
    }

    /// The cube texture it reads, if any.
    #[must_use]
    pub fn cube(&self) -> Option<&CubeTexture> {
        self.cube.as_ref()
    }

    /// The program as it runs where samplers are like this one: for what is to be expected of a device,
    /// not for what holds on all.
    #[must_use]
    pub fn on_sampler(&self, sampler: Sampler) -> Self {
        Self {
            table: self.table.clone().map(|table| table.on(sampler)),
            cube: self.cube.map(|cube| cube.on(&sampler)),
            ..self.clone()
        }
    }

    /// The steps, in order.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Operations by kind.
    #[must_use]
    pub fn operations(&self) -> Operations {
        let mut count = Operations::default();
        for step in &self.steps {
            match step {
                Step::Offset(_) | Step::Constant(_) | Step::Literal(_) => {}
                Step::Negate(_) | Step::Absolute(_) => count.sign_changes += 1,
                Step::Floor(_)
                | Step::Add(..)
                | Step::Subtract(..)
                | Step::Multiply(..)
                | Step::Fma(..) => count.add_mul_fma += 1,
                Step::Divide(..) => count.divisions += 1,
                Step::SquareRoot(_) | Step::InverseSquareRoot(_) => count.sqrt += 1,
                Step::Minimum(..) | Step::Maximum(..) | Step::Less(..) | Step::Select { .. } => {
                    count.compares_selects += 1;
                }
                Step::Arctangent(_) | Step::Arctangent2 { .. } | Step::PowerOfTwo(_) => {
                    count.transcendental += 1;
                }
                // Both channels come with one fetch.
                Step::CubeTexel { channel, .. } => {
                    count.texture_fetches += u32::from(*channel == 0);
                }
                Step::LoadTexel(_) | Step::SampleTable(_) => count.texture_fetches += 1,
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rounding::half_ulp;

    #[test]
    fn half_a_unit_is_half_the_distance_to_the_next_number() {
        for value in [
            1.0_f32,
            1.5,
            0.1,
            6_378_137.0,
            3e-39,
            1.2e-38,
            3e38,
            0.999_999_9,
        ] {
            let gap = f64::from(value.next_up()) - f64::from(value);
            let found = half_ulp(f64::from(-value));
            assert!((found / (0.5 * gap) - 1.0).abs() < 1e-12, "{value:e}");
        }
        // The distance doubles from a power of two on.
        assert!((half_ulp(2.0) / half_ulp(1.999_999) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn equal_steps_are_one_and_unneeded_ones_none() {
        let mut b = ProgramBuilder::new();
        let [x, y, z] = b.offset();
        let once = b.multiply(x, y);
        let again = b.multiply(x, y);
        assert_eq!(once, again);
        // −0 and 0 are two numbers, since a product tells them apart.
        assert_ne!(b.literal(0.0), b.literal(-0.0));
        let unneeded = b.divide(z, x);
        let _ = b.square_root(unneeded);
        let sum = b.add(once, again);
        let program = b.finish(sum, once);
        let count = program.operations();
        assert_eq!((count.add_mul_fma, count.divisions, count.sqrt), (2, 0, 0));
        let text = program.wgsl();
        assert!(!text.contains('/') && !text.contains("sqrt"), "{text}");
        // Negative control: needed, it is there.
        let mut b = ProgramBuilder::new();
        let [x, _, z] = b.offset();
        let quotient = b.divide(z, x);
        let text = b.finish(quotient, x).wgsl();
        assert!(text.contains("d.z / d.x"), "{text}");
    }

    #[test]
    fn a_missing_constant_cannot_be_overlooked() {
        let mut b = ProgramBuilder::new();
        let [x, _, _] = b.offset();
        let constant = b.constant(5);
        let sum = b.add(x, constant);
        let program = b.finish(sum, x);
        assert_eq!(program.constant_vectors(), 2);
        let short = [[1.0; 4]];
        assert!(program.emulate(&short, [0.0; 3], Arithmetic::Fused)[0].is_nan());
        assert!(program.bounded(&short, [0.0; 3])[0].value.is_nan());
        let enough = [[1.0; 4], [2.0; 4]];
        assert!((program.emulate(&enough, [0.5; 3], Arithmetic::Fused)[0] - 2.5).abs() < 1e-9);
    }

    #[test]
    fn fused_and_separate_rounding_differ_and_both_are_within_the_bound() {
        let mut b = ProgramBuilder::new();
        let [x, y, z] = b.offset();
        let fused = b.fma(x, y, z);
        let program = b.finish(fused, x);
        // (1 + ε)² − 1 − 2ε = ε², which a product rounded on its own loses.
        let epsilon = f32::EPSILON;
        let offset = [1.0 + epsilon, 1.0 + epsilon, -1.0 - 2.0 * epsilon];
        let [exact, _] = program.emulate(&[], offset, Arithmetic::Fused);
        let [lost, _] = program.emulate(&[], offset, Arithmetic::Separate);
        assert!(exact > 0.0 && lost.abs() < exact, "{exact:e} {lost:e}");
        let bounded = program.bounded(&[], offset)[0];
        for found in [exact, lost] {
            assert!((f64::from(found) - bounded.value).abs() <= bounded.bound);
        }
        // Negative control: the product's own rounding left out of the bound would not cover the second.
        let without = bounded.bound - half_ulp(1.0);
        assert!((f64::from(lost) - bounded.value).abs() > without);
    }
}
