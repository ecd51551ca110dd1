// SPDX-License-Identifier: MIT OR Apache-2.0
//! Five layers over the spiral (Gebbie and Bailey, Tables 1 and 3): features taken away one after the other, cube maps
//! against pictures by angles, the faults of the printed shader, every projection, and triangles against pixels.

mod device;
mod layers;
mod section;

pub(crate) use section::blocks;

use crate::STUDY;
use crate::list::{Eye, List};
use crate::opened::Opened;
use crate::projection::Projection;
use device::{LayerScene, LayerTargets, LayerVertex, Pictures, Shading};
use glam::{DMat3, DVec3};
use layers::{Lights, colour};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;
use std::rc::Rc;
use terrafill_core::Geodetic;
use terrafill_fill::{CpuStopwatch, DeviceError};
use terrafill_reference::SurfaceTriangles;
use terrafill_results::{CaseId, PlannedCase, Status, Verdict, quantile};
use terrafill_study::{Context, Group, Session, StudyError};
use terrafill_surface::SurfaceFrame;
use toml::{Table, Value};

/// Name of this part in cases.
pub(crate) const PART: &str = "shading";
pub(crate) const KIND: &str = "spiral";

/// Texels along a side of a cube's face.
const FACE: u32 = 256;
const QUICK_FACE: u32 = 128;
/// Vertices of a turn of the ladder, and of the published numbers of triangles: 2,146, 4,294 and 17,058 in view
/// `globe`, within what whole turns allow.
const LADDER_N: u32 = 72;
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

/// All of it.
pub(crate) struct Shadings {
    work: Vec<Work>,
    cases: Vec<PlannedCase>,
    list: List,
    opened: Rc<Opened>,
    face: u32,
}

fn work(side_px: u32, is_quick: bool) -> Vec<Work> {
    let base = Work {
        view: "globe",
        size_px: side_px,
        n: LADDER_N,
        shading: Shading::default(),
        projection: Projection::Globe,
        what: "ladder",
    };
    let mut all: Vec<Work> = (0..=REMOVED)
        .map(|removed| Work {
            shading: Shading {
                removed,
                ..Shading::default()
            },
            ..base
        })
        .collect();
    for view in ["globe", "globe-pole"] {
        all.extend([false, true].map(|by_angles| Work {
            view,
            shading: Shading {
                by_angles,
                ..Shading::default()
            },
            what: "pictures",
            ..base
        }));
        all.extend(FAULTS.map(|(fault, _)| Work {
            view,
            shading: Shading {
                fault,
                ..Shading::default()
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
    if !is_quick {
        for size_px in WINDOWS_PX {
            for n in TABLE_1_N {
                all.extend([0, REMOVED].map(|removed| Work {
                    size_px,
                    n,
                    shading: Shading {
                        removed,
                        ..Shading::default()
                    },
                    what: "tessellation",
                    ..base
                }));
            }
        }
    }
    all
}

fn fault_name(fault: u32) -> &'static str {
    let mut faults = FAULTS.iter();
    faults
        .find(|(number, _)| *number == fault)
        .map_or("none", |(_, name)| name)
}

impl Shadings {
    pub(crate) fn new(
        list: &List,
        (side_px, samples): (u32, u32),
        is_quick: bool,
        opened: &Rc<Opened>,
    ) -> Self {
        let work = work(side_px, is_quick);
        let cases = work.iter().map(|work| {
            let pictures = if work.shading.by_angles {
                "angles"
            } else {
                "cube"
            };
            let fault = fault_name(work.shading.fault);
            let conditions = [
                ("part", PART.to_owned()),
                ("what", work.what.to_owned()),
                ("view", work.view.to_owned()),
                ("n", work.n.to_string()),
                ("removed", work.shading.removed.to_string()),
                ("pictures", pictures.to_owned()),
                ("fault", fault.to_owned()),
                ("projection", work.projection.name().to_owned()),
                ("size_px", work.size_px.to_string()),
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
        Self {
            cases: cases.collect(),
            work,
            list: list.clone(),
            opened: Rc::clone(opened),
            face: if is_quick { QUICK_FACE } else { FACE },
        }
    }

    fn eye(&self, work: &Work) -> Result<Eye, String> {
        let mut views = self.list.view.iter();
        let row = views.find(|row| row.name == work.view);
        let row = row.ok_or_else(|| format!("no view is called {:?}", work.view))?;
        Ok(row.eye(work.size_px))
    }
}

/// Low in the west, so that day, night and highlight are in every view of a globe.
fn lights(eye: &Eye) -> Lights {
    let up = eye.camera.eye_ecef.normalize();
    let west = up.cross(DVec3::Z).try_normalize().unwrap_or(DVec3::NEG_Y);
    Lights {
        sun: (0.25 * up + 0.9 * west + 0.2 * DVec3::Z).normalize(),
        clouds: DMat3::from_rotation_z(0.3),
    }
}

impl Group for Shadings {
    fn name(&self) -> String {
        format!("{STUDY}/{PART}")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(ShadingSession {
            group: self,
            context,
            pictures: None,
            targets: BTreeMap::new(),
            ready: BTreeMap::new(),
        }))
    }
}

struct ShadingSession<'a> {
    group: &'a Shadings,
    context: Context<'a>,
    pictures: Option<Pictures>,
    /// By size and view.
    targets: BTreeMap<(u32, &'static str), LayerTargets>,
    ready: BTreeMap<usize, LayerScene>,
}

/// What a picture's colours are.
#[derive(Debug, Clone, PartialEq, Default)]
struct Found {
    /// Of each compared pixel, the largest channel's difference from the functions.
    all: Vec<f64>,
    /// Within 5° of a pole.
    polar: Vec<f64>,
    non_finite: usize,
    shown: usize,
}

/// Sine of 85°.
const POLAR_SINE: f64 = 0.996_194_698_091_745_5;

/// Compares a picture with the functions, by the place that each pixel's ray meets.
fn judge(eye: &Eye, frame: &SurfaceFrame, shading: Shading, picture: &[[f32; 4]]) -> Found {
    let triangles = SurfaceTriangles::new(frame);
    let lights = lights(eye);
    let width = eye.size.width as usize;
    let judged: Vec<Option<(f64, bool)>> = (0..picture.len())
        .into_par_iter()
        .map(|pixel| {
            let centre = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
            let direction = eye.camera.direction_ecef(eye.size, centre);
            let (depth, facet) = triangles.hit_facet(direction, eye.camera.near_m)?;
            let shown = picture[pixel];
            if shown[3] == 0.0 {
                return None;
            }
            // Normal and direction to the eye are interpolated as the device does: from the triangle's corners.
            let corners = facet.map(|corner| (normal(eye, corner), -corner));
            let shares = shares(facet, direction * depth);
            let mixed = |of: &dyn Fn(usize) -> DVec3| {
                (0..3).fold(DVec3::ZERO, |sum, i| sum + of(i) * shares[i])
            };
            let n = mixed(&|i| corners[i].0).normalize();
            let expected = colour(&lights, shading.removed, n, mixed(&|i| corners[i].1));
            let off = (0..3).map(|i| (f64::from(shown[i]) - expected[i]).abs());
            // What is no number must not be lost in a maximum.
            let worst = off.fold(
                0.0,
                |worst: f64, off| if off <= worst { worst } else { off },
            );
            Some((worst, n.z.abs() > POLAR_SINE))
        })
        .collect();
    let is_lost = |colour: &&[f32; 4]| colour.iter().any(|channel| !channel.is_finite());
    let mut found = Found {
        non_finite: picture.iter().filter(is_lost).count(),
        shown: picture.iter().filter(|colour| colour[3] != 0.0).count(),
        ..Found::default()
    };
    for (off, is_polar) in judged
        .into_iter()
        .flatten()
        .filter(|(off, _)| off.is_finite())
    {
        found.all.push(off);
        if is_polar {
            found.polar.push(off);
        }
    }
    found
}

/// Shares of a triangle's corners at a point of it.
fn shares([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let share = |from: DVec3, to: DVec3| {
        (from - point).cross(to - point).dot(normal) / normal.length_squared()
    };
    [share(b, c), share(c, a), share(a, b)]
}

/// Geodetic normal of a place relative to the eye.
fn normal(eye: &Eye, relative_m: DVec3) -> DVec3 {
    let radii = eye.body.radii_m();
    ((eye.camera.eye_ecef + relative_m) / (radii * radii)).normalize()
}

fn vertices(eye: &Eye, frame: &SurfaceFrame, projection: Projection) -> Vec<LayerVertex> {
    let focus: Geodetic = eye.pose.eye;
    let places = frame.vertices_rte.iter();
    places
        .map(|vertex| {
            let relative_m = DVec3::from(vertex.map(f64::from));
            let clip = projection.clip((&eye.body, &eye.camera, eye.size), focus, relative_m);
            LayerVertex {
                clip: clip.as_vec4().to_array(),
                to_eye: (-relative_m).as_vec3().to_array(),
                normal: normal(eye, relative_m).as_vec3().to_array(),
            }
        })
        .collect()
}

impl ShadingSession<'_> {
    fn frame(&self, work: &Work, eye: &Eye) -> Result<SurfaceFrame, String> {
        let parameters = Table::from_iter([("n".to_owned(), Value::Integer(work.n.into()))]);
        let surface = self.group.opened.get(KIND, &parameters)?;
        let frame = surface.frame(&eye.camera, eye.size);
        frame.map_err(|error| error.to_string())
    }

    fn make(&mut self, case: usize) -> Result<Result<Verdict, String>, DeviceError> {
        let work = self.group.work[case];
        let eye = match self.group.eye(&work) {
            Ok(eye) => eye,
            Err(error) => return Ok(Err(error)),
        };
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let pictures = self
            .pictures
            .get_or_insert_with(|| Pictures::new(&gpu, self.group.face));
        let key = (work.size_px, work.view);
        if let Entry::Vacant(entry) = self.targets.entry(key) {
            entry.insert(LayerTargets::new(&gpu, eye.size, pictures, &lights(&eye))?);
        }
        let frame = match self.frame(&work, &eye) {
            Ok(frame) => frame,
            Err(error) => return Ok(Err(error)),
        };
        let vertices = vertices(&eye, &frame, work.projection);
        let lost = vertices
            .iter()
            .flat_map(|vertex| vertex.clip)
            .filter(|at| !at.is_finite());
        let lost = lost.count();
        let targets = &self.targets[&key];
        let scene = targets.scene(work.shading, &vertices, &frame.triangles)?;
        targets.draw(&scene)?;
        let picture = targets.read()?;
        let mut figures = vec![
            ("globe_triangles", frame.triangles.len() as f64),
            (
                "globe_upload_bytes",
                std::mem::size_of_val(vertices.as_slice()) as f64,
            ),
        ];
        let mut reason = String::new();
        let non_finite;
        if work.projection == Projection::Globe {
            let found = judge(&eye, &frame, work.shading, &picture);
            non_finite = found.non_finite + lost;
            let worst = quantile(&found.all, 0.99).unwrap_or(f64::INFINITY);
            if worst > ALLOWED {
                reason = format!(
                    "99 % of the pixels are within {worst:.3} of the functions, allowed {ALLOWED}"
                );
            }
            figures.push(("globe_shade_px", found.shown as f64));
            let mut add = |name, of: &[f64], share| {
                figures.extend(quantile(of, share).map(|value| (name, value)));
            };
            add("globe_shade_max", &found.all, 1.0);
            add("globe_shade_p99", &found.all, 0.99);
            add("globe_shade_polar_max", &found.polar, 1.0);
            add("globe_shade_polar_p99", &found.polar, 0.99);
        } else {
            let is_lost = |colour: &&[f32; 4]| colour.iter().any(|channel| !channel.is_finite());
            non_finite = picture.iter().filter(is_lost).count() + lost;
            let shown = picture.iter().filter(|colour| colour[3] != 0.0).count();
            figures.push(("globe_shade_px", shown as f64));
            if shown == 0 {
                reason = "it shows nothing".to_owned();
            }
        }
        figures.push(("globe_non_finite", non_finite as f64));
        if non_finite > 0 {
            reason = format!("{non_finite} pixels or vertices are not finite, allowed 0");
        }
        let mut notes = Vec::new();
        if work.what != "tessellation" {
            let name = self.group.cases[case].id.key().replace(['/', '='], "-");
            match write(self.context.folder, &name, work.size_px, &picture) {
                Ok(path) => notes.push(("picture", path)),
                Err(error) => return Ok(Err(error)),
            }
        }
        self.ready.insert(case, scene);
        Ok(Ok(Verdict {
            status: if reason.is_empty() {
                Status::Ok
            } else {
                Status::Wrong
            },
            reason,
            figures,
            notes,
        }))
    }

    /// A frame as the paper's: the mesh is sent anew.
    fn time(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let work = self.group.work[case];
        let eye = self.group.eye(&work)?;
        let watch = CpuStopwatch::start();
        let frame = self.frame(&work, &eye)?;
        let vertices = vertices(&eye, &frame, work.projection);
        let make_ms = watch.cpu_ms();
        let targets = self
            .targets
            .get(&(work.size_px, work.view))
            .ok_or("it has no targets")?;
        let scene = self.ready.get(&case).ok_or("it was not verified")?;
        targets.send(scene, &vertices);
        let upload_ms = watch.cpu_ms() - make_ms;
        let gpu_ms = targets.draw(scene).map_err(|error| error.to_string())?;
        let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let mut values = vec![
            ("globe_whole_cpu_ms", cpu_ms),
            ("globe_whole_wall_ms", wall_ms),
            ("globe_make_cpu_ms", make_ms),
            ("globe_upload_cpu_ms", upload_ms),
            ("globe_draw_cpu_ms", cpu_ms - make_ms - upload_ms),
        ];
        if let Some(gpu_ms) = gpu_ms {
            values.push(("globe_draw_gpu_ms", gpu_ms));
            values.push(("globe_whole_gpu_ms", make_ms + upload_ms + gpu_ms));
        }
        Ok(values)
    }
}

/// Writes a picture under `folder/images/` and returns its path relative to `folder`: what is not finite is magenta.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of 255 after clamping"
)]
fn write(folder: &Path, name: &str, side_px: u32, picture: &[[f32; 4]]) -> Result<String, String> {
    let relative = format!("images/{name}.png");
    let path = folder.join(&relative);
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let pixels = picture.iter().flat_map(|colour| {
        if colour.iter().any(|channel| !channel.is_finite()) {
            return [255, 0, 255];
        }
        [0, 1, 2].map(|i| (255.0 * colour[i].clamp(0.0, 1.0)).round() as u8)
    });
    let image = image::RgbImage::from_raw(side_px, side_px, pixels.collect());
    let image = image.ok_or_else(|| failed(&"wrong size"))?;
    std::fs::create_dir_all(folder.join("images")).map_err(|error| failed(&error))?;
    let saved = image.save_with_format(&path, image::ImageFormat::Png);
    saved.map_err(|error| failed(&error))?;
    Ok(relative)
}

impl Session for ShadingSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        Ok(match self.make(case) {
            Ok(Ok(verdict)) => verdict,
            Ok(Err(error)) => Verdict::failed(error),
            Err(error @ (DeviceError::Unsupported { .. } | DeviceError::OverCapacity { .. })) => {
                Verdict::skipped(error.to_string())
            }
            Err(error) => Verdict::failed(error.to_string()),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        self.time(case)
    }
}

#[cfg(test)]
mod tests;
