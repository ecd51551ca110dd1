// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is known of the grid on the screen without a device. Its map's largest error straight down stands beside the
//! fitted formula and one in closed form. Triangles across ±180° are counted that the published rule leaves as they are.
//!
//! In closed form, for an eye that looks down: the corner cells' triangles have a diagonal of `d` metres on the ground.
//! Under its middle the facet hangs `d² / 8R` deep, and a ray that meets it at the angle `i` with the normal is moved by
//! `tan i` of that, outwards. Longitude and Mercator's latitude are bent by `tan φ` of it, at 45° to that. Together they
//! are `d² / 8R · √(tan² i + tan² φ + √2 tan i tan φ)`.

mod section;

pub(crate) use section::blocks;

use crate::STUDY;
use crate::error::on_map;
use crate::keys;
use crate::keys::{HEIGHT_M, LATITUDE_DEG, LIMIT, WHAT};
use crate::list::{Eye, ViewRow};
use crate::opened::Opened;
use glam::DVec3;
use std::f64::consts::{SQRT_2, TAU};
use std::rc::Rc;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_maps::{MapPoint, half_plane_crossings};
use terrafill_plot::number::significant;
use terrafill_reference::SurfaceTriangles;
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_scene::{Camera, CameraPose, ImageSize};
use terrafill_study::{
    CaseSession, Context, Failure, Figures, Group, Measures, Session, StudyError, judged,
};
use toml::{Table, Value};

/// Name of this part in cases.
pub(crate) const PART: &str = "grid-facts";
const KIND: &str = "screen-grid";

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

#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    /// Cells a side, latitude and height.
    Nadir(u32, f64, f64),
    /// The limit.
    Seam(f64),
}

/// All of it.
pub(crate) struct GridFacts {
    work: Vec<What>,
    cases: Vec<PlannedCase>,
    opened: Rc<Opened>,
}

impl GridFacts {
    pub(crate) fn new(opened: &Rc<Opened>) -> Self {
        let mut work = Vec::new();
        for height_m in HEIGHTS_M {
            for latitude_deg in LATITUDES_DEG {
                work.extend(CELLS.map(|n| What::Nadir(n, latitude_deg, height_m)));
            }
        }
        work.extend(LIMITS.map(What::Seam));
        let cases = work.iter().map(|what| {
            let (name, set) = match what {
                What::Nadir(n, latitude_deg, height_m) => (
                    format!("nadir/n={n}/latitude={latitude_deg}/height={height_m}"),
                    vec![
                        (WHAT, "nadir".to_owned()),
                        (keys::CELLS, n.to_string()),
                        (LATITUDE_DEG, latitude_deg.to_string()),
                        (HEIGHT_M, height_m.to_string()),
                    ],
                ),
                What::Seam(limit) => (
                    format!("seam/limit={limit}"),
                    vec![
                        (WHAT, "seam".to_owned()),
                        (LIMIT, limit.to_string()),
                        (keys::VIEWS, VIEWS.to_string()),
                    ],
                ),
            };
            let conditions = [(keys::PART, PART.to_owned())].into_iter().chain(set);
            PlannedCase {
                id: CaseId::new(STUDY, format!("{PART}/{name}"), conditions),
                samples: 0,
                may_be_wrong: false,
            }
        });
        Self {
            cases: cases.collect(),
            work,
            opened: Rc::clone(opened),
        }
    }

    /// Triangles of a view in `f64`, relative to the eye.
    fn triangles(
        &self,
        n: u32,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<Vec<[DVec3; 3]>, String> {
        let parameters = Table::from_iter([("n".to_owned(), Value::Integer(n.into()))]);
        let surface = self.opened.get(KIND, &parameters)?;
        let vertices = surface.exact_vertices(camera, size);
        let vertices = vertices.map_err(|error| error.to_string())?;
        let vertices =
            vertices.ok_or_else(|| format!("surface {KIND} does not say its vertices in f64"))?;
        let frame = surface.frame(camera, size);
        let frame = frame.map_err(|error| error.to_string())?;
        let triangles = frame.triangles.iter();
        Ok(triangles
            .map(|triangle| triangle.map(|at| vertices[at as usize]))
            .collect())
    }

    fn nadir(&self, n: u32, eye: &Eye) -> Result<Verdict, String> {
        let triangles = self.triangles(n, &eye.camera, eye.size)?;
        let found = worst_map_m(eye, &triangles);
        let fitted = fitted_m(n, eye);
        let closed = closed_m(n, eye);
        let off = found / closed - 1.0;
        let reason = match off.abs() <= ALLOWED_SHARE {
            true => String::new(),
            false => format!(
                "the map is {} m off, {} m in closed form: a difference of {} %, allowed {} %",
                significant(found),
                significant(closed),
                significant(100.0 * off),
                100.0 * ALLOWED_SHARE
            ),
        };
        let figures = vec![
            ("globe_map_m_max", found),
            ("globe_expected_map_m_max", fitted),
            ("globe_closed_map_m_max", closed),
        ];
        Ok(judged(reason, figures, Vec::new()))
    }

    fn seam(&self, limit: f64) -> Result<Verdict, String> {
        let mut counted = Seam::default();
        for number in 0..VIEWS {
            let (n, camera, size) = view(number);
            for triangle in self.triangles(n, &camera, size)? {
                counted.add(camera.eye_ecef, triangle, limit);
            }
        }
        let reason = match (limit <= 0.5, counted.partly + counted.untouched) {
            (true, missed) if missed > 0 => {
                format!("{missed} triangles are not split, allowed 0")
            }
            _ => String::new(),
        };
        let figures = vec![
            ("globe_tile_crossing", f64::from(counted.crossing)),
            (
                "globe_tile_missed",
                f64::from(counted.partly + counted.untouched),
            ),
            ("globe_tile_untouched", f64::from(counted.untouched)),
            ("globe_tile_with_pole", f64::from(counted.with_pole)),
            ("globe_tile_crossing_met", f64::from(counted.crossing_met)),
            ("globe_tile_untouched_met", f64::from(counted.untouched_met)),
        ];
        Ok(judged(reason, figures, Vec::new()))
    }
}

/// An eye that looks straight down.
fn eye(latitude_deg: f64, height_m: f64) -> Eye {
    let row = ViewRow {
        name: String::new(),
        longitude_deg: 15.0,
        latitude_deg,
        height_m,
        pitch_deg: -90.0,
        quick: false,
        all_cells: false,
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
                let shown = eye.body.geodetic_to_ecef(on_map(eye, facet, point));
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
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small number"
)]
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
    let size = ImageSize {
        width: SIDE_PX,
        height: SIDE_PX,
    };
    let n = 1 + (20.0 * at(5)) as u32;
    (n, Camera::new(&Ellipsoid::WGS84, &pose), size)
}

impl Group for GridFacts {
    fn name(&self) -> String {
        format!("{STUDY}/{PART}")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, _context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(CaseSession(FactPart(self))))
    }
}

struct FactPart<'a>(&'a GridFacts);

impl Measures for FactPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        Ok(match self.0.work[case] {
            What::Nadir(n, latitude_deg, height_m) => {
                self.0.nadir(n, &eye(latitude_deg, height_m))?
            }
            What::Seam(limit) => self.0.seam(limit)?,
        })
    }

    fn time(&mut self, _case: usize) -> Result<Figures, Failure> {
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_screen_grid::ScreenGridKind;
    use terrafill_surface::SurfaceKind;

    const KINDS: &[&dyn SurfaceKind] = &[&ScreenGridKind];

    #[test]
    fn the_closed_form_is_what_facets_do_and_the_fit_is_high_and_low_of_it() {
        let facts = GridFacts::new(&Rc::new(Opened::new(KINDS)));
        for (n, latitude_deg, height_m) in [(5, 0.0, 1e3), (10, 0.0, 1e5), (20, 84.0, 1e4)] {
            let eye = eye(latitude_deg, height_m);
            let triangles = facts.triangles(n, &eye.camera, eye.size).expect("a view");
            let found = worst_map_m(&eye, &triangles);
            let off = |formula: f64| found / formula - 1.0;
            let [closed, fitted] = [closed_m(n, &eye), fitted_m(n, &eye)].map(off);
            eprintln!(
                "N {n}, φ {latitude_deg}, {height_m} m: closed {closed:+.4}, fit {fitted:+.4}"
            );
            assert!(closed.abs() < ALLOWED_SHARE, "{closed}");
            // Twin: the closed form of another grid.
            assert!(off(closed_m(n + 1, &eye)).abs() > ALLOWED_SHARE);
        }
    }

    #[test]
    fn the_published_rule_leaves_some_triangles_untouched_and_half_a_turn_none() {
        let facts = GridFacts::new(&Rc::new(Opened::new(KINDS)));
        let figure = |verdict: &Verdict, name: &str| {
            let mut figures = verdict.figures.iter();
            let found = figures.find(|(known, _)| *known == name);
            found.map_or(f64::NAN, |(_, value)| *value)
        };
        let [published, half] = LIMITS.map(|limit| facts.seam(limit).expect("views"));
        let of = |name| [&published, &half].map(|verdict| figure(verdict, name));
        let [crossing, same] = of("globe_tile_crossing");
        eprintln!("{:?}", published.figures);
        assert!(crossing > 300.0 && crossing == same);
        let [untouched, none] = of("globe_tile_untouched");
        assert!((0.005..0.04).contains(&(untouched / crossing)) && none == 0.0);
        // As many as the facts count among triangles with a corner on the body: 45 of 2,713.
        let [crossing_met, _] = of("globe_tile_crossing_met");
        let [untouched_met, none] = of("globe_tile_untouched_met");
        assert!((0.01..0.026).contains(&(untouched_met / crossing_met)) && none == 0.0);
        // Twin: those at the limb alone are more often left untouched.
        let at_limb = (untouched - untouched_met) / (crossing - crossing_met);
        assert!(at_limb > 0.026, "{at_limb}");
        // Twin: more are split on one of two edges alone.
        let [missed, none] = of("globe_tile_missed");
        assert!(missed > untouched && none == 0.0 && half.reason.is_empty());
    }
}
