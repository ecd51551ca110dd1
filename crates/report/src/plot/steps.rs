// SPDX-License-Identifier: MIT OR Apache-2.0
//! A ladder as steps: time over bound of each rung, one bar a rung, from the first to the last.
//!
//! Bars start at the left edge of a logarithmic axis, which has no zero: their ends are what is read,
//! and the steps between the ends are the gains.

use super::canvas::{Anchor, Canvas, MARKER_PX, svg};
use super::palette::{INK, hue};
use super::ratio::ratio;
use super::scale::{LogScale, tick_label};
use super::{WIDTH_PX, label_column};
use crate::ReportError;
use crate::ladder::RungData;
use crate::number::significant;
use crate::run_data::Case;
use plotters::prelude::Color as _;

const ROW_PX: f64 = 21.0;
const TOP_PX: f64 = 30.0;
const AXIS_PX: f64 = 48.0;
const VALUE_COLUMN_PX: f64 = 210.0;

/// Draws the plot; `None` when no rung has a ratio.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn ladder_steps(
    title: &str,
    rungs: &[RungData<'_>],
) -> Result<Option<String>, ReportError> {
    let spreads: Vec<f64> = rungs
        .iter()
        .filter_map(|rung| ratio(rung.case?))
        .flat_map(|spread| [spread.p5, spread.p95])
        .collect();
    if spreads.is_empty() {
        return Ok(None);
    }
    let label = |rung: &RungData<'_>| format!("{} · {}", rung.rung.rung, rung.rung.step);
    let left = label_column(rungs.iter().map(label));
    let right = WIDTH_PX - VALUE_COLUMN_PX;
    let values = spreads.iter().copied().chain([1.0]);
    let Some(scale) = LogScale::around(values, 1.2, left, right - 14.0) else {
        return Ok(None);
    };
    let bottom = TOP_PX + ROW_PX * rungs.len() as f64;
    let title = format!("{title}: time over bound, rung by rung");
    svg(&title, WIDTH_PX, bottom + AXIS_PX, |canvas| {
        draw_axis(canvas, &scale, [left, right], bottom)?;
        let mut end_before: Option<f64> = None;
        for (rung, row) in rungs.iter().zip(0_u32..) {
            let y = TOP_PX + ROW_PX * (f64::from(row) + 0.5);
            canvas.text(&label(rung), [left - 10.0, y], Anchor::Right)?;
            let Some(spread) = rung.case.and_then(ratio) else {
                canvas.cross([right - MARKER_PX, y], INK)?;
                let outcome = rung
                    .case
                    .map_or("missing", |case: &Case| case.outcome.name());
                canvas.text(outcome, [right + 10.0, y], Anchor::Left)?;
                continue;
            };
            let end = scale.px(spread.median);
            canvas.bar([left, y - 6.0], [end, y + 6.0], hue(0).mix(0.8))?;
            if let Some(before) = end_before {
                canvas.rule([before, y - ROW_PX * 0.5], [end, y - ROW_PX * 0.5], 0.7)?;
            }
            end_before = Some(end);
            canvas.whisker(scale.px(spread.p5), scale.px(spread.p95), y, INK)?;
            canvas.text(
                &value_label(rung, spread.median),
                [right + 10.0, y],
                Anchor::Left,
            )?;
        }
        Ok(())
    })
    .map(Some)
}

fn value_label(rung: &RungData<'_>, ratio: f64) -> String {
    match rung.gain {
        Some(gain) => format!(
            "{} × · gain {}",
            significant(ratio),
            significant(gain.middle)
        ),
        None => format!("{} ×", significant(ratio)),
    }
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
