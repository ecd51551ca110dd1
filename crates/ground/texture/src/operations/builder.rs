// SPDX-License-Identifier: MIT OR Apache-2.0
//! Puts a [`Program`] together step by step.

use super::{Program, Step, Value};
use crate::cube::CubeTexture;
use crate::lookup::LookupTable;

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
