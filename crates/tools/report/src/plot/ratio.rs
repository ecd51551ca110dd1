// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time over bound of every case of a scene: a dot with its 5–95 % whisker per case, grouped by view.
//!
//! Dots in rows rather than grouped bars: a ratio has no zero on a logarithmic axis, and a row has
//! room for a variant's whole name. Cases without a time that counts stand at the right edge with
//! their outcome in words.

use super::canvas::{Anchor, Canvas, MARKER_PX, svg};
use super::palette::{INK, Palette};
use super::scale::{LogScale, tick_label};
use super::{WIDTH_PX, label, label_column};
use crate::ReportError;
use crate::number::significant;
use crate::run_data::{Case, SceneCases, ViewCases};
use crate::statistic::over;
use plotters::style::RGBColor;
use terrafill_results::legacy::{Spread, median};

const ROW_PX: f64 = 19.0;
/// Room above each view after the first.
const VIEW_GAP_PX: f64 = 8.0;
const TOP_PX: f64 = 26.0;
const AXIS_PX: f64 = 48.0;
const VALUE_COLUMN_PX: f64 = 190.0;

/// Fill time over the bound of the same run; `None` unless the picture is right and both were
/// measured.
pub(crate) fn ratio(case: &Case) -> Option<Spread> {
    let bound = case.value(|row| row.bound_cpu_ms).filter(|ms| *ms > 0.0)?;
    case.fill_cpu
        .filter(|_| case.counts())
        .map(|fill| over(fill, bound))
}

/// Median over a view's cases of floor over bound.
fn floor_ratio(view: &ViewCases<'_>) -> Option<f64> {
    let ratios: Vec<f64> = view
        .cases
        .iter()
        .filter_map(|case| case.value(|row| Some(row.floor_cpu_ms? / row.bound_cpu_ms?)))
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    median(&ratios)
}

/// Draws the plot; `None` when no case of the scene has a ratio.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn time_over_bound(
    scene: &SceneCases<'_>,
    palette: &Palette,
) -> Result<Option<String>, ReportError> {
    let cases = || scene.views.iter().flat_map(|view| &view.cases);
    let height: f64 = scene.views.iter().map(view_height).sum();
    let axis = BoundAxis::new(
        cases().filter_map(|case| ratio(case)),
        scene.views.iter().filter_map(floor_ratio),
        cases().map(|case| label(case)),
        VALUE_COLUMN_PX,
        [TOP_PX, TOP_PX + height],
    );
    let Some(axis) = axis else {
        return Ok(None);
    };
    let title = format!("{}: fill time over bound", scene.name);
    svg(&title, WIDTH_PX, axis.height(), |canvas| {
        axis.draw(canvas)?;
        let mut y = TOP_PX + ROW_PX * 0.5;
        for view in &scene.views {
            draw_view(canvas, view, palette, &axis, y)?;
            y += view_height(view);
        }
        Ok(())
    })
    .map(Some)
}

fn view_height(view: &ViewCases<'_>) -> f64 {
    ROW_PX * (view.cases.len() + 1) as f64 + VIEW_GAP_PX
}

/// The axis of time over bound, with a column of values at its right.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundAxis {
    pub(super) scale: LogScale,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl BoundAxis {
    /// An axis that holds `ratios` and the bound; `None` without a ratio.
    ///
    /// - `labels`: of the rows
    /// - `value_column`: room at the right
    /// - `[top, bottom]`: of the rows
    pub(super) fn new(
        ratios: impl Iterator<Item = Spread>,
        others: impl IntoIterator<Item = f64>,
        labels: impl IntoIterator<Item = String>,
        value_column: f64,
        [top, bottom]: [f64; 2],
    ) -> Option<Self> {
        let ratios: Vec<f64> = ratios.flat_map(|ratio| [ratio.p5, ratio.p95]).collect();
        if ratios.is_empty() {
            return None;
        }
        let (left, right) = (label_column(labels), WIDTH_PX - value_column);
        let values = ratios.into_iter().chain(others).chain([1.0]);
        Some(Self {
            scale: LogScale::around(values, 1.2, left, right - 14.0)?,
            left,
            right,
            top,
            bottom,
        })
    }

    /// Height of the drawing.
    pub(super) fn height(&self) -> f64 {
        self.bottom + AXIS_PX
    }

    pub(super) fn draw(&self, canvas: &Canvas<'_>) -> Result<(), ReportError> {
        let (top, bottom) = (self.top, self.bottom);
        for tick in self.scale.ticks() {
            let x = self.scale.px(tick);
            canvas.rule([x, top], [x, bottom], 0.12)?;
            canvas.text(&tick_label(tick), [x, bottom + 12.0], Anchor::Middle)?;
        }
        canvas.rule([self.left, bottom], [self.right, bottom], 0.6)?;
        canvas.text(
            "process CPU time of the fill ÷ that of the bound, median with 5–95 % of frames (logarithmic)",
            [self.left, bottom + 34.0],
            Anchor::Left,
        )?;
        let bound = self.scale.px(1.0);
        canvas.rule([bound, top - 6.0], [bound, bottom], 0.8)?;
        canvas.text("bound = 1", [bound, top - 14.0], Anchor::Middle)
    }

    /// A row's name, left of the axis.
    pub(super) fn draw_label(
        &self,
        canvas: &Canvas<'_>,
        label: &str,
        y: f64,
    ) -> Result<(), ReportError> {
        canvas.text(label, [self.left - 10.0, y], Anchor::Right)
    }

    /// What is said at the right of a row.
    pub(super) fn draw_value(
        &self,
        canvas: &Canvas<'_>,
        value: &str,
        y: f64,
    ) -> Result<(), ReportError> {
        canvas.text(value, [self.right + 10.0, y], Anchor::Left)
    }

    /// A row without a ratio, and why.
    pub(super) fn draw_absent(
        &self,
        canvas: &Canvas<'_>,
        why: &str,
        y: f64,
    ) -> Result<(), ReportError> {
        canvas.cross([self.right - MARKER_PX, y], INK)?;
        self.draw_value(canvas, why, y)
    }

    /// 5–95 % of frames.
    pub(super) fn draw_whisker(
        &self,
        canvas: &Canvas<'_>,
        ratio: Spread,
        y: f64,
        colour: RGBColor,
    ) -> Result<(), ReportError> {
        let [from, to] = [ratio.p5, ratio.p95].map(|value| [self.scale.px(value), y]);
        canvas.whisker(from, to, colour)
    }
}

fn draw_view(
    canvas: &Canvas<'_>,
    view: &ViewCases<'_>,
    palette: &Palette,
    axis: &BoundAxis,
    top: f64,
) -> Result<(), ReportError> {
    canvas.heading(view.name, [axis.left - 10.0, top], Anchor::Right)?;
    if let Some(floor) = floor_ratio(view) {
        let x = axis.scale.px(floor);
        let end = top + ROW_PX * (view.cases.len() as f64 + 0.4);
        canvas.dashes([x, top - ROW_PX * 0.4], [x, end])?;
        let note = format!("floor {} × (dashed)", significant(floor));
        axis.draw_value(canvas, &note, top)?;
    }
    for (case, row) in view.cases.iter().zip(1_u32..) {
        let y = top + ROW_PX * f64::from(row);
        axis.draw_label(canvas, &label(case), y)?;
        let stroke = palette.stroke(&case.series());
        let Some(spread) = ratio(case) else {
            axis.draw_absent(canvas, no_ratio(case), y)?;
            continue;
        };
        axis.draw_whisker(canvas, spread, y, stroke.colour)?;
        canvas.marker([axis.scale.px(spread.median), y], stroke)?;
        axis.draw_value(canvas, &format!("{} ×", significant(spread.median)), y)?;
    }
    Ok(())
}

/// Why a case has no dot.
fn no_ratio(case: &Case) -> &'static str {
    if !case.counts() {
        case.outcome.name()
    } else if case.fill_cpu.is_none() {
        "no fill time"
    } else {
        "no bound measured"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_data::Outcome;
    use terrafill_results::legacy::{CaseKey, Status, Summary};

    fn case(outcome: Outcome, bound_ms: Option<f64>) -> Case {
        let key = CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "vertex".to_owned(),
            variant: "doubled".to_owned(),
        };
        Case {
            summary: Some(Summary {
                bound_cpu_ms: bound_ms,
                floor_cpu_ms: Some(3.0),
                ..Summary::new(key.clone(), Status::Ok)
            }),
            key,
            outcome,
            fill_cpu_ms: vec![20.0],
            fill_cpu: Some(Spread {
                p5: 19.0,
                median: 20.0,
                p95: 22.0,
            }),
        }
    }

    #[test]
    fn the_ratio_is_fill_over_bound_and_only_for_right_pictures() {
        let right = ratio(&case(Outcome::Ok, Some(10.0))).expect("both were measured");
        assert!((right.median - 2.0).abs() < 1e-12 && (right.p95 - 2.2).abs() < 1e-12);
        assert_eq!(ratio(&case(Outcome::Wrong, Some(10.0))), None);
        assert_eq!(ratio(&case(Outcome::Ok, None)), None);
        assert_eq!(ratio(&case(Outcome::Ok, Some(0.0))), None);
        assert_eq!(no_ratio(&case(Outcome::Ok, None)), "no bound measured");
        assert_eq!(no_ratio(&case(Outcome::Wrong, None)), "wrong");
    }

    #[test]
    fn the_floor_is_over_the_same_bound() {
        let case = case(Outcome::Ok, Some(12.0));
        let view = ViewCases {
            name: "v",
            baselines: Vec::new(),
            cases: vec![&case],
        };
        let floor = floor_ratio(&view).expect("both were measured");
        assert!((floor - 0.25).abs() < 1e-12);
    }
}
