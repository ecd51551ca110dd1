// SPDX-License-Identifier: MIT OR Apache-2.0
//! The grid on the screen. Its map's largest error straight down is compared with a fitted formula and with one in
//! closed form. Triangles across ±180° that the published rule leaves as they are, are counted.
//!
//! In closed form, for an eye that looks down: the corner cells' triangles have a diagonal of `d` metres on the ground.
//! Under its middle the facet hangs `d² / 8R` deep, and a ray that meets it at the angle `i` with the normal is moved by
//! `tan i` of that, outwards. Longitude and Mercator's latitude are bent by `tan φ` of it, at 45° to that. Together they
//! are `d² / 8R · √(tan² i + tan² φ + √2 tan i tan φ)`.

use super::{numbers, table};
use crate::error::MapCorners;
use glam::DVec3;
use std::f64::consts::{SQRT_2, TAU};
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_globe_views::{Eye, Opened, ViewRow};
use terrafill_maps::{MapPoint, half_plane_crossings};
use terrafill_plot::number::significant;
use terrafill_reference::SurfaceTriangles;
use terrafill_scene::{Camera, CameraPose, ImageSize};
use terrafill_screen_grid::ScreenGridKind;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&ScreenGridKind];

/// Cells a side, latitudes and heights for which the fit is said to hold to 12 %.
const CELLS: [u32; 3] = [5, 10, 20];
const LATITUDES_DEG: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 75.0, 84.0];
const HEIGHTS_M: [f64; 3] = [1e3, 1e4, 1e5];
/// The closed form leaves out what is of higher order in the cell, and that the body is no sphere; 2 % were found.
const ALLOWED_SHARE: f64 = 0.04;
/// Parts of an edge between places at which a facet's map is compared; even, so that a diagonal's middle is one.
const PARTS: u32 = 4;

/// Views over which triangles across ±180° are counted, as many as in the facts.
const VIEWS: u32 = 1500;
/// Differences of U beyond which an edge is split: as published, and half a turn.
const LIMITS: [f64; 2] = [0.7, 0.5];
/// A ray and the body's normal at a tangent, where the body is the unit sphere; straight down from 1 km they are 1.6e-4.
const TANGENT: f64 = 1e-9;
const SIDE_PX: u32 = 800;

/// Triangles of a view in `f64`, relative to the eye.
fn triangles(n: u32, camera: &Camera, size: ImageSize) -> Vec<[DVec3; 3]> {
    let surface = Opened::new(KINDS).get("screen-grid", [("n", n)]);
    let surface = surface.expect("a surface");
    let vertices = surface.exact_vertices(camera, size).expect("a view");
    let vertices = vertices.expect("it says them in f64");
    let frame = surface.frame(camera, size).expect("a view");
    let triangles = frame.triangles.iter();
    triangles
        .map(|triangle| triangle.map(|at| vertices[at as usize]))
        .collect()
}

/// Found, and by the fit and the closed form, metres.
fn nadir(n: u32, latitude_deg: f64, height_m: f64) -> [f64; 3] {
    let eye = eye(latitude_deg, height_m);
    let triangles = triangles(n, &eye.camera, eye.size);
    [
        worst_map_m(&eye, &triangles),
        fitted_m(n, &eye),
        closed_m(n, &eye),
    ]
}

fn seam(limit: f64) -> Seam {
    let mut counted = Seam::default();
    for number in 0..VIEWS {
        let (n, camera, size) = view(number);
        for triangle in triangles(n, &camera, size) {
            counted.add(camera.eye_ecef, triangle, limit);
        }
    }
    counted
}

/// An eye that looks straight down.
fn eye(latitude_deg: f64, height_m: f64) -> Eye {
    let row = ViewRow {
        longitude_deg: 15.0,
        latitude_deg,
        height_m,
        pitch_deg: -90.0,
        ..ViewRow::default()
    };
    row.eye(SIDE_PX)
}

/// Largest distance on the ground between the place that a map shows on a facet and the place behind it, metres.
fn worst_map_m(eye: &Eye, triangles: &[[DVec3; 3]]) -> f64 {
    let body = SurfaceTriangles::of_body(&eye.body, eye.camera.eye_ecef);
    let mut worst = 0.0_f64;
    for &facet in triangles {
        let [a, b, c] = facet;
        for i in 0..=PARTS {
            for j in 0..=PARTS - i {
                let [u, v] = [i, j].map(|at| f64::from(at) / f64::from(PARTS));
                let point = a * (1.0 - u - v) + b * u + c * v;
                let Some(depth) = body.hit(point, 0.0) else {
                    continue;
                };
                let normal = MapCorners::default().between(eye, facet, point);
                let shown = eye.body.surface_point(normal);
                let place = eye.camera.eye_ecef + point * depth;
                worst = worst.max(shown.distance(place));
            }
        }
    }
    worst
}

/// `(1.3 + 2 tan φ) s² / 8R`, a fit: `s` the side of a cell below the eye, `φ` its latitude.
fn fitted_m(n: u32, eye: &Eye) -> f64 {
    let side_m = 2.0 * eye.pose.eye.height_m * eye.camera.tan_half_fov() / f64::from(n);
    let tan = eye.pose.eye.latitude_rad.abs().tan();
    (1.3 + 2.0 * tan) * side_m * side_m / (8.0 * eye.body.equatorial_radius_m())
}

/// In closed form, of the corner cell nearest to a pole.
fn closed_m(n: u32, eye: &Eye) -> f64 {
    let radius_m = eye.body.equatorial_radius_m();
    let beyond = 1.0 + eye.pose.eye.height_m / radius_m;
    let tan = eye.camera.tan_half_fov();
    // Along the picture's diagonal, as the tangent of the angle from straight down.
    let middle = SQRT_2 * tan * (1.0 - 1.0 / f64::from(n));
    let half = SQRT_2 * tan / f64::from(n);
    let incidence = |t: f64| (beyond * t.atan().sin()).asin();
    let ground = |t: f64| incidence(t) - t.atan();
    let long = radius_m * (ground(middle + half) - ground(middle - half));
    let slope = incidence(middle).tan();
    let latitude = eye.pose.eye.latitude_rad.abs() + ground(middle) / SQRT_2;
    let bend = latitude.tan();
    let both = slope * slope + bend * bend + SQRT_2 * slope * bend;
    long * long / (8.0 * radius_m) * both.sqrt()
}

/// Triangles across ±180°.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Seam {
    /// That hold no pole.
    crossing: u32,
    /// Of them, those of which no edge is split: the rule inserts nothing.
    untouched: u32,
    /// Of them, those of which one edge is split and two cross: a part is still wrong.
    partly: u32,
    with_pole: u32,
    /// Of `crossing` and `untouched`, those with a corner whose ray met the body.
    crossing_met: u32,
    untouched_met: u32,
}

impl Seam {
    /// - `triangle`: relative to the eye, metres
    fn add(&mut self, eye_ecef: DVec3, triangle: [DVec3; 3], limit: f64) {
        let corners_ecef = triangle.map(|corner| corner + eye_ecef);
        // A ray that misses the body has its corner moved to where one is tangent.
        let is_met = triangle.iter().any(|corner| !is_tangent(eye_ecef, *corner));
        match half_plane_crossings(corners_ecef) {
            0 => return,
            2 => {
                self.crossing += 1;
                self.crossing_met += u32::from(is_met);
            }
            // The axis passes through it: U is no function there, and no rule is right.
            _ => {
                self.with_pole += 1;
                return;
            }
        }
        let [a, b, c] = corners_ecef.map(|corner| MapPoint::new(&Ellipsoid::WGS84, corner).u);
        let split = [(a, b), (b, c), (c, a)]
            .iter()
            .filter(|(p, q)| (p - q).abs() > limit)
            .count();
        match split {
            0 => {
                self.untouched += 1;
                self.untouched_met += u32::from(is_met);
            }
            1 => self.partly += 1,
            _ => {}
        }
    }
}

/// Whether the ray to a place on the body is a tangent there.
///
/// - `ray`: from the eye to the place, metres
fn is_tangent(eye_ecef: DVec3, ray: DVec3) -> bool {
    let body = Ellipsoid::WGS84;
    let [a, b] = [body.equatorial_radius_m(), body.polar_radius_m()];
    // Where the body is the unit sphere, its normal is the place itself.
    let radii_m = DVec3::new(a, a, b);
    let (place, ray) = ((eye_ecef + ray) / radii_m, ray / radii_m);
    place.dot(ray).abs() <= TANGENT
}

/// One of many views straight down that lie evenly among all: over the sphere, between 1 km and 100,000 km, of any
/// heading, 1 to 20 cells a side. By multiples of powers of an irrational number (Roberts, 2018).
#[allow(clippy::cast_possible_truncation, reason = "a small number")]
fn view(number: u32) -> (u32, Camera, ImageSize) {
    // The root of x⁶ = x + 1.
    const ROOT: f64 = 1.134_724_138_401_519_4;
    let at = |power: i32| (f64::from(number + 1) * ROOT.powi(-power)).fract();
    let pose = CameraPose {
        eye: Geodetic {
            longitude_rad: TAU * (at(1) - 0.5),
            latitude_rad: (2.0 * at(2) - 1.0).asin(),
            height_m: 10_f64.powf(3.0 + 5.0 * at(3)),
        },
        heading_rad: TAU * at(4),
        pitch_rad: -0.5 * std::f64::consts::PI,
        fov_y_rad: 60_f64.to_radians(),
        near_m: 1.0,
    };
    let size = ImageSize::new(SIDE_PX, SIDE_PX);
    let n = 1 + (20.0 * at(5)) as u32;
    (n, Camera::new(&Ellipsoid::WGS84, &pose), size)
}

fn per_cent(share: f64) -> String {
    format!("{:+.1}", 100.0 * share)
}

pub(super) fn page() -> String {
    let row = |n: u32, latitude_deg: f64| {
        let mut row = numbers([n.into(), latitude_deg]);
        for height_m in HEIGHTS_M {
            let [found, fitted, closed] = nadir(n, latitude_deg, height_m);
            let off = [fitted, closed].map(|formula| per_cent(found / formula - 1.0));
            row.extend(std::iter::once(significant(found)).chain(off));
        }
        row
    };
    let rows = CELLS
        .iter()
        .flat_map(|n| LATITUDES_DEG.map(|latitude| row(*n, latitude)));
    let headings = [
        "N",
        "latitude, °",
        "1 km: found, m",
        "over the fit, %",
        "over the closed form, %",
        "10 km: found",
        "fit",
        "closed",
        "100 km: found",
        "fit",
        "closed",
    ];
    let nadir = table(&headings, rows);
    let rows = LIMITS.map(|limit| {
        let seam = seam(limit);
        let counts = [
            seam.crossing,
            seam.untouched,
            seam.untouched + seam.partly,
            seam.with_pole,
            seam.crossing_met,
            seam.untouched_met,
        ];
        numbers(std::iter::once(limit).chain(counts.map(f64::from)))
    });
    let headings = [
        "where U differs by",
        "crossing",
        "untouched",
        "not split on both edges",
        "with a pole",
        "crossing, a corner met",
        "of them untouched",
    ];
    let seams = table(&headings, rows);
    format!(
        "## The grid on the screen

An eye that looks straight down: how far the place that a map shows on a facet is from the place behind it, largest, on
the ground. The fit (1.3 + 2 tan φ) s²/8R has one constant where the closed form has 2√2 tan(fov/2) (1 − 1/N): 1.31 for
5 cells, 1.47 for 10 and 1.55 for 20. Over the equator nothing but the slope of the ray is left.
{nadir}
Triangles across ±180° by the rule that splits them, over {VIEWS} views straight down from 1 km to 100,000 km, of 1 to 20
cells. The published 0.7 leaves some untouched, those over 108° wide; the facts count 45 of 2,713 with a corner whose ray
met the body. 0.5 misses none.
{seams}"
    )
}

#[test]
fn the_closed_form_is_what_facets_do_and_the_fit_is_within_12_per_cent_off_the_equator() {
    for (n, latitude_deg, height_m) in [(5, 0.0, 1e3), (10, 15.0, 1e5), (20, 84.0, 1e4)] {
        let [found, fitted, closed] = nadir(n, latitude_deg, height_m);
        let off = |formula: f64| (found / formula - 1.0).abs();
        assert!(off(closed) < ALLOWED_SHARE, "{closed}");
        assert!(n != 10 || off(fitted) < 0.12, "{fitted}");
        // Negative control: the closed form of another grid.
        let other = closed_m(n + 1, &eye(latitude_deg, height_m));
        assert!(off(other) > ALLOWED_SHARE);
    }
    // Four times the cells, a sixteenth of the error.
    let [coarse, fine] = [5, 20].map(|n| nadir(n, 45.0, 1e4)[0]);
    let slope = (fine / coarse).ln() / 4_f64.ln();
    assert!((-2.2..-1.8).contains(&slope), "{slope}");
}

#[test]
fn the_published_rule_leaves_some_triangles_untouched_and_half_a_turn_none() {
    let [published, half] = LIMITS.map(seam);
    assert!(published.crossing > 300 && published.crossing == half.crossing);
    assert_eq!(half.untouched + half.partly, 0);
    let share = |found: u32, of: u32| f64::from(found) / f64::from(of);
    // As many as the facts count among triangles with a corner on the body: 45 of 2,713.
    let met = share(published.untouched_met, published.crossing_met);
    assert!((0.01..0.026).contains(&met), "{met}");
    // Negative controls: those at the limb alone are more often left untouched, and more are split on one edge alone.
    let at_limb = share(
        published.untouched - published.untouched_met,
        published.crossing - published.crossing_met,
    );
    assert!(at_limb > 0.026 && published.partly > 0, "{at_limb}");
}
