// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays from the eye to the body, in the space scaled by 1 / radii, where the body is the unit sphere.
//!
//! Points are relative to the eye, so that nothing is lost when it is near. Numbers of equations are
//! those of A. Jeromel's paper (StuCoSReC 2018, pp. 39–42).

use glam::DVec3;
use terrafill_core::{Ellipsoid, nearest_f32};

/// In what arithmetic vertices are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rays {
    /// All in `f64`.
    #[default]
    F64,
    /// All in `f32` but `‖c‖² − 1`, which is formed in `f64`.
    F32WithC64,
    /// All in `f32`: `‖c‖² − 1` cancels.
    F32,
}

impl Rays {
    /// Every arithmetic, with its name in scene files.
    pub const ALL: [(&'static str, Self); 3] = [
        ("f64", Self::F64),
        ("f32-c64", Self::F32WithC64),
        ("f32", Self::F32),
    ];

    /// What is kept of a result. Rounding each operation of `f64` to `f32` gives what `f32` gives: 53 bits
    /// are more than 2 · 24 + 2 (Figueroa, 1995, for + − × ÷ √).
    fn kept(self, x: f64) -> f64 {
        match self {
            Self::F64 => x,
            Self::F32WithC64 | Self::F32 => f64::from(nearest_f32(x)),
        }
    }

    fn kept_vector(self, v: DVec3) -> DVec3 {
        DVec3::new(self.kept(v.x), self.kept(v.y), self.kept(v.z))
    }

    fn times(self, v: DVec3, factor: f64) -> DVec3 {
        self.kept_vector(v * factor)
    }

    fn dot(self, a: DVec3, b: DVec3) -> f64 {
        let products = self.kept_vector(a * b);
        self.kept(self.kept(products.x + products.y) + products.z)
    }
}

/// An eye above a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eye {
    rays: Rays,
    radii_m: DVec3,
    /// From the body's centre, scaled.
    pub(crate) scaled: DVec3,
    /// `‖c‖² − 1`.
    pub(crate) beyond: f64,
    /// `‖c‖²` and `‖c‖`.
    squared: f64,
    length: f64,
}

impl Eye {
    /// `None` on the body and below it.
    pub(crate) fn new(body: &Ellipsoid, eye_ecef: DVec3, rays: Rays) -> Option<Self> {
        let radii_m = body.radii_m();
        let scaled = rays.kept_vector(eye_ecef / radii_m);
        let squared = rays.dot(scaled, scaled);
        let beyond = match rays {
            Rays::F32 => rays.kept(squared - 1.0),
            Rays::F64 | Rays::F32WithC64 => rays.kept(beyond(body, eye_ecef)),
        };
        (beyond > 0.0).then_some(Self {
            rays,
            radii_m,
            scaled,
            beyond,
            squared,
            length: rays.kept(squared.sqrt()),
        })
    }

    /// Where a ray meets the body, relative to the eye, metres; eq. (1). `None` where it misses.
    pub(crate) fn hit(&self, direction_ecef: DVec3) -> Option<DVec3> {
        let rays = self.rays;
        let d = self.scaled_direction(direction_ecef);
        let b = rays.dot(d, self.scaled);
        let dd = rays.dot(d, d);
        let under_root = rays.kept(rays.kept(b * b) - rays.kept(dd * self.beyond));
        if b >= 0.0 || under_root < 0.0 {
            return None;
        }
        let t = rays.kept(self.beyond / rays.kept(rays.kept(under_root.sqrt()) - b));
        Some(rays.times(d, t) * self.radii_m)
    }

    /// Where the horizon is in the direction of a ray that misses, relative to the eye, metres; eqs. (2)
    /// to (4) in closed form: `c / ‖c‖² + (√(‖c‖² − 1) / ‖c‖) â`, with `â` the ray's part across `c`.
    pub(crate) fn tangent(&self, direction_ecef: DVec3) -> DVec3 {
        let rays = self.rays;
        let d = self.scaled_direction(direction_ecef);
        let across = |v: DVec3| {
            let along = rays.kept(rays.dot(v, self.scaled) / self.squared);
            rays.kept_vector(v - rays.times(self.scaled, along))
        };
        // What is left of a ray that goes straight up is rounding, and not across before the second time.
        self.horizon(across(across(d)))
    }

    /// The point of the horizon in the direction `across`, scaled and at right angles to the eye's own.
    pub(crate) fn horizon(&self, across: DVec3) -> DVec3 {
        let rays = self.rays;
        let length = rays.kept(rays.dot(across, across).sqrt());
        // Straight up every direction is as near as any other.
        let unit = if length > 0.0 {
            rays.kept_vector(across / length)
        } else {
            self.scaled.normalize().any_orthonormal_vector()
        };
        let down = rays.kept(self.beyond / self.squared);
        let out = rays.kept(rays.kept(self.beyond.sqrt()) / self.length);
        rays.kept_vector(rays.times(unit, out) - rays.times(self.scaled, down)) * self.radii_m
    }

    /// Positive where a ray passes through the body or, backwards, would: `(D·c)² − k D·D` as a form of two
    /// rays, so that its roots on a line between them are found.
    pub(crate) fn form(&self, one_ecef: DVec3, other_ecef: DVec3) -> f64 {
        let (one, other) = (one_ecef / self.radii_m, other_ecef / self.radii_m);
        one.dot(self.scaled) * other.dot(self.scaled) - self.beyond * one.dot(other)
    }

    /// Whether a ray goes down.
    pub(crate) fn is_ahead(&self, direction_ecef: DVec3) -> bool {
        (direction_ecef / self.radii_m).dot(self.scaled) < 0.0
    }

    fn scaled_direction(&self, direction_ecef: DVec3) -> DVec3 {
        self.rays.kept_vector(direction_ecef / self.radii_m)
    }
}

/// `‖S⁻¹(foot + h n)‖² − 1 = 2h (S⁻² foot)·n + h² (S⁻² n)·n`, since the foot is on the body: what is 0 is
/// left out, and nothing cancels. On a sphere this is `h (2R + h) / R²`.
fn beyond(body: &Ellipsoid, eye_ecef: DVec3) -> f64 {
    let eye = body.ecef_to_geodetic(eye_ecef);
    let normal = body.geodetic_surface_normal(eye.longitude_rad, eye.latitude_rad);
    let foot = eye_ecef - normal * eye.height_m;
    let radii_squared = body.radii_m() * body.radii_m();
    let of = |v: DVec3| (v / radii_squared).dot(normal);
    eye.height_m * (2.0 * of(foot) + eye.height_m * of(normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;

    fn eye_at(body: &Ellipsoid, latitude_deg: f64, height_m: f64) -> DVec3 {
        body.geodetic_to_ecef(Geodetic::from_degrees(33.0, latitude_deg, height_m))
    }

    #[test]
    fn the_closed_form_is_the_papers_tangent_point_and_touches_the_body() {
        let body = Ellipsoid::WGS84;
        for height_m in [1.7, 2e3, 1.161e6, 8e6, 1e8] {
            let at = eye_at(&body, 20.0, height_m);
            let eye = Eye::new(&body, at, Rays::F64).expect("above");
            for direction in [
                DVec3::new(0.3, -0.2, 0.9),
                DVec3::new(0.1, 1.0, 0.0),
                at * 1e-7,
            ] {
                let c = eye.scaled;
                let point = eye.tangent(direction) / body.radii_m();
                let t = c + point;
                let out = (t.length() - 1.0).abs();
                assert!(out < 2e-15 * (2.0 + c.length()), "{height_m}: {out}");
                let off = t.dot(point) / point.length();
                assert!(off.abs() < 1e-9, "{height_m}: {off}");
                // Eqs. (3) and (4) as restored, of a unit sphere.
                let d = direction / body.radii_m();
                let a = d - c * (d.dot(c) / c.length_squared());
                if a.length() < 1e-12 * d.length() {
                    continue;
                }
                let root = (c.length_squared() - 1.0).sqrt();
                let b = a.normalize() * (c.length() / root);
                let printed = c + (b - c).normalize() * root;
                assert!((printed - t).length() < 1e-8, "{height_m}");
            }
        }
    }

    #[test]
    fn a_low_eye_loses_nothing_in_f64_and_metres_in_f32() {
        // The sheet of a sphere: 1e-7 m at 1.7 m with k from f64, 19 % of the distance without.
        let body = Ellipsoid::new("sphere", 6_378_137.0, 6_378_137.0).expect("a body");
        let (mut exact, mut mixed, mut single) = (0.0_f64, 0.0_f64, 0.0_f64);
        for i in 0..40 {
            let at = eye_at(&body, 1.0 + f64::from(i) * 2.0, 1.7);
            let down = -at.normalize();
            let level = down.any_orthonormal_vector();
            let direction = down + level * 0.3;
            let expected = {
                // The same by Newton's method on the height along the ray.
                let mut t = 1.7;
                for _ in 0..50 {
                    let p = direction * t;
                    let height = 1.7 - down.dot(p)
                        + (p - down * down.dot(p)).length_squared() / 2.0 / 6.378e6;
                    t += height;
                }
                direction.length() * t
            };
            let off = |rays: Rays| {
                let eye = Eye::new(&body, at, rays).expect("above");
                let hit = eye.hit(direction).expect("the ground");
                (hit.length() - expected).abs()
            };
            exact = exact.max(off(Rays::F64));
            mixed = mixed.max(off(Rays::F32WithC64));
            single = single.max(off(Rays::F32));
        }
        eprintln!("1.7 m: f64 {exact:.1e} m, f32-c64 {mixed:.1e} m, f32 {single:.1e} m");
        assert!(exact < 1e-8, "{exact}");
        assert!(mixed < 5e-7, "{mixed}");
        // Negative control.
        assert!(single > 0.05, "{single}");
    }

    #[test]
    fn on_the_body_and_below_there_is_no_eye() {
        for body in [
            Ellipsoid::WGS84,
            Ellipsoid::SATURN_LIKE,
            Ellipsoid::UNIT_SPHERE,
        ] {
            let size = body.equatorial_radius_m();
            for latitude in [0.0, 45.0, 90.0] {
                let is_above = |height: f64| {
                    Eye::new(&body, eye_at(&body, latitude, height * size), Rays::F64).is_some()
                };
                assert!(is_above(1e-12) && !is_above(-1e-12) && !is_above(-0.5));
            }
        }
        let body = Ellipsoid::WGS84;
        let on = DVec3::new(body.equatorial_radius_m(), 0.0, 0.0);
        assert!(Eye::new(&body, on, Rays::F64).is_none());
    }
}
