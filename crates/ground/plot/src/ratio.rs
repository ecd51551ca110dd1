// SPDX-License-Identifier: MIT OR Apache-2.0
//! Ratios to a baseline: a mark with its whisker per row, and below it a dot for each process, in groups.
//!
//! Dots in rows rather than grouped bars: a ratio has no zero on a logarithmic axis, and a row has
//! room for a variant's whole name. Rows without a ratio that counts stand at the right edge with
//! their reason in words.

use crate::canvas::{Anchor, Canvas, MARKER_PX, Spot, svg};
use crate::number::significant;
use crate::palette::{INK, Palette};
use crate::scale::{LogScale, tick_label};
use crate::{PlotError, WIDTH_PX, label, label_column};
use plotters::prelude::Color as _;
use plotters::style::RGBColor;
use terrafill_results::Spread;

const ROW_PX: f64 = 19.0;
/// From a row's mark down to the dots of its processes: the mark would hide those near the median.
const DOTS_BELOW_PX: f64 = 6.5;
/// Room above each group after the first.
const GROUP_GAP_PX: f64 = 8.0;
const TOP_PX: f64 = 26.0;
const AXIS_PX: f64 = 48.0;
const VALUE_COLUMN_PX: f64 = 210.0;
/// Seen, and no obstacle to what is drawn on it.
const TIE_OPACITY: f64 = 0.09;

/// What dots are where each is one process's.
pub const DOTS_OF_PROCESSES: &str = "small dots: one for each process";

/// What an axis of ratios says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RatioAxis<'a> {
    /// Below the axis.
    pub title: &'a str,
    /// Above the line at 1.
    pub one: &'a str,
}

/// A plot to be.
#[derive(Debug, Clone)]
pub struct RatioPlot<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the axis says.
    pub axis: RatioAxis<'a>,
    /// What small dots are, below the axis.
    pub dots: &'a str,
    /// Shaded: ratios from one over this factor to the factor, which are ties.
    pub tie_factor: Option<f64>,
    /// Top to bottom.
    pub groups: Vec<RatioGroup>,
}

/// Rows under one heading.
#[derive(Debug, Clone, Default)]
pub struct RatioGroup {
    /// The heading.
    pub name: String,
    /// A dashed line through the group, and what it is called.
    pub dashed: Option<(f64, String)>,
    /// Top to bottom.
    pub rows: Vec<RatioRow>,
}

/// A row.
#[derive(Debug, Clone)]
pub struct RatioRow {
    /// Left of the axis.
    pub label: String,
    /// Its curve as in the palette.
    pub series: String,
    /// The ratio with its whisker, or why there is none.
    pub ratio: Result<Spread, String>,
    /// The ratio of each process, or of each of what else the row is of; empty where they are not known.
    pub processes: Vec<f64>,
    /// At the right of a row with a ratio, behind it; empty for nothing.
    pub value: String,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

impl RatioPlot<'_> {
    /// Draws the plot; `None` when no row has a ratio.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self, palette: &Palette) -> Result<Option<String>, PlotError> {
        let rows = || self.groups.iter().flat_map(|group| &group.rows);
        let height: f64 = self.groups.iter().map(RatioGroup::height).sum();
        let frame = AxisFrame::new(
            self.axis,
            rows().filter_map(|row| row.ratio.as_ref().ok().copied()),
            self.groups
                .iter()
                .filter_map(|group| group.dashed.as_ref().map(|(at, _)| *at))
                .chain(rows().flat_map(|row| row.processes.iter().copied())),
            rows().map(|row| row.label.as_str()),
            VALUE_COLUMN_PX,
            [TOP_PX, TOP_PX + height],
        );
        let Some(frame) = frame else {
            return Ok(None);
        };
        svg(&self.title, WIDTH_PX, frame.height(), |canvas| {
            if let Some(factor) = self.tie_factor {
                frame.shade(canvas, factor)?;
            }
            frame.draw(canvas)?;
            if rows().any(|row| !row.processes.is_empty()) {
                frame.draw_value(canvas, self.dots, frame.bottom + 34.0)?;
            }
            let mut y = TOP_PX + ROW_PX * 0.5;
            for group in &self.groups {
                group.draw(canvas, palette, &frame, y)?;
                y += group.height();
            }
            Ok(())
        })
        .map(Some)
    }
}

impl RatioGroup {
    fn height(&self) -> f64 {
        ROW_PX * (self.rows.len() + 1) as f64 + GROUP_GAP_PX
    }

    fn draw(
        &self,
        canvas: &Canvas<'_>,
        palette: &Palette,
        frame: &AxisFrame<'_>,
        top: f64,
    ) -> Result<(), PlotError> {
        canvas.heading(&self.name, [frame.left - 10.0, top], Anchor::Right)?;
        if let Some((at, name)) = &self.dashed {
            let x = frame.scale.px(*at);
            let end = top + ROW_PX * (self.rows.len() as f64 + 0.4);
            canvas.dashes([x, top - ROW_PX * 0.4], [x, end])?;
            frame.draw_value(canvas, name, top)?;
        }
        for (row, number) in self.rows.iter().zip(1_u32..) {
            let y = top + ROW_PX * f64::from(number);
            frame.draw_label(canvas, &row.label, y)?;
            let stroke = palette.stroke(&row.series);
            match &row.ratio {
                Err(why) => frame.draw_absent(canvas, why, y)?,
                Ok(ratio) => {
                    frame.draw_whisker(canvas, *ratio, y, stroke.colour)?;
                    let dots = row.processes.iter().map(|process| frame.scale.px(*process));
                    canvas.dots(dots.map(|x| [x, y + DOTS_BELOW_PX]), stroke.colour)?;
                    let at = [frame.scale.px(ratio.median), y];
                    canvas.marker(at, stroke)?;
                    let value = format!("{} ×{}", significant(ratio.median), row.value);
                    frame.draw_value(canvas, &value, y)?;
                    canvas.spot(&Spot {
                        at,
                        group: &self.name,
                        name: &row.label,
                        values: &frame.values(*ratio),
                        command: &row.command,
                    });
                }
            }
        }
        Ok(())
    }
}

/// An axis of ratios with its place, and a column of values at its right.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AxisFrame<'a> {
    axis: RatioAxis<'a>,
    pub(crate) scale: LogScale,
    pub(crate) left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl<'a> AxisFrame<'a> {
    /// An axis that holds `ratios` and 1; `None` without a ratio.
    ///
    /// - `labels`: of the rows
    /// - `value_column`: room at the right
    /// - `[top, bottom]`: of the rows
    pub(crate) fn new<'l>(
        axis: RatioAxis<'a>,
        ratios: impl Iterator<Item = Spread>,
        others: impl IntoIterator<Item = f64>,
        labels: impl IntoIterator<Item = &'l str>,
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
            axis,
            scale: LogScale::around(values, 1.2, left, right - 14.0)?,
            left,
            right,
            top,
            bottom,
        })
    }

    /// Height of the drawing.
    pub(crate) fn height(&self) -> f64 {
        self.bottom + AXIS_PX
    }

    pub(crate) fn draw(&self, canvas: &Canvas<'_>) -> Result<(), PlotError> {
        let (top, bottom) = (self.top, self.bottom);
        for tick in self.scale.ticks() {
            let x = self.scale.px(tick);
            canvas.rule([x, top], [x, bottom], 0.12)?;
            canvas.text(&tick_label(tick), [x, bottom + 12.0], Anchor::Middle)?;
        }
        canvas.rule([self.left, bottom], [self.right, bottom], 0.6)?;
        canvas.text(self.axis.title, [self.left, bottom + 34.0], Anchor::Left)?;
        let one = self.scale.px(1.0);
        canvas.rule([one, top - 6.0], [one, bottom], 0.8)?;
        canvas.text(self.axis.one, [one, top - 14.0], Anchor::Middle)
    }

    /// Shades the ratios that are no further from 1 than `factor`.
    fn shade(&self, canvas: &Canvas<'_>, factor: f64) -> Result<(), PlotError> {
        let [from, to] = [factor.recip(), factor].map(|ratio| self.scale.px(ratio));
        canvas.bar([from, self.top], [to, self.bottom], INK.mix(TIE_OPACITY))
    }

    /// A ratio as a spot says it, with its whisker where it has one.
    pub(crate) fn values(&self, ratio: Spread) -> Vec<(&'a str, f64)> {
        let ends = [("from", ratio.p5), ("to", ratio.p95)];
        let ends = ends.into_iter().filter(|_| ratio.p5 < ratio.p95);
        std::iter::once((self.axis.title, ratio.median))
            .chain(ends)
            .collect()
    }

    /// A row's name, left of the axis.
    pub(crate) fn draw_label(
        &self,
        canvas: &Canvas<'_>,
        text: &str,
        y: f64,
    ) -> Result<(), PlotError> {
        canvas.text(&label(text), [self.left - 10.0, y], Anchor::Right)
    }

    /// What is said at the right of a row.
    pub(crate) fn draw_value(
        &self,
        canvas: &Canvas<'_>,
        value: &str,
        y: f64,
    ) -> Result<(), PlotError> {
        canvas.text(value, [self.right + 10.0, y], Anchor::Left)
    }

    /// A row without a ratio, and why.
    pub(crate) fn draw_absent(
        &self,
        canvas: &Canvas<'_>,
        why: &str,
        y: f64,
    ) -> Result<(), PlotError> {
        canvas.cross([self.right - MARKER_PX, y], INK)?;
        self.draw_value(canvas, why, y)
    }

    /// What the axis' title says of whiskers.
    pub(crate) fn draw_whisker(
        &self,
        canvas: &Canvas<'_>,
        ratio: Spread,
        y: f64,
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        let [from, to] = [ratio.p5, ratio.p95].map(|value| [self.scale.px(value), y]);
        canvas.whisker(from, to, colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: RatioAxis<'static> = RatioAxis {
        title: "time over baseline",
        one: "baseline = 1",
    };

    fn plot(rows: &[Result<f64, &str>]) -> RatioPlot<'static> {
        let row = |ratio: &Result<f64, &str>| RatioRow {
            label: "<vertex>/doubled".to_owned(),
            series: "a".to_owned(),
            ratio: ratio.map_err(str::to_owned).map(|median| Spread {
                p5: 0.9 * median,
                median,
                p95: 1.2 * median,
            }),
            processes: ratio.map_or_else(|_| Vec::new(), |median| vec![median, 2.0 * median]),
            value: " (tie)".to_owned(),
            command: "draw \"it\"".to_owned(),
        };
        RatioPlot {
            title: "ratios \"quoted\"".to_owned(),
            axis: AXIS,
            dots: DOTS_OF_PROCESSES,
            tie_factor: Some(1.1),
            groups: vec![RatioGroup {
                name: "globe".to_owned(),
                dashed: Some((0.3, "floor".to_owned())),
                rows: rows.iter().map(row).collect(),
            }],
        }
    }

    #[test]
    fn rows_have_their_ratio_or_their_reason() {
        let palette = Palette::new(vec!["a".to_owned()]);
        let drawn = |rows: &[Result<f64, &str>]| plot(rows).draw(&palette).expect("draws");
        let text = drawn(&[Ok(3.61), Err("wrong")]).expect("a ratio");
        for word in ["3.61 × (tie)", "wrong", "baseline = 1", "floor", "globe"] {
            assert!(text.contains(word), "{word}");
        }
        assert!(text.contains("data-command=\"draw &quot;it&quot;\""));
        assert!(
            text.contains("group,name,time over baseline,from,to\nglobe,&lt;vertex>/doubled,3.61,")
        );
        assert!(!text.contains("<vertex>"), "names are no markup");
        // The mark and a dot for each process, on an axis that holds them.
        let circles = text.split("<circle cx=\"").skip(1);
        let across: Vec<f64> = circles
            .filter_map(|circle| circle.split('"').next()?.parse().ok())
            .collect();
        assert_eq!(across.len(), 3, "{text}");
        let right = WIDTH_PX - VALUE_COLUMN_PX;
        assert!(across[0] < across[1] && across[1] < right, "{across:?}");
        assert!(text.contains("small dots"));
        // Negative controls: the same rows without the failed one, and without any ratio.
        assert!(!drawn(&[Ok(3.61)]).expect("a ratio").contains("wrong"));
        assert_eq!(drawn(&[Err("wrong")]), None);
    }
}
