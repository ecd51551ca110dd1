// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on precision: every route from a fragment to its texture coordinate, its error against
//! its cost, and where formula and measurement part.

use crate::number::{count, significant};
use crate::plot::{Curve, Point, Reading, ReferenceLine, Standing};
use crate::run_data::RunData;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_results::legacy::{
    PrecisionPart, PrecisionPlan, PrecisionRow, PrecisionTime, Status, spread,
};

/// A formula that costs less than this much beyond the loop around it is below what the clock tells:
/// it is drawn here. Nanoseconds.
pub(crate) const LEAST_NS: f64 = 0.01;

/// Formula and measurement agree within this factor.
pub(crate) const AGREEMENT: f64 = 2.0;

/// What a bound found at some thousand places may miss of a peak between them.
const BOUND_SLACK: f64 = 1.02;

/// A quarter of a texel, and of a pixel: what a plan allows on average.
pub(crate) const QUARTER: f64 = 0.25;

/// Largest error of a plan's route, texels.
const LARGEST_TEXELS: f64 = 0.5;

/// WGSL and Vulkan allow `atan2` this many units in the last place.
const SPECIFIED_ULP: f64 = 4096.0;

/// Mean radius of the Earth, metres: what reference lines turn radians into metres by.
const EARTH_M: f64 = 6_371_008.8;

/// The position route and depth that are drawn with by default.
const DEFAULT_POSITION: (&str, &str) = ("eye-region", "reversed-float32-infinite");

/// Where anchors stand, as in the `anchor` column.
const PLAN: &str = "plan";
const MIDDLE: &str = "middle";

/// What the default position must not exceed, metres, at this distance.
const DEFAULT_LIMIT: (f64, f64) = (20.0, 1e-4);

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

/// Regions that are drawn: extent, latitude and heights as in the `condition` column.
const DRAWN: [(&str, &str); 6] = [
    (
        "extent=0.01;latitude=45;heights=+9km",
        "0.01°, latitude 45°",
    ),
    ("extent=1;latitude=45;heights=+9km", "1°, latitude 45°"),
    ("extent=10;latitude=45;heights=+9km", "10°, latitude 45°"),
    (
        "extent=10;latitude=90;heights=+9km",
        "a cap of 5° round the pole",
    ),
    ("extent=90;latitude=45;heights=+9km", "90°, latitude 45°"),
    ("extent=360;latitude=0;heights=+9km", "The globe"),
];

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

/// The suite's rows of a run.
#[derive(Debug, Default)]
pub(crate) struct PrecisionData {
    pub(crate) rows: Vec<PrecisionRow>,
    /// Nanoseconds of each formula, CPU time of the process, one for each round.
    cpu_ns: BTreeMap<(PrecisionPart, String), Vec<f64>>,
    /// The same by the GPU's clock.
    gpu_ns: BTreeMap<(PrecisionPart, String), Vec<f64>>,
}

impl PrecisionData {
    /// Checks rows against their plan; what is missing becomes a note.
    pub(crate) fn new(
        plan: Option<&PrecisionPlan>,
        rows: Vec<PrecisionRow>,
        times: &[PrecisionTime],
        notes: &mut Vec<String>,
    ) -> Self {
        let found: BTreeSet<_> = rows.iter().map(PrecisionRow::key).collect();
        let missing: Vec<String> = plan
            .iter()
            .flat_map(|plan| plan.keys())
            .filter(|key| !found.contains(key))
            .map(|key| key.to_string())
            .collect();
        if !missing.is_empty() {
            let first: Vec<&str> = missing.iter().take(4).map(String::as_str).collect();
            notes.push(format!(
                "numerical suite: {} planned rows are missing, among them {}",
                missing.len(),
                first.join(", ")
            ));
        }
        if plan.is_none() && !rows.is_empty() {
            notes.push("numerical suite: rows without a plan; what is missing is not known".into());
        }
        let mut data = Self {
            rows,
            ..Self::default()
        };
        for time in times {
            let key = || (time.part, time.route.clone());
            data.cpu_ns.entry(key()).or_default().push(time.cpu_ns());
            if let Some(ns) = time.gpu_ns() {
                data.gpu_ns.entry(key()).or_default().push(ns);
            }
        }
        data
    }

    fn of(&self, part: PrecisionPart) -> impl Iterator<Item = &PrecisionRow> {
        self.rows.iter().filter(move |row| row.part == part)
    }

    /// Time of a coordinate route, as a plot has it.
    fn time(&self, route: &str, on_gpu: bool) -> Option<Reading> {
        let times = if on_gpu { &self.gpu_ns } else { &self.cpu_ns };
        let of_route = times.get(&(PrecisionPart::Coordinate, route.to_owned()))?;
        let seen: Vec<f64> = of_route.iter().map(|ns| ns.max(LEAST_NS)).collect();
        Some(Reading::sampled(spread(&seen)?, &seen))
    }
}

/// Two panels side by side over the same errors.
pub(crate) struct PrecisionPlot {
    pub(crate) title: String,
    pub(crate) by_time: Vec<Curve>,
    pub(crate) by_operations: Vec<Curve>,
    pub(crate) lines: Vec<ReferenceLine>,
}

/// A table as printed.
pub(crate) struct Table {
    pub(crate) headings: Vec<String>,
    pub(crate) rows: Vec<TableRow>,
}

/// One of its rows.
pub(crate) struct TableRow {
    pub(crate) name: String,
    pub(crate) cells: Vec<String>,
    pub(crate) is_bad: bool,
}

/// A sentence with its standing.
pub(crate) struct Finding {
    pub(crate) text: String,
    pub(crate) class: &'static str,
}

/// The chapter without its plots.
pub(crate) struct PrecisionChapter {
    pub(crate) summary: String,
    pub(crate) findings: Vec<Finding>,
    pub(crate) chosen: Table,
    pub(crate) positions: Table,
    pub(crate) vertices: Table,
    pub(crate) reasons: Table,
    pub(crate) disagreements: Table,
    pub(crate) special: Table,
    pub(crate) clock: &'static str,
}

/// The chapter; `None` for a run without the suite.
pub(crate) fn chapter(data: &RunData) -> Option<PrecisionChapter> {
    let precision = &data.precision;
    if precision.rows.is_empty() {
        return None;
    }
    Some(PrecisionChapter {
        summary: summary(precision),
        findings: findings(precision),
        chosen: chosen_table(precision),
        positions: position_table(precision),
        vertices: vertex_table(precision),
        reasons: reason_table(precision),
        disagreements: disagreement_table(precision),
        special: special_table(precision),
        clock: clock(data),
    })
}

/// On a software device the process's CPU time is the device's time; elsewhere the GPU's clock is.
fn is_gpu(data: &RunData) -> bool {
    data.environment.device_type != "cpu" && !data.precision.gpu_ns.is_empty()
}

fn clock(data: &RunData) -> &'static str {
    if is_gpu(data) {
        "ns per fragment, GPU clock: median, 5–95 % of rounds"
    } else {
        "ns per fragment, process CPU: median, 5–95 % of rounds"
    }
}

fn summary(data: &PrecisionData) -> String {
    let of = |status| data.rows.iter().filter(|row| row.status == status).count();
    let points: u64 = data.rows.iter().map(|row| u64::from(row.points)).sum();
    let routes: BTreeSet<&str> = data
        .of(PrecisionPart::Coordinate)
        .map(|row| row.route.as_str())
        .collect();
    format!(
        "{} rows of {} places in all, {} coordinate routes: {} within their bound, {} not finite, above \
         their bound or without one, {} not measured.",
        count(data.rows.len() as u64),
        count(points),
        routes.len(),
        of(Status::Ok),
        of(Status::Wrong),
        of(Status::Skipped) + of(Status::Failed),
    )
}

fn finding(holds: bool, text: String) -> Finding {
    Finding {
        class: if holds { "holds" } else { "does-not" },
        text,
    }
}

fn largest<'a>(
    rows: impl Iterator<Item = &'a PrecisionRow>,
    value: impl Fn(&PrecisionRow) -> Option<f64>,
) -> Option<(f64, &'a PrecisionRow)> {
    rows.filter_map(|row| Some((value(row)?, row)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

fn findings(data: &PrecisionData) -> Vec<Finding> {
    let mut findings = Vec::new();
    let chosen = || data.rows.iter().filter(|row| row.chosen);
    let non_finite: u64 = chosen().map(PrecisionRow::non_finite).sum();
    let contradicted = chosen().filter(|row| row.status != Status::Ok).count();
    let places: BTreeSet<&str> = data
        .of(PrecisionPart::Coordinate)
        .map(|row| row.condition.as_str())
        .collect();
    let rms = largest(chosen(), |row| row.rms_texels);
    let max = largest(chosen(), |row| row.max_texels);
    if let (Some((rms, rms_at)), Some((max, max_at))) = (rms, max) {
        let unchosen = places.len() - chosen().count();
        let within = rms <= QUARTER && max <= LARGEST_TEXELS;
        let holds = within && non_finite + (contradicted + unchosen) as u64 == 0;
        findings.push(finding(
            holds,
            format!(
                "Routes that a plan takes, on the device: at most {} texel RMS ({} at {}) and {} texel \
                 ({} at {}); {non_finite} answers not finite; {contradicted} contradicted by \
                 measurement; {unchosen} of {} regions without such a route.",
                significant(rms),
                rms_at.route,
                rms_at.condition,
                significant(max),
                max_at.route,
                max_at.condition,
                places.len(),
            ),
        ));
    }
    let default = || {
        data.of(PrecisionPart::Position)
            .filter(|row| (row.route.as_str(), row.depth_format.as_str()) == DEFAULT_POSITION)
    };
    // Rows of older runs have no anchor: theirs stood in the middle.
    let anchored = |anchor: &'static str| default().filter(move |row| row.anchor == anchor);
    let at_20_m = |anchor| {
        let near = anchored(anchor).filter(|row| row.distance_m == Some(DEFAULT_LIMIT.0));
        largest(near, |row| row.device_max_m)
    };
    let beside = |middle: Option<(f64, &PrecisionRow)>, unit: &str| {
        middle.map_or_else(String::new, |(most, row)| {
            let most = significant(most);
            format!(
                " Anchored in the middle of the region: {most} {unit} ({}).",
                row.condition
            )
        })
    };
    if let Some((metres, row)) = at_20_m(PLAN) {
        findings.push(finding(
            metres <= DEFAULT_LIMIT.1,
            format!(
                "The default position, {}, at 20 m, its anchor where a plan puts it: {} m at most ({}).{}",
                DEFAULT_POSITION.0,
                significant(metres),
                row.condition,
                beside(at_20_m(MIDDLE), "m"),
            ),
        ));
    }
    if let Some((pixels, row)) = largest(anchored(PLAN), |row| row.max_px) {
        let middle = largest(anchored(MIDDLE), |row| row.max_px);
        findings.push(finding(
            pixels <= QUARTER,
            format!(
                "The same from 10 m to 30,000 km, over every extent and latitude: at most {} of a pixel \
                 ({}).{}",
                significant(pixels),
                row.condition,
                beside(middle, "of a pixel"),
            ),
        ));
    }
    // Where a route is no map at all there is nothing to bound.
    let measured = || {
        data.rows
            .iter()
            .filter(|row| row.measured_over_expected.is_some())
    };
    let is_above = |row: &&PrecisionRow| row.max_over_residual.is_some_and(|r| r > BOUND_SLACK);
    let above = measured().filter(is_above).count();
    if let Some((ratio, row)) = largest(measured(), |row| row.max_over_residual) {
        findings.push(finding(
            above == 0,
            format!(
                "Largest measured error over its bound: {} ({}, {}); {above} of {} rows are above it by \
                 more than the 2 % that sampling may miss of a peak.",
                significant(ratio),
                row.route,
                row.condition,
                count(measured().count() as u64),
            ),
        ));
    }
    let agreeing = measured().filter(|row| row.measured_over_expected.is_some_and(agrees));
    let unexplained = measured()
        .filter(|row| row.residual_reason.contains(NO_REASON))
        .count();
    if measured().count() > 0 {
        findings.push(finding(
            unexplained == 0,
            format!(
                "Formula and measurement agree within 2 × in {} of {} rows; {unexplained} of the others have \
                 no known reason.",
                count(agreeing.count() as u64),
                count(measured().count() as u64),
            ),
        ));
    }
    findings
}

/// What a row says that has no better reason.
const NO_REASON: &str = "no reason";

fn agrees(ratio: f64) -> bool {
    (1.0 / AGREEMENT..=AGREEMENT).contains(&ratio)
}

/// Extent across, latitude down: what a plan takes with terrain up to 9 km, and its error.
fn chosen_table(data: &PrecisionData) -> Table {
    let rows: Vec<&PrecisionRow> = data
        .rows
        .iter()
        .filter(|row| row.chosen && row.highest_m == Some(9_000.0))
        .collect();
    let distinct = |of: fn(&PrecisionRow) -> Option<f64>| {
        let mut values: Vec<f64> = rows.iter().filter_map(|row| of(row)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let extents = distinct(|row| row.extent_deg);
    let latitudes = distinct(|row| row.latitude_deg);
    let cell = |latitude: f64, extent: f64| {
        let here = |row: &&&PrecisionRow| {
            row.latitude_deg == Some(latitude) && row.extent_deg == Some(extent)
        };
        let row = rows.iter().find(here)?;
        let texels = row.rms_texels.map_or_else(|| "–".to_owned(), significant);
        Some(format!("{} · {texels}", row.route))
    };
    Table {
        headings: std::iter::once("latitude".to_owned())
            .chain(extents.iter().map(|extent| format!("{extent}°")))
            .collect(),
        rows: latitudes
            .iter()
            .map(|latitude| TableRow {
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

fn metres_and_pixels(row: Option<&PrecisionRow>, metres: Option<f64>) -> String {
    let Some(row) = row else {
        return "–".to_owned();
    };
    match (metres, row.pixel_m) {
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
fn position_table(data: &PrecisionData) -> Table {
    let routes: BTreeSet<&str> = data
        .of(PrecisionPart::Position)
        .map(|row| row.route.as_str())
        .collect();
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
    Table {
        headings: headings("route, depth"),
        rows,
    }
}

fn position_row(data: &PrecisionData, route: &str, depth: &str, anchor: &str) -> Option<TableRow> {
    let worst = |distance: f64| {
        let here = data.of(PrecisionPart::Position).filter(|row| {
            row.route == route
                && row.depth_format == depth
                && row.anchor == anchor
                && row.distance_m == Some(distance)
        });
        // What is not finite has no largest error and is worse than any.
        here.max_by(|a, b| {
            let worth = |row: &PrecisionRow| (row.non_finite(), row.device_max_m.unwrap_or(-1.0));
            let (a, b) = (worth(a), worth(b));
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
    Some(TableRow {
        name: format!("{route}, {depth}{aside}"),
        cells: found
            .iter()
            .map(|row| metres_and_pixels(*row, row.and_then(|row| row.device_max_m)))
            .collect(),
        is_bad: found
            .iter()
            .flatten()
            .any(|row| row.non_finite() > 0 || row.max_px.is_some_and(|px| px > QUARTER)),
    })
}

fn headings(first: &str) -> Vec<String> {
    std::iter::once(first)
        .chain(DISTANCES.iter().map(|(_, heading)| *heading))
        .map(str::to_owned)
        .collect()
}

/// Vertex formats down, distance across, in a region of 1°.
fn vertex_table(data: &PrecisionData) -> Table {
    let mut formats: Vec<&str> = Vec::new();
    for row in data.of(PrecisionPart::Vertex) {
        if !formats.contains(&row.route.as_str()) {
            formats.push(&row.route);
        }
    }
    let rows = formats.into_iter().map(|format| {
        let at = |distance: f64| {
            data.of(PrecisionPart::Vertex).find(|row| {
                row.route == format
                    && row.distance_m == Some(distance)
                    && row.extent_deg == Some(1.0)
            })
        };
        let found = DISTANCES.map(|(distance, _)| at(distance));
        TableRow {
            name: format.to_owned(),
            cells: found
                .iter()
                .map(|row| metres_and_pixels(*row, row.and_then(|row| row.emulated_max_m)))
                .collect(),
            is_bad: found
                .iter()
                .flatten()
                .any(|row| row.max_px.is_some_and(|px| px > QUARTER)),
        }
    });
    Table {
        headings: headings("format"),
        rows: rows.collect(),
    }
}

/// Why formula and measurement part by more than twice, the most frequent reason first.
fn reason_table(data: &PrecisionData) -> Table {
    let mut groups: BTreeMap<(&str, bool), Vec<&PrecisionRow>> = BTreeMap::new();
    for row in &data.rows {
        if let Some(ratio) = row.measured_over_expected.filter(|ratio| !agrees(*ratio)) {
            let group = (row.residual_reason.as_str(), ratio > 1.0);
            groups.entry(group).or_default().push(row);
        }
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
    let rows = groups.into_iter().map(|((reason, is_more), rows)| {
        let mut families: BTreeMap<&str, usize> = BTreeMap::new();
        for row in &rows {
            *families.entry(row.family.as_str()).or_default() += 1;
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
        TableRow {
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
    Table {
        rows: rows.collect(),
        headings: headings.map(str::to_owned).into(),
    }
}

/// Families whose formula and measurement part by more than twice, by reason.
fn disagreement_table(data: &PrecisionData) -> Table {
    let mut groups: BTreeMap<(&str, &str), Vec<&PrecisionRow>> = BTreeMap::new();
    for row in &data.rows {
        if row
            .measured_over_expected
            .is_some_and(|ratio| !agrees(ratio))
        {
            let group = (row.residual_reason.as_str(), row.family.as_str());
            groups.entry(group).or_default().push(row);
        }
    }
    let rows = groups.into_iter().filter_map(|((reason, family), rows)| {
        let ratios = || {
            rows.iter()
                .filter_map(|row| Some((row.measured_over_expected?, row)))
        };
        let (least, at) = ratios().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (most, _) = ratios().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let rms_agrees = rows
            .iter()
            .filter(|row| row.rms_over_residual.is_some_and(agrees))
            .count();
        Some(TableRow {
            name: family.to_owned(),
            cells: vec![
                count(rows.len() as u64),
                format!("{} … {}", significant(least), significant(most)),
                format!(
                    "{} of {}",
                    count(rms_agrees as u64),
                    count(rows.len() as u64)
                ),
                format!("{}, {}", at.route, at.condition),
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
    let mut rows: Vec<TableRow> = rows.collect();
    rows.sort_by_key(|row| !row.is_bad);
    Table {
        headings: headings.map(str::to_owned).into(),
        rows,
    }
}

/// Inputs where formulas break: which of them do.
fn special_table(data: &PrecisionData) -> Table {
    let mut conditions: Vec<&str> = Vec::new();
    for row in data.of(PrecisionPart::Special) {
        if !conditions.contains(&row.condition.as_str()) {
            conditions.push(&row.condition);
        }
    }
    let rows = conditions.into_iter().map(|condition| {
        let rows: Vec<&PrecisionRow> = data
            .of(PrecisionPart::Special)
            .filter(|row| row.condition == condition)
            .collect();
        let non_finite = |of: fn(&PrecisionRow) -> Option<u64>| {
            rows.iter()
                .filter(|row| of(row).is_some_and(|n| n > 0))
                .count()
        };
        let emulated = non_finite(|row| row.non_finite_emulated);
        let device = non_finite(|row| row.non_finite_device);
        let native = rows.iter().find(|row| row.family == "atan2-native");
        let wrong: BTreeSet<&str> = rows
            .iter()
            .filter(|row| row.status == Status::Wrong)
            .map(|row| row.family.as_str())
            .collect();
        TableRow {
            name: condition.to_owned(),
            cells: vec![
                format!("{emulated} of {}", rows.len()),
                format!("{device} of {}", rows.len()),
                native.map_or_else(|| "–".to_owned(), |row| row.device_answer.clone()),
                wrong.into_iter().collect::<Vec<_>>().join(", "),
            ],
            is_bad: rows.iter().any(|row| row.status == Status::Wrong),
        }
    });
    let mut rows: Vec<TableRow> = rows.collect();
    rows.extend(cleared_row(data));
    let headings = [
        "input",
        "not finite, emulated",
        "not finite, device",
        "the device's atan2 says (rad)",
        "families to keep from there",
    ];
    Table {
        headings: headings.map(str::to_owned).into(),
        rows,
    }
}

/// Position routes where nothing was drawn.
fn cleared_row(data: &PrecisionData) -> Option<TableRow> {
    let rows: Vec<&PrecisionRow> = data
        .of(PrecisionPart::Position)
        .filter(|row| row.distance_m.is_none())
        .collect();
    let count = |of: fn(&PrecisionRow) -> Option<u64>| {
        let found = rows.iter().filter(|row| of(row).is_some_and(|n| n > 0));
        format!("{} of {}", found.count(), rows.len())
    };
    (!rows.is_empty()).then(|| TableRow {
        name: "cleared depth (position routes × depth formats)".to_owned(),
        cells: vec![
            count(|row| row.non_finite_emulated),
            count(|row| row.non_finite_device),
            "–".to_owned(),
            String::new(),
        ],
        is_bad: false,
    })
}

/// The plots: one for each region that is drawn and has rows, then every way to write the arctangent.
pub(crate) fn plots(data: &RunData) -> Vec<PrecisionPlot> {
    let on_gpu = is_gpu(data);
    let mut plots: Vec<PrecisionPlot> = DRAWN
        .iter()
        .filter_map(|(condition, name)| plot(&data.precision, condition, name, &FAMILIES, on_gpu))
        .collect();
    plots.extend(plot(
        &data.precision,
        POLYNOMIALS_AT,
        "Every way to write the arctangent, on the globe",
        &POLYNOMIALS,
        on_gpu,
    ));
    plots
}

fn plot(
    data: &PrecisionData,
    condition: &str,
    name: &str,
    families: &[&str],
    on_gpu: bool,
) -> Option<PrecisionPlot> {
    let rows: Vec<&PrecisionRow> = data
        .of(PrecisionPart::Coordinate)
        .filter(|row| row.condition == condition && families.contains(&row.family.as_str()))
        .collect();
    let first = rows.first()?;
    let time = |row: &PrecisionRow| data.time(&row.route, on_gpu);
    let operations = |row: &PrecisionRow| row.operations_cost.map(Reading::exact);
    Some(PrecisionPlot {
        title: name.to_owned(),
        by_time: curves(&rows, time),
        by_operations: curves(&rows, operations),
        lines: reference_lines(first),
    })
}

/// A curve for each family, through its knob.
fn curves(rows: &[&PrecisionRow], cost: impl Fn(&PrecisionRow) -> Option<Reading>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        let point = Point {
            knob: row.knob.unwrap_or_default(),
            label: row.knob.map(|knob| knob.to_string()).unwrap_or_default(),
            x: cost(row),
            y: row.device_max_m.map(Reading::exact),
            y_rms: row.device_rms_m,
            standing: standing(row),
        };
        match curves.iter_mut().find(|curve| curve.name == row.family) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name: row.family.clone(),
                points: vec![point],
            }),
        }
    }
    curves
}

/// An answer that is not finite has no place, nor has a route that is no map of the region; an error
/// above its bound has, and counts for nothing.
fn standing(row: &PrecisionRow) -> Standing {
    match row.status {
        Status::Ok => Standing::Right,
        Status::Wrong if row.non_finite() == 0 && row.measured_over_expected.is_some() => {
            Standing::Wrong
        }
        _ => Standing::Failed,
    }
}

/// A quarter of a texel, the last place of an answer, and what the specification allows.
fn reference_lines(row: &PrecisionRow) -> Vec<ReferenceLine> {
    let line = |label: &str, y: f64| ReferenceLine {
        label: label.to_owned(),
        from_x: None,
        y,
        power: 0.0,
    };
    let (Some(extent_deg), Some(latitude_deg)) = (row.extent_deg, row.latitude_deg) else {
        return Vec::new();
    };
    let height_rad = extent_deg.min(180.0).to_radians();
    let mut lines = Vec::new();
    if let Some(texels) = row.texture_px {
        let texel_m = height_rad * EARTH_M / f64::from(texels);
        lines.push(line("¼ texel", QUARTER * texel_m));
    }
    // The answer is the angle from the anchor: at most half of the extent.
    let half_rad = 0.5 * extent_deg.to_radians();
    lines.push(line(
        "last place of the answer in f32",
        0.5 * ulp(half_rad) * EARTH_M,
    ));
    // The angles that atan2 is asked for are absolute, latitude or longitude.
    let angle_rad = half_rad.max(latitude_deg.to_radians());
    let specified = SPECIFIED_ULP * ulp(angle_rad) * EARTH_M;
    lines.push(line("atan2 by the specification", specified));
    lines
}

/// Unit in the last place of `value` in `f32`.
fn ulp(value: f64) -> f64 {
    (value.log2().floor() - 23.0).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::legacy::{PrecisionGrid, PrecisionKey};

    fn row(route: &str, family: &str, knob: f64, error_m: f64) -> PrecisionRow {
        PrecisionRow {
            part: PrecisionPart::Coordinate,
            route: route.to_owned(),
            family: family.to_owned(),
            knob: Some(knob),
            condition: DRAWN[1].0.to_owned(),
            extent_deg: Some(1.0),
            latitude_deg: Some(45.0),
            status: Status::Ok,
            points: 100,
            device_max_m: Some(error_m),
            device_rms_m: Some(0.4 * error_m),
            max_over_residual: Some(0.8),
            texture_px: Some(4096),
            operations_cost: Some(10.0 * knob),
            ..PrecisionRow::default()
        }
    }

    fn time(route: &str, cpu_ms: f64) -> PrecisionTime {
        PrecisionTime {
            part: PrecisionPart::Coordinate,
            route: route.to_owned(),
            round: 0,
            evaluations: 1_000_000,
            cpu_ms,
            empty_cpu_ms: 1.0,
            gpu_ms: None,
            empty_gpu_ms: None,
        }
    }

    fn data() -> PrecisionData {
        let rows = vec![
            row("gnomonic-3", "gnomonic", 3.0, 0.3),
            row("gnomonic-2", "gnomonic", 2.0, 4.0),
            row("odd-7", "odd", 7.0, 500.0),
            row("no-such", "left out", 1.0, 1.0),
        ];
        let times = [
            time("gnomonic-3", 1.5),
            time("gnomonic-2", 0.9),
            time("odd-7", 3.0),
        ];
        PrecisionData::new(None, rows, &times, &mut Vec::new())
    }

    #[test]
    fn known_rows_are_the_points_of_the_plot() {
        let data = data();
        let plot = plot(&data, DRAWN[1].0, DRAWN[1].1, &FAMILIES, false).expect("rows");
        let names: Vec<&str> = plot
            .by_time
            .iter()
            .map(|curve| curve.name.as_str())
            .collect();
        assert_eq!(names, ["gnomonic", "odd"]);
        let gnomonic = &plot.by_time[0].points;
        assert_eq!(gnomonic.len(), 2);
        assert_eq!(gnomonic[0].y, Some(Reading::exact(0.3)));
        assert_eq!(gnomonic[0].y_rms, Some(0.4 * 0.3));
        let spread = |ns: f64| terrafill_results::legacy::Spread {
            p5: ns,
            median: ns,
            p95: ns,
        };
        assert_eq!(gnomonic[0].x, Some(Reading::sampled(spread(0.5), &[0.5])));
        // Cheaper than the clock can tell: at the least that is drawn, and not dropped.
        let least = Reading::sampled(spread(LEAST_NS), &[LEAST_NS]);
        assert_eq!(gnomonic[1].x, Some(least));
        assert_eq!(
            plot.by_operations[1].points[0].x,
            Some(Reading::exact(70.0))
        );
        let texel = plot.lines.iter().find(|line| line.label.contains("texel"));
        // 1° of 6,371 km over 4096, a quarter.
        assert!((texel.expect("drawn").y - 6.79).abs() < 0.01);
        assert!(super::plot(&data, "elsewhere", "", &FAMILIES, false).is_none());
    }

    #[test]
    fn what_is_not_finite_is_on_the_edge_and_what_is_above_its_bound_is_crossed_out() {
        let mut bad = row("gnomonic-4", "gnomonic", 4.0, 1.0);
        bad.status = Status::Wrong;
        bad.measured_over_expected = Some(3.0);
        assert_eq!(standing(&bad), Standing::Wrong);
        bad.non_finite_device = Some(3);
        assert_eq!(standing(&bad), Standing::Failed);
        bad.non_finite_device = None;
        bad.measured_over_expected = None;
        assert_eq!(standing(&bad), Standing::Failed);
        assert_eq!(standing(&row("a", "b", 1.0, 1.0)), Standing::Right);
    }

    #[test]
    fn a_missing_row_is_said() {
        let full = data();
        let keys: Vec<PrecisionKey> = full.rows.iter().map(PrecisionRow::key).collect();
        let plan = PrecisionPlan {
            grids: vec![PrecisionGrid {
                part: PrecisionPart::Coordinate,
                routes: keys.iter().map(|key| key.route.clone()).collect(),
                conditions: vec![DRAWN[1].0.to_owned()],
            }],
            rounds: 1,
        };
        let mut notes = Vec::new();
        let mut rows = full.rows;
        PrecisionData::new(Some(&plan), rows.clone(), &[], &mut notes);
        assert_eq!(notes, [""; 0]);
        rows.remove(2);
        PrecisionData::new(Some(&plan), rows.clone(), &[], &mut notes);
        assert!(notes[0].contains("1 planned rows are missing"), "{notes:?}");
        assert!(notes[0].contains("odd-7"));
        notes.clear();
        PrecisionData::new(None, rows, &[], &mut notes);
        assert!(notes[0].contains("without a plan"));
    }

    #[test]
    fn formula_and_measurement_that_part_are_listed_worst_first() {
        let mut data = data();
        data.rows[0].measured_over_expected = Some(0.1);
        data.rows[0].residual_reason = "few places".to_owned();
        data.rows[2].measured_over_expected = Some(3.0);
        data.rows[2].residual_reason = "no reason known".to_owned();
        let table = disagreement_table(&data);
        let names: Vec<&str> = table.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["odd", "gnomonic"]);
        assert!(table.rows[0].is_bad && !table.rows[1].is_bad);
    }

    #[test]
    fn a_plan_that_takes_too_coarse_a_route_is_called_out() {
        let mut data = data();
        data.rows[0].chosen = true;
        data.rows[0].rms_texels = Some(0.02);
        data.rows[0].max_texels = Some(0.06);
        let first = |data: &PrecisionData| findings(data).remove(0);
        assert_eq!(first(&data).class, "holds");
        data.rows[0].rms_texels = Some(0.3);
        assert_eq!(first(&data).class, "does-not");
        data.rows[0].rms_texels = Some(0.02);
        assert_eq!(first(&data).class, "holds");
        data.rows[0].status = Status::Wrong;
        assert_eq!(first(&data).class, "does-not", "above its bound");
        data.rows[0].status = Status::Ok;
        data.rows[0].non_finite_device = Some(1);
        assert_eq!(first(&data).class, "does-not");
    }

    fn position(anchor: &str, extent_deg: f64, distance_m: f64, error_m: f64) -> PrecisionRow {
        let pixel_m = distance_m * 1.07e-3;
        PrecisionRow {
            part: PrecisionPart::Position,
            route: DEFAULT_POSITION.0.to_owned(),
            depth_format: DEFAULT_POSITION.1.to_owned(),
            anchor: anchor.to_owned(),
            condition: format!("distance={distance_m};extent={extent_deg};anchor={anchor}"),
            extent_deg: Some(extent_deg),
            distance_m: Some(distance_m),
            status: Status::Ok,
            device_max_m: Some(error_m),
            pixel_m: Some(pixel_m),
            max_px: Some(error_m / pixel_m),
            ..PrecisionRow::default()
        }
    }

    #[test]
    fn positions_are_judged_where_a_plan_puts_the_anchor_and_the_middle_stands_beside() {
        let rows = |largest_at_20_m| {
            vec![
                position(PLAN, 1e-3, 20.0, 4e-6),
                position(PLAN, 1.0, 20.0, largest_at_20_m),
                position(PLAN, 1.0, 1e3, 2e-4),
                position(MIDDLE, 1.0, 20.0, 3.8e-3),
                position(MIDDLE, 1.0, 10.0, 4.2e-3),
            ]
        };
        let of = |largest| PrecisionData::new(None, rows(largest), &[], &mut Vec::new());
        let good = of(5e-6);
        let found = findings(&good);
        assert_eq!([found[0].class, found[1].class], ["holds", "holds"]);
        assert!(
            found[0]
                .text
                .contains("in the middle of the region: 0.00380 m"),
            "{}",
            found[0].text
        );
        assert!(
            found[1].text.contains("0.393 of a pixel"),
            "{}",
            found[1].text
        );
        let table = position_table(&good);
        let names: Vec<&str> = table.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names.len(), 2);
        assert!(!names[0].contains("middle") && names[1].ends_with("anchor=middle"));
        // The worst region stands in the table.
        assert!(
            table.rows[0].cells[0].starts_with("5.00e-6 m"),
            "{:?}",
            table.rows[0].cells
        );
        // Twin: one region that is worse than the limit is enough.
        let bad = findings(&of(2e-4));
        assert_eq!([bad[0].class, bad[1].class], ["does-not", "holds"]);
        assert_eq!(findings(&of(8e-3))[1].class, "does-not");
    }

    #[test]
    fn reasons_are_counted_and_a_row_without_one_is_called_out() {
        let mut data = data();
        for (place, ratio) in [(0, 0.9), (1, 0.3), (2, 0.2), (3, 4.0)] {
            data.rows[place].measured_over_expected = Some(ratio);
        }
        data.rows[1].residual_reason = "few places".to_owned();
        data.rows[2].residual_reason = "few places".to_owned();
        data.rows[3].residual_reason = "the device's own".to_owned();
        let table = reason_table(&data);
        let cells: Vec<_> = table
            .rows
            .iter()
            .map(|row| (row.name.as_str(), &row.cells))
            .collect();
        assert_eq!(cells[0].0, "few places");
        assert_eq!(cells[0].1[..2], ["2", "less than half"]);
        assert_eq!(cells[1].1[..2], ["1", "more than twice"]);
        let last = |data: &PrecisionData| findings(data).pop().expect("some");
        assert!(last(&data).text.contains("in 1 of 4 rows") && last(&data).class == "holds");
        data.rows[3].residual_reason = "no reason known".to_owned();
        assert_eq!(last(&data).class, "does-not");
        assert!(reason_table(&data).rows.iter().any(|row| row.is_bad));
    }

    #[test]
    fn units_in_the_last_place() {
        assert!((ulp(std::f64::consts::PI) - 2.384e-7).abs() < 1e-10);
        assert!((ulp(1.0) - f64::from(f32::EPSILON)).abs() < 1e-15);
    }
}
