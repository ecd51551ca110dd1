// SPDX-License-Identifier: MIT OR Apache-2.0
//! A cone with its apex above the body: where its edge meets the surface, and whether it does all round.
//!
//! Closed form, in ECEF divided by the radii, where the body is the unit ball. A ray `p + t e` meets it
//! where `|e|² t² + 2 (p·e) t + g = 0`, `g = |p|² − 1`; it touches where `D = (p·e)² − |e|² g` is 0. The
//! points touched, the horizon, are those of the plane `p·x = 1`. Along the cone's edge D is a
//! trigonometric polynomial of second degree, so it has at most two minima there.

use super::FootprintError;
use crate::{Ellipsoid, Geodetic};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Smallest height of an apex, as a share of the equatorial radius: 6 mm on the Earth, a million
/// times the rounding of degrees.
const SMALLEST_SHARE: f64 = 1e-9;
/// Angles about the axis that D is compared at: a minimum lies between the neighbours of the lowest.
const COMPARED: u32 = 64;
/// Thirds that are cut off around a minimum, until its angle is known to half of a double's digits. D does
/// not change with the other half.
const THIRDS: u32 = 40;
/// Directions in which the horizon is searched for its nearest point, to say by how much it is
/// missed.
const SEARCHED: u32 = 3600;

/// A circular cone that a sensor sees with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorCone {
    /// Above the surface.
    pub apex: Geodetic,
    /// Of the axis, clockwise from north, within ±2π.
    pub azimuth_rad: f64,
    /// Of the axis, above the plane at right angles to the apex's vertical; −π/2 looks straight
    /// down.
    pub elevation_rad: f64,
    /// Between axis and edge, below π/2.
    pub half_angle_rad: f64,
}

impl SensorCone {
    /// # Errors
    /// [`FootprintError`] for values out of range.
    pub(super) fn check(&self, body: &Ellipsoid) -> Result<(), FootprintError> {
        let angle = FootprintError::check_angle;
        angle("latitude", self.apex.latitude_rad, FRAC_PI_2)?;
        // As far as files may go past the antimeridian.
        angle("longitude", self.apex.longitude_rad, 3.0 * PI)?;
        angle("azimuth", self.azimuth_rad, TAU)?;
        angle("elevation", self.elevation_rad, FRAC_PI_2)?;
        let smallest_m = SMALLEST_SHARE * body.equatorial_radius_m();
        let height_m = self.apex.height_m;
        if !(height_m >= smallest_m && height_m.is_finite()) {
            return Err(FootprintError::ApexInside {
                found_m: height_m,
                smallest_m,
            });
        }
        let half_angle_rad = self.half_angle_rad;
        if !(half_angle_rad > 0.0 && half_angle_rad < FRAC_PI_2) {
            return Err(FootprintError::Angle {
                parameter: "half angle",
                found: half_angle_rad,
                smallest: f64::MIN_POSITIVE,
                largest: FRAC_PI_2.next_down(),
            });
        }
        Ok(())
    }
}

/// A cone and the body it looks at, ready for intersection.
pub(super) struct ConeOverBody {
    pub(super) radii_m: DVec3,
    pub(super) apex_ecef: DVec3,
    /// Apex divided by the radii.
    pub(super) p: DVec3,
    /// `|p|² − 1`, from the height: taken from `p` it would lose a low apex.
    pub(super) g: f64,
    pub(super) axis: DVec3,
    /// With the axis: `right × forward = −axis`, so that the cone's edge is traversed
    /// counter-clockwise as the apex sees it.
    pub(super) right: DVec3,
    pub(super) forward: DVec3,
    pub(super) half_angle_rad: f64,
}

impl ConeOverBody {
    pub(super) fn new(body: &Ellipsoid, cone: &SensorCone) -> Self {
        let radii_m = body.radii_m();
        let apex = cone.apex;
        let normal = body.geodetic_surface_normal(apex.longitude_rad, apex.latitude_rad);
        let foot = body.geodetic_to_ecef(Geodetic {
            height_m: 0.0,
            ..apex
        });
        let apex_ecef = foot + normal * apex.height_m;
        let (scaled_foot, scaled_normal) = (foot / radii_m, normal / radii_m);
        let g = apex.height_m
            * (2.0 * scaled_foot.dot(scaled_normal)
                + apex.height_m * scaled_normal.length_squared());
        let (sin_lon, cos_lon) = apex.longitude_rad.sin_cos();
        let east = DVec3::new(-sin_lon, cos_lon, 0.0);
        let north = normal.cross(east);
        let (sin_az, cos_az) = cone.azimuth_rad.sin_cos();
        let (sin_el, cos_el) = cone.elevation_rad.sin_cos();
        let ahead = east * sin_az + north * cos_az;
        let axis = ahead * cos_el + normal * sin_el;
        let forward = normal * cos_el - ahead * sin_el;
        Self {
            radii_m,
            apex_ecef,
            p: apex_ecef / radii_m,
            g,
            axis,
            right: axis.cross(forward),
            forward,
            half_angle_rad: cone.half_angle_rad,
        }
    }

    /// Refuses a cone whose edge does not meet the body all round.
    ///
    /// # Errors
    /// [`FootprintError::NotAllRound`] and [`FootprintError::Misses`].
    pub(super) fn check_all_round(&self, body: &Ellipsoid) -> Result<(), FootprintError> {
        // Where D stays above 0, all rays of the edge look towards the body or all look away.
        if self.p.dot(self.scaled_ray(0.0)) < 0.0 && self.smallest_discriminant() > 0.0 {
            return Ok(());
        }
        let axis = self.axis / self.radii_m;
        let is_axis_on_body = self.p.dot(axis) < 0.0 && self.discriminant(axis) > 0.0;
        let horizon_off_axis_rad = self.horizon_off_axis_rad();
        if is_axis_on_body || horizon_off_axis_rad < self.half_angle_rad {
            return Err(FootprintError::not_all_round(
                body,
                "the horizon cuts it off",
            ));
        }
        Err(FootprintError::Misses {
            body: body.name(),
            found_deg: horizon_off_axis_rad.to_degrees(),
            half_angle_deg: self.half_angle_rad.to_degrees(),
        })
    }

    /// Where the ray of a cone that meets the body all round meets it, by cosine and sine of its angle.
    pub(super) fn hit_towards(&self, cos: f64, sin: f64) -> DVec3 {
        let direction = self.ray(cos, sin);
        let scaled = direction / self.radii_m;
        let root = self.discriminant(scaled).max(0.0).sqrt();
        // The smaller solution without the difference of its numerator.
        self.apex_ecef + direction * (self.g / (root - self.p.dot(scaled)))
    }

    /// Direction of a ray on the cone's edge, ECEF, unit.
    fn ray(&self, cos: f64, sin: f64) -> DVec3 {
        let (sin_half, cos_half) = self.half_angle_rad.sin_cos();
        let spoke = self.right * cos + self.forward * sin;
        self.axis * cos_half + spoke * sin_half
    }

    /// The same by its angle about the axis, divided by the radii.
    fn scaled_ray(&self, angle_rad: f64) -> DVec3 {
        let (sin, cos) = angle_rad.sin_cos();
        self.ray(cos, sin) / self.radii_m
    }

    /// `D` of a direction `e` of the scaled space. For a far apex as the `e·e − (p×e)²` that it is by
    /// Binet and Cauchy: each form loses digits where the other keeps them.
    fn discriminant(&self, e: DVec3) -> f64 {
        if self.g > 1.0 {
            e.dot(e) - self.p.cross(e).length_squared()
        } else {
            self.p.dot(e).powi(2) - self.g * e.dot(e)
        }
    }

    /// Of all rays of the cone's edge.
    fn smallest_discriminant(&self) -> f64 {
        let at = |angle_rad: f64| self.discriminant(self.scaled_ray(angle_rad));
        let step_rad = TAU / f64::from(COMPARED);
        let compared = (0..COMPARED).map(|k| step_rad * f64::from(k));
        let lowest = compared.min_by(|a, b| at(*a).total_cmp(&at(*b)));
        let lowest_rad = lowest.unwrap_or(0.0);
        let (mut from_rad, mut to_rad) = (lowest_rad - step_rad, lowest_rad + step_rad);
        for _ in 0..THIRDS {
            let third_rad = (to_rad - from_rad) / 3.0;
            if at(from_rad + third_rad) < at(to_rad - third_rad) {
                to_rad -= third_rad;
            } else {
                from_rad += third_rad;
            }
        }
        at(0.5 * (from_rad + to_rad)).min(at(lowest_rad))
    }

    /// A point of the horizon, ECEF; counter-clockwise from outside.
    fn horizon(&self, angle_rad: f64) -> DVec3 {
        let up = self.p.normalize();
        let u = up.any_orthonormal_vector();
        let v = up.cross(u);
        let squared = self.p.length_squared();
        let (sin, cos) = angle_rad.sin_cos();
        (self.p / squared + (u * cos + v * sin) * (self.g / squared).sqrt()) * self.radii_m
    }

    /// Angle off the cone's axis under which the apex sees a point.
    fn off_axis_rad(&self, ecef: DVec3) -> f64 {
        let direction = ecef - self.apex_ecef;
        direction
            .cross(self.axis)
            .length()
            .atan2(direction.dot(self.axis))
    }

    /// Smallest angle between the axis and the horizon, radians.
    fn horizon_off_axis_rad(&self) -> f64 {
        (0..SEARCHED)
            .map(|k| self.off_axis_rad(self.horizon(TAU * f64::from(k) / f64::from(SEARCHED))))
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEOSTATIONARY_M: f64 = 35_786e3;

    fn cone(
        body: &Ellipsoid,
        latitude_deg: f64,
        elevation_deg: f64,
        half_angle_rad: f64,
    ) -> ConeOverBody {
        let cone = SensorCone {
            apex: Geodetic::from_degrees(20.0, latitude_deg, GEOSTATIONARY_M),
            azimuth_rad: 0.3,
            elevation_rad: elevation_deg.to_radians(),
            half_angle_rad,
        };
        ConeOverBody::new(body, &cone)
    }

    #[test]
    fn horizon_and_hits_are_on_the_surface_and_seen_at_their_angles() {
        let half_angle_rad = 3_f64.to_radians();
        let cone = cone(&Ellipsoid::WGS84, 10.0, -86.0, half_angle_rad);
        for k in 0..20 {
            let angle = f64::from(k) * 0.3;
            let horizon = cone.horizon(angle);
            assert!(((horizon / cone.radii_m).length() - 1.0).abs() < 1e-14);
            // The line of sight is at right angles to the normal.
            let normal = horizon / (cone.radii_m * cone.radii_m);
            let slant = (horizon - cone.apex_ecef).normalize();
            assert!(normal.normalize().dot(slant).abs() < 1e-14);
            let (sin, cos) = angle.sin_cos();
            let hit = cone.hit_towards(cos, sin);
            assert!(((hit / cone.radii_m).length() - 1.0).abs() < 1e-13);
            assert!((cone.off_axis_rad(hit) - half_angle_rad).abs() < 1e-14);
            // The near side, not the far one.
            assert!((hit / cone.radii_m).dot(cone.p) > 1.0);
        }
    }

    #[test]
    fn a_cone_meets_the_body_all_round_up_to_its_narrowest_side() {
        // Over the equator the body is narrowest from pole to pole: tan = b / √(d² − a²).
        let body = Ellipsoid::WGS84;
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let distance_m = a + GEOSTATIONARY_M;
        let narrowest_rad = (b / (distance_m * distance_m - a * a).sqrt()).atan();
        let widest_rad = (a / distance_m).asin();
        assert!(widest_rad - narrowest_rad > 1e-4, "the two differ");
        let checked =
            |half_angle_rad: f64| cone(&body, 0.0, -90.0, half_angle_rad).check_all_round(&body);
        assert_eq!(checked(narrowest_rad - 1e-9), Ok(()));
        for half_angle_rad in [narrowest_rad + 1e-9, widest_rad + 1e-9, 1.0] {
            let refused = checked(half_angle_rad).expect_err("beyond the horizon");
            assert!(refused.to_string().contains("horizon cuts"), "{refused}");
        }
        // Off to a side over a sphere, where angles add up.
        let sphere = Ellipsoid::new("sphere", a, a).expect("a sphere");
        let off_nadir_rad = 5_f64.to_radians();
        let checked = |half_angle_rad: f64| {
            cone(&sphere, 30.0, -85.0, half_angle_rad).check_all_round(&sphere)
        };
        assert_eq!(checked(widest_rad - off_nadir_rad - 1e-9), Ok(()));
        assert!(checked(widest_rad - off_nadir_rad + 1e-9).is_err());
    }

    #[test]
    fn the_smallest_discriminant_is_found_between_the_compared_angles() {
        let mut is_between = false;
        for latitude_deg in [-40.0, 7.0, 61.0] {
            for (elevation_deg, half_angle_deg) in [(-90.0, 8.5), (-84.0, 3.0), (-86.0, 9.0)] {
                let half_angle_rad = f64::to_radians(half_angle_deg);
                let cone = cone(
                    &Ellipsoid::WGS84,
                    latitude_deg,
                    elevation_deg,
                    half_angle_rad,
                );
                let smallest = |count: u32| {
                    (0..count)
                        .map(|k| TAU * f64::from(k) / f64::from(count))
                        .map(|angle_rad| cone.discriminant(cone.scaled_ray(angle_rad)))
                        .fold(f64::INFINITY, f64::min)
                };
                let found = cone.smallest_discriminant();
                let rounding = 1e-14 * cone.p.length_squared() / cone.radii_m.length_squared();
                assert!(found <= smallest(20_000) + rounding);
                is_between |= found < smallest(COMPARED) - 100.0 * rounding;
            }
        }
        // Negative control: the compared angles alone do not find it.
        assert!(is_between);
    }

    #[test]
    fn a_near_miss_is_told_by_how_much() {
        let body = Ellipsoid::UNIT_SPHERE;
        // From one radius up the horizon is 60° below the horizontal.
        let refused = |half_angle_deg: f64| {
            let cone = SensorCone {
                apex: Geodetic::from_degrees(0.0, 0.0, 1.0),
                azimuth_rad: 0.0,
                elevation_rad: (-50_f64).to_radians(),
                half_angle_rad: half_angle_deg.to_radians(),
            };
            let cone = ConeOverBody::new(&body, &cone);
            cone.check_all_round(&body)
                .expect_err("not all round")
                .to_string()
        };
        let text = refused(9.99);
        assert!(text.contains("10.0000° from the horizon"), "{text}");
        assert!(refused(10.01).contains("horizon cuts it off"));
    }
}
