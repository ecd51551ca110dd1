// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run is to measure: the cases of its studies by groups, some of them twice, and its share of them.

use crate::steady::{Settling, TimeMetric, times};
use crate::{Group, Planned, Request, Share, Study, StudyError};
use std::collections::BTreeSet;
use std::rc::Rc;
use terrafill_results::{PlannedCase, RunInput, RunPlan, Shard, SplitMix64, repeated_cases};

/// Timed cases of a group that are measured twice: two pairs tell a group's noise from one freak, and
/// cost little beside the group.
const REPEATS_PER_GROUP: usize = 2;

/// Groups of fewer timed cases compare nothing with anything, so identical work tells nothing there.
const MIN_CASES_FOR_REPEATS: usize = 3;

/// How a plan is measured.
#[derive(Debug, Clone, Copy)]
pub struct RunOptions {
    /// Processes of the run: each is a replicate.
    pub processes: u32,
    /// Which of them this is, from 0. The first verifies.
    pub process: u32,
    /// Blocks measured and dropped at the start.
    pub warm_up: u32,
    /// Seed of the blocks' order and of the choice of what is repeated.
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

/// A group with its cases and their repeats.
pub(crate) struct PlannedGroup {
    pub(crate) group: Box<dyn Group>,
    pub(crate) name: String,
    /// The group's cases, then repeats.
    pub(crate) cases: Vec<PlannedCase>,
    /// Of each of `cases`: its place in the group.
    pub(crate) work: Vec<usize>,
    /// By what its samples say whether clocks have settled.
    pub(crate) times: Rc<[TimeMetric]>,
}

/// Everything that a run is to measure, and in which groups.
pub struct Plan {
    pub(crate) groups: Vec<PlannedGroup>,
    plan: RunPlan,
    inputs: Vec<RunInput>,
    pub(crate) frames: FramesPerSample,
    pub(crate) settling: Settling,
    /// Keys of the cases that this process times; `None`: all.
    pub(crate) only: Option<BTreeSet<String>>,
}

impl Plan {
    /// As written to `plan.json`.
    #[must_use]
    pub fn run_plan(&self) -> &RunPlan {
        &self.plan
    }

    /// Files that planning read, each once for a scene, and what is remarkable about them.
    #[must_use]
    pub fn inputs(&self) -> &[RunInput] {
        &self.inputs
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
    let mut inputs = Vec::new();
    for study in studies {
        let planned: Planned = study.plan(request)?;
        refuse_undeclared(*study, &planned)?;
        for left_out in planned.skipped {
            if !skipped.contains(&left_out) {
                skipped.push(left_out);
            }
        }
        for input in planned.inputs {
            if !inputs.contains(&input) {
                inputs.push(input);
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
        .map(|(group, times)| with_repeats(group, times, options.seed))
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
            inputs,
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
pub(crate) fn first_case(cases: &[PlannedCase]) -> String {
    cases.first().map_or_else(String::new, |case| case.id.key())
}

fn with_repeats(group: Box<dyn Group>, times: Rc<[TimeMetric]>, seed: u64) -> PlannedGroup {
    let mut cases = group.cases().to_vec();
    let mut work: Vec<usize> = (0..cases.len()).collect();
    let timed: Vec<usize> = work
        .iter()
        .copied()
        .filter(|&index| cases[index].samples > 0 && !cases[index].may_be_wrong)
        .collect();
    if timed.len() >= MIN_CASES_FOR_REPEATS {
        let order = SplitMix64::new(seed ^ timed.len() as u64).shuffled(timed.len());
        for place in order.into_iter().take(REPEATS_PER_GROUP) {
            let original = &cases[timed[place]];
            let repeat = PlannedCase {
                id: original.id.repeat(),
                ..original.clone()
            };
            work.push(timed[place]);
            cases.push(repeat);
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
