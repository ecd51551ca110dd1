// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tables: what a plan takes, errors of positions, and where formulas break.

use super::data::{
    DEFAULT_POSITION, Data, MIDDLE, NO_REASON, PLAN, QUARTER, count_of, is_chosen, non_finite,
    number,
};
use crate::error::agrees;
use crate::metrics::*;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Block, Case, Cell, ConditionKey, Heading, Metric, Outcome, Row, Table};

/// Distances of the position tables, metres, with their headings.
const DISTANCES: [(f64, &str); 4] = [
    (20.0, "20 m"),
    (1e3, "1 km"),
    (1e6, "1,000 km"),
    (3e7, "30,000 km"),
];

/// Depth formats of the position table; the rows of the others are in the file.
const DEPTHS: [&str; 4] = [
    "reversed-float32-infinite",
    "standard-float32-infinite",
    "standard-unorm24-infinite",
    "logarithmic-float32-finite",
];

/// Headings of the table of special inputs.
const OF_INPUTS: [&str; 5] = [
    "input",
    "not finite, emulated",
    "not finite, device",
    "the device's atan2 says (rad)",
    "families to keep from there",
];

/// Headings of the table of disagreements.
const OF_FAMILIES: [&str; 6] = [
    "family",
    "rows",
    "measured ÷ expected",
    "RMS within 2 ×",
    "the farthest",
    "reason",
];

/// Stands for what is not there.
const NONE: &str = "–";

pub(super) fn row(name: &str, texts: impl IntoIterator<Item = String>, is_bad: bool) -> Row {
    let cell = |text: String| match text.as_str() {
        NONE => Cell::absent(""),
        _ => Cell::plain(text),
    };
    let name = std::iter::once(Cell::name(name));
    let cells = name.chain(texts.into_iter().map(cell));
    Row::new(cells.collect()).bad_if(is_bad)
}

/// The table under its heading; nothing without a row.
fn table<T: Into<String>>(
    [heading, caption]: [&str; 2],
    headings: impl IntoIterator<Item = T>,
    rows: Vec<Row>,
) -> Vec<Block> {
    if rows.is_empty() {
        return Vec::new();
    }
    vec![
        Block::section(heading),
        Block::Table(Table {
            caption: caption.to_owned(),
            headings: headings.into_iter().map(Heading::plain).collect(),
            rows,
            ..Table::default()
        }),
    ]
}

/// The tables of the study beside what is recommended.
pub(super) fn tables(data: &Data<'_>) -> Vec<Block> {
    let by_distance = |first| std::iter::once(first).chain(DISTANCES.map(|(_, heading)| heading));
    let all = [
        table(
            [
                "Position from depth",
                "Largest error of a fragment's offset from its region's anchor, on the device, over all extents \
                 and latitudes, the anchor where a plan puts it for this eye; for the default also in the middle \
                 of the region, so that what a plan's anchor is worth is seen. Pixels of a view of 60° on 1,080 \
                 rows. Red: more than ¼ pixel somewhere.",
            ],
            by_distance("route, depth"),
            positions(data),
        ),
        table(
            [
                "Position of a vertex",
                "Largest error of one component relative to the eye, in a region of 1°, by emulation. Red: \
                 more than ¼ pixel somewhere.",
            ],
            by_distance("format"),
            vertices(data),
        ),
        table(
            [
                "Formula against measurement",
                "Where measured and expected error differ by more than twice, by reason and family, the most \
                 frequent reason first. Expected is the formula's own error and 2.5 standard deviations of its \
                 roundings, each correct and independent; the bound that no error may exceed is another, and is \
                 checked above. Of positions, root mean squares are compared.",
            ],
            OF_FAMILIES,
            disagreements(data),
        ),
        table(
            [
                "Where formulas break",
                "Inputs that are special to floating point or to the map. The last seven lines are \
                 no fragment's: stencil and depth keep them away.",
            ],
            OF_INPUTS,
            special_inputs(data),
        ),
    ];
    all.into_iter().flatten().collect()
}

/// Extent across, latitude down: what a plan takes with terrain up to 9 km, and its error.
pub(super) fn recommended(data: &Data<'_>) -> Vec<Block> {
    let chosen: Vec<&Case> = data
        .formulas
        .iter()
        .filter(|row| is_chosen(row) && number(row, HIGHEST_M) == Some(9_000.0))
        .collect();
    let distinct = |of: ConditionKey| {
        let mut values: Vec<f64> = chosen.iter().filter_map(|row| number(row, of)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let extents = distinct(EXTENT_DEG);
    let cell = |latitude: f64, extent: f64| {
        let at = |row: &&Case| [LATITUDE_DEG, EXTENT_DEG].map(|key| number(row, key));
        let mut here = chosen.iter();
        let here = here.find(|row| at(row) == [Some(latitude), Some(extent)]);
        here.map_or_else(
            || NONE.to_owned(),
            |row| {
                format!(
                    "{} · {}",
                    row.condition(ROUTE),
                    or_none(row.value(RMS_TEXELS))
                )
            },
        )
    };
    let rows = distinct(LATITUDE_DEG).into_iter().map(|latitude| {
        let cells = extents.iter().map(|extent| cell(latitude, *extent));
        row(&format!("{latitude}°"), cells, false)
    });
    let of_extents = extents.iter().map(|extent| format!("{extent}°"));
    table(
        [
            "What a plan takes",
            "The cheapest route whose computed residual is within ¼ texel and ¼ pixel RMS and ½ texel at \
             most, for terrain up to 9 km, with its measured RMS error in texels. Columns: extent. The \
             picture has 4096 texels a side, from 90° on 16,384; the view shows the region on 1,080 rows. \
             A dash: a region that is another one's already.",
        ],
        std::iter::once("latitude".to_owned()).chain(of_extents),
        rows.collect(),
    )
}

fn or_none(value: Option<f64>) -> String {
    value.map_or_else(|| NONE.to_owned(), significant)
}

/// The errors of one route or format by distance.
fn by_distance(name: &str, found: [Option<&Case>; 4], error_m: &Metric) -> Row {
    let text = |row: Option<&Case>| {
        let of = |metric| row?.value(metric);
        match (of(error_m), of(PIXEL_M)) {
            _ if row.is_some_and(|row| non_finite(row) > 0) => "not finite".to_owned(),
            (Some(metres), Some(pixel)) => {
                let pixels = metres / pixel;
                format!("{} m · {} px", significant(metres), significant(pixels))
            }
            _ => NONE.to_owned(),
        }
    };
    let is_bad =
        |row: &&Case| non_finite(row) > 0 || row.value(MAX_PX).is_some_and(|px| px > QUARTER);
    row(name, found.map(text), found.iter().flatten().any(is_bad))
}

/// Route and depth down, distance across: the worst over extents and latitudes, anchored where a plan
/// does; below it the default anchored in the middle of its region.
pub(super) fn positions(data: &Data<'_>) -> Vec<Row> {
    let mut routes = data.of("position").distinct(ROUTE);
    routes.sort_unstable();
    let mut rows = Vec::new();
    for depth in DEPTHS {
        for route in &routes {
            rows.extend(position(data, route, depth, PLAN));
            if (*route, depth) == DEFAULT_POSITION {
                rows.extend(position(data, route, depth, MIDDLE));
            }
        }
    }
    rows
}

fn position(data: &Data<'_>, route: &str, depth: &str, anchor: &str) -> Option<Row> {
    let own = [(ROUTE, route), (DEPTH_FORMAT, depth), (ANCHOR, anchor)];
    let own = data.of("position").with(&own);
    let found = DISTANCES.map(|(distance, _)| {
        let here = own
            .iter()
            .filter(|row| number(row, DISTANCE_M) == Some(distance));
        // What is not finite has no largest error and is worse than any.
        here.max_by(|a, b| {
            let error = |row: &Case| row.value(DEVICE_MAX_M).unwrap_or(-1.0);
            let by_count = non_finite(a).cmp(&non_finite(b));
            by_count.then(error(a).total_cmp(&error(b)))
        })
    });
    let aside = match anchor {
        MIDDLE => ", anchor=middle",
        _ => "",
    };
    let is_known = found.iter().any(Option::is_some);
    is_known.then(|| by_distance(&format!("{route}, {depth}{aside}"), found, DEVICE_MAX_M))
}

/// Vertex formats down, distance across, in a region of 1°.
fn vertices(data: &Data<'_>) -> Vec<Row> {
    let vertices = data.of("vertex");
    let row = |format: &str| {
        let found = DISTANCES.map(|(distance, _)| {
            vertices.iter().find(|row| {
                row.condition(ROUTE) == format
                    && number(row, DISTANCE_M) == Some(distance)
                    && number(row, EXTENT_DEG) == Some(1.0)
            })
        });
        by_distance(format, found, EMULATED_MAX_M)
    };
    vertices.distinct(ROUTE).into_iter().map(row).collect()
}

/// Families whose formula and measurement differ by more than twice, by reason: those without one first, then the
/// most frequent one.
pub(super) fn disagreements(data: &Data<'_>) -> Vec<Row> {
    let mut groups: BTreeMap<(&str, &str), Vec<(f64, &Case)>> = BTreeMap::new();
    let mut of_reason: BTreeMap<&str, usize> = BTreeMap::new();
    for row in data.formulas.iter() {
        let ratio = row.value(MEASURED_OVER_EXPECTED);
        if let Some(ratio) = ratio.filter(|ratio| !agrees(*ratio)) {
            let reason = row.note("residual_reason");
            let group = groups.entry((reason, row.condition(FAMILY))).or_default();
            group.push((ratio, row));
            *of_reason.entry(reason).or_default() += 1;
        }
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|((reason, _), rows)| {
        let frequency = std::cmp::Reverse((of_reason[reason], rows.len()));
        (!reason.contains(NO_REASON), frequency)
    });
    let rows = groups.into_iter().filter_map(|((reason, family), rows)| {
        let by_ratio = |a: &&(f64, _), b: &&(f64, _)| a.0.total_cmp(&b.0);
        let (least, at) = rows.iter().min_by(by_ratio)?;
        let (most, _) = rows.iter().max_by(by_ratio)?;
        let rms_agrees = rows.iter().filter(|(_, row)| {
            let ratio = row.value(RMS_OVER_RESIDUAL);
            ratio.is_some_and(agrees)
        });
        let [agreeing, all] = [rms_agrees.count(), rows.len()].map(|rows| count(rows as u64));
        let texts = [
            all.clone(),
            format!("{} … {}", significant(*least), significant(*most)),
            format!("{agreeing} of {all}"),
            format!("{}, {}", at.condition(ROUTE), at.condition(CONDITION)),
            reason.to_owned(),
        ];
        Some(row(family, texts, reason.contains(NO_REASON)))
    });
    rows.collect()
}

/// How many of the rows have answers that are not finite.
fn share_not_finite(rows: &[&Case], of: &Metric) -> String {
    let found = rows.iter().filter(|row| count_of(row, of) > 0);
    format!("{} of {}", found.count(), rows.len())
}

/// Inputs where formulas break: which of them do. Last, position routes where nothing was drawn.
fn special_inputs(data: &Data<'_>) -> Vec<Row> {
    let special = data.of("special");
    let of_input = |condition: &str| {
        let own = special.with(&[(CONDITION, condition)]);
        let own: Vec<&Case> = own.iter().collect();
        let native = own
            .iter()
            .find(|row| row.condition(FAMILY) == "atan2-native");
        let wrong = own.iter().filter(|row| row.outcome == Outcome::Wrong);
        let wrong: BTreeSet<&str> = wrong.map(|row| row.condition(FAMILY)).collect();
        let texts = [
            share_not_finite(&own, NON_FINITE_EMULATED),
            share_not_finite(&own, NON_FINITE_DEVICE),
            native
                .map_or(NONE, |row| row.note("device_answer"))
                .to_owned(),
            wrong.iter().copied().collect::<Vec<_>>().join(", "),
        ];
        row(condition, texts, !wrong.is_empty())
    };
    let mut rows: Vec<Row> = special
        .distinct(CONDITION)
        .into_iter()
        .map(of_input)
        .collect();
    let cleared = data.of("position");
    let cleared = cleared.fitting(|row| number(row, DISTANCE_M).is_none());
    let cleared: Vec<&Case> = cleared.iter().collect();
    if !cleared.is_empty() {
        let texts = [
            share_not_finite(&cleared, NON_FINITE_EMULATED),
            share_not_finite(&cleared, NON_FINITE_DEVICE),
            NONE.to_owned(),
            String::new(),
        ];
        rows.push(row(
            "cleared depth (position routes × depth formats)",
            texts,
            false,
        ));
    }
    rows
}
