// SPDX-License-Identifier: MIT OR Apache-2.0
//! Drawings of one or two panels of work and precision, with the names of their curves.

use crate::canvas::svg;
use crate::log_log::{
    Frame, NAME_PX, distinct, draw_line_name, draw_name, draw_names_aside, names_below, names_width,
};
use crate::palette::Palette;
use crate::work_precision::{Panel, WorkPrecision};
use crate::{PlotError, WIDTH_PX};

const TOP_PX: f64 = 50.0;
const LEFT_MARGIN_PX: f64 = 74.0;
const RIGHT_MARGIN_PX: f64 = 22.0;
/// From the last panel to the names of the curves.
const LEGEND_PX: f64 = 64.0;

/// Height of a panel beside another.
const NARROW_PANEL_PX: f64 = 316.0;
/// Height of a panel of its own.
const WIDE_PANEL_PX: f64 = 470.0;
/// From one panel to the next below: axis and title, and the next one's heading.
const BETWEEN_PX: f64 = 104.0;
/// Names of the reference lines beside a wide panel.
const LINE_NAMES_PX: f64 = 206.0;
/// Height of a panel whose curves are named at its right.
const NAMED_PANEL_PX: f64 = 342.0;
/// Axis labels of wide numbers.
const NAMED_LEFT_PX: f64 = 84.0;

/// How panels stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// Beside one another, two of them.
    SideBySide,
    /// One below the other, for many curves close together.
    Stacked,
    /// A single one, for many curves close together without lines to hold them against.
    Alone,
}

impl Arrangement {
    fn frame(self, index: usize) -> Frame {
        let index = index as f64;
        match self {
            Self::SideBySide => {
                let left = index * 0.5 * WIDTH_PX;
                Frame {
                    left: left + LEFT_MARGIN_PX,
                    right: left + 0.5 * WIDTH_PX - RIGHT_MARGIN_PX,
                    top: TOP_PX,
                    bottom: TOP_PX + NARROW_PANEL_PX,
                }
            }
            Self::Stacked => {
                let top = TOP_PX + index * (WIDE_PANEL_PX + BETWEEN_PX);
                Frame {
                    left: LEFT_MARGIN_PX,
                    right: WIDTH_PX - LINE_NAMES_PX,
                    top,
                    bottom: top + WIDE_PANEL_PX,
                }
            }
            Self::Alone => Frame {
                left: LEFT_MARGIN_PX,
                right: WIDTH_PX - RIGHT_MARGIN_PX,
                top: TOP_PX,
                bottom: TOP_PX + NARROW_PANEL_PX,
            },
        }
    }
}

/// Draws the panels and below them the names of all curves; `None` when no panel has a point.
///
/// # Errors
/// [`PlotError`].
pub fn panels(
    title: &str,
    plots: &[WorkPrecision<'_>],
    arrangement: Arrangement,
    palette: &Palette,
) -> Result<Option<String>, PlotError> {
    let frame = |index| arrangement.frame(index);
    let panels = plots.iter().enumerate().filter_map(|(index, plot)| {
        let panel = Panel::new(plot, frame(index))?;
        Some(match arrangement {
            Arrangement::SideBySide => panel,
            Arrangement::Stacked | Arrangement::Alone => panel.crowded(),
        })
    });
    let panels: Vec<Panel<'_>> = panels.collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let curves = || plots.iter().flat_map(|plot| &plot.curves);
    let names = distinct(curves().map(|curve| &curve.name));
    let is_exact = |name: &str| curves().any(|curve| curve.name == name && curve.is_exact());
    let below = frame(plots.len() - 1).bottom + LEGEND_PX;
    let legend = names_below(&names, [LEFT_MARGIN_PX, below]);
    let height = legend.last().map_or(below, |(at, _)| at[1]) + NAME_PX;
    svg(title, WIDTH_PX, height, |canvas| {
        for panel in &panels {
            panel.draw(canvas, palette)?;
        }
        for ((at, text), name) in legend.iter().zip(&names) {
            let stroke = palette.stroke(name);
            if is_exact(name) {
                draw_line_name(canvas, text, *at, stroke)?;
            } else {
                draw_name(canvas, text, *at, stroke)?;
            }
        }
        Ok(())
    })
    .map(Some)
}

/// Draws one panel with each curve's name beside its right end; `None` when there is no point.
///
/// - `names`: for each curve what is written there
///
/// # Errors
/// [`PlotError`].
pub fn named_aside(
    title: &str,
    plot: &WorkPrecision<'_>,
    names: &[String],
    palette: &Palette,
) -> Result<Option<String>, PlotError> {
    let frame = Frame {
        left: NAMED_LEFT_PX,
        right: WIDTH_PX - names_width(names.iter().map(String::as_str)),
        top: TOP_PX,
        bottom: TOP_PX + NAMED_PANEL_PX,
    };
    let Some(panel) = Panel::new(plot, frame) else {
        return Ok(None);
    };
    let ends = plot.curves.iter().zip(names).filter_map(|(curve, text)| {
        let last = curve.points.last()?.y.as_ref()?;
        Some((
            panel.height(last.middle()),
            curve.name.as_str(),
            text.clone(),
        ))
    });
    let ends = ends.collect();
    svg(title, WIDTH_PX, frame.bottom + LEGEND_PX, |canvas| {
        panel.draw(canvas, palette)?;
        draw_names_aside(canvas, frame, ends, palette)
    })
    .map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Curve, Point, PointStanding, Reading, ReferenceLine, Upwards};

    fn plot(points: usize) -> WorkPrecision<'static> {
        let point = |i: usize| Point {
            knob: i as f64,
            label: format!("degree {i}"),
            x: Some(Reading::exact(10.0 + i as f64)),
            y: Some(Reading::exact(100.0 / (1.0 + i as f64))),
            y_rms: Some(10.0 / (1.0 + i as f64)),
            standing: PointStanding::Right,
            command: String::new(),
        };
        WorkPrecision {
            title: "error against time",
            across: "ns",
            up: "m",
            upwards: Upwards::Error,
            curves: vec![Curve {
                name: "gnomonic".to_owned(),
                points: (0..points).map(point).collect(),
            }],
            lines: vec![ReferenceLine {
                label: "¼ texel".to_owned(),
                from_x: None,
                y: 5.0,
                power: 0.0,
            }],
        }
    }

    #[test]
    fn every_point_stands_in_both_panels_with_its_line_and_name() {
        let palette = Palette::new(vec!["gnomonic".to_owned()]);
        let marks = |svg: &str| svg.matches("<circle").count();
        for arrangement in [Arrangement::SideBySide, Arrangement::Stacked] {
            let drawn = |points| {
                panels("both", &[plot(points), plot(points)], arrangement, &palette).expect("draws")
            };
            let three = drawn(3).expect("points");
            for word in ["gnomonic", "¼ texel", "error against time"] {
                assert!(three.contains(word), "{word}");
            }
            // Negative control: a point less is a filled and an open mark less in each panel.
            let two = drawn(2).expect("points");
            assert!(marks(&three) >= marks(&two) + 4);
            assert_eq!(drawn(0), None);
        }
    }

    #[test]
    fn names_stand_beside_their_curves() {
        let palette = Palette::new(vec!["gnomonic".to_owned()]);
        let drawn = |points| {
            named_aside(
                "one",
                &plot(points),
                &["gnomonic · 3 ns".to_owned()],
                &palette,
            )
            .expect("draws")
        };
        assert!(drawn(2).expect("points").contains("gnomonic · 3 ns"));
        assert_eq!(drawn(0), None);
    }
}
