// SPDX-License-Identifier: MIT OR Apache-2.0
//! An Earth's five layers as functions of direction, in `f64`. What a shader shows of their pictures is held against
//! them, so that error is that of pictures, normals and arithmetic.
//!
//! Waves of few lengths stand for land: their slopes are known exactly, which bumps need.

use crate::list::Eye;
use glam::{DMat3, DVec3};

/// Directions, lengths and phases of the waves: a golden-angle spiral of directions.
const WAVES: usize = 9;
/// Slope of the ground times this is what bumps show.
pub(crate) const BUMP: f64 = 0.25;
/// Exponent of the highlight.
const SHINE: i32 = 200;

/// What the shader leaves out: the number of features removed, in the order of the paper's Table 3.
pub(crate) type Removed = u32;

fn wave(i: usize) -> (DVec3, f64) {
    let at = i as f64 + 0.5;
    let z = 1.0 - 2.0 * at / WAVES as f64;
    let (sin, cos) = (at * 2.399_963_229_728_653).sin_cos();
    let across = (1.0 - z * z).sqrt();
    // From 3 to 11 waves round the body.
    let count = 3.0 + i as f64;
    (DVec3::new(across * cos, across * sin, z) * count, at)
}

/// Height, −1 … 1 about, and its gradient in space.
pub(crate) fn height(direction: DVec3) -> (f64, DVec3) {
    let mut sum = 0.0;
    let mut gradient = DVec3::ZERO;
    for i in 0..WAVES {
        let (along, phase) = wave(i);
        let (sin, cos) = (direction.dot(along) + phase).sin_cos();
        let share = 1.0 / (3.0 + i as f64);
        sum += share * sin;
        gradient += along * (share * cos);
    }
    (sum, gradient)
}

/// 0 … 1, smooth.
fn step(from: f64, to: f64, at: f64) -> f64 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn mixed(a: DVec3, b: DVec3, share: f64) -> DVec3 {
    a + (b - a) * share
}

/// Colour, and water as its fourth.
pub(crate) fn base(direction: DVec3) -> [f64; 4] {
    let (height, _) = height(direction);
    let land = step(-0.1, 0.15, height);
    let ground = mixed(
        DVec3::new(0.16, 0.34, 0.12),
        DVec3::new(0.55, 0.46, 0.33),
        step(0.2, 0.9, height),
    );
    let snow = step(0.80, 0.95, direction.z.abs());
    let ground = mixed(ground, DVec3::splat(0.85), snow);
    let colour = mixed(DVec3::new(0.03, 0.10, 0.30), ground, land);
    [colour.x, colour.y, colour.z, 1.0 - land]
}

/// East along the parallel, and any direction across at a pole, as the shader takes it.
fn tangent(n: DVec3) -> DVec3 {
    let across = n.x.hypot(n.y);
    if across > 1e-6 {
        DVec3::new(-n.y, n.x, 0.0) / across
    } else {
        DVec3::Y
    }
}

/// The bent normal: shares along normal, tangent and binormal, of length 1.
pub(crate) fn bump(n: DVec3) -> [f64; 3] {
    let (_, gradient) = height(n);
    let t = tangent(n);
    let b = n.cross(t);
    let bent = DVec3::new(1.0, -BUMP * gradient.dot(t), -BUMP * gradient.dot(b));
    bent.normalize().to_array()
}

/// White of clouds.
pub(crate) fn cloud(direction: DVec3) -> f64 {
    let (height, _) = height(DVec3::new(direction.y, direction.z, direction.x));
    0.9 * step(0.25, 1.0, height)
}

/// Lights of night on land.
pub(crate) fn night(direction: DVec3) -> [f64; 3] {
    let (height, _) = height(direction);
    let (other, _) = self::height(DVec3::new(direction.z, direction.x, direction.y));
    let share = step(0.0, 0.2, height) * step(0.1, 0.6, other);
    [0.9 * share, 0.7 * share, 0.35 * share]
}

/// What all fragments share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lights {
    /// Towards the sun, of length 1.
    pub(crate) sun: DVec3,
    /// By which clouds are looked up.
    pub(crate) clouds: DMat3,
}

/// Low in the west, so that day, night and highlight are in every view of a globe.
pub(crate) fn lights(eye: &Eye) -> Lights {
    let up = eye.camera.eye_ecef.normalize();
    let west = up.cross(DVec3::Z).try_normalize().unwrap_or(DVec3::NEG_Y);
    Lights {
        sun: (0.25 * up + 0.9 * west + 0.2 * DVec3::Z).normalize(),
        clouds: DMat3::from_rotation_z(0.3),
    }
}

/// A fragment's colour.
///
/// - `n`: geodetic normal
/// - `to_eye`: of any length
pub(crate) fn colour(lights: &Lights, removed: Removed, n: DVec3, to_eye: DVec3) -> DVec3 {
    if removed >= 6 {
        return DVec3::ONE;
    }
    let [r, g, b, water] = base(n);
    let m = if removed < 4 {
        let [along, east, north] = bump(n);
        let mut t = tangent(n);
        if removed >= 3 {
            // Without its length made 1 it is as long as the parallel is wide.
            t *= n.x.hypot(n.y);
        }
        (along * n + east * t + north * n.cross(t)).normalize()
    } else {
        n
    };
    let mut colour = DVec3::new(r, g, b) * m.dot(lights.sun).clamp(0.0, 1.0);
    if removed < 5 {
        let half_way = m.dot((lights.sun + to_eye.normalize()).normalize());
        colour += DVec3::splat(half_way.max(0.0).powi(SHINE) * water);
    }
    let level = n.dot(lights.sun).clamp(0.0, 1.0);
    if removed < 1 {
        colour += DVec3::splat(cloud(lights.clouds * n) * level);
    }
    if removed < 2 {
        colour += DVec3::from(night(n)) * (1.0 - (10.0 * level).clamp(0.0, 1.0));
    }
    colour
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_the_height_s() {
        for i in 0..50_u32 {
            let at = f64::from(i);
            let place = DVec3::new(at.sin(), (1.7 * at).cos(), (0.9 * at).sin());
            let place = place.normalize();
            let (here, gradient) = height(place);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let (there, _) = height(place + 1e-6 * axis);
                assert!(((there - here) / 1e-6 - gradient.dot(axis)).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn features_removed_change_the_colour_and_poles_are_finite() {
        let lights = Lights {
            sun: DVec3::new(1.0, 1.0, 0.2).normalize(),
            clouds: DMat3::from_rotation_z(0.4),
        };
        let mut changed = [0_u32; 6];
        for i in 0..200_u32 {
            let at = f64::from(i);
            let n = DVec3::new(at.sin(), (2.3 * at).cos(), (0.7 * at).sin()).normalize();
            let all: Vec<DVec3> = (0..7)
                .map(|removed| colour(&lights, removed, n, n))
                .collect();
            for (changed, pair) in changed.iter_mut().zip(all.windows(2)) {
                *changed += u32::from((pair[0] - pair[1]).length() > 1e-3);
            }
        }
        assert!(changed.iter().all(|count| *count > 3), "{changed:?}");
        for pole in [DVec3::Z, -DVec3::Z] {
            assert!(colour(&lights, 0, pole, pole).is_finite());
        }
        let [along, east, north] = bump(DVec3::X);
        assert!((along * along + east * east + north * north - 1.0).abs() < 1e-12);
    }
}
