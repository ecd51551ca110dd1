// SPDX-License-Identifier: MIT OR Apache-2.0
//! GeoJSON (RFC 7946) → [`Region`]s: areal geometries only, every problem of a file listed at once.
//!
//! Degrees as they stand in the file. A syntax error ends the reading, since nothing after it can
//! be trusted; everything else is collected, so that a file is mended in one round.

mod long_edges;
mod polygon;
mod problem;
mod raw;
mod records;
mod ring;

pub(crate) use problem::feature_label;
pub use problem::{RegionFileError, RegionProblem, RegionProblemKind, printable, wide_encoding};

use crate::{EdgeRule, Inside, Polygon, Region, RegionWarning, Unwrap, WarningSubject};
use long_edges::{ShorterReading, choose_readings};
use problem::{json_problem, other_format};
use raw::{RawCoordinates, RawObject};
use records::{MAX_UNPACKED_BYTES, records, unpacked};
use serde::de::IgnoredAny;
use std::collections::{BTreeMap, BTreeSet};

/// Regions of a file, and what is remarkable about the file as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionFile {
    /// One per feature with an area, in file order; none in a collection without features.
    pub regions: Vec<Region>,
    /// Features that were left out since they have no area, counted by their types, and a coordinate
    /// reference system that is not WGS 84.
    pub warnings: Vec<String>,
}

/// Reads the regions of a GeoJSON file: one per feature; a bare geometry is one region.
///
/// Newline-delimited GeoJSON and text sequences (RFC 8142) are read as the features of their lines or
/// records; gzip of any of these is unpacked.
///
/// - `file`: what error messages call it
/// - accepts Polygon, `MultiPolygon`, and `GeometryCollection` whose other members are left out with a
///   warning; heights are ignored; a byte order mark, either line ending and either winding are fine
/// - leaves features of points, lines, empty polygons or no geometry out. [`RegionFile::warnings`] says so.
/// - normalises open rings, repeated positions, and parts and holes without area beside others that have
///   one. [`Region::warnings`] says so.
///
/// # Errors
/// [`RegionFileError`] with every problem of the file. [`RegionProblemKind::NotAreal`] is one only
/// where no feature has an area.
pub fn read_region_file(
    bytes: &[u8],
    file: &str,
    reading: Reading,
) -> Result<RegionFile, RegionFileError> {
    let mut reader = Reader {
        reading,
        ..Reader::default()
    };
    let regions = reader.read_file(bytes);
    let warnings = reader.warnings();
    if reader.problems.is_empty() {
        Ok(RegionFile { regions, warnings })
    } else {
        Err(RegionFileError {
            file: file.to_owned(),
            problems: reader.problems,
            readable: regions,
            warnings,
        })
    }
}

/// What a file leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// Which way edges over more than 180° of longitude go.
    pub unwrap: Unwrap,
    /// Which side of a ring round a pole is inside: [`Region::inside`].
    pub inside: Inside,
}

impl Reading {
    /// As it counts for such edges: great ellipses take the shorter way anyway, so there is nothing to
    /// find out.
    #[must_use]
    pub fn of_edges(self, rule: EdgeRule) -> Self {
        match (self.unwrap, rule) {
            (Unwrap::Auto, EdgeRule::GreatEllipse) => Self {
                unwrap: Unwrap::Literal,
                ..self
            },
            _ => self,
        }
    }
}

/// The regions of [`read_regions_as`], what the file leaves open by default.
///
/// # Errors
/// As there.
pub fn parse_regions(bytes: &[u8], file: &str) -> Result<Vec<Region>, RegionFileError> {
    Ok(read_regions_as(bytes, file, Reading::default())?.regions)
}

/// As [`read_region_file`], at least one region.
///
/// # Errors
/// As there, and [`RegionProblemKind::NoFeatures`].
pub fn read_regions_as(
    bytes: &[u8],
    file: &str,
    reading: Reading,
) -> Result<RegionFile, RegionFileError> {
    let read = read_region_file(bytes, file, reading)?;
    if read.regions.is_empty() {
        let mut reader = Reader::default();
        reader.problem(None, RegionProblemKind::NoFeatures);
        return Err(RegionFileError {
            file: file.to_owned(),
            problems: reader.problems,
            readable: Vec::new(),
            warnings: read.warnings,
        });
    }
    Ok(read)
}

const GEOMETRY_TYPES: &str = "Polygon, MultiPolygon or GeometryCollection";
const ROOT_TYPES: &str = "FeatureCollection, Feature, Polygon, MultiPolygon or GeometryCollection";

/// Where in the file the reader is.
#[derive(Default, Clone)]
struct ReadPlace {
    /// Where the file has a text on each line.
    line: Option<usize>,
    feature: Option<usize>,
    name: Option<String>,
    polygon: Option<usize>,
    ring: Option<usize>,
}

/// Counts of what was put right, per region.
#[derive(Default)]
struct Normalised {
    open_rings: usize,
    repeated_positions: usize,
    collapsed_holes: usize,
    collapsed_parts: usize,
    members_without_area: usize,
}

impl Normalised {
    fn warnings(&self) -> Vec<RegionWarning> {
        [
            (self.open_rings, "ring", "rings", "not closed"),
            (
                self.repeated_positions,
                "repeated position",
                "repeated positions",
                "dropped",
            ),
            (
                self.collapsed_holes,
                "hole without area",
                "holes without area",
                "left out",
            ),
            (
                self.collapsed_parts,
                "part without area",
                "parts without area",
                "left out",
            ),
            (
                self.members_without_area,
                "geometry without area",
                "geometries without area",
                "left out",
            ),
        ]
        .into_iter()
        .filter(|(count, ..)| *count > 0)
        .map(|(count, one, many, done)| match count {
            1 => format!("1 {one} was {done}"),
            _ => format!("{count} {many} were {done}"),
        })
        .map(|text| WarningSubject::Reading.warn(text))
        .collect()
    }
}

#[derive(Default)]
struct Reader {
    reading: Reading,
    place: ReadPlace,
    problems: Vec<RegionProblem>,
    normalised: Normalised,
    /// Features without area, by type.
    left_out: BTreeMap<String, usize>,
    /// Coordinate reference systems that are not WGS 84.
    foreign_crs: BTreeSet<String>,
    has_no_features: bool,
    /// Of the file's features so far.
    feature_count: usize,
    /// Of the region being read: parts without area, wrong only where no other part has one.
    collapsed: Vec<RegionProblem>,
    /// Of the region being read: rings that can be read in two ways.
    shorter: Vec<ShorterReading>,
}

impl Reader {
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.has_no_features {
            warnings.push("the file has no features".to_owned());
        }
        let left_out: usize = self.left_out.values().sum();
        if left_out > 0 {
            let (noun, verb) = if left_out == 1 {
                ("feature", "was")
            } else {
                ("features", "were")
            };
            let types = self.left_out_types();
            warnings.push(format!(
                "{left_out} {noun} without area {verb} left out: {types}"
            ));
        }
        for name in &self.foreign_crs {
            warnings.push(format!(
                "crs is {name:?}; coordinates are read as longitude and latitude in degrees (RFC \
                 7946: WGS 84)"
            ));
        }
        warnings
    }

    /// `2 Point, 1 null`.
    fn left_out_types(&self) -> String {
        let types = self.left_out.iter();
        let types: Vec<String> = types
            .map(|(kind, count)| format!("{count} {kind}"))
            .collect();
        types.join(", ")
    }

    fn problem(&mut self, vertex: Option<usize>, kind: RegionProblemKind) {
        let problem = self.problem_here(vertex, kind);
        self.problems.push(problem);
    }

    fn problem_here(&self, vertex: Option<usize>, kind: RegionProblemKind) -> RegionProblem {
        RegionProblem {
            line: self.place.line,
            feature: self.place.feature,
            name: self.place.name.clone(),
            polygon: self.place.polygon,
            ring: self.place.ring,
            vertex,
            kind,
        }
    }

    fn read_file(&mut self, bytes: &[u8]) -> Vec<Region> {
        let bytes = match unpacked(bytes, MAX_UNPACKED_BYTES) {
            Ok(bytes) => bytes,
            Err(kind) => {
                self.problem(None, kind);
                return Vec::new();
            }
        };
        let bytes = &*bytes;
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if let Some(found) = other_format(text.trim_ascii_start()) {
            self.problem(None, RegionProblemKind::OtherFormat { found });
            return Vec::new();
        }
        if let Some(found) = wide_encoding(bytes) {
            self.problem(None, RegionProblemKind::Encoding { found });
            return Vec::new();
        }
        match text.iter().find(|byte| !byte.is_ascii_whitespace()) {
            None => {
                self.problem(None, RegionProblemKind::EmptyFile);
                return Vec::new();
            }
            Some(b'[') => {
                // Only a list that is valid JSON is reported as a list; a broken one is broken.
                match serde_json::from_slice::<IgnoredAny>(text) {
                    Ok(_) => self.problem(None, RegionProblemKind::BareList),
                    Err(error) => self.problem(None, json_problem(text, &error)),
                }
                return Vec::new();
            }
            Some(_) => {}
        }
        let regions = match records(text) {
            None => self.read_text(text, None),
            Some(records) => {
                let read = records
                    .into_iter()
                    .flat_map(|record| self.read_text(record.text, Some(record.line)));
                let regions = read.collect();
                self.place = ReadPlace::default();
                regions
            }
        };
        if self.problems.is_empty() {
            self.has_no_features = self.feature_count == 0;
        }
        self.check_areas(&regions);
        regions
    }

    /// - `line`: of the file that the text begins in, where it is one of several
    fn read_text(&mut self, text: &[u8], line: Option<usize>) -> Vec<Region> {
        self.place = ReadPlace {
            line,
            ..ReadPlace::default()
        };
        match serde_json::from_slice::<RawObject>(text) {
            Ok(root) => self.read_root(root),
            Err(error) => {
                self.place.line = None;
                let mut kind = json_problem(text, &error);
                if let (RegionProblemKind::Json { line: at, .. }, Some(line)) = (&mut kind, line) {
                    *at += line - 1;
                }
                self.problem(None, kind);
                Vec::new()
            }
        }
    }

    fn read_root(&mut self, root: RawObject) -> Vec<Region> {
        self.foreign_crs.extend(root.foreign_crs());
        match root.kind.as_deref() {
            Some("FeatureCollection") => {
                let Some(features) = root.features else {
                    self.missing("features", "FeatureCollection");
                    return Vec::new();
                };
                let first = self.feature_count;
                self.feature_count += features.len();
                let regions = (first..)
                    .zip(features)
                    .filter_map(|(index, feature)| self.read_feature(index, feature))
                    .collect();
                // What is wrong with all of them is no feature's.
                self.place = ReadPlace {
                    line: self.place.line,
                    ..ReadPlace::default()
                };
                regions
            }
            Some("Feature") => {
                let index = self.next_feature();
                self.read_feature(index, root).into_iter().collect()
            }
            Some(kind) if geometry_kind(kind).is_some() => {
                let index = self.next_feature();
                let name = root.label(index);
                self.read_region(index, name, root).into_iter().collect()
            }
            found => {
                self.wrong_type(found, ROOT_TYPES);
                Vec::new()
            }
        }
    }

    fn next_feature(&mut self) -> usize {
        self.feature_count += 1;
        self.feature_count - 1
    }

    /// Refuses a file in which nothing has an area.
    fn check_areas(&mut self, regions: &[Region]) {
        if regions.is_empty() && self.problems.is_empty() && !self.left_out.is_empty() {
            let found = self.left_out_types();
            self.problem(None, RegionProblemKind::NotAreal { found });
        }
    }

    /// - `found`: the type, if there is one
    fn wrong_type(&mut self, found: Option<&str>, allowed: &'static str) {
        let problem = match found.map(str::to_owned) {
            None => RegionProblemKind::MissingType { allowed },
            Some(found) => RegionProblemKind::UnknownType { found, allowed },
        };
        self.problem(None, problem);
    }

    fn missing(&mut self, member: &'static str, of: &str) {
        let of = of.to_owned();
        self.problem(None, RegionProblemKind::MissingMember { member, of });
    }

    fn read_feature(&mut self, index: usize, feature: RawObject) -> Option<Region> {
        let name = feature.label(index);
        self.place = ReadPlace {
            line: self.place.line,
            feature: Some(index),
            name: Some(name.clone()),
            ..ReadPlace::default()
        };
        let kind = feature.kind.as_deref();
        if kind != Some("Feature") {
            self.wrong_type(kind, "Feature");
            return None;
        }
        match feature.geometry {
            None => {
                self.missing("geometry", "Feature");
                None
            }
            Some(None) => {
                self.leave_out("null".to_owned());
                None
            }
            Some(Some(geometry)) => {
                self.foreign_crs.extend(geometry.foreign_crs());
                self.read_region(index, name, *geometry)
            }
        }
    }

    fn leave_out(&mut self, kind: String) {
        *self.left_out.entry(kind).or_default() += 1;
    }

    fn read_region(&mut self, index: usize, name: String, geometry: RawObject) -> Option<Region> {
        self.place = ReadPlace {
            line: self.place.line,
            feature: Some(index),
            name: Some(name.clone()),
            ..ReadPlace::default()
        };
        self.normalised = Normalised::default();
        let is_collection = geometry.geometries.is_some();
        let problems_before = self.problems.len();
        let mut polygons = Vec::new();
        let mut without_area = BTreeSet::new();
        self.read_geometry(geometry, &mut polygons, &mut without_area);
        let collapsed = std::mem::take(&mut self.collapsed);
        let shorter = std::mem::take(&mut self.shorter);
        if polygons.is_empty() {
            self.problems.extend(collapsed);
        } else {
            self.normalised.collapsed_parts += collapsed.len();
        }
        if self.problems.len() > problems_before {
            return None;
        }
        if polygons.is_empty() {
            let types: Vec<String> = without_area.into_iter().collect();
            let types = types.join(", ");
            self.leave_out(match (is_collection, types.as_str()) {
                (_, "") => "empty collection".to_owned(),
                (true, _) => format!("GeometryCollection of {types}"),
                (false, _) => types,
            });
            return None;
        }
        let mut warnings = self.normalised.warnings();
        warnings.extend(choose_readings(&mut polygons, &shorter));
        Some(Region {
            index,
            name,
            polygons,
            warnings,
            repaired: None,
            inside: self.reading.inside,
        })
    }

    fn read_geometry(
        &mut self,
        geometry: RawObject,
        polygons: &mut Vec<Polygon>,
        without_area: &mut BTreeSet<String>,
    ) {
        let Some(found) = geometry.kind else {
            self.wrong_type(None, GEOMETRY_TYPES);
            return;
        };
        match geometry_kind(&found) {
            None => self.wrong_type(Some(&found), GEOMETRY_TYPES),
            Some(GeometryKind::WithoutArea) => {
                self.normalised.members_without_area += 1;
                without_area.insert(found);
            }
            Some(GeometryKind::Collection) => match geometry.geometries {
                None => self.missing("geometries", &found),
                Some(members) => {
                    for member in members {
                        self.read_geometry(member, polygons, without_area);
                    }
                }
            },
            Some(GeometryKind::Polygon) => match geometry.coordinates {
                None => self.missing("coordinates", &found),
                Some(coordinates) if coordinates.is_empty_polygon() => {
                    self.leave_out_empty(&found, without_area);
                }
                Some(coordinates) => self.read_polygon(coordinates, polygons),
            },
            Some(GeometryKind::MultiPolygon) => match geometry.coordinates {
                None => self.missing("coordinates", &found),
                Some(RawCoordinates::List(list)) if list.is_empty() => {
                    self.leave_out_empty(&found, without_area);
                }
                Some(RawCoordinates::List(list)) => {
                    for polygon in list {
                        if polygon.is_empty_polygon() {
                            self.next_polygon();
                            self.leave_out_empty("Polygon", without_area);
                        } else {
                            self.read_polygon(polygon, polygons);
                        }
                    }
                }
                Some(other) => self.wrong_nesting(None, &other, "a list of polygons"),
            },
        }
    }

    /// RFC 7946 §3.1: what has no coordinates may be read as null.
    fn leave_out_empty(&mut self, kind: &str, without_area: &mut BTreeSet<String>) {
        self.normalised.members_without_area += 1;
        without_area.insert(format!("empty {kind}"));
    }

    /// The running number counts what is refused or left out too: it is the place in the file.
    fn next_polygon(&mut self) -> usize {
        let index = self.place.polygon.map_or(0, |previous| previous + 1);
        self.place.polygon = Some(index);
        self.place.ring = None;
        index
    }

    fn wrong_nesting(
        &mut self,
        vertex: Option<usize>,
        found: &RawCoordinates,
        allowed: &'static str,
    ) {
        let found = found.describe();
        self.problem(vertex, RegionProblemKind::WrongNesting { found, allowed });
    }
}

enum GeometryKind {
    Polygon,
    MultiPolygon,
    Collection,
    WithoutArea,
}

fn geometry_kind(name: &str) -> Option<GeometryKind> {
    match name {
        "Polygon" => Some(GeometryKind::Polygon),
        "MultiPolygon" => Some(GeometryKind::MultiPolygon),
        "GeometryCollection" => Some(GeometryKind::Collection),
        "Point" | "MultiPoint" | "LineString" | "MultiLineString" => {
            Some(GeometryKind::WithoutArea)
        }
        _ => None,
    }
}
