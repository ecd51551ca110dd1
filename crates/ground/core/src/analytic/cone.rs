// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a cone with its apex above the body cuts out of the surface that the apex can see.
//!
//! Closed form throughout, in ECEF divided by the radii, where the body is the unit ball. A ray
//! `p + t e` meets it where `|e|² t² + 2 (p·e) t + g = 0`, `g = |p|² − 1`; it touches where
//! `D = (p·e)² − |e|² g` is 0. The points touched, the horizon, are those of the plane `p·x = 1`.
//! Along the cone's edge D is a trigonometric polynomial of second degree, so the cone crosses the
//! horizon at most four times, and where is asked of a quartic.
//!
//! A cone of less than 90° is convex, so is the one of the rays that touch, and so is what both hold.
//! The footprint is in one piece, bounded by arcs of the two in turn.

use super::boundary::{Band, Boundary, Curve, Leg, pieces_of_turn};
use crate::edge::Degrees;
use crate::{Ellipsoid, Geodetic};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Directions tried for the start of the quartic's parameter: among so many one is far from roots.
const STARTS: u32 = 64;
/// Newton's steps that give a root of the quartic the digits that expanding D has lost.
const POLISHING_STEPS: u32 = 4;
/// A polishing step longer than this goes to another root, radians.
const LONGEST_POLISH_RAD: f64 = 1e-3;
/// A horizon arc this close to a whole turn, radians, may be one of none that rounding turned over.
const ROUNDED_TURN_RAD: f64 = 1e-6;
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

/// A cone and the body it looks at, ready for intersection.
pub(super) struct Sight {
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

/// Where the cone's edge crosses the horizon, or its mirror image behind the apex.
struct Tangents {
    /// Angle about the axis that the others count from.
    start_rad: f64,
    /// Ascending, within ±π.
    angles_rad: Vec<f64>,
    /// Of `D (1 + t²)²` in `t = tan ½x`, x counting from the start; ascending.
    quartic: [f64; 5],
}

/// An arc of the cone's edge between two tangents.
///
/// There `D = factor · sin ½(x − from) · sin ½(to − x) · (r₀ cos² ½x + r₁ cos ½x sin ½x + r₂ sin² ½x)`,
/// which is smooth to the last bit. As the difference of two squares D has an absolute error, and a
/// footprint that only just reaches the body would be all noise.
#[derive(Clone, Copy)]
struct ConeArc {
    start_rad: f64,
    from_rad: f64,
    to_rad: f64,
    factor: f64,
    rest: [f64; 3],
}

impl Tangents {
    /// Between each tangent and the next, the last one's next being the first a turn on.
    fn arcs(&self) -> impl Iterator<Item = ConeArc> + '_ {
        let next = self.angles_rad.iter().skip(1).copied();
        let wrapped = self.angles_rad.first().map(|first| first + TAU);
        self.angles_rad
            .iter()
            .zip(next.chain(wrapped))
            .map(|(from_rad, to_rad)| self.arc(*from_rad, to_rad))
    }

    fn arc(&self, from_rad: f64, to_rad: f64) -> ConeArc {
        let [from, to] = [from_rad, to_rad].map(|angle| (0.5 * angle).tan());
        let (sum, product) = (from + to, from * to);
        let [_, _, c2, c3, c4] = self.quartic;
        // The quartic divided by (t − from)(t − to).
        let linear = c3 + c4 * sum;
        ConeArc {
            start_rad: self.start_rad,
            from_rad,
            to_rad,
            factor: -1.0 / ((0.5 * from_rad).cos() * (0.5 * to_rad).cos()),
            rest: [c2 + sum * linear - product * c4, linear, c4],
        }
    }
}

impl ConeArc {
    fn middle_rad(&self) -> f64 {
        self.start_rad + 0.5 * (self.from_rad + self.to_rad)
    }

    /// Angle about the axis, and the root of D there, for a parameter 0 … 1.
    fn at(&self, parameter: f64) -> (f64, f64) {
        let width_rad = self.to_rad - self.from_rad;
        // Next to a tangent the range changes like the root of the angle; with this parameter it
        // changes evenly.
        let (sin, cos) = (FRAC_PI_2 * parameter).sin_cos();
        let (done_rad, left_rad) = (width_rad * sin * sin, width_rad * cos * cos);
        let angle_rad = self.from_rad + done_rad;
        let (s, c) = (0.5 * angle_rad).sin_cos();
        let rest = self.rest[0] * c * c + self.rest[1] * c * s + self.rest[2] * s * s;
        let squared = self.factor * (0.5 * done_rad).sin() * (0.5 * left_rad).sin() * rest;
        (self.start_rad + angle_rad, squared.max(0.0).sqrt())
    }
}

/// Where the boundary runs.
enum Outline {
    /// The whole cone meets the body.
    Cone,
    /// The cone holds all that can be seen.
    Horizon,
    /// Both, in order.
    Mixed(Vec<ConeArc>),
}

impl Sight {
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

    /// Whether every ray of the cone's edge meets the body.
    pub(super) fn meets_all_round(&self) -> bool {
        matches!(self.outline(), Some(Outline::Cone))
    }

    /// Where the ray of a cone that meets the body all round meets it, by cosine and sine of its angle.
    pub(super) fn hit_towards(&self, cos: f64, sin: f64) -> DVec3 {
        let (sin_half, cos_half) = self.half_angle_rad.sin_cos();
        let spoke = self.right * cos + self.forward * sin;
        let direction = self.axis * cos_half + spoke * sin_half;
        let scaled = direction / self.radii_m;
        let root = self.discriminant(scaled).max(0.0).sqrt();
        self.apex_ecef + direction * (self.g / (root - self.p.dot(scaled)))
    }

    /// Direction of a ray on the cone's edge, ECEF, unit.
    fn ray(&self, angle_rad: f64) -> DVec3 {
        let (sin_half, cos_half) = self.half_angle_rad.sin_cos();
        self.axis * cos_half + self.spoke(angle_rad) * sin_half
    }

    fn spoke(&self, angle_rad: f64) -> DVec3 {
        let (sin, cos) = angle_rad.sin_cos();
        self.right * cos + self.forward * sin
    }

    /// `D` of a direction of the scaled space.
    fn discriminant(&self, e: DVec3) -> f64 {
        self.bilinear(e, e)
    }

    /// `(p·u)(p·v) − g u·v`, for a far apex as the `u·v − (p×u)·(p×v)` that it is by Binet and
    /// Cauchy: each loses digits where the other keeps them.
    fn bilinear(&self, u: DVec3, v: DVec3) -> f64 {
        if self.g > 1.0 {
            u.dot(v) - self.p.cross(u).dot(self.p.cross(v))
        } else {
            self.p.dot(u) * self.p.dot(v) - self.g * u.dot(v)
        }
    }

    fn meets(&self, angle_rad: f64) -> bool {
        let e = self.ray(angle_rad) / self.radii_m;
        self.p.dot(e) < 0.0 && self.discriminant(e) > 0.0
    }

    /// Where a ray of the cone's edge meets the surface first.
    ///
    /// - `root`: of D; 0 for a ray that touches
    fn hit(&self, angle_rad: f64, root: f64) -> DVec3 {
        let direction = self.ray(angle_rad);
        // The smaller solution without the difference of its numerator.
        let range_m = self.g / (root - self.p.dot(direction / self.radii_m));
        self.apex_ecef + direction * range_m
    }

    /// The same for an edge that is on the body all round.
    fn hit_all_round(&self, angle_rad: f64) -> DVec3 {
        let squared = self.discriminant(self.ray(angle_rad) / self.radii_m);
        self.hit(angle_rad, squared.max(0.0).sqrt())
    }

    /// A point of the horizon, ECEF; counter-clockwise from outside.
    fn horizon(&self, angle_rad: f64) -> DVec3 {
        let (u, v) = self.horizon_axes();
        let squared = self.p.length_squared();
        let (sin, cos) = angle_rad.sin_cos();
        (self.p / squared + (u * cos + v * sin) * (self.g / squared).sqrt()) * self.radii_m
    }

    fn horizon_angle_rad(&self, ecef: DVec3) -> f64 {
        let (u, v) = self.horizon_axes();
        let scaled = ecef / self.radii_m;
        v.dot(scaled).atan2(u.dot(scaled))
    }

    fn horizon_axes(&self) -> (DVec3, DVec3) {
        let up = self.p.normalize();
        let u = up.any_orthonormal_vector();
        (u, up.cross(u))
    }

    /// Angle off the cone's axis under which the apex sees a point.
    fn off_axis_rad(&self, ecef: DVec3) -> f64 {
        let direction = ecef - self.apex_ecef;
        direction
            .cross(self.axis)
            .length()
            .atan2(direction.dot(self.axis))
    }

    fn tangents(&self) -> Tangents {
        // tan ½ψ is infinite at ψ = π: that has to be no root, best the opposite of one.
        let size = |start: &f64| self.discriminant(self.ray(start + PI) / self.radii_m).abs();
        let start = (0..STARTS)
            .map(|k| TAU * f64::from(k) / f64::from(STARTS))
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .unwrap_or(0.0);
        let (sin_half, cos_half) = self.half_angle_rad.sin_cos();
        let a = self.axis * cos_half / self.radii_m;
        let u = self.spoke(start) * sin_half / self.radii_m;
        let v = self.spoke(start + FRAC_PI_2) * sin_half / self.radii_m;
        let q = |x, y| self.bilinear(x, y);
        // D (1 + t²)² with e = a + u cos ψ + v sin ψ and t = tan ½ψ.
        let quartic = [
            q(a, a) + 2.0 * q(a, u) + q(u, u),
            4.0 * (q(a, v) + q(u, v)),
            2.0 * (q(a, a) - q(u, u)) + 4.0 * q(v, v),
            4.0 * (q(a, v) - q(u, v)),
            q(a, a) - 2.0 * q(a, u) + q(u, u),
        ];
        let mut angles_rad: Vec<f64> = real_roots(&quartic)
            .into_iter()
            .map(|t| self.polished(start + 2.0 * t.atan()) - start)
            .collect();
        angles_rad.sort_by(f64::total_cmp);
        Tangents {
            start_rad: start,
            angles_rad,
            quartic,
        }
    }

    /// Newton on D itself, whose products are small near a tangent and keep their digits.
    fn polished(&self, mut angle_rad: f64) -> f64 {
        for _ in 0..POLISHING_STEPS {
            let e = self.ray(angle_rad) / self.radii_m;
            let across = self.spoke(angle_rad + FRAC_PI_2) * self.half_angle_rad.sin();
            let slope = 2.0 * self.bilinear(e, across / self.radii_m);
            let step = self.discriminant(e) / slope;
            // Where two roots meet the slope vanishes; the quartic's answer has to do.
            if step.is_nan() || step.abs() > LONGEST_POLISH_RAD {
                break;
            }
            angle_rad -= step;
        }
        angle_rad
    }

    /// What bounds the footprint; `None` when the cone misses the body.
    fn outline(&self) -> Option<Outline> {
        let arcs: Vec<ConeArc> = self
            .tangents()
            .arcs()
            .filter(|arc| self.meets(arc.middle_rad()))
            .collect();
        if !arcs.is_empty() {
            Some(Outline::Mixed(arcs))
        } else if self.meets(0.0) {
            Some(Outline::Cone)
        } else {
            // Edge and horizon do not meet: all that can be seen is in the cone, or nothing.
            let all_seen = self.off_axis_rad(DVec3::ZERO) < self.half_angle_rad;
            all_seen.then_some(Outline::Horizon)
        }
    }

    /// `None` when the cone misses the body.
    pub(super) fn boundary(&self, body: &Ellipsoid) -> Option<Boundary<'_>> {
        let body = *body;
        let mut bands = Vec::new();
        match self.outline()? {
            Outline::Cone => bands.push(band(TAU, move |t| {
                degrees(&body, self.hit_all_round(TAU * t))
            })),
            Outline::Horizon => {
                bands.push(band(TAU, move |t| degrees(&body, self.horizon(TAU * t))))
            }
            Outline::Mixed(arcs) => {
                let next = arcs.iter().cycle().skip(1);
                for (arc, next) in arcs.iter().zip(next) {
                    bands.push(self.cone_band(body, *arc));
                    bands.extend(self.horizon_band(body, arc, next));
                }
            }
        }
        let legs = (0..bands.len()).map(|band| Leg {
            band,
            curve: 0,
            reversed: false,
        });
        let rings = vec![legs.collect()];
        Some(Boundary { bands, rings })
    }

    /// Smallest angle between the axis and the horizon, radians.
    pub(super) fn horizon_off_axis_rad(&self) -> f64 {
        (0..SEARCHED)
            .map(|k| self.off_axis_rad(self.horizon(TAU * f64::from(k) / f64::from(SEARCHED))))
            .fold(f64::INFINITY, f64::min)
    }

    fn cone_band(&self, body: Ellipsoid, arc: ConeArc) -> Band<'_> {
        band(arc.to_rad - arc.from_rad, move |t| {
            let (angle_rad, root) = arc.at(t);
            degrees(&body, self.hit(angle_rad, root))
        })
    }

    /// From where the cone's edge leaves the body to where it comes back; `None` where that is the
    /// same point.
    fn horizon_band(
        &self,
        body: Ellipsoid,
        leaves: &ConeArc,
        returns: &ConeArc,
    ) -> Option<Band<'_>> {
        let touches = |angle_rad: f64| self.horizon_angle_rad(self.hit(angle_rad, 0.0));
        let from_rad = touches(leaves.start_rad + leaves.to_rad);
        let to_rad = touches(returns.start_rad + returns.from_rad);
        let sweep_rad = (to_rad - from_rad).rem_euclid(TAU);
        let middle = self.horizon(from_rad + 0.5 * sweep_rad);
        let turned_over =
            TAU - sweep_rad < ROUNDED_TURN_RAD && self.off_axis_rad(middle) > self.half_angle_rad;
        if sweep_rad == 0.0 || turned_over {
            return None;
        }
        Some(band(sweep_rad, move |t| {
            degrees(&body, self.horizon(from_rad + sweep_rad * t))
        }))
    }
}

fn band<'a>(angle_rad: f64, curve: impl Fn(f64) -> Degrees + 'a) -> Band<'a> {
    Band {
        curves: vec![Box::new(curve) as Curve<'a>],
        pieces: pieces_of_turn(angle_rad),
    }
}

fn degrees(body: &Ellipsoid, ecef: DVec3) -> Degrees {
    let at = body.ecef_to_geodetic(ecef);
    [at.longitude_rad.to_degrees(), at.latitude_rad.to_degrees()]
}

/// Real roots of a polynomial, ascending; coefficients ascending too, the last one not 0. Roots
/// that only touch may be missing.
///
/// Between neighbouring roots of its derivative a polynomial is monotone: one root or none.
fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let Some((leading, lower)) = coefficients.split_last() else {
        return Vec::new();
    };
    if lower.is_empty() {
        return Vec::new();
    }
    let value = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let derivative: Vec<f64> = (1_u32..)
        .zip(&coefficients[1..])
        .map(|(power, c)| f64::from(power) * c)
        .collect();
    // Cauchy's bound.
    let bound = 1.0
        + lower
            .iter()
            .map(|c| (c / leading).abs())
            .fold(0.0, f64::max);
    let mut ends = vec![-bound];
    ends.extend(real_roots(&derivative));
    ends.push(bound);
    ends.windows(2)
        .filter(|pair| (value(pair[0]) < 0.0) != (value(pair[1]) < 0.0))
        .map(|pair| bisect(value, pair[0], pair[1]))
        .collect()
}

/// To the last bit.
fn bisect(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let starts_below = value(low) < 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if (value(middle) < 0.0) == starts_below {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of `Π (x − root)`, ascending.
    fn expanded(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |product, root| {
            let mut next = vec![0.0; product.len() + 1];
            for (power, c) in product.iter().enumerate() {
                next[power + 1] += c;
                next[power] -= c * root;
            }
            next
        })
    }

    #[test]
    fn roots_come_back_from_the_expanded_polynomial() {
        for roots in [
            vec![-2.0, 0.5, 0.501, 3.0],
            vec![-1e3, -1e-3, 0.0, 7.0],
            vec![4.0],
            vec![-1.0, 1.0],
        ] {
            let found = real_roots(&expanded(&roots));
            assert_eq!(found.len(), roots.len(), "{found:?}");
            for (found, root) in found.iter().zip(&roots) {
                assert!(
                    (found - root).abs() < 1e-9 * (1.0 + root.abs()),
                    "{found} {root}"
                );
            }
        }
        // Twins: none, and one that only touches zero from above.
        assert!(real_roots(&[1.0, 0.0, 1.0]).is_empty());
        assert!(real_roots(&[0.0, 0.0, 1.0]).is_empty());
        assert!(real_roots(&[5.0]).is_empty());
    }

    fn sight(half_angle_deg: f64, elevation_deg: f64) -> Sight {
        let cone = SensorCone {
            apex: Geodetic::from_degrees(20.0, 10.0, 35_786e3),
            azimuth_rad: 0.3,
            elevation_rad: elevation_deg.to_radians(),
            half_angle_rad: half_angle_deg.to_radians(),
        };
        Sight::new(&Ellipsoid::WGS84, &cone)
    }

    #[test]
    fn horizon_and_hits_are_on_the_surface_and_seen_at_their_angles() {
        let sight = sight(3.0, -86.0);
        for k in 0..20 {
            let angle = f64::from(k) * 0.3;
            let horizon = sight.horizon(angle);
            assert!(((horizon / sight.radii_m).length() - 1.0).abs() < 1e-14);
            // The line of sight is at right angles to the normal.
            let normal = horizon / (sight.radii_m * sight.radii_m);
            let slant = (horizon - sight.apex_ecef).normalize();
            assert!(normal.normalize().dot(slant).abs() < 1e-14);
            let hit = sight.hit_all_round(angle);
            assert!(((hit / sight.radii_m).length() - 1.0).abs() < 1e-13);
            assert!((sight.off_axis_rad(hit) - 3_f64.to_radians()).abs() < 1e-14);
            // The near side, not the far one.
            assert!((hit / sight.radii_m).dot(sight.p) > 1.0);
        }
    }

    #[test]
    fn the_discriminant_comes_back_from_its_factors() {
        for (half_angle, elevation) in [(8.0, -84.0), (3.0, -80.0), (20.0, -75.0), (40.0, -50.0)] {
            let sight = sight(half_angle, elevation);
            let largest = (0..64)
                .map(|k| {
                    sight
                        .discriminant(sight.ray(f64::from(k) * 0.1) / sight.radii_m)
                        .abs()
                })
                .fold(0.0, f64::max);
            let tangents = sight.tangents();
            assert_eq!(tangents.angles_rad.len(), 2);
            for arc in tangents.arcs().filter(|arc| sight.meets(arc.middle_rad())) {
                for k in 0..=20 {
                    let (angle, root) = arc.at(f64::from(k) / 20.0);
                    let whole = sight.discriminant(sight.ray(angle) / sight.radii_m);
                    let difference = (root * root - whole).abs();
                    assert!(difference < 1e-13 * largest, "{difference} of {largest}");
                }
            }
        }
    }

    #[test]
    fn a_cone_about_as_wide_as_the_body_crosses_its_horizon_four_times() {
        // From the equator the body is flattened: half angles of 8.68° east, 8.65° north or so.
        let cone = |half_angle_deg: f64| SensorCone {
            apex: Geodetic::from_degrees(0.0, 0.0, 35_786e3),
            azimuth_rad: 0.0,
            elevation_rad: -FRAC_PI_2,
            half_angle_rad: half_angle_deg.to_radians(),
        };
        let crossings = |half_angle_deg: f64| {
            let sight = Sight::new(&Ellipsoid::WGS84, &cone(half_angle_deg));
            sight.tangents().angles_rad.len()
        };
        let (a, distance) = (6_378_137.0_f64, 42_164_137.0_f64);
        let widest = (a / distance).asin().to_degrees();
        assert_eq!(crossings(widest - 0.01), 4);
        assert_eq!(crossings(widest + 1e-6), 0);
        assert_eq!(crossings(widest - 0.1), 0);
        assert_eq!(sight(8.0, -84.0).tangents().angles_rad.len(), 2);
    }
}
