// SPDX-License-Identifier: MIT OR Apache-2.0
//! How many texels of its picture a pixel of a region spans at most.
//!
//! Where that is less than one, every fragment's level of detail is 0, and a shader need not look for
//! it. The bound is a formula in `f64`, not a search: a step of the image plane, laid along the line
//! of sight onto the tangent plane, grows by no more than distance / cos θ, and both grow with the
//! angle between the line of sight and the way down (law of sines on the spheres between which the
//! visible surface lies; the ellipsoid's normal is turned from theirs by a bounded angle δ).
//! Metres and radians.

use glam::DVec3;
use terrafill_contract::{FillInput, PlannedTexture};
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_plan::{PixelRect, PlannedRegion};

/// What the bound must be below for level 0: 1, less what rounding in `f32` may add.
const MAGNIFIED_BELOW: f64 = 0.99;

/// Whether every pixel of a region takes level 0 of its picture.
///
/// - `texels`: columns and rows of the picture
/// - `farthest_m`: no point of the region is further from the eye
pub(crate) fn is_magnified(
    input: &FillInput,
    planned: &PlannedRegion,
    texture: &PlannedTexture,
    texels: [u32; 2],
    farthest_m: f64,
) -> bool {
    // A pattern's texels follow the view, with two levels mixed.
    texture.pattern.is_none()
        && largest_footprint(input, planned.screen_rect, texture, texels, farthest_m)
            < MAGNIFIED_BELOW
}

/// Texels that a step to the next pixel spans at most, of those pixels of `rect` that show the region;
/// infinite where no bound is known.
fn largest_footprint(
    input: &FillInput,
    rect: PixelRect,
    texture: &PlannedTexture,
    texels: [u32; 2],
    farthest_m: f64,
) -> f64 {
    let body = &input.scene.body;
    let terrain = input.terrain();
    let [_, south, _, north] = texture.extent_rad;
    let poleward = south.abs().max(north.abs());
    let equatorward = if south <= 0.0 && north >= 0.0 {
        0.0
    } else {
        south.abs().min(north.abs())
    };
    let radius_m = |latitude_rad, height_m| {
        let position = Geodetic {
            longitude_rad: 0.0,
            latitude_rad,
            height_m,
        };
        body.geodetic_to_ecef(position).length()
    };
    let shell = Shell {
        eye_m: input.camera.eye_ecef.length(),
        lowest_m: radius_m(poleward, terrain.lowest_m),
        highest_m: radius_m(equatorward, terrain.highest_m),
        deflection_rad: largest_deflection_rad(body),
    };
    let distance_m = shell
        .farthest_m(widest_angle_rad(input, rect))
        .min(farthest_m);
    let Some(cos_incidence) = shell.least_cos_incidence(distance_m) else {
        return f64::INFINITY;
    };
    // The longer of a pixel's sides; the shorter is not known to be across the picture's coarser axis.
    let tan = input.camera.tan_half_fov();
    let across = 2.0 * tan * input.size.aspect() / f64::from(input.size.width);
    let along = 2.0 * tan / f64::from(input.size.height);
    let step_m = across.max(along) * distance_m / cos_incidence;
    // (N + h) cos φ ≥ (a + h) cos φ and M + h ≥ a (1 − e²) + h.
    let a = body.equatorial_radius_m();
    let axis_distance_m = (a + terrain.lowest_m) * poleward.cos();
    let meridian_m = a * (1.0 - body.eccentricity_squared()) + terrain.lowest_m;
    if axis_distance_m <= 0.0 || meridian_m <= 0.0 {
        return f64::INFINITY;
    }
    let row = |axis: usize| {
        let [by_lon, by_lat, _] = texture.uv_from_angles[axis];
        let count = f64::from(texels[axis]);
        [
            by_lon * count / axis_distance_m,
            by_lat * count / meridian_m,
        ]
    };
    step_m * largest_stretch([row(0), row(1)])
}

/// The larger singular value of a 2 × 2 matrix.
fn largest_stretch([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let squares = a * a + b * b + c * c + d * d;
    let determinant = a * d - b * c;
    let root = (squares * squares - 4.0 * determinant * determinant)
        .max(0.0)
        .sqrt();
    ((squares + root) / 2.0).sqrt()
}

/// The angle between the geodetic normal and the way from the centre at most: that between p and
/// (1, 1, a²/b²) p, whose tangents are in the ratio k = a²/b², is at most atan((k − 1) / (2 √k)).
fn largest_deflection_rad(body: &Ellipsoid) -> f64 {
    let k = (1.0 - body.eccentricity_squared()).recip();
    ((k - 1.0) / (2.0 * k.sqrt())).atan()
}

/// The largest angle between the way to the body's centre and a line of sight through `rect`. Where it
/// is below 90° at the corners, the lines in between are in the same convex cone.
fn widest_angle_rad(input: &FillInput, rect: PixelRect) -> f64 {
    let camera = &input.camera;
    let down = camera.view_from_ecef * -camera.eye_ecef;
    let tan = camera.tan_half_fov();
    let [width, height] = [input.size.width, input.size.height].map(f64::from);
    let columns = [rect.left, rect.right].map(f64::from);
    let rows = [rect.top, rect.bottom].map(f64::from);
    let corners = columns.iter().flat_map(|x| rows.map(|y| (x, y)));
    let angles = corners.map(|(x, y)| {
        let sight = DVec3::new(
            (2.0 * x / width - 1.0) * tan * input.size.aspect(),
            (1.0 - 2.0 * y / height) * tan,
            -1.0,
        );
        sight.angle_between(down)
    });
    angles.fold(0.0, f64::max)
}

/// Spheres about the body's centre between which the visible surface lies, and the eye outside them.
#[derive(Debug, Clone, Copy)]
struct Shell {
    eye_m: f64,
    lowest_m: f64,
    highest_m: f64,
    deflection_rad: f64,
}

impl Shell {
    /// Distance along lines of sight that are no further than `angle_rad` from the way down; infinite
    /// where they pass the lower sphere by or all but touch it.
    fn farthest_m(&self, angle_rad: f64) -> f64 {
        let (sin, cos) = angle_rad.sin_cos();
        let passes_m = self.eye_m * sin;
        let is_clear = cos > 0.0 && passes_m < self.lowest_m * self.deflection_rad.cos();
        if !is_clear {
            return f64::INFINITY;
        }
        let inside_m = (self.lowest_m * self.lowest_m - passes_m * passes_m).sqrt();
        self.eye_m * cos - inside_m
    }

    /// Cosine of the angle between a line of sight and the ellipsoid's normal at a point no further
    /// than `distance_m`; `None` where the point may be seen edge on.
    fn least_cos_incidence(&self, distance_m: f64) -> Option<f64> {
        let (r, s) = (self.highest_m, distance_m);
        let cos = (self.eye_m * self.eye_m - r * r - s * s) / (2.0 * r * s);
        let turned = cos.min(1.0).acos() + self.deflection_rad;
        (cos.is_finite() && cos > 0.0)
            .then(|| turned.cos())
            .filter(|cos| *cos > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Earth's measures; the eye a kilometre above the higher sphere.
    const SHELL: Shell = Shell {
        eye_m: 6_379_000.0,
        lowest_m: 6_377_500.0,
        highest_m: 6_378_000.0,
        deflection_rad: 0.0034,
    };

    #[test]
    fn points_between_the_spheres_are_no_further_and_no_flatter_than_said() {
        for angle_rad in [0.0_f64, 0.3, 0.9, 1.3] {
            let farthest_m = SHELL.farthest_m(angle_rad);
            let least = SHELL.least_cos_incidence(farthest_m);
            for step in 0..=20 {
                let seen = angle_rad * f64::from(step) / 20.0;
                for radius_m in [SHELL.lowest_m, 6_377_800.0, SHELL.highest_m] {
                    // Law of sines: incidence on the sphere, and the distance from it.
                    let incidence = (SHELL.eye_m / radius_m * seen.sin()).asin();
                    let distance_m = SHELL.eye_m * seen.cos() - radius_m * incidence.cos();
                    assert!(
                        distance_m <= farthest_m * (1.0 + 1e-9),
                        "{angle_rad} {seen}"
                    );
                    let turned = (incidence + SHELL.deflection_rad).cos();
                    // Near the horizon the bound is nothing, which is right as well.
                    if let Some(least) = least {
                        assert!(
                            turned >= least - 1e-9,
                            "{angle_rad} {seen}: {turned} {least}"
                        );
                    }
                }
            }
        }
        // Negative control: lines of sight beyond the angle go further.
        assert!(SHELL.farthest_m(0.91) > SHELL.farthest_m(0.9));
    }

    #[test]
    fn what_may_be_seen_edge_on_has_no_bound() {
        assert!(SHELL.farthest_m(1.56).is_infinite());
        assert!(SHELL.farthest_m(2.0).is_infinite());
        assert_eq!(SHELL.least_cos_incidence(f64::INFINITY), None);
        assert_eq!(SHELL.least_cos_incidence(113_000.0), None);
        // Negative control: from close it has.
        assert!(SHELL.least_cos_incidence(2_000.0).is_some());
        // An eye below the surface sees nothing that is known.
        let below = Shell {
            eye_m: 6_377_000.0,
            ..SHELL
        };
        assert_eq!(below.least_cos_incidence(100.0), None);
    }

    #[test]
    fn a_matrix_stretches_no_direction_more_than_its_larger_singular_value() {
        let matrix = [[3.0, -1.0], [0.5, 2.0]];
        let largest = largest_stretch(matrix);
        let mut found = 0.0_f64;
        for step in 0..1000 {
            let (sin, cos) = (f64::from(step) * 0.0032).sin_cos();
            let [[a, b], [c, d]] = matrix;
            found = found.max((a * cos + b * sin).hypot(c * cos + d * sin));
        }
        assert!(found <= largest + 1e-12 && found > 0.9999 * largest);
        // Negative control: the largest of its rows is not enough.
        assert!(found > 10_f64.sqrt());
    }

    #[test]
    fn the_normal_of_no_latitude_is_turned_more_than_said() {
        let body = Ellipsoid::WGS84;
        let bound = largest_deflection_rad(&body);
        let mut found = 0.0_f64;
        for step in 0..=900 {
            let latitude_rad = f64::from(step) * 1e-3_f64 * std::f64::consts::FRAC_PI_2 / 0.9;
            let position = Geodetic {
                longitude_rad: 0.0,
                latitude_rad,
                height_m: 0.0,
            };
            let way = body.geodetic_to_ecef(position);
            found = found.max(
                body.geodetic_surface_normal(0.0, latitude_rad)
                    .angle_between(way),
            );
        }
        assert!(
            found <= bound + 1e-9 && found > 0.9999 * bound,
            "{found} {bound}"
        );
    }
}
