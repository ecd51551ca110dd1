// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact amounts over exact amounts, one line a name, both axes logarithmic; a ringed mark is a point
//! beside its line.

use crate::canvas::{Spot, svg};
use crate::log_log::{
    AxisText, Frame, LINE_OPACITY, draw_across, draw_names_aside, draw_up, names_width,
};
use crate::palette::Palette;
use crate::scale::{LogScale, whole};
use crate::{PlotError, WIDTH_PX};
use plotters::prelude::Color as _;

const HEIGHT_PX: f64 = 430.0;
const LEFT_PX: f64 = 84.0;
const TOP_PX: f64 = 16.0;
const AXIS_PX: f64 = 50.0;

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the horizontal axis shows.
    pub across: &'a str,
    /// A tick of it as printed.
    pub across_tick: fn(u64) -> String,
    /// What the vertical axis shows.
    pub up: &'a str,
    /// A tick of it as printed.
    pub up_tick: fn(u64) -> String,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Beside its right end.
    pub name: String,
    /// Left to right.
    pub points: Vec<[f64; 2]>,
    /// A point that need not lie on it.
    pub ringed: Option<[f64; 2]>,
}

impl Lines<'_> {
    /// Draws the plot; `None` without a point.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self) -> Result<Option<String>, PlotError> {
        let names: Vec<String> = self.lines.iter().map(|line| line.name.clone()).collect();
        let frame = Frame {
            left: LEFT_PX,
            right: WIDTH_PX - names_width(names.iter().map(String::as_str)),
            top: TOP_PX,
            bottom: HEIGHT_PX - AXIS_PX,
        };
        // A ringed point may be smaller than all of the lines.
        let points = || {
            let lines = self.lines.iter();
            lines.flat_map(|line| line.points.iter().chain(&line.ringed))
        };
        let across = LogScale::around(points().map(|point| point[0]), 1.1, frame.left, frame.right);
        let up = LogScale::around(points().map(|point| point[1]), 1.3, frame.bottom, frame.top);
        let (Some(across), Some(up)) = (across, up) else {
            return Ok(None);
        };
        let ends = self.lines.iter().filter_map(|line| {
            let end = line.points.last()?;
            Some((up.px(end[1]), line.name.as_str(), line.name.clone()))
        });
        let palette = Palette::new(names);
        svg(&self.title, WIDTH_PX, HEIGHT_PX, |canvas| {
            let text = |title, tick| AxisText { title, tick };
            let across_tick = |tick: f64| (self.across_tick)(whole(tick));
            let up_tick = |tick: f64| (self.up_tick)(whole(tick));
            let reach = [frame.top, frame.bottom];
            draw_across(canvas, frame, &across, text(self.across, &across_tick))?;
            draw_up(canvas, frame, Some(&up), reach, text(self.up, &up_tick))?;
            let corners = [frame.left, frame.right].map(|x| [x, frame.bottom]);
            canvas.rule(corners[0], corners[1], 0.6)?;
            for line in &self.lines {
                let stroke = palette.stroke(&line.name);
                let at = |point: &[f64; 2]| [across.px(point[0]), up.px(point[1])];
                let path: Vec<[f64; 2]> = line.points.iter().map(at).collect();
                canvas.path(&path, stroke.colour.mix(LINE_OPACITY), 2)?;
                for point in line.points.iter().chain(&line.ringed) {
                    canvas.spot(&Spot {
                        at: at(point),
                        group: "",
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
            draw_names_aside(canvas, frame, ends.collect(), &palette)
        })
        .map(Some)
    }
}
