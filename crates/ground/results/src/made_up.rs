// SPDX-License-Identifier: MIT OR Apache-2.0
//! Made-up runs, for the tests of everything that reads one: figures in, a run folder out.

use crate::{
    CaseFeature, CaseId, Measurement, Metric, Note, PlannedCase, Run, RunEnvironment, RunError,
    RunFolder, RunPlan, Skipped, Status,
};
use std::path::Path;

/// A case's name with its conditions.
#[must_use]
pub fn case_id(study: &str, name: &str, conditions: &[(&str, &str)]) -> CaseId {
    let conditions = conditions
        .iter()
        .map(|(key, value)| (*key, (*value).to_owned()));
    CaseId::new(study, name, conditions)
}

/// A run to be written.
#[derive(Debug, Clone, Default)]
pub struct MadeUpRun {
    /// Where it pretends to be made.
    pub environment: RunEnvironment,
    /// What it pretends to have left out.
    pub skipped: Vec<Skipped>,
    /// Declarations; a figure that none of them names is declared as a plain counter.
    pub metrics: Vec<Metric>,
    /// In the plan's order.
    pub cases: Vec<MadeUpCase>,
}

/// A case of it.
#[derive(Debug, Clone)]
pub struct MadeUpCase {
    /// Which.
    pub id: CaseId,
    /// Timed samples planned in each process.
    pub samples: u32,
    /// Whether a wrong answer is a result.
    pub may_be_wrong: bool,
    /// How it ended and why; `None` for a case that the run never reached.
    pub row: Option<(Status, String)>,
    /// Metric, number of the first sample, then samples of each process.
    pub figures: Vec<(&'static str, u32, Vec<Vec<f64>>)>,
    /// Texts by name.
    pub notes: Vec<(&'static str, String)>,
    /// What it holds and leaves out.
    pub features: Vec<CaseFeature>,
}

impl MadeUpRun {
    /// Adds a case that is right and has no figures yet.
    pub fn case(&mut self, id: CaseId) -> &mut MadeUpCase {
        self.cases.push(MadeUpCase {
            id,
            samples: 0,
            may_be_wrong: false,
            row: Some((Status::Ok, String::new())),
            figures: Vec::new(),
            notes: Vec::new(),
            features: Vec::new(),
        });
        let last = self.cases.len() - 1;
        &mut self.cases[last]
    }

    /// The run as a folder has it that is gone again.
    ///
    /// # Panics
    /// Where it cannot be written or is no run.
    #[must_use]
    pub fn loaded(&self) -> Run {
        let folder = tempfile::tempdir().expect("a folder");
        self.write(folder.path()).expect("a run")
    }

    /// Writes the folder and reads it back.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn write(&self, path: &Path) -> Result<Run, RunError> {
        let figures = || self.cases.iter().flat_map(|case| &case.figures);
        let most = |count: fn(&[Vec<f64>]) -> usize| {
            let counts = figures().map(|(_, _, processes)| count(processes));
            u32::try_from(counts.max().unwrap_or(0)).unwrap_or(u32::MAX)
        };
        let processes = most(<[Vec<f64>]>::len).max(1);
        let plan = RunPlan {
            cases: self.cases.iter().map(MadeUpCase::planned).collect(),
            skipped: self.skipped.clone(),
            processes,
            ..RunPlan::default()
        };
        let mut metrics = self.metrics.clone();
        for (name, ..) in figures() {
            if metrics.iter().all(|metric| metric.name != *name) {
                metrics.push(Metric::quantity(name, "made up"));
            }
        }
        let environment = RunEnvironment {
            schema: crate::SCHEMA,
            ..self.environment.clone()
        };
        let folder = RunFolder::create(path, environment, plan, &metrics)?;
        for (case, planned) in self.cases.iter().zip(&folder.plan().cases) {
            folder.append_measurements(&case.measurements())?;
            let notes = case.notes.iter().map(|(note, text)| Note {
                case: case.id.key(),
                note: (*note).to_owned(),
                text: text.clone(),
            });
            folder.append_notes(&notes.collect::<Vec<_>>())?;
            folder.append_features(&case.id.key(), &case.features)?;
            if let Some((status, reason)) = &case.row {
                folder.append_case(planned, *status, reason)?;
            }
        }
        Run::load(path)
    }
}

impl MadeUpCase {
    /// A counter, or an error figure.
    pub fn figure(&mut self, metric: impl Into<&'static str>, value: f64) -> &mut Self {
        self.take(metric.into(), 0, &[&[value]])
    }

    /// A time: one sample in each process.
    pub fn timed(&mut self, metric: impl Into<&'static str>, processes: &[f64]) -> &mut Self {
        self.sampled(metric, &processes.chunks(1).collect::<Vec<_>>())
    }

    /// A time: samples of each process.
    pub fn sampled(&mut self, metric: impl Into<&'static str>, processes: &[&[f64]]) -> &mut Self {
        self.take(metric.into(), 1, processes)
    }

    fn take(&mut self, metric: &'static str, first: u32, processes: &[&[f64]]) -> &mut Self {
        let processes = processes.iter().map(|samples| samples.to_vec()).collect();
        self.figures.retain(|(known, ..)| *known != metric);
        self.figures.push((metric, first, processes));
        self
    }

    /// A text.
    pub fn note(&mut self, name: &'static str, text: &str) -> &mut Self {
        self.notes.retain(|(known, _)| *known != name);
        self.notes.push((name, text.to_owned()));
        self
    }

    /// How it ended, and why.
    pub fn ended(&mut self, status: Status, reason: &str) -> &mut Self {
        self.row = Some((status, reason.to_owned()));
        self
    }

    /// The run ended before it.
    pub fn missing(&mut self) -> &mut Self {
        self.row = None;
        self
    }

    fn planned(&self) -> PlannedCase {
        PlannedCase {
            id: self.id.clone(),
            samples: self.samples,
            may_be_wrong: self.may_be_wrong,
        }
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut rows = Vec::new();
        for (metric, first, processes) in &self.figures {
            for (process, samples) in (0..).zip(processes) {
                for (sample, value) in (*first..).zip(samples) {
                    rows.push(Measurement {
                        case: self.id.key(),
                        metric: (*metric).to_owned(),
                        process,
                        sample,
                        value: *value,
                    });
                }
            }
        }
        rows
    }
}
