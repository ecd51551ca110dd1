// SPDX-License-Identifier: MIT OR Apache-2.0
//! A run as the store keeps it: its commit, its machine, and a number for each figure and process.

use crate::HistoryError;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use terrafill_results::{Clock, MetricRow, Outcome, Primary, Run, RunEnvironment, median};

/// Options that change how often things are measured, and no figure; a merged run has no shard.
const FREE_OPTIONS: [&str; 5] = ["processes=", "samples=", "seed=", "shard=", "shard-by="];

/// Ending of a commit whose sources were edited.
const DIRTY: &str = "+dirty";

/// The kind of machine, driver and options that figures belong to: the fingerprint.
///
/// Neither the host's name nor a clock rate is in it: two machines of one kind share a history.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct Machine {
    /// CPU model.
    pub cpu: String,
    /// Logical cores.
    pub cores: u32,
    /// Adapter name.
    pub gpu: String,
    /// `cpu`, `discrete-gpu` …
    pub device_type: String,
    /// PCI vendor id.
    pub vendor_id: u32,
    /// PCI device id.
    pub device_id: u32,
    /// Driver name.
    pub driver: String,
    /// Driver version, with those of Mesa and LLVM where it is Mesa's.
    pub driver_info: String,
    /// UUID of the driver's build, hexadecimal; empty where it was not recorded.
    pub driver_uuid: String,
    /// Mesa version.
    pub mesa_version: String,
    /// Whether the device has a clock that passes can be timed by.
    pub gpu_timestamps: bool,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Debug or release build.
    pub profile: String,
    /// Options that figures depend on.
    pub options: Vec<String>,
}

impl Machine {
    /// Of a run's environment.
    #[must_use]
    pub fn of(environment: &RunEnvironment) -> Self {
        let e = environment.clone();
        let is_free = |option: &str| FREE_OPTIONS.iter().any(|key| option.starts_with(key));
        Self {
            cpu: e.cpu,
            cores: e.cores,
            gpu: e.gpu,
            device_type: e.device_type,
            vendor_id: e.vendor_id,
            device_id: e.device_id,
            driver: e.driver,
            driver_info: e.driver_info,
            driver_uuid: e.driver_uuid,
            mesa_version: e.mesa_version,
            gpu_timestamps: e.gpu_timestamps,
            width: e.width,
            height: e.height,
            profile: e.profile,
            options: e.options.into_iter().filter(|o| !is_free(o)).collect(),
        }
    }

    /// The clock that its times are compared by.
    #[must_use]
    pub fn clock(&self) -> Clock {
        let environment = RunEnvironment {
            device_type: self.device_type.clone(),
            gpu_timestamps: self.gpu_timestamps,
            ..RunEnvironment::default()
        };
        environment.primary_clock()
    }

    /// Device, driver, CPU and picture size in a line.
    #[must_use]
    pub fn label(&self) -> String {
        let known = |text: &str| match text {
            "" => "not recorded".to_owned(),
            text => text.to_owned(),
        };
        format!(
            "{}, {}, {} × {}, {}×{}, {}",
            known(&self.gpu),
            known(&self.driver_info),
            self.cores,
            known(&self.cpu),
            self.width,
            self.height,
            known(&self.profile)
        )
    }

    /// In what it differs from another, with both values.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let facts = |of: &Self| match serde_json::to_value(of) {
            Ok(serde_json::Value::Object(facts)) => facts,
            _ => serde_json::Map::new(),
        };
        let (ours, theirs) = (facts(self), facts(other));
        let differ = ours
            .iter()
            .filter(|(name, value)| theirs.get(*name) != Some(value));
        differ
            .map(|(name, value)| {
                let other = theirs.get(name).unwrap_or(&serde_json::Value::Null);
                format!("{name} {value} and {other}")
            })
            .collect()
    }
}

/// A run as the store keeps it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Commit, with `+dirty` where the sources were edited.
    pub commit: String,
    /// Seconds since 1970 at its start.
    pub started_unix_s: u64,
    /// Hash over all shader sources.
    pub shader_hash: String,
    /// Where it was made.
    pub machine: Machine,
    /// Declarations of the figures that it has.
    pub metrics: Vec<MetricRow>,
    /// In alphabetical order. repeats are left out: they repeat the work of others.
    pub cases: Vec<CaseRecord>,
    /// By study the metric that the run marks as ranking it; empty of runs that are older than the mark.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ranks: BTreeMap<String, String>,
}

/// A case of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseRecord {
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// What it was measured under.
    pub conditions: BTreeMap<String, String>,
    /// [`Outcome::name`]; a case that may be wrong is `ok`.
    pub outcome: String,
    /// Why, or what is missing.
    pub reason: String,
    /// Metric, process, and the median over the process's samples. Empty unless `ok`.
    pub figures: Vec<(String, u32, f64)>,
}

impl Record {
    /// Of a run folder, with the number of figures that are no numbers and were left out.
    ///
    /// # Errors
    /// [`HistoryError::Run`] for a shard, for a run without a commit and for one without a case.
    pub fn of(run: &Run) -> Result<(Self, usize), HistoryError> {
        let refuse = |message: &str| HistoryError::Run {
            run: run.path.display().to_string(),
            message: message.to_owned(),
        };
        if let Some(shard) = run.plan.shard {
            let message = format!(
                "found shard {}/{}, allowed: whole runs; merge its shards first",
                shard.index, shard.count
            );
            return Err(refuse(&message));
        }
        let mut left_out = 0;
        let mut cases: Vec<CaseRecord> = Vec::new();
        for case in run.cases.iter().filter(|case| !case.is_repeat()) {
            let is_result =
                case.counts() || case.outcome == Outcome::Wrong && case.planned.may_be_wrong;
            let mut record = CaseRecord {
                case: case.id().key(),
                conditions: case.id().conditions.clone(),
                outcome: if is_result {
                    Outcome::Ok.name().to_owned()
                } else {
                    case.outcome.name().to_owned()
                },
                reason: case.reason.clone(),
                figures: Vec::new(),
            };
            let figures = case.figures().iter().filter(|_| is_result);
            for (metric, samples) in figures {
                for (process, samples) in samples {
                    let values: Vec<f64> = samples.values().copied().collect();
                    match median(&values).filter(|value| value.is_finite()) {
                        Some(value) => record.figures.push((metric.to_string(), *process, value)),
                        None => left_out += 1,
                    }
                }
            }
            cases.push(record);
        }
        if cases.is_empty() {
            return Err(refuse("found no case, needs one"));
        }
        cases.sort_by(|a, b| a.case.cmp(&b.case));
        let used: BTreeSet<&str> = cases
            .iter()
            .flat_map(|case| &case.figures)
            .map(|(metric, ..)| metric.as_str())
            .collect();
        let mut metrics: Vec<MetricRow> = run.metrics.clone();
        metrics.retain(|metric| used.contains(metric.name.as_str()));
        metrics.sort_by(|a, b| a.name.cmp(&b.name));
        let record = Self {
            commit: run.environment.commit.clone(),
            started_unix_s: run.environment.started_unix_s,
            shader_hash: run.environment.shader_hash.clone(),
            machine: Machine::of(&run.environment),
            metrics,
            cases,
            ranks: run.primary.clone(),
        };
        record.check_commit(&run.path.display().to_string())?;
        Ok((record, left_out))
    }

    /// Refuses what is no commit: it is handed to git.
    pub(crate) fn check_commit(&self, run: &str) -> Result<(), HistoryError> {
        let hash = clean(&self.commit);
        let is_hash = (7..=64).contains(&hash.len()) && hash.bytes().all(|b| b.is_ascii_hexdigit());
        if is_hash {
            return Ok(());
        }
        Err(HistoryError::Run {
            run: run.to_owned(),
            message: format!(
                "commit: found {:?}, allowed: 7 … 64 hexadecimal digits; a program built outside a \
                 repository has none",
                self.commit
            ),
        })
    }

    /// Hash over everything in it: the same run is stored once.
    #[must_use]
    pub fn digest(&self) -> String {
        hash(&self.without_texts())
    }

    /// Without meanings and conditions: the store keeps those of the first run that had them. Marks, which older
    /// programs did not keep, and scopes, which it does not keep, are left out too.
    fn without_texts(&self) -> Self {
        let mut plain = self.clone();
        plain.ranks.clear();
        plain.metrics.iter_mut().for_each(|metric| {
            metric.meaning.clear();
            metric.primary = Primary::No;
            metric.scope.clear();
        });
        plain
            .cases
            .iter_mut()
            .for_each(|case| case.conditions.clear());
        plain
    }

    /// Hash over what tells a run from others before it has measured anything.
    #[must_use]
    pub fn identity(&self) -> String {
        let cases: Vec<&str> = self.cases.iter().map(|case| case.case.as_str()).collect();
        hash(&(
            &self.commit,
            self.started_unix_s,
            &self.shader_hash,
            &self.machine,
            cases,
        ))
    }

    /// Names of its cases that were not reached, with the reason.
    pub fn missing(&self) -> impl Iterator<Item = (&str, &str)> {
        let missing = |case: &&CaseRecord| case.outcome == Outcome::Missing.name();
        let cases = self.cases.iter().filter(missing);
        cases.map(|case| (case.case.as_str(), case.reason.as_str()))
    }

    /// Whether it is `earlier` with more cases measured: a run that was resumed.
    #[must_use]
    pub fn continues(&self, earlier: &Self) -> bool {
        let was_reached = |case: &&CaseRecord| case.outcome != Outcome::Missing.name();
        let (now, then) = (self.without_texts(), earlier.without_texts());
        self.identity() == earlier.identity()
            && then.missing().count() > now.missing().count()
            && then
                .cases
                .iter()
                .filter(was_reached)
                .all(|case| now.cases.contains(case))
    }
}

/// A commit without the word on edited sources.
#[must_use]
pub fn clean(commit: &str) -> &str {
    commit.strip_suffix(DIRTY).unwrap_or(commit)
}

/// Whether sources were edited, so that the commit does not tell what was measured.
#[must_use]
pub fn is_dirty(commit: &str) -> bool {
    commit.ends_with(DIRTY)
}

fn hash(value: &impl Serialize) -> String {
    // A record has neither maps with other keys than texts nor anything else that JSON lacks.
    let text = serde_json::to_string(value).unwrap_or_default();
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
