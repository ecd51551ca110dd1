// SPDX-License-Identifier: MIT OR Apache-2.0
//! Series over equal steps in small panels, each on its own linear axis: how a loop answers to a step. Values stand
//! on stairs, since between two steps there is none.

use crate::canvas::{Anchor, Canvas, svg};
use crate::number::significant;
use crate::palette::INK;
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;

/// As many panels side by side.
const COLUMNS: usize = 4;
const PANEL_PX: f64 = WIDTH_PX / COLUMNS as f64;
const LEFT_PX: f64 = 58.0;
const RIGHT_PX: f64 = 10.0;
const TITLE_PX: f64 = 24.0;
const HEIGHT_PX: f64 = 96.0;
const AXIS_PX: f64 = 30.0;
/// A series that does not move would lie on an edge.
const MIN_RANGE: f64 = 1e-9;

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Courses<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What a step is, as `frames`.
    pub across: &'a str,
    /// Left to right, then downwards.
    pub panels: Vec<Course>,
}

/// A panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Above it.
    pub name: String,
    /// From the first step; what is not finite is left out.
    pub values: Vec<f64>,
    /// A dashed line, such as what a loop is to reach.
    pub wanted: Option<f64>,
}

impl Courses<'_> {
    /// Draws the plot; `None` without a value.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self) -> Result<Option<String>, PlotError> {
        let has_value = |panel: &Course| panel.values.iter().any(|value| value.is_finite());
        let panels: Vec<&Course> = self
            .panels
            .iter()
            .filter(|panel| has_value(panel))
            .collect();
        if panels.is_empty() {
            return Ok(None);
        }
        let row_px = TITLE_PX + HEIGHT_PX + AXIS_PX;
        let height = panels.len().div_ceil(COLUMNS) as f64 * row_px;
        svg(&self.title, WIDTH_PX, height, |canvas| {
            for (at, panel) in panels.iter().enumerate() {
                let left = (at % COLUMNS) as f64 * PANEL_PX;
                let top = (at / COLUMNS) as f64 * row_px + TITLE_PX;
                self.draw_panel(canvas, panel, [left + LEFT_PX, top])?;
            }
            Ok(())
        })
        .map(Some)
    }

    fn draw_panel(
        &self,
        canvas: &Canvas<'_>,
        panel: &Course,
        [left, top]: [f64; 2],
    ) -> Result<(), PlotError> {
        let (right, bottom) = (left + PANEL_PX - LEFT_PX - RIGHT_PX, top + HEIGHT_PX);
        let finite = panel
            .values
            .iter()
            .copied()
            .filter(|value| value.is_finite());
        let all = finite.chain(panel.wanted);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let range = (high - low).max(MIN_RANGE);
        let steps = panel.values.len().max(1) as f64;
        let x = |step: usize| left + (right - left) * step as f64 / steps;
        let y = |value: f64| bottom - (value - low) / range * (bottom - top);
        canvas.heading(&panel.name, [left, top - 12.0], Anchor::Left)?;
        canvas.rule([left, bottom], [right, bottom], 0.6)?;
        canvas.rule([left, top], [left, bottom], 0.6)?;
        for (value, at) in [(low, bottom), (high, top)] {
            canvas.text(&significant(value), [left - 6.0, at], Anchor::Right)?;
        }
        let last = format!("{} {}", panel.values.len().saturating_sub(1), self.across);
        canvas.text(&last, [right, bottom + 14.0], Anchor::Right)?;
        if let Some(wanted) = panel.wanted {
            canvas.dashes([left, y(wanted)], [right, y(wanted)])?;
        }
        let mut stairs = Vec::new();
        for (step, value) in panel.values.iter().enumerate() {
            if value.is_finite() {
                stairs.extend([[x(step), y(*value)], [x(step + 1), y(*value)]]);
            }
        }
        canvas.path(&stairs, INK.mix(1.0), 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(values: &[f64], wanted: Option<f64>) -> Option<String> {
        let plot = Courses {
            title: "a loop".to_owned(),
            across: "frames",
            panels: vec![Course {
                name: "step <1>".to_owned(),
                values: values.to_vec(),
                wanted,
            }],
        };
        plot.draw().expect("a plot")
    }

    #[test]
    fn a_course_has_stairs_its_range_and_what_is_wanted() {
        let text = drawn(&[0.0, 3.0, 1.0], Some(2.0)).expect("a drawing");
        assert!(
            text.contains("2 frames") && text.contains(">3.00<") && text.contains(">0<"),
            "{text}"
        );
        assert!(
            text.contains("stroke-dasharray") && text.contains("&lt;1&gt;"),
            "{text}"
        );
        let stairs = text.matches("polyline").count();
        assert!(stairs >= 4, "{text}");
        // Negative controls: nothing wanted, no range, no value.
        let plain = drawn(&[0.0, 3.0, 1.0], None).expect("a drawing");
        assert!(!plain.contains("stroke-dasharray"));
        assert!(!drawn(&[1.0, 1.0], None).expect("a drawing").contains("NaN"));
        assert_eq!(drawn(&[], None), None);
        assert_eq!(drawn(&[f64::NAN], None), None);
    }
}
