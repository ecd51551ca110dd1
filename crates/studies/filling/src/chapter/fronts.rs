// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against cost, one panel a scene: the sum over the scene's views, by each clock and by work.

use super::data::{Data, View, counter, distinct};
use super::table;
use crate::keys::*;
use terrafill_plot::{FrontPanel, FrontPoint, Fronts};
use terrafill_results::{Block, Case, ChapterError, Choice, Metric, process_medians};

/// Costs of a fill other than its time by the run's clock: name and metric.
const COSTS: [(&str, &Metric); 4] = [
    ("process CPU ms", FILL_CPU_MS),
    ("GPU ms", FILL_GPU_MS),
    ("wall-clock ms", FILL_WALL_MS),
    ("stencil-tested fragments", WORK),
];

/// Work that no noise reaches.
const WORK: &Metric = STENCIL_FRAGMENTS;

const UP: &str = "mismatched pixels";

/// The plot by the run's clock and by work, for the first page.
pub(super) fn block(data: &Data<'_>) -> Result<Option<Block>, ChapterError> {
    choice(data, |metric| [data.metric, WORK].contains(&metric))
}

/// The plot by every cost that was measured, where there are more than the first page shows.
pub(super) fn section(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let all = choice(data, |_| true)?;
    let all = all.filter(|block| matches!(block, Block::Choice(choice) if choice.ways.len() > 2));
    Ok(all.map_or_else(Vec::new, |all| {
        vec![Block::section("Error against cost"), all]
    }))
}

/// The plot by each of these costs that was measured, that of the run's clock first.
fn choice(
    data: &Data<'_>,
    is_wanted: impl Fn(&Metric) -> bool,
) -> Result<Option<Block>, ChapterError> {
    let mut costs = COSTS;
    costs.sort_by_key(|(_, metric)| *metric != data.metric);
    let mut ways = Vec::new();
    for (name, metric) in costs.into_iter().filter(|(_, metric)| is_wanted(metric)) {
        let plot = Fronts {
            title: format!("error against {name}"),
            across: name,
            up: UP,
            area: "bytes of geometry",
            panels: data
                .scenes()
                .map(|views| panel(data, views, metric))
                .collect(),
        };
        let plot = table::plot(caption(name), plot.draw(data.palette())?);
        ways.extend(plot.map(|plot| (name.to_owned(), vec![plot])));
    }
    Ok((!ways.is_empty()).then(|| {
        Block::Choice(Choice {
            caption: "Error against cost, by".to_owned(),
            ways,
        })
    }))
}

fn caption(cost: &str) -> String {
    format!(
        "Mismatched pixels against {cost}, both summed over the scene's views, for every fill that is \
         right in all of them; left and low is better. Area of a marker: bytes of geometry; its \
         command draws the scene's first view. Dashed: the \
         Pareto front of the medians; ringed: kept there by at least 95 % of the resamples of five or \
         more processes."
    )
}

fn panel(data: &Data<'_>, views: &[View<'_>], metric: &Metric) -> FrontPanel {
    let cases = views.iter().flat_map(View::competing);
    let names = distinct(cases.map(|case| data.label(case)));
    let points = names.into_iter().filter_map(|name| {
        let of_views = views.iter().map(|view| {
            let mut own = view.competing();
            own.find(|case| data.label(case) == name && case.counts())
        });
        let of_views: Option<Vec<&Case>> = of_views.collect();
        point(data, name, &of_views?, metric)
    });
    FrontPanel {
        name: views[0].scene.to_owned(),
        points: points.collect(),
    }
}

/// `None` unless every view's case has the cost and the error.
fn point(data: &Data<'_>, name: String, cases: &[&Case], metric: &Metric) -> Option<FrontPoint> {
    let medians = cases.iter().map(|case| process_medians(case, metric));
    let medians: Vec<_> = medians.collect();
    let value = |case: &&Case| match metric == data.metric {
        // As it ranks fills.
        true => Some(data.typical(case)?.middle),
        false => case.value(metric),
    };
    let costs: Option<Vec<f64>> = cases.iter().map(value).collect();
    let errors: Option<Vec<f64>> = cases.iter().map(|case| case.value(MISMATCHED_PX)).collect();
    // A process counts where it measured all views.
    let first = medians.first()?.keys();
    let sums = first.filter_map(|process| medians.iter().map(|own| own.get(process)).sum());
    let cost: f64 = costs?.iter().sum();
    let sizes = cases
        .iter()
        .filter_map(|case| counter(case, GEOMETRY_BYTES));
    (cost > 0.0).then_some(FrontPoint {
        series: data.marked(cases.first()?),
        name,
        cost,
        costs: sums.collect(),
        error: errors?.iter().sum(),
        bytes: sizes.max().unwrap_or(0),
        command: data.command(cases.first()?),
    })
}
