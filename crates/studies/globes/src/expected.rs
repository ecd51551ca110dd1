// SPDX-License-Identifier: MIT OR Apache-2.0
//! What formulas say of a surface's error in a view.
//!
//! A triangle with corners on the body hangs below it by at most `r² / 2R`, `r` the radius of its smallest
//! circle. Where a ray meets it `s` below the body, the foot of the place is seen `s · sin i · f / d` from
//! the pixel's centre. There `i` is the ray's angle with the normal, `d` its length, `f` pixels per radian. Both are
//! put together by projecting each pixel's true place raised by `s`.

use crate::error::{Truth, shift_px};
use crate::list::Formula;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_globe_views::Eye;

/// Highest eye for which the formula of the screen grid's map error was found to hold, metres.
const SCREEN_GRID_MAX_HEIGHT_M: f64 = 1e5;

/// How far facets may hang for their error to be that of the true place raised, as a share of the eye's
/// height: beyond it the ray meets them much farther away.
const MAX_HANG_SHARE: f64 = 0.05;

/// What is expected.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Expected {
    /// Largest error, pixels.
    pub(crate) px_max: Option<f64>,
    /// Largest error of a map's coordinates, metres on the ground.
    pub(crate) map_max_m: Option<f64>,
    /// Lowest place that is seen, metres.
    pub(crate) lowest_m: Option<f64>,
    /// The formula, as written in reports.
    pub(crate) by: &'static str,
}

/// Of a surface with this knob.
///
/// - `truths`: of the same eye
pub(crate) fn expected(
    formula: Formula,
    knob: f64,
    eye: &Eye,
    truths: &[Option<Truth>],
) -> Expected {
    match formula {
        Formula::None => Expected {
            by: "no formula",
            ..Expected::default()
        },
        Formula::ScreenError => Expected {
            px_max: Some(knob),
            by: "the surface's own promise, for heights seen side-on",
            ..Expected::default()
        },
        Formula::CellShare => {
            // A tile's cells are as its nearest place allows, so this is the most.
            let by = "κ² d² (1 + cos² φ) / 8R at most, κ = cell / distance";
            hanging(eye, truths, by, |truth, radius_m| {
                let side_m = knob * truth.ecef.distance(eye.camera.eye_ecef);
                side_m * side_m * (1.0 + squared_cosine(truth)) / (8.0 * radius_m)
            })
        }
        Formula::Uniform => {
            let step = PI / knob;
            let by = "R q² (1 + cos² φ) / 8, q = π / rows";
            // Half the diagonal of a cell is the radius of the circle around its triangles.
            hanging(eye, truths, by, |truth, radius_m| {
                radius_m * step * step * (1.0 + squared_cosine(truth)) / 8.0
            })
        }
        Formula::Spiral => {
            let step = TAU / knob;
            let radii = eye.body.radii_m();
            let focus = (eye.camera.eye_ecef / radii).normalize();
            let by = "R q² (r² + sin² r) / 8, q = 2π / n, cells square";
            hanging(eye, truths, by, |truth, radius_m| {
                let there = (truth.ecef / radii).normalize();
                let angle = focus.angle_between(there);
                radius_m * step * step * (angle * angle + angle.sin().powi(2)) / 8.0
            })
        }
        Formula::ScreenGrid => screen_grid(knob, eye),
    }
}

/// Of a place's latitude.
fn squared_cosine(truth: &Truth) -> f64 {
    truth.normal.x * truth.normal.x + truth.normal.y * truth.normal.y
}

/// Largest error and lowest place where facets hang by `sagitta_m` below each place that is seen.
fn hanging(
    eye: &Eye,
    truths: &[Option<Truth>],
    by: &'static str,
    sagitta_m: impl Fn(&Truth, f64) -> f64 + Sync,
) -> Expected {
    let radius_m = eye.body.equatorial_radius_m();
    let found = eye.by_pixel(|pixel, centre, _| {
        let truth = truths[pixel].as_ref()?;
        let sagitta = sagitta_m(truth, radius_m);
        let raised = truth.ecef + truth.normal * sagitta;
        Some([shift_px(eye, raised, centre), -sagitta])
    });
    let all = |which: usize| found.iter().flatten().map(move |found| found[which]);
    let lowest_m = all(1).reduce(f64::min);
    let most_m = MAX_HANG_SHARE * eye.pose.eye.height_m;
    let is_shallow = lowest_m.is_some_and(|lowest_m| -lowest_m <= most_m);
    Expected {
        px_max: all(0).reduce(f64::max).filter(|_| is_shallow),
        lowest_m,
        by,
        ..Expected::default()
    }
}

fn screen_grid(rects: f64, eye: &Eye) -> Expected {
    let (height_m, radius_m) = (eye.pose.eye.height_m, eye.body.equatorial_radius_m());
    let tan = eye.camera.tan_half_fov();
    let side_px = f64::from(eye.size.height);
    let looks_down = eye.pose.pitch_rad == -FRAC_PI_2;
    let disc_px = 0.5 * side_px / tan * (radius_m / (radius_m + height_m)).asin().tan();
    if looks_down && disc_px < 0.5 * side_px {
        return Expected {
            lowest_m: Some(-radius_m * side_px / rects / (4.0 * disc_px)),
            by: "−R c / 4ρ, c = cell, ρ = disc, pixels",
            ..Expected::default()
        };
    }
    if looks_down && height_m <= SCREEN_GRID_MAX_HEIGHT_M {
        let cell_m = 2.0 * height_m * tan / rects;
        let latitude = eye.pose.eye.latitude_rad.abs();
        return Expected {
            map_max_m: Some((1.3 + 2.0 * latitude.tan()) * cell_m * cell_m / (8.0 * radius_m)),
            by: "(1.3 + 2 tan φ) s² / 8R, s = cell on the ground",
            ..Expected::default()
        };
    }
    Expected {
        by: "no formula for this view",
        ..Expected::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::{of_frame, truths};
    use crate::list::List;
    use glam::DVec3;
    use terrafill_core::Ellipsoid;
    use terrafill_surface::EllipsoidKind;

    fn eye(name: &str, side_px: u32) -> Eye {
        let list = List::shipped().expect("a list");
        list.view(name).expect("the view").eye(side_px)
    }

    #[test]
    fn facets_of_a_uniform_grid_err_as_their_sagitta_says() {
        for (view, rows, at_least) in [
            ("globe", 45, 0.8),
            ("globe-pole", 45, 0.8),
            ("nadir-1161km", 90, 0.8),
            // Of the horizon few pixels are seen, none of them where a facet hangs deepest.
            ("oblique-100km", 180, 0.75),
        ] {
            let eye = eye(view, 120);
            let surface = EllipsoidKind::surface(&Ellipsoid::WGS84, rows);
            let frame = surface.frame(&eye.camera, eye.size).expect("a frame");
            let found = of_frame(&eye, &truths(&eye), &frame);
            let of = |rows: u32| expected(Formula::Uniform, f64::from(rows), &eye, &truths(&eye));
            let holds = |expected: Expected| {
                let px = found.px.expect("pixels").max / expected.px_max.expect("px");
                let low = found.lowest_m.expect("low") / expected.lowest_m.expect("low");
                (at_least..1.02).contains(&px) && (at_least..1.02).contains(&low)
            };
            assert!(
                holds(of(rows)),
                "{view}: {:?} {:?} {:?}",
                found.px,
                found.lowest_m,
                of(rows)
            );
            // Negative controls: the formula for a grid half as fine, and twice as fine.
            assert!(!holds(of(rows / 2)) && !holds(of(rows * 2)), "{view}");
            assert_eq!(found.non_finite, 0);
        }
    }

    #[test]
    fn formulas_reproduce_the_published_facts() {
        // A sphere of 6,371 km and 1,080 pixels there, WGS84 and the same pixels here.
        for (height_m, n, px) in [(2e3, 36.0, 0.17), (1.161e6, 36.0, 3.3), (8e6, 36.0, 3.4)] {
            let mut view = List::shipped().expect("a list").view[0].clone();
            (view.height_m, view.latitude_deg) = (height_m, 0.0);
            let eye = view.eye(1080);
            // All round: the horizon is reached by no ray of a view that looks down from 2 km, so the
            // formula is taken at the horizon itself.
            let radius_m = 6_371_008.8;
            let angle = (radius_m / (radius_m + height_m)).acos();
            let length_m = (height_m * (2.0 * radius_m + height_m)).sqrt();
            let f = 0.5 * 1080.0 / eye.camera.tan_half_fov();
            let q = TAU / n;
            let closed =
                f * radius_m * q * q * (angle * angle + angle.sin().powi(2)) / (8.0 * length_m);
            // The facts are of meshes, of which the formula is 5 % too high.
            assert!((1.0..1.06).contains(&(closed / px)), "{height_m}: {closed}");
            if height_m > 7e6 {
                // Seen whole, at the limb: rays there are 7 % off the axis times its cosine squared.
                let found = expected(Formula::Spiral, n, &eye, &truths(&eye))
                    .px_max
                    .expect("px");
                let off_axis = 1.0 / (radius_m / (radius_m + height_m)).asin().cos().powi(2);
                assert!(
                    (found / (closed * off_axis) - 1.0).abs() < 0.03,
                    "{found} {closed}"
                );
                // Negative control: with other turns.
                let other = expected(Formula::Spiral, 24.0, &eye, &truths(&eye))
                    .px_max
                    .expect("px");
                assert!((other / (closed * off_axis) - 1.0).abs() > 0.5);
            }
        }
        // Facets 0.4 km below the body are close to it seen from 100 km, and not from 2 km.
        let of = |view| {
            let eye = eye(view, 8);
            expected(Formula::Uniform, 180.0, &eye, &truths(&eye)).px_max
        };
        assert!(of("horizon-2km").is_none() && of("oblique-100km").is_some());
        let globe = eye("globe", 800);
        let lowest = |n| {
            expected(Formula::ScreenGrid, n, &globe, &[])
                .lowest_m
                .expect("low")
                * 1e-3
        };
        for (n, km) in [(10.0, -372.0), (20.0, -186.0), (40.0, -93.0)] {
            assert!((lowest(n) / km - 1.0).abs() < 0.01, "{n}: {}", lowest(n));
        }
        assert_eq!(
            expected(Formula::ScreenGrid, 10.0, &eye("horizon-2km", 8), &[]).px_max,
            None
        );
    }

    #[test]
    fn the_sky_and_a_lost_facet_are_told_from_the_body() {
        let eye = eye("globe", 64);
        let surface = EllipsoidKind::surface(&Ellipsoid::WGS84, 18);
        let mut frame = surface.frame(&eye.camera, eye.size).expect("a frame");
        let right = of_frame(&eye, &truths(&eye), &frame);
        assert_eq!((right.uncovered_px, right.extra_px), (0, 0));
        let middle = 32 * 64 + 32;
        assert!(right.shown[middle] && !right.shown[0]);
        // Negative controls: a surface with a hole, one that is too large, and a corner that is lost.
        let near = |triangle: &&[u32; 3]| {
            let corners =
                triangle.map(|v| DVec3::from(frame.vertices_rte[v as usize].map(f64::from)));
            let lengths = corners.map(DVec3::length);
            // What lies beyond the horizon would show through the hole.
            lengths
                .iter()
                .all(|length| (8.5e6..1.35e7).contains(length))
        };
        let holed = frame.triangles.iter().filter(near).copied().collect();
        let whole = std::mem::replace(&mut frame.triangles, holed);
        assert!(of_frame(&eye, &truths(&eye), &frame).uncovered_px > 0);
        frame.triangles = whole;
        let small = frame.clone();
        let away = |v: &[f32; 3]| {
            let ecef = eye.camera.eye_ecef + DVec3::from(v.map(f64::from));
            (ecef * 1.1 - eye.camera.eye_ecef).as_vec3().to_array()
        };
        frame.vertices_rte = frame.vertices_rte.iter().map(away).collect();
        assert!(of_frame(&eye, &truths(&eye), &frame).extra_px > 0);
        let mut lost = small.vertices_rte.to_vec();
        lost[100] = [f32::NAN; 3];
        frame.vertices_rte = lost.into();
        assert!(of_frame(&eye, &truths(&eye), &frame).non_finite > 0);
    }
}
