// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral's vertices by their forms: how far single precision and short series move them, and how many rings
//! each law of radii needs. Computed, not drawn; the surface's own frames are compared vertex by vertex.

mod section;

pub(crate) use section::blocks;

use crate::STUDY;
use crate::keys;
use crate::keys::{FORM, HEIGHT_M, WHAT};
use crate::list::{Eye, ViewRow};
use crate::opened::Opened;
use glam::DVec3;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_core::Geodetic;
use terrafill_results::{CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{
    CaseSession, Context, Failure, Figures, Group, Measures, Session, StudyError, judged,
};
use terrafill_surface::{Surface, SurfaceFrame};
use toml::{Table as Parameters, Value};

/// Name of this part in cases.
pub(crate) const PART: &str = "forms";
pub(crate) const KIND: &str = "spiral";

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

#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    /// A form of position in single precision against itself in double precision.
    Form(&'static str),
    /// A series against the functions, in double precision.
    Series(&'static str),
    /// A law's rings.
    Rings(&'static str),
}

impl What {
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Form(name) => ["f32", name],
            Self::Series(name) => ["series", name],
            Self::Rings(name) => ["rings", name],
        }
    }
}

/// All of it.
pub(crate) struct Forms {
    work: Vec<(What, f64)>,
    cases: Vec<PlannedCase>,
    opened: Rc<Opened>,
}

impl Forms {
    pub(crate) fn new(opened: &Rc<Opened>) -> Self {
        let mut work = Vec::new();
        for height_m in HEIGHTS_M {
            work.extend(FORMS.map(|form| (What::Form(form), height_m)));
            work.extend(SERIES.map(|series| (What::Series(series), height_m)));
        }
        for height_m in RING_HEIGHTS_M {
            work.extend(LAWS.map(|law| (What::Rings(law), height_m)));
        }
        let cases = work.iter().map(|(what, height_m)| {
            let [group, name] = what.names();
            let conditions = [
                (keys::PART, PART.to_owned()),
                (WHAT, group.to_owned()),
                (FORM, name.to_owned()),
                (HEIGHT_M, height_m.to_string()),
            ];
            // A slash parts what a case's name is made of.
            let name = name.replace('/', "-");
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{PART}/{group}/{name}/{height_m}"),
                    conditions,
                ),
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

    fn surface(&self, set: &[(&str, Value)]) -> Result<Arc<dyn Surface>, String> {
        let set = set.iter();
        let set = set.map(|(key, value)| ((*key).to_owned(), value.clone()));
        self.opened.get(KIND, &Parameters::from_iter(set))
    }

    fn frame(&self, eye: &Eye, set: &[(&str, Value)]) -> Result<SurfaceFrame, String> {
        let frame = self.surface(set)?.frame(&eye.camera, eye.size);
        frame.map_err(|error| error.to_string())
    }

    /// Before a frame rounds them, which would be an error of both sides.
    fn vertices(&self, eye: &Eye, set: &[(&str, Value)]) -> Result<Vec<DVec3>, String> {
        let vertices = self.surface(set)?.exact_vertices(&eye.camera, eye.size);
        let vertices = vertices.map_err(|error| error.to_string())?;
        vertices.ok_or_else(|| format!("surface {KIND} does not say its vertices in f64"))
    }

    fn figures(&self, case: usize) -> Result<Figures, String> {
        let (what, height_m) = self.work[case];
        let eye = eye(height_m);
        let word = |text: &str| Value::String(text.to_owned());
        match what {
            What::Form(form) => {
                let form = ("frame", word(form));
                let [exact, single] = ["buffer", "f32"].map(|precision| {
                    self.vertices(&eye, &[form.clone(), ("precision", word(precision))])
                });
                moved(&exact?, &single?, &eye)
            }
            What::Series(series) => {
                // On the horizon, so that both meshes end where the series is asked for.
                let rim = ("rim", word("horizon"));
                let [exact, short] = ["native", series]
                    .map(|trig| self.vertices(&eye, &[rim.clone(), ("trig", word(trig))]));
                moved(&exact?, &short?, &eye)
            }
            What::Rings(law) => {
                let found = self.rings(&eye, law)?;
                let expected = rings_by_formula(law, height_m);
                Ok(vec![
                    ("globe_form_rings", f64::from(found)),
                    ("globe_form_expected_rings", f64::from(expected)),
                ])
            }
        }
    }

    /// The fewest rings with which no edge sags by more than a quarter of a pixel.
    fn rings(&self, eye: &Eye, law: &str) -> Result<u32, String> {
        let frame = |doubling: f64| {
            self.frame(
                eye,
                &[
                    ("law", Value::String(law.to_owned())),
                    ("n", Value::Integer(RING_VERTICES)),
                    ("std", Value::Float(doubling)),
                    ("rim", Value::String("horizon".to_owned())),
                ],
            )
        };
        // Rings of a mesh: two triangles a vertex and ring, and the fan.
        let rings = |frame: &SurfaceFrame| {
            (frame.triangles.len() as f64 / RING_VERTICES as f64 - 1.0) / 2.0
        };
        let doublings = rings(&frame(10.0)?) / 10.0;
        let is_fine = |count: u32| -> Result<bool, String> {
            let doubling = f64::from(count) / doublings;
            Ok(worst_sag_px(&frame(doubling)?, eye) <= FINE_PX)
        };
        // The surface allows no fewer turns.
        let mut low = whole((MIN_DOUBLING * doublings).ceil());
        let mut high = low + 1;
        let most = whole(MAX_DOUBLING * doublings).min(MAX_RINGS);
        while !is_fine(high)? {
            if high >= most {
                return Err(format!("{law}: more than {high} rings, allowed: {most}"));
            }
            (low, high) = (high, (2 * high).min(most));
        }
        while high - low > 1 {
            let middle = (low + high) / 2;
            match is_fine(middle)? {
                true => high = middle,
                false => low = middle,
            }
        }
        Ok(high)
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small number of turns"
)]
fn whole(turns: f64) -> u32 {
    turns as u32
}

/// Over one place, level, so that the horizon is seen.
fn eye(height_m: f64) -> Eye {
    let view = ViewRow {
        name: String::new(),
        longitude_deg: -122.4194,
        latitude_deg: 37.7749,
        height_m,
        pitch_deg: 0.0,
        quick: false,
        all_cells: false,
    };
    view.eye(ROWS_PX)
}

fn focal_px(eye: &Eye) -> f64 {
    0.5 * f64::from(eye.size.height) / eye.camera.tan_half_fov()
}

fn places(frame: &SurfaceFrame) -> Vec<DVec3> {
    let vertices = frame.vertices_rte.iter();
    vertices
        .map(|vertex| DVec3::from(vertex.map(f64::from)))
        .collect()
}

/// Angle between two directions; exact for small ones.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// How far a view's vertices are from others.
fn moved(exact: &[DVec3], other: &[DVec3], eye: &Eye) -> Result<Figures, String> {
    if exact.len() != other.len() {
        return Err(format!(
            "{} and {} vertices, allowed: as many",
            exact.len(),
            other.len()
        ));
    }
    let pairs = || exact.iter().zip(other);
    let metres: Vec<f64> = pairs().map(|(a, b)| a.distance(*b)).collect();
    let pixels: Vec<f64> = pairs()
        .map(|(a, b)| angle(*a, *b) * focal_px(eye))
        .collect();
    let lost = pixels.iter().filter(|px| !px.is_finite()).count();
    let mut figures = vec![("globe_non_finite", lost as f64)];
    let mut add = |name, of: &[f64], share| {
        figures.extend(quantile(of, share).map(|value| (name, value)));
    };
    add("globe_form_px_max", &pixels, 1.0);
    add("globe_form_m_max", &metres, 1.0);
    add("globe_form_m_median", &metres, 0.5);
    Ok(figures)
}

/// Largest distance on the screen between the middle of an edge and the place of the body over it, pixels. The
/// fan's spokes are left out: they are no rings.
fn worst_sag_px(frame: &SurfaceFrame, eye: &Eye) -> f64 {
    let places = places(frame);
    let mut worst = 0.0_f64;
    for triangle in frame
        .triangles
        .iter()
        .filter(|triangle| !triangle.contains(&0))
    {
        for i in 0..3 {
            let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|at| places[at as usize]);
            let middle = 0.5 * (a + b);
            let place = eye.body.ecef_to_geodetic(eye.camera.eye_ecef + middle);
            let foot = eye.body.geodetic_to_ecef(Geodetic {
                height_m: 0.0,
                ..place
            });
            let off = angle(middle, foot - eye.camera.eye_ecef);
            worst = worst.max(off * focal_px(eye));
        }
    }
    worst
}

/// The same from the law's own formula, on a sphere. A ring from `r` to `r + Δ` sags by `s = R Δ² / 8`. From `h` it is
/// seen as `f s g / (h² + g²)`, `g = R r`.
fn rings_by_formula(law: &str, height_m: f64) -> u32 {
    let eye = eye(height_m);
    let focal_px = focal_px(&eye);
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

impl Group for Forms {
    fn name(&self) -> String {
        format!("{STUDY}/{PART}")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, _context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(CaseSession(FormPart(self))))
    }
}

struct FormPart<'a>(&'a Forms);

impl Measures for FormPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        Ok(judged(String::new(), self.0.figures(case)?, Vec::new()))
    }

    fn time(&mut self, _case: usize) -> Result<Figures, Failure> {
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests;
