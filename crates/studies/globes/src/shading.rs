// SPDX-License-Identifier: MIT OR Apache-2.0
//! Five layers over the spiral (Gebbie and Bailey, Tables 1 and 3): features taken away one after the other, the faults
//! of the printed shader, every projection. Cube maps stand against pictures by angles, triangles against pixels.

mod device;
mod judge;
mod layers;
mod section;
mod tessellation;

pub(crate) use section::SECTIONS;
#[cfg(test)]
pub(crate) use section::TABLE_3;

use crate::STUDY;
use crate::clock::FrameWatch;
use crate::image::write_png;
use crate::list::{Eye, List};
use crate::metrics::{self, CELLS, FAULT, PICTURES, PROJECTION, SIZE_PX, VIEW, WHAT};
use crate::opened::Opened;
use crate::projection::Projection;
use device::{LayerScene, LayerTargets, LayerVertex, Pictures, Shading};
use glam::DVec3;
use judge::{bytes, is_lost, judge, normal};
use layers::lights;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::rc::Rc;
use terrafill_results::{Case, CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, Context, Failure, Figures, Session, judged, verified};
use terrafill_surface::SurfaceFrame;

/// Name of this part in cases.
pub(crate) const PART: &str = "shading";
pub(crate) const KIND: &str = "spiral";

/// Texels along a side of a cube's face.
const FACE: u32 = 256;
const QUICK_FACE: u32 = 128;
/// Vertices of a turn of the ablation, and of the published numbers of triangles: 2,146, 4,294 and 17,058 in view
/// `globe`, within what whole turns allow.
const ABLATION_N: u32 = 72;
const TABLE_1_N: [u32; 3] = [47, 66, 132];
const WINDOWS_PX: [u32; 3] = [600, 800, 1000];
const REMOVED: u32 = 7;
/// Colour by which 99 % of a right picture's pixels may be off the functions: half a step of 8 bits in each of four
/// layers, and what lies between texels; 0.004 was measured with faces of 128 texels, with a margin of five.
const ALLOWED: f64 = 0.02;

/// The shader's faults as printed.
const FAULTS: [(u32, &str); 3] = [
    (1, "unclamped-power"),
    (2, "polar-tangent"),
    (3, "negated-night"),
];

#[derive(Debug, Clone, Copy, PartialEq)]
struct Work {
    view: &'static str,
    size_px: u32,
    n: u32,
    shading: Shading,
    projection: Projection,
    /// What it is for.
    what: &'static str,
}

/// All work on shading, as one group of cases.
pub(crate) struct Shadings {
    work: Vec<Work>,
    list: List,
    opened: Rc<Opened>,
    face: u32,
}

fn work(side_px: u32, is_quick: bool) -> Vec<Work> {
    let base = Work {
        view: "globe",
        size_px: side_px,
        n: ABLATION_N,
        shading: Shading::default(),
        projection: Projection::Globe,
        what: "ladder",
    };
    let without = |removed| Shading {
        removed,
        ..base.shading
    };
    let ladder = (0..=REMOVED).map(|removed| Work {
        shading: without(removed),
        ..base
    });
    let mut all: Vec<Work> = ladder.collect();
    for view in ["globe", "globe-pole"] {
        let shaded = |what, shading| Work {
            view,
            shading,
            what,
            ..base
        };
        all.extend([false, true].map(|by_angles| {
            let shading = Shading {
                by_angles,
                ..base.shading
            };
            shaded("pictures", shading)
        }));
        all.extend(FAULTS.map(|(fault, _)| {
            let shading = Shading {
                fault,
                ..base.shading
            };
            shaded("faults", shading)
        }));
    }
    all.extend(Projection::ALL.iter().skip(1).map(|&projection| Work {
        projection,
        what: "projections",
        ..base
    }));
    let windows = if is_quick { 1 } else { WINDOWS_PX.len() };
    for &size_px in &WINDOWS_PX[..windows] {
        for n in TABLE_1_N {
            all.extend([0, REMOVED].map(|removed| Work {
                size_px,
                n,
                shading: without(removed),
                what: "tessellation",
                ..base
            }));
        }
    }
    all
}

/// - `what`: its condition of that name
fn is_of(case: &Case, what: &str) -> bool {
    case.condition(metrics::PART) == PART && case.condition(WHAT) == what
}

fn fault_name(fault: u32) -> &'static str {
    let mut faults = FAULTS.iter();
    faults
        .find(|(number, _)| *number == fault)
        .map_or("none", |(_, name)| name)
}

impl Shadings {
    pub(crate) fn planned(
        list: &List,
        (side_px, samples): (u32, u32),
        is_quick: bool,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let work = work(side_px, is_quick);
        let cases = work.iter().map(|work| {
            let pictures = if work.shading.by_angles {
                "angles"
            } else {
                "cube"
            };
            let fault = fault_name(work.shading.fault);
            let conditions = [
                (metrics::PART, PART.to_owned()),
                (WHAT, work.what.to_owned()),
                (VIEW, work.view.to_owned()),
                (CELLS, work.n.to_string()),
                (metrics::REMOVED, work.shading.removed.to_string()),
                (PICTURES, pictures.to_owned()),
                (FAULT, fault.to_owned()),
                (PROJECTION, work.projection.name().to_owned()),
                (SIZE_PX, work.size_px.to_string()),
            ];
            let name = format!(
                "{PART}/{}/{}/n={}/removed={}/{pictures}/{fault}/{}/{}",
                work.what,
                work.view,
                work.n,
                work.shading.removed,
                work.projection.name(),
                work.size_px
            );
            PlannedCase {
                id: CaseId::new(STUDY, name, conditions),
                samples,
                may_be_wrong: work.shading.fault > 0,
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                work,
                list: list.clone(),
                opened: Rc::clone(opened),
                face: if is_quick { QUICK_FACE } else { FACE },
            },
            open: |group, context| {
                Ok(Box::new(ShadingPart {
                    group: &group.work,
                    cases: &group.cases,
                    context,
                    pictures: None,
                    targets: BTreeMap::new(),
                    ready: BTreeMap::new(),
                }))
            },
        }
    }

    fn eye(&self, work: &Work) -> Result<Eye, String> {
        Ok(self.list.view(work.view)?.eye(work.size_px))
    }
}

struct ShadingPart<'a> {
    group: &'a Shadings,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    pictures: Option<Pictures>,
    /// By size and view.
    targets: BTreeMap<(u32, &'static str), LayerTargets>,
    ready: BTreeMap<usize, LayerScene>,
}

fn vertices(eye: &Eye, frame: &SurfaceFrame, projection: Projection) -> Vec<LayerVertex> {
    let places = frame.vertices_rte.iter();
    places
        .map(|vertex| {
            let relative_m = DVec3::from(vertex.map(f64::from));
            LayerVertex {
                clip: projection.clip(eye, relative_m).as_vec4().to_array(),
                to_eye: (-relative_m).as_vec3().to_array(),
                normal: normal(eye, relative_m).as_vec3().to_array(),
            }
        })
        .collect()
}

impl ShadingPart<'_> {
    fn frame(&self, work: &Work, eye: &Eye) -> Result<SurfaceFrame, String> {
        let surface = self.group.opened.get(KIND, [("n", work.n)])?;
        let frame = surface.frame(&eye.camera, eye.size);
        frame.map_err(|error| error.to_string())
    }
}

impl Session for ShadingPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        let eye = self.group.eye(&work)?;
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let pictures = self
            .pictures
            .get_or_insert_with(|| Pictures::new(&gpu, self.group.face));
        let key = (work.size_px, work.view);
        if let Entry::Vacant(entry) = self.targets.entry(key) {
            entry.insert(LayerTargets::new(&gpu, eye.size, pictures, &lights(&eye))?);
        }
        let frame = self.frame(&work, &eye)?;
        let vertices = vertices(&eye, &frame, work.projection);
        let places = vertices.iter().flat_map(|vertex| vertex.clip);
        let lost = places.filter(|at| !at.is_finite()).count();
        let targets = &self.targets[&key];
        let scene = targets.scene(work.shading, &vertices, &frame.triangles)?;
        targets.draw(&scene)?;
        let picture = targets.read()?;
        let (reason, mut figures) = match work.projection {
            Projection::Globe => of_globe(&eye, &frame, &work, (lost, &picture)),
            _ => of_other(lost, &picture),
        };
        let sent = std::mem::size_of_val(vertices.as_slice());
        figures.push(("globe_triangles", frame.triangles.len() as f64));
        figures.push(("globe_upload_bytes", sent as f64));
        let mut notes = Vec::new();
        if work.what != "tessellation" {
            let name = self.cases[case].id.key().replace(['/', '='], "-");
            let size = [work.size_px; 2];
            let pixels = picture.iter().map(|colour| bytes(*colour));
            let path = write_png(self.context.folder, &name, size, pixels)?;
            notes.push(("picture", path));
        }
        self.ready.insert(case, scene);
        Ok(judged(reason, figures, notes))
    }

    /// A frame as the paper's: the mesh is sent anew.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let eye = self.group.eye(&work)?;
        let mut watch = FrameWatch::start();
        let frame = self.frame(&work, &eye)?;
        let vertices = vertices(&eye, &frame, work.projection);
        watch.ends("globe_make_cpu_ms");
        let targets = self.targets.get(&(work.size_px, work.view));
        let targets = targets.ok_or("it has no targets".to_owned())?;
        let scene = verified(&mut self.ready, case)?;
        targets.send(scene, &vertices);
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(scene)?;
        Ok(watch.drawn(gpu_ms))
    }
}

/// Why a globe's picture is wrong, and its figures.
fn of_globe(
    eye: &Eye,
    frame: &SurfaceFrame,
    work: &Work,
    (lost, picture): (usize, &[[f32; 4]]),
) -> (String, Figures) {
    let found = judge(eye, frame, work.shading, picture);
    let mut figures = vec![
        ("globe_shade_px", found.shown as f64),
        ("globe_non_finite", (found.non_finite + lost) as f64),
    ];
    let mut add = |name, of: &[f64], share| {
        figures.extend(quantile(of, share).map(|value| (name, value)));
    };
    add("globe_shade_max", &found.all, 1.0);
    add("globe_shade_p99", &found.all, 0.99);
    add("globe_shade_polar_max", &found.polar, 1.0);
    add("globe_shade_polar_p99", &found.polar, 0.99);
    let worst = quantile(&found.all, 0.99).unwrap_or(f64::INFINITY);
    let reason = match (found.non_finite + lost, worst > ALLOWED) {
        (0, false) => String::new(),
        (0, true) => {
            format!("99 % of the pixels are within {worst:.3} of the functions, allowed {ALLOWED}")
        }
        (lost, _) => format!("{lost} pixels or vertices are not finite, allowed 0"),
    };
    (reason, figures)
}

/// The same of another projection, whose colours no ray says.
fn of_other(lost: usize, picture: &[[f32; 4]]) -> (String, Figures) {
    let non_finite = lost + picture.iter().filter(|colour| is_lost(colour)).count();
    let shown = picture.iter().filter(|colour| colour[3] != 0.0).count();
    let figures = vec![
        ("globe_shade_px", shown as f64),
        ("globe_non_finite", non_finite as f64),
    ];
    let reason = match (non_finite, shown) {
        (0, 0) => "it shows nothing".to_owned(),
        (0, _) => String::new(),
        (lost, _) => format!("{lost} pixels or vertices are not finite, allowed 0"),
    };
    (reason, figures)
}

#[cfg(test)]
mod tests;
