// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes: every way from an offset to longitude and latitude, under a stable name.

use crate::angle::TINY;
use crate::angle_core::AngleCore;
use crate::charts::Chart;
use crate::latitude::LatitudeForm;
use crate::operations::{Arithmetic, Operations, Program, ProgramBuilder, Value};
use crate::region::MapRegion;
use crate::residual::{RESIDUAL_SAMPLES, Residual, residual_of};
use crate::rounding::vectors;

/// Which quantities the angles are taken of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleForm {
    /// Position in `f32`, longitude and latitude of it, the anchor's latitude subtracted: what every
    /// globe does first, and off by metres, since an `f32` longitude of π has a step of 1.5 m.
    Absolute,
    /// Angles between the anchor's directions and the position's, of differences alone: nothing
    /// cancels, so the error shrinks with the region.
    Recentred,
    /// The recentred form without octants: for points less than 45° from the anchor in both angles.
    Near,
}

impl AngleForm {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::Absolute, Self::Recentred, Self::Near];

    /// Prefix of a route's name.
    #[must_use]
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Absolute => "",
            Self::Recentred => "recentred-",
            Self::Near => "near-",
        }
    }
}

/// A way from a fragment's offset to longitude and latitude, both relative to the anchor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoordinateRoute {
    /// Two arctangents.
    Angles {
        /// Of absolute positions or of differences.
        form: AngleForm,
        /// How an arctangent is computed.
        core: AngleCore,
        /// Which latitude.
        latitude: LatitudeForm,
    },
    /// A chart fitted to the region, or a cube texture.
    Chart(Chart),
}

impl CoordinateRoute {
    /// Every route.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for form in AngleForm::ALL {
            for core in AngleCore::all() {
                all.extend(LatitudeForm::ALL.map(|latitude| Self::Angles {
                    form,
                    core,
                    latitude,
                }));
            }
        }
        all.extend(Chart::all().map(Self::Chart));
        all
    }

    /// Stable name: form, core and latitude, as in `recentred-odd-7+bowring-1`, or the chart's.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Angles {
                form,
                core,
                latitude,
            } => format!("{}{}+{}", form.prefix(), core.name(), latitude.name()),
            Self::Chart(chart) => chart.name(),
        }
    }

    /// The route called `name`; angles without a latitude take one step of Bowring's.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let full = if name.contains('+') {
            name.to_owned()
        } else {
            format!("{name}+{}", LatitudeForm::Bowring1.name())
        };
        Self::all()
            .into_iter()
            .find(|route| route.name() == full || route.name() == name)
    }

    /// The route's steps: everything else here is read off them.
    #[must_use]
    pub fn program(&self) -> Program {
        match *self {
            Self::Angles {
                form: AngleForm::Absolute,
                core,
                latitude,
            } => absolute_program(core, latitude),
            Self::Angles {
                form,
                core,
                latitude,
            } => recentred_program(form, core, latitude),
            Self::Chart(chart) => chart.program(),
        }
    }

    /// The region's constants for the shader, computed in `f64`; as many as the program reads.
    #[must_use]
    pub fn constants(&self, region: &MapRegion) -> Vec<[f32; 4]> {
        let (form, latitude) = match *self {
            Self::Angles { form, latitude, .. } => (form, latitude),
            Self::Chart(chart) => return chart.constants(region),
        };
        let lanes = match form {
            AngleForm::Absolute => absolute_constants(region),
            AngleForm::Recentred | AngleForm::Near => recentred_constants(region, latitude),
        };
        let mut vectors = vectors(&lanes);
        vectors.truncate(self.program().constant_vectors());
        vectors
    }

    /// WGSL that defines `struct RouteConstants` and
    /// `fn route_angles(d: vec3f, constants: RouteConstants) -> vec2f`; see [`Program::wgsl`].
    #[must_use]
    pub fn wgsl(&self) -> String {
        self.program().wgsl()
    }

    /// The shader's steps in `f32` on the CPU, `fma` rounded once; see [`Program::emulate`], which
    /// is the one to call for many places.
    #[must_use]
    pub fn emulate(&self, constants: &[[f32; 4]], offset_m: [f32; 3]) -> [f32; 2] {
        self.program()
            .emulate(constants, offset_m, Arithmetic::Fused)
    }

    /// Error over `region`, computed.
    #[must_use]
    pub fn residual(&self, region: &MapRegion) -> Residual {
        let constants = self.constants(region);
        residual_of(&self.program(), &constants, region, RESIDUAL_SAMPLES)
    }

    /// Operations by kind, both angles together.
    #[must_use]
    pub fn operations(&self) -> Operations {
        self.program().operations()
    }
}

fn builder(core: AngleCore) -> ProgramBuilder {
    core.table()
        .map_or_else(ProgramBuilder::new, ProgramBuilder::with_table)
}

/// Constants of the absolute form, one scalar each.
mod absolute {
    /// Distance of the anchor from the axis, metres.
    pub(super) const RHO: usize = 0;
    /// Its height over the equator's plane, metres.
    pub(super) const Z: usize = 1;
    /// Its latitude, radians.
    pub(super) const LATITUDE: usize = 2;
    /// `1 − e²`
    pub(super) const PARAMETRIC: usize = 3;
    /// `1 − f`
    pub(super) const AXIS_RATIO: usize = 4;
    /// `e² a`, metres.
    pub(super) const EVOLUTE_RHO: usize = 5;
    /// `e′² b`, metres.
    pub(super) const EVOLUTE_Z: usize = 6;
}

fn absolute_constants(region: &MapRegion) -> Vec<f64> {
    let body = region.body();
    let anchor = region.anchor_meridian();
    let e2 = body.eccentricity_squared();
    let mut lanes = vec![0.0; 8];
    lanes[absolute::RHO] = anchor.x;
    lanes[absolute::Z] = anchor.z;
    lanes[absolute::LATITUDE] = region.anchor_latitude_rad();
    lanes[absolute::PARAMETRIC] = 1.0 - e2;
    lanes[absolute::AXIS_RATIO] = body.polar_radius_m() / body.equatorial_radius_m();
    lanes[absolute::EVOLUTE_RHO] = e2 * body.equatorial_radius_m();
    lanes[absolute::EVOLUTE_Z] = e2 / (1.0 - e2) * body.polar_radius_m();
    lanes
}

/// Longitude and latitude of the position itself, in `f32` from the first addition on.
fn absolute_program(core: AngleCore, latitude: LatitudeForm) -> Program {
    let mut builder = builder(core);
    let b = &mut builder;
    let [dx, y, dz] = b.offset();
    let (anchor_rho, anchor_z) = (b.constant(absolute::RHO), b.constant(absolute::Z));
    let x = b.add(dx, anchor_rho);
    let z = b.add(dz, anchor_z);
    let longitude = core.full(b, y, x);
    let rho = length(b, x, y);
    let (along_rho, along_z) = match latitude {
        LatitudeForm::Geocentric => (rho, z),
        LatitudeForm::Parametric => {
            let scale = b.constant(absolute::PARAMETRIC);
            (b.multiply(scale, rho), z)
        }
        LatitudeForm::Bowring1 | LatitudeForm::Bowring2 => {
            let ratio = b.constant(absolute::AXIS_RATIO);
            // tan β = z / ((1 − f) ρ), and from the first normal (1 − f) V_z / V_ρ.
            let scaled_rho = b.multiply(ratio, rho);
            let mut normal = bowring_step(b, [rho, z], [scaled_rho, z]);
            for _ in 1..latitude.bowring_steps() {
                let scaled_z = b.multiply(ratio, normal[1]);
                normal = bowring_step(b, [rho, z], [normal[0], scaled_z]);
            }
            (normal[0], normal[1])
        }
    };
    let absolute_latitude = core.right_half(b, along_z, along_rho);
    let anchor_latitude = b.constant(absolute::LATITUDE);
    let latitude = b.subtract(absolute_latitude, anchor_latitude);
    builder.finish(longitude, latitude)
}

/// The normal's direction (ρ, z) by Bowring's step from the direction of the parametric latitude.
fn bowring_step(b: &mut ProgramBuilder, position: [Value; 2], beta: [Value; 2]) -> [Value; 2] {
    let inverse = inverse_length(b, beta[0], beta[1]);
    let (cos, sin) = (b.multiply(beta[0], inverse), b.multiply(beta[1], inverse));
    let (cos_cubed, sin_cubed) = (cube(b, cos), cube(b, sin));
    let evolute_rho = b.constant(absolute::EVOLUTE_RHO);
    let evolute_z = b.constant(absolute::EVOLUTE_Z);
    let inward = b.negate(evolute_rho);
    [
        b.fma(inward, cos_cubed, position[0]),
        b.fma(evolute_z, sin_cubed, position[1]),
    ]
}

/// Constants of the recentred forms, one scalar each.
mod recentred {
    /// Distance of the anchor from the axis, metres.
    pub(super) const RHO: usize = 0;
    /// Direction of the latitude's vector at the anchor.
    pub(super) const COS: usize = 1;
    pub(super) const SIN: usize = 2;
    /// Length of that vector, metres.
    pub(super) const LENGTH: usize = 3;
    /// `1 − e²`
    pub(super) const PARAMETRIC: usize = 4;
    /// `1 − f`
    pub(super) const AXIS_RATIO: usize = 5;
    /// `e² a`, metres.
    pub(super) const EVOLUTE_RHO: usize = 6;
    /// `e′² b`, metres.
    pub(super) const EVOLUTE_Z: usize = 7;
    /// Parametric latitude of the anchor.
    pub(super) const COS_BETA: usize = 8;
    pub(super) const SIN_BETA: usize = 9;
    /// Length of `((1 − f) ρ, z)` at the anchor, which is b, metres.
    pub(super) const BETA_LENGTH: usize = 10;
    /// Length of `(V_ρ, (1 − f) V_z)` at the anchor, metres.
    pub(super) const SECOND_LENGTH: usize = 11;
}

fn recentred_constants(region: &MapRegion, latitude: LatitudeForm) -> Vec<f64> {
    let body = region.body();
    let anchor = region.anchor_meridian();
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let e2 = body.eccentricity_squared();
    let (sin_lat, cos_lat) = region.anchor_latitude_rad().sin_cos();
    // The normal's vector at the anchor, from the foot that the form measures at.
    let curvature = a * (1.0 - e2) / (1.0 - e2 * sin_lat * sin_lat).powf(1.5);
    let (along_rho, along_z) = match latitude {
        LatitudeForm::Geocentric => (anchor.x, anchor.z),
        LatitudeForm::Parametric => ((1.0 - e2) * anchor.x, anchor.z),
        LatitudeForm::Bowring1 | LatitudeForm::Bowring2 => {
            (curvature * cos_lat, curvature * sin_lat)
        }
    };
    let length = along_rho.hypot(along_z);
    let ratio = b / a;
    let (cos_beta, sin_beta) = (anchor.x / a, anchor.z / b);
    let mut lanes = vec![0.0; 12];
    lanes[recentred::RHO] = anchor.x;
    lanes[recentred::COS] = along_rho / length;
    lanes[recentred::SIN] = along_z / length;
    lanes[recentred::LENGTH] = length;
    lanes[recentred::PARAMETRIC] = 1.0 - e2;
    lanes[recentred::AXIS_RATIO] = ratio;
    lanes[recentred::EVOLUTE_RHO] = e2 * a;
    lanes[recentred::EVOLUTE_Z] = e2 / (1.0 - e2) * b;
    lanes[recentred::COS_BETA] = cos_beta;
    lanes[recentred::SIN_BETA] = sin_beta;
    lanes[recentred::BETA_LENGTH] = b;
    lanes[recentred::SECOND_LENGTH] = along_rho.hypot(ratio * along_z);
    lanes
}

/// Angles between the anchor's directions and the position's.
///
/// With longitude 0 through the anchor, `Δλ = atan2(y, ρ₀ + dx)` has nothing to cancel, and
/// `ρ − ρ₀ = dx + y² / (ρ + x)`. For a vector V of the meridian whose direction at the anchor is
/// n₀, `Δφ = atan2(dV × n₀, |V₀| + dV · n₀)`: V₀ × n₀ = 0 is left out of the sum instead of
/// cancelling in it. Geocentric and parametric latitudes have dV = (dρ, dz) and ((1 − e²) dρ, dz).
/// Bowring's adds the change of the centre of curvature, `e′² b (sin³ β − sin³ β₀)`, factored into
/// differences of β the same way.
fn recentred_program(form: AngleForm, core: AngleCore, latitude: LatitudeForm) -> Program {
    let mut builder = builder(core);
    let b = &mut builder;
    let [dx, y, dz] = b.offset();
    let anchor_rho = b.constant(recentred::RHO);
    let x = b.add(dx, anchor_rho);
    let rho = length(b, x, y);
    let y_squared = b.multiply(y, y);
    let sum = b.add(rho, x);
    let rho_change = if form == AngleForm::Near {
        let bow = b.divide(y_squared, sum);
        b.add(dx, bow)
    } else {
        // Behind the axis ρ + x cancels, and ρ − ρ₀ does not.
        let divisor = above_zero(b, sum);
        let bow = b.divide(y_squared, divisor);
        let before = b.add(dx, bow);
        let behind = b.subtract(rho, anchor_rho);
        let zero = b.literal(0.0);
        b.select_less(x, zero, behind, before)
    };
    let change = match latitude {
        LatitudeForm::Geocentric => [rho_change, dz],
        LatitudeForm::Parametric => {
            let scale = b.constant(recentred::PARAMETRIC);
            [b.multiply(scale, rho_change), dz]
        }
        LatitudeForm::Bowring1 | LatitudeForm::Bowring2 => {
            let ratio = b.constant(recentred::AXIS_RATIO);
            let position = [rho_change, dz];
            let scaled_rho = b.multiply(ratio, rho_change);
            let first_length = b.constant(recentred::BETA_LENGTH);
            let mut normal = bowring_change(b, form, position, [scaled_rho, dz], first_length);
            for _ in 1..latitude.bowring_steps() {
                let scaled_z = b.multiply(ratio, normal[1]);
                let next_length = b.constant(recentred::SECOND_LENGTH);
                normal = bowring_change(b, form, position, [normal[0], scaled_z], next_length);
            }
            normal
        }
    };
    let (cos, sin) = (b.constant(recentred::COS), b.constant(recentred::SIN));
    let anchor_length = b.constant(recentred::LENGTH);
    let (across, along) = turned(b, change, cos, sin, anchor_length);
    let angle = |b: &mut ProgramBuilder, y, x| match form {
        AngleForm::Near => core.near(b, y, x),
        AngleForm::Absolute | AngleForm::Recentred => core.full(b, y, x),
    };
    let longitude = angle(b, y, x);
    let latitude = angle(b, across, along);
    builder.finish(longitude, latitude)
}

/// A vector's change (ρ, z) in the frame of its direction at the anchor: across it, and along it with
/// its length there added.
fn turned(
    b: &mut ProgramBuilder,
    change: [Value; 2],
    cos: Value,
    sin: Value,
    length: Value,
) -> (Value, Value) {
    let [rho, z] = change;
    let from_rho = b.multiply(rho, sin);
    let from_rho = b.negate(from_rho);
    let across = b.fma(z, cos, from_rho);
    let along = b.fma(rho, cos, length);
    (across, b.fma(z, sin, along))
}

/// Change of the normal's vector since the anchor, by Bowring's step.
///
/// - `position`: change of (ρ, z)
/// - `beta`: change of the vector whose direction is the parametric latitude
/// - `beta_length`: that vector's length at the anchor
fn bowring_change(
    b: &mut ProgramBuilder,
    form: AngleForm,
    position: [Value; 2],
    beta: [Value; 2],
    beta_length: Value,
) -> [Value; 2] {
    let (cos0, sin0) = (
        b.constant(recentred::COS_BETA),
        b.constant(recentred::SIN_BETA),
    );
    let (across, along) = turned(b, beta, cos0, sin0, beta_length);
    let inverse = inverse_length(b, across, along);
    let (sin, cos) = (b.multiply(across, inverse), b.multiply(along, inverse));
    // cos δβ − 1 = −sin² δβ / (1 + cos δβ), without cancelling; beyond 90° the difference itself does
    // not cancel, and the fraction would.
    let one = b.literal(1.0);
    let one_more = b.add(one, cos);
    let square = b.multiply(sin, sin);
    let fall = if form == AngleForm::Near {
        let fraction = b.divide(square, one_more);
        b.negate(fraction)
    } else {
        let divisor = b.maximum(one_more, one);
        let fraction = b.divide(square, divisor);
        let close = b.negate(fraction);
        let far = b.subtract(cos, one);
        let zero = b.literal(0.0);
        b.select_less(cos, zero, far, close)
    };
    // sin β − sin β₀ and cos β − cos β₀.
    let part = b.multiply(sin0, fall);
    let sin_change = b.fma(cos0, sin, part);
    let part = b.multiply(cos0, fall);
    let back = b.negate(sin);
    let cos_change = b.fma(sin0, back, part);
    let evolute_rho = b.constant(recentred::EVOLUTE_RHO);
    let evolute_z = b.constant(recentred::EVOLUTE_Z);
    let inward = b.negate(evolute_rho);
    let cubes = [
        cube_change(b, cos0, cos_change),
        cube_change(b, sin0, sin_change),
    ];
    [
        b.fma(inward, cubes[0], position[0]),
        b.fma(evolute_z, cubes[1], position[1]),
    ]
}

/// `(s + d)³ − s³ = d (3 s (s + d) + d²)`
fn cube_change(b: &mut ProgramBuilder, start: Value, change: Value) -> Value {
    let end = b.add(start, change);
    let three = b.literal(3.0);
    let triple = b.multiply(three, start);
    let square = b.multiply(change, change);
    let factor = b.fma(triple, end, square);
    b.multiply(change, factor)
}

fn cube(b: &mut ProgramBuilder, a: Value) -> Value {
    let square = b.multiply(a, a);
    b.multiply(square, a)
}

fn length(b: &mut ProgramBuilder, x: Value, y: Value) -> Value {
    let square = b.multiply(y, y);
    let square = b.fma(x, x, square);
    b.square_root(square)
}

/// One over the length; at the origin a large finite number, so that nothing becomes NaN.
fn inverse_length(b: &mut ProgramBuilder, x: Value, y: Value) -> Value {
    let square = b.multiply(y, y);
    let square = b.fma(x, x, square);
    let square = above_zero(b, square);
    b.inverse_square_root(square)
}

/// The value, or 2⁻¹⁰⁰ where it is smaller.
fn above_zero(b: &mut ProgramBuilder, value: Value) -> Value {
    let tiny = b.literal(TINY);
    b.maximum(value, tiny)
}
