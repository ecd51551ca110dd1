// SPDX-License-Identifier: MIT OR Apache-2.0
//! Writes a [`Program`] as WGSL.

use super::{Program, Step, Value};
use std::fmt::Write as _;

impl Program {
    /// WGSL that defines `struct RouteConstants` and `fn route_angles`.
    ///
    /// Where the program reads a table, the text names `route_table` and `route_sampler`; their
    /// declarations are those of [`crate::LookupTable::declarations`], and those of `route_cube` are
    /// [`crate::CubeTexture::declarations`].
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
