// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact amounts over exact amounts in small panels, one line a name, both axes logarithmic and the
//! same in all panels. A ringed mark is a point beside its line.

use crate::canvas::{Anchor, Canvas, Spot, svg};
use crate::log_log::{
    AxisText, Frame, LINE_OPACITY, NAME_PX, draw_across, draw_name, draw_up, names_below,
};
use crate::palette::Palette;
use crate::scale::{LogScale, whole};
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;

/// As many panels side by side.
const COLUMNS: usize = 3;
const PANEL_PX: f64 = WIDTH_PX / COLUMNS as f64;
/// Room for ticks and title left of a panel.
const LEFT_PX: f64 = 78.0;
const RIGHT_PX: f64 = 12.0;
/// Height of a panel, and of its title above and its axis below.
const HEIGHT_PX: f64 = 190.0;
const TITLE_PX: f64 = 30.0;
const AXIS_PX: f64 = 48.0;
/// From the top of the drawing to the middle of the names' first line.
const LEGEND_PX: f64 = 12.0;

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the horizontal axes show.
    pub across: &'a str,
    /// A tick of them as printed.
    pub across_tick: fn(u64) -> String,
    /// What the vertical axes show.
    pub up: &'a str,
    /// A tick of them as printed.
    pub up_tick: fn(u64) -> String,
    /// Left to right, then downwards.
    pub panels: Vec<LinePanel>,
}

/// A panel.
#[derive(Debug, Clone, PartialEq)]
pub struct LinePanel {
    /// Above it.
    pub name: String,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// As in the palette.
    pub name: String,
    /// Left to right.
    pub points: Vec<[f64; 2]>,
    /// A point that need not lie on it.
    pub ringed: Option<[f64; 2]>,
}

impl Line {
    fn all(&self) -> impl Iterator<Item = &[f64; 2]> {
        self.points.iter().chain(&self.ringed)
    }
}

impl Lines<'_> {
    /// Draws the plot; `None` without a point.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self, palette: &Palette) -> Result<Option<String>, PlotError> {
        let lines = || self.panels.iter().flat_map(|panel| &panel.lines);
        let mut names: Vec<String> = lines().map(|line| line.name.clone()).collect();
        names.sort_unstable();
        names.dedup();
        let legend = names_below(&names, [LEFT_PX * 0.5, LEGEND_PX]);
        let top = legend.last().map_or(LEGEND_PX, |(at, _)| at[1]) + NAME_PX;
        let row_px = TITLE_PX + HEIGHT_PX + AXIS_PX;
        let frame = |index: usize| {
            let left = (index % COLUMNS) as f64 * PANEL_PX;
            let above = top + (index / COLUMNS) as f64 * row_px + TITLE_PX;
            Frame {
                left: left + LEFT_PX,
                right: left + PANEL_PX - RIGHT_PX,
                top: above,
                bottom: above + HEIGHT_PX,
            }
        };
        let values = |axis: usize| lines().flat_map(Line::all).map(move |point| point[axis]);
        let is_drawn = |axis| LogScale::around(values(axis), 1.1, 0.0, 1.0).is_some();
        if !(is_drawn(0) && is_drawn(1)) {
            return Ok(None);
        }
        let height = top + self.panels.len().div_ceil(COLUMNS) as f64 * row_px;
        svg(&self.title, WIDTH_PX, height, |canvas| {
            for ((at, text), name) in legend.iter().zip(&names) {
                draw_name(canvas, text, *at, palette.stroke(name))?;
            }
            for (index, panel) in self.panels.iter().enumerate() {
                let frame = frame(index);
                let across = LogScale::around(values(0), 1.1, frame.left, frame.right);
                let up = LogScale::around(values(1), 1.3, frame.bottom, frame.top);
                if let Some(scales) = across.zip(up) {
                    self.draw_panel(canvas, palette, panel, frame, scales)?;
                }
            }
            Ok(())
        })
        .map(Some)
    }

    fn draw_panel(
        &self,
        canvas: &Canvas<'_>,
        palette: &Palette,
        panel: &LinePanel,
        frame: Frame,
        (across, up): (LogScale, LogScale),
    ) -> Result<(), PlotError> {
        let text = |title, tick| AxisText { title, tick };
        let across_tick = |tick: f64| (self.across_tick)(whole(tick));
        let up_tick = |tick: f64| (self.up_tick)(whole(tick));
        let reach = [frame.top, frame.bottom];
        canvas.heading(&panel.name, [frame.left, frame.top - 14.0], Anchor::Left)?;
        draw_across(canvas, frame, &across, text(self.across, &across_tick))?;
        draw_up(canvas, frame, Some(&up), reach, text(self.up, &up_tick))?;
        let corners = [frame.left, frame.right].map(|x| [x, frame.bottom]);
        canvas.rule(corners[0], corners[1], 0.6)?;
        for line in &panel.lines {
            let stroke = palette.stroke(&line.name);
            let at = |point: &[f64; 2]| [across.px(point[0]), up.px(point[1])];
            let path: Vec<[f64; 2]> = line.points.iter().map(at).collect();
            canvas.path(&path, stroke.colour.mix(LINE_OPACITY), 2)?;
            for point in line.all() {
                canvas.spot(&Spot {
                    at: at(point),
                    group: &panel.name,
                    name: &line.name,
                    values: &[(self.across, point[0]), (self.up, point[1])],
                    command: "",
                });
            }
            if let Some(point) = &line.ringed {
                canvas.marker(at(point), stroke)?;
                canvas.ring(at(point))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_its_lines_and_no_point_is_no_plot() {
        let drawn = |points: &[[f64; 2]]| {
            let panel = |name: &str| LinePanel {
                name: name.to_owned(),
                lines: vec![Line {
                    name: "a".to_owned(),
                    points: points.to_vec(),
                    ringed: None,
                }],
            };
            let plot = Lines {
                title: "bytes".to_owned(),
                across: "regions",
                across_tick: crate::number::count,
                up: "bytes",
                up_tick: crate::number::bytes,
                panels: ["one", "two"].map(panel).into(),
            };
            let palette = Palette::new(vec!["a".to_owned()]);
            plot.draw(&palette).expect("draws")
        };
        let svg = drawn(&[[1.0, 100.0], [5.0, 500.0]]).expect("points");
        assert!(
            svg.contains("one,a,1,100\none,a,5,500\ntwo,a,1,100\n"),
            "{svg}"
        );
        // Twin.
        assert_eq!(drawn(&[]), None);
    }
}
