// SPDX-License-Identifier: MIT OR Apache-2.0
//! What single precision and short series move.

use super::*;

/// Median and largest error of a view's vertices, metres, and largest, pixels, of a form in single precision
/// against itself in double precision, from what the buffer holds.
fn rounding(form: Form, height_m: f64) -> [f64; 3] {
    let body = sphere();
    let camera = camera(&body, [-122.4194, 37.7749, height_m], 0.0);
    let spiral = Spiral::new(&body, 36);
    let limits = spiral.limits(&camera, SIZE).expect("above");
    let focus = Focus::new(&body, camera.eye_ecef);
    let layout = lay_out(spiral.steps, spiral.turns(limits), Indices::Watertight);
    let mut metres = Vec::new();
    let mut pixels: f64 = 0.0;
    for place in &layout.places {
        let radius = place.along.map_or(0.0, |along| {
            spiral.law.radius(along, limits.inner, limits.outer)
        });
        let vertex = Attributes::new(Arithmetic::F32, place.angle_rad, radius);
        let [exact, single] = [Arithmetic::F64, Arithmetic::F32]
            .map(|f| focus.vertex_rte((form, Trig::Native, f), vertex));
        metres.push(exact.distance(single));
        pixels = pixels.max(angle(exact, single) * scale());
    }
    metres.sort_by(f64::total_cmp);
    [metres[metres.len() / 2], metres[metres.len() - 1], pixels]
}

#[test]
fn single_precision_moves_vertices_as_computed() {
    // Largest pixels at 1.7 m, 2 km, 100 km and 8,000 km.
    let expected = [
        (Form::LonLat, [503.0, 0.66, 0.013, 2e-4]),
        (Form::Hemisphere, [289.0, 0.33, 0.007, 1e-4]),
        (Form::Local, [0.11, 0.043, 9e-4, 6e-5]),
        (Form::LocalSin2, [5e-5, 8e-5, 7e-5, 6e-5]),
    ];
    for (form, pixels) in expected {
        for (height_m, expected) in [1.7, 2e3, 1e5, 8e6].into_iter().zip(pixels) {
            let [median, largest, found] = rounding(form, height_m);
            eprintln!(
                "{form:?} {height_m} m: {median:.1e} / {largest:.1e} m, {found:.1e} px, computed {expected:.1e}"
            );
            // The place on the body and the order of operations move the figure by less than this.
            assert!(
                (0.3..3.0).contains(&(found / expected)),
                "{form:?} {height_m} {found}"
            );
        }
    }
    for height_m in [1.7, 2e3, 1e5, 1.161e6, 8e6, 1e8] {
        let [_, _, found] = rounding(Form::LocalSin2, height_m);
        assert!(found <= 1e-4, "{height_m} {found}");
    }
    // Negative controls: the absolute forms are hundreds of pixels off at the ground.
    assert!(rounding(Form::LonLat, 1.7)[2] > 200.0);
    assert!(rounding(Form::Hemisphere, 1.7)[2] > 100.0);
}

/// Largest error of a series up to the horizon, pixels.
fn series_px(trig: Trig, height_m: f64) -> f64 {
    let body = sphere();
    let eye = DVec3::new(RADIUS_M + height_m, 0.0, 0.0);
    let focus = Focus::new(&body, eye);
    let horizon = (1.0 + height_m / RADIUS_M).recip().acos();
    let at = |trig, radius| {
        let vertex = Attributes::new(Arithmetic::F64, 0.3, radius);
        focus.vertex_rte((Form::LocalSin2, trig, Arithmetic::F64), vertex)
    };
    let off = (1..=400_u32).map(|step| {
        let radius = horizon * f64::from(step) / 400.0;
        angle(at(trig, radius), at(Trig::Native, radius)) * scale()
    });
    off.fold(0.0, f64::max)
}

#[test]
fn series_are_off_by_the_computed_pixels() {
    let heights = [2e3, 1e5, 1.161e6, 8e6, 1e8];
    let none = f64::NAN;
    for (trig, expected) in [
        (Trig::Taylor(1, 2), [0.0018, 0.63, 17.0, 71.0, 28.0]),
        (Trig::Taylor(3, 2), [6e-4, 0.21, 5.5, 18.0, 4.1]),
        (Trig::Taylor(3, 4), [6e-8, 0.0011, 0.31, 5.2, 3.4]),
        (Trig::Taylor(5, 4), [none, 2e-4, 0.058, 0.70, 0.25]),
    ] {
        let found = heights.map(|height_m| series_px(trig, height_m));
        eprintln!("{trig:?}: {found:.2?} px");
        for (found, expected) in found.into_iter().zip(expected) {
            let is_close = (found / expected - 1.0).abs() < 0.12;
            assert!(expected.is_nan() || is_close, "{trig:?} {found} {expected}");
        }
    }
    for (trig, limit) in [
        (Trig::Taylor(5, 6), 0.19),
        (Trig::Taylor(7, 8), 0.006),
        (Trig::Taylor(9, 10), 1.3e-4),
    ] {
        let found = heights.map(|height_m| series_px(trig, height_m));
        let worst = found.into_iter().fold(0.0, f64::max);
        eprintln!("{trig:?}: at most {worst:.2e} px");
        assert!(
            worst <= 1.05 * limit && worst > 0.5 * limit,
            "{trig:?} {worst}"
        );
    }
}
