// SPDX-License-Identifier: MIT OR Apache-2.0
//! A raster of heights.
//!
//! Samples are heights at points, in rows from north to south, each from west to east. Between four of
//! them the height is bilinear in the raster's own axes: degrees, or metres of Web Mercator (EPSG:3857,
//! a sphere of the radius 6,378,137 m, fed with geodetic latitudes).

use crate::error::Complaints;
use crate::pyramid::{Heights, Pyramid};
use crate::{ElevationError, voids};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use terrafill_core::Extent;

/// Most samples of a field: 256 MiB in memory, and four times a tile of 1 arc-second.
pub const MAX_SAMPLES: u64 = 1 << 26;
/// Highest or deepest sample, metres: four times the highest mountain of the Solar System.
pub const MAX_HEIGHT_M: f64 = 100_000.0;
/// Radius of EPSG:3857's sphere, metres.
const MERCATOR_RADIUS_M: f64 = 6_378_137.0;
/// A place this far outside the outermost samples, in samples, still counts as on the rim: corners of
/// tiles are written with eight decimals or so.
const RIM: f64 = 1e-6;

/// Smallest step of samples as a share of a parallel: 4.7 mm on the Earth. Places so close differ in the last bits of
/// their coordinates alone, and below that samples have no places of their own.
const LEAST_STEP: f64 = 1.0 / (1_u64 << 33) as f64;

/// Axes of a raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// Degrees of longitude and geodetic latitude.
    Geographic,
    /// EPSG:3857, metres.
    WebMercator,
}

impl Projection {
    /// Where a place lies.
    #[must_use]
    pub fn project(self, longitude_deg: f64, latitude_deg: f64) -> [f64; 2] {
        match self {
            Self::Geographic => [longitude_deg, latitude_deg],
            Self::WebMercator => [
                longitude_deg.to_radians() * MERCATOR_RADIUS_M,
                latitude_deg.to_radians().sin().atanh() * MERCATOR_RADIUS_M,
            ],
        }
    }

    /// Longitude and latitude of a place.
    #[must_use]
    pub fn unproject(self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Geographic => [x, y],
            Self::WebMercator => [
                (x / MERCATOR_RADIUS_M).to_degrees(),
                (y / MERCATOR_RADIUS_M).tanh().asin().to_degrees(),
            ],
        }
    }

    /// Length of a parallel.
    fn turn(self) -> f64 {
        match self {
            Self::Geographic => 360.0,
            Self::WebMercator => 2.0 * PI * MERCATOR_RADIUS_M,
        }
    }
}

/// What a sample stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registration {
    /// The point itself: a field ends at its outermost samples.
    Point,
    /// A cell around it: a field ends half a cell beyond them, and is level there.
    Area,
}

/// Where samples lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Axes.
    pub projection: Projection,
    /// What a sample stands for.
    pub registration: Registration,
    /// Samples a row.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
    /// Place of the first sample: the western, northern one.
    pub first: [f64; 2],
    /// Steps to the east and to the south, both above 0.
    pub step: [f64; 2],
}

impl Grid {
    /// How far beyond the outermost samples the field goes, in samples.
    fn beyond(&self) -> f64 {
        match self.registration {
            Registration::Point => 0.0,
            Registration::Area => 0.5,
        }
    }

    /// Whether the last column's eastern neighbour is the first column.
    fn is_round(&self) -> bool {
        let all = f64::from(self.columns) * self.step[0];
        (all - self.projection.turn()).abs() < RIM * self.step[0]
    }

    fn bounds_beyond(&self, samples: f64) -> Bounds {
        let last = [self.columns, self.rows].map(|count| f64::from(count) - 1.0 + samples);
        Bounds {
            west: self.first[0] - samples * self.step[0],
            south: self.first[1] - last[1] * self.step[1],
            east: self.first[0] + last[0] * self.step[0],
            north: self.first[1] + samples * self.step[1],
        }
    }
}

/// A rectangle in a raster's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Western edge.
    pub west: f64,
    /// Southern edge.
    pub south: f64,
    /// Eastern edge, above the western one.
    pub east: f64,
    /// Northern edge.
    pub north: f64,
}

/// Heights over a rectangle.
#[derive(Debug, Clone)]
pub struct HeightField {
    name: String,
    grid: Grid,
    samples: Vec<f32>,
    pyramid: Pyramid,
    void_samples: u64,
    warnings: Vec<String>,
}

impl HeightField {
    /// - `name`: of the file, for messages
    /// - `samples`: metres, rows from the north; NaN is a void, which is filled from its neighbours
    ///
    /// # Errors
    /// [`ElevationError::Value`] for a grid that lies nowhere on a planet, samples that are not as many as
    /// the grid says, one beyond [`MAX_HEIGHT_M`], or nothing but voids.
    pub fn new(name: &str, grid: Grid, mut samples: Vec<f32>) -> Result<Self, ElevationError> {
        let complaints = Complaints { file: name };
        check_grid(complaints, &grid)?;
        let allowed = u64::from(grid.columns) * u64::from(grid.rows);
        if samples.len() as u64 != allowed {
            let (columns, rows) = (grid.columns, grid.rows);
            let allowed = format!("{allowed}, {columns} columns of {rows} rows");
            return Err(complaints.value("samples", samples.len(), allowed));
        }
        let (columns, rows) = (grid.columns as usize, grid.rows as usize);
        let is_wrong = |sample: &f32| f64::from(sample.abs()) > MAX_HEIGHT_M;
        if let Some(index) = samples.iter().position(is_wrong) {
            return Err(complaints.value(
                format!(
                    "sample in column {}, row {}",
                    index % columns,
                    index / columns
                ),
                samples[index],
                format!("-{MAX_HEIGHT_M} to {MAX_HEIGHT_M} m"),
            ));
        }
        let Some(void_samples) = voids::fill(&mut samples, columns, rows) else {
            let found = format!("{allowed} voids");
            return Err(complaints.value("samples", found, "at least one height"));
        };
        Ok(Self {
            name: name.to_owned(),
            pyramid: Pyramid::new(&samples, columns, rows),
            grid,
            samples,
            void_samples,
            warnings: Vec::new(),
        })
    }

    /// The same field with what a reader has to say of its file.
    pub(crate) fn with_warnings(mut self, texts: Vec<String>) -> Self {
        let name = &self.name;
        let named = texts.into_iter().map(|text| format!("{name}: {text}"));
        self.warnings.extend(named);
        self
    }

    /// The same field with a warning where heights lie outside `allowed`, metres: it names the place of the one that
    /// is farthest outside.
    #[must_use]
    pub fn expected_within(self, allowed: RangeInclusive<f64>) -> Self {
        let (low, high) = (*allowed.start(), *allowed.end());
        let outside_m = |height_m: f64| (low - height_m).max(height_m - high);
        let all = self.heights();
        if outside_m(all.lowest_m).max(outside_m(all.highest_m)) <= 0.0 {
            return self;
        }
        let outside = self.samples.iter().copied().map(f64::from).map(outside_m);
        let count = outside.clone().filter(|far| *far > 0.0).count();
        let farthest = outside.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let at = farthest.map_or(0, |(at, _)| at);
        let columns = self.grid.columns as usize;
        let steps = [at % columns, at / columns].map(|steps| steps as f64);
        let [longitude_deg, latitude_deg] = self.grid.projection.unproject([
            self.grid.first[0] + steps[0] * self.grid.step[0],
            self.grid.first[1] - steps[1] * self.grid.step[1],
        ]);
        let text = format!(
            "{count} of {} heights are outside {low} to {high} m, which nothing on this body is: {} m at longitude \
             {longitude_deg:.5}, latitude {latitude_deg:.5}; are they voids that the file does not say, or another \
             unit?",
            self.samples.len(),
            self.samples[at],
        );
        self.with_warnings(vec![text])
    }

    /// What has to be said of the file, each with its name: what was read otherwise than it says, or may be wrong.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Name of the file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where samples lie.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Samples that the file had no height for.
    #[must_use]
    pub fn void_samples(&self) -> u64 {
        self.void_samples
    }

    /// Of all samples, filled voids included.
    #[must_use]
    pub fn heights(&self) -> Heights {
        self.pyramid.all()
    }

    /// Bytes in memory, samples and bounds.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        // The finest of the bounds are two numbers for 64 samples, all of them a third more.
        self.samples.len() as u64 * 4 * 33 / 32
    }

    /// The rectangle that the field covers.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.grid.bounds_beyond(self.grid.beyond())
    }

    /// The same in degrees, west to east; a field that goes round is −180 … 180.
    #[must_use]
    pub fn extent(&self) -> Extent {
        let bounds = self.bounds();
        let projection = self.grid.projection;
        let [west_deg, south_deg] = projection.unproject([bounds.west, bounds.south]);
        let [east_deg, north_deg] = projection.unproject([bounds.east, bounds.north]);
        let wrap = |degrees: f64| match degrees {
            d if d > 180.0 => d - 360.0,
            d if d < -180.0 => d + 360.0,
            d => d,
        };
        let is_round = east_deg - west_deg > 360.0 - 1e-9;
        Extent {
            west_deg: if is_round { -180.0 } else { wrap(west_deg) },
            south_deg,
            east_deg: if is_round { 180.0 } else { wrap(east_deg) },
            north_deg,
        }
    }

    /// Smallest distance of two samples, degrees of latitude or longitude.
    #[must_use]
    pub fn spacing_deg(&self) -> f64 {
        let step = self.grid.step[0].min(self.grid.step[1]);
        step * 360.0 / self.grid.projection.turn()
    }

    /// Bilinear height, metres; `None` outside.
    #[must_use]
    pub fn height_m(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        let place = self.grid.projection.project(longitude_deg, latitude_deg);
        let [column, row] = self.place_in_samples(place)?;
        // Level beyond the outermost samples.
        let row = row.clamp(0.0, f64::from(self.grid.rows) - 1.0);
        let column = if self.grid.is_round() {
            column
        } else {
            column.clamp(0.0, f64::from(self.grid.columns) - 1.0)
        };
        let (left, right, along) = self.between(column, self.grid.columns, self.grid.is_round());
        let (above, below, down) = self.between(row, self.grid.rows, false);
        let columns = self.grid.columns as usize;
        let at = |x: usize, y: usize| f64::from(self.samples[y * columns + x]);
        let top = at(left, above) * (1.0 - along) + at(right, above) * along;
        let bottom = at(left, below) * (1.0 - along) + at(right, below) * along;
        Some(top * (1.0 - down) + bottom * down)
    }

    /// Distance to the nearest edge of the field as a share of its shorter side, 0 at the edge; `None`
    /// outside. An edge that is none, such as ±180° of a whole globe or a pole, does not count.
    #[must_use]
    pub fn share_from_edge(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        let place = self.grid.projection.project(longitude_deg, latitude_deg);
        let [column, row] = self.place_in_samples(place)?;
        let beyond = self.grid.beyond();
        let sides = [self.grid.columns, self.grid.rows].map(|n| f64::from(n) - 1.0 + 2.0 * beyond);
        let bounds = self.bounds();
        let far = f64::INFINITY;
        let is_geographic = self.grid.projection == Projection::Geographic;
        let reaches = |y: f64, pole: f64| is_geographic && (y - pole).abs() < self.grid.step[1];
        let is_round =
            bounds.east - bounds.west > self.grid.projection.turn() - 2.0 * self.grid.step[0];
        let from = |at: f64, side: f64| [at + beyond, side - beyond - at];
        let [west, east] = if is_round {
            [far; 2]
        } else {
            from(column, sides[0])
        };
        let [mut north, mut south] = from(row, sides[1]);
        if reaches(bounds.north, 90.0) {
            north = far;
        }
        if reaches(bounds.south, -90.0) {
            south = far;
        }
        let nearest = west.min(east).min(north).min(south).max(0.0);
        Some(nearest / sides[0].min(sides[1]).max(1.0))
    }

    /// Bounds of every bilinear value over `extent`, or `None` where the field has none.
    #[must_use]
    pub fn range(&self, extent: &Extent) -> Option<Heights> {
        let projection = self.grid.projection;
        let [west, south] = projection.project(extent.west_deg, extent.south_deg.max(-89.999_999));
        let [mut east, north] =
            projection.project(extent.east_deg, extent.north_deg.min(89.999_999));
        let turn = projection.turn();
        if east < west {
            east += turn;
        }
        let beyond = self.grid.beyond() + RIM;
        let row = |y: f64| (self.grid.first[1] - y) / self.grid.step[1];
        let (mut top, mut bottom) = (row(north), row(south));
        if projection == Projection::Geographic {
            // The latitudes above were cut for Mercator's sake.
            top = row(extent.north_deg);
            bottom = row(extent.south_deg);
        }
        let rows = samples_between(top, bottom, self.grid.rows, beyond)?;
        // A round field is one cell wider: its last cell ends at the first column.
        let is_round = self.grid.is_round();
        let mut found: Option<Heights> = None;
        for turns in -2..=2 {
            let column =
                |x: f64| (x + f64::from(turns) * turn - self.grid.first[0]) / self.grid.step[0];
            let wide = self.grid.columns + u32::from(is_round);
            let rim = if is_round { RIM } else { beyond };
            let Some([first, last]) = samples_between(column(west), column(east), wide, rim) else {
                continue;
            };
            let columns = self.grid.columns as usize;
            let mut add = |first: usize, last: usize| {
                let (low, high) = ([first, rows[0]], [last, rows[1]]);
                let range = self.pyramid.range(&self.samples, columns, low, high);
                found = Some(found.map_or(range, |found| found.union(range)));
            };
            if last >= columns {
                add(0, 0);
            }
            add(first.min(columns - 1), last.min(columns - 1));
        }
        found
    }

    /// Fields of one grid that adjoin, as one: four tiles of a map, two degrees of a survey. Where two
    /// have the same sample, the later one's is kept.
    ///
    /// - returns: `None` unless all have the same axes and steps, lie on one lattice and fill a rectangle
    #[must_use]
    pub fn joined(fields: &[Self]) -> Option<Self> {
        let first = fields.first()?;
        let step = first.grid.step;
        let mut places = Vec::new();
        for field in fields {
            let grid = &field.grid;
            let is_same = grid.projection == first.grid.projection
                && grid.registration == first.grid.registration
                && (0..2).all(|axis| (grid.step[axis] / step[axis] - 1.0).abs() < RIM);
            let column = (grid.first[0] - first.grid.first[0]) / step[0];
            let row = (first.grid.first[1] - grid.first[1]) / step[1];
            // A survey's corner is exact, a map's is off by the rounding of its address.
            let is_whole = |at: f64| (at - at.round()).abs() < 0.01 && at.abs() < 1e6;
            if !(is_same && is_whole(column) && is_whole(row)) {
                return None;
            }
            #[allow(clippy::cast_possible_truncation, reason = "whole and below a million")]
            let place = [column.round() as i64, row.round() as i64];
            let size = [i64::from(grid.columns), i64::from(grid.rows)];
            places.push((place, size));
        }
        let low = [0, 1].map(|axis| places.iter().map(|(at, _)| at[axis]).min().unwrap_or(0));
        let high = [0, 1].map(|axis| {
            let ends = places.iter().map(|(at, size)| at[axis] + size[axis]);
            ends.max().unwrap_or(0)
        });
        let size = [0, 1].map(|axis| usize::try_from(high[axis] - low[axis]).ok());
        let [Some(columns), Some(rows)] = size else {
            return None;
        };
        let own: u64 = fields.iter().map(|field| field.samples.len() as u64).sum();
        let all = columns as u64 * rows as u64;
        if all > own || all > MAX_SAMPLES {
            return None;
        }
        let mut samples = vec![f32::NAN; columns * rows];
        for (field, (at, _)) in fields.iter().zip(&places) {
            let left = usize::try_from(at[0] - low[0]).ok()?;
            let top = usize::try_from(at[1] - low[1]).ok()?;
            let width = field.grid.columns as usize;
            for (row, line) in field.samples.chunks_exact(width).enumerate() {
                let start = (top + row) * columns + left;
                samples[start..start + width].copy_from_slice(line);
            }
        }
        if samples.iter().any(|sample| sample.is_nan()) {
            return None;
        }
        let names: Vec<&str> = fields.iter().map(Self::name).collect();
        let grid = Grid {
            columns: u32::try_from(columns).ok()?,
            rows: u32::try_from(rows).ok()?,
            first: [
                first.grid.first[0] + low[0] as f64 * step[0],
                first.grid.first[1] - low[1] as f64 * step[1],
            ],
            ..first.grid
        };
        let mut joined = Self::new(&names.join(" + "), grid, samples).ok()?;
        joined.void_samples = fields.iter().map(Self::void_samples).sum();
        let warnings = fields.iter().flat_map(Self::warnings);
        joined.warnings = warnings.cloned().collect();
        Some(joined)
    }

    /// Column and row, fractional, of a place in the field's axes; up to half a sample beyond the outermost
    /// ones where samples stand for areas.
    fn place_in_samples(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let grid = &self.grid;
        let (turn, beyond) = (grid.projection.turn(), grid.beyond() + RIM);
        let (columns, rows) = (f64::from(grid.columns), f64::from(grid.rows));
        let row = (grid.first[1] - y) / grid.step[1];
        if !(row >= -beyond && row <= rows - 1.0 + beyond) {
            return None;
        }
        let mut east = x - grid.first[0];
        let west_rim = -beyond * grid.step[0];
        if !east.is_finite() {
            return None;
        }
        if east.abs() > 4.0 * turn {
            east = east.rem_euclid(turn);
        }
        // A turn at a time keeps the bits of places within the field.
        while east < west_rim {
            east += turn;
        }
        while east >= turn + west_rim {
            east -= turn;
        }
        let column = east / grid.step[0];
        if grid.is_round() {
            return Some([column.rem_euclid(columns), row]);
        }
        (column <= columns - 1.0 + beyond).then_some([column, row])
    }

    /// The samples on either side of `at`, and how far it is from the first to the second.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "0 to the number of samples"
    )]
    fn between(&self, at: f64, count: u32, is_round: bool) -> (usize, usize, f64) {
        let count = count as usize;
        let first = (at.floor() as usize).min(count - 1);
        let along = at - first as f64;
        match (first + 1 < count, is_round) {
            (true, _) => (first, first + 1, along),
            (false, true) => (first, 0, along),
            (false, false) => (first, first, 0.0),
        }
    }
}

/// Samples that bilinear values from `from` to `to` are made of; `None` where there are none.
#[allow(
    clippy::cast_possible_truncation,
    reason = "0 to the number of samples"
)]
fn samples_between(from: f64, to: f64, count: u32, beyond: f64) -> Option<[usize; 2]> {
    let last = f64::from(count) - 1.0;
    if !(to >= -beyond && from <= last + beyond) {
        return None;
    }
    // Wider by the rounding of a projection there and back.
    let first = (from - RIM).floor().clamp(0.0, last);
    let end = (to + RIM).ceil().clamp(0.0, last);
    Some([first as usize, end as usize])
}

fn check_grid(complaints: Complaints<'_>, grid: &Grid) -> Result<(), ElevationError> {
    let count = u64::from(grid.columns) * u64::from(grid.rows);
    if grid.columns < 2 || grid.rows < 2 || count > MAX_SAMPLES {
        let found = format!("{} × {}", grid.columns, grid.rows);
        let allowed = format!("2 × 2 to {MAX_SAMPLES} samples");
        return Err(complaints.value("size", found, allowed));
    }
    let turn = grid.projection.turn();
    for (name, step) in ["step to the east", "step to the south"]
        .into_iter()
        .zip(grid.step)
    {
        let least = turn * LEAST_STEP;
        if !(step >= least && step.is_finite()) {
            return Err(complaints.value(name, step, format!("{least:.1e} or more")));
        }
    }
    let bounds = grid.bounds_beyond(grid.beyond());
    let (most_x, most_y) = match grid.projection {
        // Rasters of 0 … 360° are as common as those of −180 … 180°.
        Projection::Geographic => (360.0, 90.0),
        // The square of map tiles.
        Projection::WebMercator => (turn / 2.0, turn / 2.0),
    };
    let slack = 1.0 + 1e-6;
    for (name, found, most) in [
        ("western edge", bounds.west, most_x),
        ("eastern edge", bounds.east, most_x),
        ("southern edge", bounds.south, most_y),
        ("northern edge", bounds.north, most_y),
    ] {
        // No range holds a NaN.
        if !(0.0..=most * slack).contains(&found.abs()) {
            return Err(complaints.value(name, found, format!("-{most} to {most}")));
        }
    }
    // A column more than a whole turn repeats the first one.
    if bounds.east - bounds.west > turn + 1.5 * grid.step[0] {
        let found = bounds.east - bounds.west;
        return Err(complaints.value("width", found, format!("at most {turn}")));
    }
    Ok(())
}
