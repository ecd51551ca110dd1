// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fill time and wall height over the cap step, side by side: what is gained with fewer triangles, and
//! what it takes.

use super::WIDTH_PX;
use super::canvas::svg;
use super::log_log::{Frame, NAME_PX, draw_name, names_below};
use super::palette::Palette;
use super::work_precision::{Curve, Panel, Upwards, WorkPrecision};
use crate::ReportError;

const TOP_PX: f64 = 50.0;
const BOTTOM_PX: f64 = 330.0;
const LEGEND_PX: f64 = 392.0;
const PANEL_PX: f64 = WIDTH_PX / 2.0;
const LEFT_MARGIN_PX: f64 = 74.0;
const RIGHT_MARGIN_PX: f64 = 22.0;

/// Draws both panels; `None` when neither has a point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn subdivision(
    times: Vec<Curve>,
    walls: Vec<Curve>,
) -> Result<Option<String>, ReportError> {
    let names: Vec<String> = times.iter().map(|curve| curve.name.clone()).collect();
    let panel = |title, up, curves| WorkPrecision {
        title,
        across: "largest edge of a cap triangle, degrees",
        up,
        upwards: Upwards::Amount,
        curves,
        lines: Vec::new(),
    };
    let plots = [
        panel("Fill time", "fill, process CPU ms: median, 5–95 %", times),
        panel("Wall height", "tallest wall drawn, m", walls),
    ];
    let panels: Vec<Panel<'_>> = plots
        .iter()
        .zip([0.0, PANEL_PX])
        .filter_map(|(plot, left)| {
            let frame = Frame {
                left: left + LEFT_MARGIN_PX,
                right: left + PANEL_PX - RIGHT_MARGIN_PX,
                top: TOP_PX,
                bottom: BOTTOM_PX,
            };
            Panel::new(plot, frame)
        })
        .collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let palette = Palette::new(names.clone());
    let legend = names_below(&names, [LEFT_MARGIN_PX, LEGEND_PX]);
    let height = legend.last().map_or(LEGEND_PX, |(at, _)| at[1]) + NAME_PX;
    svg(
        "subdivision against wall height",
        WIDTH_PX,
        height,
        |canvas| {
            for panel in &panels {
                panel.draw(canvas, &palette)?;
            }
            for ((at, text), name) in legend.iter().zip(&names) {
                draw_name(canvas, text, *at, palette.stroke(name))?;
            }
            Ok(())
        },
    )
    .map(Some)
}
