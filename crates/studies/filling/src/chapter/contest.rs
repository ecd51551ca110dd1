// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills that compete: in a view, and over all views.

use super::budget::held_bytes;
use super::data::{Data, ViewCases, label};
use crate::keys::*;
use terrafill_conformance::MAX_ROUNDED_PX;
use terrafill_lab::in_every_group;
use terrafill_results::{Case, Metric};

/// Fills that compete in a view, fastest first.
pub(super) struct Contest<'d, 'a> {
    pub(super) view: &'d ViewCases<'a>,
    pub(super) fills: Vec<&'a Case>,
}

impl<'d, 'a> Contest<'d, 'a> {
    pub(super) fn new(data: &Data<'a>, view: &'d ViewCases<'a>) -> Self {
        let timed = view.competing();
        let timed = timed.filter_map(|case| Some((case, data.timings.typical(case)?.middle)));
        let mut timed: Vec<(&Case, f64)> = timed.collect();
        timed.sort_by(|a, b| a.1.total_cmp(&b.1));
        let fills = timed.into_iter().map(|(case, _)| case).collect();
        Self { view, fills }
    }

    /// Typical time of one of its fills over that of the fastest.
    pub(super) fn over_fastest(&self, data: &Data<'_>, fill: &Case) -> Option<f64> {
        let over = data.timings.over_fastest(fill, self.fills.first()?)?;
        Some(over.middle)
    }

    /// Every fill of a view draws the same regions; the first one that counted stands for all.
    pub(super) fn counted(&self, metric: &Metric) -> Option<f64> {
        self.fills.iter().find_map(|fill| fill.value(metric))
    }

    pub(super) fn fragments_a_vertex(&self) -> Option<f64> {
        let vertices = self.counted(VERTICES).filter(|vertices| *vertices > 0.0)?;
        Some(self.counted(STENCIL_FRAGMENTS)? / vertices)
    }
}

/// A fill that is right in all of some views.
pub(super) struct Ranked<'a> {
    pub(super) name: String,
    /// A case for each view.
    pub(super) cases: Vec<&'a Case>,
    /// Its time over that of each view's best.
    pub(super) ratios: Vec<f64>,
    /// Their geometric mean.
    pub(super) mean: f64,
    /// The largest of them.
    pub(super) most: f64,
}

impl Ranked<'_> {
    /// The largest of a figure over the views; `None` where one has none.
    pub(super) fn most_of(&self, metric: &Metric) -> Option<f64> {
        let figures = self.cases.iter().map(|case| case.value(metric));
        let figures: Option<Vec<f64>> = figures.collect();
        figures?.into_iter().reduce(f64::max)
    }

    /// All that it holds on the device in the view where that is most; `None` where one does not count it.
    pub(super) fn held_bytes(&self) -> Option<f64> {
        let held = self.cases.iter().map(|case| held_bytes(case));
        let held: Option<Vec<f64>> = held.collect();
        held?.into_iter().reduce(f64::max)
    }

    /// By how much levels of detail move boundaries at most, pixels; `None` where none is moved on purpose.
    pub(super) fn moved_px(&self) -> Option<f64> {
        let moved = self
            .cases
            .iter()
            .filter_map(|case| case.value(BOUNDARY_MOVED_PX));
        moved.filter(|px| *px > MAX_ROUNDED_PX).reduce(f64::max)
    }
}

/// By the mean of how much longer they take than the best.
pub(super) fn ranked<'a>(data: &Data<'a>, contests: &[&Contest<'_, 'a>]) -> Vec<Ranked<'a>> {
    let fills = contests.iter().map(|contest| contest.fills.clone());
    let fills = in_every_group(&fills.collect::<Vec<_>>(), label).into_iter();
    let ranked = fills.filter_map(|(name, cases)| {
        let ratios = contests.iter().zip(&cases);
        let ratios = ratios.map(|(contest, case)| contest.over_fastest(data, case));
        let ratios: Vec<f64> = ratios.collect::<Option<_>>()?;
        let logs = ratios.iter().map(|ratio| ratio.ln());
        Some(Ranked {
            name,
            cases,
            mean: (logs.sum::<f64>() / ratios.len() as f64).exp(),
            most: ratios.iter().copied().fold(0.0, f64::max),
            ratios,
        })
    });
    let mut ranked: Vec<Ranked<'_>> = ranked.collect();
    ranked.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    ranked
}

/// The first and those that tie with it, by the mean.
pub(super) fn tied<'r, 'a>(data: &Data<'_>, ranked: &'r [Ranked<'a>]) -> &'r [Ranked<'a>] {
    let Some(first) = ranked.first() else {
        return ranked;
    };
    let is_tie = |fill: &Ranked<'_>| data.timings.is_tie(fill.mean / first.mean);
    let others = ranked[1..].iter().take_while(|fill| is_tie(fill));
    &ranked[..=others.count()]
}
