// SPDX-License-Identifier: MIT OR Apache-2.0
//! From where to where a view draws the spiral, in closed form.
//!
//! Angles at the centre in scaled space, radians. There the body is the unit sphere and the eye is `d` from
//! its centre, so the horizon is `acos(1/d)` away.

use crate::layout::Steps;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use terrafill_core::Ellipsoid;
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::HeightRange;

/// Largest inner radius: from far away a fan of some pixels would be as wide as the globe, and the worst
/// piece of the mesh.
pub(crate) const MAX_INNER: f64 = 0.1;
/// Smallest one, for an eye nearly on the ground: a thirtieth of a metre on the Earth.
const MIN_INNER: f64 = 5e-9;
/// Rounds in which the rim moves out by what its facets hang down. Each brings at most a quarter of the
/// change of the one before, from twelve vertices a turn on.
const ROUNDS: u32 = 12;

/// Where the mesh ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rim {
    /// So far out that every ray of the picture that meets the body below the lowest facet meets the mesh.
    Covering,
    /// On the horizon: between the chords of the rim the body is bare.
    Horizon,
}

impl Rim {
    pub(crate) const ALL: [(&'static str, Self); 2] =
        [("covering", Self::Covering), ("horizon", Self::Horizon)];
}

/// What the limits depend on besides the view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    pub(crate) steps: Steps,
    /// [`Law::widest_turn`](crate::law::Law::widest_turn).
    pub(crate) widest_turn: f64,
    pub(crate) fan_px: f64,
    pub(crate) rim: Rim,
    /// Heights of the terrain over the ellipsoid, metres.
    pub(crate) terrain: HeightRange,
}

/// Inner and outer radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    pub(crate) inner: f64,
    pub(crate) outer: f64,
}

impl Shape {
    /// How deep a facet may hang below its lowest corner, metres: [`facet_heights`] of the longest edge, which
    /// on the sphere is at most `√(q² sin² r + Δr²)` long between two neighbouring turns.
    ///
    /// [`facet_heights`]: terrafill_surface::SurfaceMesh::facet_heights
    pub(crate) fn deepest_facet_m(&self, body: &Ellipsoid, inner: f64, outer: f64) -> f64 {
        let turn = self.widest_turn * outer;
        let around = self.steps.widest_rad() * outer.min(FRAC_PI_2).sin();
        let fan = inner + turn;
        let longest = (around * around + turn * turn).max(fan * fan).sqrt();
        let HeightRange {
            lowest_m,
            highest_m,
        } = self.terrain;
        let longest_m = longest * (body.equatorial_radius_m() + highest_m.max(0.0));
        let relief_m = highest_m - lowest_m;
        let ball_m = body.smallest_curvature_radius_m() + lowest_m.min(0.0);
        let circle = longest_m * longest_m + relief_m * relief_m;
        let circle = (circle / 3.0).min(ball_m * ball_m);
        circle / (ball_m + (ball_m * ball_m - circle).sqrt())
    }

    /// - `ground_m`: height of the eye over the ground, above 0
    /// - returns: `None` for an eye so low that it sees no horizon
    pub(crate) fn limits(
        &self,
        body: &Ellipsoid,
        camera: &Camera,
        size: ImageSize,
        ground_m: f64,
    ) -> Option<Limits> {
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let eye = camera.eye_ecef / body.radii_m();
        let distance = eye.length();
        // A height is along the normal of the ellipsoid, which scaled leans away from that of the sphere.
        let highest = 1.0 + self.terrain.highest_m.max(0.0) / b;
        let lowest_terrain = 1.0 + self.terrain.lowest_m.min(0.0) / b;
        let tilt = (highest - lowest_terrain) * (a / b - 1.0);
        // An edge of the rim runs inside the circle through its vertices.
        let chord = (0.5 * self.steps.widest_rad()).min(1.5).cos();
        // Summits that stand behind the horizon.
        let behind = angle_to(highest / lowest_terrain)?;
        let reach = |lowest: f64| -> Option<f64> {
            let horizon = angle_to(distance / lowest)? + behind;
            let corner = corner_angle(body, camera, size, lowest);
            Some(corner.map_or(horizon, |corner| corner.min(horizon)) + tilt)
        };
        // Pixels that an angle of 1 at the eye spans in the middle of the picture.
        let scale = f64::from(size.height) / (2.0 * camera.tan_half_fov());
        let inner = (self.fan_px * ground_m / (scale * b)).clamp(MIN_INNER, MAX_INNER);
        let mut outer = reach(lowest_terrain)?.min(FRAC_PI_2);
        if self.rim == Rim::Covering {
            let widened = |angle: f64| {
                if angle < FRAC_PI_2 {
                    (angle.tan() / chord).atan()
                } else {
                    FRAC_PI_2
                }
            };
            let terrain_only = outer;
            for _ in 0..ROUNDS {
                let lowest = lowest_terrain - self.deepest_facet_m(body, inner, outer) / b;
                // Nothing can be promised of a mesh as coarse as the body.
                outer = if lowest > 0.0 {
                    widened(reach(lowest).unwrap_or(terrain_only))
                } else {
                    FRAC_PI_2
                };
            }
        }
        Some(Limits {
            inner: inner.min(outer),
            outer,
        })
    }
}

/// acos(1/ratio) without its cancellation near 1: the angle to where a ray from `ratio` radii away touches the
/// sphere. `None` from inside.
fn angle_to(ratio: f64) -> Option<f64> {
    let squared = (ratio - 1.0) * (ratio + 1.0);
    (squared >= 0.0).then(|| squared.sqrt().atan())
}

/// The largest angle at which rays through the picture's corners meet the sphere of the radius `lowest`; `None`
/// where one misses it.
///
/// Rays that meet it at no larger angle form a convex cone around the way straight down. So no ray through the
/// picture meets it farther away than one through a corner.
fn corner_angle(body: &Ellipsoid, camera: &Camera, size: ImageSize, lowest: f64) -> Option<f64> {
    let tan_y = camera.tan_half_fov();
    let tan_x = tan_y * size.aspect();
    let ecef_from_view = camera.view_from_ecef.transpose();
    let eye = camera.eye_ecef / body.radii_m();
    let mut largest: f64 = 0.0;
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let corner = ecef_from_view * DVec3::new(x * tan_x, y * tan_y, -1.0);
        let direction = (corner / body.radii_m()).normalize();
        let along = -eye.dot(direction);
        let height = (eye.length() - lowest) * (eye.length() + lowest);
        let discriminant = along * along - height;
        if along <= 0.0 || discriminant < 0.0 {
            return None;
        }
        let hit = eye + direction * (height / (along + discriminant.sqrt()));
        largest = largest.max(eye.cross(hit).length().atan2(eye.dot(hit)));
    }
    Some(largest)
}
