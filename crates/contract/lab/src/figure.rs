// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where figures of a case come from, and what names it.

use crate::cases::{Cases, measured};
use terrafill_results::{Case, Cell, Clock, ConditionKey, Estimate, Heading, Metric};

/// Where a figure comes from.
#[derive(Debug, Clone, Copy)]
pub enum Figure {
    /// A metric.
    Metric(&'static Metric),
    /// The first in runs that compare GPU times, else the second.
    ByClock(&'static Metric, &'static Metric),
    /// The same with the range of 5 to 95 % of its samples.
    Samples(&'static Metric, &'static Metric),
    /// A condition that is a number.
    Condition(ConditionKey),
    /// Made of several.
    Computed(fn(&Case) -> Option<f64>),
    /// No figure but words.
    Words(fn(&Case) -> Option<String>),
    /// How many times as much as another case of its section it takes.
    Beside(fn(&Cases<'_>, &Case) -> Option<Estimate>),
}

impl Figure {
    /// Its metric in a run.
    #[must_use]
    pub fn metric(self, clock: Clock) -> Option<&'static Metric> {
        match self {
            Self::Metric(metric) => Some(metric),
            Self::ByClock(gpu, cpu) | Self::Samples(gpu, cpu) => Some(clock.pick(gpu, cpu)),
            Self::Condition(_) | Self::Computed(_) | Self::Words(_) | Self::Beside(_) => None,
        }
    }

    /// What a case has of it.
    #[must_use]
    pub fn of(self, case: &Case, clock: Clock) -> Option<f64> {
        match self {
            Self::Metric(_) | Self::ByClock(..) | Self::Samples(..) => {
                measured(case, self.metric(clock)?)
            }
            Self::Condition(key) => case.condition(key).parse().ok(),
            Self::Computed(of) => of(case),
            Self::Words(_) | Self::Beside(_) => None,
        }
    }
}

/// What names a row, or a curve.
#[derive(Debug, Clone, Copy)]
pub enum Names<'a> {
    /// Values of conditions in one column; those that a case has not are left out.
    Joined(&'a [ConditionKey]),
    /// A column a condition, each with its heading.
    Columns(&'a [(&'a str, ConditionKey)]),
    /// One column with a heading, its texts by the case.
    Of(&'a str, fn(&Case) -> String),
}

impl Names<'_> {
    /// In one text.
    #[must_use]
    pub fn text(&self, case: &Case) -> String {
        let values: Vec<&str> = match self {
            Self::Joined(keys) => keys.iter().map(|key| case.condition(*key)).collect(),
            Self::Columns(keys) => keys.iter().map(|(_, key)| case.condition(*key)).collect(),
            Self::Of(_, of) => return of(case),
        };
        let values: Vec<&str> = values.into_iter().filter(|text| !text.is_empty()).collect();
        values.join(", ")
    }

    pub(crate) fn headings(&self) -> Vec<Heading> {
        match self {
            Self::Joined(keys) => {
                let names = keys.iter().map(|key| key.name().replace('_', " "));
                vec![Heading::plain(names.collect::<Vec<_>>().join(", "))]
            }
            Self::Columns(keys) => keys.iter().map(|(text, _)| Heading::plain(*text)).collect(),
            Self::Of(heading, _) => vec![Heading::plain(*heading)],
        }
    }

    pub(crate) fn cells(&self, case: &Case) -> Vec<Cell> {
        match self {
            Self::Columns(keys) => {
                let values = keys.iter().map(|(_, key)| case.condition(*key));
                values.map(Cell::name).collect()
            }
            _ => vec![Cell::name(self.text(case))],
        }
    }
}
