// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on precision: every route from a fragment to its texture coordinate, its error against
//! its cost, and where formula and measurement differ.

use std::collections::{BTreeMap, BTreeSet};
use terrafill_plot::number::{count, significant};
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, ReferenceLine, Upwards,
    WorkPrecision, panels,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Finding, Heading, Outcome, Plot, Row,
    Run, Standing, Table, median, spread,
};

/// A formula that costs less than this much beyond the loop around it is below the timer's resolution
/// and is drawn here. Nanoseconds.
const MIN_NS: f64 = 0.01;

/// Formula and measurement agree within this factor.
const AGREEMENT: f64 = 2.0;

/// What a bound found at some thousand places may miss of a peak between them.
const BOUND_SLACK: f64 = 1.02;

/// A quarter of a texel, and of a pixel: what a plan allows on average.
const QUARTER: f64 = 0.25;

/// Largest error of a plan's route, texels.
const MAX_TEXELS: f64 = 0.5;

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

/// Errors and costs of the routes to a texture coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct PrecisionChapter;

impl Chapter for PrecisionChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Precision: from a fragment to its texture coordinate"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(clock.pick("gpu_ns", "cpu_ns"))
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let data = Data::new(run);
        if data.formulas.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(format!(
            "Every way to longitude and latitude, evaluated at places of regions from 0.001° to the \
             globe, from the equator to the pole, with terrain from −110 to 90 km: on the CPU in the \
             shader's steps, and on the device by the shader's text. Errors are against the exact map \
             in double precision. Times are of the formula alone, without the loop around it. {}",
            summary(&data)
        ))];
        blocks.extend(recommended(&data));
        blocks.push(Block::section("What was computed, and what was measured"));
        blocks.extend(findings(&data).into_iter().map(Block::Finding));
        blocks.push(Block::Remark(format!(
            "In the plots terrain reaches up to 9 km where it says nothing else; one curve per family \
             through its knob: degree, or texels of a table. Filled: largest error on the device; open: \
             root mean square. A cross: an error above its bound; on the upper edge: no finite answer, \
             or no map of that region. Ringed and dashed: the Pareto front, where 95 % of the resamples \
             of processes keep it. A formula cheaper than {} ns, below the timer's resolution, stands \
             there. cubic-cesium: the arctangent of the best-known web globe (CesiumJS, after Drobot \
             2014) with the geodetic latitude; +geocentric: with the geocentric one, as it is used \
             there, where extents are computed by the same formula, so that edges fall together and \
             pictures are distorted between them. A label has its curve's colour. Dashed lines, named at \
             the right: a quarter of a texel; half a unit in the last place of the largest answer in \
             f32; 4096 units in the last place, which WGSL and Vulkan grant atan2.",
            significant(MIN_NS)
        )));
        blocks.extend(plots(&data)?);
        blocks.extend(tables(&data));
        Ok(blocks)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let data = Data::new(run);
        if data.formulas.is_empty() {
            return Ok(Answers::default());
        }
        let compared = data
            .formulas
            .iter()
            .filter(|row| row.count("points").is_some());
        let meant = data
            .formulas
            .iter()
            .filter(|row| row.0.planned.may_be_wrong);
        Ok(Answers {
            scope: vec![format!(
                "{} of {} formulas at a place compared with the exact map in double precision; {} may be \
                 wrong: their error is the question.",
                count(compared.count() as u64),
                count(data.formulas.len() as u64),
                count(meant.count() as u64),
            )],
            blocks: recommended(&data),
            requirements: findings(&data),
        })
    }
}

/// One formula under one condition.
#[derive(Debug, Clone, Copy)]
struct Formula<'a>(&'a Case);

impl<'a> Formula<'a> {
    fn part(self) -> &'a str {
        self.0.condition("part")
    }

    fn route(self) -> &'a str {
        self.0.condition("route")
    }

    fn family(self) -> &'a str {
        self.0.condition("family")
    }

    fn condition(self) -> &'a str {
        self.0.condition("condition")
    }

    fn anchor(self) -> &'a str {
        self.0.condition("anchor")
    }

    /// A condition that is a number.
    fn number(self, condition: &str) -> Option<f64> {
        self.0.condition(condition).parse().ok()
    }

    fn figure(self, metric: &str) -> Option<f64> {
        self.0.value(metric)
    }

    fn is_chosen(self) -> bool {
        self.figure("chosen").is_some_and(|chosen| chosen > 0.5)
    }

    fn is_ok(self) -> bool {
        self.0.outcome == Outcome::Ok
    }

    /// A figure that counts something.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counts are whole, not negative and far below 2^53"
    )]
    fn count(self, metric: &str) -> Option<u64> {
        let value = self.figure(metric)?;
        (value.is_finite() && value >= 0.0).then(|| value.round() as u64)
    }

    /// Answers that are not finite, emulated or on the device.
    fn non_finite(self) -> u64 {
        let counted = |metric| self.count(metric).unwrap_or(0);
        counted("non_finite_emulated") + counted("non_finite_device")
    }
}

/// The study in a run.
struct Data<'a> {
    clock: Clock,
    /// Every formula that was verified.
    formulas: Vec<Formula<'a>>,
    /// Timed coordinate routes.
    times: BTreeMap<&'a str, &'a Case>,
}

impl<'a> Data<'a> {
    fn new(run: &'a Run) -> Self {
        let own = || run.of_study(crate::STUDY).filter(|case| !case.is_twin());
        let is_time = |case: &&Case| case.condition("part") == "time";
        let timed = own().filter(is_time);
        let timed = timed.filter(|case| case.condition("of_part") == "coordinate");
        Self {
            clock: run.clock(),
            formulas: own().filter(|case| !is_time(case)).map(Formula).collect(),
            times: timed.map(|case| (case.condition("route"), case)).collect(),
        }
    }

    fn of(&self, part: &'a str) -> impl Iterator<Item = Formula<'a>> {
        let formulas = self.formulas.iter().copied();
        formulas.filter(move |formula| formula.part() == part)
    }

    /// Time of a coordinate route, as a plot has it.
    fn time(&self, route: &str) -> Option<Reading> {
        let case = self.times.get(route).filter(|case| case.counts())?;
        let samples = case.samples(self.clock.pick("gpu_ns", "cpu_ns"))?;
        let seen = |ns: &f64| ns.max(MIN_NS);
        let all: Vec<f64> = samples
            .values()
            .flat_map(|of| of.values().map(seen))
            .collect();
        let replicates = samples.values().filter_map(|of| {
            let of: Vec<f64> = of.values().map(seen).collect();
            median(&of)
        });
        Some(Reading::sampled(
            spread(&all)?,
            &replicates.collect::<Vec<_>>(),
        ))
    }

    fn time_axis(&self) -> String {
        format!(
            "ns per fragment, {}: median, 5–95 % of samples",
            self.clock.name()
        )
    }
}

/// A table of texts.
struct Grid {
    headings: Vec<String>,
    rows: Vec<Line>,
}

/// One of its rows.
struct Line {
    name: String,
    cells: Vec<String>,
    is_bad: bool,
}

impl Grid {
    /// The table under its heading; nothing without a row.
    fn blocks(self, heading: &str, caption: &str) -> Vec<Block> {
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
fn recommended(data: &Data<'_>) -> Vec<Block> {
    chosen_table(data).blocks(
        "What a plan takes",
        "The cheapest route whose computed residual is within ¼ texel and ¼ pixel RMS and ½ texel at \
         most, for terrain up to 9 km, with its measured RMS error in texels. Columns: extent. The \
         picture has 4096 texels a side, from 90° on 16,384; the view shows the region on 1,080 rows. \
         A dash: a region that is another one's already.",
    )
}

/// The other tables of the study.
fn tables(data: &Data<'_>) -> Vec<Block> {
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

fn summary(data: &Data<'_>) -> String {
    let of = |status| {
        data.formulas
            .iter()
            .copied()
            .filter(|row| row.0.outcome == status)
            .count()
    };
    let points = data.formulas.iter().filter_map(|row| row.count("points"));
    let points: u64 = points.sum();
    let routes: BTreeSet<&str> = data.of("coordinate").map(|row| row.route()).collect();
    format!(
        "{} rows of {} places in all, {} coordinate routes: {} within their bound, {} not finite, above \
         their bound or without one, {} not measured.",
        count(data.formulas.len() as u64),
        count(points),
        routes.len(),
        of(Outcome::Ok),
        of(Outcome::Wrong),
        of(Outcome::Skipped) + of(Outcome::Failed),
    )
}

/// What was computed before the measurement, and whether it came out so.
fn finding(holds: bool, text: String) -> Finding {
    Finding {
        claim: text,
        standing: Standing::holds_if(holds),
        because: String::new(),
    }
}

fn largest<'a>(
    rows: impl Iterator<Item = Formula<'a>>,
    metric: &str,
) -> Option<(f64, Formula<'a>)> {
    rows.filter_map(|row| Some((row.figure(metric)?, row)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

fn findings(data: &Data<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let chosen = || data.formulas.iter().copied().filter(|row| row.is_chosen());
    let non_finite: u64 = chosen().map(Formula::non_finite).sum();
    let contradicted = chosen().filter(|row| !row.is_ok()).count();
    let places: BTreeSet<&str> = data.of("coordinate").map(|row| row.condition()).collect();
    let rms = largest(chosen(), "rms_texels");
    let max = largest(chosen(), "max_texels");
    if let (Some((rms, rms_at)), Some((max, max_at))) = (rms, max) {
        let unchosen = places.len() - chosen().count();
        let within = rms <= QUARTER && max <= MAX_TEXELS;
        let holds = within && non_finite + (contradicted + unchosen) as u64 == 0;
        findings.push(finding(
            holds,
            format!(
                "Routes that a plan takes, on the device: at most {} texel RMS ({} at {}) and {} texel \
                 ({} at {}); {non_finite} answers not finite; {contradicted} contradicted by \
                 measurement; {unchosen} of {} regions without such a route.",
                significant(rms),
                rms_at.route(),
                rms_at.condition(),
                significant(max),
                max_at.route(),
                max_at.condition(),
                places.len(),
            ),
        ));
    }
    let default = || {
        data.of("position")
            .filter(|row| (row.route(), row.0.condition("depth_format")) == DEFAULT_POSITION)
    };
    let anchored = |anchor: &'static str| default().filter(move |row| row.anchor() == anchor);
    let at_20_m = |anchor| {
        let near = anchored(anchor).filter(|row| row.number("distance_m") == Some(DEFAULT_LIMIT.0));
        largest(near, "device_max_m")
    };
    let beside = |middle: Option<(f64, Formula<'_>)>, unit: &str| {
        middle.map_or_else(String::new, |(most, row)| {
            let most = significant(most);
            format!(
                " Anchored in the middle of the region: {most} {unit} ({}).",
                row.condition()
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
                row.condition(),
                beside(at_20_m(MIDDLE), "m"),
            ),
        ));
    }
    if let Some((pixels, row)) = largest(anchored(PLAN), "max_px") {
        let middle = largest(anchored(MIDDLE), "max_px");
        findings.push(finding(
            pixels <= QUARTER,
            format!(
                "The same from 10 m to 30,000 km, over every extent and latitude: at most {} of a pixel \
                 ({}).{}",
                significant(pixels),
                row.condition(),
                beside(middle, "of a pixel"),
            ),
        ));
    }
    // Where a route is no map at all there is nothing to bound.
    let measured = || {
        data.formulas
            .iter()
            .copied()
            .filter(|row| row.figure("measured_over_expected").is_some())
    };
    let is_above = |row: &Formula<'_>| {
        row.figure("max_over_residual")
            .is_some_and(|r| r > BOUND_SLACK)
    };
    let above = measured().filter(is_above).count();
    if let Some((ratio, row)) = largest(measured(), "max_over_residual") {
        findings.push(finding(
            above == 0,
            format!(
                "Largest measured error over its bound: {} ({}, {}); {above} of {} rows are above it by \
                 more than the 2 % that sampling may miss of a peak.",
                significant(ratio),
                row.route(),
                row.condition(),
                count(measured().count() as u64),
            ),
        ));
    }
    let agreeing =
        measured().filter(|row| row.figure("measured_over_expected").is_some_and(agrees));
    let unexplained = measured()
        .filter(|row| row.0.note("residual_reason").contains(NO_REASON))
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
fn chosen_table(data: &Data<'_>) -> Grid {
    let formulas = data.formulas.iter().copied();
    let rows: Vec<Formula<'_>> = formulas
        .filter(|row| row.is_chosen() && row.number("highest_m") == Some(9_000.0))
        .collect();
    let distinct = |of: &str| {
        let mut values: Vec<f64> = rows.iter().filter_map(|row| row.number(of)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let extents = distinct("extent_deg");
    let latitudes = distinct("latitude_deg");
    let cell = |latitude: f64, extent: f64| {
        let here = |row: &&Formula<'_>| {
            row.number("latitude_deg") == Some(latitude) && row.number("extent_deg") == Some(extent)
        };
        let row = rows.iter().find(here)?;
        let texels = row
            .figure("rms_texels")
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
    match (metres, row.figure("pixel_m")) {
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
fn position_table(data: &Data<'_>) -> Grid {
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
                && row.0.condition("depth_format") == depth
                && row.anchor() == anchor
                && row.number("distance_m") == Some(distance)
        });
        // What is not finite has no largest error and is worse than any.
        here.max_by(|a, b| {
            let worth =
                |row: Formula<'_>| (row.non_finite(), row.figure("device_max_m").unwrap_or(-1.0));
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
            .map(|row| metres_and_pixels(*row, row.and_then(|row| row.figure("device_max_m"))))
            .collect(),
        is_bad: found
            .iter()
            .flatten()
            .any(|row| row.non_finite() > 0 || row.figure("max_px").is_some_and(|px| px > QUARTER)),
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
                    && row.number("distance_m") == Some(distance)
                    && row.number("extent_deg") == Some(1.0)
            })
        };
        let found = DISTANCES.map(|(distance, _)| at(distance));
        Line {
            name: format.to_owned(),
            cells: found
                .iter()
                .map(|row| {
                    metres_and_pixels(*row, row.and_then(|row| row.figure("emulated_max_m")))
                })
                .collect(),
            is_bad: found
                .iter()
                .flatten()
                .any(|row| row.figure("max_px").is_some_and(|px| px > QUARTER)),
        }
    });
    Grid {
        headings: headings("format"),
        rows: rows.collect(),
    }
}

/// Why formula and measurement differ by more than twice, the most frequent reason first.
fn reason_table(data: &Data<'_>) -> Grid {
    let mut groups: BTreeMap<(&str, bool), Vec<Formula<'_>>> = BTreeMap::new();
    for &row in &data.formulas {
        if let Some(ratio) = row
            .figure("measured_over_expected")
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
fn disagreement_table(data: &Data<'_>) -> Grid {
    let mut groups: BTreeMap<(&str, &str), Vec<Formula<'_>>> = BTreeMap::new();
    for &row in &data.formulas {
        if row
            .figure("measured_over_expected")
            .is_some_and(|ratio| !agrees(ratio))
        {
            let group = (row.0.note("residual_reason"), row.family());
            groups.entry(group).or_default().push(row);
        }
    }
    let rows = groups.into_iter().filter_map(|((reason, family), rows)| {
        let ratios = || {
            rows.iter()
                .filter_map(|row| Some((row.figure("measured_over_expected")?, row)))
        };
        let (least, at) = ratios().min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (most, _) = ratios().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let rms_agrees = rows
            .iter()
            .filter(|row| row.figure("rms_over_residual").is_some_and(agrees))
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
        let non_finite = |of: &str| {
            rows.iter()
                .filter(|row| row.count(of).is_some_and(|n| n > 0))
                .count()
        };
        let emulated = non_finite("non_finite_emulated");
        let device = non_finite("non_finite_device");
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
        .filter(|row| row.number("distance_m").is_none())
        .collect();
    let count = |of: &str| {
        let found = rows
            .iter()
            .filter(|row| row.count(of).is_some_and(|n| n > 0));
        format!("{} of {}", found.count(), rows.len())
    };
    (!rows.is_empty()).then(|| Line {
        name: "cleared depth (position routes × depth formats)".to_owned(),
        cells: vec![
            count("non_finite_emulated"),
            count("non_finite_device"),
            "–".to_owned(),
            String::new(),
        ],
        is_bad: false,
    })
}

/// The plots: one for each region that is drawn and has rows, then every way to write the arctangent.
fn plots(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let drawn = DRAWN
        .iter()
        .map(|(condition, name)| (*condition, *name, &FAMILIES));
    let name = "Every way to write the arctangent, on the globe";
    let drawn: Vec<_> = drawn
        .chain([(POLYNOMIALS_AT, name, &POLYNOMIALS)])
        .collect();
    let rows_of = |condition: &str, families: &[&str]| -> Vec<Formula<'_>> {
        let own = data
            .of("coordinate")
            .filter(|row| row.condition() == condition);
        own.filter(|row| families.contains(&row.family())).collect()
    };
    let mut names: Vec<String> = drawn
        .iter()
        .flat_map(|(condition, _, families)| rows_of(condition, *families))
        .map(|row| row.family().to_owned())
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
    rows: &[Formula<'_>],
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
        lines: reference_lines(*first),
    };
    let time = |row: Formula<'_>| data.time(row.route());
    let operations = |row: Formula<'_>| row.figure("operations_cost").map(Reading::exact);
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
fn curves(rows: &[Formula<'_>], cost: impl Fn(Formula<'_>) -> Option<Reading>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for &row in rows {
        let point = Point {
            knob: row.number("knob").unwrap_or_default(),
            label: row.0.condition("knob").to_owned(),
            x: cost(row),
            y: row.figure("device_max_m").map(Reading::exact),
            y_rms: row.figure("device_rms_m"),
            standing: standing(row),
            command: String::new(),
        };
        match curves.iter_mut().find(|curve| curve.name == row.family()) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name: row.family().to_owned(),
                points: vec![point],
            }),
        }
    }
    curves
}

/// An answer that is not finite has no place, nor has a route that is no map of the region; an error
/// above its bound has, and counts for nothing.
fn standing(row: Formula<'_>) -> PointStanding {
    match row.0.outcome {
        Outcome::Ok => PointStanding::Right,
        Outcome::Wrong
            if row.non_finite() == 0 && row.figure("measured_over_expected").is_some() =>
        {
            PointStanding::Wrong
        }
        _ => PointStanding::Failed,
    }
}

/// A quarter of a texel, the last place of an answer, and what the specification allows.
fn reference_lines(row: Formula<'_>) -> Vec<ReferenceLine> {
    let line = |label: &str, y: f64| ReferenceLine {
        label: label.to_owned(),
        from_x: None,
        y,
        power: 0.0,
    };
    let (Some(extent_deg), Some(latitude_deg)) =
        (row.number("extent_deg"), row.number("latitude_deg"))
    else {
        return Vec::new();
    };
    let height_rad = extent_deg.min(180.0).to_radians();
    let mut lines = Vec::new();
    if let Some(texels) = row.figure("texture_px") {
        let texel_m = height_rad * EARTH_M / texels;
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
    use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
    use terrafill_results::{CellClass, Status};

    /// A coordinate route in the region of 1°.
    fn route<'a>(
        run: &'a mut MadeUpRun,
        family: &str,
        knob: &str,
        error_m: f64,
    ) -> &'a mut MadeUpCase {
        let (route, condition) = (format!("{family}-{knob}"), DRAWN[1].0);
        let conditions = [
            ("part", "coordinate"),
            ("route", &route),
            ("family", family),
            ("knob", knob),
            ("condition", condition),
            ("extent_deg", "1"),
            ("latitude_deg", "45"),
            ("highest_m", "9000"),
        ];
        let name = format!("coordinate/{route}/{condition}");
        run.case(case_id(crate::STUDY, &name, &conditions))
            .figure("points", 100.0)
            .figure("device_max_m", error_m)
            .figure("device_rms_m", 0.4 * error_m)
            .figure("max_over_residual", 0.8)
            .figure("measured_over_expected", 0.9)
            .figure("texture_px", 4096.0)
            .figure("rms_texels", 0.02)
            .figure("max_texels", 0.06)
            .figure("operations_cost", 12.0)
    }

    fn time(run: &mut MadeUpRun, route: &str, ns: f64) {
        let conditions = [
            ("part", "time"),
            ("of_part", "coordinate"),
            ("route", route),
        ];
        let name = format!("time/coordinate/{route}");
        run.case(case_id(crate::STUDY, &name, &conditions))
            .timed("cpu_ns", &[ns, ns, ns]);
    }

    /// Three routes, the first of which a plan takes.
    fn routes() -> MadeUpRun {
        let mut run = MadeUpRun::default();
        route(&mut run, "gnomonic", "3", 0.3).figure("chosen", 1.0);
        route(&mut run, "gnomonic", "2", 4.0);
        route(&mut run, "odd", "7", 500.0);
        time(&mut run, "gnomonic-3", 0.5);
        time(&mut run, "gnomonic-2", -0.1);
        run
    }

    fn position(run: &mut MadeUpRun, anchor: &str, distance_m: f64, error_m: f64) {
        let (distance, pixel_m) = (distance_m.to_string(), distance_m * 1.07e-3);
        let condition = format!("distance={distance};anchor={anchor};error={error_m}");
        let conditions = [
            ("part", "position"),
            ("route", DEFAULT_POSITION.0),
            ("depth_format", DEFAULT_POSITION.1),
            ("anchor", anchor),
            ("condition", condition.as_str()),
            ("distance_m", distance.as_str()),
        ];
        run.case(case_id(
            crate::STUDY,
            &format!("position/{condition}"),
            &conditions,
        ))
        .figure("device_max_m", error_m)
        .figure("pixel_m", pixel_m)
        .figure("max_px", error_m / pixel_m);
    }

    fn with<T>(run: &MadeUpRun, read: impl FnOnce(&Data<'_>) -> T) -> T {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        read(&Data::new(&run))
    }

    fn blocks(run: &MadeUpRun) -> Vec<Block> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        PrecisionChapter.blocks(&run).expect("a chapter")
    }

    #[test]
    fn each_family_is_a_curve_with_its_time_and_its_errors() {
        let blocks = blocks(&routes());
        let plot = blocks.iter().find_map(|block| match block {
            Block::Plot(plot) => Some(plot),
            _ => None,
        });
        let svg = &plot.expect("a plot").svg;
        for word in [
            "gnomonic",
            "odd",
            "¼ texel",
            "Error against operations",
            "process CPU time",
        ] {
            assert!(svg.contains(word), "{word}");
        }
        with(&routes(), |data| {
            assert!(data.time("gnomonic-3").is_some());
            assert!(data.time("odd-7").is_none(), "not timed");
            let below = data.time("gnomonic-2");
            assert!(
                below.is_some(),
                "below the timer's resolution, and drawn there"
            );
        });
        let table = blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        let cells = &table.expect("what a plan takes").rows[0].cells;
        assert_eq!(cells[1].text, "gnomonic-3 · 0.0200");
    }

    #[test]
    fn a_plan_that_takes_too_coarse_a_route_is_called_out() {
        let standing = |change: &dyn Fn(&mut MadeUpCase)| {
            let mut run = routes();
            change(&mut run.cases[0]);
            with(&run, |data| findings(data).remove(0).standing)
        };
        assert_eq!(standing(&|_| ()), Standing::Holds);
        let coarse = |case: &mut MadeUpCase| {
            case.figure("rms_texels", 0.3);
        };
        let above_its_bound = |case: &mut MadeUpCase| {
            case.ended(Status::Wrong, "above its bound");
        };
        let not_finite = |case: &mut MadeUpCase| {
            case.figure("non_finite_device", 1.0);
        };
        let changes: [&dyn Fn(&mut MadeUpCase); 3] = [&coarse, &above_its_bound, &not_finite];
        for change in changes {
            assert_eq!(standing(change), Standing::DoesNotHold);
        }
    }

    #[test]
    fn positions_count_where_a_plan_puts_the_anchor_and_the_middle_stands_beside() {
        let found = |largest_at_20_m: f64| {
            let mut run = MadeUpRun::default();
            position(&mut run, PLAN, 20.0, 4e-6);
            position(&mut run, PLAN, 20.0, largest_at_20_m);
            position(&mut run, PLAN, 1e3, 2e-4);
            position(&mut run, MIDDLE, 20.0, 3.8e-3);
            position(&mut run, MIDDLE, 10.0, 4.2e-3);
            with(&run, |data| (findings(data), position_table(data)))
        };
        let (good, table) = found(5e-6);
        assert_eq!([good[0].standing, good[1].standing], [Standing::Holds; 2]);
        assert!(
            good[0]
                .claim
                .contains("in the middle of the region: 0.00380 m")
        );
        assert!(
            good[1].claim.contains("0.393 of a pixel"),
            "{}",
            good[1].claim
        );
        assert_eq!(table.rows.len(), 2);
        assert!(table.rows[1].name.ends_with("anchor=middle"));
        assert!(
            table.rows[0].cells[0].starts_with("5.00e-6 m"),
            "the worst region"
        );
        // Twin: one region that is worse than the limit is enough.
        let bad = found(2e-4).0;
        assert_eq!(
            [bad[0].standing, bad[1].standing],
            [Standing::DoesNotHold, Standing::Holds]
        );
        assert_eq!(found(8e-3).0[1].standing, Standing::DoesNotHold);
    }

    #[test]
    fn reasons_are_counted_and_a_row_without_one_is_called_out() {
        let mut run = routes();
        route(&mut run, "odd", "9", 300.0);
        for (case, ratio, reason) in [
            (1, 0.3, "few places"),
            (2, 0.2, "few places"),
            (5, 4.0, "the device's own"),
        ] {
            run.cases[case]
                .figure("measured_over_expected", ratio)
                .note("residual_reason", reason);
        }
        let found = |run: &MadeUpRun| {
            with(run, |data| {
                let last = findings(data).pop().expect("some");
                (reason_table(data), disagreement_table(data), last)
            })
        };
        let (reasons, families, last) = found(&run);
        assert_eq!(reasons.rows[0].cells[..2], ["2", "less than half"]);
        assert_eq!(reasons.rows[1].cells[..2], ["1", "more than twice"]);
        assert_eq!(families.rows.len(), 3);
        assert!(last.claim.contains("in 1 of 4 rows") && last.standing == Standing::Holds);
        run.cases[5].note("residual_reason", "no reason known");
        let (reasons, families, last) = found(&run);
        assert_eq!(last.standing, Standing::DoesNotHold);
        assert!(reasons.rows.iter().any(|row| row.is_bad) && families.rows[0].is_bad);
    }

    #[test]
    fn what_is_bad_is_red_and_a_run_without_the_study_has_no_chapter() {
        let line = |is_bad| Line {
            name: "a".to_owned(),
            cells: vec!["1".to_owned(), "–".to_owned()],
            is_bad,
        };
        let grid = Grid {
            headings: Vec::new(),
            rows: vec![line(true), line(false)],
        };
        let blocks_of_grid = grid.blocks("h", "");
        let Some(Block::Table(table)) = blocks_of_grid.last() else {
            panic!("a table");
        };
        let classes = |row: usize| table.rows[row].cells.iter().map(|cell| cell.class);
        assert!(classes(0).eq([CellClass::Name, CellClass::Bad, CellClass::Absent]));
        assert!(classes(1).eq([CellClass::Name, CellClass::Plain, CellClass::Absent]));
        assert_eq!(blocks(&MadeUpRun::default()), []);
    }

    #[test]
    fn units_in_the_last_place() {
        assert!((ulp(std::f64::consts::PI) - 2.384e-7).abs() < 1e-10);
        assert!((ulp(1.0) - f64::from(f32::EPSILON)).abs() < 1e-15);
    }
}
