// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes whose top caps may be drawn without the facets that face away from the eye.
//!
//! Fragments count in front of the surface. A facet may be left out where every ray through it goes
//! on into the sky: no pixel that shows the surface lies on such a ray behind the facet. Covers then
//! leave out the sky, where the stencil holds anything. So each facet must certainly face the eye,
//! or certainly stand before the sky.
//!
//! A cap is not convex: where a sliver dents it, a ray at a grazing angle may leave the volume by one
//! facet and enter it again by the next. Terrain higher than the cap may stand behind it. Volumes
//! with such facets keep both kinds.
//!
//! ECEF metres in `f64`. The surface lies inside the ellipsoid scaled by 1 + h / b (h: its highest
//! point, b: the polar radius): that holds all points up to h above the ellipsoid. Divided by the
//! scaled axes it is the unit sphere, and rays stay rays.

use crate::FillInput;
use glam::DVec3;
use terrafill_scene::{NearRectangle, PlannedRegion};

/// Pixels by which a rasteriser may move a corner: it snaps to 1/256 at the worst here, so half of
/// that along each axis, and as much again for `f32`.
const SNAPPED_PX: f64 = 1.0 / 128.0;

/// Share of its distance by which `f32` arithmetic may move a corner.
const ROUNDED: f64 = 1.0 / (1 << 20) as f64;

/// Rounding of `f64` in the unit sphere, 6 mm on Earth.
const TOUCHES: f64 = 1e-9;

/// Why a volume keeps the facets that face away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum CapsKept {
    /// The near plane may meet it, so that it counts behind the surface.
    MetByNearPlane,
    /// The vertex stage bends it.
    IsBent,
    /// The surface rises as high as one of its facets, or its facets fold.
    FoldOrHigherGround,
}

impl CapsKept {
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::MetByNearPlane => "the near plane may meet them",
            Self::IsBent => "the vertex stage bends them",
            Self::FoldOrHigherGround => {
                "a facet neither certainly faces the eye nor stands before the sky: ground as high, or a fold"
            }
        }
    }
}

/// Why the volume of `planned` needs the facets of its top that face away; `None` where the others
/// suffice.
pub(crate) fn caps_kept(input: &FillInput, planned: &PlannedRegion) -> Option<CapsKept> {
    if planned.near_rectangle != NearRectangle::Outside {
        return Some(CapsKept::MetByNearPlane);
    }
    if input.scene.footprints.contains_key(&planned.mesh) {
        return Some(CapsKept::IsBent);
    }
    let body = &input.scene.body;
    let [a, b] = [body.equatorial_radius_m(), body.polar_radius_m()];
    let pixel_rad = 2.0 * input.camera.tan_half_fov() / f64::from(input.size.height);
    let sight = Sight::new(
        input.camera.eye_ecef,
        [a, b],
        input.terrain().highest_m,
        SNAPPED_PX * pixel_rad + ROUNDED,
    );
    let mesh = &input.scene.meshes[planned.mesh];
    // The gradient of the ellipsoid's equation is along the geodetic normal.
    let per_axis = DVec3::new(a * a, a * a, b * b).recip();
    let top = |&vertex: &DVec3| vertex + (vertex * per_axis).normalize() * planned.heights.top_m;
    let corners: Vec<DVec3> = mesh.vertices_ecef.iter().map(top).collect();
    let mut facets = mesh.triangles.iter();
    let is_free = facets.all(|facet| {
        let corners = facet.map(|corner| corners[corner as usize]);
        sight.faces_eye(corners) || sight.is_before_sky(corners)
    });
    (!is_free).then_some(CapsKept::FoldOrHigherGround)
}

/// An eye over a body.
#[derive(Debug, Clone, Copy)]
struct Sight {
    eye_ecef: DVec3,
    /// One over the axes of the ellipsoid that holds the surface.
    per_axis: DVec3,
    /// Angle by which corners may be drawn aside, radians.
    aside_rad: f64,
}

impl Sight {
    fn new(eye_ecef: DVec3, [a, b]: [f64; 2], highest_m: f64, aside_rad: f64) -> Self {
        let scale = 1.0 + highest_m.max(0.0) / b;
        Self {
            eye_ecef,
            per_axis: (DVec3::new(a, a, b) * scale).recip(),
            aside_rad,
        }
    }

    /// Six times the volume of eye and facet, positive where the facet faces the eye, and what
    /// corners drawn aside may change of it.
    fn side(&self, corners: [DVec3; 3]) -> (f64, f64) {
        let [a, b, c] = corners.map(|corner| corner - self.eye_ecef);
        let [bc, ca, ab] = [b.cross(c), c.cross(a), a.cross(b)];
        let changes =
            a.length() * bc.length() + b.length() * ca.length() + c.length() * ab.length();
        (-a.dot(bc), self.aside_rad * changes)
    }

    /// Whether the facet is certainly drawn as one that looks at the eye.
    fn faces_eye(&self, corners: [DVec3; 3]) -> bool {
        let (side, unsure) = self.side(corners);
        side > unsure
    }

    /// Whether no ray from the eye meets the surface behind the facet.
    fn is_before_sky(&self, corners: [DVec3; 3]) -> bool {
        let (side, unsure) = self.side(corners);
        let eye = self.eye_ecef * self.per_axis;
        let scaled = corners.map(|corner| corner * self.per_axis);
        let [a, b, c] = scaled;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // The whole sphere lies below the facet's plane, and rays leave it upwards.
        if side < -unsure && normal.dot(a) >= 1.0 - TOUCHES {
            return true;
        }
        // Rays leave the sphere behind: p · (p − eye) > 0 where |p| ≥ 1 and p · eye < 1. A sphere is
        // wider than the body by no more than the ratio of its axes, which 4 holds.
        let farthest = scaled.map(|corner| (corner - eye).length());
        let farthest = farthest.into_iter().fold(0.0, f64::max);
        let aside = 4.0 * self.aside_rad * farthest;
        let leaves = |corner: DVec3| eye.dot(corner) < 1.0 - (eye.length() + 2.0) * aside;
        scaled.into_iter().all(leaves) && least_length_squared(scaled) >= 1.0 - TOUCHES
    }
}

/// Of the points of a triangle, the square of the distance of that next to the origin.
fn least_length_squared([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_inside = |from: DVec3, to: DVec3| {
        (to - from).cross(normal * normal.dot(a) - from).dot(normal) >= 0.0
    };
    if normal != DVec3::ZERO && is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return normal.dot(a).powi(2);
    }
    let of_edge = |from: DVec3, to: DVec3| {
        let way = to - from;
        let along = (-from.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from + way * along).length_squared()
    };
    of_edge(a, b).min(of_edge(b, c)).min(of_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight(eye: DVec3, highest_m: f64) -> Sight {
        Sight::new(eye, [1000.0, 1000.0], highest_m, 1e-6)
    }

    /// A facet `height` above a sphere of radius 1000, `angle` along the equator, `size` wide.
    fn facet(angle: f64, height: f64, size: f64) -> [DVec3; 3] {
        let at = |longitude: f64, latitude: f64| {
            let (sin, cos) = longitude.sin_cos();
            DVec3::new(cos * latitude.cos(), sin * latitude.cos(), latitude.sin())
                * (1000.0 + height)
        };
        [
            at(angle - size, -size),
            at(angle + size, -size),
            at(angle, size),
        ]
    }

    #[test]
    fn facets_face_the_eye_before_the_horizon_and_the_sky_beyond() {
        let sight = sight(DVec3::new(2000.0, 0.0, 0.0), 0.0);
        for (angle, faces, sky) in [(0.0, true, false), (0.9, true, false), (1.2, false, true)] {
            let corners = facet(angle, 1.0, 0.01);
            assert_eq!(sight.faces_eye(corners), faces, "{angle}");
            assert_eq!(sight.is_before_sky(corners), sky, "{angle}");
            // Twin: turned over, nothing beyond the horizon has to face away.
            let [a, b, c] = corners;
            assert_eq!(sight.faces_eye([a, c, b]), !faces, "{angle}");
        }
    }

    #[test]
    fn ground_as_high_as_the_facet_may_stand_behind_it() {
        let eye = DVec3::new(1000.5, 0.0, 0.0);
        let corners = facet(0.02, 1.0, 0.001);
        assert!(!sight(eye, 0.0).faces_eye(corners));
        assert!(sight(eye, 0.0).is_before_sky(corners));
        // Twin: a hill twice as high may.
        assert!(!sight(eye, 2.0).is_before_sky(corners));
    }

    #[test]
    fn a_dent_in_a_cap_is_not_taken_for_the_sky() {
        // A sliver whose plane cuts the sphere, seen at a grazing angle from behind.
        let raised = |x: f64, y: f64, height: f64| {
            let up = (1_000_000.0 - x * x - y * y).sqrt();
            DVec3::new(up, x, y) * ((1000.0 + height) / 1000.0)
        };
        let sliver = [
            raised(0.0, -60.0, 2.0),
            raised(0.2, 0.0, 2.0),
            raised(0.0, 60.0, 2.0),
        ];
        let normal = (sliver[1] - sliver[0]).cross(sliver[2] - sliver[0]);
        let normal = normal.normalize();
        // So steep a facet that a ray through it meets the sphere.
        assert!(normal.dot(sliver[0]) < 999.0, "{}", normal.dot(sliver[0]));
        let through = (sliver[0] + sliver[1] + sliver[2]) / 3.0;
        let eye = through - normal * 5.0 + DVec3::X * 1.0;
        let seen = sight(eye, 0.0);
        let way = (through - eye).normalize();
        let nearest = through - way * through.dot(way).min(0.0);
        let meets = nearest.length() < 1000.0;
        assert!(!seen.faces_eye(sliver));
        assert!(meets && !seen.is_before_sky(sliver), "{}", nearest.length());
    }

    #[test]
    fn a_facet_seen_edge_on_is_neither() {
        let eye = DVec3::new(2000.0, 0.0, 0.0);
        // Its plane passes through the eye; the horizon of its level runs across it.
        let angle = (1001.0_f64 / 2000.0).acos();
        let corners = facet(angle, 1.0, 0.01);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        let lifted = corners.map(|corner| corner + normal * normal.dot(eye - a));
        let seen = sight(eye, 0.0);
        assert!(!seen.faces_eye(lifted));
        let low = Sight::new(eye, [1000.0, 1000.0], 3.0, 1e-6);
        assert!(!low.is_before_sky(corners));
    }

    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_least() {
        let triangles = [
            facet(0.3, 1.0, 0.2),
            [
                DVec3::new(5.0, 1.0, 0.0),
                DVec3::new(5.0, 4.0, 0.0),
                DVec3::new(9.0, 2.0, 3.0),
            ],
        ];
        for [a, b, c] in triangles {
            let least = least_length_squared([a, b, c]);
            let mut found = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let [u, v] = [i, j].map(|step| f64::from(step) / 200.0);
                    found = found.min((a + (b - a) * u + (c - a) * v).length_squared());
                }
            }
            assert!(least <= found * (1.0 + 1e-12), "{least} {found}");
            // Twin: the corners alone are farther.
            assert!(found <= least * 1.001, "{least} {found}");
        }
    }
}
