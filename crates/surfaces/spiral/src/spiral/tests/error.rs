// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far facets are from the body, and how many rings a law needs.

use super::*;

/// Worst distance on the screen between a place of a facet and the place of the body over or under it, pixels.
/// With it the lowest such place, metres. Both as far as the horizon.
///
/// - `is_longer`: whether the mesh ends a turn behind the horizon, so that facets there are as large as others
fn geometric_error(spiral: &Spiral, height_m: f64, is_longer: bool) -> ([f64; 2], usize) {
    let camera = camera(&spiral.body, [10.0, 20.0, height_m], 0.0);
    let mut limits = spiral.limits(&camera, SIZE).expect("above");
    if is_longer {
        limits.outer *= (1.0 / spiral.doubling).exp2();
    }
    let (mesh, _) = spiral.mesh(&camera, limits);
    let horizon = (1.0 + height_m / RADIUS_M).recip().acos();
    let (mut worst, mut lowest) = (0.0_f64, 0.0_f64);
    const PARTS: u32 = 12;
    for triangle in mesh.triangles.iter() {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices_ecef[vertex as usize]);
        for i in 0..=PARTS {
            for j in 0..=PARTS - i {
                let [u, v] = [i, j].map(|at| f64::from(at) / f64::from(PARTS));
                let place = a * (1.0 - u - v) + b * u + c * v;
                if angle(place, camera.eye_ecef) > horizon {
                    continue;
                }
                let true_place = place.normalize() * RADIUS_M;
                let off = angle(place - camera.eye_ecef, true_place - camera.eye_ecef);
                worst = worst.max(off * scale());
                lowest = lowest.min(place.length() - RADIUS_M);
            }
        }
    }
    ([worst, lowest], mesh.triangles.len())
}

#[test]
fn the_geometric_error_is_the_computed_one() {
    let horizon = |height_m: f64| (1.0 + height_m / RADIUS_M).recip().acos();
    for n in [36, 72] {
        let spiral = Spiral::new(&sphere(), n);
        for height_m in [1.7, 2e3, 1e4, 1.161e6, 8e6] {
            let ([found, lowest], _) = geometric_error(&spiral, height_m, true);
            let ([drawn, _], triangles) = geometric_error(&spiral, height_m, false);
            let r = horizon(height_m);
            let q = TAU / f64::from(n);
            let sag = q * q * (r * r + r.sin().powi(2)) / 8.0;
            let to_horizon = (height_m * (2.0 * RADIUS_M + height_m)).sqrt();
            let formula = scale() * RADIUS_M * sag / to_horizon;
            eprintln!(
                "n {n}, {height_m} m: {found:.4} px, by formula {formula:.4} px; lowest {lowest:.2} m, by \
                 formula {:.2} m; as drawn, ending on the horizon, {drawn:.4} px, {triangles} triangles",
                -RADIUS_M * sag
            );
            assert!((found / formula - 1.0).abs() < 0.05, "{n} {height_m}");
            assert!(
                (lowest / (-RADIUS_M * sag) - 1.0).abs() < 0.05,
                "{n} {height_m}"
            );
        }
    }
    let published =
        |height_m: f64| geometric_error(&Spiral::new(&sphere(), 36), height_m, true).0[0];
    for (height_m, expected) in [(2e3, 0.17), (8e6, 3.4)] {
        let found = published(height_m);
        assert!((found / expected - 1.0).abs() < 0.05, "{height_m} {found}");
    }
    // Negative control: a coarser spiral has another error.
    let ([coarse, _], _) = geometric_error(&Spiral::new(&sphere(), 24), 2e3, true);
    assert!(coarse / 0.17 > 2.0, "{coarse}");
}

/// The fewest turns with which no turn's radial sag is more than a quarter of a pixel.
fn turns_for_a_quarter(law: Law, height_m: f64) -> u32 {
    let outer = (1.0 + height_m / RADIUS_M).recip().acos();
    let inner = 50.0 * height_m / (scale() * RADIUS_M);
    let sag_px = |from: f64, to: f64| {
        let sag_m = RADIUS_M * (to - from).powi(2) / 8.0;
        let ground_m = RADIUS_M * 0.5 * (from + to);
        scale() * sag_m * ground_m / (height_m * height_m + ground_m * ground_m)
    };
    let worst = |turns: u32| {
        let radius = |at: u32| law.radius(f64::from(at) / f64::from(turns), inner, outer);
        (0..turns)
            .map(|at| sag_px(radius(at), radius(at + 1)))
            .fold(0.0, f64::max)
    };
    let mut all = 1..1000;
    all.find(|&turns| worst(turns) <= 0.25).expect("enough")
}

#[test]
fn laws_need_the_computed_turns_for_a_quarter_of_a_pixel() {
    for (height_m, expected) in [
        (2e3, [24, 12, 7, 347, 19]),
        (1e4, [32, 16, 10, 440, 22]),
        (1e5, [47, 24, 17, 261, 22]),
    ] {
        let found = laws().map(|law| turns_for_a_quarter(law, height_m));
        eprintln!("{height_m} m: turns {found:?} by {:?}", laws());
        for (found, expected) in found.into_iter().zip(expected) {
            // The sheet rounds hundreds of turns.
            let allowed = if expected > 100 { expected / 100 } else { 0 };
            assert!(
                found.abs_diff(expected) <= allowed,
                "{height_m} {found} {expected}"
            );
        }
    }
}
