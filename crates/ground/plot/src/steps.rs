// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ratios as a waterfall, one row a step, from the first to the last.
//!
//! A row's bar goes from the ratio of the row before to its own, which has a dot: its length on the
//! logarithmic axis is the gain. No bar stands on the axis' edge, which is no zero.

use crate::canvas::{Spot, svg};
use crate::palette::{FASTER, INK, SLOWER};
use crate::ratio::{AxisFrame, RatioAxis};
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;
use terrafill_results::Spread;

const ROW_PX: f64 = 21.0;
const TOP_PX: f64 = 30.0;
const VALUE_COLUMN_PX: f64 = 210.0;
/// Half the height of a bar.
const BAR_PX: f64 = 6.0;

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Steps<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the axis says.
    pub axis: RatioAxis<'a>,
    /// Top to bottom.
    pub rows: Vec<Step>,
}

/// A row.
#[derive(Debug, Clone)]
pub struct Step {
    /// Left of the axis.
    pub label: String,
    /// The ratio, or why there is none.
    pub ratio: Result<Spread, String>,
    /// At the right of a row with a ratio.
    pub value: String,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

impl Steps<'_> {
    /// Draws the plot; `None` when no row has a ratio.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self) -> Result<Option<String>, PlotError> {
        let frame = AxisFrame::new(
            self.axis,
            self.rows
                .iter()
                .filter_map(|row| row.ratio.as_ref().ok().copied()),
            [],
            self.rows.iter().map(|row| row.label.as_str()),
            VALUE_COLUMN_PX,
            [TOP_PX, TOP_PX + ROW_PX * self.rows.len() as f64],
        );
        let Some(frame) = frame else {
            return Ok(None);
        };
        svg(&self.title, WIDTH_PX, frame.height(), |canvas| {
            frame.draw(canvas)?;
            let mut end_before: Option<f64> = None;
            for (row, number) in self.rows.iter().zip(0_u32..) {
                let y = TOP_PX + ROW_PX * (f64::from(number) + 0.5);
                frame.draw_label(canvas, &row.label, y)?;
                let ratio = match &row.ratio {
                    Ok(ratio) => *ratio,
                    Err(why) => {
                        frame.draw_absent(canvas, why, y)?;
                        continue;
                    }
                };
                let end = frame.scale.px(ratio.median);
                let before = end_before.unwrap_or(end);
                let stroke = if end > before { SLOWER } else { FASTER };
                canvas.bar(
                    [before, y - BAR_PX],
                    [end, y + BAR_PX],
                    stroke.colour.mix(0.55),
                )?;
                if end_before.is_some() {
                    canvas.rule([before, y - ROW_PX + BAR_PX], [before, y + BAR_PX], 0.5)?;
                }
                end_before = Some(end);
                frame.draw_whisker(canvas, ratio, y, INK)?;
                let at = [end, y];
                canvas.marker(at, stroke)?;
                canvas.spot(&Spot {
                    at,
                    group: "",
                    name: &row.label,
                    values: &frame.values(ratio),
                    command: &row.command,
                });
                frame.draw_value(canvas, &row.value, y)?;
            }
            Ok(())
        })
        .map(Some)
    }
}
