// SPDX-License-Identifier: MIT OR Apache-2.0
//! Projections of Gebbie and Bailey: a hyperbolic map by polar or by Cartesian coordinates, and a dome. What comes out
//! fills −1 … 1. The paper prints no formulas; these are those of Bailey's shader textbook.

use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// How far from the focus studies reach half of a hyperbolic map's rim, radii of the body.
pub const HALF_RIM: f64 = 0.5;

/// `(x, y) / (ρ + K)`: radius `r' = ρ / (ρ + K)`, the angle stays.
pub fn hyperbolic_polar([x, y]: [f64; 2], k: f64) -> [f64; 2] {
    let from = x.hypot(y) + k;
    // At the middle of a map with K = 0 all directions are one.
    if from > 0.0 {
        [x / from, y / from]
    } else {
        [0.0; 2]
    }
}

/// `x / √(x² + K²)`, each axis by itself.
pub fn hyperbolic_cartesian(x: f64, k: f64) -> f64 {
    let from = x.hypot(k);
    if from > 0.0 { x / from } else { 0.0 }
}

/// Share of a quarter turn from straight ahead, in the direction where it is seen; the view looks along −z.
pub fn dome(view: DVec3) -> [f64; 2] {
    let across = view.x.hypot(view.y);
    let share = across.atan2(-view.z) / FRAC_PI_2;
    if across > 0.0 {
        [view.x, view.y].map(|at| share * at / across)
    } else {
        [0.0; 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_go_to_their_rim_and_back() {
        for at in [0.1, 1.0, 3.0] {
            let [x, y] = hyperbolic_polar([0.6 * at, 0.8 * at], HALF_RIM);
            let radius = x.hypot(y);
            assert!((HALF_RIM * radius / (1.0 - radius) - at).abs() < 1e-12);
            assert!((y / x - 0.8 / 0.6).abs() < 1e-12);
            let x = hyperbolic_cartesian(at, HALF_RIM);
            assert!((HALF_RIM * x / (1.0 - x * x).sqrt() - at).abs() < 1e-12);
        }
        // HALF_RIM = 0 sends all to the rim, HALF_RIM = ∞ to the middle.
        assert_eq!(hyperbolic_polar([3.0, 4.0], 0.0), [0.6, 0.8]);
        assert_eq!(hyperbolic_polar([3.0, 4.0], f64::INFINITY), [0.0; 2]);
        assert_eq!(hyperbolic_cartesian(-2.0, 0.0), -1.0);
        assert_eq!(hyperbolic_cartesian(-2.0, f64::INFINITY), 0.0);
        for at in [
            hyperbolic_polar([0.0; 2], 0.0),
            dome(DVec3::ZERO),
            dome(DVec3::NEG_Z),
        ] {
            assert_eq!(at, [0.0; 2]);
        }
        assert!((dome(DVec3::X)[0] - 1.0).abs() < 1e-12);
        assert!((dome(DVec3::new(1.0, 0.0, -1.0))[0] - 0.5).abs() < 1e-12);
        assert!(hyperbolic_cartesian(0.0, 0.0).abs() < 1e-12);
    }
}
