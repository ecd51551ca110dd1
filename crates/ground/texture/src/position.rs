// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes: from a fragment's pixel and depth to its offset from the region's anchor.
//!
//! View space: x right, y up, z towards the viewer; pixels count from the upper left corner, centres
//! at half integers; the offset is in meridian axes, metres. What decides the precision is where the
//! body's radius enters. The inverse view-projection of 2007 has it in every product, so millimetres
//! of a near object are lost in 6.4 · 10⁶ m. An affine map into the region's frame, whose
//! translation eye − anchor is computed in `f64`, never holds it at all.
//!
//! Vertices have the same problem on their way in: [`VertexFormat`].

use crate::charts::affine;
use crate::operations::{Arithmetic, Operations, Program, ProgramBuilder, Value};
use crate::rounding::{Bounded, half_ulp};
use crate::{DepthFormat, DepthMapping, MapRegion};
use glam::{DMat3, DVec3};
use terrafill_core::nearest_f32;

/// A perspective view of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerspectiveView {
    /// Eye, ECEF metres.
    pub eye_ecef: DVec3,
    /// Unit vector to the right on the screen, ECEF.
    pub right: DVec3,
    /// Unit vector up on the screen, ECEF.
    pub up: DVec3,
    /// Unit vector towards the viewer, ECEF.
    pub backward: DVec3,
    /// `1 / (tan(fov_y / 2) · aspect)`.
    pub focal_x: f64,
    /// `1 / tan(fov_y / 2)`.
    pub focal_y: f64,
    /// Columns and rows.
    pub size: [u32; 2],
    /// The depth buffer.
    pub depth: DepthFormat,
}

impl PerspectiveView {
    /// Axes in meridian axes, as columns right, up, backward.
    fn meridian_from_view(&self, region: &MapRegion) -> DMat3 {
        let meridian_from_ecef = DMat3::from_rotation_z(-region.anchor_longitude_rad());
        meridian_from_ecef * DMat3::from_cols(self.right, self.up, self.backward)
    }

    /// Eye in meridian axes about the body's centre, metres.
    fn eye_meridian(&self, region: &MapRegion) -> DVec3 {
        DMat3::from_rotation_z(-region.anchor_longitude_rad()) * self.eye_ecef
    }

    /// Columns and rows as numbers.
    fn size_px(&self) -> [f64; 2] {
        self.size.map(f64::from)
    }

    /// Width of a pixel at a distance along the viewing direction, metres.
    #[must_use]
    pub fn pixel_size_m(&self, distance_m: f64) -> f64 {
        let [width, height] = self.size_px();
        let x = 2.0 / (self.focal_x * width);
        let y = 2.0 / (self.focal_y * height);
        x.min(y) * distance_m
    }

    /// Offset from the region's anchor of what is seen at `pixel` and `distance_m` along the viewing
    /// direction, meridian axes, metres, exact.
    #[must_use]
    pub fn exact_offset_m(&self, region: &MapRegion, pixel: [f64; 2], distance_m: f64) -> DVec3 {
        let [width, height] = self.size_px();
        let in_view = DVec3::new(
            (2.0 * pixel[0] / width - 1.0) / self.focal_x,
            (1.0 - 2.0 * pixel[1] / height) / self.focal_y,
            -1.0,
        ) * distance_m;
        // The eye minus the anchor before they are rotated: both are millions of metres.
        let eye = DMat3::from_rotation_z(-region.anchor_longitude_rad())
            * (self.eye_ecef - region.anchor_ecef());
        self.meridian_from_view(region) * in_view + eye
    }
}

/// One way from pixel and depth to the offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PositionRoute {
    /// Inverse view-projection matrix in `f32` to positions about the body's centre, then minus the
    /// anchor: what was published in 2007.
    InverseEcef,
    /// Eye space first, then an affine map in `f32` about the body's centre, then minus the anchor.
    EyeEcef,
    /// Eye space first, then an affine map into the region's frame: the default.
    #[default]
    EyeRegion,
}

/// How far a position route's offsets are from the exact ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionResidual {
    /// Bound by formula over all samples, metres.
    pub max_m: f64,
    /// Root mean square by formula, were all roundings independent, metres.
    pub rms_m: f64,
    /// Largest error of the emulation, metres.
    pub measured_max_m: f64,
    /// Samples with a result that is not finite.
    pub non_finite: usize,
}

impl PositionRoute {
    /// Every route, the default last.
    pub const ALL: [Self; 3] = [Self::InverseEcef, Self::EyeEcef, Self::EyeRegion];

    /// Stable name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::InverseEcef => "inverse-ecef",
            Self::EyeEcef => "eye-ecef",
            Self::EyeRegion => "eye-region",
        }
    }

    /// The route called `name`.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|route| route.name() == name)
    }

    /// Uniform values of a view and a region, computed in `f64`: what `PositionConstants` of
    /// [`Self::wgsl`] holds.
    ///
    /// | vector | what |
    /// |---|---|
    /// | 0 | half width, half height, pixels; slope of a pixel to the right and downwards, per metre of distance |
    /// | 1 | near, metres; near / far; log2(1 + far) for logarithmic depth; 0 |
    /// | 2–4 | rows of the affine map to x, y and z in meridian axes: of view space, or of clip x, clip y, depth |
    /// | 5 | `inverse-ecef`: row of w |
    /// | last | `inverse-ecef`, `eye-ecef`: the anchor, metres; 0 |
    ///
    /// The inverse is taken in `f64` and rounded: one computed in `f32` is worse.
    #[must_use]
    pub fn constants(&self, view: &PerspectiveView, region: &MapRegion) -> Vec<[f32; 4]> {
        let [width, height] = view.size_px();
        let screen = [
            nearest_f32(0.5 * width),
            nearest_f32(0.5 * height),
            nearest_f32(2.0 / (width * view.focal_x)),
            nearest_f32(-2.0 / (height * view.focal_y)),
        ];
        let axes = view.meridian_from_view(region);
        let row = |i: usize, columns: [DVec3; 4]| columns.map(|c| nearest_f32(c[i]));
        let anchor = region.anchor_meridian();
        let anchor = [
            nearest_f32(anchor.x),
            nearest_f32(anchor.y),
            nearest_f32(anchor.z),
            0.0,
        ];
        let mut constants = vec![screen, view.depth.constants()];
        let (columns, w, absolute) = match self {
            Self::InverseEcef => {
                let (columns, w) = Self::inverse_columns(view, region, axes);
                (columns, Some(w), true)
            }
            Self::EyeEcef => {
                let eye = view.eye_meridian(region);
                ([axes.x_axis, axes.y_axis, axes.z_axis, eye], None, true)
            }
            Self::EyeRegion => {
                let eye = view.exact_offset_m(region, [0.0; 2], 0.0);
                ([axes.x_axis, axes.y_axis, axes.z_axis, eye], None, false)
            }
        };
        constants.extend((0..3).map(|i| row(i, columns)));
        if let Some(w) = w {
            constants.push(w.map(nearest_f32));
        }
        if absolute {
            constants.push(anchor);
        }
        constants
    }

    /// Columns of position · w in (clip x, clip y, depth, 1), and the row of w = 1 / distance.
    ///
    /// With `w = (α depth + β) / near`, position · w is eye · w plus the ray through the pixel.
    /// Logarithmic depth is no projection; it is made reversed depth without a far plane first.
    fn inverse_columns(
        view: &PerspectiveView,
        region: &MapRegion,
        axes: DMat3,
    ) -> ([DVec3; 4], [f64; 4]) {
        let near = view.depth.near_m();
        let ratio = view.depth.near_over_far();
        let (alpha, beta) = match view.depth.mapping() {
            DepthMapping::Standard => (ratio - 1.0, 1.0),
            DepthMapping::Reversed => (1.0 - ratio, ratio),
            DepthMapping::Logarithmic => (1.0, 0.0),
        };
        let eye = view.eye_meridian(region);
        let columns = [
            axes.x_axis / view.focal_x,
            axes.y_axis / view.focal_y,
            eye * (alpha / near),
            eye * (beta / near) - axes.z_axis,
        ];
        (columns, [0.0, 0.0, alpha / near, beta / near])
    }

    /// Inputs are pixel x, pixel y and depth; results the offset's three components, metres.
    ///
    /// The shader's text, its emulation and its costs come from these steps.
    #[must_use]
    pub fn program(&self, depth_format: &DepthFormat) -> Program {
        let mut b = ProgramBuilder::with_inputs(["pixel.x", "pixel.y", "depth"]);
        let [x, y, depth] = b.offset();
        let [half_width, half_height] = [b.constant(0), b.constant(1)];
        // From the middle of the screen: exact, and small where precision matters.
        let x = b.subtract(x, half_width);
        let y = b.subtract(y, half_height);
        let offset = if *self == Self::InverseEcef {
            let (x, y) = (b.divide(x, half_width), b.divide(y, half_height));
            inverse_steps(&mut b, depth_format, [x, y, depth])
        } else {
            let distance = depth_format.distance_steps(&mut b, 1, depth);
            let [scale_x, scale_y] = [b.constant(2), b.constant(3)];
            let (slope_x, slope_y) = (b.multiply(x, scale_x), b.multiply(y, scale_y));
            let in_view = [
                b.multiply(slope_x, distance),
                b.multiply(slope_y, distance),
                b.negate(distance),
            ];
            [2, 3, 4].map(|slot| affine(&mut b, 4 * slot, in_view))
        };
        let result = match self {
            Self::EyeRegion => offset,
            Self::EyeEcef => minus_anchor(&mut b, 5, offset),
            Self::InverseEcef => minus_anchor(&mut b, 6, offset),
        };
        b.finish_all(&result)
    }

    /// WGSL of `struct PositionConstants` and
    /// `fn fragment_offset(pixel: vec2f, depth: f32, constants: PositionConstants) -> vec3f`.
    ///
    /// `pixel` is `@builtin(position).xy`. The caller tests for cleared depth first: without a far
    /// plane the distance is infinite there, and the result not finite.
    #[must_use]
    pub fn wgsl(&self, depth: &DepthFormat) -> String {
        let parameters = "pixel: vec2f, depth: f32";
        self.program(depth)
            .function_text("fragment_offset", parameters, "PositionConstants")
    }

    /// The same operations in the same order in `f32`.
    ///
    /// A device may contract or not, and divide to 2.5 ULP; [`PositionRoute::residual`] covers both.
    #[must_use]
    pub fn emulate(
        &self,
        format: &DepthFormat,
        constants: &[[f32; 4]],
        pixel: [f32; 2],
        depth: f32,
    ) -> [f32; 3] {
        let inputs = [pixel[0], pixel[1], depth];
        let all = self
            .program(format)
            .emulate_all(constants, inputs, Arithmetic::Fused);
        [all[0], all[1], all[2]]
    }

    /// What one evaluation costs.
    #[must_use]
    pub fn operations(&self, depth: &DepthFormat) -> Operations {
        self.program(depth).operations()
    }

    /// Error against the exact offset, by formula and as emulated, over a grid of pixels.
    ///
    /// `max_m` bounds what any device may do that keeps to WGSL's accuracies and does not
    /// reassociate: rounding of the stored depth, of the constants and of every step.
    #[must_use]
    pub fn residual(
        &self,
        view: &PerspectiveView,
        region: &MapRegion,
        distance_m: f64,
    ) -> PositionResidual {
        let constants = self.constants(view, region);
        let program = self.program(&view.depth);
        let mut residual = PositionResidual {
            max_m: 0.0,
            rms_m: 0.0,
            measured_max_m: 0.0,
            non_finite: 0,
        };
        let mut count = 0.0;
        for pixel in pixel_grid(view.size) {
            // Distances of one binade, so that the depth meets every rounding.
            let distance_m = distance_m * (1.0 + 1e-3 * (count % 17.0));
            count += 1.0;
            let exact = view.exact_offset_m(region, pixel, distance_m);
            let stored_error = view.depth.stored_error(distance_m);
            let stored_variance = view.depth.stored_variance(distance_m);
            let depth = view.depth.depth(distance_m);
            let [x, y] = pixel.map(Bounded::exact);
            let of = |depth| program.bounded_all(&constants, [x, y, Bounded::exact(depth)]);
            let all = of(depth);
            // What the stored depth is off by is one number wherever the formula reads it. So the offsets at both
            // its ends are evaluated. Derivatives step by step would take a numerator's and a divisor's share for
            // independent. Beyond infinity there is no offset.
            let ends = [depth - stored_error, depth + stored_error];
            let is_beyond = ends.iter().any(|end| view.depth.distance_m(*end) < 0.0);
            let [low, high] = ends.map(of);
            let moved = |i: usize| {
                if is_beyond {
                    return f64::INFINITY;
                }
                let [low, high] = [&low, &high].map(|end| (end[i].value - all[i].value).abs());
                low.max(high)
            };
            let share = stored_variance / stored_error.powi(2).max(f64::MIN_POSITIVE);
            let bound = DVec3::from_array(
                [0, 1, 2].map(|i| (all[i].value - exact[i]).abs() + all[i].bound + moved(i)),
            );
            let square: f64 = (0..3)
                .map(|i| {
                    let by_depth = moved(i).powi(2) * share;
                    (all[i].value - exact[i]).powi(2) + all[i].variance + by_depth
                })
                .sum();
            let inputs = [
                nearest_f32(pixel[0]),
                nearest_f32(pixel[1]),
                view.depth.stored(distance_m),
            ];
            let emulated = program.emulate_all(&constants, inputs, Arithmetic::Fused);
            let emulated = DVec3::from_array([0, 1, 2].map(|i| f64::from(emulated[i])));
            let error = (emulated - exact).length();
            if !emulated.is_finite() || !bound.is_finite() {
                residual.non_finite += 1;
                residual.max_m = f64::INFINITY;
                continue;
            }
            residual.max_m = residual.max_m.max(bound.length());
            residual.rms_m += square;
            residual.measured_max_m = residual.measured_max_m.max(error);
        }
        residual.rms_m = if residual.non_finite > 0 {
            f64::INFINITY
        } else {
            (residual.rms_m / count).sqrt()
        };
        residual
    }
}

fn minus_anchor(b: &mut ProgramBuilder, slot: usize, position: [Value; 3]) -> [Value; 3] {
    std::array::from_fn(|lane| {
        let anchor = b.constant(4 * slot + lane);
        b.subtract(position[lane], anchor)
    })
}

/// Position about the body's centre from clip x, negative clip y and depth.
fn inverse_steps(
    b: &mut ProgramBuilder,
    depth_format: &DepthFormat,
    [clip_x, down, depth]: [Value; 3],
) -> [Value; 3] {
    let clip_y = b.negate(down);
    let depth = if depth_format.mapping() == DepthMapping::Logarithmic {
        let distance = depth_format.distance_steps(b, 1, depth);
        let near = b.constant(4);
        b.divide(near, distance)
    } else {
        depth
    };
    let position = [2, 3, 4].map(|slot| affine(b, 4 * slot, [clip_x, clip_y, depth]));
    let [alpha, beta] = [b.constant(4 * 5 + 2), b.constant(4 * 5 + 3)];
    let w = b.fma(alpha, depth, beta);
    position.map(|component| b.divide(component, w))
}

/// Centres of 13 × 13 pixels from corner to corner.
fn pixel_grid([width, height]: [u32; 2]) -> impl Iterator<Item = [f64; 2]> {
    const STEPS: u32 = 12;
    let at = |i: u32, size: u32| f64::from(i * (size - 1) / STEPS) + 0.5;
    (0..=STEPS).flat_map(move |j| (0..=STEPS).map(move |i| [at(i, width), at(j, height)]))
}

/// How a vertex's position is stored and made relative to the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VertexFormat {
    /// `f32` about the body's centre, minus the eye in `f32`: 12 bytes.
    EcefF32,
    /// Multiples of 65536 m and the rest, both `f32`, subtracted separately: 24 bytes. As Cesium
    /// splits (`EncodedCartesian3`).
    SplitAt65536,
    /// `f32` and what it rounded away, both `f32`, subtracted separately: 24 bytes.
    TwoFloat,
    /// The same bytes as [`Self::TwoFloat`], added before the eye is subtracted: what is left if a
    /// compiler reassociates the sums, as WGSL lets it.
    TwoFloatReassociated,
    /// `f32` from the region's anchor, minus the eye from there: 12 bytes.
    RegionLocalF32,
    /// Integers of a power-of-two unit from the region's anchor, the eye subtracted in integers: 12
    /// bytes.
    RegionFixedPoint,
}

impl VertexFormat {
    /// Every format.
    pub const ALL: [Self; 6] = [
        Self::EcefF32,
        Self::SplitAt65536,
        Self::TwoFloat,
        Self::TwoFloatReassociated,
        Self::RegionLocalF32,
        Self::RegionFixedPoint,
    ];

    /// Stable name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::EcefF32 => "ecef-f32",
            Self::SplitAt65536 => "split-65536",
            Self::TwoFloat => "two-float",
            Self::TwoFloatReassociated => "two-float-reassociated",
            Self::RegionLocalF32 => "region-local-f32",
            Self::RegionFixedPoint => "region-fixed-point",
        }
    }

    /// Bytes per vertex.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::SplitAt65536 | Self::TwoFloat | Self::TwoFloatReassociated => 24,
            Self::EcefF32 | Self::RegionLocalF32 | Self::RegionFixedPoint => 12,
        }
    }

    /// Position minus the eye as the vertex shader has it in `f32`, metres, ECEF axes.
    ///
    /// - `origin_ecef`: the region's, for the formats that are local to one
    /// - `extent_m`: no vertex of the region is further from the origin along any axis
    #[must_use]
    pub fn emulate(
        &self,
        vertex_ecef: DVec3,
        eye_ecef: DVec3,
        origin_ecef: DVec3,
        extent_m: f64,
    ) -> [f32; 3] {
        let unit_m = fixed_point_unit_m(extent_m);
        std::array::from_fn(|axis| {
            let (p, e, o) = (vertex_ecef[axis], eye_ecef[axis], origin_ecef[axis]);
            self.component(p, e, o, unit_m)
        })
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounding to what the GPU reads is the purpose"
    )]
    fn component(self, p: f64, e: f64, o: f64, unit_m: f64) -> f32 {
        let split = |x: f64| {
            let high = (x / 65536.0).trunc() * 65536.0;
            (high as f32, (x - high) as f32)
        };
        let two_float = |x: f64| (x as f32, (x - f64::from(x as f32)) as f32);
        match self {
            Self::EcefF32 => p as f32 - e as f32,
            Self::SplitAt65536 => {
                let ((high, low), (eye_high, eye_low)) = (split(p), split(e));
                (high - eye_high) + (low - eye_low)
            }
            Self::TwoFloat => {
                let ((high, low), (eye_high, eye_low)) = (two_float(p), two_float(e));
                (high - eye_high) + (low - eye_low)
            }
            Self::TwoFloatReassociated => {
                let ((high, low), (eye_high, eye_low)) = (two_float(p), two_float(e));
                (high + low) - (eye_high + eye_low)
            }
            Self::RegionLocalF32 => (p - o) as f32 - (e - o) as f32,
            Self::RegionFixedPoint => {
                // In i64 where the frame shifts both by as many bits as make it fit in i32: the
                // difference only shows for an eye so far that a unit is below an f32's step.
                let stored = ((p - o) / unit_m).round() as i64;
                let eye = (e - o) / unit_m;
                let whole = eye.floor();
                let remainder = ((eye - whole) * unit_m) as f32;
                ((stored - whole as i64) as f32).mul_add(unit_m as f32, -remainder)
            }
        }
    }

    /// Bound of the error of one component of [`Self::emulate`], metres.
    ///
    /// - `radius_m`: no vertex and no eye is further from the body's centre along any axis
    /// - `extent_m`: no vertex is further from the region's origin along any axis
    /// - `distance_m`: nor from the eye
    #[must_use]
    pub fn residual_m(&self, radius_m: f64, extent_m: f64, distance_m: f64) -> f64 {
        let roundings = self.roundings(radius_m, extent_m, distance_m);
        roundings.iter().map(|(times, half)| times * half).sum()
    }

    /// Root mean square of the same, were all roundings even and independent, metres.
    ///
    /// Numbers are spread up to the limits that are given, and half of them round by half as much: a
    /// rounding's square is taken for three quarters of its largest.
    #[must_use]
    pub fn residual_rms_m(&self, radius_m: f64, extent_m: f64, distance_m: f64) -> f64 {
        let roundings = self.roundings(radius_m, extent_m, distance_m);
        let variance = roundings
            .iter()
            .map(|(times, half)| 0.75 * times * half * half / 3.0);
        variance.sum::<f64>().sqrt()
    }

    /// What is rounded, how often, and by how much at most.
    fn roundings(self, radius_m: f64, extent_m: f64, distance_m: f64) -> Vec<(f64, f64)> {
        // Every difference is rounded once in the end.
        let difference = half_ulp(distance_m);
        match self {
            Self::EcefF32 | Self::TwoFloatReassociated => {
                vec![(2.0, half_ulp(radius_m)), (1.0, difference)]
            }
            // Low parts reach 65536 m, and so does their difference, either way.
            Self::SplitAt65536 => vec![
                (2.0, half_ulp(65535.0)),
                (1.0, half_ulp(2.0 * 65535.0)),
                (1.0, difference),
            ],
            // Half an ULP of the radius: the largest low part; twice that, their difference.
            Self::TwoFloat => vec![
                (2.0, half_ulp(half_ulp(radius_m))),
                (1.0, half_ulp(2.0 * half_ulp(radius_m))),
                (2.0, difference),
            ],
            Self::RegionLocalF32 => vec![
                (1.0, half_ulp(extent_m)),
                (1.0, half_ulp(extent_m + distance_m)),
                (1.0, difference),
            ],
            // Storing; the remainder in f32; the integer difference to f32; the last sum.
            Self::RegionFixedPoint => {
                let unit_m = fixed_point_unit_m(extent_m);
                vec![
                    (1.0, 0.5 * unit_m),
                    (1.0, half_ulp(unit_m)),
                    (1.0, half_ulp(distance_m + unit_m)),
                    (1.0, difference),
                ]
            }
        }
    }
}

/// Power of two at or above extent / 2³⁰, as `frame::FixedPoint` has it.
fn fixed_point_unit_m(extent_m: f64) -> f64 {
    (extent_m / f64::from(1_u32 << 30)).log2().ceil().exp2()
}
