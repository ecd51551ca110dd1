// SPDX-License-Identifier: MIT OR Apache-2.0
//! GeoJSON (RFC 7946) → [`Region`]s: areal geometries only, every problem of a file listed at once.
//!
//! Degrees as they stand in the file. A syntax error ends the reading, since nothing after it can
//! be trusted; everything else is collected, so that a file is mended in one round. The tree that
//! serde builds holds only what is needed: positions as two numbers, properties as a name.

use crate::{Inside, Polygon, Region, Ring, Unwrap};
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// Longitudes beyond this are refused: one turn past the antimeridian is how uncut rings are
/// written; more is a mistake, most often another unit.
pub(crate) const LARGEST_LONGITUDE_DEG: f64 = 540.0;

/// Everything that is wrong with a file of regions.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionFileError {
    /// As the caller named it.
    pub file: String,
    /// At least one.
    pub problems: Vec<RegionProblem>,
    /// Features without problems: what else is wrong with them can be told in the same round.
    pub readable: Vec<Region>,
}

impl fmt::Display for RegionFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            let separator = if i == 0 { "" } else { "\n" };
            write!(f, "{separator}{}: {problem}", self.file)?;
        }
        Ok(())
    }
}

impl std::error::Error for RegionFileError {}

/// One thing wrong with a file, and where. Indices count from 0, in file order.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionProblem {
    /// Feature, unless the file as a whole is meant.
    pub feature: Option<usize>,
    /// Its name, where it was read.
    pub name: Option<String>,
    /// Areal part of the feature.
    pub polygon: Option<usize>,
    /// Ring of the polygon; 0 is the shell.
    pub ring: Option<usize>,
    /// Position in the ring.
    pub vertex: Option<usize>,
    /// What is wrong.
    pub kind: RegionProblemKind,
}

/// Number and name of a feature, the name left out where there is none.
pub(crate) fn feature_label(feature: usize, name: &str) -> String {
    let number = unnamed(feature);
    if name.is_empty() || name == number {
        number
    } else {
        format!("{number} ({name})")
    }
}

fn unnamed(feature: usize) -> String {
    format!("feature {feature}")
}

impl fmt::Display for RegionProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(feature) = self.feature {
            let name = self.name.as_deref().unwrap_or_default();
            f.write_str(&feature_label(feature, name))?;
            let parts = [
                ("polygon", self.polygon),
                ("ring", self.ring),
                ("vertex", self.vertex),
            ];
            for (word, index) in parts {
                if let Some(index) = index {
                    write!(f, ", {word} {index}")?;
                }
            }
            f.write_str(": ")?;
        }
        write!(f, "{}", self.kind)
    }
}

/// What can be wrong with a file of regions: the value found and the value allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionProblemKind {
    /// No bytes, or only white space.
    #[error("the file is empty; expected GeoJSON")]
    EmptyFile,
    /// Not JSON from here on, or JSON of a shape that GeoJSON does not have.
    #[error("line {line}, column {column}: {message}{}", Self::quoted(found.as_ref()))]
    Json {
        /// From 1.
        line: usize,
        /// From 1, in bytes.
        column: usize,
        /// The parser's words.
        message: String,
        /// The text there, where there is a word or number.
        found: Option<String>,
    },
    /// A list where an object should be.
    #[error(
        "the file is a bare list, such as rings in pixel coordinates; expected a GeoJSON object \
         with a \"type\""
    )]
    BareList,
    /// `type` is missing.
    #[error("no \"type\"; expected {allowed}")]
    MissingType {
        /// What may stand here.
        allowed: &'static str,
    },
    /// `type` says something else.
    #[error("type \"{found}\"; expected {allowed}")]
    UnknownType {
        /// As in the file.
        found: String,
        /// What may stand here.
        allowed: &'static str,
    },
    /// A member that the type calls for is missing or null.
    #[error("no \"{member}\" in a {of}")]
    MissingMember {
        /// Its name.
        member: &'static str,
        /// Type of the object.
        of: String,
    },
    /// A collection of nothing.
    #[error("no features; expected at least one")]
    NoFeatures,
    /// Only points or lines.
    #[error("no area: geometry is {found}; expected Polygon or MultiPolygon")]
    NotAreal {
        /// Types found, as in the file.
        found: String,
    },
    /// `[]` where positions should be.
    #[error("empty coordinates; expected at least 3 distinct positions")]
    EmptyCoordinates,
    /// Coordinates nested too deep, too flat, or not numbers.
    #[error("{found} in the coordinates; expected {allowed}")]
    WrongNesting {
        /// What stands there.
        found: String,
        /// What may.
        allowed: &'static str,
    },
    /// Beyond a pole.
    #[error("latitude {found} is outside -90 … 90")]
    Latitude {
        /// Degrees.
        found: f64,
    },
    /// Far round.
    #[error("longitude {found} is outside -540 … 540")]
    Longitude {
        /// Degrees.
        found: f64,
    },
    /// No area.
    #[error("{found} distinct positions in the ring; needs at least {required}")]
    TooFewVertices {
        /// Distinct positions.
        found: usize,
        /// Three.
        required: usize,
    },
    /// Goes round more than once.
    #[error("the ring goes round the axis {found} times; at most 1 is allowed")]
    ManyTurns {
        /// Turns, without their sign.
        found: usize,
    },
}

impl RegionProblemKind {
    fn quoted(found: Option<&String>) -> String {
        found.map_or_else(String::new, |text| format!(", found \"{text}\""))
    }
}

/// Reads the regions of a GeoJSON file: one per feature; a bare geometry is one region.
///
/// - `file`: what error messages call it
/// - accepts Polygon, MultiPolygon, and GeometryCollection whose other members are left out with a
///   warning; heights are ignored; a byte order mark, either line ending and either winding are fine
/// - normalises, with a warning in [`Region::warnings`]: open rings, repeated positions
///
/// # Errors
/// [`RegionFileError`] with every problem of the file.
pub fn parse_regions(bytes: &[u8], file: &str) -> Result<Vec<Region>, RegionFileError> {
    parse_regions_as(bytes, file, Reading::default())
}

/// What a file leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// Which way edges over more than 180° of longitude go.
    pub unwrap: Unwrap,
    /// Which side of a ring round a pole is inside: [`Region::inside`].
    pub inside: Inside,
}

/// As [`parse_regions`], with another reading of what a file leaves open.
///
/// # Errors
/// As [`parse_regions`].
pub fn parse_regions_as(
    bytes: &[u8],
    file: &str,
    reading: Reading,
) -> Result<Vec<Region>, RegionFileError> {
    let mut reader = Reader {
        reading,
        ..Reader::default()
    };
    let regions = reader.read_file(bytes);
    if reader.problems.is_empty() {
        Ok(regions)
    } else {
        Err(RegionFileError {
            file: file.to_owned(),
            problems: reader.problems,
            readable: regions,
        })
    }
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
}

impl Reader {
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
        match root.kind.as_deref() {
            None => {
                let allowed = ROOT_TYPES;
                self.problem(None, RegionProblemKind::MissingType { allowed });
                Vec::new()
            }
            Some("FeatureCollection") => {
                let Some(features) = root.features else {
                    self.missing("features", "FeatureCollection");
                    return Vec::new();
                };
                if features.is_empty() {
                    self.problem(None, RegionProblemKind::NoFeatures);
                }
                features
                    .into_iter()
                    .enumerate()
                    .filter_map(|(index, feature)| self.read_feature(index, feature))
                    .collect()
            }
            Some("Feature") => self.read_feature(0, root).into_iter().collect(),
            Some(kind) if geometry_kind(kind).is_some() => {
                let name = root.label(0);
                self.read_region(0, name, root).into_iter().collect()
            }
            Some(found) => {
                let found = found.to_owned();
                let allowed = ROOT_TYPES;
                self.problem(None, RegionProblemKind::UnknownType { found, allowed });
                Vec::new()
            }
        }
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
        match feature.kind.as_deref() {
            Some("Feature") => {}
            None => {
                let allowed = "Feature";
                self.problem(None, RegionProblemKind::MissingType { allowed });
                return None;
            }
            Some(found) => {
                let found = found.to_owned();
                let allowed = "Feature";
                self.problem(None, RegionProblemKind::UnknownType { found, allowed });
                return None;
            }
        }
        let Some(geometry) = feature.geometry else {
            self.missing("geometry", "Feature");
            return None;
        };
        self.read_region(index, name, *geometry)
    }

    fn read_region(&mut self, index: usize, name: String, geometry: RawObject) -> Option<Region> {
        self.place = Place {
            feature: Some(index),
            name: Some(name.clone()),
            ..Place::default()
        };
        self.normalised = Normalised::default();
        let problems_before = self.problems.len();
        let mut polygons = Vec::new();
        let mut without_area = Vec::new();
        self.read_geometry(geometry, &mut polygons, &mut without_area);
        if self.problems.len() > problems_before {
            return None;
        }
        if polygons.is_empty() {
            let found = if without_area.is_empty() {
                "an empty collection".to_owned()
            } else {
                without_area.join(", ")
            };
            self.problem(None, RegionProblemKind::NotAreal { found });
            return None;
        }
        self.normalised.members_without_area = without_area.len();
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
        without_area: &mut Vec<String>,
    ) {
        let Some(found) = geometry.kind else {
            let allowed = GEOMETRY_TYPES;
            self.problem(None, RegionProblemKind::MissingType { allowed });
            return;
        };
        match geometry_kind(&found) {
            None => {
                let allowed = GEOMETRY_TYPES;
                self.problem(None, RegionProblemKind::UnknownType { found, allowed });
            }
            Some(GeometryKind::WithoutArea) => without_area.push(found),
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

/// Indices of the positions that differ from the next; none where all do.
fn without_repeated(positions: &[[f64; 2]]) -> Vec<usize> {
    if positions.windows(2).all(|pair| pair[0] != pair[1]) {
        return Vec::new();
    }
    let last = positions.len() - 1;
    (0..=last)
        .filter(|&i| i == last || positions[i] != positions[i + 1])
        .collect()
}

/// Whole turns to take from the edge between two places.
type TurnOf = fn([f64; 2], [f64; 2]) -> isize;

/// ±1 for an edge between two spellings, one turn apart, of a place that is not a pole; else 0.
fn jump(start: [f64; 2], end: [f64; 2]) -> isize {
    let step = end[0] - start[0];
    if start[1] != end[1] || start[1].abs() == 90.0 || step.abs() != 360.0 {
        0
    } else if step > 0.0 {
        1
    } else {
        -1
    }
}

/// Whole turns that the edge between two places is longer than the shorter way; 0 along a pole, which
/// is one place, and where both ways are half a turn.
#[allow(
    clippy::cast_possible_truncation,
    reason = "longitudes within ±540 are three turns apart at most"
)]
fn shorter_turn(start: [f64; 2], end: [f64; 2]) -> isize {
    let step = end[0] - start[0];
    let along_pole = start[1].abs() == 90.0 && start[1] == end[1];
    if step.abs() <= 180.0 || along_pole {
        0
    } else {
        (step / 360.0).round() as isize
    }
}

/// Sum of the jumps of a closed ring.
///
/// Not 0: the ring goes round the axis and was cut open at the antimeridian to be written down.
/// 0 with jumps: edges along a whole parallel, as in the rectangle −180 … 180 × −10 … 10. The
/// rectangle −180 … 180 × 80 … 90 comes back along a pole, in one edge or in several, so its one
/// jump is such an edge too.
fn net_jumps(positions: &[[f64; 2]]) -> isize {
    let next = || positions.iter().cycle().skip(1);
    let turns: isize = positions
        .iter()
        .zip(next())
        .map(|(start, end)| jump(*start, *end))
        .sum();
    // By the ends of each run along a pole, which round nothing where its edges would.
    let along_pole = |a: &[f64; 2], b: &[f64; 2]| a[1].abs() == 90.0 && a[1] == b[1];
    let previous = positions.iter().cycle().skip(positions.len() - 1);
    let along_poles_deg: f64 = previous
        .zip(positions)
        .zip(next())
        .map(|((previous, at), next)| {
            f64::from(along_pole(previous, at)) * at[0] - f64::from(along_pole(at, next)) * at[0]
        })
        .sum();
    if along_poles_deg == -360.0 * turns as f64 {
        0
    } else {
        turns
    }
}

/// Shifts what follows each edge that turns by that many turns, drops the position that a jump
/// repeats, and returns how far from the start the ring ends, the longitudes before they were shifted,
/// and how many positions became one with their neighbour since 360° more cost them their last bits.
/// The same positions are dropped from `file_vertices`.
fn unroll(
    positions: &mut Vec<[f64; 2]>,
    file_vertices: &mut Vec<usize>,
    turn: TurnOf,
) -> (f64, Vec<f64>, usize) {
    let mut offset = 0.0;
    let mut repeated = 0;
    let mut written: Vec<f64> = Vec::with_capacity(positions.len());
    let mut unrolled: Vec<[f64; 2]> = Vec::with_capacity(positions.len());
    let mut kept: Vec<usize> = Vec::with_capacity(positions.len());
    let next = positions.iter().cycle().skip(1);
    let mut after_jump = false;
    for (i, (start, end)) in positions.iter().zip(next).enumerate() {
        let file_vertex = file_vertices.get(i).copied().unwrap_or(i);
        let place = [start[0] + offset, start[1]];
        let is_repeated = !after_jump && unrolled.last() == Some(&place);
        repeated += usize::from(is_repeated);
        if after_jump || is_repeated {
            // The edge to come starts from the position that repeats the one before the jump.
            kept.pop();
            if let Some(kept) = written.last_mut() {
                *kept = nearer_spelling(*kept, start[0]);
            }
        } else {
            unrolled.push(place);
            written.push(start[0]);
        }
        kept.push(file_vertex);
        let turns = turn(*start, *end);
        after_jump = turns != 0 && jump(*start, *end) != 0;
        offset -= 360.0 * turns as f64;
    }
    let ends_at_start = |unrolled: &[[f64; 2]]| match unrolled {
        [first, .., last] => *last == [first[0] + offset, first[1]],
        _ => false,
    };
    while after_jump || ends_at_start(&unrolled) {
        // The closing edge was the jump: the first position repeats the last.
        repeated += usize::from(!after_jump);
        after_jump = false;
        unrolled.pop();
        kept.pop();
        if let Some(last) = written.pop()
            && let Some(first) = written.first_mut()
        {
            *first = nearer_spelling(*first, last);
        }
    }
    if unrolled
        .iter()
        .any(|place| place[0].abs() > LARGEST_LONGITUDE_DEG + 360.0)
    {
        // Edges each taken the shorter way may lead further round than a file may be written.
        let back = 360.0 * (unrolled[0][0] / 360.0).round();
        for place in &mut unrolled {
            place[0] -= back;
        }
    }
    *positions = unrolled;
    *file_vertices = kept;
    (offset, written, repeated)
}

/// Of a place's longitudes on either side of a jump, the one that a ring in the other direction
/// keeps as well: a turn apart to the nearest number, they may be a last bit apart on the body.
fn nearer_spelling(a: f64, b: f64) -> f64 {
    if b.abs() < a.abs() { b } else { a }
}

/// Number of distinct positions, counting no further than 3.
fn distinct_up_to_three(positions: &[[f64; 2]]) -> usize {
    let mut seen: Vec<[f64; 2]> = Vec::with_capacity(3);
    for position in positions {
        if !seen.contains(position) {
            seen.push(*position);
            if seen.len() == 3 {
                break;
            }
        }
    }
    seen.len()
}

/// serde_json's error, with the word or number that stands at its place.
fn json_problem(text: &[u8], error: &serde_json::Error) -> RegionProblemKind {
    let (line, column) = (error.line(), error.column());
    let full = error.to_string();
    let suffix = format!(" at line {line} column {column}");
    RegionProblemKind::Json {
        line,
        column,
        message: full.strip_suffix(&suffix).unwrap_or(&full).to_owned(),
        found: word_at(text, line, column),
    }
}

/// Letters, digits and signs around a place: `NaN`, `-Infinity`, `1e999`.
fn word_at(text: &[u8], line: usize, column: usize) -> Option<String> {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let line = text
        .split(|byte| *byte == b'\n')
        .nth(line.checked_sub(1)?)?;
    let at = column.saturating_sub(1).min(line.len());
    let before = line[..at]
        .iter()
        .rev()
        .take_while(|byte| is_word(byte))
        .count();
    let after = line[at..].iter().take_while(|byte| is_word(byte)).count();
    let word = &line[at - before..at + after];
    // A longer run is a broken file, not a word worth quoting.
    (!word.is_empty() && word.len() <= 40).then(|| String::from_utf8_lossy(word).into_owned())
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

/// Any GeoJSON object: members may come in any order, so the type is known only at its end.
#[derive(serde::Deserialize)]
#[serde(expecting = "a GeoJSON object")]
struct RawObject {
    #[serde(rename = "type")]
    kind: Option<String>,
    coordinates: Option<RawCoordinates>,
    geometries: Option<Vec<RawObject>>,
    geometry: Option<Box<RawObject>>,
    features: Option<Vec<RawObject>>,
    properties: Option<RawProperties>,
    id: Option<RawLabel>,
}

impl RawObject {
    fn label(&self, index: usize) -> String {
        let from_properties = self.properties.as_ref().and_then(|p| p.label.clone());
        let from_id = self.id.as_ref().and_then(|id| id.0.clone());
        from_properties
            .or(from_id)
            .unwrap_or_else(|| unnamed(index))
    }
}

/// Properties that name a feature, best first.
const NAME_PROPERTIES: [&str; 8] = [
    "NAME",
    "name",
    "Name",
    "ADMIN",
    "admin",
    "NAME_LONG",
    "id",
    "ID",
];

/// Only the name of all the properties.
struct RawProperties {
    label: Option<String>,
}

impl<'de> Deserialize<'de> for RawProperties {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PropertiesVisitor;
        impl<'de> Visitor<'de> for PropertiesVisitor {
            type Value = RawProperties;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of properties")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut best = NAME_PROPERTIES.len();
                let mut label = None;
                while let Some(RawKey(rank)) = map.next_key()? {
                    match rank {
                        Some(rank) => {
                            let RawLabel(found) = map.next_value()?;
                            if rank < best && found.is_some() {
                                (best, label) = (rank, found);
                            }
                        }
                        None => {
                            map.next_value::<IgnoredAny>()?;
                        }
                    }
                }
                Ok(RawProperties { label })
            }
        }
        deserializer.deserialize_map(PropertiesVisitor)
    }
}

/// Rank of a property among [`NAME_PROPERTIES`], compared without copying the key.
struct RawKey(Option<usize>);

impl<'de> Deserialize<'de> for RawKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KeyVisitor;
        impl Visitor<'_> for KeyVisitor {
            type Value = RawKey;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a key")
            }

            fn visit_str<E>(self, key: &str) -> Result<RawKey, E> {
                Ok(RawKey(NAME_PROPERTIES.iter().position(|name| *name == key)))
            }
        }
        deserializer.deserialize_str(KeyVisitor)
    }
}

/// A name or number; nothing for any other kind of value and for an empty string.
struct RawLabel(Option<String>);

impl<'de> Deserialize<'de> for RawLabel {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let label = match serde_json::Value::deserialize(deserializer)? {
            serde_json::Value::String(text) if !text.trim().is_empty() => Some(text),
            serde_json::Value::Number(number) => Some(number.to_string()),
            _ => None,
        };
        Ok(Self(label))
    }
}

/// Coordinates of any depth. Third and further numbers of a position are dropped while reading.
enum RawCoordinates {
    Position([f64; 2]),
    List(Vec<RawCoordinates>),
    Number(f64),
    Other(Box<str>),
}

impl RawCoordinates {
    fn describe(&self) -> String {
        match self {
            Self::Position(_) => "a position".to_owned(),
            Self::List(list) if list.is_empty() => "an empty list".to_owned(),
            Self::List(_) => "a list of lists".to_owned(),
            Self::Number(value) => format!("the number {value}"),
            Self::Other(text) => text.to_string(),
        }
    }
}

impl<'de> Deserialize<'de> for RawCoordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CoordinatesVisitor)
    }
}

struct CoordinatesVisitor;

impl<'de> Visitor<'de> for CoordinatesVisitor {
    type Value = RawCoordinates;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("coordinates")
    }

    fn visit_f64<E>(self, value: f64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Number(value as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other(format!("the text \"{text}\"").into()))
    }

    fn visit_bool<E>(self, value: bool) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other(value.to_string().into()))
    }

    fn visit_unit<E>(self) -> Result<RawCoordinates, E> {
        Ok(RawCoordinates::Other("null".into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawCoordinates, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(RawCoordinates::Other("an object".into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<RawCoordinates, A::Error> {
        let longitude = match seq.next_element()? {
            None => return Ok(RawCoordinates::List(Vec::new())),
            Some(RawCoordinates::Number(longitude)) => longitude,
            Some(RawCoordinates::Other(text)) => {
                while seq.next_element::<IgnoredAny>()?.is_some() {}
                return Ok(RawCoordinates::Other(format!("{text} in a list").into()));
            }
            Some(first) => {
                let mut list = vec![first];
                while let Some(item) = seq.next_element()? {
                    list.push(item);
                }
                return Ok(RawCoordinates::List(list));
            }
        };
        let mut numbers = 1;
        let mut latitude = 0.0;
        let mut intruder = None;
        while let Some(item) = seq.next_element::<RawCoordinates>()? {
            match item {
                RawCoordinates::Number(value) if numbers == 1 => latitude = value,
                RawCoordinates::Number(_) => {}
                other => intruder = Some(other.describe()),
            }
            numbers += 1;
        }
        Ok(match intruder {
            Some(text) => RawCoordinates::Other(format!("{text} in a position").into()),
            None if numbers == 1 => RawCoordinates::Other("a position of 1 number".into()),
            None => RawCoordinates::Position([longitude, latitude]),
        })
    }
}
