// SPDX-License-Identifier: MIT OR Apache-2.0
//! The plots: error against time and against operations, a curve for each family.

use super::data::{DRAWN, Data, QUARTER, non_finite, number};
use crate::metrics::*;
use terrafill_lab::grouped;
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, ReferenceLine, Upwards,
    WorkPrecision, panels,
};
use terrafill_results::{Block, Case, ChapterError, Outcome, Plot};

/// WGSL and Vulkan allow `atan2` this many units in the last place.
const SPECIFIED_ULP: f64 = 4096.0;

/// Mean radius of the Earth, metres: what reference lines turn radians into metres by.
const EARTH_M: f64 = 6_371_008.8;

/// Families that are drawn everywhere; those of [`POLYNOMIALS`] have a plot of their own.
const FAMILIES: [&str; 14] = [
    "atan2-native",
    "recentred-atan2-native",
    "odd",
    "recentred-odd",
    "near-odd",
    "rat",
    "cubic-cesium",
    "planes",
    "gnomonic",
    "azimuthal",
    "cube",
    "lut-r32f-nearest",
    "lut-r32f-linear",
    "lut-r32f-linear-exact",
];

/// Every way to write the arctangent, absolute angles.
const POLYNOMIALS: [&str; 14] = [
    "atan2-native",
    "odd",
    "odd-rel",
    "odd-pin",
    "cubic-cesium",
    "cubic-cesium+geocentric",
    "dense",
    "rat",
    "rat-rel",
    "lut-r32f-nearest",
    "lut-r32f-linear",
    "lut-r16-linear",
    "lut-r16f-linear",
    "lut-r8-linear",
];

/// Where they are drawn.
const POLYNOMIALS_AT: &str = "extent=360;latitude=0;heights=0";

/// The plots: one for each region that is drawn and has rows, then every way to write the arctangent.
pub(super) fn plots(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let drawn = DRAWN
        .iter()
        .map(|(condition, name)| (*condition, *name, &FAMILIES));
    let name = "Every way to write the arctangent, on the globe";
    let drawn: Vec<_> = drawn
        .chain([(POLYNOMIALS_AT, name, &POLYNOMIALS)])
        .collect();
    let coordinates = data.of("coordinate");
    let rows_of = |condition: &str, families: &[&str]| -> Vec<&Case> {
        let own = coordinates.with(&[(CONDITION, condition)]);
        let own = own.fitting(|row| families.contains(&row.condition(FAMILY)));
        own.iter().collect()
    };
    let mut names: Vec<String> = drawn
        .iter()
        .flat_map(|(condition, _, families)| rows_of(condition, *families))
        .map(|row| row.condition(FAMILY).to_owned())
        .collect();
    names.sort_unstable();
    names.dedup();
    let palette = Palette::new(names);
    let mut blocks = Vec::new();
    for (condition, name, families) in drawn {
        let rows = rows_of(condition, families);
        if let Some(svg) = plot(data, &rows, name, &palette)? {
            blocks.push(Block::Plot(Plot {
                caption: format!("{name}."),
                svg,
            }));
        }
    }
    Ok(blocks)
}

/// Error against time and, below it, against operations, which no noise reaches.
fn plot(
    data: &Data<'_>,
    rows: &[&Case],
    name: &str,
    palette: &Palette,
) -> Result<Option<String>, ChapterError> {
    let Some(first) = rows.first() else {
        return Ok(None);
    };
    let (by_time, clock) = (format!("{name}: error against time"), data.time_axis());
    let panel = |title, across, curves| WorkPrecision {
        title,
        across,
        up: "error, m: largest (filled), RMS (open)",
        upwards: Upwards::Error,
        curves,
        lines: reference_lines(first),
    };
    let time = |row: &Case| data.time(row.condition(ROUTE));
    let operations = |row: &Case| row.value(OPERATIONS_COST).map(Reading::exact);
    let both = [
        panel(by_time.as_str(), clock.as_str(), curves(rows, time)),
        panel(
            "Error against operations",
            "operations, weighted, in fused multiply-adds",
            curves(rows, operations),
        ),
    ];
    let title = format!("{name}: error against cost");
    Ok(panels(&title, &both, Arrangement::Stacked, palette)?)
}

/// A curve for each family, through its knob.
fn curves(rows: &[&Case], cost: impl Fn(&Case) -> Option<Reading>) -> Vec<Curve> {
    let point = |row: &Case| Point {
        knob: number(row, KNOB).unwrap_or_default(),
        label: row.condition(KNOB).to_owned(),
        x: cost(row),
        y: row.value(DEVICE_MAX_M).map(Reading::exact),
        y_rms: row.value(DEVICE_RMS_M),
        standing: standing(row),
        command: String::new(),
    };
    let families = grouped(rows.iter().copied(), |row| row.condition(FAMILY));
    let curve = |(name, rows): (&str, Vec<&Case>)| Curve {
        name: name.to_owned(),
        points: rows.into_iter().map(point).collect(),
    };
    families.into_iter().map(curve).collect()
}

/// An answer that is not finite has no place, nor has a route that is no map of the region; an error
/// above its bound has, and counts for nothing.
fn standing(row: &Case) -> PointStanding {
    match row.outcome {
        Outcome::Ok => PointStanding::Right,
        Outcome::Wrong if non_finite(row) == 0 && row.value(MEASURED_OVER_EXPECTED).is_some() => {
            PointStanding::Wrong
        }
        _ => PointStanding::Failed,
    }
}

/// A quarter of a texel, the last place of an answer, and what the specification allows.
fn reference_lines(row: &Case) -> Vec<ReferenceLine> {
    let line = |label: &str, y: f64| ReferenceLine {
        label: label.to_owned(),
        from_x: None,
        y,
        power: 0.0,
    };
    let (Some(extent_deg), Some(latitude_deg)) =
        (number(row, EXTENT_DEG), number(row, LATITUDE_DEG))
    else {
        return Vec::new();
    };
    let height_rad = extent_deg.min(180.0).to_radians();
    let mut lines = Vec::new();
    if let Some(texels) = row.value(TEXTURE_PX) {
        let texel_m = height_rad * EARTH_M / texels;
        lines.push(line("¼ texel", QUARTER * texel_m));
    }
    // The answer is the angle from the anchor: at most half of the extent.
    let half_rad = 0.5 * extent_deg.to_radians();
    lines.push(line(
        "last place of the answer in f32",
        0.5 * ulp(half_rad) * EARTH_M,
    ));
    // The angles that atan2 gives are absolute, latitude or longitude.
    let angle_rad = half_rad.max(latitude_deg.to_radians());
    let specified = SPECIFIED_ULP * ulp(angle_rad) * EARTH_M;
    lines.push(line("atan2 by the specification", specified));
    lines
}

/// Unit in the last place of `value` in `f32`.
pub(super) fn ulp(value: f64) -> f64 {
    (value.log2().floor() - 23.0).exp2()
}
