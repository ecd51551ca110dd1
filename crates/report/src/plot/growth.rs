// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time to mesh against vertices, both axes logarithmic, one curve per shape, with a line of slope 1.

use super::canvas::{Anchor, Canvas, svg};
use super::palette::{Palette, Stroke};
use super::scale::{LogScale, tick_label};
use crate::ReportError;
use crate::growth::GrowthCurve;
use crate::number;
use plotters::prelude::Color as _;
use terrafill_results::Spread;

const WIDTH_PX: f64 = 780.0;
const HEIGHT_PX: f64 = 440.0;
const LEFT_PX: f64 = 80.0;
/// Room for the names at the ends of the curves.
const RIGHT_PX: f64 = 620.0;
const TOP_PX: f64 = 34.0;
const BOTTOM_PX: f64 = 384.0;
/// Names at the curves' ends are at least so far apart.
const NAME_PX: f64 = 18.0;

/// Draws the curves; `None` when there is no point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn growth(curves: &[GrowthCurve]) -> Result<Option<String>, ReportError> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let x = LogScale::around(points().map(|point| point.0), 1.2, LEFT_PX, RIGHT_PX);
    let times = points().flat_map(|point| [point.1.p5, point.1.p95]);
    let y = LogScale::around(times, 1.2, BOTTOM_PX, TOP_PX);
    let (Some(x), Some(y)) = (x, y) else {
        return Ok(None);
    };
    let palette = Palette::new(curves.iter().map(|curve| curve.shape.clone()).collect());
    svg(
        "time to mesh against vertices",
        WIDTH_PX,
        HEIGHT_PX,
        |canvas| {
            draw_axes(canvas, &x, &y)?;
            draw_slope(canvas, &x, &y, curves)?;
            for curve in curves {
                let stroke = palette.stroke(&curve.shape);
                draw_curve(canvas, &x, &y, curve, stroke)?;
            }
            draw_names(canvas, &y, curves, &palette)
        },
    )
    .map(Some)
}

fn draw_axes(canvas: &Canvas<'_>, x: &LogScale, y: &LogScale) -> Result<(), ReportError> {
    canvas.heading(
        "Time to mesh against vertices",
        [LEFT_PX, 14.0],
        Anchor::Left,
    )?;
    for tick in x.ticks() {
        let at = x.px(tick);
        canvas.rule([at, TOP_PX], [at, BOTTOM_PX], 0.12)?;
        canvas.text(&tick_label(tick), [at, BOTTOM_PX + 14.0], Anchor::Middle)?;
    }
    for tick in y.ticks() {
        let at = y.px(tick);
        canvas.rule([LEFT_PX, at], [RIGHT_PX, at], 0.12)?;
        canvas.text(&tick_label(tick), [LEFT_PX - 8.0, at], Anchor::Right)?;
    }
    canvas.rule([LEFT_PX, TOP_PX], [LEFT_PX, BOTTOM_PX], 0.6)?;
    canvas.rule([LEFT_PX, BOTTOM_PX], [RIGHT_PX, BOTTOM_PX], 0.6)?;
    let middle = (LEFT_PX + RIGHT_PX) * 0.5;
    canvas.text(
        "vertices of the outline",
        [middle, BOTTOM_PX + 38.0],
        Anchor::Middle,
    )?;
    canvas.upright_text(
        "text to mesh, process CPU ms: median, 5–95 %",
        [LEFT_PX - 62.0, (TOP_PX + BOTTOM_PX) * 0.5],
    )
}

/// From the cheapest shape's first point, as far as the axes reach.
fn draw_slope(
    canvas: &Canvas<'_>,
    x: &LogScale,
    y: &LogScale,
    curves: &[GrowthCurve],
) -> Result<(), ReportError> {
    let firsts = curves.iter().filter_map(|curve| curve.points.first());
    let Some((vertices, time)) = firsts.min_by(|a, b| a.1.median.total_cmp(&b.1.median)) else {
        return Ok(());
    };
    let last = curves.iter().filter_map(|curve| curve.points.last());
    let end = last.map(|point| point.0).fold(*vertices, f64::max);
    let to = [x.px(end), y.px(time.median * end / vertices)];
    canvas.dashes([x.px(*vertices), y.px(time.median)], to)?;
    let below = [to[0] - 6.0, to[1] + 34.0];
    canvas.text("slope 1", below, Anchor::Right)
}

fn draw_curve(
    canvas: &Canvas<'_>,
    x: &LogScale,
    y: &LogScale,
    curve: &GrowthCurve,
    stroke: Stroke,
) -> Result<(), ReportError> {
    let at = |point: &(f64, Spread)| [x.px(point.0), y.px(point.1.median)];
    let path: Vec<[f64; 2]> = curve.points.iter().map(at).collect();
    canvas.path(&path, stroke.colour.mix(0.7), 2)?;
    for (point, at) in curve.points.iter().zip(path) {
        let whisker = [point.1.p5, point.1.p95].map(|time| y.px(time));
        let colour = stroke.colour.mix(0.9);
        canvas.path(&[[at[0], whisker[0]], [at[0], whisker[1]]], colour, 1)?;
        for end in whisker {
            canvas.path(&[[at[0] - 4.0, end], [at[0] + 4.0, end]], colour, 1)?;
        }
        canvas.marker(at, stroke)?;
    }
    Ok(())
}

/// Beside the curves' ends, spread where they are close, with the cost of a vertex there.
fn draw_names(
    canvas: &Canvas<'_>,
    y: &LogScale,
    curves: &[GrowthCurve],
    palette: &Palette,
) -> Result<(), ReportError> {
    let mut names: Vec<(f64, &GrowthCurve, f64)> = curves
        .iter()
        .filter_map(|curve| {
            let (vertices, time) = curve.points.last()?;
            Some((y.px(time.median), curve, time.median * 1e6 / vertices))
        })
        .collect();
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::NEG_INFINITY;
    for (wanted, curve, nanoseconds) in names {
        let at = wanted.max(free);
        free = at + NAME_PX;
        canvas.marker([RIGHT_PX + 14.0, at], palette.stroke(&curve.shape))?;
        let label = format!("{} · {} ns", curve.shape, number::significant(nanoseconds));
        canvas.text(&label, [RIGHT_PX + 26.0, at], Anchor::Left)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(shape: &str, points: &[(f64, f64)]) -> GrowthCurve {
        let spread = |median: f64| Spread {
            p5: median * 0.9,
            median,
            p95: median * 1.2,
        };
        GrowthCurve {
            shape: shape.to_owned(),
            points: points.iter().map(|&(n, ms)| (n, spread(ms))).collect(),
        }
    }

    #[test]
    fn every_shape_has_a_curve_and_its_name() {
        let curves = [
            curve("comb", &[(1e3, 1.0), (1e4, 10.0), (1e5, 120.0)]),
            curve("circle", &[(1e3, 1.5), (1e4, 15.0), (1e5, 180.0)]),
        ];
        let text = growth(&curves).expect("drawn").expect("points");
        for word in [
            "comb · 1",
            "circle · 1",
            "slope 1",
            "vertices of the outline",
        ] {
            assert!(text.contains(word), "{word}");
        }
        let polylines = |text: &str| text.matches("<polyline").count();
        let fewer = growth(&curves[..1]).expect("drawn").expect("points");
        // Twin: one shape less is a curve and its whiskers less.
        assert!(polylines(&text) > polylines(&fewer) && !fewer.contains("circle ·"));
        assert_eq!(growth(&[]).expect("nothing to draw"), None);
    }
}
