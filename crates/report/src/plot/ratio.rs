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
use terrafill_results::{Spread, median};

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
    let left = label_column(cases().map(|case| label(case)));
    let right = WIDTH_PX - VALUE_COLUMN_PX;
    let spreads: Vec<f64> = cases()
        .filter_map(|case| ratio(case))
        .flat_map(|spread| [spread.p5, spread.p95])
        .collect();
    if spreads.is_empty() {
        return Ok(None);
    }
    let floors = scene.views.iter().filter_map(floor_ratio);
    let values = spreads.iter().copied().chain(floors).chain([1.0]);
    let Some(scale) = LogScale::around(values, 1.2, left, right - 14.0) else {
        return Ok(None);
    };
    let height: f64 = scene.views.iter().map(view_height).sum();
    let bottom = TOP_PX + height;
    let title = format!("{}: fill time over bound", scene.name);
    svg(&title, WIDTH_PX, bottom + AXIS_PX, |canvas| {
        draw_axis(canvas, &scale, [left, right], bottom)?;
        let mut y = TOP_PX + ROW_PX * 0.5;
        for view in &scene.views {
            draw_view(canvas, view, palette, &scale, [left, right], y)?;
            y += view_height(view);
        }
        Ok(())
    })
    .map(Some)
}

fn view_height(view: &ViewCases<'_>) -> f64 {
    ROW_PX * (view.cases.len() + 1) as f64 + VIEW_GAP_PX
}

fn draw_axis(
    canvas: &Canvas<'_>,
    scale: &LogScale,
    [left, right]: [f64; 2],
    bottom: f64,
) -> Result<(), ReportError> {
    for tick in scale.ticks() {
        let x = scale.px(tick);
        canvas.rule([x, TOP_PX], [x, bottom], 0.12)?;
        canvas.text(&tick_label(tick), [x, bottom + 12.0], Anchor::Middle)?;
    }
    canvas.rule([left, bottom], [right, bottom], 0.6)?;
    canvas.text(
        "process CPU time of the fill ÷ that of the bound, median with 5–95 % of frames (logarithmic)",
        [left, bottom + 34.0],
        Anchor::Left,
    )?;
    let bound = scale.px(1.0);
    canvas.rule([bound, TOP_PX - 6.0], [bound, bottom], 0.8)?;
    canvas.text("bound = 1", [bound, TOP_PX - 14.0], Anchor::Middle)
}

fn draw_view(
    canvas: &Canvas<'_>,
    view: &ViewCases<'_>,
    palette: &Palette,
    scale: &LogScale,
    [left, right]: [f64; 2],
    top: f64,
) -> Result<(), ReportError> {
    canvas.heading(view.name, [left - 10.0, top], Anchor::Right)?;
    let value_x = right + 10.0;
    if let Some(floor) = floor_ratio(view) {
        let x = scale.px(floor);
        let end = top + ROW_PX * (view.cases.len() as f64 + 0.4);
        canvas.dashes([x, top - ROW_PX * 0.4], [x, end])?;
        let note = format!("floor {} × (dashed)", significant(floor));
        canvas.text(&note, [value_x, top], Anchor::Left)?;
    }
    for (case, row) in view.cases.iter().zip(1_u32..) {
        let y = top + ROW_PX * f64::from(row);
        canvas.text(&label(case), [left - 10.0, y], Anchor::Right)?;
        let stroke = palette.stroke(&case.series());
        let Some(spread) = ratio(case) else {
            canvas.cross([right - MARKER_PX, y], INK)?;
            canvas.text(no_ratio(case), [value_x, y], Anchor::Left)?;
            continue;
        };
        canvas.whisker(scale.px(spread.p5), scale.px(spread.p95), y, stroke.colour)?;
        canvas.marker([scale.px(spread.median), y], stroke)?;
        let value = format!("{} ×", significant(spread.median));
        canvas.text(&value, [value_x, y], Anchor::Left)?;
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
    use terrafill_results::{CaseKey, Status, Summary};

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
