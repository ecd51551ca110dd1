// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time to mesh against vertices, both axes logarithmic, one curve per shape, with a line of slope 1.

use super::WIDTH_PX;
use super::canvas::svg;
use super::log_log::{Frame, draw_names_aside, names_width};
use super::palette::Palette;
use super::work_precision::{
    Curve, Panel, Point, Reading, ReferenceLine, Standing, Upwards, WorkPrecision,
};
use crate::ReportError;
use crate::growth::GrowthCurve;
use crate::number;
use terrafill_results::legacy::Spread;

const HEIGHT_PX: f64 = 440.0;
const LEFT_PX: f64 = 84.0;
const TOP_PX: f64 = 48.0;
const BOTTOM_PX: f64 = 390.0;

/// Draws the curves; `None` when there is no point.
///
/// # Errors
/// [`ReportError::Plot`].
pub(crate) fn growth(curves: &[GrowthCurve]) -> Result<Option<String>, ReportError> {
    let plot = WorkPrecision {
        title: "Time to mesh against vertices",
        across: "vertices of the outline",
        up: "text to mesh, process CPU ms: median, 5–95 %",
        upwards: Upwards::Amount,
        curves: curves.iter().map(curve).collect(),
        lines: slope(curves).into_iter().collect(),
    };
    let names = curves.iter().filter_map(|curve| {
        let (_, time) = curve.points.last()?;
        Some((time.median, curve.shape.as_str(), name(curve)?))
    });
    let names: Vec<(f64, &str, String)> = names.collect();
    let frame = Frame {
        left: LEFT_PX,
        right: WIDTH_PX - names_width(names.iter().map(|(.., text)| text.as_str())),
        top: TOP_PX,
        bottom: BOTTOM_PX,
    };
    let Some(panel) = Panel::new(&plot, frame) else {
        return Ok(None);
    };
    let names = names
        .into_iter()
        .map(|(time, shape, text)| (panel.height(time), shape, text))
        .collect();
    let palette = Palette::new(curves.iter().map(|curve| curve.shape.clone()).collect());
    svg(
        "time to mesh against vertices",
        WIDTH_PX,
        HEIGHT_PX,
        |canvas| {
            panel.draw(canvas, &palette)?;
            draw_names_aside(canvas, frame, names, &palette)
        },
    )
    .map(Some)
}

fn curve(curve: &GrowthCurve) -> Curve {
    let point = |&(vertices, time): &(f64, Spread)| Point {
        knob: vertices,
        label: String::new(),
        x: Some(Reading::exact(vertices)),
        y: Some(Reading::sampled(time, &[])),
        y_rms: None,
        standing: Standing::Right,
    };
    Curve {
        name: curve.shape.clone(),
        points: curve.points.iter().map(point).collect(),
    }
}

/// From the cheapest shape's first point.
fn slope(curves: &[GrowthCurve]) -> Option<ReferenceLine> {
    let firsts = curves.iter().filter_map(|curve| curve.points.first());
    let cheapest = firsts.min_by(|a, b| a.1.median.total_cmp(&b.1.median));
    cheapest.map(|(vertices, time)| ReferenceLine {
        label: "slope 1".to_owned(),
        from_x: Some(*vertices),
        y: time.median,
        power: 1.0,
    })
}

/// The shape, and the cost of a vertex at the curve's end.
fn name(curve: &GrowthCurve) -> Option<String> {
    let (vertices, time) = curve.points.last()?;
    let nanoseconds = number::significant(time.median * 1e6 / vertices);
    Some(format!("{} · {nanoseconds} ns", curve.shape))
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
