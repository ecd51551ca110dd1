// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes over the number of regions, one curve a layout, both axes logarithmic; as allocated where a
//! scene was drawn.

use super::WIDTH_PX;
use super::canvas::{Anchor, Canvas, TEXT_PX, svg, text_width};
use super::palette::Palette;
use super::scale::LogScale;
use crate::ReportError;
use crate::memory::Curve;
use crate::number;
use plotters::prelude::Color as _;

const HEIGHT_PX: f64 = 430.0;
const LEFT_PX: f64 = 70.0;
const TOP_PX: f64 = 16.0;
const AXIS_PX: f64 = 50.0;
const LEGEND_ROW_PX: f64 = 19.0;

/// Draws the plot; `None` without a point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn bytes_over_regions(
    scene: &str,
    curves: &[Curve],
) -> Result<Option<String>, ReportError> {
    let names: Vec<String> = curves.iter().map(|curve| curve.name.clone()).collect();
    let longest = names.iter().map(|name| text_width(name, TEXT_PX));
    let right = WIDTH_PX - 50.0 - longest.fold(0.0, f64::max);
    let bottom = HEIGHT_PX - AXIS_PX;
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let across = LogScale::around(points().map(|point| point[0]), 1.1, LEFT_PX, right);
    let up = LogScale::around(points().map(|point| point[1]), 1.3, bottom, TOP_PX);
    let (Some(across), Some(up)) = (across, up) else {
        return Ok(None);
    };
    let palette = Palette::new(names);
    let title = format!("{scene}: bytes over regions");
    svg(&title, WIDTH_PX, HEIGHT_PX, |canvas| {
        draw_axes(canvas, &across, &up, [right, bottom])?;
        for curve in curves {
            let stroke = palette.stroke(&curve.name);
            let at = |point: &[f64; 2]| [across.px(point[0]), up.px(point[1])];
            let path: Vec<[f64; 2]> = curve.points.iter().map(at).collect();
            canvas.path(&path, stroke.colour.mix(0.8), 2)?;
            if let Some(point) = &curve.allocated {
                canvas.marker(at(point), stroke)?;
                canvas.ring(at(point))?;
            }
        }
        let mut by_bytes: Vec<&Curve> = curves.iter().collect();
        let last = |curve: &Curve| curve.points.last().map_or(0.0, |point| point[1]);
        by_bytes.sort_by(|a, b| last(b).total_cmp(&last(a)));
        for (curve, row) in by_bytes.into_iter().zip(0_u32..) {
            let stroke = palette.stroke(&curve.name);
            let y = TOP_PX + LEGEND_ROW_PX * (f64::from(row) + 0.5);
            canvas.path(
                &[[right + 10.0, y], [right + 34.0, y]],
                stroke.colour.mix(0.8),
                2,
            )?;
            canvas.marker([right + 22.0, y], stroke)?;
            canvas.text(&curve.name, [right + 42.0, y], Anchor::Left)?;
        }
        Ok(())
    })
    .map(Some)
}

fn draw_axes(
    canvas: &Canvas<'_>,
    across: &LogScale,
    up: &LogScale,
    [right, bottom]: [f64; 2],
) -> Result<(), ReportError> {
    for tick in across.ticks() {
        let x = across.px(tick);
        canvas.rule([x, TOP_PX], [x, bottom], 0.12)?;
        canvas.text(
            &number::count(whole(tick)),
            [x, bottom + 12.0],
            Anchor::Middle,
        )?;
    }
    for tick in up.ticks() {
        let y = up.px(tick);
        canvas.rule([LEFT_PX, y], [right, y], 0.12)?;
        canvas.text(
            &number::bytes(whole(tick)),
            [LEFT_PX - 8.0, y],
            Anchor::Right,
        )?;
    }
    canvas.rule([LEFT_PX, TOP_PX], [LEFT_PX, bottom], 0.6)?;
    canvas.rule([LEFT_PX, bottom], [right, bottom], 0.6)?;
    canvas.text(
        "regions (logarithmic); upwards: bytes of positions, flags and indices by formula; ringed: as allocated",
        [LEFT_PX, bottom + 36.0],
        Anchor::Left,
    )
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "ticks are positive and far below 2^53"
)]
fn whole(tick: f64) -> u64 {
    tick.round() as u64
}
