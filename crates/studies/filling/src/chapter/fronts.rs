// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against cost, one panel a scene: the sum over the scene's views, by each clock and by work.

use super::data::{Data, ViewCases, label, marked};
use crate::keys::*;
use terrafill_lab::{in_every_group, sums_by_process};
use terrafill_plot::{FrontPanel, FrontPoint, Fronts};
use terrafill_results::{Block, Case, ChapterError, Choice, Metric};

/// Costs of a fill: name and metric. No noise reaches the last.
const COSTS: [(&str, &Metric); 4] = [
    ("process CPU ms", FILL_CPU_MS),
    ("GPU ms", FILL_GPU_MS),
    ("wall-clock ms", FILL_WALL_MS),
    ("stencil-tested fragments", STENCIL_FRAGMENTS),
];

/// The plot by each cost that was measured, that of the run's clock first.
pub(super) fn block(data: &Data<'_>) -> Result<Option<Block>, ChapterError> {
    let mut costs = COSTS;
    costs.sort_by_key(|(_, metric)| *metric != data.timings.metric);
    let mut ways = Vec::new();
    for (name, metric) in costs {
        let scenes = data.scenes().into_iter();
        let plot = Fronts {
            title: format!("error against {name}"),
            across: name,
            up: "mismatched pixels",
            area: "bytes of geometry",
            panels: scenes
                .map(|(scene, views)| panel(data, scene, &views, metric))
                .collect(),
        };
        let caption = format!(
            "Mismatched pixels against {name}, both summed over the scene's views, for every fill that is right in \
             all of them; left and low is better. Area of a marker: bytes of geometry; its command draws the \
             scene's first view. Dashed: the Pareto front of the medians; ringed: kept there by at least 95 % of \
             the resamples of five or more processes."
        );
        let plot = Block::plot(caption, plot.draw(data.palette())?);
        ways.extend(plot.map(|plot| (name.to_owned(), vec![plot])));
    }
    Ok((!ways.is_empty()).then(|| {
        Block::Choice(Choice {
            caption: "Error against cost, by".to_owned(),
            ways,
        })
    }))
}

fn panel(data: &Data<'_>, scene: &str, views: &[&ViewCases<'_>], metric: &Metric) -> FrontPanel {
    let of_views = views.iter().map(|view| {
        let right = view.competing().filter(|case| case.counts());
        right.collect()
    });
    let fills = in_every_group(&of_views.collect::<Vec<_>>(), label).into_iter();
    let points = fills.filter_map(|(name, cases)| point(data, name, &cases, metric));
    FrontPanel {
        name: scene.to_owned(),
        points: points.collect(),
    }
}

/// `None` unless every view's case has the cost and the error.
fn point(data: &Data<'_>, name: String, cases: &[&Case], metric: &Metric) -> Option<FrontPoint> {
    let first = *cases.first()?;
    let sum = |metric: &Metric| {
        let values = cases.iter().map(|case| case.value(metric));
        values.sum::<Option<f64>>()
    };
    let sizes = cases.iter().filter_map(|case| case.value(GEOMETRY_BYTES));
    Some(FrontPoint {
        series: marked(first),
        name,
        cost: sum(metric).filter(|cost| *cost > 0.0)?,
        costs: sums_by_process(cases, metric).into_values().collect(),
        error: sum(MISMATCHED_PX)?,
        bytes: sizes.fold(0.0, f64::max),
        command: data.command(first),
    })
}
