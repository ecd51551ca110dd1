// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against cost in many small panels: one for each scene, a marker for each method, its area
//! what the method holds.
//!
//! Both axes are logarithmic; points without error stand on the line at the bottom. The dashed line
//! joins the Pareto front of the medians, and a ring is round each of its points that at least
//! [`FRONT_SURVIVAL`] of the resamples keep there (see [`terrafill_results::front_survival`]).

use crate::canvas::{Anchor, Canvas, MARKER_PX, Spot, svg};
use crate::log_log::{
    Frame, NAME_PX, distinct, draw_across, draw_name, draw_stairs, draw_up, names_below,
};
use crate::palette::Palette;
use crate::scale::LogScale;
use crate::{PlotError, WIDTH_PX};
use terrafill_results::threshold::FRONT_SURVIVAL;
use terrafill_results::{Candidate, front, front_survival};

const COLUMNS: usize = 3;
const PANEL_PX: f64 = WIDTH_PX / COLUMNS as f64;
/// Room for ticks and title left of a panel.
const LEFT_PX: f64 = 78.0;
const RIGHT_PX: f64 = 16.0;
/// Height of a panel, and of its title above and its axis below.
const HEIGHT_PX: f64 = 176.0;
const TITLE_PX: f64 = 30.0;
const AXIS_PX: f64 = 48.0;
/// From the legend's first line to the top of the drawing.
const LEGEND_PX: f64 = 12.0;
/// From the logarithm to the line of points without error, and from there to the end of the panel.
const ZERO_PX: [f64; 2] = [24.0, 14.0];
/// Half the size of the largest marker.
const MAX_MARKER_PX: f64 = 12.0;
/// Markers cover one another.
const OPACITY: f64 = 0.62;
/// Costs and errors that differ by less than these factors are hardly different.
const MIN_MARGINS: [f64; 2] = [1.25, 2.5];

/// A plot to be.
#[derive(Debug, Clone)]
pub struct Fronts<'a> {
    /// For readers who do not see it.
    pub title: String,
    /// What the horizontal axes show.
    pub across: &'a str,
    /// What the vertical axes show.
    pub up: &'a str,
    /// What the markers' areas show.
    pub area: &'a str,
    /// Left to right, then downwards.
    pub panels: Vec<FrontPanel>,
}

/// A panel.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontPanel {
    /// Above it.
    pub name: String,
    /// Methods.
    pub points: Vec<FrontPoint>,
}

/// A method.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontPoint {
    /// Its curve as in the palette.
    pub series: String,
    /// What a reader who points at it sees.
    pub name: String,
    /// Its cost, more than 0.
    pub cost: f64,
    /// One number for each process, for the front.
    pub costs: Vec<f64>,
    /// Its error.
    pub error: f64,
    /// What it holds, bytes; 0 where that is unknown.
    pub bytes: f64,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

impl Fronts<'_> {
    /// Draws the plot; `None` when no panel has a point.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn draw(&self, palette: &Palette) -> Result<Option<String>, PlotError> {
        let panels = self.panels.iter().filter(|panel| !panel.points.is_empty());
        let panels: Vec<&FrontPanel> = panels.collect();
        let points = panels.iter().flat_map(|panel| &panel.points);
        let mut names = distinct(points.map(|point| &point.series));
        if names.is_empty() {
            return Ok(None);
        }
        names.sort_unstable();
        let legend = names_below(&names, [LEFT_PX * 0.5, LEGEND_PX]);
        let top = legend.last().map_or(LEGEND_PX, |(at, _)| at[1]) + NAME_PX;
        let row_px = TITLE_PX + HEIGHT_PX + AXIS_PX;
        let rows = panels.len().div_ceil(COLUMNS);
        svg(
            &self.title,
            WIDTH_PX,
            top + rows as f64 * row_px,
            |canvas| {
                for ((at, text), name) in legend.iter().zip(&names) {
                    draw_name(canvas, text, *at, palette.stroke(name))?;
                }
                for (index, panel) in panels.iter().enumerate() {
                    let left = (index % COLUMNS) as f64 * PANEL_PX;
                    let above = top + (index / COLUMNS) as f64 * row_px + TITLE_PX;
                    let frame = Frame {
                        left: left + LEFT_PX,
                        right: left + PANEL_PX - RIGHT_PX,
                        top: above,
                        bottom: above + HEIGHT_PX,
                    };
                    self.draw_panel(canvas, palette, panel, frame)?;
                }
                Ok(())
            },
        )
        .map(Some)
    }

    fn draw_panel(
        &self,
        canvas: &Canvas<'_>,
        palette: &Palette,
        panel: &FrontPanel,
        frame: Frame,
    ) -> Result<(), PlotError> {
        let Frame {
            left,
            right,
            top,
            bottom,
        } = frame;
        let costs = panel.points.iter().map(|point| point.cost);
        let Some(across) = LogScale::around(costs, MIN_MARGINS[0], left, right) else {
            return Ok(());
        };
        let zero = bottom - ZERO_PX[1];
        let reach = [top, zero - ZERO_PX[0]];
        let errors = panel.points.iter().map(|point| point.error);
        let up = LogScale::around(errors, MIN_MARGINS[1], reach[1], reach[0]);
        canvas.heading(&panel.name, [left, top - 14.0], Anchor::Left)?;
        draw_across(canvas, frame, &across, self.across)?;
        draw_up(canvas, frame, up.as_ref(), reach, self.up)?;
        canvas.rule([left, zero], [right, zero], 0.6)?;
        canvas.text("0", [left - 8.0, zero], Anchor::Right)?;
        let at = |point: &FrontPoint| {
            let y = match &up {
                Some(up) if point.error > 0.0 => up.px(point.error),
                _ => zero,
            };
            [across.px(point.cost), y]
        };
        draw_front(canvas, &panel.points, at)?;
        let bytes = panel.points.iter().map(|point| point.bytes);
        let most = bytes.fold(1.0, f64::max);
        for point in &panel.points {
            let share = point.bytes / most;
            let size = (MAX_MARKER_PX * share.sqrt()).max(MARKER_PX * 0.5);
            canvas.sized_marker(at(point), palette.stroke(&point.series), size, OPACITY)?;
        }
        for point in &panel.points {
            canvas.spot(&Spot {
                at: at(point),
                group: &panel.name,
                name: &point.name,
                values: &[
                    (self.across, point.cost),
                    (self.up, point.error),
                    (self.area, point.bytes),
                ],
                command: &point.command,
            });
        }
        Ok(())
    }
}

/// The front of the medians from its fastest point to its most exact one, with rings.
fn draw_front(
    canvas: &Canvas<'_>,
    points: &[FrontPoint],
    at: impl Fn(&FrontPoint) -> [f64; 2],
) -> Result<(), PlotError> {
    let medians: Vec<[f64; 2]> = points.iter().map(|p| [p.cost, p.error]).collect();
    let candidates = points.iter().map(|point| Candidate {
        costs: &point.costs,
        error: point.error,
    });
    let survival = front_survival(&candidates.collect::<Vec<_>>());
    let on_front = front(&medians).into_iter().zip(survival).zip(points);
    let mut corners: Vec<([f64; 2], bool)> = on_front
        .filter(|((on_front, _), _)| *on_front)
        .map(|((_, survival), point)| (at(point), survival >= FRONT_SURVIVAL))
        .collect();
    corners.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    draw_stairs(
        canvas,
        &corners.iter().map(|(at, _)| *at).collect::<Vec<_>>(),
    )?;
    for (at, _) in corners.iter().filter(|(_, is_sure)| *is_sure) {
        canvas.ring(*at)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(name: &str, cost: f64, error: f64) -> FrontPoint {
        FrontPoint {
            series: name.to_owned(),
            name: name.to_owned(),
            cost,
            costs: vec![cost; 6],
            error,
            bytes: 1_000.0,
            command: format!("draw {name}"),
        }
    }

    fn drawn(points: Vec<FrontPoint>) -> Option<String> {
        let plot = Fronts {
            title: "error against time".to_owned(),
            across: "time, ms",
            up: "wrong pixels",
            area: "bytes",
            panels: vec![FrontPanel {
                name: "globe".to_owned(),
                points,
            }],
        };
        let palette = Palette::new(vec!["fast".to_owned(), "exact".to_owned()]);
        plot.draw(&palette).expect("draws")
    }

    fn rings(svg: &str) -> usize {
        svg.matches("<circle").count() - svg.matches("opacity=\"0.62\"").count()
    }

    #[test]
    fn every_point_says_its_figures_and_the_front_is_drawn() {
        let points = vec![point("fast", 2.0, 78.0), point("exact", 12.0, 0.0)];
        let svg = drawn(points.clone()).expect("points");
        assert!(svg.contains("globe: fast\ntime, ms: 2\nwrong pixels: 78"));
        assert!(svg.contains("globe,exact,12,0,1000"), "{svg}");
        assert!(svg.contains("data-command=\"draw exact\""), "{svg}");
        let dashes = |svg: &str| svg.matches("stroke-dasharray").count();
        // Negative control: a point that another one beats in both ways is not joined.
        let beaten = vec![point("fast", 2.0, 0.0), point("exact", 12.0, 78.0)];
        let beaten = drawn(beaten).expect("points");
        assert!(dashes(&svg) > dashes(&beaten));
        assert_eq!(drawn(Vec::new()), None);
    }

    #[test]
    fn only_what_resamples_keep_has_a_ring() {
        let sure = drawn(vec![point("fast", 2.0, 78.0)]).expect("a point");
        let mut unsure = point("fast", 2.0, 78.0);
        unsure.costs.truncate(2);
        let unsure = drawn(vec![unsure]).expect("a point");
        assert_eq!(rings(&sure), rings(&unsure) + 1);
    }
}
