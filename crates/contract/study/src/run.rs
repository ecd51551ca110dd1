// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one runner: groups, verification before timing, shuffled blocks, resume, shards, A/A twins.
//!
//! Each value is appended to the run's folder as soon as it is measured, so that killing a run loses
//! one sample. A run of several processes is the same folder measured by one process after another:
//! the first verifies every case, the others make sure that they do the same work and time it again.

mod running;

use crate::steady::{Settling, TimeMetric, times};
use crate::{Context, Group, Planned, Request, Share, Study, StudyError, Turns};
use running::Running;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::{
    Outcome, PlannedCase, Run, RunError, RunFolder, RunPlan, Shard, SplitMix64, Status,
    repeated_cases,
};

/// Timed cases of a group that are measured twice: two pairs tell a group's noise from one freak, and
/// cost little beside the group.
const TWINS_PER_GROUP: usize = 2;

/// Groups of fewer timed cases compare nothing with anything, so identical work tells nothing there.
const MIN_CASES_FOR_TWINS: usize = 3;

/// How a plan is measured.
#[derive(Debug, Clone, Copy)]
pub struct RunOptions {
    /// Processes of the run: each is a replicate.
    pub processes: u32,
    /// Which of them this is, from 0. The first verifies.
    pub process: u32,
    /// Blocks measured and dropped at the start.
    pub warm_up: u32,
    /// Seed of the blocks' order and of the choice of twins.
    pub seed: u64,
    /// Part of the groups to measure; `None`: all.
    pub shard: Option<Shard>,
}

/// Frames behind one timed sample: a gate averages several, and its self-test adds known work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FramesPerSample {
    /// Frames that a sample is the mean of.
    pub frames: u32,
    /// Frames drawn beside these, whose cost is added to the sum: real work of a known share.
    pub extra: u32,
}

impl Default for FramesPerSample {
    fn default() -> Self {
        Self {
            frames: 1,
            extra: 0,
        }
    }
}

/// Receives progress. The runner has no clock: who listens decides how often to say so.
pub trait Progress {
    /// - `done`, `all`: steps of this process: verified cases and measured blocks
    fn step(&mut self, done: usize, all: usize, what: &str);

    /// What was left to measure of a group is measured.
    ///
    /// - `first`: key of the group's first case
    fn measured(&mut self, _first: &str) {}
}

/// Says nothing.
#[derive(Debug, Default, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn step(&mut self, _done: usize, _all: usize, _what: &str) {}
}

/// How cases ended, A/A twins not counted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RunOutcome {
    /// Right.
    pub ok: usize,
    /// Wrong.
    pub wrong: usize,
    /// Wrong where the error is the question.
    pub wrong_on_purpose: usize,
    /// Broken off.
    pub failed: usize,
    /// Wrong in exactly the pixels that a listed fault of the driver loses.
    pub driver_fault: usize,
    /// Not run on this machine.
    pub skipped: usize,
    /// Planned and not measured.
    pub missing: usize,
}

impl RunOutcome {
    /// Of a run's folder as it is now.
    ///
    /// # Errors
    /// As [`Run::load`].
    pub fn of(folder: &Path) -> Result<Self, RunError> {
        let run = Run::load(folder)?;
        let mut outcome = Self::default();
        for case in run.cases.iter().filter(|case| !case.is_twin()) {
            *match case.outcome {
                Outcome::Ok => &mut outcome.ok,
                Outcome::Wrong if case.planned.may_be_wrong => &mut outcome.wrong_on_purpose,
                Outcome::Wrong => &mut outcome.wrong,
                Outcome::Failed => &mut outcome.failed,
                Outcome::DriverFault => &mut outcome.driver_fault,
                Outcome::Skipped => &mut outcome.skipped,
                Outcome::Missing => &mut outcome.missing,
            } += 1;
        }
        Ok(outcome)
    }
}

/// A group with its cases and their twins.
struct PlannedGroup {
    group: Box<dyn Group>,
    name: String,
    /// The group's cases, then twins.
    cases: Vec<PlannedCase>,
    /// Of each of `cases`: its place in the group.
    work: Vec<usize>,
    /// By what its samples say whether clocks have settled.
    times: Rc<[TimeMetric]>,
}

/// Everything that a run is to measure, and in which groups.
pub struct Plan {
    groups: Vec<PlannedGroup>,
    plan: RunPlan,
    frames: FramesPerSample,
    settling: Settling,
    /// Keys of the cases that this process times; `None`: all.
    only: Option<BTreeSet<String>>,
}

impl Plan {
    /// As written to `plan.json`.
    #[must_use]
    pub fn run_plan(&self) -> &RunPlan {
        &self.plan
    }

    /// The same plan with so many frames behind each sample.
    #[must_use]
    pub fn with_frames(mut self, frames: FramesPerSample) -> Self {
        self.frames = frames;
        self
    }

    /// The same plan, in which a process times nothing before clocks have settled.
    #[must_use]
    pub fn with_settling(mut self, settling: Settling) -> Self {
        self.settling = settling;
        self
    }

    /// The same plan, of which this process times these cases alone.
    ///
    /// # Errors
    /// [`StudyError::BadInput`] for a key that is not planned.
    pub fn timing_only(mut self, keys: BTreeSet<String>) -> Result<Self, StudyError> {
        if let Some(unknown) = keys.iter().find(|key| self.plan.case(key).is_none()) {
            return Err(StudyError::BadInput(format!(
                "case {unknown:?}: not one of the {} planned",
                self.plan.cases.len()
            )));
        }
        self.only = Some(keys);
        Ok(self)
    }
}

/// Plans the requested studies.
///
/// # Errors
/// [`StudyError::BadInput`] from a study, or for a case that is planned twice.
pub fn plan(
    studies: &[&dyn Study],
    request: &Request,
    options: &RunOptions,
) -> Result<Plan, StudyError> {
    plan_shared(studies, request, options, &Share::Turns)
}

/// Plans the requested studies, of which a shard gets its share.
///
/// # Errors
/// As [`plan`].
pub fn plan_shared(
    studies: &[&dyn Study],
    request: &Request,
    options: &RunOptions,
    share: &Share,
) -> Result<Plan, StudyError> {
    let mut groups = Vec::new();
    let mut skipped = Vec::new();
    for study in studies {
        let planned: Planned = study.plan(request)?;
        refuse_undeclared(*study, &planned)?;
        for left_out in planned.skipped {
            if !skipped.contains(&left_out) {
                skipped.push(left_out);
            }
        }
        let primary = |clock| study.chapter().primary_metric(clock);
        let times: Rc<[TimeMetric]> = times(study.metrics(), primary).into();
        let planned = planned.groups.into_iter();
        groups.extend(planned.map(|group| (group, Rc::clone(&times))));
    }
    if let Some(Shard { index, count }) = options.shard {
        let names = groups.iter().map(|(group, _)| first_case(group.cases()));
        let names: Vec<String> = names.collect();
        let mut shards = share.shards(&names, count).into_iter();
        groups.retain(|_| shards.next() == Some(index));
    }
    let groups: Vec<PlannedGroup> = groups
        .into_iter()
        .map(|(group, times)| with_twins(group, times, options.seed))
        .collect();
    let plan = RunPlan {
        cases: groups
            .iter()
            .flat_map(|group| group.cases.clone())
            .collect(),
        skipped,
        processes: options.processes,
        warm_up: options.warm_up,
        seed: options.seed,
        shard: options.shard,
    };
    match repeated_cases(&plan).as_slice() {
        [] => Ok(Plan {
            groups,
            plan,
            frames: FramesPerSample::default(),
            settling: Settling::default(),
            only: None,
        }),
        [twice, ..] => Err(StudyError::BadInput(format!(
            "case {twice:?} is planned twice, allowed: once"
        ))),
    }
}

/// A condition that its study did not declare is a mistake of the program: nobody could read it.
fn refuse_undeclared(study: &dyn Study, planned: &Planned) -> Result<(), StudyError> {
    let declared: BTreeSet<&str> = study.conditions().iter().map(|key| key.name()).collect();
    let cases = planned.groups.iter().flat_map(|group| group.cases());
    let mut all = cases.flat_map(|case| case.id.conditions.keys().map(move |key| (case, key)));
    match all.find(|(_, key)| !declared.contains(key.as_str())) {
        None => Ok(()),
        Some((case, key)) => Err(StudyError::Broken {
            place: case.id.key(),
            message: format!(
                "study {} plans the condition {key:?} and does not declare it, allowed: {}",
                study.name(),
                declared.into_iter().collect::<Vec<_>>().join(", ")
            ),
        }),
    }
}

/// What a group is known by from run to run.
fn first_case(cases: &[PlannedCase]) -> String {
    cases.first().map_or_else(String::new, |case| case.id.key())
}

fn with_twins(group: Box<dyn Group>, times: Rc<[TimeMetric]>, seed: u64) -> PlannedGroup {
    let mut cases = group.cases().to_vec();
    let mut work: Vec<usize> = (0..cases.len()).collect();
    let timed: Vec<usize> = work
        .iter()
        .copied()
        .filter(|&index| cases[index].samples > 0 && !cases[index].may_be_wrong)
        .collect();
    if timed.len() >= MIN_CASES_FOR_TWINS {
        let order = SplitMix64::new(seed ^ timed.len() as u64).shuffled(timed.len());
        for place in order.into_iter().take(TWINS_PER_GROUP) {
            let original = &cases[timed[place]];
            let twin = PlannedCase {
                id: original.id.twin(),
                ..original.clone()
            };
            work.push(timed[place]);
            cases.push(twin);
        }
    }
    PlannedGroup {
        name: group.name(),
        group,
        cases,
        work,
        times,
    }
}

/// Measures in this process what the folder does not have yet.
///
/// # Errors
/// [`StudyError`] when a group cannot be measured or the folder cannot be written. What was measured
/// before stays.
pub fn run(
    plan: &Plan,
    folder: &RunFolder,
    devices: &Rc<Devices>,
    options: &RunOptions,
    progress: &mut dyn Progress,
) -> Result<(), StudyError> {
    run_groups(plan, folder, devices, options, progress, None)
}

/// As [`run`], with each sample released by `turns`, as many as it likes.
///
/// # Errors
/// As [`run`]; [`StudyError::BadInput`] where `turns` ends early.
pub fn run_by_turns(
    plan: &Plan,
    folder: &RunFolder,
    devices: &Rc<Devices>,
    options: &RunOptions,
    progress: &mut dyn Progress,
    turns: &mut dyn Turns,
) -> Result<(), StudyError> {
    run_groups(plan, folder, devices, options, progress, Some(turns))
}

fn run_groups(
    plan: &Plan,
    folder: &RunFolder,
    devices: &Rc<Devices>,
    options: &RunOptions,
    progress: &mut dyn Progress,
    mut turns: Option<&mut dyn Turns>,
) -> Result<(), StudyError> {
    let measured = Run::load(folder.path())?;
    let known: BTreeMap<String, Known> = measured
        .cases
        .iter()
        .map(|case| (case.id().key(), Known::of(case, options.process)))
        .collect();
    let mut steps = Steps::new(plan, options, progress);
    let mut settling = plan.settling;
    for group in &plan.groups {
        let mut todo = Todo::new(group, &known, options);
        if let Some(only) = &plan.only {
            todo.time
                .retain(|(case, _)| only.contains(&group.cases[*case].id.key()));
        }
        if todo.is_empty() {
            steps.skip(group);
            continue;
        }
        steps.say(&group.name);
        let context = Context {
            devices,
            folder: folder.path(),
        };
        let mut session = group.group.open(context)?;
        let mut running = Running {
            group,
            folder,
            options,
            frames: plan.frames,
            known: &known,
            devices,
            session: &mut *session,
        };
        let ready = running.verify(&todo, &mut steps)?;
        match turns.as_deref_mut() {
            Some(turns) => running.measure_by_turns(ready, turns)?,
            None => {
                if !ready.is_empty() && settling.max_looks > 0 {
                    running.settle(&ready, settling.max_looks)?;
                    settling.max_looks *= u32::from(settling.each_group);
                }
                running.measure(&todo, ready, &mut steps)?;
            }
        }
        steps.measured(group);
    }
    Ok(())
}

/// What the folder has of a case.
struct Known {
    status: Option<Status>,
    notes: BTreeMap<String, String>,
    /// Samples taken by this process.
    samples: BTreeSet<u32>,
}

impl Known {
    fn of(case: &terrafill_results::Case, process: u32) -> Self {
        Self {
            status: case.status(),
            notes: case.notes().clone(),
            samples: case.timed_samples(process),
        }
    }
}

/// What is left to do of a group in this process.
struct Todo {
    /// Cases to be verified.
    verify: Vec<usize>,
    /// Cases to be timed, with the first sample that is missing.
    time: Vec<(usize, u32)>,
}

impl Todo {
    fn new(group: &PlannedGroup, known: &BTreeMap<String, Known>, options: &RunOptions) -> Self {
        let mut todo = Self {
            verify: Vec::new(),
            time: Vec::new(),
        };
        for (index, case) in group.cases.iter().enumerate() {
            let known = known.get(&case.id.key());
            let status = known.and_then(|known| known.status);
            if status.is_none() && options.process == 0 {
                todo.verify.push(index);
            }
            let may_be_timed = match status {
                None => options.process == 0,
                Some(Status::Ok) => true,
                Some(Status::Wrong) => case.may_be_wrong,
                Some(Status::Skipped | Status::Failed | Status::DriverFault) => false,
            };
            let taken = known.map_or(0, |known| known.samples.len());
            let taken = u32::try_from(taken).unwrap_or(u32::MAX);
            if may_be_timed && taken < case.samples {
                todo.time.push((index, taken));
            }
        }
        todo
    }

    fn is_empty(&self) -> bool {
        self.verify.is_empty() && self.time.is_empty()
    }
}

/// Counts steps for whoever listens.
struct Steps<'a> {
    done: usize,
    all: usize,
    progress: &'a mut dyn Progress,
}

impl<'a> Steps<'a> {
    fn new(plan: &Plan, options: &RunOptions, progress: &'a mut dyn Progress) -> Self {
        let all = plan
            .groups
            .iter()
            .map(|group| steps_of(group, options))
            .sum();
        Self {
            done: 0,
            all,
            progress,
        }
    }

    fn say(&mut self, what: &str) {
        self.progress.step(self.done, self.all, what);
    }

    fn step(&mut self, what: &str) {
        self.done = (self.done + 1).min(self.all);
        self.say(what);
    }

    fn measured(&mut self, group: &PlannedGroup) {
        self.progress.measured(&first_case(&group.cases));
    }

    fn skip(&mut self, group: &PlannedGroup) {
        self.done = (self.done + group.cases.len()).min(self.all);
        self.say(&group.name);
    }
}

/// Verified cases and measured blocks.
fn steps_of(group: &PlannedGroup, options: &RunOptions) -> usize {
    let blocks = group
        .cases
        .iter()
        .map(|case| case.samples)
        .max()
        .unwrap_or(0);
    let warm_up = if blocks > 0 {
        warm_up(group, options)
    } else {
        0
    };
    group.cases.len() + (blocks + warm_up) as usize
}

fn warm_up(group: &PlannedGroup, options: &RunOptions) -> u32 {
    group.group.warm_up().unwrap_or(options.warm_up)
}
