// SPDX-License-Identifier: MIT OR Apache-2.0
//! GeoJSON (RFC 7946) → [`Region`]s: areal geometries only, every problem of a file listed at once.
//!
//! Degrees as they stand in the file. A syntax error ends the reading, since nothing after it can
//! be trusted; everything else is collected, so that a file is mended in one round.

mod problem;
mod raw;
mod ring;

pub(crate) use problem::feature_label;
pub use problem::{RegionFileError, RegionProblem, RegionProblemKind, printable, wide_encoding};
pub(crate) use ring::LARGEST_LONGITUDE_DEG;

use crate::{Inside, Polygon, Region, Ring, Unwrap};
use problem::json_problem;
use raw::{RawCoordinates, RawObject};
use ring::{TurnOf, distinct_up_to_three, jump, net_jumps, shorter_turn, unroll, without_repeated};
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
/// - `file`: what error messages call it
/// - accepts Polygon, MultiPolygon, and GeometryCollection whose other members are left out with a
///   warning; heights are ignored; a byte order mark, either line ending and either winding are fine
/// - leaves features of points, lines or no geometry out, with a warning of the file
/// - normalises, with a warning in [`Region::warnings`]: open rings, repeated positions
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

/// As [`parse_regions_as`], what the file leaves open by default.
///
/// # Errors
/// As there.
pub fn parse_regions(bytes: &[u8], file: &str) -> Result<Vec<Region>, RegionFileError> {
    parse_regions_as(bytes, file, Reading::default())
}

/// The regions of [`read_region_file`], at least one.
///
/// # Errors
/// As there, and [`RegionProblemKind::NoFeatures`].
pub fn parse_regions_as(
    bytes: &[u8],
    file: &str,
    reading: Reading,
) -> Result<Vec<Region>, RegionFileError> {
    Ok(read_regions_as(bytes, file, reading)?.regions)
}

/// As [`parse_regions_as`], with what the reader warns of.
///
/// # Errors
/// As there.
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
struct Place {
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
    members_without_area: usize,
}

impl Normalised {
    fn warnings(&self) -> Vec<String> {
        let count = |n: usize, one: &str, many: &str| {
            (n > 0).then(|| format!("{n} {}", if n == 1 { one } else { many }))
        };
        [
            count(
                self.open_rings,
                "ring was not closed",
                "rings were not closed",
            ),
            count(
                self.repeated_positions,
                "repeated position was dropped",
                "repeated positions were dropped",
            ),
            count(
                self.collapsed_holes,
                "hole without area was left out",
                "holes without area were left out",
            ),
            count(
                self.members_without_area,
                "geometry without area was left out",
                "geometries without area were left out",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[derive(Default)]
struct Reader {
    reading: Reading,
    place: Place,
    problems: Vec<RegionProblem>,
    normalised: Normalised,
    /// Features without area, by type.
    left_out: BTreeMap<String, usize>,
    /// Coordinate reference systems that are not WGS 84.
    foreign_crs: BTreeSet<String>,
    has_no_features: bool,
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
        self.problems.push(RegionProblem {
            feature: self.place.feature,
            name: self.place.name.clone(),
            polygon: self.place.polygon,
            ring: self.place.ring,
            vertex,
            kind,
        });
    }

    fn read_file(&mut self, bytes: &[u8]) -> Vec<Region> {
        if let Some(found) = wide_encoding(bytes) {
            self.problem(None, RegionProblemKind::Encoding { found });
            return Vec::new();
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
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
        match serde_json::from_slice::<RawObject>(text) {
            Ok(root) => self.read_root(root),
            Err(error) => {
                self.problem(None, json_problem(text, &error));
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
                self.has_no_features = features.is_empty();
                let regions: Vec<Region> = features
                    .into_iter()
                    .enumerate()
                    .filter_map(|(index, feature)| self.read_feature(index, feature))
                    .collect();
                self.check_areas(&regions, None);
                regions
            }
            Some("Feature") => {
                let regions: Vec<Region> = self.read_feature(0, root).into_iter().collect();
                self.check_areas(&regions, Some(0));
                regions
            }
            Some(kind) if geometry_kind(kind).is_some() => {
                let name = root.label(0);
                let regions: Vec<Region> = self.read_region(0, name, root).into_iter().collect();
                self.check_areas(&regions, Some(0));
                regions
            }
            found => {
                self.wrong_type(found, ROOT_TYPES);
                Vec::new()
            }
        }
    }

    /// Refuses a file in which nothing has an area.
    ///
    /// - `feature`: the only one, if the file is no collection
    fn check_areas(&mut self, regions: &[Region], feature: Option<usize>) {
        if regions.is_empty() && self.problems.is_empty() && !self.left_out.is_empty() {
            if feature.is_none() {
                self.place = Place::default();
            }
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
        self.place = Place {
            feature: Some(index),
            name: Some(name.clone()),
            ..Place::default()
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
        self.place = Place {
            feature: Some(index),
            name: Some(name.clone()),
            ..Place::default()
        };
        self.normalised = Normalised::default();
        let is_collection = geometry.geometries.is_some();
        let problems_before = self.problems.len();
        let mut polygons = Vec::new();
        let mut without_area = BTreeSet::new();
        self.read_geometry(geometry, &mut polygons, &mut without_area);
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
        Some(Region {
            index,
            name,
            polygons,
            warnings: self.normalised.warnings(),
            repaired: false,
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
                Some(coordinates) => self.read_polygon(coordinates, polygons),
            },
            Some(GeometryKind::MultiPolygon) => match geometry.coordinates {
                None => self.missing("coordinates", &found),
                Some(RawCoordinates::List(list)) if list.is_empty() => {
                    self.problem(None, RegionProblemKind::EmptyCoordinates);
                }
                Some(RawCoordinates::List(list)) => {
                    for polygon in list {
                        self.read_polygon(polygon, polygons);
                    }
                }
                Some(other) => self.wrong_nesting(None, &other, "a list of polygons"),
            },
        }
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

    fn read_polygon(&mut self, coordinates: RawCoordinates, polygons: &mut Vec<Polygon>) {
        // The running number counts refused polygons too: it is the place in the file.
        let index = self.place.polygon.map_or(0, |previous| previous + 1);
        self.place.polygon = Some(index);
        self.place.ring = None;
        match coordinates {
            RawCoordinates::List(rings) if rings.is_empty() => {
                self.problem(None, RegionProblemKind::EmptyCoordinates);
            }
            RawCoordinates::List(rings) => {
                let mut read = Vec::with_capacity(rings.len());
                for (i, ring) in rings.into_iter().enumerate() {
                    self.place.ring = Some(i);
                    let ring = self.read_ring(ring);
                    let dropped = i - read.len();
                    read.extend(ring.map(|ring| ring.after_dropped(dropped)));
                }
                self.place.ring = None;
                let mut read = read.into_iter();
                if let Some(shell) = read.next() {
                    let holes = read.collect();
                    polygons.push(Polygon { shell, holes });
                }
            }
            other => self.wrong_nesting(None, &other, "a list of rings"),
        }
    }

    fn read_ring(&mut self, coordinates: RawCoordinates) -> Option<Ring> {
        let list = match coordinates {
            RawCoordinates::List(list) => list,
            other => {
                self.wrong_nesting(None, &other, "a list of positions");
                return None;
            }
        };
        if list.is_empty() {
            self.problem(None, RegionProblemKind::EmptyCoordinates);
            return None;
        }
        let problems_before = self.problems.len();
        let mut positions: Vec<[f64; 2]> = Vec::with_capacity(list.len());
        for (i, item) in list.iter().enumerate() {
            match item {
                RawCoordinates::Position(position) => {
                    self.check_position(i, *position);
                    // Adding zero turns −0 into 0, so that equal places have equal bits.
                    positions.push(position.map(|value| value + 0.0));
                }
                RawCoordinates::NotANumber(not) => {
                    let (element, found) = (not.element, not.found.clone());
                    self.problem(Some(i), RegionProblemKind::NotANumber { element, found });
                }
                other => {
                    let allowed = "a position of two or more numbers";
                    self.wrong_nesting(Some(i), other, allowed);
                }
            }
        }
        if self.problems.len() > problems_before {
            return None;
        }
        self.normalise_ring(positions)
    }

    fn check_position(&mut self, vertex: usize, [longitude, latitude]: [f64; 2]) {
        // JSON has no NaN and serde_json refuses what overflows: both are finite.
        if longitude.abs() > LARGEST_LONGITUDE_DEG {
            let found = longitude;
            self.problem(Some(vertex), RegionProblemKind::Longitude { found });
        }
        if latitude.abs() > 90.0 {
            let found = latitude;
            self.problem(Some(vertex), RegionProblemKind::Latitude { found });
        }
    }

    /// Positions known to be in range → ring.
    fn normalise_ring(&mut self, mut positions: Vec<[f64; 2]>) -> Option<Ring> {
        let length = positions.len();
        let closed = length > 1 && positions[0] == positions[length - 1];
        if closed {
            positions.pop();
        }
        let length = positions.len();
        let mut file_vertices = without_repeated(&positions);
        positions.dedup();
        while positions.len() > 1 && positions.first() == positions.last() {
            positions.pop();
        }
        file_vertices.truncate(positions.len());
        self.normalised.repeated_positions += length - positions.len();

        let (turns, is_unrolled, turn): (isize, bool, TurnOf) = match self.reading.unwrap {
            Unwrap::Literal => {
                let turns = net_jumps(&positions);
                (turns, turns != 0, jump)
            }
            Unwrap::Shortest => {
                let next = positions.iter().cycle().skip(1);
                let edges = positions.iter().zip(next);
                let each = edges.map(|(start, end)| shorter_turn(*start, *end));
                let (net, any) = each.fold((0, false), |(net, any), turn| {
                    (net + turn, any || turn != 0)
                });
                (net, any, shorter_turn)
            }
        };
        if turns.unsigned_abs() > 1 {
            let found = turns.unsigned_abs();
            self.problem(None, RegionProblemKind::ManyTurns { found });
            return None;
        }
        let last_edge_is_jump = jump(positions[positions.len() - 1], positions[0]) != 0;
        let ends_one_turn_on = turns != 0 && last_edge_is_jump;
        if !(closed || ends_one_turn_on) {
            self.normalised.open_rings += 1;
        }
        let (winding_deg, written) = if is_unrolled {
            let (winding_deg, written, repeated) = unroll(&mut positions, &mut file_vertices, turn);
            self.normalised.repeated_positions += repeated;
            (winding_deg, written)
        } else {
            (0.0, Vec::new())
        };
        let mut found = distinct_up_to_three(&positions);
        if winding_deg != 0.0 && found < 3 {
            // Its end, one turn on, is a position of its own in the file.
            found += 1;
        }
        if found < 3 && self.place.ring > Some(0) {
            self.normalised.collapsed_holes += 1;
            return None;
        }
        if found < 3 {
            let required = 3;
            self.problem(None, RegionProblemKind::TooFewVertices { found, required });
            return None;
        }
        let ring = Ring::from_checked(positions, winding_deg)
            .with_file_vertices(file_vertices)
            .with_written_longitudes(written);
        Some(ring)
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
