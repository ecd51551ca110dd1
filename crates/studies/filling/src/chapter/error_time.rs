// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time of one view: two panels side by side, wrong pixels and error of the boundary.
//!
//! One curve per layout through its knob, the boundary tolerance. A wrong case whose error is the
//! question stands where its figures put it; any other wrong or failed case stands on the edge.

use super::data::{Data, ViewCases, grouped, knob_m, series, setting, standing};
use crate::keys::{BOUNDARY_DEVIATION_M, MISMATCHED_PX};
use crate::purpose::{Purpose, is_approximate};
use terrafill_plot::{
    Arrangement, Curve, Point, PointStanding, Reading, Upwards, WorkPrecision, length, panels,
};
use terrafill_results::{Block, Case, ChapterError, Metric, Outcome};

const CAPTION: &str = "Error against run time; one curve per layout through its boundary tolerance, which labels the \
    points. Zero errors stand on the line at the bottom; wrong and failed cases (crosses) are pinned to the upper \
    edge, except those whose error is the question, which stand at it; open marks are approximate fills. Ringed and \
    joined by dashes: the Pareto front, where at least 95 % of bootstrap resamples of the processes keep it.";

/// Every fill of a view; nothing when neither panel would hold a point.
pub(super) fn of_view(
    data: &Data<'_>,
    view: &ViewCases<'_>,
) -> Result<Option<Block>, ChapterError> {
    let title = format!("{}: error against run time", view.title());
    let across = format!("fill, {}: median, 5–95 % of samples", data.timings.unit());
    let panel = |title, up, metric| WorkPrecision {
        title,
        across: &across,
        up,
        upwards: Upwards::Error,
        curves: curves(data, view, metric),
        lines: Vec::new(),
    };
    let plots = [
        panel(
            "Error against the reference",
            "mismatched pixels",
            MISMATCHED_PX,
        ),
        panel(
            "Error of the drawn boundary",
            "boundary deviation, m",
            BOUNDARY_DEVIATION_M,
        ),
    ];
    let svg = panels(&title, &plots, Arrangement::SideBySide, data.palette())?;
    Ok(Block::plot(CAPTION, svg))
}

/// The cases as curves, one for each layout.
pub(super) fn curves(data: &Data<'_>, view: &ViewCases<'_>, metric: &Metric) -> Vec<Curve> {
    let shown = view.cases.iter().filter(|case| match case.outcome {
        Outcome::Ok => data.timings.samples(case).is_some() && case.value(metric).is_some(),
        Outcome::Wrong | Outcome::Failed => true,
        Outcome::Skipped | Outcome::Missing | Outcome::DriverFault => false,
    });
    let curves = grouped(shown, |case| series(case)).into_iter();
    let curves = curves.map(|(name, cases)| {
        let points = cases.iter().map(|case| point(data, view, case, metric));
        Curve {
            name,
            points: points.collect(),
        }
    });
    let mut curves: Vec<Curve> = curves.collect();
    curves.sort_by(|a, b| a.name.cmp(&b.name));
    curves
}

/// A case by its time and an error. Its label is its setting or the knob's value, and what went wrong where something did.
fn point(data: &Data<'_>, view: &ViewCases<'_>, case: &Case, metric: &Metric) -> Point {
    let time = |spread| Reading::sampled(spread, &data.timings.replicates(case));
    let (setting, knob) = (setting(case, view), knob_m(case));
    let label = match (setting, knob.map(length), case.outcome) {
        (Some(setting), ..) => setting.to_owned(),
        (None, Some(knob), Outcome::Ok) => knob,
        (None, Some(knob), _) if !is_approximate(case) => format!("{knob} {}", standing(case)),
        (None, None, Outcome::Ok) => "default".to_owned(),
        _ => standing(case).to_owned(),
    };
    let number = setting.and_then(|value| value.parse().ok());
    Point {
        knob: number.or(knob).unwrap_or(0.0),
        label,
        x: data.timings.samples(case).map(time),
        y: case.value(metric).map(Reading::exact),
        y_rms: None,
        standing: match case.outcome {
            _ if case.counts() => PointStanding::Right,
            Outcome::Wrong if is_approximate(case) => PointStanding::Approximate,
            Outcome::Wrong if Purpose::Sweep.is_of(case) => PointStanding::Wrong,
            _ => PointStanding::Failed,
        },
        command: data.command(case),
    }
}
