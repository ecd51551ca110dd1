// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a vertex of the spiral is, relative to the eye, by the forms that a vertex shader may use.
//!
//! In the space scaled by 1/radii the body is the unit sphere, so that every form is exact on an
//! ellipsoid. There U is the direction to the focus, and E and N are its east and north. A vertex of the angle
//! θ and the radius r is `(E sin θ + N cos θ) sin r + U cos r`.
//!
//! Single precision is emulated: each operation is done in `f64` and rounded to `f32`. For sum, difference,
//! product, quotient and root that is the `f32` operation itself, since 53 ≥ 2·24 + 2 bits (Figueroa, 1995).
//! Sine and cosine are rounded from `f64`; a device's are worse.

use glam::{DMat3, DVec3};
use std::f64::consts::PI;
use terrafill_core::{Ellipsoid, nearest_f32};

/// How a vertex is computed from its angle, its radius and the focus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// The paper's first version: longitude and latitude of the focus plus the offset, in degrees, then to a
    /// place relative to the centre, less the eye. The paper does not divide by cos φ.
    LonLat,
    /// Its final version: a hemisphere rotated to the focus, relative to the centre, less the eye.
    Hemisphere,
    /// Relative to the focus and along its own east, north and up, with cos r − 1 formed by a subtraction,
    /// plus the focus relative to the eye from `f64`.
    Local,
    /// The same with −2 sin²(r/2), in which nothing cancels.
    LocalSin2,
}

impl Form {
    pub(crate) const ALL: [(&'static str, Self); 4] = [
        ("lonlat", Self::LonLat),
        ("hemisphere", Self::Hemisphere),
        ("local", Self::Local),
        ("local-sin2", Self::LocalSin2),
    ];
}

/// Sine and cosine of the radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trig {
    Native,
    /// Highest powers of r in the sine and in the cosine.
    Taylor(u32, u32),
}

impl Trig {
    pub(crate) const ALL: [(&'static str, Self); 8] = [
        ("native", Self::Native),
        ("1/2", Self::Taylor(1, 2)),
        ("3/2", Self::Taylor(3, 2)),
        ("3/4", Self::Taylor(3, 4)),
        ("5/4", Self::Taylor(5, 4)),
        ("5/6", Self::Taylor(5, 6)),
        ("7/8", Self::Taylor(7, 8)),
        ("9/10", Self::Taylor(9, 10)),
    ];

    /// How far the length of (sin r, cos r) is from 1 at most, for r up to π/2: errors of these series grow
    /// with r.
    pub(crate) fn worst_length_error(self) -> f64 {
        let [sine, minus] = self.sine_and_cosine_minus_1(Arithmetic::F64, PI / 2.0, true);
        (sine - 1.0).abs() + (minus + 1.0).abs()
    }

    /// sin r and cos r − 1.
    fn sine_and_cosine_minus_1(self, f: Arithmetic, r: f64, is_squared: bool) -> [f64; 2] {
        match self {
            Self::Native if is_squared => {
                let half = f.round(f.round(r * 0.5).sin());
                [f.round(r.sin()), f.round(-2.0 * f.round(half * half))]
            }
            Self::Native => [f.round(r.sin()), f.round(f.round(r.cos()) - 1.0)],
            Self::Taylor(sine, cosine) => [f.series(r, 1, sine), f.series(r, 2, cosine)],
        }
    }
}

/// What each operation is rounded to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arithmetic {
    F64,
    /// In `f64`, from what a buffer of `f32` holds of angle and radius: what [`Arithmetic::F32`] would give without
    /// rounding.
    Buffer,
    F32,
}

impl Arithmetic {
    pub(crate) const ALL: [(&'static str, Self); 3] = [
        ("f64", Self::F64),
        ("buffer", Self::Buffer),
        ("f32", Self::F32),
    ];

    /// What a buffer keeps of an attribute.
    fn stored(self, value: f64) -> f64 {
        match self {
            Self::F64 => value,
            Self::Buffer | Self::F32 => Self::F32.round(value),
        }
    }

    fn round(self, value: f64) -> f64 {
        match self {
            Self::F64 | Self::Buffer => value,
            Self::F32 => f64::from(nearest_f32(value)),
        }
    }

    fn vector(self, v: DVec3) -> DVec3 {
        DVec3::new(self.round(v.x), self.round(v.y), self.round(v.z))
    }

    /// a · x + b · y, each operation rounded.
    fn combine(self, a: DVec3, x: f64, b: DVec3, y: f64) -> DVec3 {
        self.vector(self.vector(a * x) + self.vector(b * y))
    }

    /// Terms of the sine (`first` 1) or of the cosine (`first` 2) of r up to the power `last`, by Horner's
    /// scheme.
    fn series(self, r: f64, first: u32, last: u32) -> f64 {
        let square = self.round(r * r);
        let mut sum = 0.0;
        let mut power = last;
        while power >= first.max(1) {
            let next = f64::from((power + 1) * (power + 2));
            let share = self.round(square / next);
            sum = self.round(1.0 - self.round(share * sum));
            if power < first + 2 {
                break;
            }
            power -= 2;
        }
        match first {
            1 => self.round(r * sum),
            _ => self.round(self.round(-0.5 * square) * sum),
        }
    }
}

/// A vertex as its buffer holds it: the paper's form, which needs no inverse trigonometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Attributes {
    /// Of the angle clockwise from north.
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
    /// Angle at the centre, in scaled space, radians.
    pub(crate) radius: f64,
}

impl Attributes {
    pub(crate) fn new(f: Arithmetic, angle_rad: f64, radius: f64) -> Self {
        let (sine, cosine) = angle_rad.sin_cos();
        Self {
            sine: f.stored(sine),
            cosine: f.stored(cosine),
            radius: f.stored(radius),
        }
    }
}

/// The point that the spiral turns around.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Focus {
    radii: DVec3,
    eye_ecef: DVec3,
    /// From the centre to the focus, in scaled space.
    up: DVec3,
    /// Scaled to metres, east, north and up as columns.
    axes: DMat3,
    /// Rows are the focus's own east, north and normal of the ellipsoid, in which what is near the focus has
    /// small numbers.
    local_from_ecef: DMat3,
    /// Relative to the eye, metres.
    focus_rte: DVec3,
}

impl Focus {
    /// Below the eye in scaled space: where the line from the eye to the centre meets the body.
    pub(crate) fn new(body: &Ellipsoid, eye_ecef: DVec3) -> Self {
        let radii = body.radii_m();
        let scaled = eye_ecef / radii;
        let distance = scaled.length();
        let up = scaled / distance;
        let across = up.x.hypot(up.y);
        // At a pole every direction is south or north; that of longitude 0 is east.
        let east = if across > 0.0 {
            DVec3::new(-up.y / across, up.x / across, 0.0)
        } else {
            DVec3::Y
        };
        let axes = DMat3::from_cols(east * radii, up.cross(east) * radii, up * radii);
        // Along the ellipsoid, east and north stay at right angles when they are scaled.
        let (own_east, own_north) = (axes.x_axis.normalize(), axes.y_axis.normalize());
        let own = DMat3::from_cols(own_east, own_north, own_east.cross(own_north));
        Self {
            radii,
            eye_ecef,
            up,
            axes,
            local_from_ecef: own.transpose(),
            // eye · (1/d − 1), without the difference of two places.
            focus_rte: eye_ecef * ((1.0 - distance) / distance),
        }
    }

    /// A vertex relative to the eye, metres.
    pub(crate) fn vertex_rte(
        &self,
        (form, trig, f): (Form, Trig, Arithmetic),
        vertex: Attributes,
    ) -> DVec3 {
        if form == Form::LonLat {
            return self.by_degrees(f, vertex);
        }
        let Attributes {
            sine,
            cosine,
            radius,
        } = vertex;
        let [sin_r, cos_r_minus_1] =
            trig.sine_and_cosine_minus_1(f, radius, form == Form::LocalSin2);
        // Columns in metres, the same for all vertices.
        let columns = |axes: DMat3| [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| f.vector(a));
        let [a, b] = [sine, cosine].map(|share| f.round(share * sin_r));
        if form == Form::Hemisphere {
            let [east, north, up] = columns(self.axes);
            let cos_r = f.round(cos_r_minus_1 + 1.0);
            let ecef = f.combine(f.combine(east, a, north, b), 1.0, up, cos_r);
            return f.vector(ecef - f.vector(self.eye_ecef));
        }
        // The matrix that turns the local frame into the view's turns it to ECEF here.
        let [east, north, up] = columns(self.local_from_ecef * self.axes);
        let local = f.combine(f.combine(east, a, north, b), 1.0, up, cos_r_minus_1);
        let focus = f.vector(self.local_from_ecef * self.focus_rte);
        self.local_from_ecef.transpose() * f.vector(local + focus)
    }

    fn by_degrees(&self, f: Arithmetic, vertex: Attributes) -> DVec3 {
        let per_radian = f.round(180.0 / PI);
        let per_degree = f.round(PI / 180.0);
        let focus = [
            self.up.y.atan2(self.up.x),
            self.up.z.atan2(self.up.x.hypot(self.up.y)),
        ];
        let [longitude, latitude] =
            [(focus[0], vertex.sine), (focus[1], vertex.cosine)].map(|(at, share)| {
                let offset = f.round(f.round(share * vertex.radius) * per_radian);
                let degrees = f.round(f.round(at.to_degrees()) + offset);
                f.round(degrees * per_degree)
            });
        let [sin_lon, cos_lon, sin_lat, cos_lat] = [
            longitude.sin(),
            longitude.cos(),
            latitude.sin(),
            latitude.cos(),
        ]
        .map(|value| f.round(value));
        let unit = DVec3::new(
            f.round(cos_lat * cos_lon),
            f.round(cos_lat * sin_lon),
            sin_lat,
        );
        let ecef = f.vector(unit * f.vector(self.radii));
        f.vector(ecef - f.vector(self.eye_ecef))
    }
}
