// SPDX-License-Identifier: MIT OR Apache-2.0
//! A ladder as steps: time over bound of each rung, one bar a rung, from the first to the last.
//!
//! Bars start at the left edge of a logarithmic axis, which has no zero: their ends are what is read,
//! and the steps between the ends are the gains.

use super::WIDTH_PX;
use super::canvas::svg;
use super::palette::{INK, hue};
use super::ratio::{BoundAxis, ratio};
use crate::ReportError;
use crate::ladder::RungData;
use crate::number::significant;
use crate::run_data::Case;
use plotters::prelude::Color as _;

const ROW_PX: f64 = 21.0;
const TOP_PX: f64 = 30.0;
const VALUE_COLUMN_PX: f64 = 210.0;

/// Draws the plot; `None` when no rung has a ratio.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn ladder_steps(
    title: &str,
    rungs: &[RungData<'_>],
) -> Result<Option<String>, ReportError> {
    let label = |rung: &RungData<'_>| format!("{} · {}", rung.rung.rung, rung.rung.step);
    let axis = BoundAxis::new(
        rungs.iter().filter_map(|rung| ratio(rung.case?)),
        [],
        rungs.iter().map(label),
        VALUE_COLUMN_PX,
        [TOP_PX, TOP_PX + ROW_PX * rungs.len() as f64],
    );
    let Some(axis) = axis else {
        return Ok(None);
    };
    let title = format!("{title}: time over bound, rung by rung");
    svg(&title, WIDTH_PX, axis.height(), |canvas| {
        axis.draw(canvas)?;
        let mut end_before: Option<f64> = None;
        for (rung, row) in rungs.iter().zip(0_u32..) {
            let y = TOP_PX + ROW_PX * (f64::from(row) + 0.5);
            axis.draw_label(canvas, &label(rung), y)?;
            let Some(spread) = rung.case.and_then(ratio) else {
                let outcome = rung
                    .case
                    .map_or("missing", |case: &Case| case.outcome.name());
                axis.draw_absent(canvas, outcome, y)?;
                continue;
            };
            let end = axis.scale.px(spread.median);
            canvas.bar([axis.left, y - 6.0], [end, y + 6.0], hue(0).mix(0.8))?;
            if let Some(before) = end_before {
                canvas.rule([before, y - ROW_PX * 0.5], [end, y - ROW_PX * 0.5], 0.7)?;
            }
            end_before = Some(end);
            axis.draw_whisker(canvas, spread, y, INK)?;
            axis.draw_value(canvas, &value_label(rung, spread.median), y)?;
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
