// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes as bars, one per row, stacked by purpose.
//!
//! A row keeps its colour from the other plots; the purposes are shades of it.

use crate::canvas::{Anchor, Canvas, Spot, TEXT_PX, svg, text_width};
use crate::palette::{INK, Palette};
use crate::scale::{linear_ticks, whole};
use crate::{PlotError, WIDTH_PX, label, label_column, number};
use plotters::prelude::Color as _;

const ROW_PX: f64 = 24.0;
const TOP_PX: f64 = 34.0;
const AXIS_PX: f64 = 48.0;
const VALUE_COLUMN_PX: f64 = 190.0;

/// Opacity of each purpose, from the axis outwards.
const OPACITIES: [f64; 3] = [1.0, 0.6, 0.3];

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Bars<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// Below the axis.
    pub axis: &'a str,
    /// Purposes, from the axis outwards.
    pub parts: [&'a str; 3],
    /// Top to bottom.
    pub rows: Vec<Bar>,
}

/// A row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bar {
    /// Left of the axis.
    pub label: String,
    /// Its curve as in the palette.
    pub series: String,
    /// Bytes of each purpose.
    pub parts: [u64; 3],
    /// At the right of the row.
    pub value: String,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

impl Bar {
    fn total(&self) -> u64 {
        self.parts.iter().sum()
    }
}

impl Bars<'_> {
    /// Draws the plot; `None` when no row has bytes.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self, palette: &Palette) -> Result<Option<String>, PlotError> {
        let most = self.rows.iter().map(Bar::total).max().unwrap_or(0);
        if most == 0 {
            return Ok(None);
        }
        let left = label_column(self.rows.iter().map(|row| row.label.as_str()));
        let right = WIDTH_PX - VALUE_COLUMN_PX;
        let bottom = TOP_PX + self.rows.len() as f64 * ROW_PX;
        svg(&self.title, WIDTH_PX, bottom + AXIS_PX, |canvas| {
            let scale = (right - left - 6.0) / most as f64;
            self.draw_legend(canvas, left)?;
            for tick in linear_ticks(0.0, most as f64) {
                let x = left + tick * scale;
                canvas.rule([x, TOP_PX], [x, bottom], 0.12)?;
                let bytes = number::bytes(whole(tick));
                canvas.text(&bytes, [x, bottom + 12.0], Anchor::Middle)?;
            }
            canvas.rule([left, TOP_PX], [left, bottom], 0.6)?;
            canvas.text(self.axis, [left, bottom + 34.0], Anchor::Left)?;
            for (row, number) in self.rows.iter().zip(0_u32..) {
                let y = TOP_PX + ROW_PX * (f64::from(number) + 0.5);
                canvas.text(&label(&row.label), [left - 10.0, y], Anchor::Right)?;
                let colour = palette.stroke(&row.series).colour;
                let mut x = left;
                for (part, opacity) in row.parts.iter().zip(OPACITIES) {
                    let end = x + *part as f64 * scale;
                    canvas.bar([x, y - 7.0], [end, y + 7.0], colour.mix(opacity))?;
                    x = end;
                }
                canvas.text(&row.value, [right + 10.0, y], Anchor::Left)?;
                let values: Vec<(&str, f64)> = self
                    .parts
                    .into_iter()
                    .zip(row.parts.map(|bytes| bytes as f64))
                    .collect();
                canvas.spot(&Spot {
                    at: [x, y],
                    group: "",
                    name: &row.label,
                    values: &values,
                    command: &row.command,
                });
            }
            Ok(())
        })
        .map(Some)
    }

    fn draw_legend(&self, canvas: &Canvas<'_>, left: f64) -> Result<(), PlotError> {
        let mut x = left;
        for (name, opacity) in self.parts.iter().zip(OPACITIES) {
            canvas.bar([x, 8.0], [x + 14.0, 20.0], INK.mix(opacity))?;
            canvas.text(name, [x + 20.0, 14.0], Anchor::Left)?;
            x += 60.0 + text_width(name, TEXT_PX);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_bar_and_bytes_of_nothing_are_no_plot() {
        let bar = |bytes: u64| Bar {
            label: "vertex/doubled".to_owned(),
            series: "vertex/doubled".to_owned(),
            parts: [bytes, bytes / 2, 0],
            value: format!("{bytes} in all"),
            command: String::new(),
        };
        let drawn = |rows: Vec<Bar>| {
            let bars = Bars {
                title: "bytes".to_owned(),
                axis: "bytes on the device",
                parts: ["positions", "indices", "constants"],
                rows,
            };
            bars.draw(&Palette::new(Vec::new())).expect("draws")
        };
        let text = drawn(vec![bar(1_000), bar(500)]).expect("bytes");
        assert!(text.contains("1000 in all") && text.contains("500 in all"));
        assert_eq!(drawn(vec![bar(0)]), None);
    }
}
