// SPDX-License-Identifier: MIT OR Apache-2.0
//! Changes in series of figures over commits: exact ones, steps of times, and slow drift.
//!
//! A figure that is exact has changed wherever it differs from the commit before. A time has a step
//! where all of these hold, and a drift by the same rules of its line. There are enough commits; the
//! change is of the floor's size and several times the series' own scatter; the sides hardly overlap.
//! And a rank test's probability is a discovery among all tests of all series. The commit of a step is
//! the one that leaves the least absolute residuals. Its probability counts every place that it might
//! have had (Bonferroni). Whether steps or a line tell a series better, an information criterion
//! decides.
//!
//! Times of different jobs are not paired: what moved may be the machine. So all of it is advisory.

use crate::rank::{Nulls, discoveries, separation, slope};
use crate::threshold::{
    FALSE_DISCOVERY_RATE, FLOOR_PERCENT, MAX_POINTS, MIN_POINTS, MIN_RESIDUALS, MIN_SEPARATION,
    MIN_SIDE,
};
use serde::Serialize;
use terrafill_results::{Direction, MetricRow, median};

/// A figure of a case on one kind of machine, commit by commit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Number of the machine in the store.
    pub machine: i64,
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Which figure.
    pub metric: MetricRow,
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

/// How a series changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeKind {
    /// A figure without noise differs from the commit before.
    Exact,
    /// A time is longer or shorter from one commit on.
    Step,
    /// A time grows or shrinks from commit to commit.
    Drift,
}

/// One change of one series.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Number of the machine in the store.
    pub machine: i64,
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Which figure.
    pub metric: String,
    /// Its unit.
    pub unit: String,
    /// How it changed.
    pub kind: ChangeKind,
    /// Last commit before the change; of a drift the first one of the series.
    pub good: String,
    /// First commit with the change; of a drift the last one of the series.
    pub bad: String,
    /// Figure before: of a step the median of its side, of a drift the line's start.
    pub from: f64,
    /// Figure after.
    pub to: f64,
    /// Whether it is for the better; `None` for a figure that is neither good nor bad.
    pub is_better: Option<bool>,
    /// Probability of such a series without any change; `None` for an exact figure.
    pub probability: Option<f64>,
    /// Place of the last commit before, among the points of the series.
    #[serde(skip)]
    pub at: usize,
}

impl Change {
    /// Change in percent of the figure before; `None` from 0.
    #[must_use]
    pub fn percent(&self) -> Option<f64> {
        let percent = 100.0 * (self.to / self.from - 1.0);
        percent.is_finite().then_some(percent)
    }
}

/// What a look at many series found.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Changes {
    /// By machine, case, metric and commit.
    pub changes: Vec<Change>,
    /// Series of exact figures with two commits or more.
    pub exact: usize,
    /// Series of times in which changes were looked for.
    pub times: usize,
    /// Series of times with too few commits.
    pub too_short: usize,
    /// Tests that share the rate of false discoveries.
    pub tests: usize,
}

/// Looks for changes in every series.
#[must_use]
pub fn changes(all: &[Series]) -> Changes {
    let mut found = Changes::default();
    let mut tests = Vec::new();
    let mut nulls = Nulls::default();
    for series in all {
        if series.metric.kind.is_exact() {
            found.exact += usize::from(series.points.len() > 1);
            found.changes.extend(exact_changes(series));
            continue;
        }
        let usable = usable(series);
        if usable.len() < MIN_POINTS {
            found.too_short += 1;
            continue;
        }
        found.times += 1;
        look(series, &usable, &mut nulls, &mut tests);
    }
    found.tests = tests.len();
    let probabilities: Vec<f64> = tests.iter().map(|(p, _)| *p).collect();
    let discovered = discoveries(&probabilities, FALSE_DISCOVERY_RATE);
    let named = tests.into_iter().zip(discovered);
    let named = named.filter_map(|((_, change), discovered)| change.filter(|_| discovered));
    found.changes.extend(named);
    let key = |change: &Change| {
        let Change {
            machine,
            case,
            metric,
            at,
            ..
        } = change;
        (*machine, case.clone(), metric.clone(), *at)
    };
    found.changes.sort_by_key(key);
    found
}

fn is_better(metric: &MetricRow, from: f64, to: f64) -> Option<bool> {
    match metric.better {
        Direction::Less => Some(to < from),
        Direction::More => Some(to > from),
        Direction::Neither => None,
    }
}

/// A change between two points of a series.
fn change(
    series: &Series,
    kind: ChangeKind,
    [good, bad]: [usize; 2],
    [from, to]: [f64; 2],
) -> Change {
    Change {
        machine: series.machine,
        case: series.case.clone(),
        metric: series.metric.name.clone(),
        unit: series.metric.unit.clone(),
        kind,
        good: series.points[good].commit.clone(),
        bad: series.points[bad].commit.clone(),
        from,
        to,
        is_better: is_better(&series.metric, from, to),
        probability: None,
        at: good,
    }
}

fn exact_changes(series: &Series) -> Vec<Change> {
    let pairs = series.points.windows(2).enumerate();
    let differ = pairs.filter(|(_, pair)| pair[0].value.to_bits() != pair[1].value.to_bits());
    differ
        .map(|(at, pair)| {
            let values = [pair[0].value, pair[1].value];
            change(series, ChangeKind::Exact, [at, at + 1], values)
        })
        .collect()
}

/// Places of the newest points that are times, with their logarithms: changes of times are factors.
fn usable(series: &Series) -> Vec<(usize, f64)> {
    let points = series.points.iter().enumerate();
    let usable = points.filter(|(_, point)| point.value.is_finite() && point.value > 0.0);
    let mut usable: Vec<(usize, f64)> = usable.map(|(at, p)| (at, p.value.ln())).collect();
    usable.drain(..usable.len().saturating_sub(MAX_POINTS));
    usable
}

/// A probability, and the change that it would be were it a discovery.
type Test = (f64, Option<Change>);

/// Tests the whole series for steps and for a drift. What both could be is what tells more by fewer
/// numbers.
fn look(series: &Series, usable: &[(usize, f64)], nulls: &mut Nulls, tests: &mut Vec<Test>) {
    let values: Vec<f64> = usable.iter().map(|(_, value)| *value).collect();
    let mut splits = Vec::new();
    split(&values, 0, nulls, &mut splits);
    let boundaries = boundaries(&values, &splits);
    let levels = Levels::between(&values, boundaries.iter().map(|split| split.at));
    let line = Line::through(&values);
    // A single step that is too small to be named is still no drift.
    let single = splits
        .first()
        .map(|split| Levels::between(&values, [split.at].into_iter()));
    let single = single.map_or(f64::INFINITY, |of| {
        information(of.residuals, 3, values.len())
    });
    let steps = information(levels.residuals, 2 * boundaries.len() + 1, values.len()).min(single);
    let is_line = line
        .as_ref()
        .is_some_and(|line| information(line.residuals, 2, values.len()) < steps);
    if let Some(line) = line {
        let p = nulls.order(&values);
        let drift = (is_line && line.counts(&values)).then(|| {
            let ends = [usable[0].0, usable[usable.len() - 1].0];
            Change {
                probability: Some(p),
                ..change(series, ChangeKind::Drift, ends, line.ends.map(f64::exp))
            }
        });
        tests.push((p, drift));
    }
    for split in &splits {
        let place = boundaries.iter().position(|kept| kept.at == split.at);
        let step = place.filter(|_| !is_line).map(|place| {
            let around = [usable[split.at - 1].0, usable[split.at].0];
            let medians = [levels.medians[place], levels.medians[place + 1]];
            Change {
                probability: Some(split.probability),
                ..change(series, ChangeKind::Step, around, medians.map(f64::exp))
            }
        });
        tests.push((split.probability, step));
    }
}

/// Information criterion of a model with Laplace residuals (Schwarz, 1978): less is better.
fn information(residuals: f64, numbers: usize, values: usize) -> f64 {
    let n = values as f64;
    // Identical values leave no residuals, which is better than any.
    2.0 * n * (residuals / n).max(f64::MIN_POSITIVE).ln() + numbers as f64 * n.ln()
}

/// A place where a part of a series was tested for a step.
struct Split {
    /// First value after it.
    at: usize,
    /// That its two sides differ by chance, for every place that it might have had.
    probability: f64,
}

/// Tests the values, of which the first is the series' `start`th, for a step, and both sides of one that
/// may be real for more.
fn split(values: &[f64], start: usize, nulls: &mut Nulls, splits: &mut Vec<Split>) {
    if values.len() < MIN_POINTS {
        return;
    }
    let places = MIN_SIDE..=values.len() - MIN_SIDE;
    let tests = places.clone().count() as f64;
    let best = places
        .map(|at| (at, Levels::between(values, [at].into_iter()).residuals))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((at, _)) = best else {
        return;
    };
    let (before, after) = values.split_at(at);
    let probability = (nulls.groups(before, after) * tests).min(1.0);
    splits.push(Split {
        at: start + at,
        probability,
    });
    if probability <= FALSE_DISCOVERY_RATE {
        split(before, start, nulls, splits);
        split(after, start + at, nulls, splits);
    }
}

/// The splits between levels that differ by more than the floor and their scatter, in order. One that
/// does not is taken away, and its neighbours are looked at again.
fn boundaries<'a>(values: &[f64], splits: &'a [Split]) -> Vec<&'a Split> {
    let real = splits
        .iter()
        .filter(|split| split.probability <= FALSE_DISCOVERY_RATE);
    let mut kept: Vec<&Split> = real.collect();
    kept.sort_by_key(|split| split.at);
    loop {
        let ends = |place: usize| {
            let start = if place == 0 { 0 } else { kept[place - 1].at };
            let end = kept.get(place + 1).map_or(values.len(), |next| next.at);
            (&values[start..kept[place].at], &values[kept[place].at..end])
        };
        let is_small = |place: &usize| {
            let (before, after) = ends(*place);
            !differ(before, after)
        };
        match (0..kept.len()).find(is_small) {
            Some(place) => {
                kept.remove(place);
            }
            None => return kept,
        }
    }
}

/// Whether two levels differ by more than the floor and their scatter, and hardly overlap.
fn differ(before: &[f64], after: &[f64]) -> bool {
    let Some((low, high)) = median(before).zip(median(after)) else {
        return false;
    };
    let size = (high - low).abs();
    let scatter: Vec<f64> = distances(before, low)
        .chain(distances(after, high))
        .collect();
    size >= floor()
        && size >= MIN_RESIDUALS * median(&scatter).unwrap_or(f64::INFINITY)
        && separation(before, after) >= MIN_SEPARATION
}

/// A series as levels, in logarithms.
struct Levels {
    medians: Vec<f64>,
    /// Sum of absolute residuals.
    residuals: f64,
}

impl Levels {
    fn between(values: &[f64], boundaries: impl Iterator<Item = usize>) -> Self {
        let mut levels = Self {
            medians: Vec::new(),
            residuals: 0.0,
        };
        let mut start = 0;
        for end in boundaries.chain([values.len()]) {
            let part = &values[start..end];
            let middle = median(part).unwrap_or(f64::NAN);
            levels.residuals += distances(part, middle).sum::<f64>();
            levels.medians.push(middle);
            start = end;
        }
        levels
    }
}

/// A series as a line over its commits, in logarithms.
struct Line {
    /// At the first and at the last commit.
    ends: [f64; 2],
    residuals: f64,
    scatter: f64,
}

impl Line {
    fn through(values: &[f64]) -> Option<Self> {
        let slope = slope(values)?;
        let flat = |(at, value): (usize, &f64)| value - slope * at as f64;
        let flattened: Vec<f64> = values.iter().enumerate().map(flat).collect();
        let start = median(&flattened)?;
        let residuals: Vec<f64> = distances(&flattened, start).collect();
        Some(Self {
            ends: [start, start + slope * (values.len() - 1) as f64],
            residuals: residuals.iter().sum(),
            scatter: median(&residuals)?,
        })
    }

    /// The last third differs from the first as the line does, so that no end alone makes a drift.
    fn counts(&self, values: &[f64]) -> bool {
        let third = values.len() / 3;
        let (first, last) = (&values[..third], &values[values.len() - third..]);
        let thirds = median(last)
            .zip(median(first))
            .map_or(0.0, |(last, first)| last - first);
        let size = self.ends[1] - self.ends[0];
        size.abs() >= floor()
            && size.abs() >= MIN_RESIDUALS * self.scatter
            && thirds * size.signum() >= floor() / 2.0
            && separation(first, last) >= MIN_SEPARATION
    }
}

fn floor() -> f64 {
    (FLOOR_PERCENT / 100.0).ln_1p()
}

fn distances(values: &[f64], from: f64) -> impl Iterator<Item = f64> {
    values.iter().map(move |value| (value - from).abs())
}

#[cfg(test)]
mod tests;
