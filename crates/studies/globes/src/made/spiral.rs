// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral in `f64`, which `globes/spiral.wgsl` follows in `f32`.

use super::heights::HeightCube;
use crate::list::Eye;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, TAU};
use std::sync::Arc;
use terrafill_core::nearest_f32;

/// Radius of the fan, pixels, and of the inner circle at most.
const FAN_PX: f64 = 50.0;
const MAX_INNER: f64 = 0.1;
/// The least radius of a vertex that is stored, radians: 6 mm on the Earth, within the fan of an eye 0.1 m above it.
const BASE: f64 = 1e-9;

terrafill_results::named! {
    /// Where vertices come from.
    all pub(crate) enum Source {
        /// The CPU makes and sends them.
        Sent = "sent",
        /// A compute shader makes them.
        Compute = "compute",
        /// The vertex stage makes them, from a vertex's number.
        Number = "number",
        /// The vertex stage makes them, from one buffer for all views (sine, cosine, radius): the paper's own method.
        Static = "static",
    }
}

terrafill_results::named! {
    /// How radii grow.
    pub(crate) enum Law {
        /// By the same factor.
        Exponential = "exponential",
        /// Their roots by equal steps.
        Quadratic = "quadratic",
        /// By the same factor where they are stored; corrected by a square root where they are drawn, as the paper does.
        Published = "published",
    }
}

terrafill_results::named! {
    /// How vertices find their heights in f32.
    pub(crate) enum Lookup {
        /// By their direction from the body's centre; the height is added to a place relative to the eye.
        Absolute = "absolute",
        /// By their way from the ground below the eye, whose own height and normal are differences' other side.
        Local = "local",
    }
}

/// Terrain under a spiral, and the ground below the eye.
#[derive(Debug, Clone)]
pub(crate) struct Relief {
    pub(crate) heights: Arc<HeightCube>,
    /// Height of the ground below the eye, metres.
    pub(crate) base_m: f64,
    /// That ground from the eye.
    pub(crate) ground: DVec3,
    /// Geodetic normal there.
    pub(crate) normal: DVec3,
}

/// A spiral in f64, which the shader follows.
#[derive(Debug, Clone)]
pub(crate) struct Spiral {
    /// East, north and up of the focus in scaled space, in metres.
    pub(crate) axes: [DVec3; 3],
    /// The focus from the eye.
    pub(crate) focus: DVec3,
    pub(crate) inner: f64,
    pub(crate) outer: f64,
    pub(crate) turns: f64,
    pub(crate) per_turn: u32,
    pub(crate) law: Law,
    /// Of all vertices that are stored, the first of this view.
    pub(crate) first: u32,
    pub(crate) radii: DVec3,
    pub(crate) relief: Option<Relief>,
}

/// Vertices for which the radius doubles: cells are square.
fn per_octave(per_turn: u32) -> f64 {
    f64::from(per_turn).powi(2) * LN_2 / TAU
}

/// Radius of a stored vertex, radians.
pub(crate) fn stored_radius(number: u32, per_turn: u32) -> f64 {
    BASE * (f64::from(number) / per_octave(per_turn)).exp2()
}

/// The last stored vertex that is not beyond a radius.
#[allow(
    clippy::cast_possible_truncation,
    reason = "some thousands of vertices"
)]
pub(crate) fn number_of(radius: f64, per_turn: u32) -> u32 {
    (per_octave(per_turn) * (radius / BASE).log2()).floor() as u32
}

/// acos(1/ratio) without its cancellation near 1: tan² = ratio² − 1.
fn angle_to(ratio: f64) -> f64 {
    ((ratio - 1.0) * (ratio + 1.0)).max(0.0).sqrt().atan()
}

impl Spiral {
    /// In closed form from a view: from the fan's rim to the horizon, in square cells. The fan's rim is the start of a
    /// turn of those that are stored, so that one buffer has the vertices of every view. Over terrain the focus is the
    /// foot of the eye's height: the line to the centre misses the ground below the eye by some metres. The horizon is
    /// that of the highest summit.
    pub(crate) fn new(
        eye: &Eye,
        per_turn: u32,
        law: Law,
        heights: Option<&Arc<HeightCube>>,
    ) -> Self {
        let radii = eye.body.radii_m();
        let scaled = eye.camera.eye_ecef / radii;
        let distance = scaled.length();
        let mut up = scaled / distance;
        // acos(1/d), and the eye's height in radii.
        let (mut outer, mut height) = (angle_to(distance), distance - 1.0);
        let mut focus = eye.camera.eye_ecef * ((1.0 - distance) / distance);
        let relief = heights.map(|heights| {
            let foot = eye.foot();
            let normal = (foot / radii).normalize();
            let base_m = heights.height_m(foot);
            let above_m = eye.pose.eye.height_m - base_m;
            let leaning = up.cross(foot).length().atan2(up.dot(foot));
            let summits = angle_to(1.0 + heights.highest_m / eye.body.polar_radius_m());
            outer = (outer + leaning + summits).min(FRAC_PI_2);
            height = above_m / eye.body.polar_radius_m();
            up = foot;
            focus = normal * -eye.pose.eye.height_m;
            Relief {
                heights: Arc::clone(heights),
                base_m,
                ground: normal * -above_m,
                normal,
            }
        });
        let across = up.x.hypot(up.y);
        let east = if across > 0.0 {
            DVec3::new(-up.y / across, up.x / across, 0.0)
        } else {
            DVec3::Y
        };
        let inner = (FAN_PX * height / eye.focal_px())
            .min(MAX_INNER)
            .min(0.5 * outer);
        let first = (number_of(inner, per_turn) / per_turn).max(1) * per_turn;
        let inner = stored_radius(first, per_turn);
        Self {
            axes: [east * radii, up.cross(east) * radii, up * radii],
            focus,
            inner,
            outer,
            turns: per_octave(per_turn) / f64::from(per_turn) * (outer / inner).log2(),
            per_turn,
            law,
            first,
            radii,
            relief,
        }
    }

    /// Vertices: the centre, and the turns.
    pub(crate) fn count(&self) -> u32 {
        self.rim() + self.per_turn + 1
    }

    /// The first vertex on the outer circle.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "some thousands of vertices"
    )]
    pub(crate) fn rim(&self) -> u32 {
        (self.turns * f64::from(self.per_turn)).ceil() as u32
    }

    /// Triangles that share every vertex: fan, one that closes it, strips.
    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
        let (n, rim) = (self.per_turn, self.rim());
        let at = |k: u32| k + 1;
        let mut triangles: Vec<[u32; 3]> = (0..n).map(|k| [0, at((k + 1) % n), at(k)]).collect();
        triangles.push([at(0), at(n), at(n - 1)]);
        for k in 0..rim {
            triangles.push([at(k), at(k + 1), at(k + n)]);
            if k + 1 < rim {
                triangles.push([at(k + 1), at(k + n + 1), at(k + n)]);
            }
        }
        triangles
    }

    /// A vertex from the eye, metres.
    pub(crate) fn place(&self, number: u32) -> DVec3 {
        let way = self.way(number);
        let Some(relief) = &self.relief else {
            return way + self.focus;
        };
        let direction = (self.axes[2] + way) / self.radii;
        let normal = (direction / self.radii).normalize();
        way + self.focus + normal * relief.heights.height_m(direction)
    }

    /// All vertices from the eye, metres.
    pub(crate) fn vertices(&self) -> Vec<[f32; 3]> {
        let places = (0..self.count()).map(|number| self.place(number));
        places.map(|place| place.as_vec3().to_array()).collect()
    }

    /// From the focus to a vertex on the body, metres.
    fn way(&self, number: u32) -> DVec3 {
        let Some(k) = number.checked_sub(1) else {
            return DVec3::ZERO;
        };
        let share = (f64::from(k) / f64::from(self.per_turn) / self.turns).min(1.0);
        let (inner, outer) = (self.inner, self.outer);
        let radius = match self.law {
            Law::Exponential => inner * (outer / inner).powf(share),
            Law::Quadratic => (inner.sqrt() + share * (outer.sqrt() - inner.sqrt())).powi(2),
            Law::Published => {
                // Of the radius as it is stored: near the fan's rim the root magnifies how it was rounded.
                let [inner, outer] = [inner, outer].map(|at| f64::from(nearest_f32(at)));
                let stored = nearest_f32(stored_radius(self.first + k, self.per_turn));
                let (stored, span) = (f64::from(stored).min(outer), outer - inner);
                ((stored - inner) / span).sqrt() * span + inner
            }
        };
        let angle = TAU * f64::from(k % self.per_turn) / f64::from(self.per_turn);
        let [east, north, up] = self.axes;
        let level = east * angle.sin() + north * angle.cos();
        level * radius.sin() - up * (2.0 * (0.5 * radius).sin().powi(2))
    }
}
