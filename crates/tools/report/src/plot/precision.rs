// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error of coordinate routes against their time and, below it, against their operations, which no
//! noise reaches.

use super::WIDTH_PX;
use super::canvas::svg;
use super::log_log::{Frame, NAME_PX, draw_name, names_below};
use super::palette::Palette;
use super::work_precision::{Curve, Panel, Upwards, WorkPrecision};
use crate::ReportError;
use crate::precision::PrecisionPlot;

const TOP_PX: f64 = 50.0;
const PANEL_PX: f64 = 470.0;
/// From one panel to the next: axis and title, and the next one's heading.
const BETWEEN_PX: f64 = 104.0;
/// From the last panel to the names of the curves.
const LEGEND_PX: f64 = 64.0;
const LEFT_MARGIN_PX: f64 = 74.0;
/// Names of the reference lines.
const RIGHT_MARGIN_PX: f64 = 206.0;

/// Draws both panels; `None` when neither has a point.
///
/// - `clock`: what the left panel's axis says
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn precision(
    plot: &PrecisionPlot,
    clock: &str,
    palette: &Palette,
) -> Result<Option<String>, ReportError> {
    let panel = |title, across, curves: &[Curve]| WorkPrecision {
        title,
        across,
        up: "error, m: largest (filled), RMS (open)",
        upwards: Upwards::Error,
        curves: curves.to_vec(),
        lines: plot.lines.clone(),
    };
    let by_time = format!("{}: error against time", plot.title);
    let plots = [
        panel(&by_time, clock, &plot.by_time),
        panel(
            "Error against operations",
            "operations, weighted, in fused multiply-adds",
            &plot.by_operations,
        ),
    ];
    let panels: Vec<Panel<'_>> = plots
        .iter()
        .zip([TOP_PX, TOP_PX + PANEL_PX + BETWEEN_PX])
        .filter_map(|(plot, top)| {
            let frame = Frame {
                left: LEFT_MARGIN_PX,
                right: WIDTH_PX - RIGHT_MARGIN_PX,
                top,
                bottom: top + PANEL_PX,
            };
            Panel::new(plot, frame).map(Panel::crowded)
        })
        .collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let names: Vec<String> = plot.by_operations.iter().map(|c| c.name.clone()).collect();
    let below = TOP_PX + 2.0 * PANEL_PX + BETWEEN_PX + LEGEND_PX;
    let legend = names_below(&names, [LEFT_MARGIN_PX, below]);
    let height = legend.last().map_or(below, |(at, _)| at[1]) + NAME_PX;
    let title = format!("{}: error against cost", plot.title);
    svg(&title, WIDTH_PX, height, |canvas| {
        for panel in &panels {
            panel.draw(canvas, palette)?;
        }
        for ((at, text), name) in legend.iter().zip(&names) {
            draw_name(canvas, text, *at, palette.stroke(name))?;
        }
        Ok(())
    })
    .map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Point, Reading, ReferenceLine, Standing};

    fn plot(points: usize) -> PrecisionPlot {
        let point = |i: usize| Point {
            knob: i as f64,
            label: format!("degree {i}"),
            x: Some(Reading::exact(10.0 + i as f64)),
            y: Some(Reading::exact(100.0 / (1.0 + i as f64))),
            y_rms: Some(10.0 / (1.0 + i as f64)),
            standing: Standing::Right,
        };
        let curves = vec![Curve {
            name: "gnomonic".to_owned(),
            points: (0..points).map(point).collect(),
        }];
        PrecisionPlot {
            title: "1°".to_owned(),
            by_time: curves.clone(),
            by_operations: curves,
            lines: vec![ReferenceLine {
                label: "¼ texel".to_owned(),
                from_x: None,
                y: 5.0,
                power: 0.0,
            }],
        }
    }

    fn drawn(points: usize) -> Option<String> {
        let palette = Palette::new(vec!["gnomonic".to_owned()]);
        precision(&plot(points), "ns", &palette).expect("draws")
    }

    #[test]
    fn every_point_stands_in_both_panels_with_its_line_and_name() {
        let three = drawn(3).expect("points");
        for word in [
            "gnomonic",
            "¼ texel",
            "error against time",
            "Error against operations",
        ] {
            assert!(three.contains(word), "{word}");
        }
        let marks = |svg: &str| svg.matches("<circle").count();
        // Twin: a point less is a filled and an open mark less in each panel.
        let two = drawn(2).expect("points");
        assert!(
            marks(&three) >= marks(&two) + 4,
            "{} {}",
            marks(&three),
            marks(&two)
        );
        assert_eq!(drawn(0), None);
    }
}
