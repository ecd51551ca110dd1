// SPDX-License-Identifier: MIT OR Apache-2.0
//! Five layers over the spiral (Gebbie and Bailey, Tables 1 and 3), of real pictures of the Earth where there is data:
//! from which side they are seen, how bumps are stored, features taken away one after the other, the faults of the
//! printed shader, every projection. Cube maps stand against pictures by angles, triangles against pixels.

mod device;
mod judge;
mod layers;
mod section;
mod sources;
#[cfg(test)]
mod synthetic;
mod tessellation;
mod texels;

pub(crate) use section::SECTIONS;
#[cfg(test)]
pub(crate) use section::TABLE_3;
pub(crate) use sources::layers;

use crate::STUDY;
use crate::clock::FrameWatch;
use crate::image::write_png;
use crate::list::{Eye, List, ShadedRow};
use crate::metrics::{self, BUMPS, CELLS, FAULT, HOURS, PICTURES, PROJECTION, SIZE_PX, VIEW, WHAT};
use crate::opened::Opened;
use crate::projection::Projection;
use device::{LayerScene, LayerTargets, LayerTextures, LayerVertex, Shading};
use glam::DVec3;
use judge::{Met, bytes, is_lost, judge, normal};
use layers::{Lights, Sampled};
use sources::Sources;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_results::{Case, CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, Context, Failure, Figures, Session, judged, verified};
use terrafill_surface::SurfaceFrame;
use texels::Pictures;

/// Name of this part in cases.
pub(crate) const PART: &str = "shading";
pub(crate) const KIND: &str = "spiral";

/// Texels along a side of a cube's face: as dense along the equator as the finest picture, 4,096 round it.
const FACE: u32 = 1024;
const QUICK_FACE: u32 = 256;
/// Vertices of a turn of the ablation, and of the published numbers of triangles: 2,146, 4,294 and 17,058 in view
/// `day`, within what whole turns allow.
const ABLATION_N: u32 = 72;
const TABLE_1_N: [u32; 3] = [47, 66, 132];
const WINDOWS_PX: [u32; 3] = [600, 800, 1000];
const REMOVED: u32 = 7;
const VIEWS: [&str; 4] = ["day", "night-edge", "limb", "pole"];
/// Hours after which the moving clouds are drawn, beside those of the view itself.
const HOURS_LATER: [u32; 2] = [0, 48];
/// Share of a picture's pixels that wrong layers must be found in.
const CONTROL_SHARE: f64 = 0.01;

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
    /// For which clouds have moved; that of the view if none.
    hours: Option<u32>,
    /// What it is for.
    what: &'static str,
}

/// All work on shading, as one group of cases.
pub(crate) struct Shadings {
    work: Vec<Work>,
    list: List,
    opened: Rc<Opened>,
    face: u32,
    sources: Sources,
}

/// Ways to store bumps and pictures, one change from the first.
fn storages() -> [Shading; 3] {
    let cube = Shading::default();
    let object = Shading {
        is_object_space: true,
        ..cube
    };
    let angles = Shading {
        by_angles: true,
        ..cube
    };
    [cube, object, angles]
}

fn work(side_px: u32, is_quick: bool) -> Vec<Work> {
    let base = Work {
        view: VIEWS[0],
        size_px: side_px,
        n: ABLATION_N,
        shading: Shading::default(),
        projection: Projection::Globe,
        hours: None,
        what: "ladder",
    };
    let without = |removed| Shading {
        removed,
        ..base.shading
    };
    let mut all = Vec::new();
    for view in VIEWS {
        all.extend(storages().map(|shading| Work {
            view,
            shading,
            what: "layers",
            ..base
        }));
    }
    all.extend(HOURS_LATER.map(|hours| Work {
        hours: Some(hours),
        what: "clouds",
        ..base
    }));
    all.extend((0..=REMOVED).map(|removed| Work {
        shading: without(removed),
        ..base
    }));
    for view in ["day", "pole"] {
        all.extend(FAULTS.map(|(fault, _)| Work {
            view,
            shading: Shading {
                fault,
                ..base.shading
            },
            what: "faults",
            ..base
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

impl Work {
    fn id(&self, view: Option<&ShadedRow>) -> CaseId {
        let Self { shading, .. } = self;
        let pictures = if shading.by_angles { "angles" } else { "cube" };
        let bumps = if shading.is_object_space {
            "object"
        } else {
            "tangent"
        };
        let hours = self.hours.or(view.map(|view| view.hours)).unwrap_or(0);
        let fault = fault_name(shading.fault);
        let conditions = [
            (metrics::PART, PART.to_owned()),
            (WHAT, self.what.to_owned()),
            (VIEW, self.view.to_owned()),
            (CELLS, self.n.to_string()),
            (metrics::REMOVED, shading.removed.to_string()),
            (PICTURES, pictures.to_owned()),
            (BUMPS, bumps.to_owned()),
            (FAULT, fault.to_owned()),
            (PROJECTION, self.projection.name().to_owned()),
            (HOURS, hours.to_string()),
            (SIZE_PX, self.size_px.to_string()),
        ];
        let name = format!(
            "{PART}/{}/{}/n={}/removed={}/{pictures}/{bumps}/{fault}/{}/hours={hours}/{}",
            self.what,
            self.view,
            self.n,
            shading.removed,
            self.projection.name(),
            self.size_px
        );
        CaseId::new(STUDY, name, conditions)
    }
}

impl Shadings {
    pub(crate) fn planned(
        list: &List,
        (side_px, samples): (u32, u32),
        is_quick: bool,
        sources: Sources,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let work = work(side_px, is_quick);
        let cases = work.iter().map(|work| PlannedCase {
            id: work.id(list.shaded(work.view).ok()),
            samples,
            may_be_wrong: work.shading.fault > 0,
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
                sources,
            },
            open: |group, context| {
                Ok(Box::new(ShadingPart {
                    group: &group.work,
                    cases: &group.cases,
                    context,
                    pictures: None,
                    targets: BTreeMap::new(),
                    met: None,
                    ready: BTreeMap::new(),
                }))
            },
        }
    }

    fn eye(&self, work: &Work) -> Result<Eye, String> {
        Ok(self.list.shaded(work.view)?.eye(work.size_px))
    }

    fn lights(&self, work: &Work) -> Result<Lights, String> {
        let view = self.list.shaded(work.view)?;
        Ok(Lights::new(view, work.hours.unwrap_or(view.hours)))
    }
}

/// A view, pixels a side and vertices a turn: what the triangles that rays meet depend on.
type MetBy = (&'static str, u32, u32);

struct ShadingPart<'a> {
    group: &'a Shadings,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    /// As the reference reads them, and as the device does.
    pictures: Option<(Pictures, LayerTextures)>,
    /// By pixels a side.
    targets: BTreeMap<u32, LayerTargets>,
    /// Of the view last judged.
    met: Option<(MetBy, Met)>,
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

    /// Why a globe's picture is wrong, and its figures.
    fn of_globe(
        &mut self,
        work: &Work,
        (eye, lights): (&Eye, &Lights),
        frame: &SurfaceFrame,
        (lost, picture): (usize, &[[f32; 4]]),
    ) -> (String, Figures) {
        let by = (work.view, work.size_px, work.n);
        if self.met.as_ref().is_none_or(|(known, _)| *known != by) {
            self.met = Some((by, Met::new(eye, frame)));
        }
        let (Some((_, met)), Some((pictures, _))) = (&self.met, &self.pictures) else {
            return ("no layers were made".to_owned(), Figures::new());
        };
        let sampled = Sampled {
            pictures,
            shading: work.shading,
        };
        let layers = (&sampled, &self.group.sources);
        // Clouds that have not moved are no control of themselves.
        let controls = work.what == "layers";
        let found = judge(eye, met, lights, layers, picture, controls);
        let mut figures = vec![
            ("globe_shade_px", found.shown as f64),
            ("globe_shade_beyond_px", found.beyond as f64),
            ("globe_non_finite", (found.non_finite + lost) as f64),
            ("globe_drawn_otherwise_px", found.otherwise as f64),
        ];
        let mut add = |name, of: &[f64], share| {
            figures.extend(quantile(of, share).map(|value| (name, value)));
        };
        add("globe_shade_texels_max", &found.from_texels, 1.0);
        add("globe_shade_max", &found.all, 1.0);
        add("globe_shade_p99", &found.all, 0.99);
        add("globe_shade_polar_max", &found.polar, 1.0);
        add("globe_shade_polar_p99", &found.polar, 0.99);
        let least = found.controls.map(|controls| {
            let least = controls.into_iter().min().unwrap_or(0);
            figures.push(("globe_shade_control_px", least as f64));
            least as f64
        });
        let reason = if found.non_finite + lost > 0 {
            let lost = found.non_finite + lost;
            format!("{lost} pixels or vertices are not finite, allowed 0")
        } else if found.shown == 0 {
            "it shows nothing".to_owned()
        } else if found.beyond > 0 {
            let off = quantile(&found.from_texels, 1.0).unwrap_or(f64::INFINITY);
            format!(
                "{} pixels are farther from the same texels in f64 than 8 bits of place and value explain, by up to \
                 {off:.4}, allowed 0",
                found.beyond
            )
        } else if found.otherwise > 0 {
            format!(
                "{} pixels are drawn that no ray meets, or the other way round, allowed 0",
                found.otherwise
            )
        } else if least.is_some_and(|least| least < CONTROL_SHARE * found.shown as f64) {
            "wrong layers are found in less than 1 % of the pixels: the comparison sees nothing"
                .to_owned()
        } else {
            String::new()
        };
        (reason, figures)
    }
}

impl Session for ShadingPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let work = self.group.work[case];
        let (eye, lights) = (self.group.eye(&work)?, self.group.lights(&work)?);
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let (_, textures) = self.pictures.get_or_insert_with(|| {
            let pictures = Pictures::new(&self.group.sources, self.group.face);
            let textures = LayerTextures::new(&gpu, &pictures);
            (pictures, textures)
        });
        let targets = self.targets.entry(work.size_px);
        let targets = targets.or_insert_with(|| LayerTargets::new(&gpu, eye.size, textures));
        let surface = self.group.opened.get(KIND, [("n", work.n)])?;
        let frame = surface.frame(&eye.camera, eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let vertices = vertices(&eye, &frame, work.projection);
        let places = vertices.iter().flat_map(|vertex| vertex.clip);
        let lost = places.filter(|at| !at.is_finite()).count();
        let scene = targets.scene(work.shading, &vertices, &frame.triangles)?;
        let sent = targets.send(&scene, &lights, &vertices);
        targets.draw(&scene)?;
        let picture = targets.read()?;
        self.ready.insert(case, scene);
        let (reason, mut figures) = match work.projection {
            Projection::Globe => self.of_globe(&work, (&eye, &lights), &frame, (lost, &picture)),
            _ => of_other(lost, &picture),
        };
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
        Ok(judged(reason, figures, notes))
    }

    /// A frame as the paper's: the mesh is sent anew.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let (eye, lights) = (self.group.eye(&work)?, self.group.lights(&work)?);
        let mut watch = FrameWatch::start();
        let frame = self.frame(&work, &eye)?;
        let vertices = vertices(&eye, &frame, work.projection);
        watch.ends("globe_make_cpu_ms");
        let targets = self.targets.get(&work.size_px);
        let targets = targets.ok_or("it has no targets".to_owned())?;
        let scene = verified(&mut self.ready, case)?;
        targets.send(scene, &lights, &vertices);
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(scene)?;
        Ok(watch.drawn(gpu_ms))
    }
}

/// Why a picture of another projection is wrong, whose colours no ray says, and its figures.
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
