// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces through their knobs in one view: each is made, judged against rays at the body, and timed.

use crate::STUDY;
use crate::api::RAYS;
use crate::error::{Errors, Truth, of_depth, of_frame, truths};
use crate::expected::{Expected, expected};
use crate::list::{SurfaceRow, number};
use crate::metrics::{API, KNOB, SIZE_PX, SURFACE, VALUE, VIEW};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Picture, SurfaceInterface, SurfaceTargets, ViewConstants};
use terrafill_globe_views::{
    Eye, FrameWatch, OTHER_TRIANGLES, Opened, ViewRow, around, fingerprint, no_triangles,
};
use terrafill_gpu::RayCast;
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{CaseGroup, Context, Depth, Failure, Figures, JudgedOnce, Shows, verified};
use terrafill_surface::{Surface, SurfaceError, SurfaceFrame};
use toml::Value;

/// The case without triangles.
pub(crate) const RAY_CAST: &str = "ray-cast";

/// Bytes of a vertex, and of a triangle's indices.
const VERTEX_BYTES: u64 = 12;

/// A surface with its knob set, on an interface.
#[derive(Clone)]
pub(crate) struct Work {
    /// `None` for the body itself, a ray for each pixel.
    pub(crate) surface: Option<Chosen>,
    interface: SurfaceInterface,
}

/// A surface with its knob set.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chosen {
    pub(crate) row: SurfaceRow,
    pub(crate) value: Value,
}

impl Chosen {
    /// The first of a quick run's values, or of all where that has none.
    pub(crate) fn first(row: &SurfaceRow) -> Option<Self> {
        let of = |depth| row.values(depth).into_iter().next();
        let value = of(Depth::Quick).or_else(|| of(Depth::Full))?;
        let row = row.clone();
        Some(Self { row, value })
    }

    /// With the value at which its triangles are drawn as pictures.
    pub(crate) fn pictured(row: &SurfaceRow) -> Option<Self> {
        let value = row.pictured.clone();
        let of = |value| Self {
            row: row.clone(),
            value,
        };
        value.map(of).or_else(|| Self::first(row))
    }

    pub(crate) fn parameters(&self) -> toml::Table {
        let mut parameters = self.row.with.clone();
        parameters.insert(self.row.knob.clone(), self.value.clone());
        parameters
    }
}

impl Work {
    /// What tells its targets from others.
    fn targets(&self) -> &'static str {
        match self.surface {
            Some(_) => self.interface.api.name,
            None => RAY_CAST,
        }
    }
}

pub(crate) fn works(rows: &[SurfaceRow], depth: Depth) -> Vec<Work> {
    // Vulkan itself draws the same triangles: as many as all wgpu cases only where all is measured.
    let interfaces: &[SurfaceInterface] = match depth {
        Depth::Full => &[terrafill_gpu::SURFACES, terrafill_vulkan::SURFACES],
        Depth::Quick | Depth::Main => &[terrafill_gpu::SURFACES],
    };
    let mut works = Vec::new();
    for row in rows {
        for value in row.values(depth) {
            works.extend(interfaces.iter().map(|&interface| Work {
                surface: Some(Chosen {
                    row: row.clone(),
                    value: value.clone(),
                }),
                interface,
            }));
        }
    }
    works.push(Work {
        surface: None,
        interface: RAYS,
    });
    works
}

/// All surfaces in one view.
pub(crate) struct SurfacesView {
    eye: Eye,
    works: Vec<Work>,
    opened: Rc<Opened>,
}

impl SurfacesView {
    pub(crate) fn planned(
        view: &ViewRow,
        works: &[Work],
        opened: &Rc<Opened>,
        (side_px, samples): (u32, u32),
    ) -> CaseGroup<Self> {
        let eye = view.eye(side_px);
        let cases = works.iter().map(|work| {
            let [surface, knob, value] = match &work.surface {
                Some(Chosen { row, value }) => {
                    let value = number(value).map(|value| value.to_string());
                    [
                        row.name.clone(),
                        row.knob.clone(),
                        value.unwrap_or_default(),
                    ]
                }
                None => [RAY_CAST, "", ""].map(str::to_owned),
            };
            let set = match knob.as_str() {
                "" => String::new(),
                knob => format!("/{knob}={value}"),
            };
            let api = work.interface.api.name;
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("{}/{surface}{set}/{api}", view.name),
                    [
                        (VIEW, view.name.clone()),
                        (SURFACE, surface),
                        (KNOB, knob),
                        (VALUE, value),
                        (API, api.to_owned()),
                        (SIZE_PX, eye.size.width.to_string()),
                    ],
                ),
                samples,
                may_be_wrong: work.surface.as_ref().is_some_and(|of| of.row.cracks),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{}", view.name),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                eye,
                works: works.to_vec(),
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(SightPart {
                    sight: &group.work,
                    context,
                    targets: BTreeMap::new(),
                    truths: None,
                    judged: BTreeMap::new(),
                    ready: BTreeMap::new(),
                })))
            },
        }
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
    /// Of the triangles that were verified.
    triangles: String,
}

struct SightPart<'a> {
    sight: &'a SurfacesView,
    context: Context<'a>,
    /// By [`Work::targets`].
    targets: BTreeMap<&'static str, Box<dyn SurfaceTargets>>,
    /// Of the view's pixels, where a case is judged.
    truths: Option<Vec<Option<Truth>>>,
    /// By kind and parameters.
    judged: BTreeMap<String, Rc<Judged>>,
    /// By case.
    ready: BTreeMap<usize, Ready>,
}

impl SightPart<'_> {
    fn frame(&self, surface: &Arc<dyn Surface>) -> Result<SurfaceFrame, SurfaceError> {
        surface.frame(&self.sight.eye.camera, self.sight.eye.size)
    }

    /// Opens what a case is drawn by, and makes its triangles.
    fn make_ready(&mut self, case: usize) -> Result<Option<SurfaceFrame>, Failure> {
        let SurfacesView { eye, works, opened } = self.sight;
        let work = &works[case];
        let open = |chosen: &Chosen| opened.get(&chosen.row.kind, chosen.parameters());
        let surface = work.surface.as_ref().map(open).transpose()?;
        if let Entry::Vacant(entry) = self.targets.entry(work.targets()) {
            entry.insert((work.interface.open)(self.context.devices, eye.size)?);
        }
        let frame = surface.as_ref().map(|surface| self.frame(surface));
        let frame = frame.transpose()?;
        let ready = Ready {
            surface,
            triangles: frame.as_ref().map_or_else(String::new, of_triangles),
        };
        self.ready.insert(case, ready);
        Ok(frame)
    }

    /// Draws a frame, or the body itself; gives the GPU's time.
    fn draw(
        &mut self,
        case: usize,
        frame: &SurfaceFrame,
        watch: &mut FrameWatch,
    ) -> Result<Option<f64>, DeviceError> {
        let SurfacesView { eye, works, .. } = self.sight;
        let targets = self.targets.get_mut(works[case].targets());
        let targets = targets.ok_or(DeviceError::Missing("targets of the interface"))?;
        targets.prepare(eye.view(frame))?;
        watch.ends("globe_upload_cpu_ms");
        targets.draw_surface()
    }
}

impl Shows for SightPart<'_> {
    type Shown = (Option<SurfaceFrame>, Picture);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let frame = self.make_ready(case)?;
        let nothing = no_triangles();
        let drawn = frame.as_ref().unwrap_or(&nothing);
        self.draw(case, drawn, &mut FrameWatch::start())?;
        let picture = self.targets[self.sight.works[case].targets()].read()?;
        let depths = fingerprint(&[bytemuck::cast_slice(&picture.depth)]);
        let hash = format!("{}-{depths}", self.ready[&case].triangles);
        Ok((hash, (frame, picture)))
    }

    fn judge(&mut self, case: usize, (frame, picture): Self::Shown) -> Result<Verdict, Failure> {
        let SurfacesView { eye, works, .. } = self.sight;
        let work = &works[case];
        let truths = self.truths.get_or_insert_with(|| truths(eye));
        let (judged, otherwise) = if let (Some(chosen), Some(frame)) = (&work.surface, &frame) {
            let key = format!("{} {}", chosen.row.kind, chosen.parameters());
            let judged = self.judged.entry(key).or_insert_with(|| {
                let knob = number(&chosen.value).unwrap_or(f64::NAN);
                Rc::new(Judged {
                    errors: of_frame(eye, truths, frame),
                    expected: expected(chosen.row.expected, knob, eye, truths),
                })
            });
            let width = eye.size.width as usize;
            let shown: Vec<bool> = picture.depth.iter().map(|depth| *depth != 0.0).collect();
            let otherwise = drawn_otherwise(width, &judged.errors.shown, &shown);
            (Rc::clone(judged), Some(otherwise))
        } else {
            let by_construction = Expected {
                px_max: Some(0.0),
                map_max_m: None,
                lowest_m: Some(0.0),
                by: "0 by construction",
            };
            let judged = Judged {
                errors: of_depth(eye, truths, &picture),
                expected: by_construction,
            };
            (Rc::new(judged), None)
        };
        let mut figures = figures(&judged);
        figures.push(("globe_upload_bytes", upload_bytes(frame.as_ref()) as f64));
        if let Some(frame) = &frame {
            figures.push(("globe_triangles", frame.triangles.len() as f64));
            figures.push(("globe_vertices", frame.vertices_rte.len() as f64));
            figures.push(("globe_stated_lowest_m", frame.heights.lowest_m));
        }
        figures.extend(otherwise.map(|px| ("globe_drawn_otherwise_px", px as f64)));
        let notes = vec![("expected-by", judged.expected.by.to_owned())];
        let reason = standing(&judged.errors, otherwise);
        Ok(terrafill_study::judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let ready = verified(&mut self.ready, case)?;
        let (surface, triangles) = (ready.surface.clone(), ready.triangles.clone());
        let mut watch = FrameWatch::start();
        let frame = match &surface {
            Some(surface) => self.frame(surface)?,
            None => no_triangles(),
        };
        watch.ends("globe_make_cpu_ms");
        let gpu_ms = self.draw(case, &frame, &mut watch)?;
        let values = watch.drawn(gpu_ms);
        if surface.is_some() && of_triangles(&frame) != triangles {
            return Err(Failure::broken(OTHER_TRIANGLES));
        }
        Ok(values)
    }
}

fn of_triangles(frame: &SurfaceFrame) -> String {
    let vertices = bytemuck::cast_slice(&frame.vertices_rte);
    fingerprint(&[vertices, bytemuck::cast_slice(&frame.triangles)])
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
pub(crate) fn drawn_otherwise(width: usize, rays: &[bool], device: &[bool]) -> usize {
    let is_plain =
        |pixel: usize| around(pixel, width, rays.len()).all(|beside| rays[beside] == rays[pixel]);
    (0..rays.len())
        .filter(|&pixel| rays[pixel] != device[pixel] && is_plain(pixel))
        .count()
}

/// Why a surface is wrong; empty where it is not.
pub(crate) fn standing(errors: &Errors, otherwise: Option<usize>) -> String {
    let mut reasons = Vec::new();
    if errors.non_finite > 0 {
        reasons.push(format!("{} figures that are not finite", errors.non_finite));
    }
    if let Some(px) = otherwise.filter(|&px| px > 0) {
        reasons.push(format!(
            "{px} pixels that the device draws otherwise than rays meet the triangles"
        ));
    }
    reasons.join(", ")
}

fn figures(judged: &Judged) -> Figures {
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
