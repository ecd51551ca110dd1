// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run as its readers see it: every planned case with its figures, or why it has none.
//!
//! Strict: a table that is missing, a column that is not the expected one, another schema version, a
//! row of another commit, or a value of a metric that was never declared is an error that names the
//! file and the place. Only a torn last row is let pass, since a killed run leaves one.

use crate::feature::read_features;
use crate::folder::{
    CASE_COLUMNS, CASES, ENVIRONMENT, MEASUREMENT_COLUMNS, MEASUREMENTS, METRIC_COLUMNS, METRICS,
    NOTE_COLUMNS, NOTES, OLD_METRIC_COLUMNS, PLAN, RunError, cell, check_schema, each_row,
    read_json, read_table,
};
use crate::{
    CaseFeature, CaseId, Clock, Measurement, MetricRow, Note, Numbered, PlannedCase, REPEATS,
    RunEnvironment, RunPlan, Status, median,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How a planned case ended, including that it has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// Right, and measured as often as planned.
    Ok,
    /// Wrong.
    Wrong,
    /// Not run, with a reason.
    Skipped,
    /// Broke off, with a reason.
    Failed,
    /// Differs in exactly the pixels that a listed fault of this driver loses.
    DriverFault,
    /// The run ended before it was verified, or before all its samples were taken.
    Missing,
}

impl Outcome {
    /// In tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Wrong => "wrong",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
            Self::DriverFault => "driver-fault",
            Self::Missing => "missing",
        }
    }
}

/// Values of one metric of one case: process → sample → value.
pub type Samples = Numbered<Numbered<f64>>;

/// One planned case and what is known of it.
#[derive(Debug, Clone)]
pub struct Case {
    /// As planned.
    pub planned: PlannedCase,
    /// How it ended.
    pub outcome: Outcome,
    /// Why, or a remark; for a missing case, what is missing.
    pub reason: String,
    status: Option<Status>,
    figures: BTreeMap<Arc<str>, Samples>,
    notes: BTreeMap<String, String>,
    features: Vec<CaseFeature>,
}

impl Case {
    /// As in its row; `None` where it has none.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        self.status
    }

    /// Every text of the case by name.
    #[must_use]
    pub fn notes(&self) -> &BTreeMap<String, String> {
        &self.notes
    }

    /// What it holds and leaves out; empty of a case that does not say.
    #[must_use]
    pub fn features(&self) -> &[CaseFeature] {
        &self.features
    }

    /// Numbers of the timed samples that a process took, from 1.
    #[must_use]
    pub fn timed_samples(&self, process: u32) -> BTreeSet<u32> {
        let of_process = self.figures.values().filter_map(|all| all.get(&process));
        let samples = of_process.flat_map(|samples| samples.keys().copied());
        samples.filter(|sample| *sample > 0).collect()
    }

    /// Metrics that were measured, with their values.
    #[must_use]
    pub fn figures(&self) -> &BTreeMap<Arc<str>, Samples> {
        &self.figures
    }

    /// A row for each of these values.
    #[must_use]
    pub fn measurements(&self) -> Vec<Measurement> {
        let key = self.id().key();
        let mut rows = Vec::new();
        for (metric, samples) in &self.figures {
            for (&process, of) in samples {
                rows.extend(of.iter().map(|(&sample, &value)| Measurement {
                    case: key.clone(),
                    metric: metric.to_string(),
                    process,
                    sample,
                    value,
                }));
            }
        }
        rows
    }

    /// Which case.
    #[must_use]
    pub fn id(&self) -> &CaseId {
        &self.planned.id
    }

    /// Value of a condition; empty where the case has none of that name.
    #[must_use]
    pub fn condition(&self, key: impl AsRef<str>) -> &str {
        self.condition_named(key.as_ref())
    }

    /// The same for readers of any study, which have names from tables.
    #[must_use]
    pub fn condition_named(&self, key: &str) -> &str {
        self.planned.id.condition_named(key)
    }

    /// Whether it repeats the work of another case, to see by how much identical work differs.
    #[must_use]
    pub fn is_repeat(&self) -> bool {
        self.planned.id.conditions.contains_key(REPEATS.name())
    }

    /// Whether its figures may be compared with others'.
    #[must_use]
    pub fn counts(&self) -> bool {
        self.outcome == Outcome::Ok
    }

    /// Every value of a metric; `None` where it was not measured.
    #[must_use]
    pub fn samples(&self, metric: impl AsRef<str>) -> Option<&Samples> {
        self.figures.get(metric.as_ref())
    }

    /// One number per process, its median over the process's samples: the replicates.
    #[must_use]
    pub fn replicates(&self, metric: impl AsRef<str>) -> Vec<f64> {
        let processes = self.samples(metric).into_iter().flatten();
        processes
            .filter_map(|(_, samples)| {
                let values: Vec<f64> = samples.values().copied().collect();
                median(&values)
            })
            .collect()
    }

    /// The metric's value: the median over processes of their medians. A counter has one sample.
    #[must_use]
    pub fn value(&self, metric: impl AsRef<str>) -> Option<f64> {
        let metric = metric.as_ref();
        let all = self.replicates(metric);
        match all.as_slice() {
            [only] => Some(*only),
            [] => self.single(metric),
            _ => median(&all),
        }
    }

    /// A value that is no number stays one, which a median would drop.
    fn single(&self, metric: &str) -> Option<f64> {
        let samples = self.figures.get(metric)?.values().next()?;
        samples.values().next().copied()
    }

    /// A text of the case, such as `image`; empty where there is none.
    #[must_use]
    pub fn note(&self, name: &str) -> &str {
        self.notes.get(name).map_or("", String::as_str)
    }
}

/// A run, read and checked.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its folder.
    pub path: PathBuf,
    /// Where and with what it was made.
    pub environment: RunEnvironment,
    /// What it set out to measure.
    pub plan: RunPlan,
    /// Declarations of everything measured.
    pub metrics: Vec<MetricRow>,
    /// In the plan's order.
    pub cases: Vec<Case>,
    /// What [`Run::primary_metric`] answers, by study.
    pub primary: BTreeMap<String, String>,
}

impl Run {
    /// Reads a run's folder.
    ///
    /// # Errors
    /// [`RunError`], for anything that does not fit the schema or the rest of the folder.
    pub fn load(path: &Path) -> Result<Self, RunError> {
        check_schema(path)?;
        let plan: RunPlan = read_json(&path.join(PLAN))?;
        let environment: RunEnvironment = read_json(&path.join(ENVIRONMENT))?;
        let metrics = read_metrics(&path.join(METRICS))?;
        let mut rows = read_cases(&path.join(CASES), &plan, &environment)?;
        let names: BTreeSet<Arc<str>> = metrics
            .iter()
            .map(|metric| metric.name.as_str().into())
            .collect();
        let planned: BTreeSet<String> = plan.cases.iter().map(|case| case.id.key()).collect();
        let mut figures = read_measurements(&path.join(MEASUREMENTS), &planned, &names)?;
        let mut notes = read_notes(&path.join(NOTES), &planned)?;
        let mut features = read_features(path, &planned)?;
        let cases: Vec<Case> = plan
            .cases
            .iter()
            .map(|planned| {
                let key = planned.id.key();
                let figures = figures.remove(&key).unwrap_or_default();
                let row = rows.remove(&key);
                let status = row.as_ref().map(|(status, _)| *status);
                let (outcome, reason) = outcome(planned, &plan, row, &figures);
                Case {
                    planned: planned.clone(),
                    status,
                    outcome,
                    reason,
                    figures,
                    notes: notes.remove(&key).unwrap_or_default(),
                    features: features.remove(&key).unwrap_or_default(),
                }
            })
            .collect();
        Ok(Self {
            path: path.to_owned(),
            primary: primary(&metrics, &cases, environment.primary_clock()),
            environment,
            plan,
            metrics,
            cases,
        })
    }

    /// The clock of every ratio, ranking and plot of this run.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.environment.primary_clock()
    }

    /// Cases of one study, repeats included.
    pub fn of_study<'a>(&'a self, study: &'a str) -> impl Iterator<Item = &'a Case> + Clone {
        self.cases
            .iter()
            .filter(move |case| case.id().study == study)
    }

    /// Cases that ended so, repeats not counted.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> usize {
        let cases = self.cases.iter().filter(|case| !case.is_repeat());
        cases.filter(|case| case.outcome == outcome).count()
    }

    /// The case of this key.
    #[must_use]
    pub fn case(&self, key: &str) -> Option<&Case> {
        self.cases.iter().find(|case| case.id().key() == key)
    }

    /// The metric that a study's cases are ranked by, as the run itself says: of those marked for its clock
    /// one that no earlier study measured. `None` in runs that are older than the mark.
    #[must_use]
    pub fn primary_metric(&self, study: &str) -> Option<&str> {
        self.primary.get(study).map(String::as_str)
    }

    /// Declaration of a metric.
    #[must_use]
    pub fn metric(&self, name: &str) -> Option<&MetricRow> {
        self.metrics.iter().find(|metric| metric.name == name)
    }
}

/// Of each study the metric that is marked as ranking it.
fn primary(metrics: &[MetricRow], cases: &[Case], clock: Clock) -> BTreeMap<String, String> {
    let marked = metrics.iter().filter(|metric| metric.primary.ranks(clock));
    let mut marked: BTreeSet<&str> = marked.map(|metric| metric.name.as_str()).collect();
    let mut found = BTreeMap::new();
    for case in cases {
        for metric in case
            .figures
            .keys()
            .filter(|metric| marked.remove(&***metric))
        {
            found.insert(case.id().study.clone(), metric.to_string());
        }
    }
    found
}

fn outcome(
    planned: &PlannedCase,
    plan: &RunPlan,
    row: Option<(Status, String)>,
    figures: &BTreeMap<Arc<str>, Samples>,
) -> (Outcome, String) {
    let Some((status, reason)) = row else {
        return (
            Outcome::Missing,
            "the run ended before this case".to_owned(),
        );
    };
    let outcome = match status {
        Status::Ok => Outcome::Ok,
        Status::Wrong => Outcome::Wrong,
        Status::Skipped => return (Outcome::Skipped, reason),
        Status::Failed => return (Outcome::Failed, reason),
        Status::DriverFault => return (Outcome::DriverFault, reason),
    };
    if outcome == Outcome::Wrong && !planned.may_be_wrong {
        return (outcome, reason);
    }
    let wanted = planned.samples as usize * plan.processes as usize;
    let found = samples_taken(figures);
    if found < wanted {
        let reason = format!("the run ended after {found} of {wanted} samples of this case");
        return (Outcome::Missing, reason);
    }
    (outcome, reason)
}

/// Timed samples, which count from 1, over all processes.
fn samples_taken(figures: &BTreeMap<Arc<str>, Samples>) -> usize {
    let taken: BTreeSet<(u32, u32)> = figures
        .values()
        .flatten()
        .flat_map(|(&process, samples)| samples.keys().map(move |&sample| (process, sample)))
        .filter(|(_, sample)| *sample > 0)
        .collect();
    taken.len()
}

fn strings(columns: &[&str]) -> Vec<String> {
    columns.iter().map(ToString::to_string).collect()
}

/// A row number as people count them: the header is 1.
fn numbered<T>(rows: Vec<T>) -> impl Iterator<Item = (u64, T)> {
    (2..).zip(rows)
}

fn read_metrics(path: &Path) -> Result<Vec<MetricRow>, RunError> {
    let columns = strings(&METRIC_COLUMNS);
    let rows = match read_table(path, &columns) {
        Err(RunError::Column {
            position, found, ..
        }) if position == OLD_METRIC_COLUMNS + 1 && found.is_empty() => {
            read_table(path, &columns[..OLD_METRIC_COLUMNS])
        }
        rows => rows,
    }?;
    numbered(rows)
        .map(|(row, record)| {
            let header: csv::StringRecord = columns.iter().take(record.len()).collect();
            record
                .deserialize(Some(&header))
                .map_err(|error| match error.kind() {
                    csv::ErrorKind::Deserialize { err, .. } => {
                        let index = err.field().and_then(|i| usize::try_from(i).ok());
                        let column = index.and_then(|i| METRIC_COLUMNS.get(i)).unwrap_or(&"");
                        let found = index.and_then(|i| record.get(i)).unwrap_or_default();
                        cell(path, row, column, found, err.kind().to_string())
                    }
                    _ => cell(path, row, "", "", error.to_string()),
                })
        })
        .collect()
}

type CaseRows = BTreeMap<String, (Status, String)>;

fn read_cases(
    path: &Path,
    plan: &RunPlan,
    environment: &RunEnvironment,
) -> Result<CaseRows, RunError> {
    let mut columns = strings(&CASE_COLUMNS);
    columns.extend(plan.conditions());
    let mut rows = CaseRows::new();
    let planned: BTreeMap<String, &PlannedCase> = plan
        .cases
        .iter()
        .map(|case| (case.id.key(), case))
        .collect();
    for (row, record) in numbered(read_table(path, &columns)?) {
        let of = |index: usize| record.get(index).unwrap_or_default();
        let Some(case) = planned.get(of(0)) else {
            return Err(cell(path, row, "case", of(0), "a case of plan.json"));
        };
        if of(5) != environment.commit {
            let expected = format!("{:?}, that of environment.json", environment.commit);
            return Err(cell(path, row, "commit", of(5), expected));
        }
        for (index, column) in columns.iter().enumerate().skip(CASE_COLUMNS.len()) {
            let expected = case.id.condition_named(column);
            if of(index) != expected {
                let expected = format!("{expected:?}, as in plan.json");
                return Err(cell(path, row, column, of(index), expected));
            }
        }
        let status = Status::from_name(of(2)).ok_or_else(|| {
            cell(
                path,
                row,
                "status",
                of(2),
                "ok, wrong, skipped, failed or driver-fault",
            )
        })?;
        let earlier = rows.insert(of(0).to_owned(), (status, of(3).to_owned()));
        if earlier.is_some() {
            return Err(cell(path, row, "case", of(0), "one row a case"));
        }
    }
    Ok(rows)
}

fn read_measurements(
    path: &Path,
    planned: &BTreeSet<String>,
    metrics: &BTreeSet<Arc<str>>,
) -> Result<BTreeMap<String, BTreeMap<Arc<str>, Samples>>, RunError> {
    let mut figures: BTreeMap<String, BTreeMap<Arc<str>, Samples>> = BTreeMap::new();
    let columns = strings(&MEASUREMENT_COLUMNS);
    each_row(path, &columns, |row, record| {
        let of = |index: usize| record.get(index).unwrap_or_default();
        let wrong = |index: usize, expected: &str| {
            cell(path, row, MEASUREMENT_COLUMNS[index], of(index), expected)
        };
        // Names are kept once, and not for each row.
        if !figures.contains_key(of(0)) && !planned.contains(of(0)) {
            return Err(wrong(0, "a case of plan.json"));
        }
        let of_case = kept(&mut figures, of(0));
        if !of_case.contains_key(of(1)) {
            let metric = metrics.get(of(1));
            let metric = metric.ok_or_else(|| wrong(1, "a metric of metrics.csv"))?;
            of_case.insert(Arc::clone(metric), Samples::default());
        }
        let samples = of_case.get_mut(of(1)).expect("it was inserted");
        let process = of(2).parse().map_err(|_| wrong(2, "a whole number"))?;
        let sample = of(3).parse().map_err(|_| wrong(3, "a whole number"))?;
        let value = of(4).parse().map_err(|_| wrong(4, "a number"))?;
        samples.of(process).insert(sample, value);
        Ok(())
    })?;
    Ok(figures)
}

/// The value of this name, made where there is none.
fn kept<'a, T: Default>(all: &'a mut BTreeMap<String, T>, name: &str) -> &'a mut T {
    if !all.contains_key(name) {
        return all.entry(name.to_owned()).or_default();
    }
    all.get_mut(name).expect("it was found")
}

fn read_notes(
    path: &Path,
    planned: &BTreeSet<String>,
) -> Result<BTreeMap<String, BTreeMap<String, String>>, RunError> {
    let mut notes: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for (row, record) in numbered(read_table(path, &strings(&NOTE_COLUMNS))?) {
        let of = |index: usize| record.get(index).unwrap_or_default();
        if !planned.contains(of(0)) {
            return Err(cell(path, row, "case", of(0), "a case of plan.json"));
        }
        let note = Note {
            case: of(0).to_owned(),
            note: of(1).to_owned(),
            text: of(2).to_owned(),
        };
        notes
            .entry(note.case)
            .or_default()
            .insert(note.note, note.text);
    }
    Ok(notes)
}

/// Keys of the plan that stand twice: their rows could not be told apart.
#[must_use]
pub fn repeated_cases(plan: &RunPlan) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let keys = plan.cases.iter().map(|case| case.id.key());
    keys.filter(|key| !seen.insert(key.clone())).collect()
}
