// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time of one view: two panels side by side, wrong pixels and error of the boundary.
//!
//! One curve per layout through its knob, the boundary tolerance. A wrong case whose error is the
//! question stands where its figures put it; any other wrong or failed case stands on the edge.

use super::data::{Data, View, grouped, has_role, is_approximate, knob_m, name, setting, standing};
use super::table::plot;
use crate::keys::{BOUNDARY_DEVIATION_M, MISMATCHED_PX};
use terrafill_plot::{
    Arrangement, Curve, Point, PointStanding, Reading, Upwards, WorkPrecision, length, panels,
};
use terrafill_results::{Block, Case, ChapterError, Metric, Outcome};

/// Title, axis and metric of each panel.
const QUANTITIES: [(&str, &str, &Metric); 2] = [
    (
        "Error against the reference",
        "mismatched pixels",
        MISMATCHED_PX,
    ),
    (
        "Error of the drawn boundary",
        "boundary deviation, m",
        BOUNDARY_DEVIATION_M,
    ),
];

/// Every fill of a view; nothing when neither panel would hold a point.
pub(super) fn of_view(data: &Data<'_>, view: &View<'_>) -> Result<Option<Block>, ChapterError> {
    let title = format!("{}: error against run time", view.title());
    let across = format!("fill, {}: median, 5–95 % of samples", data.unit());
    let plots = QUANTITIES.map(|(title, up, metric)| WorkPrecision {
        title,
        across: &across,
        up,
        upwards: Upwards::Error,
        curves: curves(data, view, metric),
        lines: Vec::new(),
    });
    let svg = panels(&title, &plots, Arrangement::SideBySide, data.palette())?;
    let not_drawn = match not_drawn(data, view) {
        none if none.is_empty() => String::new(),
        some => format!(" Not drawn: {}.", some.join("; ")),
    };
    let caption = format!(
        "Error against run time; one curve per layout through its boundary tolerance, which labels the points. \
         Zero errors stand on the line at the bottom; wrong and failed cases (crosses) are pinned to the upper \
         edge, except those whose error is the question, which stand at it; open marks are approximate fills. \
         Ringed and joined by dashes: the Pareto front, where at least 95 % of bootstrap resamples of the \
         processes keep it.{not_drawn}"
    );
    Ok(plot(caption, svg))
}

/// The cases as curves, one for each layout.
pub(super) fn curves(data: &Data<'_>, view: &View<'_>, metric: &Metric) -> Vec<Curve> {
    let shown = view.cases.iter().filter(|case| match case.outcome {
        Outcome::Ok => data.time(case).is_some() && case.value(metric).is_some(),
        Outcome::Wrong | Outcome::Failed => true,
        Outcome::Skipped | Outcome::Missing | Outcome::DriverFault => false,
    });
    let mut curves = grouped(shown, |case| data.series(case));
    curves.sort_by(|a, b| a.0.cmp(&b.0));
    let curve = |(name, cases): (String, Vec<&&Case>)| Curve {
        name,
        points: cases
            .iter()
            .map(|case| point(data, view, case, metric))
            .collect(),
    };
    curves.into_iter().map(curve).collect()
}

/// A case by its time and an error.
fn point(data: &Data<'_>, view: &View<'_>, case: &Case, metric: &Metric) -> Point {
    let time = |spread| Reading::sampled(spread, &data.replicates(case));
    let setting = setting(case, view).filter(|_| is_approximate(case));
    let number = setting.and_then(|value| value.parse().ok());
    Point {
        knob: number.or(knob_m(case)).unwrap_or(0.0),
        label: setting.map_or_else(|| label(case), str::to_owned),
        x: data.time(case).map(time),
        y: case.value(metric).map(Reading::exact),
        y_rms: None,
        standing: match case.outcome {
            _ if case.counts() => PointStanding::Right,
            Outcome::Wrong if is_approximate(case) => PointStanding::Approximate,
            Outcome::Wrong if has_role(case, "sweep") => PointStanding::Wrong,
            _ => PointStanding::Failed,
        },
        command: data.command(case),
    }
}

/// The knob's value, and what went wrong where something did.
fn label(case: &Case) -> String {
    match (knob_m(case).map(length), case.outcome) {
        (Some(knob), Outcome::Ok) => knob,
        (Some(knob), _) if !is_approximate(case) => format!("{knob} {}", standing(case)),
        (None, Outcome::Ok) => "default".to_owned(),
        _ => standing(case).to_owned(),
    }
}

/// Cases that have no point on the first panel.
fn not_drawn(data: &Data<'_>, view: &View<'_>) -> Vec<String> {
    let reason = |case: &&&Case| {
        let why = match case.outcome {
            Outcome::Wrong | Outcome::Failed => return None,
            Outcome::Skipped | Outcome::Missing | Outcome::DriverFault => {
                format!("{}: {}", case.outcome.name(), case.reason)
            }
            Outcome::Ok if data.time(case).is_none() => "no fill time".to_owned(),
            Outcome::Ok if case.value(QUANTITIES[0].2).is_none() => "no error figure".to_owned(),
            Outcome::Ok => return None,
        };
        Some(format!("{} ({why})", name(case)))
    };
    view.cases.iter().filter_map(|case| reason(&case)).collect()
}
