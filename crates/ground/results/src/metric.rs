// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a figure is: declared once by the study that measures it.
//!
//! `terrafill studies --markdown`, `metrics.csv` and `schema.json` are made from these declarations,
//! so a figure cannot be written under a name that is explained nowhere.

use crate::{Clock, Scope};
use serde::{Deserialize, Serialize};

/// How a figure comes about, which decides how it may be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Exact and repeatable on every driver: draws, vertices, triangles. Compared without statistics.
    Counter,
    /// Exact and repeatable within one driver: pipeline statistics, pixels.
    #[serde(rename = "driver-counter")]
    DriverCounter,
    /// Exact as well, and added up over buffers.
    Bytes,
    /// Noisy: compared over processes, with an interval.
    Time,
    /// Difference from the reference; repeatable within one driver.
    Error,
}

impl Kind {
    /// Whether two runs of the same work agree in every bit.
    #[must_use]
    pub fn is_exact(self) -> bool {
        self != Self::Time
    }

    /// Whether two drivers may differ in it for the same work.
    #[must_use]
    pub fn depends_on_driver(self) -> bool {
        matches!(self, Self::DriverCounter | Self::Error)
    }

    /// As in `metrics.csv`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Counter => "counter",
            Self::DriverCounter => "driver-counter",
            Self::Bytes => "bytes",
            Self::Time => "time",
            Self::Error => "error",
        }
    }
}

/// Which way a figure should go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Less is better.
    Less,
    /// More is better.
    More,
    /// Neither: it describes the case.
    Neither,
}

/// What a time is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Timer {
    /// Timestamps of the device.
    Gpu,
    /// CPU time of the whole process.
    ProcessCpu,
    /// The wall clock, around work that has been waited for.
    Wall,
}

impl Timer {
    /// Of times by it, for headings and axes.
    #[must_use]
    pub fn unit_ms(self) -> &'static str {
        match self {
            Self::Gpu => "GPU ms",
            Self::ProcessCpu => "process CPU ms",
            Self::Wall => "wall-clock ms",
        }
    }
}

/// By which clock a study's cases are ranked by a figure, as in `metrics.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Primary {
    /// It ranks nothing.
    #[default]
    #[serde(rename = "")]
    No,
    /// By GPU time, on hardware.
    Gpu,
    /// By the wall clock, on hardware: the device's clock covers less than is compared.
    Wall,
    /// By process CPU time, on software devices.
    Cpu,
    /// On every device.
    Any,
}

impl Primary {
    /// Whether it ranks in runs whose times are compared by `clock`.
    #[must_use]
    pub const fn ranks(self, clock: Clock) -> bool {
        match self {
            Self::No => false,
            Self::Gpu | Self::Wall => matches!(clock, Clock::Gpu),
            Self::Cpu => matches!(clock, Clock::ProcessCpu),
            Self::Any => true,
        }
    }

    fn is_no(&self) -> bool {
        *self == Self::No
    }
}

/// Why a figure is absent that gives no reason of its own.
pub const NOT_MEASURED: &str = "not measured";

/// One declared figure. Names are unique over all studies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Metric {
    /// `fill_cpu_ms`: lower case, with the unit at the end where there is one.
    pub name: &'static str,
    /// `ms`, `bytes`, `px` …; empty for a plain number.
    pub unit: &'static str,
    /// How it comes about.
    pub kind: Kind,
    /// Which way it should go.
    pub better: Direction,
    /// One or two sentences for the glossary.
    pub meaning: &'static str,
    /// What it covers, of times; nothing of other figures.
    pub scope: Scope,
    /// Whether it ranks its study.
    pub primary: Primary,
    /// Why a case that ended well may lack it.
    pub absent: &'static str,
}

impl Metric {
    /// The same time, which covers `scope`.
    #[must_use]
    pub const fn covering(self, scope: Scope) -> Self {
        Self { scope, ..self }
    }

    /// The same time, which ranks its study.
    #[must_use]
    pub const fn ranking(self, primary: Primary) -> Self {
        Self { primary, ..self }
    }

    /// The same figure, which a case that ended well may lack for this reason.
    #[must_use]
    pub const fn or(self, absent: &'static str) -> Self {
        Self { absent, ..self }
    }

    /// Whether its scope fits its kind: a time covers something, and nothing else does.
    #[must_use]
    pub fn has_scope_of_its_kind(&self) -> bool {
        (self.kind == Kind::Time) != self.scope.is_empty()
    }

    /// What a time is read from, which its name has before its unit; `None` for a figure that is no time, or is
    /// made of one.
    #[must_use]
    pub fn timer(&self) -> Option<Timer> {
        match self.name.rsplit('_').nth(1)? {
            "gpu" => Some(Timer::Gpu),
            "cpu" => Some(Timer::ProcessCpu),
            "wall" => Some(Timer::Wall),
            _ => None,
        }
    }

    /// A figure that is better when it is smaller.
    #[must_use]
    pub const fn less(
        name: &'static str,
        unit: &'static str,
        kind: Kind,
        meaning: &'static str,
    ) -> Self {
        Self {
            better: Direction::Less,
            ..Self::neither(name, unit, kind, meaning)
        }
    }

    /// A time in milliseconds.
    #[must_use]
    pub const fn time_ms(name: &'static str, meaning: &'static str) -> Self {
        Self::less(name, "ms", Kind::Time, meaning)
    }

    /// Bytes, of which fewer are better.
    #[must_use]
    pub const fn bytes(name: &'static str, meaning: &'static str) -> Self {
        Self::less(name, "bytes", Kind::Bytes, meaning)
    }

    /// A count of which less is better.
    #[must_use]
    pub const fn counter(name: &'static str, meaning: &'static str) -> Self {
        Self::less(name, "", Kind::Counter, meaning)
    }

    /// A count that describes its case.
    #[must_use]
    pub const fn quantity(name: &'static str, meaning: &'static str) -> Self {
        Self::neither(name, "", Kind::Counter, meaning)
    }

    /// A difference from the reference.
    #[must_use]
    pub const fn error(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self::less(name, unit, Kind::Error, meaning)
    }

    /// A difference from the reference in pixels.
    #[must_use]
    pub const fn error_px(name: &'static str, meaning: &'static str) -> Self {
        Self::error(name, "px", meaning)
    }

    /// A figure that describes its case.
    #[must_use]
    pub const fn neither(
        name: &'static str,
        unit: &'static str,
        kind: Kind,
        meaning: &'static str,
    ) -> Self {
        Self {
            name,
            unit,
            kind,
            better: Direction::Neither,
            meaning,
            scope: Scope::NOTHING,
            primary: Primary::No,
            absent: NOT_MEASURED,
        }
    }
}

impl Metric {
    /// The declaration of this name: chapters read by constants made so, and a name that the study did
    /// not declare does not compile.
    ///
    /// # Panics
    /// Where no metric of `declared` has the name.
    #[must_use]
    pub const fn of(declared: &'static [Self], name: &str) -> &'static Self {
        let mut at = 0;
        while at < declared.len() {
            if is_same(declared[at].name, name) {
                return &declared[at];
            }
            at += 1;
        }
        panic!("no declared metric has this name")
    }
}

/// `==`, which constants cannot use on texts.
const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

impl From<&'static Metric> for &'static str {
    fn from(metric: &'static Metric) -> Self {
        metric.name
    }
}

impl From<&Metric> for String {
    fn from(metric: &Metric) -> Self {
        metric.name.to_owned()
    }
}

impl AsRef<str> for Metric {
    fn as_ref(&self) -> &str {
        self.name
    }
}

/// A row of `metrics.csv`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MetricRow {
    /// See [`Metric::name`].
    pub name: String,
    /// See [`Metric::unit`].
    pub unit: String,
    /// See [`Metric::kind`].
    pub kind: Kind,
    /// See [`Metric::better`].
    pub better: Direction,
    /// See [`Metric::meaning`].
    pub meaning: String,
    /// See [`Metric::primary`]; nothing in runs that are older than the mark.
    #[serde(default, skip_serializing_if = "Primary::is_no")]
    pub primary: Primary,
    /// See [`Metric::scope`], as `upload+draw`; empty in runs that are older.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub scope: String,
}

impl MetricRow {
    /// A row of the table, where every column has a cell.
    pub(crate) fn cells(&self) -> (&str, &str, Kind, Direction, &str, Primary, &str) {
        let Self {
            name,
            unit,
            kind,
            better,
            meaning,
            primary,
            scope,
        } = self;
        (name, unit, *kind, *better, meaning, *primary, scope)
    }
}

impl From<&Metric> for MetricRow {
    fn from(metric: &Metric) -> Self {
        Self {
            name: metric.name.to_owned(),
            unit: metric.unit.to_owned(),
            kind: metric.kind,
            better: metric.better,
            meaning: metric.meaning.to_owned(),
            primary: metric.primary,
            scope: metric.scope.to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const METRICS: [Metric; 2] = [
        Metric::less("cost_ms", "ms", Kind::Time, "Cost."),
        Metric::less("cost", "", Kind::Counter, "Cost."),
    ];

    #[test]
    fn the_name_of_a_time_says_what_it_is_read_from() {
        let timer = |name| Metric::less(name, "ms", Kind::Time, "Cost.").timer();
        assert_eq!(timer("cost_gpu_ms"), Some(Timer::Gpu));
        assert_eq!(timer("cost_cpu_us"), Some(Timer::ProcessCpu));
        assert_eq!(timer("cost_wall_ms"), Some(Timer::Wall));
        assert_eq!(timer("cpu_ns"), Some(Timer::ProcessCpu));
        for none in ["cost_ms", "cost_cpu", "cpu_ms_of_cost", "ms"] {
            assert_eq!(timer(none), None, "{none}");
        }
    }

    #[test]
    fn a_metric_is_found_by_its_whole_name() {
        const COST: &Metric = Metric::of(&METRICS, "cost");
        assert_eq!(COST, &METRICS[1]);
        assert_eq!(Metric::of(&METRICS, "cost_ms"), &METRICS[0]);
        for other in ["cos", "cost_", "cost_ns", ""] {
            let found = std::panic::catch_unwind(|| Metric::of(&METRICS, other));
            assert!(found.is_err(), "{other:?}");
        }
    }
}
