// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs a [`Program`] on the CPU: in `f32` as a shader would, and in `f64` with its rounding bound.

use super::{Arithmetic, Program, Step, Value};
use crate::rounding::{Bounded, combine, half_ulp, slope};
use terrafill_core::nearest_f32;

impl Program {
    /// Runs it in `f32`: the same operations in the same order as the shader.
    ///
    /// A missing constant counts as NaN, so that it cannot be overlooked. The device's own
    /// functions are taken as correctly rounded.
    #[must_use]
    pub fn emulate(
        &self,
        constants: &[[f32; 4]],
        offset_m: [f32; 3],
        arithmetic: Arithmetic,
    ) -> [f32; 2] {
        let all = self.emulate_all(constants, offset_m, arithmetic);
        [all[0], all[1]]
    }

    /// As [`Self::emulate`], every result.
    #[must_use]
    pub fn emulate_all(
        &self,
        constants: &[[f32; 4]],
        offset_m: [f32; 3],
        arithmetic: Arithmetic,
    ) -> Vec<f32> {
        let mut values: Vec<f32> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let v = |value: Value| values[value.0];
            let result = match *step {
                Step::Offset(axis) => offset_m[axis],
                Step::Constant(index) => {
                    constants.get(index / 4).map_or(f32::NAN, |c| c[index % 4])
                }
                Step::Literal(number) => number,
                Step::Negate(a) => -v(a),
                Step::Absolute(a) => v(a).abs(),
                Step::Floor(a) => v(a).floor(),
                Step::Add(a, b) => v(a) + v(b),
                Step::Subtract(a, b) => v(a) - v(b),
                Step::Multiply(a, b) => v(a) * v(b),
                Step::Fma(a, b, c) => match arithmetic {
                    Arithmetic::Fused => v(a).mul_add(v(b), v(c)),
                    Arithmetic::Separate => v(a) * v(b) + v(c),
                },
                Step::Divide(a, b) => v(a) / v(b),
                Step::SquareRoot(a) => v(a).sqrt(),
                Step::InverseSquareRoot(a) => nearest_f32(1.0 / f64::from(v(a)).sqrt()),
                Step::Minimum(a, b) => v(a).min(v(b)),
                Step::Maximum(a, b) => v(a).max(v(b)),
                Step::Less(a, b) => f32::from(u8::from(v(a) < v(b))),
                Step::Select {
                    condition,
                    if_true,
                    if_false,
                } => {
                    if v(condition) > 0.5 {
                        v(if_true)
                    } else {
                        v(if_false)
                    }
                }
                Step::Arctangent(a) => nearest_f32(f64::from(v(a)).atan()),
                Step::Arctangent2 { y, x } => nearest_f32(f64::from(v(y)).atan2(f64::from(v(x)))),
                Step::PowerOfTwo(a) => nearest_f32(f64::from(v(a)).exp2()),
                Step::CubeTexel { direction, channel } => self
                    .cube
                    .as_ref()
                    .map_or(f32::NAN, |cube| cube.sample(direction.map(v))[channel]),
                Step::LoadTexel(a) => self.table.as_ref().map_or(f32::NAN, |t| t.load(v(a))),
                Step::SampleTable(a) => self.table.as_ref().map_or(f32::NAN, |t| t.sample(v(a))),
            };
            values.push(result);
        }
        self.outputs.iter().map(|value| values[value.0]).collect()
    }

    /// Runs it in `f64` and carries along what rounding may add, step by step.
    ///
    /// First-order running error analysis (Higham 2002, "Accuracy and Stability of Numerical
    /// Algorithms", §3.3). Each step passes on its operands' errors by its derivatives and adds half
    /// a unit in the last place of its own result, or what WGSL allows where that is more.
    #[must_use]
    pub fn bounded(&self, constants: &[[f32; 4]], offset_m: [f32; 3]) -> [Bounded; 2] {
        let all = self.bounded_all(constants, offset_m.map(|x| Bounded::exact(f64::from(x))));
        [all[0], all[1]]
    }

    /// As [`Self::bounded`], every result, from inputs that bring an error along.
    #[must_use]
    pub fn bounded_all(&self, constants: &[[f32; 4]], inputs: [Bounded; 3]) -> Vec<Bounded> {
        let mut values: Vec<Bounded> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let result = self.bounded_step(step, constants, inputs, &values);
            values.push(result);
        }
        self.outputs.iter().map(|value| values[value.0]).collect()
    }

    fn bounded_step(
        &self,
        step: &Step,
        constants: &[[f32; 4]],
        inputs: [Bounded; 3],
        values: &[Bounded],
    ) -> Bounded {
        let v = |value: Value| values[value.0];
        let exact = Bounded::exact;
        match *step {
            Step::Offset(axis) => inputs[axis],
            Step::Constant(index) => exact(
                constants
                    .get(index / 4)
                    .map_or(f64::NAN, |c| f64::from(c[index % 4])),
            ),
            Step::Literal(number) => exact(f64::from(number)),
            Step::Negate(a) => v(a).map(-v(a).value),
            Step::Absolute(a) => v(a).map(v(a).value.abs()),
            // Piecewise constant: a rounding that crosses a step lands where both sides are as good.
            Step::Floor(a) => exact(v(a).value.floor()),
            Step::Add(a, b) => combine(v(a).value + v(b).value, &[(v(a), 1.0), (v(b), 1.0)], 1.0),
            Step::Subtract(a, b) => {
                combine(v(a).value - v(b).value, &[(v(a), 1.0), (v(b), 1.0)], 1.0)
            }
            Step::Multiply(a, b) => combine(
                v(a).value * v(b).value,
                &[(v(a), v(b).value), (v(b), v(a).value)],
                1.0,
            ),
            Step::Fma(a, b, c) => {
                let product = v(a).value * v(b).value;
                let terms = [(v(a), v(b).value), (v(b), v(a).value), (v(c), 1.0)];
                let mut sum = combine(product + v(c).value, &terms, 1.0);
                sum.bound += half_ulp(product);
                sum
            }
            Step::Divide(a, b) => {
                let quotient = v(a).value / v(b).value;
                let terms = [(v(a), 1.0 / v(b).value), (v(b), quotient / v(b).value)];
                combine(quotient, &terms, 5.0)
            }
            Step::SquareRoot(a) => {
                let root = v(a).value.sqrt();
                // WGSL: as 1 / inverseSqrt, which is 2 ULP and a division.
                combine(root, &[(v(a), slope(0.5 / root))], 9.0)
            }
            Step::InverseSquareRoot(a) => {
                let root = 1.0 / v(a).value.sqrt();
                combine(root, &[(v(a), slope(0.5 * root / v(a).value))], 4.0)
            }
            Step::Minimum(a, b) => {
                if v(b).value < v(a).value {
                    v(b)
                } else {
                    v(a)
                }
            }
            Step::Maximum(a, b) => {
                if v(b).value > v(a).value {
                    v(b)
                } else {
                    v(a)
                }
            }
            Step::Less(a, b) => exact(f64::from(u8::from(v(a).value < v(b).value))),
            Step::Select {
                condition,
                if_true,
                if_false,
            } => {
                if v(condition).value > 0.5 {
                    v(if_true)
                } else {
                    v(if_false)
                }
            }
            Step::Arctangent(a) => {
                let x = v(a).value;
                combine(x.atan(), &[(v(a), 1.0 / (1.0 + x * x))], 8192.0)
            }
            Step::Arctangent2 { y, x } => {
                let (p, q) = (v(y).value, v(x).value);
                let square = p * p + q * q;
                let terms = [(v(y), slope(q / square)), (v(x), slope(p / square))];
                combine(p.atan2(q), &terms, 8192.0)
            }
            Step::PowerOfTwo(a) => {
                let power = v(a).value.exp2();
                // WGSL: 3 + 2 |x| ULP.
                let own = 2.0 * (3.0 + 2.0 * v(a).value.abs());
                combine(power, &[(v(a), power * std::f64::consts::LN_2)], own)
            }
            Step::CubeTexel { direction, channel } => {
                self.cube.as_ref().map_or(exact(f64::NAN), |cube| {
                    cube.bounded(direction.map(v))[channel]
                })
            }
            Step::LoadTexel(a) => self.table.as_ref().map_or(exact(f64::NAN), |table| {
                exact(f64::from(table.load(nearest_f32(v(a).value))))
            }),
            Step::SampleTable(a) => self.table.as_ref().map_or(exact(f64::NAN), |table| {
                let value = f64::from(table.sample(nearest_f32(v(a).value)));
                let mut sample = combine(value, &[(v(a), table.slope())], 1.0);
                sample.bound += table.sampler_freedom();
                sample.variance += table.sampler().bias_and_variance().1;
                sample
            }),
        }
    }
}
