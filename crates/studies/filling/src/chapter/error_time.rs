// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against time of one view: a curve for each method through its knob, a vertical line for each exact method.
//!
//! Knobs are the boundary tolerance of sweeps, the levels of detail of full plans, and the setting of approximate
//! fills, such as the mask's texels. A fill that is wrong and no point of a sweep is neither curve nor line.

use super::data::{Data, ViewCases, grouped, knob_m, layout_name, setting};
use crate::keys::{BOUNDARY_LOD_PX, BOUNDARY_MOVED_PX, MISMATCHED_PX};
use crate::purpose::{Purpose, is_approximate, is_point};
use crate::request::STUDY;
use terrafill_conformance::MAX_ROUNDED_PX;
use terrafill_lab::full_command;
use terrafill_plot::{
    Arrangement, Curve, Point, PointStanding, Reading, Upwards, WorkPrecision, length, panels,
};
use terrafill_results::{Block, Case, ChapterError, Outcome};

const CAPTION: &str = "One curve a method through its knob, whose values label the points. Knobs: boundary tolerance, by how \
    many pixels levels of detail move boundaries at most, texels of a mask. Vertical lines: right fills that move no \
    boundary and have no other value of a knob in this view. Left and low is better. Open marks are approximate \
    fills, crosses are wrong pictures of sweeps, whose error is the question. Ringed and joined by dashes: the Pareto \
    front of right fills, where at least 95 % of bootstrap resamples of the processes keep it.";

/// For the first page: the view whose fills have the most errors to choose from. Without a choice, what to type for one.
pub(super) fn of_run(data: &Data<'_>) -> Result<Block, ChapterError> {
    let plots = data.views.iter().map(|view| (view, curves(data, view)));
    let most = plots.reduce(|most, next| {
        if choice(&next.1) > choice(&most.1) {
            next
        } else {
            most
        }
    });
    let plot = most.map(|(view, curves)| plot(data, view, curves));
    Ok(plot.transpose()?.flatten().unwrap_or_else(|| {
        let command = full_command(&data.run.environment, STUDY);
        Block::Text(format!(
            "No knob of this run trades error for time. To measure some: {command}"
        ))
    }))
}

/// Every method of a view; nothing where there is no error to choose.
pub(super) fn of_view(
    data: &Data<'_>,
    view: &ViewCases<'_>,
) -> Result<Option<Block>, ChapterError> {
    plot(data, view, curves(data, view))
}

fn plot(
    data: &Data<'_>,
    view: &ViewCases<'_>,
    curves: Vec<Curve>,
) -> Result<Option<Block>, ChapterError> {
    if choice(&curves).0 < 2 {
        return Ok(None);
    }
    let title = format!("{}: error against time", view.title());
    let plot = WorkPrecision {
        title: &title,
        across: &format!("fill, {}: median, 5–95 % of samples", data.timings.unit()),
        up: "mismatched pixels",
        upwards: Upwards::Error,
        curves,
        lines: Vec::new(),
    };
    let svg = panels(&title, &[plot], Arrangement::Alone, data.palette())?;
    Ok(Block::plot(CAPTION, svg))
}

/// How many errors the knobs and the approximate fills offer, and by which factor they differ.
fn choice(curves: &[Curve]) -> (usize, f64) {
    let points = curves.iter().flat_map(|curve| &curve.points);
    let points = points.filter(|point| point.standing != PointStanding::Exact);
    let mut errors: Vec<f64> = points
        .filter_map(|point| Some(point.y.as_ref()?.middle()))
        .collect();
    errors.sort_by(f64::total_cmp);
    errors.dedup();
    let factor = match errors[..] {
        [least, .., most] => most / least.max(1.0),
        _ => 1.0,
    };
    (errors.len(), factor)
}

/// Methods in the order of reports, each through its knob.
pub(super) fn curves(data: &Data<'_>, view: &ViewCases<'_>) -> Vec<Curve> {
    let cases = view.cases.iter();
    let shown = cases.filter_map(|case| {
        let (name, point) = point(data, view, case)?;
        Some((name, (*case, point)))
    });
    let methods = grouped(shown, |(name, _)| name.clone()).into_iter();
    let curves = methods.map(|(name, shown)| {
        let (cases, mut points): (Vec<&Case>, Vec<Point>) =
            shown.into_iter().map(|(_, point)| point).unzip();
        points.sort_by(|a, b| a.knob.total_cmp(&b.knob));
        // A sweep draws the scene's own tolerance again.
        points.dedup_by(|a, b| a.label == b.label);
        if let ([only], true) = (&mut points[..], cases.iter().any(|case| is_exact(case))) {
            only.standing = PointStanding::Exact;
        }
        Curve { name, points }
    });
    let mut curves: Vec<Curve> = curves.collect();
    let place = |curve: &Curve| data.palette().place(&curve.name);
    curves.sort_by(|a, b| (place(a), &a.name).cmp(&(place(b), &b.name)));
    curves
}

/// Right, and no boundary moved on purpose.
fn is_exact(case: &Case) -> bool {
    let moved = case.value(BOUNDARY_MOVED_PX);
    case.counts()
        && !is_approximate(case)
        && !is_point(case)
        && moved.is_none_or(|px| px <= MAX_ROUNDED_PX)
}

/// A case's curve and its place there; `None` of what was not timed or compared, or counts for nothing.
fn point(data: &Data<'_>, view: &ViewCases<'_>, case: &Case) -> Option<(String, Point)> {
    let standing = match case.outcome {
        Outcome::Ok | Outcome::Wrong if is_approximate(case) => PointStanding::Approximate,
        Outcome::Ok => PointStanding::Right,
        Outcome::Wrong if Purpose::Sweep.is_of(case) => PointStanding::Wrong,
        _ => return None,
    };
    let time = data.timings.samples(case)?;
    let (name, knob, label) = knob(data, view, case);
    let point = Point {
        // What is no number comes first, in the plan's order.
        knob: knob.unwrap_or(f64::NEG_INFINITY),
        label,
        x: Some(Reading::sampled(time, &data.timings.replicates(case))),
        y: Some(Reading::exact(case.value(MISMATCHED_PX)?)),
        y_rms: None,
        standing,
        command: data.command(case),
    };
    Some((name, point))
}

/// Name of a case's curve, its knob's value, and how that is written.
fn knob(data: &Data<'_>, view: &ViewCases<'_>, case: &Case) -> (String, Option<f64>, String) {
    if is_approximate(case) {
        let value = setting(case, view).unwrap_or_default();
        return (layout_name(case), value.parse().ok(), value.to_owned());
    }
    if Purpose::FullPlan.is_of(case) {
        let px = case.condition(BOUNDARY_LOD_PX);
        let label = match px {
            "" | "off" => "0 px".to_owned(),
            px => format!("≤ {px} px"),
        };
        let name = format!("{}, full plan", layout_name(case));
        return (name, px.parse().ok(), label);
    }
    let tolerance = knob_m(case);
    let label = tolerance.map_or_else(String::new, length);
    // The sweep of a full plan is another curve than the plan's levels.
    let mut name = data.curve(case);
    if data.plan_of(case).is_some() {
        name += ", simplified";
    }
    (name, tolerance, label)
}
