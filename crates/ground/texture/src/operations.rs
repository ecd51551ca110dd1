// SPDX-License-Identifier: MIT OR Apache-2.0
//! A coordinate route as a list of steps: the one description that its shader text, its emulation,
//! its operation counts and its rounding bound are made from. Position routes are such lists too,
//! with a pixel and its depth in the place of the offset and three results.
//!
//! Scalars in `f32`, no loops and no branches: a choice is a select, as on a GPU. Steps are shared
//! where they are equal, and steps that no result needs are dropped, as a shader compiler would.
//! A device may differ from the emulation where WGSL leaves it free (WGSL §15.7.4 "Floating point
//! accuracy"): `fma` may be a product and a sum with two roundings ([`Arithmetic::Separate`] does
//! that), a division may be off by 2.5 ULP, an inverse square root by 2 ULP, `atan` and `atan2` by
//! 4096 ULP, a sampler may weigh more finely or round to the format it reads, subnormals may be
//! flushed, and minima of NaN are anything. The bounds of
//! [`Program::bounded`] cover all of these but the flush and the NaN.

use crate::cube::CubeTexture;
use crate::lookup::{LookupTable, Sampler};
use crate::rounding::{Bounded, combine, half_ulp, rounded, slope};
use std::fmt::Write as _;

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

/// Takes steps down; see [`Program`].
#[derive(Debug, Clone, Default)]
pub struct ProgramBuilder {
    steps: Vec<Step>,
    table: Option<LookupTable>,
    cube: Option<CubeTexture>,
    input_names: Option<[&'static str; 3]>,
}

impl ProgramBuilder {
    /// Nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// With the table that [`Step::LoadTexel`] and [`Step::SampleTable`] read.
    #[must_use]
    pub fn with_table(table: LookupTable) -> Self {
        Self {
            table: Some(table),
            ..Self::default()
        }
    }

    /// With the cube texture that [`Step::CubeTexel`] reads.
    #[must_use]
    pub fn with_cube(cube: CubeTexture) -> Self {
        Self {
            cube: Some(cube),
            ..Self::default()
        }
    }

    /// With three scalars of these names for input, in the place of the offset's components.
    #[must_use]
    pub fn with_inputs(names: [&'static str; 3]) -> Self {
        Self {
            input_names: Some(names),
            ..Self::default()
        }
    }

    /// The value of `step`, taken down unless an equal one already is.
    pub fn push(&mut self, step: Step) -> Value {
        let same = |other: &Step| match (other, &step) {
            // −0 equals 0 and is another number.
            (Step::Literal(a), Step::Literal(b)) => a.to_bits() == b.to_bits(),
            _ => *other == step,
        };
        let place = self.steps.iter().position(same).unwrap_or_else(|| {
            self.steps.push(step);
            self.steps.len() - 1
        });
        Value(place)
    }

    /// The fragment's offset from the anchor, meridian axes, metres.
    pub fn offset(&mut self) -> [Value; 3] {
        [0, 1, 2].map(|axis| self.push(Step::Offset(axis)))
    }

    /// Scalar number `index` of the region's constants.
    pub fn constant(&mut self, index: usize) -> Value {
        self.push(Step::Constant(index))
    }

    /// A number.
    pub fn literal(&mut self, number: f32) -> Value {
        self.push(Step::Literal(number))
    }

    /// `−a`
    pub fn negate(&mut self, a: Value) -> Value {
        self.push(Step::Negate(a))
    }

    /// `|a|`
    pub fn absolute(&mut self, a: Value) -> Value {
        self.push(Step::Absolute(a))
    }

    /// `⌊a⌋`
    pub fn floor(&mut self, a: Value) -> Value {
        self.push(Step::Floor(a))
    }

    /// `a + b`
    pub fn add(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Add(a, b))
    }

    /// `a − b`
    pub fn subtract(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Subtract(a, b))
    }

    /// `a · b`
    pub fn multiply(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Multiply(a, b))
    }

    /// `a · b + c`
    pub fn fma(&mut self, a: Value, b: Value, c: Value) -> Value {
        self.push(Step::Fma(a, b, c))
    }

    /// `a / b`
    pub fn divide(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Divide(a, b))
    }

    /// `√a`
    pub fn square_root(&mut self, a: Value) -> Value {
        self.push(Step::SquareRoot(a))
    }

    /// `1 / √a`
    pub fn inverse_square_root(&mut self, a: Value) -> Value {
        self.push(Step::InverseSquareRoot(a))
    }

    /// 2 to the power of `a`.
    pub fn power_of_two(&mut self, a: Value) -> Value {
        self.push(Step::PowerOfTwo(a))
    }

    /// Both channels of the cube texture in a direction.
    pub fn cube_texel(&mut self, direction: [Value; 3]) -> [Value; 2] {
        [0, 1].map(|channel| self.push(Step::CubeTexel { direction, channel }))
    }

    /// The smaller one.
    pub fn minimum(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Minimum(a, b))
    }

    /// The larger one.
    pub fn maximum(&mut self, a: Value, b: Value) -> Value {
        self.push(Step::Maximum(a, b))
    }

    /// `if_true` where `a < b`, else `if_false`.
    pub fn select_less(&mut self, a: Value, b: Value, if_true: Value, if_false: Value) -> Value {
        let condition = self.push(Step::Less(a, b));
        self.push(Step::Select {
            condition,
            if_true,
            if_false,
        })
    }

    /// Coefficients in ascending powers at `x`, by Horner's rule.
    pub fn polynomial(&mut self, x: Value, ascending: &[f32]) -> Value {
        let mut descending = ascending.iter().rev();
        let mut sum = self.literal(descending.next().copied().unwrap_or(0.0));
        for coefficient in descending {
            let next = self.literal(*coefficient);
            sum = self.fma(sum, x, next);
        }
        sum
    }

    /// The program that gives these two values: longitude and latitude minus the anchor's.
    #[must_use]
    pub fn finish(self, longitude: Value, latitude: Value) -> Program {
        self.finish_all(&[longitude, latitude])
    }

    /// The program that gives these values.
    #[must_use]
    pub fn finish_all(self, results: &[Value]) -> Program {
        let mut needed = vec![false; self.steps.len()];
        for result in results {
            needed[result.0] = true;
        }
        for place in (0..self.steps.len()).rev() {
            if needed[place] {
                for operand in self.steps[place].operands() {
                    needed[operand.0] = true;
                }
            }
        }
        let mut new_places = vec![0; self.steps.len()];
        let mut steps = Vec::new();
        for (place, step) in self.steps.iter().enumerate().filter(|(i, _)| needed[*i]) {
            new_places[place] = steps.len();
            steps.push(step.with_operands(|value| Value(new_places[value.0])));
        }
        let constant_vectors = steps
            .iter()
            .map(|step| match step {
                Step::Constant(index) => index / 4 + 1,
                _ => 0,
            })
            .max()
            .unwrap_or(0);
        Program {
            steps,
            outputs: results
                .iter()
                .map(|value| Value(new_places[value.0]))
                .collect(),
            constant_vectors,
            table: self.table,
            cube: self.cube,
            input_names: self.input_names.unwrap_or(["d.x", "d.y", "d.z"]),
        }
    }
}

impl Step {
    /// The values it takes.
    fn operands(&self) -> impl Iterator<Item = Value> {
        let list = match *self {
            Self::Offset(_) | Self::Constant(_) | Self::Literal(_) => [None, None, None],
            Self::Negate(a)
            | Self::Absolute(a)
            | Self::Floor(a)
            | Self::SquareRoot(a)
            | Self::InverseSquareRoot(a)
            | Self::Arctangent(a)
            | Self::PowerOfTwo(a)
            | Self::LoadTexel(a)
            | Self::SampleTable(a) => [Some(a), None, None],
            Self::CubeTexel { direction, .. } => direction.map(Some),
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Minimum(a, b)
            | Self::Maximum(a, b)
            | Self::Less(a, b)
            | Self::Arctangent2 { y: a, x: b } => [Some(a), Some(b), None],
            Self::Fma(a, b, c)
            | Self::Select {
                condition: a,
                if_true: b,
                if_false: c,
            } => [Some(a), Some(b), Some(c)],
        };
        list.into_iter().flatten()
    }

    /// The same step with other operands.
    fn with_operands(&self, new: impl Fn(Value) -> Value) -> Self {
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
                Step::InverseSquareRoot(a) => rounded(1.0 / f64::from(v(a)).sqrt()),
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
                Step::Arctangent(a) => rounded(f64::from(v(a)).atan()),
                Step::Arctangent2 { y, x } => rounded(f64::from(v(y)).atan2(f64::from(v(x)))),
                Step::PowerOfTwo(a) => rounded(f64::from(v(a)).exp2()),
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
    /// Algorithms", §3.3): each step passes on its operands' errors by its derivatives and adds half
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
                exact(f64::from(table.load(rounded(v(a).value))))
            }),
            Step::SampleTable(a) => self.table.as_ref().map_or(exact(f64::NAN), |table| {
                let value = f64::from(table.sample(rounded(v(a).value)));
                let mut sample = combine(value, &[(v(a), table.slope())], 1.0);
                sample.bound += table.sampler_freedom();
                sample.variance += table.sampler().bias_and_variance().1;
                sample
            }),
        }
    }

    /// WGSL that defines `struct RouteConstants` and `fn route_angles`.
    ///
    /// Where the program reads a table, the text names `route_table` and `route_sampler`; their
    /// declarations are those of [`LookupTable::declarations`], and those of `route_cube` are
    /// [`CubeTexture::declarations`].
    #[must_use]
    pub fn wgsl(&self) -> String {
        self.function_text("route_angles", "d: vec3f", "RouteConstants")
    }

    /// WGSL that defines the struct `constants_type` and a function of the given name and parameters.
    pub(crate) fn function_text(
        &self,
        name: &str,
        parameters: &str,
        constants_type: &str,
    ) -> String {
        let mut text = format!("struct {constants_type} {{\n");
        for i in 0..self.constant_vectors.max(1) {
            let _ = writeln!(text, "    c{i}: vec4f,");
        }
        let lanes = self.outputs.len();
        let _ = writeln!(
            text,
            "}}\n\nfn {name}({parameters}, constants: {constants_type}) -> vec{lanes}f {{"
        );
        for (place, step) in self.steps.iter().enumerate() {
            if let Some(expression) = self.expression(step) {
                let _ = writeln!(text, "    let v{place} = {expression};");
            }
        }
        let results: Vec<String> = self.outputs.iter().map(|v| self.name(*v)).collect();
        let _ = writeln!(text, "    return vec{lanes}f({});\n}}", results.join(", "));
        text
    }

    /// What a value is called: inputs and numbers stand where they are used.
    fn name(&self, value: Value) -> String {
        match self.steps[value.0] {
            Step::Offset(axis) => self.input_names[axis].to_owned(),
            Step::Constant(index) => {
                let lane = ["x", "y", "z", "w"][index % 4];
                format!("constants.c{}.{lane}", index / 4)
            }
            Step::Literal(number) => format!("{number:?}f"),
            _ => format!("v{}", value.0),
        }
    }

    /// The right-hand side; `None` for what [`Self::name`] writes out.
    fn expression(&self, step: &Step) -> Option<String> {
        let n = |value: Value| self.name(value);
        Some(match *step {
            Step::Offset(_) | Step::Constant(_) | Step::Literal(_) => return None,
            Step::Negate(a) => format!("-{}", n(a)),
            Step::Absolute(a) => format!("abs({})", n(a)),
            Step::Floor(a) => format!("floor({})", n(a)),
            Step::Add(a, b) => format!("{} + {}", n(a), n(b)),
            Step::Subtract(a, b) => format!("{} - {}", n(a), n(b)),
            Step::Multiply(a, b) => format!("{} * {}", n(a), n(b)),
            Step::Fma(a, b, c) => format!("fma({}, {}, {})", n(a), n(b), n(c)),
            Step::Divide(a, b) => format!("{} / {}", n(a), n(b)),
            Step::SquareRoot(a) => format!("sqrt({})", n(a)),
            Step::InverseSquareRoot(a) => format!("inverseSqrt({})", n(a)),
            Step::Minimum(a, b) => format!("min({}, {})", n(a), n(b)),
            Step::Maximum(a, b) => format!("max({}, {})", n(a), n(b)),
            Step::Less(a, b) => format!("{} < {}", n(a), n(b)),
            Step::Select {
                condition,
                if_true,
                if_false,
            } => format!("select({}, {}, {})", n(if_false), n(if_true), n(condition)),
            Step::Arctangent(a) => format!("atan({})", n(a)),
            Step::Arctangent2 { y, x } => format!("atan2({}, {})", n(y), n(x)),
            Step::PowerOfTwo(a) => format!("exp2({})", n(a)),
            Step::CubeTexel { direction, channel } => {
                let [x, y, z] = direction.map(n);
                let lane = ["x", "y"][channel];
                format!(
                    "textureSampleLevel(route_cube, route_sampler, vec3f({x}, {y}, {z}), 0.0f)\
                     .{lane}"
                )
            }
            Step::LoadTexel(a) => {
                format!("textureLoad(route_table, vec2i(i32({}), 0), 0).x", n(a))
            }
            Step::SampleTable(a) => format!(
                "textureSampleLevel(route_table, route_sampler, vec2f({}, 0.5f), 0.0f).x",
                n(a)
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        // Twin: needed, it is there.
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
        // Twin: the product's own rounding left out of the bound would not cover the second.
        let without = bounded.bound - half_ulp(1.0);
        assert!((f64::from(lost) - bounded.value).abs() > without);
    }
}
