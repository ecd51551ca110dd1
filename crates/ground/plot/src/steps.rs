// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ratios as steps, one bar a row, from the first to the last.
//!
//! Bars start at the left edge of a logarithmic axis, which has no zero: their ends are what is read,
//! and the steps between the ends are the gains.

use crate::canvas::svg;
use crate::palette::{INK, hue};
use crate::ratio::{AxisFrame, RatioAxis};
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;
use terrafill_results::Spread;

const ROW_PX: f64 = 21.0;
const TOP_PX: f64 = 30.0;
const VALUE_COLUMN_PX: f64 = 210.0;

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
                canvas.bar([frame.left, y - 6.0], [end, y + 6.0], hue(0).mix(0.8))?;
                if let Some(before) = end_before {
                    let between = y - ROW_PX * 0.5;
                    canvas.rule([before, between], [end, between], 0.7)?;
                }
                end_before = Some(end);
                frame.draw_whisker(canvas, ratio, y, INK)?;
                frame.draw_value(canvas, &row.value, y)?;
            }
            Ok(())
        })
        .map(Some)
    }
}
