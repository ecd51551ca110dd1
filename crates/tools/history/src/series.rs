// SPDX-License-Identifier: MIT OR Apache-2.0
//! A figure of a case, commit by commit.

use terrafill_results::MetricRow;

/// A figure of a case on one kind of machine, commit by commit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Number of the machine in the store.
    pub machine: i64,
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Which figure.
    pub metric: MetricRow,
    /// Whether it is of the control pass, in which no technique has a part.
    pub is_control: bool,
    /// In order of the commits.
    pub points: Vec<Point>,
}

/// A series at one commit.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Place of the commit among all of the store.
    pub place: usize,
    /// The commit.
    pub commit: String,
    /// Median over the commit's runs, in the metric's unit.
    pub value: f64,
}

/// A series of times with commits enough.
#[derive(Debug, Clone)]
pub(crate) struct Followed<'a> {
    pub(crate) series: &'a Series,
    /// The points of the series that are looked at.
    pub(crate) points: Vec<usize>,
    /// Their logarithms: changes of times are factors.
    pub(crate) values: Vec<f64>,
}
