// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral in `f64`, which `globes/spiral.wgsl` follows in `f32`.

use super::heights::HeightCube;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, TAU};
use std::sync::Arc;
use terrafill_globe_views::Eye;

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
pub(crate) fn per_octave(per_turn: u32) -> f64 {
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
        number
            .checked_sub(1)
            .map_or(DVec3::ZERO, |k| self.way_at(k, self.radius(k)))
    }

    /// To what is so many radians off, in the direction of vertex `k` of the turns.
    fn way_at(&self, k: u32, radius: f64) -> DVec3 {
        let angle = TAU * f64::from(k % self.per_turn) / f64::from(self.per_turn);
        let [east, north, up] = self.axes;
        let level = east * angle.sin() + north * angle.cos();
        level * radius.sin() - up * (2.0 * (0.5 * radius).sin().powi(2))
    }

    fn radius(&self, k: u32) -> f64 {
        let share = (f64::from(k) / f64::from(self.per_turn) / self.turns).min(1.0);
        let (inner, outer) = (self.inner, self.outer);
        match self.law {
            Law::Exponential => inner * (outer / inner).powf(share),
            Law::Quadratic => (inner.sqrt() + share * (outer.sqrt() - inner.sqrt())).powi(2),
            Law::Published => corrected([self.stored(k), inner, outer]),
        }
    }

    fn stored(&self, k: u32) -> f64 {
        stored_radius(self.first + k, self.per_turn)
    }

    /// How far a vertex may be off because radii are kept in `f32`, metres: near the fan's rim the published root
    /// magnifies how they are rounded. The first one is stored as the rim itself is, and rounded alike.
    pub(crate) fn rounding_m(&self, number: u32) -> f64 {
        let Some(k) = number.checked_sub(2).filter(|_| self.law == Law::Published) else {
            return 0.0;
        };
        let k = k + 1;
        let kept = [self.stored(k), self.inner, self.outer];
        let here = corrected(kept);
        let off = (0..kept.len()).map(|which| {
            let moved = [-HALF_ULP, HALF_ULP].map(|by| {
                let mut kept = kept;
                kept[which] *= 1.0 + by;
                (corrected(kept) - here).abs()
            });
            moved[0].max(moved[1])
        });
        let off: f64 = off.sum();
        (self.way_at(k, here + off) - self.way_at(k, here)).length()
    }
}

/// Half the distance between numbers in `f32`, as a share of theirs, at most.
const HALF_ULP: f64 = 0.5 * f32::EPSILON as f64;

/// The published correction of a stored radius, between an inner circle and an outer one.
fn corrected([stored, inner, outer]: [f64; 3]) -> f64 {
    let (stored, span) = (stored.min(outer), outer - inner);
    ((stored - inner) / span).max(0.0).sqrt() * span + inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::list::List;
    use terrafill_core::nearest_f32;

    #[test]
    fn radii_in_single_precision_move_published_vertices_by_no_more_than_is_allowed() {
        let list = List::shipped().expect("a list");
        for view in ["globe", "nadir-1161km", "oblique-100km", "ground-1.7m"] {
            let eye = list.view(view).expect("the view").eye(160);
            let spiral = Spiral::new(&eye, 72, Law::Published, None);
            let mut largest_m = 0.0_f64;
            for number in 2..spiral.count() {
                let k = number - 1;
                let exact = [spiral.stored(k), spiral.inner, spiral.outer];
                let kept = exact.map(|radius| f64::from(nearest_f32(radius)));
                let [here, off] = [exact, kept].map(|radii| spiral.way_at(k, corrected(radii)));
                let off_m = here.distance(off);
                let allowed_m = spiral.rounding_m(number);
                assert!(
                    off_m <= allowed_m + 1e-9,
                    "{view} {number}: {off_m} {allowed_m}"
                );
                largest_m = largest_m.max(off_m / allowed_m);
            }
            // Negative control: it is no bound from far away.
            assert!(largest_m > 0.1, "{view}: {largest_m}");
            let other = Spiral::new(&eye, 72, Law::Exponential, None);
            assert_eq!(other.rounding_m(7), 0.0);
        }
    }
}
