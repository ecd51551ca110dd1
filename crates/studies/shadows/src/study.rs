// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases, by question: each question is a group.

mod on_devices;

use crate::brought::{Brought, SETTING};
use crate::casting::Asks;
use crate::chapter::ShadowsChapter;
use crate::count::{Rule, Wrong};
use crate::device::Draws;
use crate::device_map::DeviceMap;
use crate::eyes::EyeTable;
use crate::job::{Job, Method};
use crate::list::questions;
use crate::metrics::METRICS;
use crate::near::EyeTest;
use crate::outline::{Way, outlines};
use crate::view::sun;
use crate::views::Chooser;
use crate::way::DrawError;
use crate::work::{BOUNDS_SHARE, Drawn, End, Pixels, Scene, Scissor};
use crate::{STUDY, images};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_casters::{
    EdgeTable, Extent, Facing, Mesh, Policy, PortSize, Prepared, Side, Volume, by_hash, by_stack,
    hull, port,
};
use terrafill_fill::{CpuStopwatch, DeviceError};
use terrafill_results::{Chapter, Metric, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};

/// Pixels of a channel, and of the row of plates.
const QUICK_SIZE: [u32; 2] = [128, 96];
const SIZE: [u32; 2] = [200, 150];
/// Sun of silhouettes: every mesh has faces to and from it.
const SILHOUETTE_SUN: [f64; 2] = [30.0, -60.0];

/// Share of pixels on which a device's map and the CPU's may differ, %: texels' borders and heights are
/// rounded to f32.
const MAX_DIFFERS: f64 = 0.5;

/// What each optimisation of shadow volumes costs and what it gets wrong.
#[derive(Debug, Clone, Copy)]
pub struct ShadowsStudy;

impl Study for ShadowsStudy {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "What does each optimisation of shadow volumes save in a port, and what does it get wrong?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

    fn needs_device(&self) -> bool {
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let size = if is_quick { QUICK_SIZE } else { SIZE };
        let brought = brought(request)?.map(Rc::new);
        let groups = questions(request.depth, request.samples, brought.as_deref()).into_iter();
        let groups = groups.map(|(name, cases)| -> Box<dyn Group> {
            let (jobs, cases) = cases.into_iter().unzip();
            Box::new(Question {
                name,
                jobs,
                cases,
                size,
                brought: brought.clone(),
            })
        });
        Ok(Planned {
            groups: groups.collect(),
            skipped: Vec::new(),
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &ShadowsChapter
    }
}

/// The model that the request names.
fn brought(request: &Request) -> Result<Option<Brought>, StudyError> {
    let settings = request.settings.get(SETTING).map_or(&[][..], Vec::as_slice);
    match settings {
        [] => Ok(None),
        [one] => Brought::new(one).map(Some).map_err(StudyError::BadInput),
        more => {
            let found = more.len();
            let message = format!("--{SETTING}: found {found} files, allowed: 1");
            Err(StudyError::BadInput(message))
        }
    }
}

/// Cases that share what they are computed from.
struct Question {
    name: &'static str,
    jobs: Vec<Job>,
    cases: Vec<PlannedCase>,
    size: [u32; 2],
    /// Instead of the port.
    brought: Option<Rc<Brought>>,
}

impl Group for Question {
    fn name(&self) -> String {
        format!("{STUDY}/{}", self.name)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(Answering {
            question: self,
            context,
            scene: None,
            eyes: None,
            meshes: Vec::new(),
            opened: BTreeMap::new(),
            asking: BTreeMap::new(),
            edges: None,
            map: None,
        }))
    }
}

/// A mesh ready for silhouettes.
struct Ready {
    name: &'static str,
    prepared: Prepared,
    facing: Facing,
    table: EdgeTable,
}

struct Answering<'a> {
    question: &'a Question,
    context: Context<'a>,
    /// The last one: cases of a sun follow one another.
    scene: Option<(String, Scene)>,
    eyes: Option<EyeTable>,
    meshes: Vec<Ready>,
    /// By case: what a device drew.
    opened: BTreeMap<usize, Box<dyn Draws>>,
    /// By case: what a rival answers.
    asking: BTreeMap<usize, Box<dyn Asks>>,
    /// Of the last scene, for silhouettes that are found each frame.
    edges: Option<EdgeTable>,
    /// The last one, of a sun and a size of texels: it may fill half of a device.
    map: Option<([f64; 2], f64, DeviceMap)>,
}

type Figures = Vec<(&'static str, f64)>;

fn ready(name: &'static str, brought: Option<&Brought>) -> Result<Ready, String> {
    if let Some(own) = brought {
        return Ok(Ready::of(name, own.prepared.clone()));
    }
    let mut mesh = mesh_named(name)?;
    let policy = match name.contains("turned") {
        true => {
            turn_a_lit_face(&mut mesh);
            Policy::AsIs
        }
        false => Policy::Refuse,
    };
    let prepared = policy.prepare(mesh).map_err(|error| error.to_string())?;
    Ok(Ready::of(name, prepared))
}

fn mesh_named(name: &str) -> Result<Mesh, String> {
    let plain = name.split(',').next().unwrap_or(name);
    match plain.strip_prefix("hull-") {
        Some(triangles) => triangles
            .parse()
            .map(hull)
            .map_err(|_| format!("{name}: no mesh")),
        None => PortSize::named(plain)
            .map(port)
            .ok_or_else(|| format!("{name}: no mesh")),
    }
}

/// Turns the first triangle that faces away from the sun and has a lit neighbour, so that it faces the
/// sun and two lit triangles have an edge the same way round.
fn turn_a_lit_face(mesh: &mut Mesh) {
    let to_light = sun(SILHOUETTE_SUN);
    let facing = Facing::of(mesh, to_light);
    let is_lit = |at: usize| facing.is_lit[at];
    let has_lit_neighbour = |at: usize| {
        let own = mesh.triangles[at];
        let shared = |other: &[u32; 3]| other.iter().filter(|corner| own.contains(corner)).count();
        let mut all = mesh.triangles.iter().enumerate();
        all.any(|(other, corners)| is_lit(other) && shared(corners) == 2)
    };
    let found = (0..mesh.triangles.len()).find(|at| !is_lit(*at) && has_lit_neighbour(*at));
    if let Some(at) = found {
        mesh.triangles[at].swap(1, 2);
        let plane = u32::try_from(mesh.normals.len()).unwrap_or(0);
        let turned = -mesh.normals[mesh.planes[at] as usize];
        mesh.normals.push(turned);
        mesh.planes[at] = plane;
    }
}

impl Ready {
    fn of(name: &'static str, prepared: Prepared) -> Self {
        Self {
            name,
            facing: Facing::of(&prepared.mesh, sun(SILHOUETTE_SUN)),
            table: EdgeTable::of(&prepared.mesh),
            prepared,
        }
    }

    fn sides(&self, method: Method) -> Vec<Side> {
        match method {
            Method::Stack => by_stack(&self.prepared.mesh, &self.facing),
            Method::Hash => by_hash(&self.prepared.mesh, &self.facing),
            Method::Adjacency => self.table.sides(&self.prepared, &self.facing),
        }
    }
}

fn verdict(is_right: bool, reason: String, figures: Figures) -> Verdict {
    Verdict {
        status: if is_right { Status::Ok } else { Status::Wrong },
        reason: if is_right { String::new() } else { reason },
        figures,
        notes: Vec::new(),
    }
}

/// A share in per cent.
fn percent(part: f64, whole: usize) -> f64 {
    100.0 * part / whole.max(1) as f64
}

fn drawn_figures(drawn: &Drawn, pixels: Pixels) -> Figures {
    vec![
        ("shadow_receiver_px", pixels.receivers as f64),
        ("shadow_px", pixels.shadow as f64),
        ("shadow_edge_on_px", pixels.edge_on as f64),
        ("shadow_undecided_px", pixels.undecided as f64),
        ("shadow_false_lit_px", drawn.wrong.false_lit as f64),
        ("shadow_false_dark_px", drawn.wrong.false_dark as f64),
        ("shadow_band_px", drawn.wrong.in_band as f64),
        (
            "shadow_lost_share",
            percent(drawn.lost as f64, pixels.shadow),
        ),
        ("shadow_updates", drawn.updates as f64 / pixels.all as f64),
        ("shadow_volume_triangles", drawn.volume_triangles as f64),
        ("shadow_max_overlap", f64::from(drawn.max_overlap)),
    ]
}

fn drawn_verdict(drawn: &Drawn, pixels: Pixels) -> Verdict {
    verdict_of(drawn.wrong, drawn_figures(drawn, pixels))
}

fn verdict_of(wrong: Wrong, figures: Figures) -> Verdict {
    let reason = format!(
        "{} pixels lit in shadow, {} in shadow in the light, outside the band",
        wrong.false_lit, wrong.false_dark
    );
    verdict(wrong.outside() == 0, reason, figures)
}

impl Answering<'_> {
    /// The scene called `name`, made if the last one is another.
    fn scene(
        &mut self,
        name: &str,
        make: impl FnOnce() -> Result<Scene, String>,
    ) -> Result<&Scene, String> {
        if self.scene.as_ref().is_none_or(|(own, _)| own != name) {
            self.scene = Some((name.to_owned(), make()?));
            self.edges = None;
        }
        self.scene
            .as_ref()
            .map(|(_, scene)| scene)
            .ok_or_else(|| name.to_owned())
    }

    fn under(&mut self, sun: [f64; 2]) -> Result<&Scene, String> {
        let Question { size, brought, .. } = self.question;
        self.scene(&format!("{sun:?}"), || match brought {
            Some(own) => {
                let prepared = own.prepared.clone();
                Ok(Scene::of_prepared(prepared, sun, own.views(*size)))
            }
            None => Scene::new(sun, *size),
        })
    }

    fn answer(&mut self, job: Job) -> Result<Verdict, String> {
        let folder = self.context.folder;
        match job {
            Job::Eye(sun, near, test) => self.eye(sun, near, test),
            Job::Updates(sun, end, rule) => {
                let scene = self.under(sun)?;
                let drawn = scene.drawn(end, rule, Scissor::Off)?;
                let mut verdict = drawn_verdict(&drawn, scene.pixels());
                if end == End::Sea && rule == Rule::Fail {
                    let channel = scene.darkest().ok_or("no channel")?;
                    let name = format!("sun-{}-{}", sun[0], sun[1]);
                    let path = images::write(folder, &name, &channel.1, None)?;
                    verdict.notes.push(("reference_image", path));
                }
                Ok(verdict)
            }
            Job::Scissor(sun, scissor) => {
                let scene = self.under(sun)?;
                let drawn = scene.drawn(End::Infinite, Rule::Fail, scissor)?;
                let mut verdict = drawn_verdict(&drawn, scene.pixels());
                if scissor == Scissor::ReceiverRectangle {
                    // What is meant to be left out is the sea's shadow; a caster's must not be.
                    let text = format!(
                        "{} of the lost pixels lie on casters",
                        drawn.lost_on_casters
                    );
                    verdict.reason = text;
                }
                let channel = scene.darkest().ok_or("no channel")?;
                let mask = scene.mask(channel, End::Infinite, Rule::Fail, scissor)?;
                let path = images::write(folder, scissor.name(), &channel.1, Some(&mask))?;
                verdict.notes.push(("image", path));
                Ok(verdict)
            }
            Job::Bounds(sun, rule) => {
                let scene = self.under(sun)?;
                let drawn = scene.drawn_within(rule, BOUNDS_SHARE)?;
                Ok(drawn_verdict(&drawn, scene.pixels()))
            }
            Job::View(sun, place, chooser) => {
                let size = self.question.size;
                let make = || Scene::of_place(place, sun, size);
                let scene = self.scene(place.name(), make)?;
                let drawn = scene.drawn_chosen(chooser)?;
                let mut verdict = drawn_verdict(&drawn, scene.pixels());
                if chooser == Chooser::ALL[0] {
                    let (_, truth) = scene.darkest().ok_or("no channel")?;
                    let path = images::write(folder, place.name(), truth, None)?;
                    verdict.notes.push(("reference_image", path));
                }
                Ok(verdict)
            }
            Job::Finite(sun, length) => {
                let scene = self.under(sun)?;
                let drawn = scene.drawn(End::Finite(length), Rule::Fail, Scissor::Off)?;
                Ok(drawn_verdict(&drawn, scene.pixels()))
            }
            Job::Row(count, guard) => {
                let size = self.question.size;
                let scene = self.scene(&count.to_string(), || Scene::of_row(count, size))?;
                let drawn = match guard {
                    true => scene.drawn_guarded(Rule::Pass)?,
                    false => scene.drawn(End::Infinite, Rule::Pass, Scissor::Off)?,
                };
                Ok(drawn_verdict(&drawn, scene.pixels()))
            }
            Job::Casters(policy) => {
                let size = self.question.size;
                let scene = self.scene("hull", || Scene::of_hull(size))?;
                match scene.drawn_open(policy) {
                    Ok((drawn, triangles)) => {
                        let mut verdict = drawn_verdict(&drawn, scene.pixels());
                        verdict
                            .figures
                            .push(("shadow_mesh_triangles", triangles as f64));
                        Ok(verdict)
                    }
                    // As it should be: the mesh is not closed.
                    Err(error) if policy == Policy::Refuse => Ok(Verdict {
                        status: Status::Ok,
                        reason: error.to_string(),
                        ..Verdict::default()
                    }),
                    Err(error) => Err(error.to_string()),
                }
            }
            Job::Outline(models, way) => {
                let (clears, wrong) = outlines(models, way);
                let expected = match way {
                    Way::Clear => u64::from(models),
                    Way::Value | Way::ValueAsPrinted => 1 + u64::from(models / 255),
                    Way::ValueNeverCleared => 1,
                };
                let reason = format!("{wrong} contour pixels wrong, {clears} clears of {expected}");
                let figures = vec![
                    ("shadow_clears", clears as f64),
                    ("shadow_contour_px", wrong as f64),
                ];
                Ok(verdict(wrong == 0 && clears == expected, reason, figures))
            }
            Job::Silhouette(mesh, method) => self.silhouette(mesh, method),
            Job::Model => {
                let own = self.question.brought.as_deref().ok_or("no model")?;
                let mesh = &own.prepared.mesh;
                Ok(Verdict {
                    status: Status::Ok,
                    reason: format!("policy {}: {}", own.policy.name(), own.verdict),
                    figures: vec![
                        ("shadow_mesh_triangles", mesh.triangles.len() as f64),
                        ("shadow_mesh_models", mesh.casters.len() as f64),
                        ("shadow_mesh_parts", mesh.parts.len() as f64),
                    ],
                    notes: Vec::new(),
                })
            }
            Job::Map(sun, texel_m, bias) => {
                let scene = self.under(sun)?;
                let mapped = match scene.mapped(texel_m, bias) {
                    Ok(mapped) => mapped,
                    Err(error) => return Ok(Verdict::skipped(error.to_string())),
                };
                let wrong = mapped.wrong;
                let all = wrong.outside() + wrong.in_band;
                let share = |count: usize| percent(count as f64, mapped.judged);
                let figures = vec![
                    ("shadow_map_wrong", share(all)),
                    ("shadow_map_wrong_in_three", 100.0 * mapped.wrong_in_three),
                    ("shadow_map_wrong_unbiased", share(mapped.unbiased)),
                    ("shadow_map_bias_m", mapped.bias_m),
                    ("shadow_bytes", mapped.bytes as f64),
                    ("shadow_false_lit_px", wrong.false_lit as f64),
                    ("shadow_false_dark_px", wrong.false_dark as f64),
                    ("shadow_band_px", wrong.in_band as f64),
                ];
                let mut verdict = verdict_of(wrong, figures);
                let darkest = scene.darkest_channel().ok_or("no channel")?;
                let name = format!("map-{}-{texel_m}-{}", sun[0], bias.name());
                let (truth, mask) = (&scene.channels[darkest].1, &mapped.masks[darkest]);
                let path = images::write(folder, &name, truth, Some(mask))?;
                verdict.notes.push(("image", path));
                Ok(verdict)
            }
            Job::Device(..)
            | Job::Origin(..)
            | Job::Facing(..)
            | Job::Near(..)
            | Job::DeviceRow(..)
            | Job::DeviceMap(..)
            | Job::Rival(..)
            | Job::Rung(..) => Err("devices answer by case".to_owned()),
        }
    }

    fn eye(&mut self, sun: [f64; 2], near: f64, test: EyeTest) -> Result<Verdict, String> {
        if self.eyes.as_ref().is_none_or(|table| table.at != sun) {
            self.eyes = Some(EyeTable::new(sun)?);
        }
        let table = self.eyes.as_ref().ok_or("no eyes")?;
        let result = table.result(test, near).ok_or("no such near plane")?;
        let mut figures = vec![
            (
                "shadow_eyes_missed",
                percent(result.missed as f64, result.eyes),
            ),
            (
                "shadow_eyes_missed_at_corners",
                percent(result.missed_at_corners as f64, result.eyes),
            ),
            (
                "shadow_eyes_needless",
                percent(result.needless as f64, result.eyes),
            ),
            (
                "shadow_fail_triangles",
                percent(result.fail_share, result.eyes),
            ),
        ];
        if result.missed > 0 {
            figures.push((
                "shadow_near_dark",
                percent(result.missed_share, result.missed),
            ));
        }
        let reason = format!("{} of {} eyes missed", result.missed, result.eyes);
        let mut verdict = verdict(result.missed == 0, reason, figures);
        let is_last_near = crate::work::NEARS.last().is_some_and(|last| *last <= near);
        if test == EyeTest::Eye
            && is_last_near
            && let Some((truth, [missed, exact])) = table.missed()?
        {
            let folder = self.context.folder;
            for (key, what, mask) in [
                ("reference_image", "reference", None),
                ("image", "eye", Some(&missed)),
                ("exact_image", "exact", Some(&exact)),
            ] {
                let name = format!("eye-{}-{what}", sun[0]);
                let path = images::write(folder, &name, &truth, mask.map(Vec::as_slice))?;
                verdict.notes.push((key, path));
            }
        }
        Ok(verdict)
    }

    fn ready(&mut self, name: &'static str) -> Result<&Ready, String> {
        let place = match self.meshes.iter().position(|own| own.name == name) {
            Some(place) => place,
            None => {
                let brought = self.question.brought.as_deref();
                self.meshes.push(ready(name, brought)?);
                self.meshes.len() - 1
            }
        };
        Ok(&self.meshes[place])
    }

    fn silhouette(&mut self, name: &'static str, method: Method) -> Result<Verdict, String> {
        let mesh = self.ready(name)?;
        let sides = mesh.sides(method);
        let to_light = sun(SILHOUETTE_SUN);
        let volume = Volume::of(
            &mesh.prepared,
            &mesh.facing,
            &sides,
            to_light,
            &Extent::Infinite,
        );
        let open = volume
            .map_err(|error| error.to_string())?
            .open_edges()
            .len();
        let figures = vec![
            ("shadow_sides", sides.len() as f64),
            (
                "shadow_mesh_triangles",
                mesh.prepared.mesh.triangles.len() as f64,
            ),
            ("shadow_open_edges", open as f64),
        ];
        Ok(verdict(
            open == 0,
            format!("{open} edges of the volumes are open"),
            figures,
        ))
    }
}

impl Session for Answering<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let answer = match self.question.jobs[case] {
            job @ (Job::Device(..)
            | Job::Origin(..)
            | Job::Facing(..)
            | Job::Near(..)
            | Job::DeviceRow(..)
            | Job::Rung(..)) => self.device(case, job),
            Job::Rival(sun, rival) => self.rival(case, sun, rival),
            Job::DeviceMap(sun, texel_m, bias) => self.device_mapped(sun, texel_m, bias),
            job => self.answer(job).map_err(DrawError::from),
        };
        Ok(answer.unwrap_or_else(|error| match error {
            // A device that is missing, or lacks something, is no defect.
            DrawError::Device(error @ DeviceError::Unsupported { .. }) => {
                Verdict::skipped(error.to_string())
            }
            error @ DrawError::Unfit(_) => Verdict::skipped(error.to_string()),
            error => Verdict::failed(error.to_string()),
        }))
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let (name, method) = match self.question.jobs[case] {
            Job::Silhouette(name, method) => (name, method),
            Job::Device(..) | Job::Near(..) | Job::DeviceRow(..) => {
                let channel = self.opened.get_mut(&case).ok_or("it was not verified")?;
                let times = channel.time().map_err(|error| error.to_string())?;
                let mut values = vec![("shadow_fill_cpu_ms", times.fill_cpu_ms)];
                values.extend(times.fill_gpu_ms.map(|ms| ("shadow_fill_gpu_ms", ms)));
                return Ok(values);
            }
            Job::Rung(sun, rung) => {
                let found_ms = self.volumes_ms(sun, rung)?;
                let channel = self.opened.get_mut(&case).ok_or("it was not verified")?;
                let times = channel.time().map_err(|error| error.to_string())?;
                let mut values = vec![("shadow_fill_cpu_ms", times.fill_cpu_ms)];
                values.extend(times.fill_gpu_ms.map(|ms| ("shadow_fill_gpu_ms", ms)));
                values.extend(found_ms.map(|ms| ("shadow_volumes_cpu_ms", ms)));
                return Ok(values);
            }
            Job::Rival(..) => {
                let asking = self.asking.get_mut(&case).ok_or("it was not verified")?;
                let times = asking.time().map_err(|error| error.to_string())?;
                let mut values = vec![("shadow_fill_cpu_ms", times.fill_cpu_ms)];
                values.extend(times.fill_gpu_ms.map(|ms| ("shadow_fill_gpu_ms", ms)));
                return Ok(values);
            }
            Job::DeviceMap(sun, texel_m, _) => {
                let failed = |error: DrawError| error.to_string();
                let darkest = self.under(sun)?.darkest_channel().ok_or("no channel")?;
                let times = self.map(sun, texel_m).map_err(failed)?.time(darkest);
                let times = times.map_err(|error| error.to_string())?;
                let mut values = vec![("shadow_fill_cpu_ms", times.fill_cpu_ms)];
                values.extend(times.fill_gpu_ms.map(|ms| ("shadow_fill_gpu_ms", ms)));
                values.extend(times.stencil_gpu_ms.map(|ms| ("shadow_map_gpu_ms", ms)));
                return Ok(values);
            }
            // The bias costs nothing: one comparison takes it in.
            Job::Map(sun, texel_m, _) => {
                let scene = self.under(sun)?;
                let watch = CpuStopwatch::start();
                let map = scene.map(texel_m).map_err(|error| error.to_string())?;
                let asked = scene.asked(&map);
                let cpu_ms = watch.cpu_ms();
                return match asked.is_empty() {
                    true => Err("nothing is seen".to_owned()),
                    false => Ok(vec![("shadow_map_cpu_ms", cpu_ms)]),
                };
            }
            _ => return Err("nothing of it is timed".to_owned()),
        };
        let mesh = self.ready(name)?;
        let watch = CpuStopwatch::start();
        let sides = mesh.sides(method);
        let cpu_ms = watch.cpu_ms();
        match sides.is_empty() {
            true => Err("no silhouette".to_owned()),
            false => Ok(vec![("shadow_silhouette_cpu_ms", cpu_ms)]),
        }
    }
}

#[cfg(test)]
mod tests;
