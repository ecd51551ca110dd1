// SPDX-License-Identifier: MIT OR Apache-2.0
//! The textured cover, put together from its parts.
//!
//! How a fragment finds where it is, how it finds its angles there, and where those lie in the
//! picture are three choices that do not depend on each other. Each is a piece of WGSL; a pipeline
//! is compiled from the pieces it needs and holds nothing of the others.

use crate::wgsl::{
    ShaderError, ShaderSource, StructLayout, compose_text, layout_in, shader_sources, validate,
};

/// Name that messages give the composed shader.
pub const TEXTURED_COVER: &str = "texture/cover.wgsl";

/// How angles become a place in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TexturedPlacement {
    /// One picture, linear in the angles.
    Affine,
    /// A picture whose size on the ground follows the view.
    Pattern,
}

impl TexturedPlacement {
    fn path(self) -> &'static str {
        match self {
            Self::Affine => "texture/affine.wgsl",
            Self::Pattern => "texture/pattern.wgsl",
        }
    }
}

/// A route: its function, and how many `vec4f` of a region's constants it takes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RouteText {
    /// Declarations, among them `fragment_offset(pixel: vec2f, depth: f32, constants:
    /// PositionConstants) -> vec3f`, or `route_angles(d: vec3f, constants: RouteConstants) -> vec2f`,
    /// and that struct: N times `vec4f`, or one that nothing reads.
    pub wgsl: String,
    /// N.
    pub constants: usize,
}

/// What a textured cover is made of.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TexturedParts {
    /// From pixel and depth to the offset from the anchor.
    pub position: RouteText,
    /// From there to the angles.
    pub route: RouteText,
    /// From there to the picture.
    pub placement: TexturedPlacement,
}

impl TexturedParts {
    /// - `position`, `route`: their text, and how many `vec4f` of constants they take
    /// - `is_pattern`: the picture's size on the ground follows the view
    #[must_use]
    pub fn new(position: (String, usize), route: (String, usize), is_pattern: bool) -> Self {
        let text = |(wgsl, constants)| RouteText { wgsl, constants };
        Self {
            position: text(position),
            route: text(route),
            placement: if is_pattern {
                TexturedPlacement::Pattern
            } else {
                TexturedPlacement::Affine
            },
        }
    }

    /// The shader's text.
    ///
    /// # Errors
    /// [`ShaderError::UnknownImport`] if a part is not embedded.
    pub fn compose(&self) -> Result<String, ShaderError> {
        let part = |path: &str| {
            let found = PARTS.iter().find(|source| source.path == path);
            let source = found.ok_or_else(|| ShaderError::UnknownImport {
                path: TEXTURED_COVER.to_owned(),
                import: path.to_owned(),
            })?;
            compose_text(source.path, source.text)
        };
        let position = self.position.text("position");
        let route = self.route.text("route");
        let placement = part(self.placement.path())?;
        let counts = format!(
            "const POSITION_CONSTANTS: u32 = {}u;\nconst ROUTE_CONSTANTS: u32 = {}u;\n",
            self.position.constants.max(1),
            self.route.constants.max(1)
        );
        let mut composed = part(TEXTURED_COVER)? + &counts;
        for (name, text) in [
            ("position", &position),
            ("route", &route),
            ("placement", &placement),
        ] {
            composed = composed.replacen(&format!("//#insert {name}\n"), text, 1);
        }
        Ok(composed)
    }

    /// How a region's constants lie in the composed shader.
    ///
    /// # Errors
    /// [`ShaderError`] if a part does not compile.
    pub fn region_layout(&self) -> Result<StructLayout, ShaderError> {
        let module = validate(TEXTURED_COVER, &self.compose()?)?;
        layout_in(&module, TEXTURED_COVER, "TexturedRegion")
    }
}

impl RouteText {
    /// The route's declarations and a function that hands it a region's constants.
    fn text(&self, member: &str) -> String {
        let (outer, inner, given, ty, returned) = match member {
            "position" => (
                "offset_of(pixel: vec2<f32>, depth: f32)",
                "fragment_offset",
                "pixel, depth",
                "PositionConstants",
                "vec3<f32>",
            ),
            _ => (
                "angles_of(offset_m: vec3<f32>)",
                "route_angles",
                "offset_m",
                "RouteConstants",
                "vec2<f32>",
            ),
        };
        let constants: Vec<String> = (0..self.constants.max(1))
            .map(|i| format!("textured.{member}[{i}]"))
            .collect();
        format!(
            "{}\nfn {outer} -> {returned} {{\n    return {inner}({given}, {ty}(\n        {},\n    \
             ));\n}}\n",
            self.wgsl,
            constants.join(",\n        ")
        )
    }
}

/// Files that are put together here; those with entry points among them compile only then.
pub(crate) const PARTS: [ShaderSource; 3] = shader_sources![
    "texture/cover.wgsl",
    "texture/affine.wgsl",
    "texture/pattern.wgsl",
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared_text;

    fn parts(placement: TexturedPlacement) -> TexturedParts {
        TexturedParts {
            position: RouteText {
                wgsl: "struct PositionConstants { c0: vec4f, c1: vec4f }\n\
                       fn fragment_offset(pixel: vec2f, depth: f32, constants: PositionConstants) -> \
                       vec3f { return vec3f(pixel, depth) + constants.c1.xyz; }"
                    .to_owned(),
                constants: 2,
            },
            route: RouteText {
                wgsl: "struct RouteConstants { c0: vec4f }\n\
                       fn route_angles(d: vec3f, constants: RouteConstants) -> vec2f { return d.yz; }"
                    .to_owned(),
                constants: 0,
            },
            placement,
        }
    }

    #[test]
    fn every_placement_composes_and_validates() {
        for placement in [TexturedPlacement::Affine, TexturedPlacement::Pattern] {
            let composed = parts(placement).compose().expect("embedded");
            validate(TEXTURED_COVER, &composed).expect("valid");
            assert!(!composed.contains("#insert"));
            // What is not needed is not there.
            let mixes = composed.contains("mix(");
            assert_eq!(mixes, placement == TexturedPlacement::Pattern);
        }
    }

    #[test]
    fn routes_find_their_constants_behind_the_fixed_ones() {
        let layout = parts(TexturedPlacement::Affine)
            .region_layout()
            .expect("valid");
        let find = |name: &str| {
            let member = layout.members.iter().find(|(member, ..)| member == name);
            member.map(|&(_, offset, size)| (offset, size))
        };
        let (position, size) = find("position").expect("there");
        assert_eq!(size, 32);
        assert_eq!(find("route"), Some((position + 32, 16)));
        assert_eq!(layout.stride, position + 48);
    }

    #[test]
    fn a_part_that_does_not_fit_is_refused() {
        let mut wrong = parts(TexturedPlacement::Affine);
        wrong.position.constants = 1;
        assert!(wrong.region_layout().is_err(), "a constant too few");
        let mut wrong = parts(TexturedPlacement::Affine);
        wrong.route.wgsl = wrong.route.wgsl.replace("route_angles", "angles");
        assert!(wrong.region_layout().is_err(), "no such function");
    }

    /// The coefficients of y³, y², y and 1 in `srgb_of_linear`, as the shader has them.
    fn encoding_coefficients() -> Vec<f64> {
        let text = shared_text("shared/srgb.wgsl").expect("embedded");
        let line = text.lines().find(|line| line.contains("let curved ="));
        let (_, right) = line.expect("there").split_once('=').expect("a definition");
        let spaced = right.replace("- ", "-");
        let numbers = spaced.split(|c: char| !(c.is_ascii_digit() || ".-".contains(c)));
        numbers.filter_map(|number| number.parse().ok()).collect()
    }

    /// Extremes of the encoding's error between the standard's join and 1, in levels of 255.
    fn extremes(coefficients: &[f64]) -> Vec<f64> {
        const STEPS: i32 = 20_000;
        let error = |step: i32| {
            let join = 0.003_130_8_f64.powf(0.25);
            let y = join + (1.0 - join) * f64::from(step) / f64::from(STEPS);
            let fitted = coefficients.iter().fold(0.0, |sum, c| sum * y + c);
            255.0 * (fitted - (1.055 * y.powf(4.0 / 2.4) - 0.055))
        };
        let is_extreme = |&step: &i32| {
            let [before, here, after] = [step - 1, step, step + 1].map(error);
            let is_end = step == 0 || step == STEPS;
            is_end || (here - before) * (after - here) <= 0.0
        };
        (0..=STEPS).filter(is_extreme).map(error).collect()
    }

    /// A polynomial of degree n is the one with the least largest error if and only if the error
    /// takes that size n + 2 times with alternating signs (Chebyshev; the condition that Remez's
    /// exchange ends at).
    fn is_best(coefficients: &[f64]) -> bool {
        let found = extremes(coefficients);
        let largest = found.iter().copied().map(f64::abs).fold(0.0, f64::max);
        found.len() == coefficients.len() + 1
            && found.iter().all(|error| error.abs() > 0.99 * largest)
            && found.windows(2).all(|pair| pair[0] * pair[1] < 0.0)
    }

    #[test]
    fn the_screens_encoding_is_the_best_cubic_and_near_enough() {
        let coefficients = encoding_coefficients();
        assert_eq!(coefficients.len(), 4, "{coefficients:?}");
        let found = extremes(&coefficients);
        assert!(found.iter().all(|error| error.abs() < 0.056), "{found:?}");
        assert!(is_best(&coefficients), "{found:?}");
        // Negative controls: each coefficient a five-thousandth beside.
        for i in 0..4 {
            let mut wrong = coefficients.clone();
            wrong[i] += 2e-4;
            assert!(!is_best(&wrong), "{i}");
            assert!(
                extremes(&wrong).iter().any(|error| error.abs() > 0.056),
                "{i}"
            );
        }
    }
}
