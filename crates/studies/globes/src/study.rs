// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: surfaces through their knobs, in each view a group.

use crate::api::{Drawing, Interface, RAYS, VULKAN, WGPU};
use crate::canvas::no_triangles;
use crate::counts::Counts;
use crate::error::{Errors, of_depth, of_frame};
use crate::expected::{Expected, expected};
use crate::forms::{self, Forms};
use crate::list::{Eye, Formula, List, SurfaceRow, ViewRow, number};
use crate::made::Made;
use crate::metrics::METRICS;
use crate::opened::Opened;
use crate::shading::{self, Shadings};
use crate::tiled::stage::Stages;
use crate::tiled::{self, Tiled};
use crate::{STUDY, chapter::GlobesChapter};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::hash::{DefaultHasher, Hasher as _};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_fill::{CpuStopwatch, DeviceError, SurfaceView, ViewConstants, ViewId};
use terrafill_gpu::RayCast;
use terrafill_results::{CaseId, Chapter, Metric, PlannedCase, Skipped, Status, Verdict};
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};
use terrafill_surface::{Surface, SurfaceError, SurfaceFrame, SurfaceKind};
use toml::Value;

/// Timed frames of each case in a process, unless the request says otherwise. Odd, so that the median
/// is one of them.
const SAMPLES: u32 = 11;
const QUICK_SAMPLES: u32 = 5;

/// Pixels a side. The facts that figures are held against are for the larger one.
const SIDE_PX: u32 = 800;
const QUICK_SIDE_PX: u32 = 400;

/// The case without triangles.
const RAY_CAST: &str = "ray-cast";

/// Bytes of a vertex, and of a triangle's indices.
const VERTEX_BYTES: u64 = 12;

/// Which surface draws the body with which error in which time.
#[derive(Debug, Clone, Copy)]
pub struct GlobesStudy {
    /// Surfaces that it may compare.
    pub surfaces: &'static [&'static dyn SurfaceKind],
}

impl Study for GlobesStudy {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "Which surface draws the body with which error in which time?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let list = List::shipped().map_err(StudyError::BadInput)?;
        let is_quick = request.depth == Depth::Quick;
        let (mut rows, mut skipped) = (Vec::new(), Vec::new());
        for row in list.surface.clone() {
            if self.surfaces.iter().any(|kind| kind.name() == row.kind) {
                rows.push(row);
                continue;
            }
            skipped.push(Skipped {
                what: format!("{STUDY}/{}", row.name),
                reason: format!("there is no surface of the kind {:?}", row.kind),
            });
        }
        let works = works(&rows, request.depth);
        let opened = Rc::new(Opened::new(self.surfaces));
        let views = list
            .view
            .iter()
            .filter(|view| view.quick || !is_quick)
            .cloned();
        let mut groups: Vec<Box<dyn Group>> = views
            .map(|view| -> Box<dyn Group> { Box::new(Sight::new(view, &works, &opened, request)) })
            .collect();
        if opened.has(tiled::KIND) {
            let sizes = sizes(request);
            let views = list
                .tiled_view
                .iter()
                .filter(|view| view.quick || !is_quick);
            for view in views {
                groups.push(Box::new(Tiled::planned(view, sizes, is_quick, &opened)));
                groups.push(Box::new(Stages::new(view, sizes, &opened)));
            }
        } else {
            skipped.push(Skipped {
                what: format!("{STUDY}/{}", tiled::PART),
                reason: format!("there is no surface of the kind {:?}", tiled::KIND),
            });
        }
        if opened.has(forms::KIND) {
            groups.push(Box::new(Forms::new(&opened)));
            let sizes = sizes(request);
            groups.push(Box::new(Shadings::new(&list, sizes, is_quick, &opened)));
        } else {
            skipped.push(Skipped {
                what: format!("{STUDY}/{}, {STUDY}/{}", forms::PART, shading::PART),
                reason: format!("there is no surface of the kind {:?}", forms::KIND),
            });
        }
        groups.push(Box::new(Made::new(&list, sizes(request))));
        groups.push(Box::new(Counts::new(&list, is_quick, sizes(request).1)));
        Ok(Planned { groups, skipped })
    }

    fn chapter(&self) -> &dyn Chapter {
        &GlobesChapter
    }
}

/// Pixels a side, and timed frames of a case.
fn sizes(request: &Request) -> (u32, u32) {
    let (side_px, samples) = match request.depth {
        Depth::Quick => (QUICK_SIDE_PX, QUICK_SAMPLES),
        Depth::Main | Depth::Full => (SIDE_PX, SAMPLES),
    };
    (side_px, request.samples.unwrap_or(samples))
}

/// A surface with its knob set, on an interface.
#[derive(Clone)]
struct Work {
    /// As in reports.
    name: String,
    /// `None` for the body itself, a ray for each pixel.
    surface: Option<Chosen>,
    interface: Interface,
    has_cracks: bool,
}

/// What a surface is opened by.
#[derive(Debug, Clone, PartialEq)]
struct Chosen {
    kind: String,
    knob: String,
    value: Value,
    formula: Formula,
    with: toml::Table,
}

impl Chosen {
    /// What tells it from others.
    fn key(&self) -> String {
        format!("{} {}={} {}", self.kind, self.knob, self.value, self.with)
    }

    fn parameters(&self) -> toml::Table {
        let mut parameters = self.with.clone();
        parameters.insert(self.knob.clone(), self.value.clone());
        parameters
    }
}

fn works(rows: &[SurfaceRow], depth: Depth) -> Vec<Work> {
    let mut works = Vec::new();
    for row in rows {
        let values = match depth {
            Depth::Quick => &row.quick,
            Depth::Main | Depth::Full => &row.values,
        };
        // Vulkan itself draws the same triangles: as many as all wgpu cases only where all is measured.
        let interfaces: &[Interface] = match depth {
            Depth::Full => &[WGPU, VULKAN],
            Depth::Quick | Depth::Main => &[WGPU],
        };
        for value in values {
            works.extend(interfaces.iter().map(|&interface| Work {
                name: row.name.clone(),
                surface: Some(Chosen {
                    kind: row.kind.clone(),
                    knob: row.knob.clone(),
                    value: value.clone(),
                    formula: row.expected,
                    with: row.with.clone(),
                }),
                interface,
                has_cracks: row.cracks,
            }));
        }
    }
    works.push(Work {
        name: RAY_CAST.to_owned(),
        surface: None,
        interface: RAYS,
        has_cracks: false,
    });
    works
}

/// All surfaces in one view.
struct Sight {
    view: ViewRow,
    eye: Eye,
    works: Vec<Work>,
    cases: Vec<PlannedCase>,
    opened: Rc<Opened>,
}

impl Sight {
    fn new(view: ViewRow, works: &[Work], opened: &Rc<Opened>, request: &Request) -> Self {
        let (side_px, samples) = sizes(request);
        let eye = view.eye(side_px);
        let cases = works.iter().map(|work| {
            let (knob, value) = work
                .surface
                .as_ref()
                .map_or_else(Default::default, |chosen| {
                    let number = number(&chosen.value).map(|value| value.to_string());
                    (chosen.knob.clone(), number.unwrap_or_default())
                });
            let set = match knob.as_str() {
                "" => String::new(),
                knob => format!("/{knob}={value}"),
            };
            let api = work.interface.api.name;
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{}/{}{set}/{api}", view.name, work.name),
                    [
                        ("view", view.name.clone()),
                        ("surface", work.name.clone()),
                        ("knob", knob),
                        ("value", value),
                        ("api", api.to_owned()),
                        ("size_px", eye.size.width.to_string()),
                    ],
                ),
                samples,
                may_be_wrong: work.has_cracks,
            }
        });
        Self {
            cases: cases.collect(),
            view,
            eye,
            works: works.to_vec(),
            opened: Rc::clone(opened),
        }
    }
}

impl Group for Sight {
    fn name(&self) -> String {
        format!("{STUDY}/{}", self.view.name)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(SightSession {
            sight: self,
            context,
            targets: BTreeMap::new(),
            judged: BTreeMap::new(),
            ready: BTreeMap::new(),
        }))
    }
}

/// A surface's triangles in the view, judged.
struct Judged {
    errors: Errors,
    expected: Expected,
}

/// What draws a case.
struct Ready {
    surface: Option<Arc<dyn Surface>>,
    targets: &'static str,
    /// Of the triangles that were verified.
    fingerprint: u64,
}

struct SightSession<'a> {
    sight: &'a Sight,
    context: Context<'a>,
    /// By interface, [`RAY_CAST`] one of them.
    targets: BTreeMap<&'static str, Box<dyn Drawing>>,
    /// By [`Chosen::key`].
    judged: BTreeMap<String, Rc<Judged>>,
    /// By case.
    ready: BTreeMap<usize, Ready>,
}

/// Why a case has no figures.
enum Failure {
    /// A surface or a device that cannot do it.
    Unable(String),
    /// A defect.
    Broken(String),
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        match error {
            DeviceError::Unsupported { .. } => Self::Unable(error.to_string()),
            _ => Self::Broken(error.to_string()),
        }
    }
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        match error {
            SurfaceError::EyeBelow { .. } => Self::Unable(error.to_string()),
            _ => Self::Broken(error.to_string()),
        }
    }
}

impl From<Failure> for Verdict {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Unable(reason) => Self::skipped(reason),
            Failure::Broken(reason) => Self::failed(reason),
        }
    }
}

impl SightSession<'_> {
    fn frame(&self, surface: &Arc<dyn Surface>) -> Result<SurfaceFrame, SurfaceError> {
        surface.frame(&self.sight.eye.camera, self.sight.eye.size)
    }

    /// Opens what a case is drawn by, and makes its triangles.
    fn make_ready(&mut self, case: usize) -> Result<Option<SurfaceFrame>, Failure> {
        let work = &self.sight.works[case];
        let surface = match &work.surface {
            Some(chosen) => {
                let opened = self.sight.opened.get(&chosen.kind, &chosen.parameters());
                Some(opened.map_err(Failure::Broken)?)
            }
            None => None,
        };
        let name = match &work.surface {
            Some(_) => work.interface.api.name,
            None => RAY_CAST,
        };
        if let Entry::Vacant(entry) = self.targets.entry(name) {
            entry.insert((work.interface.open)(
                self.context.devices,
                self.sight.eye.size,
            )?);
        }
        let frame = match &surface {
            Some(surface) => Some(self.frame(surface)?),
            None => None,
        };
        let ready = Ready {
            surface,
            targets: name,
            fingerprint: frame.as_ref().map_or(0, fingerprint),
        };
        self.ready.insert(case, ready);
        Ok(frame)
    }

    /// Draws a frame, or the body itself.
    fn draw(&mut self, targets: &'static str, frame: &SurfaceFrame) -> Result<Drawn, DeviceError> {
        let eye = &self.sight.eye;
        let view = SurfaceView {
            id: ViewId::unique(),
            body: &eye.body,
            camera: &eye.camera,
            size: eye.size,
            surface: frame,
            picture: None,
            draws_back_faces: false,
        };
        let targets = self.targets.get_mut(targets);
        let targets = targets.ok_or(DeviceError::Missing("targets of the interface"))?;
        let watch = CpuStopwatch::start();
        targets.upload(view)?;
        let upload_ms = watch.cpu_ms();
        let gpu_ms = targets.draw()?;
        Ok(Drawn {
            upload_ms,
            draw_ms: watch.cpu_ms() - upload_ms,
            gpu_ms,
        })
    }

    fn judge(&mut self, case: usize) -> Result<Verdict, Failure> {
        let frame = self.make_ready(case)?;
        let ready = &self.ready[&case];
        let (targets, hash) = (ready.targets, ready.fingerprint);
        self.draw(targets, frame.as_ref().unwrap_or(&no_triangles()))?;
        let picture = self.targets[targets].read()?;
        let eye = self.sight.eye;
        let work = &self.sight.works[case];
        let of_device = of_depth(&eye, &picture);
        let (judged, otherwise) = match (&work.surface, &frame) {
            (Some(chosen), Some(frame)) => {
                let judged = self.judged.entry(chosen.key()).or_insert_with(|| {
                    let knob = number(&chosen.value).unwrap_or(f64::NAN);
                    Rc::new(Judged {
                        errors: of_frame(&eye, frame),
                        expected: expected(chosen.formula, knob, &eye),
                    })
                });
                let width = eye.size.width as usize;
                let otherwise = drawn_otherwise(width, &judged.errors.shown, &of_device.shown);
                (Rc::clone(judged), Some(otherwise))
            }
            _ => {
                let by_construction = Expected {
                    px_max: Some(0.0),
                    map_max_m: None,
                    lowest_m: Some(0.0),
                    by: "0 by construction",
                };
                let judged = Judged {
                    errors: of_device,
                    expected: by_construction,
                };
                (Rc::new(judged), None)
            }
        };
        let mut figures = figures(&judged);
        figures.push(("globe_upload_bytes", upload_bytes(frame.as_ref()) as f64));
        if let Some(frame) = &frame {
            figures.push(("globe_triangles", frame.triangles.len() as f64));
            figures.push(("globe_vertices", frame.vertices_rte.len() as f64));
            figures.push(("globe_stated_lowest_m", frame.heights.lowest_m));
        }
        figures.extend(otherwise.map(|px| ("globe_drawn_otherwise_px", px as f64)));
        let (status, reason) = standing(&judged.errors, otherwise);
        Ok(Verdict {
            status,
            reason,
            figures,
            notes: vec![
                ("triangles", format!("{hash:016x}")),
                ("expected-by", judged.expected.by.to_owned()),
            ],
        })
    }

    fn time(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let ready = self.ready.get(&case).ok_or("it was not verified")?;
        let (surface, targets) = (ready.surface.clone(), ready.targets);
        let hash = ready.fingerprint;
        let watch = CpuStopwatch::start();
        let frame = match &surface {
            Some(surface) => self.frame(surface).map_err(|error| error.to_string())?,
            None => no_triangles(),
        };
        let make_ms = watch.cpu_ms();
        let drawn = self
            .draw(targets, &frame)
            .map_err(|error| error.to_string())?;
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        if surface.is_some() && fingerprint(&frame) != hash {
            return Err("it made other triangles than when it was verified".to_owned());
        }
        let mut values = vec![
            ("globe_whole_cpu_ms", cpu_ms),
            ("globe_whole_wall_ms", wall_ms),
            ("globe_make_cpu_ms", make_ms),
            ("globe_upload_cpu_ms", drawn.upload_ms),
            ("globe_draw_cpu_ms", drawn.draw_ms),
        ];
        if let Some(gpu_ms) = drawn.gpu_ms {
            let whole_ms = make_ms + drawn.upload_ms + gpu_ms;
            values.push(("globe_draw_gpu_ms", gpu_ms));
            values.push(("globe_whole_gpu_ms", whole_ms));
        }
        Ok(values)
    }
}

/// What drawing took.
struct Drawn {
    upload_ms: f64,
    draw_ms: f64,
    gpu_ms: Option<f64>,
}

impl Session for SightSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        Ok(self.judge(case).unwrap_or_else(Verdict::from))
    }

    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        if let Err(failure) = self.make_ready(case) {
            return Ok(failure.into());
        }
        let hash = format!("{:016x}", self.ready[&case].fingerprint);
        if notes.get("triangles") != Some(&hash) {
            return Ok(Verdict::failed(
                "it makes other triangles than in the process that verified it",
            ));
        }
        Ok(Verdict {
            status,
            reason: String::new(),
            figures: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        self.time(case)
    }
}

/// Of vertices and triangles.
fn fingerprint(frame: &SurfaceFrame) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytemuck::cast_slice(&frame.vertices_rte));
    hasher.write(bytemuck::cast_slice(&frame.triangles));
    hasher.finish()
}

fn upload_bytes(frame: Option<&SurfaceFrame>) -> u64 {
    let Some(frame) = frame else {
        return RayCast::CONSTANT_BYTES;
    };
    let counts = frame.vertices_rte.len() + frame.triangles.len();
    VERTEX_BYTES * counts as u64 + size_of::<ViewConstants>() as u64
}

/// Pixels that one of two pictures shows and the other does not, but for those beside the outline of the
/// first.
fn drawn_otherwise(width: usize, rays: &[bool], device: &[bool]) -> usize {
    let height = rays.len() / width.max(1);
    let is_plain = |pixel: usize| {
        let (row, column) = (pixel / width, pixel % width);
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        rows.flat_map(|row| {
            let columns = column.saturating_sub(1)..(column + 2).min(width);
            columns.map(move |column| row * width + column)
        })
        .all(|beside| rays[beside] == rays[pixel])
    };
    (0..rays.len())
        .filter(|&pixel| rays[pixel] != device[pixel] && is_plain(pixel))
        .count()
}

fn standing(errors: &Errors, otherwise: Option<usize>) -> (Status, String) {
    let mut reasons = Vec::new();
    if errors.non_finite > 0 {
        reasons.push(format!("{} figures that are not finite", errors.non_finite));
    }
    if let Some(px) = otherwise.filter(|&px| px > 0) {
        reasons.push(format!(
            "{px} pixels that the device draws otherwise than rays meet the triangles"
        ));
    }
    match reasons.is_empty() {
        true => (Status::Ok, String::new()),
        false => (Status::Wrong, reasons.join(", ")),
    }
}

fn figures(judged: &Judged) -> Vec<(&'static str, f64)> {
    let (errors, expected) = (&judged.errors, &judged.expected);
    let mut figures = vec![
        ("globe_compared_px", errors.compared_px as f64),
        ("globe_uncovered_px", errors.uncovered_px as f64),
        ("globe_extra_px", errors.extra_px as f64),
        ("globe_non_finite", errors.non_finite as f64),
    ];
    let mut add = |name, value: Option<f64>| figures.extend(value.map(|value| (name, value)));
    add("globe_px_max", errors.px.map(|px| px.max));
    add("globe_px_p99", errors.px.map(|px| px.p99));
    add("globe_px_median", errors.px.map(|px| px.median));
    add("globe_m_max", errors.max_m);
    add("globe_map_px_max", errors.map_px.map(|px| px.max));
    add("globe_map_px_p99", errors.map_px.map(|px| px.p99));
    add("globe_map_px_median", errors.map_px.map(|px| px.median));
    add("globe_map_m_max", errors.map_max_m);
    add("globe_depth_m_max", errors.depth_m);
    add("globe_lowest_m", errors.lowest_m);
    add("globe_expected_px_max", expected.px_max);
    add("globe_expected_map_m_max", expected.map_max_m);
    add("globe_expected_lowest_m", expected.lowest_m);
    figures
}

#[cfg(test)]
mod tests;
