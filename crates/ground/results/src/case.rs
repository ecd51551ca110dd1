// SPDX-License-Identifier: MIT OR Apache-2.0
//! A case: one point of a study, under named conditions.

use crate::condition::REPEATS;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the notes begin with of processes that timed before their clock was steady.
pub const UNSTEADY_CLOCK: &str = "unsteady_clock_";

/// What tells a case from all others.
///
/// The name is for people and for joining tables; nobody has to take it apart, since every condition
/// has a column of its own in `cases.csv`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CaseId {
    /// The study that it belongs to.
    pub study: String,
    /// Unique within the study, `california/globe/vertex/doubled`.
    pub name: String,
    /// `scene`, `view`, `technique`, `colour` …, each with its value.
    pub conditions: BTreeMap<String, String>,
}

impl CaseId {
    /// A case of `study`.
    #[must_use]
    pub fn new<K: Into<String>>(
        study: &str,
        name: impl Into<String>,
        conditions: impl IntoIterator<Item = (K, String)>,
    ) -> Self {
        Self {
            study: study.to_owned(),
            name: name.into(),
            conditions: conditions
                .into_iter()
                .map(|(key, value)| (key.into(), value))
                .collect(),
        }
    }

    /// `study/name`: the `case` column of every table.
    #[must_use]
    pub fn key(&self) -> String {
        format!("{}/{}", self.study, self.name)
    }

    /// Value of a condition; empty where the case has none of that name.
    #[must_use]
    pub fn condition(&self, key: impl AsRef<str>) -> &str {
        self.condition_named(key.as_ref())
    }

    /// The same for readers of any study, which have names from tables.
    #[must_use]
    pub fn condition_named(&self, key: &str) -> &str {
        self.conditions.get(key).map_or("", String::as_str)
    }

    /// The same work under another name, see [`REPEATS`].
    #[must_use]
    pub fn repeat(&self) -> Self {
        let mut repeat = self.clone();
        repeat.name.push_str(" (again)");
        repeat.conditions.insert(REPEATS.into(), self.key());
        repeat
    }
}

impl std::fmt::Display for CaseId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.study, self.name)
    }
}

/// A case that a run set out to measure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedCase {
    /// Which.
    pub id: CaseId,
    /// Timed samples in each process; 0 for a case that is only verified.
    pub samples: u32,
    /// Whether its error is the question, so that a wrong answer is a result and no defect.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub may_be_wrong: bool,
}

/// What a case's probe showed, before anything is timed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Verdict {
    /// How it ended.
    pub status: Status,
    /// Why, unless `ok`; also remarks, such as why a cell is empty.
    pub reason: String,
    /// Figures of the probe by metric name: counters, bytes and errors.
    pub figures: Vec<(&'static str, f64)>,
    /// Texts by name: picture paths, hashes, what was left out.
    pub notes: Vec<(&'static str, String)>,
    /// What the case holds and leaves out, if it says so.
    pub features: Vec<CaseFeature>,
}

impl Verdict {
    /// Not run, for this reason.
    #[must_use]
    pub fn skipped(reason: impl Into<String>) -> Self {
        Self {
            status: Status::Skipped,
            reason: reason.into(),
            ..Self::default()
        }
    }

    /// Broke off, for this reason.
    #[must_use]
    pub fn failed(reason: impl Into<String>) -> Self {
        Self {
            status: Status::Failed,
            reason: reason.into(),
            ..Self::default()
        }
    }
}

/// Something that a case holds on the device, or leaves out.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct CaseFeature {
    /// Its name.
    pub feature: String,
    /// It is built in; else it is left out.
    pub is_held: bool,
    /// Bytes of its buffers and textures.
    pub bytes: u64,
    /// Pipelines made for it.
    pub pipelines: u64,
    /// Bytes that it would take beside these.
    pub spared_bytes: u64,
    /// Why, with the value that decided it.
    pub reason: String,
}

/// A row of `measurements.csv`: raw, appended, never edited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// [`CaseId::key`].
    pub case: String,
    /// [`crate::Metric::name`].
    pub metric: String,
    /// Which process measured it, from 0: one process is one replicate.
    pub process: u32,
    /// 0: a figure of the probe, taken once. Timed samples of a case count from 1 in each process.
    pub sample: u32,
    /// In the metric's unit.
    pub value: f64,
}

/// A row of `notes.csv`: what is said of a case in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// [`CaseId::key`].
    pub case: String,
    /// `image`, `mask_hash`, `left_out` …
    pub note: String,
    /// The text.
    pub text: String,
}

/// How a case ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The picture is right and the times were measured.
    Ok,
    /// The picture is wrong; times, if any, count for nothing.
    Wrong,
    /// Not run, for the reason given.
    #[default]
    Skipped,
    /// Started and broke off, for the reason given.
    Failed,
    /// The picture differs in exactly the pixels that a listed fault of this driver loses: an expected
    /// failure. Never timed and never right.
    DriverFault,
}

impl Status {
    /// Every status.
    pub const ALL: [Self; 5] = [
        Self::Ok,
        Self::Wrong,
        Self::Skipped,
        Self::Failed,
        Self::DriverFault,
    ];

    /// As in the `status` column.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Wrong => "wrong",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
            Self::DriverFault => "driver-fault",
        }
    }

    /// The inverse of [`Status::name`].
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|status| status.name() == name)
    }
}
