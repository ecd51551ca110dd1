// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tables: what a plan takes, errors of positions, and where formulas break.

use super::data::{DEFAULT_POSITION, Data, Formula, MIDDLE, NO_REASON, PLAN, QUARTER, agrees};
use crate::conditions::{DEPTH_FORMAT, DISTANCE_M, EXTENT_DEG, HIGHEST_M, LATITUDE_DEG};
use crate::keys::{
    DEVICE_MAX_M, EMULATED_MAX_M, MAX_PX, MEASURED_OVER_EXPECTED, NON_FINITE_DEVICE,
    NON_FINITE_EMULATED, PIXEL_M, RMS_OVER_RESIDUAL, RMS_TEXELS,
};
use std::collections::{BTreeMap, BTreeSet};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Block, Cell, ConditionKey, Heading, Metric, Outcome, Row, Table};

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

/// A table of texts.
pub(super) struct Grid {
    pub(super) headings: Vec<String>,
    pub(super) rows: Vec<Line>,
}

/// One of its rows.
pub(super) struct Line {
    pub(super) name: String,
    pub(super) cells: Vec<String>,
    pub(super) is_bad: bool,
}

impl Grid {
    /// The table under its heading; nothing without a row.
    pub(super) fn blocks(self, heading: &str, caption: &str) -> Vec<Block> {
        if self.rows.is_empty() {
            return Vec::new();
        }
        let cell = |text: String| match text.as_str() {
            "–" => Cell::absent(""),
            _ => Cell::plain(text),
        };
        let row = |line: Line| {
            let cells = line.cells.into_iter().map(cell);
            Row::new(
                std::iter::once(Cell::name(line.name))
                    .chain(cells)
                    .collect(),
            )
            .bad_if(line.is_bad)
        };
        vec![
            Block::section(heading),
            Block::Table(Table {
                caption: caption.to_owned(),
                headings: self.headings.into_iter().map(Heading::plain).collect(),
                rows: self.rows.into_iter().map(row).collect(),
                ..Table::default()
            }),
        ]
    }
}

/// The routes that are recommended.
pub(super) fn recommended(data: &Data<'_>) -> Vec<Block> {
    chosen_table(data).blocks(
        "What a plan takes",
        "The cheapest route whose computed residual is within ¼ texel and ¼ pixel RMS and ½ texel at \
         most, for terrain up to 9 km, with its measured RMS error in texels. Columns: extent. The \
         picture has 4096 texels a side, from 90° on 16,384; the view shows the region on 1,080 rows. \
         A dash: a region that is another one's already.",
    )
}

/// The other tables of the study.
pub(super) fn tables(data: &Data<'_>) -> Vec<Block> {
    let all = [
        (
            "Position from depth",
            "Largest error of a fragment's offset from its region's anchor, on the device, over all extents \
             and latitudes, the anchor where a plan puts it for this eye; for the default also in the middle \
             of the region, so that what a plan's anchor is worth is seen. Pixels of a view of 60° on 1,080 \
             rows. Red: more than ¼ pixel somewhere.",
            position_table(data),
        ),
        (
            "Position of a vertex",
            "Largest error of one component relative to the eye, in a region of 1°, by emulation. Red: \
             more than ¼ pixel somewhere.",
            vertex_table(data),
        ),
        (
            "Why formula and measurement differ",
            "Rows whose measured and expected error differ by more than twice, by reason.",
            reason_table(data),
        ),
        (
            "Formula against measurement",
            "Where measured and expected error differ by more than twice, by family and reason. Expected is \
             the formula's own error and 2.5 standard deviations of its roundings, each correct and \
             independent; the bound that no error may exceed is another, and is checked above. Of \
             positions, root mean squares are compared.",
            disagreement_table(data),
        ),
        (
            "Where formulas break",
            "Inputs that are special to floating point or to the map. The last seven lines are \
             no fragment's: stencil and depth keep them away.",
            special_table(data),
        ),
    ];
    let blocks = all
        .into_iter()
        .flat_map(|(heading, caption, grid)| grid.blocks(heading, caption));
    blocks.collect()
}

/// Extent across, latitude down: what a plan takes with terrain up to 9 km, and its error.
fn chosen_table(data: &Data<'_>) -> Grid {
    let formulas = data.formulas.iter().copied();
    let rows: Vec<Formula<'_>> = formulas
        .filter(|row| row.is_chosen() && row.number(HIGHEST_M) == Some(9_000.0))
        .collect();
    let distinct = |of: ConditionKey| {
        let mut values: Vec<f64> = rows.iter().filter_map(|row| row.number(of)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let extents = distinct(EXTENT_DEG);
    let latitudes = distinct(LATITUDE_DEG);
    let cell = |latitude: f64, extent: f64| {
        let here = |row: &&Formula<'_>| {
            row.number(LATITUDE_DEG) == Some(latitude) && row.number(EXTENT_DEG) == Some(extent)
        };
        let row = rows.iter().find(here)?;
        let texels = row
            .figure(RMS_TEXELS)
            .map_or_else(|| "–".to_owned(), significant);
        Some(format!("{} · {texels}", row.route()))
    };
    Grid {
        headings: std::iter::once("latitude".to_owned())
            .chain(extents.iter().map(|extent| format!("{extent}°")))
            .collect(),
        rows: latitudes
            .iter()
            .map(|latitude| Line {
                name: format!("{latitude}°"),
                cells: extents
                    .iter()
                    .map(|extent| cell(*latitude, *extent).unwrap_or_else(|| "–".to_owned()))
                    .collect(),
                is_bad: false,
            })
            .collect(),
    }
}

fn metres_and_pixels(row: Option<Formula<'_>>, metres: Option<f64>) -> String {
    let Some(row) = row else {
        return "–".to_owned();
    };
    match (metres, row.figure(PIXEL_M)) {
        _ if row.non_finite() > 0 => "not finite".to_owned(),
        (Some(metres), Some(pixel)) => {
            format!(
                "{} m · {} px",
                significant(metres),
                significant(metres / pixel)
            )
        }
        _ => "–".to_owned(),
    }
}

/// Route and depth down, distance across: the worst over extents and latitudes, anchored where a plan
/// does; below it the default anchored in the middle of its region.
pub(super) fn position_table(data: &Data<'_>) -> Grid {
    let routes: BTreeSet<&str> = data.of("position").map(|row| row.route()).collect();
    let (default_route, default_depth) = DEFAULT_POSITION;
    let mut rows = Vec::new();
    for depth in DEPTHS {
        for route in &routes {
            rows.extend(position_row(data, route, depth, PLAN));
            if (*route, depth) == (default_route, default_depth) {
                rows.extend(position_row(data, route, depth, MIDDLE));
            }
        }
    }
    Grid {
        headings: headings("route, depth"),
        rows,
    }
}

fn position_row(data: &Data<'_>, route: &str, depth: &str, anchor: &str) -> Option<Line> {
    let worst = |distance: f64| {
        let here = data.of("position").filter(|row| {
            row.route() == route
                && row.0.condition(DEPTH_FORMAT) == depth
                && row.anchor() == anchor
                && row.number(DISTANCE_M) == Some(distance)
        });
        // What is not finite has no largest error and is worse than any.
        here.max_by(|a, b| {
            let worth =
                |row: Formula<'_>| (row.non_finite(), row.figure(DEVICE_MAX_M).unwrap_or(-1.0));
            let (a, b) = (worth(*a), worth(*b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    };
    let found = DISTANCES.map(|(distance, _)| worst(distance));
    if found.iter().all(Option::is_none) {
        return None;
    }
    let aside = if anchor == MIDDLE {
        ", anchor=middle"
    } else {
        ""
    };
    Some(Line {
        name: format!("{route}, {depth}{aside}"),
        cells: found
            .iter()
            .map(|row| metres_and_pixels(*row, row.and_then(|row| row.figure(DEVICE_MAX_M))))
            .collect(),
        is_bad: found
            .iter()
            .flatten()
            .any(|row| row.non_finite() > 0 || row.figure(MAX_PX).is_some_and(|px| px > QUARTER)),
    })
}

fn headings(first: &str) -> Vec<String> {
    std::iter::once(first)
        .chain(DISTANCES.iter().map(|(_, heading)| *heading))
        .map(str::to_owned)
        .collect()
}

/// Vertex formats down, distance across, in a region of 1°.
fn vertex_table(data: &Data<'_>) -> Grid {
    let mut formats: Vec<&str> = Vec::new();
    for row in data.of("vertex") {
        if !formats.contains(&row.route()) {
            formats.push(row.route());
        }
    }
    let rows = formats.into_iter().map(|format| {
        let at = |distance: f64| {
            data.of("vertex").find(|row| {
                row.route() == format
                    && row.number(DISTANCE_M) == Some(distance)
                    && row.number(EXTENT_DEG) == Some(1.0)
            })
        };
        let found = DISTANCES.map(|(distance, _)| at(distance));
        Line {
            name: format.to_owned(),
            cells: found
                .iter()
                .map(|row| metres_and_pixels(*row, row.and_then(|row| row.figure(EMULATED_MAX_M))))
                .collect(),
            is_bad: found
                .iter()
                .flatten()
                .any(|row| row.figure(MAX_PX).is_some_and(|px| px > QUARTER)),
        }
    });
    Grid {
        headings: headings("format"),
        rows: rows.collect(),
    }
}

/// Why formula and measurement differ by more than twice, the most frequent reason first.
pub(super) fn reason_table(data: &Data<'_>) -> Grid {
    let mut groups: BTreeMap<(&str, bool), Vec<Formula<'_>>> = BTreeMap::new();
    for &row in &data.formulas {
        if let Some(ratio) = row
            .figure(MEASURED_OVER_EXPECTED)
            .filter(|ratio| !agrees(*ratio))
        {
            let group = (row.0.note("residual_reason"), ratio > 1.0);
            groups.entry(group).or_default().push(row);
        }
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
    let rows = groups.into_iter().map(|((reason, is_more), rows)| {
        let mut families: BTreeMap<&str, usize> = BTreeMap::new();
        for row in &rows {
            *families.entry(row.family()).or_default() += 1;
        }
        let mut families: Vec<_> = families.into_iter().collect();
        families.sort_by_key(|(_, rows)| std::cmp::Reverse(*rows));
        let families = families
            .iter()
            .map(|(family, rows)| format!("{family} {rows}"));
        let direction = if is_more {
            "more than twice"
        } else {
            "less than half"
        };
        Line {
            name: reason.to_owned(),
            cells: vec![
                count(rows.len() as u64),
                direction.to_owned(),
                families.collect::<Vec<_>>().join(", "),
            ],
            is_bad: reason.contains(NO_REASON),
        }
    });
    let headings = [
        "reason",
        "rows",
        "measured, of what was expected",
        "families",
    ];
    Grid {
        rows: rows.collect(),
        headings: headings.map(str::to_owned).into(),
    }
}

/// Families whose formula and measurement differ by more than twice, by reason.
pub(super) fn disagreement_table(data: &Data<'_>) -> Grid {
    let mut groups: BTreeMap<(&str, &str), Vec<Formula<'_>>> = BTreeMap::new();
    for &row in &data.formulas {
        if row
            .figure(MEASURED_OVER_EXPECTED)
            .is_some_and(|ratio| !agrees(ratio))
        {
            let group = (row.0.note("residual_reason"), row.family());
            groups.entry(group).or_default().push(row);
        }
    }
    let rows = groups.into_iter().filter_map(|((reason, family), rows)| {
        let ratios = || {
            rows.iter()
                .filter_map(|row| Some((row.figure(MEASURED_OVER_EXPECTED)?, row)))
        };
        let (least, at) = ratios().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (most, _) = ratios().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let rms_agrees = rows
            .iter()
            .filter(|row| row.figure(RMS_OVER_RESIDUAL).is_some_and(agrees))
            .count();
        Some(Line {
            name: family.to_owned(),
            cells: vec![
                count(rows.len() as u64),
                format!("{} … {}", significant(least), significant(most)),
                format!(
                    "{} of {}",
                    count(rms_agrees as u64),
                    count(rows.len() as u64)
                ),
                format!("{}, {}", at.route(), at.condition()),
                reason.to_owned(),
            ],
            is_bad: reason.contains(NO_REASON),
        })
    });
    let headings = [
        "family",
        "rows",
        "measured ÷ expected",
        "RMS within 2 ×",
        "the farthest",
        "reason",
    ];
    let mut rows: Vec<Line> = rows.collect();
    rows.sort_by_key(|row| !row.is_bad);
    Grid {
        headings: headings.map(str::to_owned).into(),
        rows,
    }
}

/// Inputs where formulas break: which of them do.
fn special_table(data: &Data<'_>) -> Grid {
    let mut conditions: Vec<&str> = Vec::new();
    for row in data.of("special") {
        if !conditions.contains(&row.condition()) {
            conditions.push(row.condition());
        }
    }
    let rows = conditions.into_iter().map(|condition| {
        let rows: Vec<Formula<'_>> = data
            .of("special")
            .filter(|row| row.condition() == condition)
            .collect();
        let non_finite = |of: &Metric| {
            rows.iter()
                .filter(|row| row.count(of).is_some_and(|n| n > 0))
                .count()
        };
        let emulated = non_finite(NON_FINITE_EMULATED);
        let device = non_finite(NON_FINITE_DEVICE);
        let native = rows.iter().find(|row| row.family() == "atan2-native");
        let wrong: BTreeSet<&str> = rows
            .iter()
            .filter(|row| row.0.outcome == Outcome::Wrong)
            .map(|row| row.family())
            .collect();
        Line {
            name: condition.to_owned(),
            cells: vec![
                format!("{emulated} of {}", rows.len()),
                format!("{device} of {}", rows.len()),
                native.map_or_else(
                    || "–".to_owned(),
                    |row| row.0.note("device_answer").to_owned(),
                ),
                wrong.into_iter().collect::<Vec<_>>().join(", "),
            ],
            is_bad: rows.iter().any(|row| row.0.outcome == Outcome::Wrong),
        }
    });
    let mut rows: Vec<Line> = rows.collect();
    rows.extend(cleared_row(data));
    let headings = [
        "input",
        "not finite, emulated",
        "not finite, device",
        "the device's atan2 says (rad)",
        "families to keep from there",
    ];
    Grid {
        headings: headings.map(str::to_owned).into(),
        rows,
    }
}

/// Position routes where nothing was drawn.
fn cleared_row(data: &Data<'_>) -> Option<Line> {
    let rows: Vec<Formula<'_>> = data
        .of("position")
        .filter(|row| row.number(DISTANCE_M).is_none())
        .collect();
    let count = |of: &Metric| {
        let found = rows
            .iter()
            .filter(|row| row.count(of).is_some_and(|n| n > 0));
        format!("{} of {}", found.count(), rows.len())
    };
    (!rows.is_empty()).then(|| Line {
        name: "cleared depth (position routes × depth formats)".to_owned(),
        cells: vec![
            count(NON_FINITE_EMULATED),
            count(NON_FINITE_DEVICE),
            "–".to_owned(),
            String::new(),
        ],
        is_bad: false,
    })
}
