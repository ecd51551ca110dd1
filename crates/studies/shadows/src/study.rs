// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases, by question: each question is a group.

mod answers;
mod driver_fault;
mod harbour;
mod lights;
mod meshes;
mod on_devices;

use self::meshes::Ready;
use crate::STUDY;
use crate::brought::{Brought, SETTING};
use crate::device_map::DeviceMap;
use crate::drawing::{DeviceDrawn, mask_hash_of, times_of};
use crate::eyes::EyeTable;
use crate::job::Job;
use crate::lamps::{LampDrawn, LampScene, MOON};
use crate::list::questions;
use crate::maps::Map;
use crate::metrics::{
    METRICS, QUESTION, SHADOW_MAP_CPU_MS, SHADOW_PLANNED_CPU_MS, SIZE_PX, TIME, WHOLE_CPU,
    WHOLE_WALL,
};
use crate::views::Eyes;
use crate::work::{End, Scene, closed, port_m};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_casters::EdgeTable;
use terrafill_contract::{CpuStopwatch, FrameTimes};
use terrafill_results::{PlannedCase, Verdict};
use terrafill_shadow_views::{Draws, bridge};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, JudgedOnce, Planned, Request, Shows, Study,
    StudyError, size_name, verified,
};

/// Pixels of each channel in which the CPU answers: rays take long. A quick run has them of everything.
const QUICK_SIZE: [u32; 2] = [128, 96];
const SIZE: [u32; 2] = [200, 150];
/// The same of what a device draws, unless a size is named: the paper names none.
const FRAME_SIZE: [u32; 2] = [512, 384];
/// Setting by which whoever renders keeps pictures.
const PICTURES: &str = "pictures";

/// Hash of what the CPU says: every process the same.
const COMPUTED: &str = "computed";
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
                let own = job.size(size, frame_size).into_iter();
                let own = own.map(|size| (SIZE_PX.into(), size_name(size)));
                case.id.conditions.extend(own);
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
                    frame_size,
                    loses_nothing,
                    brought: brought.clone(),
                },
                open: |group, context| {
                    Ok(Box::new(JudgedOnce::new(Answering {
                        question: &group.work,
                        cases: &group.cases,
                        context,
                        scenes: Vec::new(),
                        eyes: None,
                        meshes: Vec::new(),
                        opened: BTreeMap::new(),
                        edges: None,
                        map: None,
                        lamp: None,
                    })))
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
    /// Of each channel in which the CPU answers, pixels.
    size: [u32; 2],
    /// Of each channel that a device draws, pixels.
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
    /// By case: what a device drew, channel by channel.
    opened: BTreeMap<usize, Vec<Box<dyn Draws>>>,
    /// Of a scene by name, for silhouettes that are found each frame.
    edges: Option<(String, EdgeTable)>,
    /// The last one, of a sun and a size of texels: it may fill half of a device.
    map: Option<([f64; 2], f64, DeviceMap)>,
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

    /// What stands over the sea, seen from there.
    ///
    /// - `feet_m`: as of [`End::feet_m`]
    fn seen_from(
        &mut self,
        eyes: Eyes,
        sun: [f64; 2],
        feet_m: Option<f64>,
        size: [u32; 2],
    ) -> Result<&Scene, String> {
        let brought = &self.question.brought;
        self.scene(
            &format!("{} {sun:?} {feet_m:?} {size:?}", eyes.name()),
            || {
                let views = match (eyes, brought) {
                    (Eyes::At(place), _) => vec![place.view(size)],
                    (Eyes::Bridge, None) => bridge(size),
                    (Eyes::Bridge, Some(own)) => own.views(size),
                };
                let Some(own) = brought else {
                    return Scene::standing(&closed(port_m()?)?, sun, views, feet_m);
                };
                let of = |feet_m| Scene::standing(&own.prepared, sun, views.clone(), feet_m);
                // A user's model that has no simple cut stands as it is: it casts the same.
                of(feet_m).or_else(|_| of(None))
            },
        )
    }

    /// As volumes of that end have it, where the CPU answers.
    fn of_end(&mut self, sun: [f64; 2], end: End) -> Result<&Scene, String> {
        self.seen_from(Eyes::Bridge, sun, end.feet_m(), self.question.size)
    }

    /// Cut below the sea, as a device draws it.
    fn frame(&mut self, sun: [f64; 2]) -> Result<&Scene, String> {
        self.seen_from(
            Eyes::Bridge,
            sun,
            End::Sea.feet_m(),
            self.question.frame_size,
        )
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

/// What a case shows, before anybody judges it.
enum Shown {
    /// By the CPU, which says the same in every process: all of it is judging.
    Computed,
    /// By a device, over all channels.
    Device(DeviceDrawn),
    /// By a device, in one channel under a lamp.
    Lamp(Box<LampDrawn>),
    /// A shadow map of a device.
    Map,
}

impl Shows for Answering<'_> {
    type Shown = Shown;

    fn show(&mut self, case: usize) -> Result<(String, Shown), Failure> {
        let job = self.question.jobs[case];
        Ok(match job {
            Job::DeviceMap(sun, texel_m, bias) => (self.show_map(sun, texel_m, bias)?, Shown::Map),
            Job::DeviceLamp(..) => {
                let drawn = self.show_lamp(case, job)?;
                (mask_hash_of(&drawn.mask), Shown::Lamp(Box::new(drawn)))
            }
            Job::Harbour(..) | Job::DeviceMoon(..) => {
                let drawn = self.show_frame(case, job)?;
                (drawn.hash(), Shown::Device(drawn))
            }
            job if job.is_drawn() => {
                let drawn = self.show_device(case, job)?;
                (drawn.hash(), Shown::Device(drawn))
            }
            _ => (COMPUTED.to_owned(), Shown::Computed),
        })
    }

    fn judge(&mut self, case: usize, shown: Shown) -> Result<Verdict, Failure> {
        let job = self.question.jobs[case];
        match (job, &shown) {
            (Job::DeviceMap(sun, texel_m, bias), _) => self.judge_map(sun, texel_m, bias),
            (_, Shown::Lamp(drawn)) => self.judge_lamp(case, job, drawn),
            (Job::Harbour(..) | Job::DeviceMoon(..), Shown::Device(drawn)) => {
                self.judge_frame(case, job, drawn)
            }
            (_, Shown::Device(drawn)) => self.judge_device(case, job, drawn),
            (Job::Lamp(name, rule, limit), _) => self.lamp_counted(name, rule, limit),
            (Job::Moon(rule), _) => self.answer(Job::Updates(MOON, End::Sea, rule)),
            (job, Shown::Computed | Shown::Map) => self.answer(job),
        }
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        match self.question.jobs[case] {
            Job::Silhouette(name, method) => {
                let mesh = self.ready(name)?;
                watched(TIME.name, || Ok(mesh.sides(method)))
            }
            Job::DeviceMap(sun, texel_m, _) => {
                let times = self.map(sun, texel_m)?.time()?;
                let mut values = filled(&times);
                values.extend(times.stencil_gpu_ms.map(|ms| ("shadow_map_gpu_ms", ms)));
                Ok(values)
            }
            // The bias costs nothing: one comparison takes it in.
            Job::Map(sun, texel_m, _) => {
                let scene = self.of_end(sun, End::Sea)?;
                let mut kept = None;
                watched(SHADOW_MAP_CPU_MS.name, || {
                    let map = Map::of(scene.mesh(), scene.to_light, texel_m)?;
                    Ok(scene.asked(kept.insert(map)))
                })
            }
            Job::Harbour(..) | Job::DeviceMoon(..) => self.frame_times(case),
            job => {
                let found_ms = self.volumes_ms(job)?;
                let planned = self.planned(case, job)?;
                let times = times_of(verified(&mut self.opened, case)?)?;
                let mut values = filled(&times);
                if matches!(job, Job::Device(..)) {
                    let [cpu_ms, wall_ms] = planned.unwrap_or_default();
                    values.push((WHOLE_CPU.name, cpu_ms + times.fill_cpu_ms));
                    values.push((WHOLE_WALL.name, wall_ms + times.fill_wall_ms));
                }
                values.extend(planned.map(|[cpu_ms, _]| (SHADOW_PLANNED_CPU_MS.name, cpu_ms)));
                values.extend(found_ms.map(|ms| ("shadow_volumes_cpu_ms", ms)));
                Ok(values)
            }
        }
    }
}

#[cfg(test)]
mod tests;
