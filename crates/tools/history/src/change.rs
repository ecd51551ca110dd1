// SPDX-License-Identifier: MIT OR Apache-2.0
//! Changes in series of figures over commits: exact ones, steps of times, and slow drift.
//!
//! A figure that is exact has changed wherever it differs from the commit before. A time has a **step**
//! where one of two tests makes it a discovery among all series. The first is the step's size in units of
//! the series' own scatter, by [`Scatters`]. The second, in a history that is long enough for it, is by the
//! ranks of both sides (Mann and Whitney, 1947; times the number of places, Bonferroni). A **drift** is one
//! where the order of all values is a discovery (Mann and Kendall). Both also have the floor's size, are several times the
//! scatter around the levels or the line, and their sides hardly overlap. Whether steps or a line tell a
//! series better, an information criterion decides.
//!
//! Where each run has control passes, times are taken relative to them, so that a machine's shift is none
//! of the program's. Times of different jobs are not paired all the same: what moved may be the machine. So
//! all of it is advisory. What cannot be decided is named with the reason.

use crate::control::relative;
use crate::rank::{Nulls, discovered, separation, slope};
use crate::scatter::{Cut, Scatters, error};
use crate::series::{Followed, Series};
use crate::threshold::{
    FALSE_DISCOVERY_RATE, FLOOR_PERCENT, MAX_HIDDEN_PERCENT, MAX_POINTS, MIN_POINTS, MIN_RESIDUALS,
    MIN_SEPARATION, MIN_SIDE,
};
use serde::Serialize;
use std::collections::BTreeMap;
use terrafill_plot::number::significant;
use terrafill_results::{Direction, MetricRow, median};

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
    /// Series of times that can be decided.
    pub times: usize,
    /// Of these, taken relative to the control passes of the same runs.
    pub relative: usize,
    /// Half of the decided times find a lone step in the middle of their commits from this size on, in
    /// percent; `None` without any.
    pub finds_percent: Option<f64>,
    /// Series of times that cannot be decided, by the reason.
    pub undecided: Vec<Undecided>,
}

/// A time in which no change can be found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Undecided {
    /// Number of the machine in the store.
    pub machine: i64,
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// Which figure.
    pub metric: String,
    /// Why.
    pub reason: String,
}

/// Looks for changes in every series.
#[must_use]
pub fn changes(all: &[Series]) -> Changes {
    let mut found = Changes::default();
    let mut groups: BTreeMap<(i64, &str), Vec<Followed<'_>>> = BTreeMap::new();
    for series in all {
        if series.metric.kind.is_exact() {
            found.exact += usize::from(series.points.len() > 1);
            found.changes.extend(exact_changes(series));
            continue;
        }
        let followed = followed(series);
        let count = followed.values.len();
        if count < MIN_POINTS {
            let reason = format!("found {count} commits with a time, needs {MIN_POINTS}");
            found.undecided.push(undecided(series, reason));
            continue;
        }
        let group = groups.entry((series.machine, &series.metric.name));
        group.or_default().push(followed);
    }
    for group in groups.values_mut() {
        found.relative += relative(group);
    }
    let groups: Vec<Vec<Followed<'_>>> = groups.into_values().collect();
    look(&groups, &mut found);
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

fn undecided(series: &Series, reason: String) -> Undecided {
    Undecided {
        machine: series.machine,
        case: series.case.clone(),
        metric: series.metric.name.clone(),
        reason,
    }
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

/// The newest points that are times.
fn followed(series: &Series) -> Followed<'_> {
    let points = series.points.iter().enumerate();
    let usable = points.filter(|(_, point)| point.value.is_finite() && point.value > 0.0);
    let mut usable: Vec<(usize, f64)> = usable.map(|(at, p)| (at, p.value.ln())).collect();
    usable.drain(..usable.len().saturating_sub(MAX_POINTS));
    let (points, values) = usable.into_iter().unzip();
    Followed {
        series,
        points,
        values,
    }
}

/// Tests every series for a step and for a drift, and names what is a discovery among all.
fn look(groups: &[Vec<Followed<'_>>], found: &mut Changes) {
    let values: Vec<Vec<&[f64]>> = groups
        .iter()
        .map(|group| group.iter().map(|of| of.values.as_slice()).collect())
        .collect();
    let scatters = Scatters::of(&values);
    let all: Vec<(&Followed<'_>, f64)> = groups
        .iter()
        .flatten()
        .zip(scatters.each.iter().copied())
        .collect();
    let rate = 0.5 * FALSE_DISCOVERY_RATE;
    let mut tests = Tests {
        scatters: &scatters,
        nulls: Nulls::default(),
        alone: rate / all.len() as f64,
    };
    let steps: Vec<Option<Split>> = all
        .iter()
        .map(|(of, scatter)| tests.best(&of.values, 0, *scatter))
        .collect();
    let drifts: Vec<f64> = all
        .iter()
        .map(|(of, _)| tests.nulls.order(&of.values))
        .collect();
    let of_steps: Vec<f64> = steps
        .iter()
        .flatten()
        .map(|split| split.probability)
        .collect();
    let step_from = discovered(&of_steps, rate).unwrap_or(0.0);
    let drift_from = discovered(&drifts, rate).unwrap_or(0.0);
    let needed = scatters.size_at(tests.alone.max(step_from));
    let mut hidden = Vec::new();
    for (((of, scatter), first), drift) in all.into_iter().zip(steps).zip(drifts) {
        let mut splits = Vec::new();
        tests.split(&of.values, 0, scatter, step_from, &mut splits);
        let is_drift = drift <= drift_from;
        let named = named(of, first, &splits, is_drift.then_some(drift));
        let half = of.values.len() / 2;
        let least = needed * scatter * error(half, of.values.len() - half);
        let least = 100.0 * least.max(floor()).exp_m1();
        if named.is_empty() && least > MAX_HIDDEN_PERCENT {
            let reason = format!(
                "its scatter of {} % hides steps below {} %",
                significant(100.0 * scatter.exp_m1()),
                significant(least)
            );
            found.undecided.push(undecided(of.series, reason));
        } else {
            found.times += 1;
            hidden.push(least);
        }
        found.changes.extend(named);
    }
    found.finds_percent = median(&hidden);
}

/// What a series is named for: steps or a drift, whichever tells more by fewer numbers.
///
/// - `first`: its best split, a discovery or not
/// - `drift`: probability of its order, where it is a discovery
fn named(
    of: &Followed<'_>,
    first: Option<Split>,
    splits: &[Split],
    drift: Option<f64>,
) -> Vec<Change> {
    let Followed {
        series,
        points,
        values,
    } = of;
    let boundaries = boundaries(values, splits);
    let levels = Levels::between(values, boundaries.iter().map(|split| split.at));
    // A single step that is too small to be named is still no drift.
    let single = first.map_or(f64::INFINITY, |split| {
        let single = Levels::between(values, [split.at].into_iter());
        information(single.residuals, 3, values.len())
    });
    let steps = information(levels.residuals, 2 * boundaries.len() + 1, values.len()).min(single);
    let line = drift.and_then(|p| Some((p, Line::through(values)?)));
    let line = line.filter(|(_, line)| {
        line.counts(values) && information(line.residuals, 2, values.len()) < steps
    });
    if let Some((p, line)) = line {
        let ends = [points[0], points[points.len() - 1]];
        return vec![Change {
            probability: Some(p),
            ..change(series, ChangeKind::Drift, ends, line.ends.map(f64::exp))
        }];
    }
    let steps = boundaries.iter().enumerate().map(|(place, split)| {
        let around = [points[split.at - 1], points[split.at]];
        let medians = [levels.medians[place], levels.medians[place + 1]];
        Change {
            probability: Some(split.probability),
            ..change(series, ChangeKind::Step, around, medians.map(f64::exp))
        }
    });
    steps.collect()
}

/// Information criterion of a model with Laplace residuals (Schwarz, 1978): less is better.
fn information(residuals: f64, numbers: usize, values: usize) -> f64 {
    let n = values as f64;
    // Identical values leave no residuals, which is better than any.
    2.0 * n * (residuals / n).max(f64::MIN_POSITIVE).ln() + numbers as f64 * n.ln()
}

/// A place where a part of a series was tested for a step.
#[derive(Debug, Clone, Copy)]
struct Split {
    /// First value after it.
    at: usize,
    /// That its two sides differ by chance, for every place that it might have had.
    probability: f64,
}

/// What places are tested by.
struct Tests<'a> {
    scatters: &'a Scatters,
    nulls: Nulls,
    /// Probability from which on a lone step is a discovery.
    alone: f64,
}

impl Tests<'_> {
    /// The best place for a step in values, of which the first is the series' `start`th.
    fn best(&mut self, values: &[f64], start: usize, scatter: f64) -> Option<Split> {
        let cut = Cut::of(values)?;
        let by_scatter = self.scatters.probability(cut.size(values, scatter));
        let half = values.len() / 2;
        let places = (values.len() + 1 - 2 * MIN_SIDE) as f64;
        // Ranks of few values can find nothing among so many series: that is no test, and takes no share.
        let can_tell = 2.0 * places * self.nulls.least(half, values.len() - half) <= self.alone;
        let probability = if can_tell {
            let (before, after) = values.split_at(cut.at);
            let by_rank = places * self.nulls.groups(before, after);
            (2.0 * by_scatter.min(by_rank)).min(1.0)
        } else {
            by_scatter
        };
        Some(Split {
            at: start + cut.at,
            probability,
        })
    }

    /// Splits values at steps of at most this probability, and both sides again.
    fn split(
        &mut self,
        values: &[f64],
        start: usize,
        scatter: f64,
        from: f64,
        splits: &mut Vec<Split>,
    ) {
        let best = self.best(values, start, scatter);
        let Some(split) = best.filter(|split| split.probability <= from) else {
            return;
        };
        splits.push(split);
        let (before, after) = values.split_at(split.at - start);
        self.split(before, start, scatter, from, splits);
        self.split(after, split.at, scatter, from, splits);
    }
}

/// The splits between levels that differ by more than the floor and their scatter, in order. One that
/// does not is taken away, and its neighbours are looked at again.
fn boundaries<'a>(values: &[f64], splits: &'a [Split]) -> Vec<&'a Split> {
    let mut kept: Vec<&Split> = splits.iter().collect();
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
