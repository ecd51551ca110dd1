// SPDX-License-Identifier: MIT OR Apache-2.0
//! One group of a run: verified, brought to a steady pace, and measured.

use super::{FramesPerSample, Known, PlannedGroup, RunOptions, Steps, Todo, warm_up};
use crate::schedule::block_order;
use crate::steady::{Settled, settle};
use crate::{Session, StudyError, Turn, Turns};
use std::collections::{BTreeMap, BTreeSet};
use terrafill_contract::Devices;
use terrafill_results::{Measurement, Note, RunFolder, Status, UNSTEADY_CLOCK, Verdict, median};

/// The median of each metric that all measurements of a sample have.
fn medians(taken: &[Vec<(&'static str, f64)>]) -> Vec<(&'static str, f64)> {
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
pub(super) struct Ready {
    case: usize,
    next_sample: u32,
}

pub(super) struct Running<'a> {
    pub(super) group: &'a PlannedGroup,
    pub(super) folder: &'a RunFolder,
    pub(super) options: &'a RunOptions,
    pub(super) frames: FramesPerSample,
    pub(super) known: &'a BTreeMap<String, Known>,
    pub(super) devices: &'a Devices,
    pub(super) session: &'a mut dyn Session,
}

impl Running<'_> {
    fn key(&self, case: usize) -> String {
        self.group.cases[case].id.key()
    }

    /// Verifies what is not verified yet and makes ready what is to be timed; twins stand for the
    /// case whose work they repeat.
    pub(super) fn verify(
        &mut self,
        todo: &Todo,
        steps: &mut Steps<'_>,
    ) -> Result<Vec<Ready>, StudyError> {
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
            let may_be_timed = match verdict.status {
                Status::Ok => true,
                Status::Wrong => self.group.cases[case].may_be_wrong,
                Status::Skipped | Status::Failed | Status::DriverFault => false,
            };
            if let Some(&(_, next_sample)) = timed.filter(|_| may_be_timed) {
                ready.push(Ready { case, next_sample });
            }
        }
        Ok(ready)
    }

    fn verdict(&mut self, work: usize, is_new: bool) -> Result<Verdict, StudyError> {
        let known = self.known.get(&self.key(work)).filter(|_| !is_new);
        let earlier = known.and_then(|known| Some((known.status?, &known.notes)));
        match earlier {
            Some((status, notes)) => self.session.recheck(work, status, notes),
            None => self.session.verify(work),
        }
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
        // Figures first: a case with a row has all of them. A twin's are those of its original.
        if is_own {
            let figures: Vec<Measurement> = verdict
                .figures
                .iter()
                .map(|&(metric, value)| self.measurement(&key, metric, 0, value))
                .collect();
            self.folder.append_measurements(&figures)?;
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
        }
        Ok(self
            .folder
            .append_case(planned, verdict.status, &verdict.reason)?)
    }

    fn fail(&self, case: usize, message: &str) -> Result<(), StudyError> {
        self.check_device(case)?;
        Ok(self.folder.fail_case(&self.group.cases[case], message)?)
    }

    fn measurement(&self, key: &str, metric: &str, sample: u32, value: f64) -> Measurement {
        Measurement {
            case: key.to_owned(),
            metric: metric.to_owned(),
            process: self.options.process,
            sample,
            value,
        }
    }

    /// One sample of a case: the mean over its frames.
    fn sample(
        &mut self,
        case: usize,
        FramesPerSample { frames, extra }: FramesPerSample,
    ) -> Result<Vec<(&'static str, f64)>, String> {
        let work = self.group.work[case];
        let mut sum = self.session.sample(work)?;
        for _ in 1..frames + extra {
            let values = self.session.sample(work)?;
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
        let frames = if counts {
            self.frames
        } else {
            FramesPerSample::default()
        };
        let drawn = match counts {
            true => self.session.before_sample(self.group.work[case]),
            false => Ok(()),
        };
        let sampled = |()| (0..of).map(|_| self.sample(case, frames)).collect();
        let taken: Result<Vec<_>, String> = drawn.and_then(sampled);
        match taken {
            Err(message) => {
                self.fail(case, &message)?;
                return Ok(false);
            }
            Ok(_) if !counts => {}
            Ok(taken) => {
                self.check_device(case)?;
                let values = medians(&taken);
                ready.next_sample += 1;
                let key = self.key(case);
                let rows: Vec<Measurement> = values
                    .into_iter()
                    .map(|(metric, value)| self.measurement(&key, metric, ready.next_sample, value))
                    .collect();
                self.folder.append_measurements(&rows)?;
            }
        }
        Ok(true)
    }

    /// Draws the first case until its times agree, and notes where they never do.
    pub(super) fn settle(&mut self, ready: &[Ready], max_looks: u32) -> Result<(), StudyError> {
        let Some(case) = ready.first().map(|ready| ready.case) else {
            return Ok(());
        };
        let work = self.group.work[case];
        self.session.begin_block()?;
        let sample = || self.session.sample(work);
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
    pub(super) fn measure_by_turns(
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
    pub(super) fn measure(
        &mut self,
        todo: &Todo,
        mut ready: Vec<Ready>,
        steps: &mut Steps<'_>,
    ) -> Result<(), StudyError> {
        let left = |ready: &[Ready], group: &PlannedGroup| {
            let left = ready.iter().map(|case| {
                group.cases[case.case]
                    .samples
                    .saturating_sub(case.next_sample)
            });
            left.max().unwrap_or(0)
        };
        if todo.time.is_empty() || left(&ready, self.group) == 0 {
            return Ok(());
        }
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
                if next_sample >= self.group.cases[case].samples {
                    continue;
                }
                if !self.take(&mut ready[place], 1, !is_warm_up)? {
                    broken.insert(place);
                }
            }
            let mut place = 0;
            ready.retain(|_| {
                place += 1;
                !broken.contains(&(place - 1))
            });
            block += 1;
            steps.step(&self.group.name);
        }
        Ok(())
    }
}
