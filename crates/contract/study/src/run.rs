// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one runner: verification before timing, shuffled blocks, resume.
//!
//! Each value is appended to the run's folder as soon as it is measured, so that killing a run loses
//! one sample. A run of several processes is the same folder measured by one process after another:
//! the first verifies every case, the others make sure that they do the same work and time it again.

use crate::plan::{FramesPerSample, Plan, PlannedGroup, RunOptions, first_case};
use crate::schedule::block_order;
use crate::steady::{Settled, settle};
use crate::{Context, Failure, Figures, Session, StudyError, Turn, Turns};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::{
    Measurement, Note, Outcome, PlannedCase, Run, RunError, RunFolder, Status, UNSTEADY_CLOCK,
    Verdict, median,
};

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

/// How cases ended, repeats not counted.
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
        for case in run.cases.iter().filter(|case| !case.is_repeat()) {
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
        if let Some(turns) = turns.as_deref_mut() {
            running.measure_by_turns(ready, turns)?;
        } else {
            if !ready.is_empty() && settling.max_looks > 0 {
                running.settle(&ready, settling.max_looks)?;
                settling.max_looks *= u32::from(settling.each_group);
            }
            running.measure(ready, &mut steps)?;
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
            let may_be_timed =
                status.map_or(options.process == 0, |status| may_be_timed(case, status));
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

fn may_be_timed(case: &PlannedCase, status: Status) -> bool {
    match status {
        Status::Ok => true,
        Status::Wrong => case.may_be_wrong,
        Status::Skipped | Status::Failed | Status::DriverFault => false,
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

/// The median of each metric that all measurements of a sample have.
fn medians(taken: &[Figures]) -> Figures {
    let metrics = taken.first().into_iter().flatten();
    let of = |name: &str| -> Option<f64> {
        let value = |values: &Vec<(&str, f64)>| {
            let found = values.iter().find(|(metric, _)| *metric == name);
            found.map(|(_, value)| *value)
        };
        let values: Option<Vec<f64>> = taken.iter().map(value).collect();
        match values?.as_slice() {
            // One alone stays what it is, even where it is no number.
            [only] => Some(*only),
            many => median(many),
        }
    };
    metrics
        .filter_map(|&(name, _)| Some((name, of(name)?)))
        .collect()
}

/// A case that can be timed.
#[derive(Clone, Copy)]
struct Ready {
    case: usize,
    next_sample: u32,
}

struct Running<'a> {
    group: &'a PlannedGroup,
    folder: &'a RunFolder,
    options: &'a RunOptions,
    frames: FramesPerSample,
    known: &'a BTreeMap<String, Known>,
    devices: &'a Devices,
    session: &'a mut dyn Session,
}

impl Running<'_> {
    fn key(&self, case: usize) -> String {
        self.group.cases[case].id.key()
    }

    /// Verifies what is not verified yet and makes ready what is to be timed; repeats stand for the
    /// case whose work they repeat.
    fn verify(&mut self, todo: &Todo, steps: &mut Steps<'_>) -> Result<Vec<Ready>, StudyError> {
        let mut verdicts: BTreeMap<usize, Verdict> = BTreeMap::new();
        let mut ready = Vec::new();
        for case in 0..self.group.cases.len() {
            let is_new = todo.verify.contains(&case);
            let timed = todo.time.iter().find(|(index, _)| *index == case);
            if !is_new && timed.is_none() {
                steps.step(&self.group.name);
                continue;
            }
            let work = self.group.work[case];
            steps.step(&self.key(case));
            let verdict = match verdicts.get(&work) {
                Some(verdict) => verdict.clone(),
                None => self.verdict(work, is_new)?,
            };
            verdicts.insert(work, verdict.clone());
            if is_new {
                self.record(case, work == case, &verdict)?;
            } else if let Some(message) = self.contradiction(case, &verdict) {
                self.fail(case, &message)?;
                continue;
            }
            let may_be_timed = may_be_timed(&self.group.cases[case], verdict.status);
            if let Some(&(_, next_sample)) = timed.filter(|_| may_be_timed) {
                ready.push(Ready { case, next_sample });
            }
        }
        Ok(ready)
    }

    fn verdict(&mut self, work: usize, is_new: bool) -> Result<Verdict, StudyError> {
        let known = self.known.get(&self.key(work)).filter(|_| !is_new);
        let earlier = known.and_then(|known| Some((known.status?, &known.notes)));
        let verdict = match earlier {
            Some((status, notes)) => self.session.recheck(work, status, notes),
            None => self.session.verify(work),
        };
        verdict.or_else(Failure::verdict)
    }

    /// Why a case does not do what it did when it was verified.
    fn contradiction(&self, case: usize, verdict: &Verdict) -> Option<String> {
        let known = self.known.get(&self.key(case))?;
        let then = known.status?;
        (then != verdict.status).then(|| {
            let (then, now) = (then.name(), verdict.status.name());
            let process = self.options.process;
            let reason = &verdict.reason;
            format!("{then} when it was verified, {now} in process {process}: {reason}")
        })
    }

    /// Refuses to write anything of a case when a device is gone: what it drew or failed to draw says nothing
    /// of the technique, and the cases to come would all fail. They stay missing, so that the run can go on.
    fn check_device(&self, case: usize) -> Result<(), StudyError> {
        match self.devices.loss().message() {
            None => Ok(()),
            Some(message) => Err(StudyError::Broken {
                place: self.key(case),
                message: format!("the device was lost: {message}"),
            }),
        }
    }

    fn record(&self, case: usize, is_own: bool, verdict: &Verdict) -> Result<(), StudyError> {
        self.check_device(case)?;
        let planned = &self.group.cases[case];
        let key = planned.id.key();
        // Figures first: a case with a row has all of them. A repeat's are those of its original.
        if is_own {
            self.keep(case, 0, &verdict.figures)?;
            let notes: Vec<Note> = verdict
                .notes
                .iter()
                .filter(|(_, text)| !text.is_empty())
                .map(|(note, text)| Note {
                    case: key.clone(),
                    note: (*note).to_owned(),
                    text: text.clone(),
                })
                .collect();
            self.folder.append_notes(&notes)?;
            self.folder.append_features(&key, &verdict.features)?;
        }
        Ok(self
            .folder
            .append_case(planned, verdict.status, &verdict.reason)?)
    }

    fn fail(&self, case: usize, message: &str) -> Result<(), StudyError> {
        self.check_device(case)?;
        Ok(self.folder.fail_case(&self.group.cases[case], message)?)
    }

    /// One sample of a case: the mean over its frames.
    fn sample(
        &mut self,
        case: usize,
        FramesPerSample { frames, extra }: FramesPerSample,
    ) -> Result<Figures, Failure> {
        let work = self.group.work[case];
        let mut sum = self.session.time(work)?;
        for _ in 1..frames + extra {
            let values = self.session.time(work)?;
            // A value that one frame lacks has no mean.
            sum.retain(|(metric, _)| values.iter().any(|(other, _)| other == metric));
            for (metric, total) in &mut sum {
                let found = values.iter().find(|(other, _)| other == metric);
                *total += found.map_or(0.0, |(_, value)| *value);
            }
        }
        let frames = f64::from(frames.max(1));
        Ok(sum
            .into_iter()
            .map(|(metric, total)| (metric, total / frames))
            .collect())
    }

    /// Takes one sample of a case and keeps it if it counts; false where the case broke off.
    ///
    /// - `of`: how many measurements it is the median of
    fn take(&mut self, ready: &mut Ready, of: u32, counts: bool) -> Result<bool, StudyError> {
        let case = ready.case;
        let (frames, drawn) = if counts {
            let drawn = self.session.before_sample(self.group.work[case]);
            (self.frames, drawn)
        } else {
            (FramesPerSample::default(), Ok(()))
        };
        let sampled = |()| (0..of).map(|_| self.sample(case, frames)).collect();
        let taken: Result<Vec<_>, Failure> = drawn.and_then(sampled);
        let taken = match taken {
            Ok(taken) => taken,
            Err(failure) => {
                self.fail(case, &failure.reason())?;
                return Ok(false);
            }
        };
        if counts {
            self.check_device(case)?;
            ready.next_sample += 1;
            self.keep(case, ready.next_sample, &medians(&taken))?;
        }
        Ok(true)
    }

    /// Appends figures of a case to the run's folder.
    fn keep(&self, case: usize, sample: u32, figures: &[(&str, f64)]) -> Result<(), RunError> {
        let row = |&(metric, value): &(&str, f64)| Measurement {
            case: self.key(case),
            metric: metric.to_owned(),
            process: self.options.process,
            sample,
            value,
        };
        let rows: Vec<Measurement> = figures.iter().map(row).collect();
        self.folder.append_measurements(&rows)
    }

    /// Draws the first case until its times agree, and notes where they never do.
    fn settle(&mut self, ready: &[Ready], max_looks: u32) -> Result<(), StudyError> {
        let Some(case) = ready.first().map(|ready| ready.case) else {
            return Ok(());
        };
        let work = self.group.work[case];
        self.session.begin_block()?;
        let sample = || self.session.time(work).map_err(Failure::reason);
        // What breaks here breaks again where it is measured, and is that case's verdict there.
        let Ok(Settled::Unsteady(off)) = settle(max_looks, &self.group.times, sample) else {
            return Ok(());
        };
        let process = self.options.process;
        let note = Note {
            case: self.key(case),
            note: format!("{UNSTEADY_CLOCK}{process}"),
            text: format!(
                "process {process} timed {} before its clock was steady: the last of {max_looks} looks differed by {:.0} %",
                self.group.name,
                (off - 1.0) * 100.0
            ),
        };
        Ok(self.folder.append_notes(&[note])?)
    }

    /// Measures what `turns` asks for, until it asks for the next group.
    fn measure_by_turns(
        &mut self,
        mut ready: Vec<Ready>,
        turns: &mut dyn Turns,
    ) -> Result<(), StudyError> {
        let keys: Vec<String> = ready.iter().map(|ready| self.key(ready.case)).collect();
        turns.ready(&keys).map_err(StudyError::BadInput)?;
        loop {
            let is_well = match turns.next().map_err(StudyError::BadInput)? {
                Turn::NextGroup => return Ok(()),
                Turn::Block => {
                    self.session.begin_block()?;
                    true
                }
                Turn::Sample { place, of, counts } => {
                    let Some(ready) = ready.get_mut(place) else {
                        let message =
                            format!("turn of case {place}, allowed: below {}", keys.len());
                        return Err(StudyError::BadInput(message));
                    };
                    self.take(ready, of, counts)?
                }
            };
            turns.over(is_well).map_err(StudyError::BadInput)?;
        }
    }

    /// Measures every case once in each block, in an order that changes from block to block.
    fn measure(&mut self, mut ready: Vec<Ready>, steps: &mut Steps<'_>) -> Result<(), StudyError> {
        let left = |ready: &[Ready], group: &PlannedGroup| {
            let left = ready.iter().map(|case| {
                group.cases[case.case]
                    .samples
                    .saturating_sub(case.next_sample)
            });
            left.max().unwrap_or(0)
        };
        let mut block = 0;
        while left(&ready, self.group) > 0 {
            let is_warm_up = block < warm_up(self.group, self.options);
            self.session.begin_block()?;
            let order = block_order(
                self.options.seed,
                &self.group.name,
                self.options.process,
                block,
                ready.len(),
            );
            let mut broken = BTreeSet::new();
            for place in order {
                let Ready { case, next_sample } = ready[place];
                let is_left = next_sample < self.group.cases[case].samples;
                if is_left && !self.take(&mut ready[place], 1, !is_warm_up)? {
                    broken.insert(case);
                }
            }
            ready.retain(|ready| !broken.contains(&ready.case));
            block += 1;
            steps.step(&self.group.name);
        }
        Ok(())
    }
}
