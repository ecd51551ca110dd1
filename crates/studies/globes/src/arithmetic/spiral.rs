// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral's vertices by their forms: how far single precision and short series move them, and how many rings
//! each law of radii needs.

use super::table;
use glam::DVec3;
use std::sync::Arc;
use terrafill_globe_views::{Eye, Opened, ViewRow};
use terrafill_plot::number::significant;
use terrafill_spiral::SpiralKind;
use terrafill_surface::{Surface, SurfaceFrame, SurfaceKind};
use toml::Value;

const KINDS: &[&dyn SurfaceKind] = &[&SpiralKind];

/// Heights of the eye, metres.
const HEIGHTS_M: [f64; 6] = [1.7, 2e3, 1e5, 1.161e6, 8e6, 1e8];
/// Heights from which rings are counted: those for which the facts print them.
const RING_HEIGHTS_M: [f64; 3] = [2e3, 1e4, 1e5];
/// Rows of the picture that pixels are of.
const ROWS_PX: u32 = 1080;
const FORMS: [&str; 4] = ["lonlat", "hemisphere", "local", "local-sin2"];
const SERIES: [&str; 7] = ["1/2", "3/2", "3/4", "5/4", "5/6", "7/8", "9/10"];
const LAWS: [&str; 5] = [
    "exponential",
    "published",
    "quadratic",
    "equal-area",
    "linear",
];
/// Vertices of a turn where rings are counted: as many as there may be, so that what is left is the rings' sag.
const RING_VERTICES: i64 = 288;
/// What no one sees, pixels.
const FINE_PX: f64 = 0.25;
/// Turns to double the radius that the surface allows at least, and at most.
const MIN_DOUBLING: f64 = 0.3;
const MAX_DOUBLING: f64 = 64.0;
/// More than any law needs.
const MAX_RINGS: u32 = 1200;

fn surface<'a, V: Into<Value>>(set: impl IntoIterator<Item = (&'a str, V)>) -> Arc<dyn Surface> {
    let surface = Opened::new(KINDS).get("spiral", set);
    surface.expect("a surface")
}

/// Largest distance on the screen between a view's vertices made by one and by the other of two sets of parameters,
/// pixels. In `f64`, before a frame rounds them.
fn moved_px(height_m: f64, sets: [[(&str, &str); 2]; 2]) -> f64 {
    let eye = eye(height_m);
    let [exact, other] = sets.map(|set| {
        let vertices = surface(set).exact_vertices(&eye.camera, eye.size);
        vertices.expect("a view").expect("it says them in f64")
    });
    assert_eq!(exact.len(), other.len());
    let pairs = exact.iter().zip(&other);
    let px = pairs.map(|(a, b)| angle(*a, *b) * eye.focal_px());
    px.max_by(f64::total_cmp).expect("vertices")
}

/// A form of position in single precision against itself in double precision, both from what a buffer of f32 holds.
fn form_px(form: &str, height_m: f64) -> f64 {
    let form = ("frame", form);
    let precisions = ["buffer", "f32"];
    moved_px(
        height_m,
        precisions.map(|precision| [form, ("precision", precision)]),
    )
}

/// A series against the functions; on the horizon, so that both meshes end where the series is asked for.
fn series_px(series: &str, height_m: f64) -> f64 {
    let sets = ["native", series].map(|trig| [("rim", "horizon"), ("trig", trig)]);
    moved_px(height_m, sets)
}

/// The fewest rings with which no edge sags by more than a quarter of a pixel.
fn rings(eye: &Eye, law: &str) -> u32 {
    let frame = |doubling: f64| {
        let set = [
            ("law", Value::from(law)),
            ("n", RING_VERTICES.into()),
            ("std", doubling.into()),
            ("rim", "horizon".into()),
        ];
        let frame = surface(set).frame(&eye.camera, eye.size);
        frame.expect("a frame")
    };
    // Rings of a mesh: two triangles a vertex and ring, and the fan.
    let rings =
        |frame: &SurfaceFrame| (frame.triangles.len() as f64 / RING_VERTICES as f64 - 1.0) / 2.0;
    let doublings = rings(&frame(10.0)) / 10.0;
    let is_fine = |count: u32| worst_sag_px(&frame(f64::from(count) / doublings), eye) <= FINE_PX;
    // The surface allows no fewer turns.
    let mut low = whole((MIN_DOUBLING * doublings).ceil());
    let mut high = low + 1;
    let most = whole(MAX_DOUBLING * doublings).min(MAX_RINGS);
    while !is_fine(high) {
        assert!(high < most, "{law}: more than {high} rings");
        (low, high) = (high, (2 * high).min(most));
    }
    while high - low > 1 {
        let middle = (low + high) / 2;
        if is_fine(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[allow(clippy::cast_possible_truncation, reason = "a small number of turns")]
fn whole(turns: f64) -> u32 {
    turns as u32
}

/// Over one place, level, so that the horizon is seen.
fn eye(height_m: f64) -> Eye {
    let view = ViewRow {
        longitude_deg: -122.4194,
        latitude_deg: 37.7749,
        height_m,
        ..ViewRow::default()
    };
    view.eye(ROWS_PX)
}

/// Angle between two directions; exact for small ones.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Largest distance on the screen between the middle of an edge and the place of the body over it, pixels. The
/// fan's spokes are left out: they are no rings.
fn worst_sag_px(frame: &SurfaceFrame, eye: &Eye) -> f64 {
    let place = |at: u32| DVec3::from(frame.vertices_rte[at as usize].map(f64::from));
    let mut worst = 0.0_f64;
    let triangles = frame.triangles.iter();
    for triangle in triangles.filter(|triangle| !triangle.contains(&0)) {
        for i in 0..3 {
            let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(place);
            let middle = 0.5 * (a + b);
            let place = eye.body.ecef_to_geodetic(eye.camera.eye_ecef + middle);
            let off = angle(middle, eye.below(place) - eye.camera.eye_ecef);
            worst = worst.max(off * eye.focal_px());
        }
    }
    worst
}

/// The same from the law's own formula, on a sphere. A ring from `r` to `r + Δ` sags by `s = R Δ² / 8`. From `h` it is
/// seen as `f s g / (h² + g²)`, `g = R r`.
fn rings_by_formula(law: &str, height_m: f64) -> u32 {
    let eye = eye(height_m);
    let focal_px = eye.focal_px();
    let radius_m = eye.body.equatorial_radius_m();
    let outer = (radius_m / (radius_m + height_m)).acos();
    let inner = 50.0 * height_m / (focal_px * radius_m);
    let radius = |along: f64| {
        let exponential = inner * (outer / inner).powf(along);
        match law {
            "published" => {
                let share = ((exponential - inner) / (outer - inner)).max(0.0);
                inner + share.sqrt() * (outer - inner)
            }
            "quadratic" => (inner.sqrt() + along * (outer.sqrt() - inner.sqrt())).powi(2),
            "equal-area" => (inner.powi(2) + along * (outer.powi(2) - inner.powi(2))).sqrt(),
            "linear" => inner + along * (outer - inner),
            _ => exponential,
        }
    };
    let sag_px = |from: f64, to: f64| {
        let sag_m = radius_m * (to - from).powi(2) / 8.0;
        let ground_m = radius_m * 0.5 * (from + to);
        focal_px * sag_m * ground_m / (height_m * height_m + ground_m * ground_m)
    };
    let is_fine = |count: &u32| {
        let at = |ring: u32| radius(f64::from(ring) / f64::from(*count));
        (0..*count).all(|ring| sag_px(at(ring), at(ring + 1)) <= FINE_PX)
    };
    (1..MAX_RINGS).find(is_fine).unwrap_or(MAX_RINGS)
}

pub(super) fn page() -> String {
    let rows = |names: &[&str], heights: &[f64], figure: &dyn Fn(&str, f64) -> String| {
        let row = |name: &&str| {
            let figures = heights.iter().map(|height_m| figure(name, *height_m));
            std::iter::once((*name).to_owned()).chain(figures).collect()
        };
        names.iter().map(row).collect::<Vec<Vec<String>>>()
    };
    let px = |names, figure: fn(&str, f64) -> f64| {
        let headings = [
            "",
            "1.7 m",
            "2 km",
            "100 km",
            "1,161 km",
            "8,000 km",
            "100,000 km",
        ];
        table(
            &headings,
            rows(names, &HEIGHTS_M, &|name, height_m| {
                // Smaller ones hang on the system's last digits of sines.
                match figure(name, height_m) {
                    small if small < 1e-6 => "< 1e-6".to_owned(),
                    px => significant(px),
                }
            }),
        )
    };
    let (forms, series) = (px(&FORMS, form_px), px(&SERIES, series_px));
    let counts = |law: &str, height_m: f64| {
        format!(
            "{}, {}",
            rings(&eye(height_m), law),
            rings_by_formula(law, height_m)
        )
    };
    let rings = rows(&LAWS, &RING_HEIGHTS_M, &counts);
    let rings = table(&["law", "2 km", "10 km", "100 km"], rings);
    format!(
        "## Vertices of the spiral

Seen level from a height, in a picture of 1,080 rows and 60°, up to the horizon. Single precision is emulated; sines are
rounded from f64, and a device's are worse.

A form in single precision against itself in double precision, largest, px. From 1.7 m absolute forms are hundreds of
pixels off, the focus-local form with −2 sin²(r/2) at most 1e-4.
{forms}
A Taylor series of sine and cosine against the functions, largest, px. Gebbie & Bailey say that artefacts of low orders
“are not noticeable”. At 3/2 that is so up to 100 km, where they are below ¼ px, and not from 1,161 km on. At 5/6 they are
below ¼ px from every height.
{series}
Fewest rings with which no edge between two of them sags by more than ¼ px: found, and by the law's formula.
{rings}"
    )
}

#[test]
fn absolute_forms_and_short_series_are_seen_and_others_are_not() {
    assert!(form_px("lonlat", 1.7) > 200.0 && form_px("hemisphere", 1.7) > 100.0);
    assert!(form_px("local", 1.7) < 0.3);
    for height_m in HEIGHTS_M {
        let found = form_px("local-sin2", height_m);
        assert!(found <= 1e-4, "{height_m} {found}");
    }
    let worst = HEIGHTS_M.map(|height_m| series_px("5/6", height_m));
    assert!(worst.iter().all(|px| *px <= 0.2), "{worst:?}");
    assert!(worst.iter().any(|px| *px > 0.1), "{worst:?}");
    // What the page says of third order.
    assert!(series_px("3/2", 1e5) < FINE_PX && series_px("3/2", 1.161e6) > 1.0);
    // Negative control: a shorter series.
    assert!(series_px("3/4", 8e6) > 4.0);
}

#[test]
fn rings_are_those_of_the_formula() {
    for (law, facts) in [("exponential", 24), ("published", 12), ("quadratic", 7)] {
        let [found, expected] = [rings(&eye(2e3), law), rings_by_formula(law, 2e3)];
        assert!(u32::abs_diff(expected, facts) <= 1, "{law} {expected}");
        assert!(found.abs_diff(expected) <= 1, "{law} {found} {expected}");
    }
    // Negative control: another law's formula.
    assert!(rings_by_formula("exponential", 2e3) > 2 * rings_by_formula("quadratic", 2e3));
}
