// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time of one view: two panels side by side, wrong pixels and boundary deviation.
//!
//! Both axes are logarithmic; one curve per layout through its knob, the boundary tolerance. A case
//! without error stands on a line of its own at the bottom, a wrong or failed one on the upper edge:
//! neither has a place on a logarithm, and neither may vanish. A wrong case of the sweep is the
//! exception, since its error is the answer to the sweep's question: it stands where its figures put
//! it, on its curve, with the cross of a wrong case. The Pareto front joins only right cases that
//! keep their place when frames are resampled (see `statistic`).

use super::WIDTH_PX;
use super::canvas::{Anchor, Canvas, MARKER_PX, TEXT_PX, svg, text_width};
use super::palette::{INK, Palette, Stroke};
use super::scale::{LogScale, length, tick_label};
use crate::ReportError;
use crate::number::elided;
use crate::run_data::{Case, Outcome, ViewCases};
use crate::statistic::{Candidate, FRONT_SURVIVAL, front_survival};
use plotters::prelude::Color as _;
use std::collections::BTreeMap;

const TITLE_Y: f64 = 14.0;
/// Wrong and failed cases.
const EDGE_Y: f64 = 50.0;
const LOG_TOP_Y: f64 = 78.0;
const LOG_BOTTOM_Y: f64 = 322.0;
/// Cases without error.
const ZERO_Y: f64 = 352.0;
const BOTTOM_Y: f64 = 366.0;
const LEGEND_Y: f64 = 430.0;
const LEGEND_ROW_PX: f64 = 19.0;
const PANEL_PX: f64 = WIDTH_PX / 2.0;
const LEFT_MARGIN_PX: f64 = 70.0;
const RIGHT_MARGIN_PX: f64 = 22.0;
/// Longest curve name in the legend.
const LEGEND_CHARS: usize = 80;

/// Errors that differ by less than this much are hardly different: keeps one pixel more or less from
/// filling the axis.
const LEAST_ERROR_MARGIN: f64 = 2.5;

/// Distances at which a label is tried around its point, nearest first.
const LABEL_RADII_PX: [f64; 4] = [13.0, 24.0, 38.0, 54.0];
/// From this distance on, a line leads from the label to its point.
const LEADER_FROM_PX: f64 = 20.0;

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

/// One case on one panel.
struct Point<'a> {
    case: &'a Case,
    at: [f64; 2],
    whisker: Option<[f64; 2]>,
    /// On the upper edge.
    pinned: bool,
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
    let panels: Vec<Panel<'_>> = QUANTITIES
        .iter()
        .zip([0.0, PANEL_PX])
        .filter_map(|(quantity, left)| Panel::new(quantity, left, &view.cases))
        .collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let mut series: Vec<String> = view.cases.iter().map(|case| case.series()).collect();
    series.sort_unstable();
    series.dedup();
    let legend = legend_places(&series);
    let height = legend.last().map_or(LEGEND_Y, |(at, _)| at[1]) + LEGEND_ROW_PX;
    let title = format!("{scene}, {}: error against run time", view.name);
    let svg = svg(&title, WIDTH_PX, height, |canvas| {
        for panel in &panels {
            panel.draw(canvas, palette)?;
        }
        for (at, name) in &legend {
            canvas.marker(*at, palette.stroke(name))?;
            let label = elided(name, LEGEND_CHARS);
            canvas.text(&label, [at[0] + 12.0, at[1]], Anchor::Left)?;
        }
        Ok(())
    })?;
    Ok(Some(ErrorPlot {
        svg,
        not_drawn: not_drawn(view),
    }))
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

/// Entries side by side, a new line where the next would not fit.
fn legend_places(series: &[String]) -> Vec<([f64; 2], String)> {
    let mut at = [LEFT_MARGIN_PX, LEGEND_Y];
    let mut places = Vec::new();
    for name in series {
        let width = text_width(&elided(name, LEGEND_CHARS), TEXT_PX) + 40.0;
        if at[0] > LEFT_MARGIN_PX && at[0] + width > WIDTH_PX {
            at = [LEFT_MARGIN_PX, at[1] + LEGEND_ROW_PX];
        }
        places.push((at, name.clone()));
        at[0] += width;
    }
    places
}

/// One panel, laid out.
struct Panel<'a> {
    quantity: &'static Quantity,
    left: f64,
    right: f64,
    x: LogScale,
    /// `None` when no case has a positive error.
    y: Option<LogScale>,
    points: Vec<Point<'a>>,
    /// Corners of the front, left to right.
    front: Vec<[f64; 2]>,
}

impl<'a> Panel<'a> {
    fn new(quantity: &'static Quantity, left: f64, cases: &[&'a Case]) -> Option<Self> {
        let (left, right) = (left + LEFT_MARGIN_PX, left + PANEL_PX - RIGHT_MARGIN_PX);
        let shown: Vec<&'a Case> = cases
            .iter()
            .copied()
            .filter(|case| match case.outcome {
                Outcome::Ok => case.fill_cpu.is_some() && (quantity.of)(case).is_some(),
                Outcome::Wrong | Outcome::Failed => true,
                Outcome::Skipped | Outcome::Missing => false,
            })
            .collect();
        let times = shown
            .iter()
            .filter_map(|case| case.fill_cpu)
            .flat_map(|spread| [spread.p5, spread.p95]);
        let x = LogScale::around(times, 1.2, left, right)?;
        let errors = shown
            .iter()
            .filter(|case| !is_pinned(case, quantity))
            .filter_map(|case| (quantity.of)(case));
        let y = LogScale::around(errors, LEAST_ERROR_MARGIN, LOG_BOTTOM_Y, LOG_TOP_Y);
        let mut panel = Self {
            quantity,
            left,
            right,
            x,
            y,
            points: Vec::new(),
            front: Vec::new(),
        };
        panel.points = panel.place(&shown);
        panel.front = panel.front_corners();
        Some(panel)
    }

    fn place(&self, cases: &[&'a Case]) -> Vec<Point<'a>> {
        let mut without_time = 0.0;
        cases
            .iter()
            .map(|case| {
                let pinned = is_pinned(case, self.quantity);
                let at_x = case.fill_cpu.map_or_else(
                    || {
                        without_time += 1.0;
                        self.right - (without_time - 1.0) * 4.0 * MARKER_PX
                    },
                    |spread| self.x.px(spread.median),
                );
                Point {
                    case,
                    at: [at_x, self.height_of(case)],
                    whisker: case
                        .fill_cpu
                        .filter(|_| !pinned)
                        .map(|spread| [self.x.px(spread.p5), self.x.px(spread.p95)]),
                    pinned,
                }
            })
            .collect()
    }

    fn height_of(&self, case: &Case) -> f64 {
        match ((self.quantity.of)(case), &self.y) {
            _ if is_pinned(case, self.quantity) => EDGE_Y,
            (Some(error), Some(scale)) if error > 0.0 => scale.px(error),
            _ => ZERO_Y,
        }
    }

    fn front_corners(&self) -> Vec<[f64; 2]> {
        let judged: Vec<&Point<'a>> = self
            .points
            .iter()
            .filter(|point| point.case.counts())
            .collect();
        let candidates: Vec<Candidate<'_>> = judged
            .iter()
            .filter_map(|point| {
                Some(Candidate {
                    times: &point.case.fill_cpu_ms,
                    error: (self.quantity.of)(point.case)?,
                })
            })
            .collect();
        let mut corners: Vec<[f64; 2]> = judged
            .iter()
            .zip(front_survival(&candidates))
            .filter(|(_, survival)| *survival >= FRONT_SURVIVAL)
            .map(|(point, _)| point.at)
            .collect();
        corners.sort_by(|a, b| a[0].total_cmp(&b[0]));
        corners
    }

    fn draw(&self, canvas: &Canvas<'_>, palette: &Palette) -> Result<(), ReportError> {
        self.draw_axes(canvas)?;
        self.draw_front(canvas)?;
        self.draw_curves(canvas, palette)?;
        for point in &self.points {
            let stroke = palette.stroke(&point.case.series());
            self.draw_point(canvas, point, stroke)?;
        }
        self.draw_labels(canvas)
    }

    fn draw_axes(&self, canvas: &Canvas<'_>) -> Result<(), ReportError> {
        let (left, right) = (self.left, self.right);
        canvas.heading(self.quantity.title, [left, TITLE_Y], Anchor::Left)?;
        for tick in self.x.ticks() {
            let x = self.x.px(tick);
            canvas.rule([x, EDGE_Y], [x, BOTTOM_Y], 0.12)?;
            canvas.text(&tick_label(tick), [x, BOTTOM_Y + 12.0], Anchor::Middle)?;
        }
        canvas.text(
            "fill, process CPU ms: median, 5–95 % of frames",
            [(left + right) * 0.5, BOTTOM_Y + 34.0],
            Anchor::Middle,
        )?;
        for tick in self.y.iter().flat_map(LogScale::ticks) {
            let y = self.y.map_or(ZERO_Y, |scale| scale.px(tick));
            canvas.rule([left, y], [right, y], 0.12)?;
            canvas.text(&tick_label(tick), [left - 8.0, y], Anchor::Right)?;
        }
        let middle = (LOG_TOP_Y + LOG_BOTTOM_Y) * 0.5;
        canvas.upright_text(self.quantity.axis, [left - 56.0, middle])?;
        canvas.rule([left, LOG_TOP_Y], [left, LOG_BOTTOM_Y], 0.6)?;
        canvas.rule([left, ZERO_Y], [right, ZERO_Y], 0.6)?;
        canvas.text("0", [left - 8.0, ZERO_Y], Anchor::Right)?;
        canvas.rule([left, EDGE_Y], [right, EDGE_Y], 0.35)?;
        canvas.text("wrong,", [left - 8.0, EDGE_Y - 7.0], Anchor::Right)?;
        canvas.text("failed", [left - 8.0, EDGE_Y + 7.0], Anchor::Right)
    }

    fn draw_front(&self, canvas: &Canvas<'_>) -> Result<(), ReportError> {
        for pair in self.front.windows(2) {
            let corner = [pair[1][0], pair[0][1]];
            canvas.dashes(pair[0], corner)?;
            canvas.dashes(corner, pair[1])?;
        }
        for corner in &self.front {
            canvas.ring(*corner)?;
        }
        Ok(())
    }

    /// Joins the cases of one layout in the order of the knob.
    fn draw_curves(&self, canvas: &Canvas<'_>, palette: &Palette) -> Result<(), ReportError> {
        for (series, mut points) in self.curves() {
            points.sort_by(|a, b| {
                let knob = |point: &Point<'_>| point.case.knob_m().unwrap_or(0.0);
                knob(a).total_cmp(&knob(b))
            });
            let path: Vec<[f64; 2]> = points.iter().map(|point| point.at).collect();
            let colour = palette.stroke(&series).colour.mix(0.7);
            canvas.path(&path, colour, 2)?;
        }
        Ok(())
    }

    /// Points with a place of their own, by layout, where a layout has more than one.
    fn curves(&self) -> BTreeMap<String, Vec<&Point<'a>>> {
        let mut curves: BTreeMap<String, Vec<&Point<'a>>> = BTreeMap::new();
        for point in self.points.iter().filter(|point| !point.pinned) {
            curves.entry(point.case.series()).or_default().push(point);
        }
        curves.retain(|_, points| points.len() > 1);
        curves
    }

    fn draw_point(
        &self,
        canvas: &Canvas<'_>,
        point: &Point<'_>,
        stroke: Stroke,
    ) -> Result<(), ReportError> {
        if let Some([from, to]) = point.whisker {
            canvas.whisker(from, to, point.at[1], stroke.colour)?;
        }
        if point.case.counts() {
            canvas.marker(point.at, stroke)
        } else {
            canvas.cross(point.at, stroke.colour)
        }
    }

    fn draw_labels(&self, canvas: &Canvas<'_>) -> Result<(), ReportError> {
        let curves = self.curves();
        let mut taken: Vec<Rectangle> = self
            .points
            .iter()
            .map(|point| Rectangle::around(point.at, 2.0 * MARKER_PX + 2.0, 2.0 * MARKER_PX + 2.0))
            .collect();
        for point in &self.points {
            let on_curve = curves.contains_key(&point.case.series());
            if !point.pinned && !on_curve {
                continue;
            }
            let label = label_of(point);
            let width = text_width(&label, TEXT_PX);
            let Some((middle, radius)) = self.free_place(point.at, width, &taken) else {
                continue;
            };
            if radius >= LEADER_FROM_PX {
                canvas.path(&[point.at, middle], INK.mix(0.3), 1)?;
            }
            canvas.text(&label, middle, Anchor::Middle)?;
            taken.push(Rectangle::around(middle, width, TEXT_PX + 2.0));
        }
        Ok(())
    }

    /// The nearest place for a label's middle that touches no point and no other label.
    fn free_place(&self, at: [f64; 2], width: f64, taken: &[Rectangle]) -> Option<([f64; 2], f64)> {
        const DIRECTIONS: [[f64; 2]; 8] = [
            [0.7, -0.7],
            [0.7, 0.7],
            [-0.7, -0.7],
            [-0.7, 0.7],
            [0.0, -1.0],
            [0.0, 1.0],
            [1.0, 0.0],
            [-1.0, 0.0],
        ];
        for radius in LABEL_RADII_PX {
            for [dx, dy] in DIRECTIONS {
                let aside = width * 0.5 * (dx * 1.5).clamp(-1.0, 1.0);
                let middle = [at[0] + dx * radius + aside, at[1] + dy * radius];
                let place = Rectangle::around(middle, width, TEXT_PX);
                let inside = place.low[0] >= self.left - 2.0
                    && place.high[0] <= self.right + RIGHT_MARGIN_PX - 2.0
                    && place.low[1] >= TITLE_Y + 8.0
                    && place.high[1] <= BOTTOM_Y + 2.0;
                if inside && !taken.iter().any(|other| other.meets(&place)) {
                    return Some((middle, radius));
                }
            }
        }
        None
    }
}

/// Whether a case has no place by its figures: it has none, or they count for nothing.
fn is_pinned(case: &Case, quantity: &Quantity) -> bool {
    let has_figures = case.fill_cpu.is_some() && (quantity.of)(case).is_some();
    let is_result = case.counts() || (case.outcome == Outcome::Wrong && case.is_sweep());
    !(has_figures && is_result)
}

/// The knob's value, and what went wrong where something did.
fn label_of(point: &Point<'_>) -> String {
    let knob = point.case.knob_m().map(length);
    match (knob, point.case.outcome) {
        (Some(knob), Outcome::Ok) => knob,
        (Some(knob), outcome) => format!("{knob} {}", outcome.name()),
        (None, Outcome::Ok) => "default".to_owned(),
        (None, outcome) => outcome.name().to_owned(),
    }
}

/// Room that a mark takes up.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
}

impl Rectangle {
    fn around(middle: [f64; 2], width: f64, height: f64) -> Self {
        Self {
            low: [middle[0] - width * 0.5, middle[1] - height * 0.5],
            high: [middle[0] + width * 0.5, middle[1] + height * 0.5],
        }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::{CaseKey, Status, Summary, spread};

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

    /// Places of the cases on the panel of wrong pixels.
    fn places(cases: &[Case]) -> Vec<[f64; 2]> {
        let cases: Vec<&Case> = cases.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &cases).expect("something to draw");
        panel.points.iter().map(|point| point.at).collect()
    }

    #[test]
    fn slower_is_further_right_and_worse_is_higher() {
        let at = places(&[
            case("a", Outcome::Ok, 1.0, 500),
            case("b", Outcome::Ok, 2.0, 10),
            case("c", Outcome::Ok, 4.0, 0),
        ]);
        assert!(at[0][0] < at[1][0] && at[1][0] < at[2][0], "{at:?}");
        assert!(at[0][1] < at[1][1] && at[1][1] < at[2][1], "{at:?}");
        assert!(at[0][1] > EDGE_Y, "an error, however large, is no failure");
        assert!(
            at[2][1] >= ZERO_Y && at[1][1] < ZERO_Y,
            "only 0 is on the line"
        );
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
        assert!(at[1..].iter().all(|at| at[1] <= EDGE_Y), "{at:?}");
        assert!(at[0][1] > EDGE_Y);
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
        let all: Vec<&Case> = cases.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &all).expect("something to draw");
        assert_eq!(panel.front, [panel.points[0].at, panel.points[1].at]);
        // Twin: had the wrong one been right, it would beat them all.
        let mut right = cases;
        right[3].outcome = Outcome::Ok;
        let all: Vec<&Case> = right.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &all).expect("something to draw");
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
        let all: Vec<&Case> = cases.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &all).expect("something to draw");
        let curves = panel.curves();
        assert_eq!(curves.keys().collect::<Vec<_>>(), ["vertex/doubled"]);
        assert_eq!(curves["vertex/doubled"].len(), 3, "the wrong one too");
    }

    #[test]
    fn a_wrong_case_of_the_sweep_stands_at_its_error_but_not_on_the_front() {
        let coarse = "doubled,boundary-tolerance-m=9000";
        let cases = [
            case("doubled", Outcome::Ok, 2.0, 3),
            case(coarse, Outcome::Wrong, 0.5, 99),
            without_time(case(coarse, Outcome::Wrong, 0.5, 99)),
        ];
        let all: Vec<&Case> = cases.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &all).expect("something to draw");
        let [right, wrong, timeless] = &panel.points[..] else {
            panic!("three points");
        };
        assert!(EDGE_Y < wrong.at[1] && wrong.at[1] < right.at[1]);
        assert!(wrong.at[0] < right.at[0]);
        assert!(timeless.at[1] <= EDGE_Y, "without a time there is no place");
        assert_eq!(panel.front, [right.at]);
    }

    #[test]
    fn labels_keep_clear_of_points_and_of_each_other() {
        let cases = [
            case("a", Outcome::Ok, 1.0, 9),
            case("b", Outcome::Ok, 4.0, 90),
        ];
        let all: Vec<&Case> = cases.iter().collect();
        let panel = Panel::new(&QUANTITIES[0], 0.0, &all).expect("something to draw");
        let at = [300.0, 200.0];
        let mut taken = vec![Rectangle::around(at, 11.0, 11.0)];
        for _ in 0..9 {
            let (middle, _) = panel.free_place(at, 40.0, &taken).expect("room");
            let place = Rectangle::around(middle, 40.0, TEXT_PX);
            assert!(!taken.iter().any(|other| other.meets(&place)));
            taken.push(place);
        }
        // Twin: where everything is taken, there is no place.
        let full = [Rectangle::around(at, 1000.0, 1000.0)];
        assert!(panel.free_place(at, 40.0, &full).is_none());
    }

    #[test]
    fn nothing_with_a_time_is_no_panel() {
        let cases = [without_time(case("a", Outcome::Failed, 1.0, 0))];
        assert!(Panel::new(&QUANTITIES[0], 0.0, &[&cases[0]]).is_none());
    }

    #[test]
    fn rectangles_meet_or_do_not() {
        let a = Rectangle::around([0.0, 0.0], 10.0, 4.0);
        assert!(a.meets(&Rectangle::around([9.0, 0.0], 10.0, 4.0)));
        assert!(!a.meets(&Rectangle::around([11.0, 0.0], 10.0, 4.0)));
        assert!(!a.meets(&Rectangle::around([0.0, 5.0], 10.0, 4.0)));
    }

    #[test]
    fn legend_entries_do_not_run_out_of_the_drawing() {
        let names: Vec<String> = (0..20).map(|i| format!("vertex/variant-{i:02}")).collect();
        let places = legend_places(&names);
        assert_eq!(places.len(), 20);
        for (at, name) in &places {
            assert!(at[0] + 12.0 + text_width(name, TEXT_PX) <= WIDTH_PX);
        }
        assert!(places[19].0[1] > places[0].0[1], "they wrap");
    }
}
