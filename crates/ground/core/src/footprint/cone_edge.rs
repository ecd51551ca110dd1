// SPDX-License-Identifier: MIT OR Apache-2.0
//! A cone's edge on a body as a device follows it: a few numbers a footprint instead of its vertices.
//!
//! A vertex is the angle about the cone's axis. Let `a` be the apex in ECEF metres, `p` the same divided by
//! the radii, `g = |p|² − 1`, and `d = axis + right cos + forward sin` the direction, of unit length. With
//! `e` as `d` divided by the radii, the ray meets the body first at `a + d g / (√((p·e)² − g e·e) − p·e)`.
//! Here that is followed in f64; `shaders/shared/footprint.wgsl` does the same in f32, and
//! [`ConeEdge::rounding_bound_m`] says how far apart the two may be.

use super::FootprintError;
use super::cone::ConeOverBody;
use crate::mesh::{sagitta_m, volume_heights};
use crate::{Ellipsoid, OrientedBox, VolumeHeights};
use glam::DVec3;

/// A cone and a body, with what the closed form needs computed beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConeEdge {
    /// ECEF metres.
    pub apex_ecef: DVec3,
    /// Apex divided by the radii.
    pub scaled_apex: DVec3,
    /// `|p|² − 1`, from the height: taken from `p` in f32 it would lose a low apex.
    pub power: f64,
    /// Part of a ray's direction along the cone's axis.
    pub axis: DVec3,
    /// The part that the cosine of a vertex's angle is multiplied by.
    pub right: DVec3,
    /// The part that its sine is multiplied by.
    pub forward: DVec3,
    /// 1 / radii of the body, per metre.
    pub inverse_radii: DVec3,
}

/// Half the distance of a number from the next one in f32, as a share of it.
const ROUNDING_F32: f64 = 1.0 / (1 << 24) as f64;
/// Roundings of a direction: three rounded inputs, two products with rounded factors, two sums; and of
/// the product with the range.
const DIRECTION_ROUNDINGS: f64 = 11.0;
/// Roundings of a product `p·e` of two vectors, as a share of the product of their lengths.
const PRODUCT_ROUNDINGS: f64 = 14.0;
/// Of a root: Vulkan allows the inverse root two units in the last place, and a division two and a half.
const ROOT_ROUNDINGS: f64 = 9.0;
/// Of the quotient that is the range, and of the power.
const QUOTIENT_ROUNDINGS: f64 = 7.0;

impl ConeEdge {
    /// Where the ray at an angle about the axis meets the body, ECEF metres.
    #[must_use]
    pub fn hit(&self, cos: f64, sin: f64) -> DVec3 {
        let (direction, range_m) = self.ray(cos, sin);
        self.apex_ecef + direction * range_m
    }

    fn ray(&self, cos: f64, sin: f64) -> (DVec3, f64) {
        let direction = self.axis + self.right * cos + self.forward * sin;
        let scaled = direction * self.inverse_radii;
        let along = self.scaled_apex.dot(scaled);
        let root = self.squared_root(scaled, along).max(0.0).sqrt();
        (direction, self.power / (root - along))
    }

    fn squared_root(&self, scaled: DVec3, along: f64) -> f64 {
        along * along - self.power * scaled.length_squared()
    }

    /// Largest distance, metres, between what a device that follows Vulkan's rules computes in f32 for
    /// [`ConeEdge::hit`] less the apex, and what that is. First order in 2⁻²⁴, each rounding
    /// counted with the largest size of what is rounded.
    ///
    /// - `steps`: cosines and sines of the angles asked for
    #[must_use]
    pub fn rounding_bound_m(&self, steps: &[[f64; 2]]) -> f64 {
        let bound = |&[cos, sin]: &[f64; 2]| {
            let (direction, range_m) = self.ray(cos, sin);
            let scaled = direction * self.inverse_radii;
            let along = self.scaled_apex.dot(scaled);
            let product = PRODUCT_ROUNDINGS * self.scaled_apex.length() * scaled.length();
            let root = self.squared_root(scaled, along).max(0.0).sqrt();
            let square = 2.0 * along.abs() * product
                + 2.0 * along * along
                + 20.0 * self.power * scaled.length_squared();
            let root_error = square / (2.0 * root) + ROOT_ROUNDINGS * root;
            let below = root - along;
            let quotient = (root_error + product + below) / below + QUOTIENT_ROUNDINGS;
            range_m * ROUNDING_F32 * (DIRECTION_ROUNDINGS + quotient)
        };
        steps.iter().map(bound).fold(0.0, f64::max)
    }
}

impl ConeOverBody {
    /// Parameters of an edge that meets the body all round.
    pub(super) fn edge(&self) -> ConeEdge {
        let (sin_half, cos_half) = self.half_angle_rad.sin_cos();
        ConeEdge {
            apex_ecef: self.apex_ecef,
            scaled_apex: self.p,
            power: self.g,
            axis: self.axis * cos_half,
            right: self.right * sin_half,
            forward: self.forward * sin_half,
            inverse_radii: self.radii_m.recip(),
        }
    }
}

/// A cone's edge, and the vertices on it that a device will make: what a plan needs to know of them.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingFootprint {
    /// What the device is handed.
    pub edge: ConeEdge,
    vertices_ecef: Vec<DVec3>,
    cap_sagitta_m: f64,
}

impl MovingFootprint {
    /// # Errors
    /// [`FootprintError::Folded`] where a facet faces inwards.
    pub(super) fn new(
        body: &Ellipsoid,
        edge: ConeEdge,
        steps: &[[f64; 2]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, FootprintError> {
        let hits = steps.iter().map(|&[cos, sin]| edge.hit(cos, sin));
        let vertices_ecef: Vec<DVec3> = hits.collect();
        let facets = triangles.iter();
        let facets = facets.map(|corners| corners.map(|i| vertices_ecef[i as usize]));
        if facets.clone().any(faces_inwards) {
            return Err(FootprintError::Folded { body: body.name() });
        }
        Ok(Self {
            edge,
            cap_sagitta_m: sagitta_m(body, facets),
            vertices_ecef,
        })
    }

    /// As of a mesh with these vertices: [`RegionMesh::volume_heights`](crate::RegionMesh::volume_heights).
    #[must_use]
    pub fn volume_heights(&self, lowest_m: f64, highest_m: f64) -> VolumeHeights {
        volume_heights(&self.vertices_ecef, self.cap_sagitta_m, lowest_m, highest_m)
    }

    /// As of a mesh with these vertices: [`RegionMesh::oriented_box`](crate::RegionMesh::oriented_box).
    #[must_use]
    pub fn oriented_box(&self, body: &Ellipsoid, heights: VolumeHeights) -> OrientedBox {
        OrientedBox::around(body, &self.vertices_ecef, heights)
    }
}

/// Whether a facet is clockwise seen from outside, by the sign of a determinant. Scaling the axes by positive
/// numbers leaves the sign, so the body need not be made a sphere.
pub(super) fn faces_inwards([a, b, c]: [DVec3; 3]) -> bool {
    a.dot(b.cross(c)) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgeRule, FootprintMesher, Geodetic, RegionMesh, SensorCone, nearest_f32};
    use glam::Vec3;

    fn cone(longitude_deg: f64, tilt_deg: f64, half_angle_deg: f64, height_m: f64) -> SensorCone {
        SensorCone {
            apex: Geodetic::from_degrees(longitude_deg, 35.0, height_m),
            azimuth_rad: 2.0,
            elevation_rad: (tilt_deg - 90.0).to_radians(),
            half_angle_rad: half_angle_deg.to_radians(),
        }
    }

    fn cones() -> Vec<SensorCone> {
        let mut cones = Vec::new();
        for longitude_deg in [-170.0, 15.0] {
            for (tilt_deg, half_angle_deg) in [(0.0, 1.0), (5.0, 18.0), (22.0, 18.0), (30.0, 25.0)]
            {
                for height_m in [20_000.0, 500_000.0, 900_000.0] {
                    cones.push(cone(longitude_deg, tilt_deg, half_angle_deg, height_m));
                }
            }
        }
        cones
    }

    /// As the shader has it, each step rounded to f32.
    fn in_f32(edge: &ConeEdge, [cos, sin]: [f64; 2]) -> Vec3 {
        let direction = edge.axis.as_vec3()
            + edge.right.as_vec3() * nearest_f32(cos)
            + edge.forward.as_vec3() * nearest_f32(sin);
        let scaled = direction * edge.inverse_radii.as_vec3();
        let along = edge.scaled_apex.as_vec3().dot(scaled);
        let power = nearest_f32(edge.power);
        let root = (along * along - power * scaled.dot(scaled)).max(0.0).sqrt();
        direction * (power / (root - along))
    }

    fn worst_m(edge: &ConeEdge, of: &ConeEdge, steps: &[[f64; 2]]) -> f64 {
        let off = steps.iter().map(|&[cos, sin]| {
            let exact = of.hit(cos, sin) - of.apex_ecef;
            in_f32(edge, [cos, sin]).as_dvec3().distance(exact)
        });
        off.fold(0.0, f64::max)
    }

    #[test]
    fn the_vertices_are_those_of_the_footprint_and_so_are_heights_and_box() {
        let body = Ellipsoid::WGS84;
        let mesher = FootprintMesher::new(body, 256).expect("allowed");
        for cone in cones() {
            let footprint = mesher.footprint(&cone).expect("all round");
            let strip = mesher.mesh("cone", 0, footprint, EdgeRule::Planar);
            let strip = strip.expect("unfolded");
            let moving = mesher.moving(&cone).expect("all round");
            for (a, b) in moving.vertices_ecef.iter().zip(&strip.vertices_ecef) {
                assert!(a.distance(*b) < 1e-6, "{a} {b}");
            }
            let heights = moving.volume_heights(-10.0, 100.0);
            let expected = strip.volume_heights(-10.0, 100.0);
            assert!((heights.top_m - expected.top_m).abs() < 1e-3);
            assert_eq!(
                heights.bottom_m.to_bits() >> 20,
                expected.bottom_m.to_bits() >> 20
            );
            let [found, wanted] = [
                moving.oriented_box(&body, heights),
                strip.oriented_box(&body, heights),
            ];
            assert!(found.center_ecef.distance(wanted.center_ecef) < 1e-3);
            assert!(found.half_extents_m.distance(wanted.half_extents_m) < 1e-3);
            // Negative control: another cone's box is another one.
            let other = mesher.moving(&SensorCone {
                azimuth_rad: 3.0,
                half_angle_rad: 0.9 * cone.half_angle_rad,
                ..cone
            });
            let other = other.expect("all round").oriented_box(&body, heights);
            assert!(other.half_extents_m.distance(wanted.half_extents_m) > 1.0);
        }
        let past = SensorCone {
            elevation_rad: 0.2,
            ..cones()[0]
        };
        assert_eq!(mesher.moving(&past).err(), mesher.footprint(&past).err());
    }

    #[test]
    fn f32_stays_within_its_bound_and_a_wrong_constant_does_not() {
        let mesher = FootprintMesher::new(Ellipsoid::WGS84, 64).expect("allowed");
        let (mut share, mut largest_m) = (0.0_f64, 0.0_f64);
        for cone in cones() {
            let edge = mesher.moving(&cone).expect("all round").edge;
            let bound_m = edge.rounding_bound_m(mesher.steps());
            let found_m = worst_m(&edge, &edge, mesher.steps());
            assert!(found_m <= bound_m, "{cone:?}: {found_m} > {bound_m}");
            share = share.max(found_m / bound_m);
            largest_m = largest_m.max(bound_m);
            // Negative control: a power that is a ten-thousandth off.
            let mut wrong = edge;
            wrong.power *= 1.0 + 1e-4;
            let found_m = worst_m(&wrong, &edge, mesher.steps());
            assert!(found_m > bound_m, "{cone:?}: {found_m} within {bound_m}");
        }
        eprintln!("at most {share:.3} of the bound, which is {largest_m:.2} m at most");
        assert!(share > 0.02 && largest_m < 20.0, "{share} {largest_m}");
    }

    #[test]
    fn a_disc_has_the_strips_triangles_on_the_unit_circle() {
        let mesher = FootprintMesher::new(Ellipsoid::WGS84, 64).expect("allowed");
        let footprint = mesher.footprint(&cones()[4]).expect("all round");
        let strip = mesher.mesh("cone", 3, footprint, EdgeRule::Planar);
        let strip: RegionMesh = strip.expect("unfolded");
        let disc = mesher.disc("cone", 3);
        assert_eq!(disc.triangles, strip.triangles);
        assert_eq!(disc.boundary_loops, strip.boundary_loops);
        assert_eq!(disc.vertex_count(), strip.vertex_count());
        for (vertex, [cos, sin]) in disc.vertices_ecef.iter().zip(mesher.steps()) {
            assert_eq!(vertex.to_array(), [*cos, *sin, 0.0]);
        }
    }
}
