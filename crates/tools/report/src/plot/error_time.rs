// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time of one view: two panels side by side, wrong pixels and boundary deviation.
//!
//! One curve per layout through its knob, the boundary tolerance. A wrong case of the sweep stands
//! where its figures put it, since its error is the answer to the sweep's question; any other wrong
//! or failed case stands on the edge (see `work_precision`).

use super::WIDTH_PX;
use super::canvas::svg;
use super::log_log::{Frame, NAME_PX, draw_name, names_below};
use super::palette::Palette;
use super::scale::length;
use super::work_precision::{Curve, Panel, Point, Reading, Standing, Upwards, WorkPrecision};
use crate::ReportError;
use crate::run_data::{Case, Outcome, ViewCases};
use std::collections::BTreeMap;

const TOP_PX: f64 = 50.0;
const BOTTOM_PX: f64 = 366.0;
const LEGEND_PX: f64 = 430.0;
const PANEL_PX: f64 = WIDTH_PX / 2.0;
const LEFT_MARGIN_PX: f64 = 74.0;
const RIGHT_MARGIN_PX: f64 = 22.0;

/// What a panel's vertical axis shows.
struct Quantity {
    title: &'static str,
    axis: &'static str,
    of: fn(&Case) -> Option<f64>,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        title: "Error against the reference",
        axis: "mismatched pixels",
        of: |case| {
            case.value(|row| row.mismatched_px)
                .map(|pixels| pixels as f64)
        },
    },
    Quantity {
        title: "Error of the drawn boundary",
        axis: "boundary deviation, m",
        of: |case| case.value(|row| row.boundary_deviation_m),
    },
];

/// The drawing, and what is not on it.
#[derive(Debug)]
pub(crate) struct ErrorPlot {
    pub(crate) svg: String,
    /// Cases without a point, each with its reason.
    pub(crate) not_drawn: Vec<String>,
}

/// Draws both panels; `None` when neither would hold a point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn error_against_time(
    scene: &str,
    view: &ViewCases<'_>,
    palette: &Palette,
) -> Result<Option<ErrorPlot>, ReportError> {
    let plots = QUANTITIES
        .each_ref()
        .map(|quantity| plot(quantity, &view.cases));
    let panels: Vec<Panel<'_>> = plots
        .iter()
        .zip([0.0, PANEL_PX])
        .filter_map(|(plot, left)| Panel::new(plot, frame(left)))
        .collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let mut series: Vec<String> = view.cases.iter().map(|case| case.series()).collect();
    series.sort_unstable();
    series.dedup();
    let legend = names_below(&series, [LEFT_MARGIN_PX, LEGEND_PX]);
    let height = legend.last().map_or(LEGEND_PX, |(at, _)| at[1]) + NAME_PX;
    let title = format!("{scene}, {}: error against run time", view.name);
    let svg = svg(&title, WIDTH_PX, height, |canvas| {
        for panel in &panels {
            panel.draw(canvas, palette)?;
        }
        for ((at, text), name) in legend.iter().zip(&series) {
            draw_name(canvas, text, *at, palette.stroke(name))?;
        }
        Ok(())
    })?;
    Ok(Some(ErrorPlot {
        svg,
        not_drawn: not_drawn(view),
    }))
}

fn frame(left: f64) -> Frame {
    Frame {
        left: left + LEFT_MARGIN_PX,
        right: left + PANEL_PX - RIGHT_MARGIN_PX,
        top: TOP_PX,
        bottom: BOTTOM_PX,
    }
}

/// The cases as curves, one for each layout.
fn plot(quantity: &Quantity, cases: &[&Case]) -> WorkPrecision<'static> {
    let mut curves: BTreeMap<String, Vec<Point>> = BTreeMap::new();
    for case in cases {
        let is_shown = match case.outcome {
            Outcome::Ok => case.fill_cpu.is_some() && (quantity.of)(case).is_some(),
            Outcome::Wrong | Outcome::Failed => true,
            Outcome::Skipped | Outcome::Missing => false,
        };
        if is_shown {
            let points = curves.entry(case.series()).or_default();
            points.push(point(quantity, case));
        }
    }
    WorkPrecision {
        title: quantity.title,
        across: "fill, process CPU ms: median, 5–95 % of frames",
        up: quantity.axis,
        upwards: Upwards::Error,
        curves: curves
            .into_iter()
            .map(|(name, points)| Curve { name, points })
            .collect(),
        lines: Vec::new(),
    }
}

fn point(quantity: &Quantity, case: &Case) -> Point {
    let time = |spread| Reading::sampled(spread, &case.fill_cpu_ms);
    Point {
        knob: case.knob_m().unwrap_or(0.0),
        label: label_of(case),
        x: case.fill_cpu.map(time),
        y: (quantity.of)(case).map(Reading::exact),
        y_rms: None,
        standing: match case.outcome {
            _ if case.counts() => Standing::Right,
            Outcome::Wrong if case.is_sweep() => Standing::Wrong,
            _ => Standing::Failed,
        },
    }
}

/// Cases that have no point on the first panel.
fn not_drawn(view: &ViewCases<'_>) -> Vec<String> {
    view.cases
        .iter()
        .filter_map(|case| {
            let why = match case.outcome {
                Outcome::Wrong | Outcome::Failed => return None,
                Outcome::Skipped | Outcome::Missing => {
                    format!("{}: {}", case.outcome.name(), case.reason())
                }
                Outcome::Ok if case.fill_cpu.is_none() => "no fill time".to_owned(),
                Outcome::Ok if (QUANTITIES[0].of)(case).is_none() => "no error figure".to_owned(),
                Outcome::Ok => return None,
            };
            Some(format!("{} ({why})", case.name()))
        })
        .collect()
}

/// The knob's value, and what went wrong where something did.
fn label_of(case: &Case) -> String {
    let knob = case.knob_m().map(length);
    match (knob, case.outcome) {
        (Some(knob), Outcome::Ok) => knob,
        (Some(knob), outcome) => format!("{knob} {}", outcome.name()),
        (None, Outcome::Ok) => "default".to_owned(),
        (None, outcome) => outcome.name().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::canvas::MARKER_PX;
    use terrafill_results::legacy::{CaseKey, Status, Summary, spread};

    fn case(variant: &str, outcome: Outcome, ms: f64, error_px: u64) -> Case {
        let key = CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "vertex".to_owned(),
            variant: variant.to_owned(),
        };
        let times = [0.98, 0.99, 1.0, 1.01, 1.02].map(|factor| factor * ms);
        Case {
            summary: Some(Summary {
                mismatched_px: Some(error_px),
                ..Summary::new(key.clone(), Status::Ok)
            }),
            key,
            outcome,
            fill_cpu: spread(&times),
            fill_cpu_ms: times.to_vec(),
        }
    }

    fn without_time(mut case: Case) -> Case {
        case.fill_cpu = None;
        case.fill_cpu_ms.clear();
        case
    }

    fn wrong_pixels(cases: &[Case]) -> WorkPrecision<'static> {
        let cases: Vec<&Case> = cases.iter().collect();
        plot(&QUANTITIES[0], &cases)
    }

    /// Places of the cases on the panel of wrong pixels.
    fn places(cases: &[Case]) -> Vec<[f64; 2]> {
        let plot = wrong_pixels(cases);
        let panel = Panel::new(&plot, frame(0.0)).expect("something to draw");
        panel.points.iter().map(|point| point.at).collect()
    }

    #[test]
    fn slower_is_further_right_and_worse_is_higher() {
        let cases = [
            case("a", Outcome::Ok, 1.0, 500),
            case("b", Outcome::Ok, 2.0, 10),
            case("c", Outcome::Ok, 4.0, 0),
        ];
        let at = places(&cases);
        let plot = wrong_pixels(&cases);
        let zero = Panel::new(&plot, frame(0.0))
            .expect("something to draw")
            .zero();
        assert!(at[0][0] < at[1][0] && at[1][0] < at[2][0], "{at:?}");
        assert!(at[0][1] < at[1][1] && at[1][1] < at[2][1], "{at:?}");
        assert!(at[0][1] > TOP_PX, "an error, however large, is no failure");
        assert!(at[2][1] >= zero && at[1][1] < zero, "only 0 is on the line");
    }

    #[test]
    fn wrong_and_failed_cases_are_pinned_and_none_is_dropped() {
        let at = places(&[
            case("a", Outcome::Ok, 1.0, 3),
            case("b", Outcome::Wrong, 2.0, 0),
            without_time(case("c", Outcome::Failed, 2.0, 0)),
            without_time(case("d", Outcome::Failed, 2.0, 0)),
        ]);
        assert_eq!(at.len(), 4);
        assert!(at[1..].iter().all(|at| at[1] <= TOP_PX), "{at:?}");
        assert!(at[0][1] > TOP_PX);
        assert!(at[2][0] > at[1][0], "no time: at the right");
        assert!(
            (at[2][0] - at[3][0]).abs() > 2.0 * MARKER_PX,
            "side by side"
        );
    }

    #[test]
    fn only_cases_that_count_reach_the_front() {
        let cases = [
            case("a", Outcome::Ok, 1.0, 50),
            case("b", Outcome::Ok, 4.0, 0),
            case("c", Outcome::Ok, 4.0, 60),
            case("d", Outcome::Wrong, 0.5, 0),
        ];
        let plot = wrong_pixels(&cases);
        let panel = Panel::new(&plot, frame(0.0)).expect("something to draw");
        assert_eq!(panel.front, [panel.points[0].at, panel.points[1].at]);
        // Twin: had the wrong one been right, it would beat them all.
        let mut right = cases;
        right[3].outcome = Outcome::Ok;
        let plot = wrong_pixels(&right);
        let panel = Panel::new(&plot, frame(0.0)).expect("something to draw");
        assert_eq!(panel.front, [panel.points[3].at]);
    }

    #[test]
    fn a_curve_runs_through_its_layout_only() {
        let cases = [
            case("doubled,boundary-tolerance-m=5000", Outcome::Ok, 1.0, 9),
            case("doubled,boundary-tolerance-m=1000", Outcome::Ok, 2.0, 3),
            case("doubled,boundary-tolerance-m=9000", Outcome::Wrong, 0.5, 99),
            case("pulled,boundary-tolerance-m=1000", Outcome::Ok, 2.0, 3),
        ];
        let plot = wrong_pixels(&cases);
        let panel = Panel::new(&plot, frame(0.0)).expect("something to draw");
        let paths = panel.paths();
        assert_eq!((paths.len(), paths[0].0), (1, "vertex/doubled"));
        assert_eq!(paths[0].1.len(), 3, "the wrong one too");
    }

    #[test]
    fn a_wrong_case_of_the_sweep_stands_at_its_error_but_not_on_the_front() {
        let coarse = "doubled,boundary-tolerance-m=9000";
        let cases = [
            case("doubled", Outcome::Ok, 2.0, 3),
            case(coarse, Outcome::Wrong, 0.5, 99),
            without_time(case(coarse, Outcome::Wrong, 0.5, 99)),
        ];
        let plot = wrong_pixels(&cases);
        let panel = Panel::new(&plot, frame(0.0)).expect("something to draw");
        let [right, wrong, timeless] = &panel.points[..] else {
            panic!("three points");
        };
        assert!(TOP_PX < wrong.at[1] && wrong.at[1] < right.at[1]);
        assert!(wrong.at[0] < right.at[0]);
        assert!(timeless.at[1] <= TOP_PX, "without a time there is no place");
        assert_eq!(panel.front, [right.at]);
    }

    #[test]
    fn nothing_with_a_time_is_no_panel() {
        let cases = [without_time(case("a", Outcome::Failed, 1.0, 0))];
        assert!(Panel::new(&wrong_pixels(&cases), frame(0.0)).is_none());
    }
}
