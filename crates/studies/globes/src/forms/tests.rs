// SPDX-License-Identifier: MIT OR Apache-2.0
//! Forms, series and rings by the surface itself.

use super::*;
use terrafill_spiral::SpiralKind;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

fn figure(forms: &Forms, what: What, height_m: f64, name: &str) -> f64 {
    let case = forms.work.iter().position(|work| *work == (what, height_m));
    let figures = forms.figures(case.expect("planned")).expect("figures");
    let mut found = figures.iter().filter(|(known, _)| *known == name);
    found.next().expect("the figure").1
}

#[test]
fn frames_show_what_forms_and_series_cost() {
    let forms = Forms::new(&Rc::new(Opened::new(KINDS)));
    let px = |what, height_m| figure(&forms, what, height_m, "globe_form_px_max");
    // Absolute forms are hundreds of pixels off at the ground; local ones are not.
    assert!(px(What::Form("lonlat"), 1.7) > 200.0);
    assert!(px(What::Form("hemisphere"), 1.7) > 100.0);
    assert!(px(What::Form("local"), 1.7) < 0.3);
    for height_m in HEIGHTS_M {
        let found = px(What::Form("local-sin2"), height_m);
        eprintln!("local-sin2, {height_m} m: {found:.2e} px");
        assert!(found <= 1e-4, "{height_m} {found}");
    }
    let worst = HEIGHTS_M.map(|height_m| px(What::Series("5/6"), height_m));
    assert!(worst.iter().all(|px| *px <= 0.2), "{worst:?}");
    assert!(worst.iter().any(|px| *px > 0.1), "{worst:?}");
    assert!(px(What::Series("3/4"), 8e6) > 4.0);
}

#[test]
fn rings_of_frames_are_those_of_the_formula() {
    let forms = Forms::new(&Rc::new(Opened::new(KINDS)));
    for (law, facts) in [
        ("exponential", 24.0),
        ("published", 12.0),
        ("quadratic", 7.0),
    ] {
        let [found, expected] = ["globe_form_rings", "globe_form_expected_rings"]
            .map(|name| figure(&forms, What::Rings(law), 2e3, name));
        eprintln!("{law}: {found} rings, {expected} by the formula");
        assert!((expected - facts).abs() <= 1.0, "{law} {expected}");
        assert!((found - expected).abs() <= 1.0, "{law} {found} {expected}");
    }
    // Twin: another law's formula.
    assert!(rings_by_formula("exponential", 2e3) > 2 * rings_by_formula("quadratic", 2e3));
}
