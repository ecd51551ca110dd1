// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes over the number of regions, one curve a layout, both axes logarithmic; as allocated where a
//! scene was drawn.

use super::WIDTH_PX;
use super::canvas::svg;
use super::log_log::{
    AxisText, Frame, LINE_OPACITY, draw_across, draw_names_aside, draw_up, names_width,
};
use super::palette::Palette;
use super::scale::{LogScale, whole};
use crate::ReportError;
use crate::memory::Curve;
use crate::number;
use plotters::prelude::Color as _;

const HEIGHT_PX: f64 = 430.0;
const LEFT_PX: f64 = 84.0;
const TOP_PX: f64 = 16.0;
const AXIS_PX: f64 = 50.0;

/// Draws the plot; `None` without a point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn bytes_over_regions(
    scene: &str,
    curves: &[Curve],
) -> Result<Option<String>, ReportError> {
    let names: Vec<String> = curves.iter().map(|curve| curve.name.clone()).collect();
    let frame = Frame {
        left: LEFT_PX,
        right: WIDTH_PX - names_width(names.iter().map(String::as_str)),
        top: TOP_PX,
        bottom: HEIGHT_PX - AXIS_PX,
    };
    // The scene itself stands beside the curves, and may be smaller than all of them.
    let points: Vec<[f64; 2]> = curves
        .iter()
        .flat_map(|curve| curve.points.iter().chain(&curve.allocated))
        .copied()
        .collect();
    let regions = points.iter().map(|point| point[0]);
    let bytes = points.iter().map(|point| point[1]);
    let across = LogScale::around(regions, 1.1, frame.left, frame.right);
    let up = LogScale::around(bytes, 1.3, frame.bottom, frame.top);
    let (Some(across), Some(up)) = (across, up) else {
        return Ok(None);
    };
    let ends = curves.iter().filter_map(|curve| {
        let end = curve.points.last()?;
        Some((up.px(end[1]), curve.name.as_str(), curve.name.clone()))
    });
    let palette = Palette::new(names);
    let title = format!("{scene}: bytes over regions");
    svg(&title, WIDTH_PX, HEIGHT_PX, |canvas| {
        let regions = AxisText {
            title: "regions",
            tick: |tick| number::count(whole(tick)),
        };
        let bytes = AxisText {
            title: "bytes by formula; ringed: as allocated",
            tick: |tick| number::bytes(whole(tick)),
        };
        draw_across(canvas, frame, &across, regions)?;
        draw_up(canvas, frame, Some(&up), [frame.top, frame.bottom], bytes)?;
        let corners = [frame.left, frame.right].map(|x| [x, frame.bottom]);
        canvas.rule(corners[0], corners[1], 0.6)?;
        for curve in curves {
            let stroke = palette.stroke(&curve.name);
            let at = |point: &[f64; 2]| [across.px(point[0]), up.px(point[1])];
            let path: Vec<[f64; 2]> = curve.points.iter().map(at).collect();
            canvas.path(&path, stroke.colour.mix(LINE_OPACITY), 2)?;
            if let Some(point) = &curve.allocated {
                canvas.marker(at(point), stroke)?;
                canvas.ring(at(point))?;
            }
        }
        draw_names_aside(canvas, frame, ends.collect(), &palette)
    })
    .map(Some)
}
