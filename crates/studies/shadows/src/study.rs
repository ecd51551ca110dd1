// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases, by question: each question is a group.

mod answers;
mod harbour;
mod lights;
mod meshes;
mod on_devices;

use self::meshes::Ready;
use crate::STUDY;
use crate::brought::{Brought, SETTING};
use crate::device_map::DeviceMap;
use crate::eyes::EyeTable;
use crate::job::Job;
use crate::lamps::{LampScene, MOON};
use crate::list::questions;
use crate::maps::Map;
use crate::metrics::{METRICS, QUESTION, SHADOW_MAP_CPU_MS, TIME};
use crate::views::Place;
use crate::work::{End, Scene, closed, port_m};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_casters::EdgeTable;
use terrafill_contract::{CpuStopwatch, FrameTimes};
use terrafill_results::{PlannedCase, Verdict};
use terrafill_shadow_views::{Draws, bridge};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, Planned, Request, Session, Study,
    StudyError, size_name, verified,
};

/// Pixels of each channel in which a case is checked: rays take long. What is timed has the request's size.
const QUICK_SIZE: [u32; 2] = [128, 96];
const SIZE: [u32; 2] = [200, 150];
/// The same of each of seven channels of a frame, unless a size is named: the paper names none.
const FRAME_SIZE: [u32; 2] = [512, 384];
/// Setting by which whoever renders keeps pictures.
const PICTURES: &str = "pictures";

/// Scenes kept: casters whole and cut, of one sun.
const SCENES: usize = 3;
/// Share of pixels on which a device's map and the CPU's may differ, %: texels' borders and heights are
/// rounded to f32.
const MAX_DIFFERS: f64 = 0.5;

/// What each optimisation of shadow volumes costs and what it gets wrong.
#[derive(Debug, Clone, Copy)]
pub struct ShadowsStudy;

impl Study for ShadowsStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: crate::chapter::CHAPTER,
    );

    fn needs_device(&self) -> bool {
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let size = if is_quick { QUICK_SIZE } else { SIZE };
        let timed_size = request.size_or(QUICK_SIZE);
        let frame_size = match (is_quick, request.names_size) {
            (_, true) => request.size,
            (true, false) => QUICK_SIZE,
            (false, false) => FRAME_SIZE,
        };
        let loses_nothing = request.settings.contains_key(PICTURES);
        let brought = brought(request)?.map(Rc::new);
        let groups = questions(request.depth, request.samples, brought.as_deref()).into_iter();
        let groups = groups.map(|(name, cases)| -> Box<dyn Group> {
            let sized = |(job, mut case): (Job, PlannedCase)| {
                let sizes = job.sizes(size, timed_size, frame_size).into_iter();
                let sizes = sizes.map(|(key, size)| (key.into(), size_name(size)));
                case.id.conditions.extend(sizes);
                (job, case)
            };
            let (jobs, cases) = cases.into_iter().map(sized).unzip();
            Box::new(CaseGroup {
                name: format!("{STUDY}/{name}"),
                cases,
                warm_up: None,
                work: Question {
                    name,
                    jobs,
                    size,
                    timed_size,
                    frame_size,
                    loses_nothing,
                    brought: brought.clone(),
                },
                open: |group, context| {
                    Ok(Box::new(Answering {
                        question: &group.work,
                        cases: &group.cases,
                        context,
                        scenes: Vec::new(),
                        eyes: None,
                        meshes: Vec::new(),
                        opened: BTreeMap::new(),
                        frames: BTreeMap::new(),
                        edges: None,
                        map: None,
                        lamp: None,
                    }))
                },
            })
        });
        let outlines = match brought {
            // Its models are seen from elsewhere.
            Some(_) => Vec::new(),
            None => terrafill_outlines::planned(STUDY, (QUESTION, "outlines"), request),
        };
        Ok(Planned {
            groups: groups.chain(outlines).collect(),
            ..Planned::default()
        })
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
    /// Of what is checked, pixels.
    size: [u32; 2],
    /// Of what is timed, pixels.
    timed_size: [u32; 2],
    /// Of each channel of a frame, pixels.
    frame_size: [u32; 2],
    /// Whether pictures for people are kept without loss.
    loses_nothing: bool,
    /// Instead of the port.
    brought: Option<Rc<Brought>>,
}

struct Answering<'a> {
    question: &'a Question,
    cases: &'a [PlannedCase],
    context: Context<'a>,
    /// The last ones, the very last at the end: cases of a sun follow one another.
    scenes: Vec<(String, Scene)>,
    eyes: Option<EyeTable>,
    meshes: Vec<Ready>,
    /// By case: what a device drew.
    opened: BTreeMap<usize, Box<dyn Draws>>,
    /// The same of frames: each of their channels.
    frames: BTreeMap<usize, Vec<Box<dyn Draws>>>,
    /// Of a scene by name, for silhouettes that are found each frame.
    edges: Option<(String, EdgeTable)>,
    /// The last one, of a sun, a size of texels and whether it is timed: it may fill half of a device.
    map: Option<([f64; 2], f64, bool, DeviceMap)>,
    /// The last one, by lamp, eye and size.
    lamp: Option<(String, LampScene)>,
}

impl Answering<'_> {
    /// The scene called `name`, made if it is none of the last ones.
    fn scene(
        &mut self,
        name: &str,
        make: impl FnOnce() -> Result<Scene, String>,
    ) -> Result<&Scene, String> {
        if let Some(place) = self.scenes.iter().position(|(own, _)| own == name) {
            self.scenes[place..].rotate_left(1);
        } else {
            self.scenes.push((name.to_owned(), make()?));
            let before = self.scenes.len().saturating_sub(SCENES);
            self.scenes.drain(..before);
        }
        let last = self.scenes.last().map(|(_, scene)| scene);
        last.ok_or_else(|| name.to_owned())
    }

    /// What stands over the sea under a sun, cut below it.
    fn under(&mut self, sun: [f64; 2]) -> Result<&Scene, String> {
        self.of_end(sun, End::Sea)
    }

    /// The port from a place, as volumes of that end have it.
    fn of_place(&mut self, place: Place, sun: [f64; 2], end: End) -> Result<&Scene, String> {
        let (size, feet_m) = (self.question.size, end.feet_m());
        self.scene(&format!("{} {sun:?} {feet_m:?}", place.name()), || {
            Scene::standing(&closed(port_m()?)?, sun, vec![place.view(size)], feet_m)
        })
    }

    /// The same as volumes of that end have it.
    fn of_end(&mut self, sun: [f64; 2], end: End) -> Result<&Scene, String> {
        let Question { size, brought, .. } = self.question;
        let feet_m = end.feet_m();
        self.scene(&format!("{sun:?} {feet_m:?}"), || {
            let Some(own) = brought else {
                return Scene::standing(&closed(port_m()?)?, sun, bridge(*size), feet_m);
            };
            let of = |feet_m| Scene::standing(&own.prepared, sun, own.views(*size), feet_m);
            // A user's model that has no simple cut stands as it is: it casts the same.
            of(feet_m).or_else(|_| of(None))
        })
    }
}

/// Of a frame's shadows.
fn filled(times: &FrameTimes) -> Figures {
    let mut values = vec![("shadow_fill_cpu_ms", times.fill_cpu_ms)];
    values.extend(times.fill_gpu_ms.map(|ms| ("shadow_fill_gpu_ms", ms)));
    values
}

/// Process CPU time of work that must find something.
fn watched<T>(
    metric: &'static str,
    work: impl FnOnce() -> Result<Vec<T>, Failure>,
) -> Result<Figures, Failure> {
    let watch = CpuStopwatch::start();
    let found = work()?;
    let cpu_ms = watch.cpu_ms();
    if found.is_empty() {
        Err("nothing was found".to_owned().into())
    } else {
        Ok(vec![(metric, cpu_ms)])
    }
}

impl Session for Answering<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        match self.question.jobs[case] {
            Job::DeviceMap(sun, texel_m, bias) => self.device_mapped(sun, texel_m, bias),
            Job::Harbour(sun, eyes, interface) => self.harbour(case, sun, eyes, interface),
            Job::Lamp(name, rule, limit) => self.lamp_counted(name, rule, limit),
            job @ Job::DeviceLamp(..) => self.lamp_drawn(case, job),
            Job::Moon(rule) => self.answer(Job::Updates(MOON, End::Sea, rule)),
            Job::DeviceMoon(eyes, interface, rule) => self.moonlit(eyes, interface, rule),
            job @ (Job::Origin(..) | Job::Facing(..)) => self.device(case, job),
            job if job.is_of_device() => self.device(case, job),
            job => self.answer(job),
        }
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        match self.question.jobs[case] {
            Job::Silhouette(name, method) => {
                let mesh = self.ready(name)?;
                watched(TIME.name, || Ok(mesh.sides(method)))
            }
            Job::DeviceMap(sun, texel_m, _) => {
                let size = self.question.timed_size;
                let scene = self.under(sun)?;
                let darkest = match scene.timed_at(size) {
                    Some(_) => 0,
                    None => scene.darkest_channel()?,
                };
                let times = self.map(sun, texel_m, true)?.time(darkest)?;
                let mut values = filled(&times);
                values.extend(times.stencil_gpu_ms.map(|ms| ("shadow_map_gpu_ms", ms)));
                Ok(values)
            }
            // The bias costs nothing: one comparison takes it in.
            Job::Map(sun, texel_m, _) => {
                let scene = self.under(sun)?;
                let mut kept = None;
                watched(SHADOW_MAP_CPU_MS.name, || {
                    let map = Map::of(scene.mesh(), scene.to_light, texel_m)?;
                    Ok(scene.asked(kept.insert(map)))
                })
            }
            Job::Harbour(..) => self.frame_times(case),
            job => {
                let found_ms = match job {
                    Job::StencilStep(sun, step) => self.volumes_ms(sun, step)?,
                    _ => None,
                };
                let times = verified(&mut self.opened, case)?.time()?;
                let mut values = filled(&times);
                values.extend(found_ms.map(|ms| ("shadow_volumes_cpu_ms", ms)));
                Ok(values)
            }
        }
    }
}

#[cfg(test)]
mod tests;
