// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions as people write them: polygons with holes in degrees, and the rule for their edges.
//!
//! Longitude east positive, latitude geodetic, both in degrees exactly as read. Nothing is wrapped,
//! reordered or subdivided here. So the reference renderer can judge from the same numbers that the
//! mesher starts from, without sharing any of its code.

use crate::RegionWarning;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a ring edge between two vertices *is*.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum EdgeRule {
    /// Straight in longitude and latitude as the file's numbers stand (RFC 7946 §3.1.1): an edge
    /// from 179 to −179 goes the long way round; 179 to 181 the short one.
    #[default]
    Planar,
    /// The shorter arc cut by the plane through both vertices and the body's centre. In geodetic
    /// longitude and latitude it is a great circle, since the tangents of geocentric and geodetic
    /// latitude differ by a constant factor.
    GreatEllipse,
}

impl EdgeRule {
    /// Name in scene files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::GreatEllipse => "great-ellipse",
        }
    }
}

/// Which side of a ring is inside, where it is round a pole or its orientation is asked for.
///
/// Round a pole are planar rings that end one turn on from their start ([`Ring::winding_deg`]). Of rings
/// of great ellipses it is those that have one pole on either side, and those that have both on their
/// smaller side. All others enclose their smaller side (great ellipses) or a part of the plane (planar),
/// whichever way they are written; only [`Inside::Left`] goes by how a shell is written. When both the shell
/// and a hole of a polygon part the poles, what lies between the two is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Inside {
    /// The side with the smaller area on the body, whichever way the ring is written; of halves the
    /// left one. Where a ring crosses itself, what it goes round the other way counts negative.
    #[default]
    Smaller,
    /// The left side along each shell, as RFC 7946 §3.1.6 orients them: of one written clockwise all but what
    /// it goes round. The right side of a hole that is round a pole.
    Left,
}

impl Inside {
    /// Name in scene files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Smaller => "smaller",
            Self::Left => "left",
        }
    }
}

/// Which way an edge goes that spans more than 180° of longitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Unwrap {
    /// As the numbers stand (RFC 7946 §3.1.9): from 170 to −170 the long way, over 0.
    #[default]
    Literal,
    /// Ring by ring the reading that crosses nothing and that RFC 7946 orients; as the numbers stand
    /// where that leaves both.
    Auto,
    /// The shorter way, over the antimeridian, as many files mean it that were never cut there. Edges
    /// along a pole stay as written, and an edge of a whole turn has no length.
    Shortest,
}

impl Unwrap {
    /// Name in scene files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Literal => "literal",
            Self::Auto => "auto",
            Self::Shortest => "shortest",
        }
    }
}

/// What is made of rings that cross or lie over one another.
///
/// All of them fill each single ring by the even-odd rule; they differ in what several rings make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Repair {
    /// Inside is what an odd number of the region's rings hold. What two parts cover is empty, what two
    /// holes cover is filled.
    EvenOdd,
    /// Inside is what any part covers, and a part is its shell less all of its holes: parts are joined,
    /// and so are holes, as by the method `structure` of GEOS `MakeValid`.
    Union,
    /// As [`Repair::Union`], with every hole left out.
    KeepShells,
}

impl Repair {
    /// Every one, in the order of messages.
    pub const ALL: [Self; 3] = [Self::EvenOdd, Self::Union, Self::KeepShells];

    /// Name in scene files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::EvenOdd => "even-odd",
            Self::Union => "union",
            Self::KeepShells => "keep-shells",
        }
    }

    /// What has been done to what crosses or overlaps, as warnings say it.
    #[must_use]
    pub fn effect(self) -> &'static str {
        match self {
            Self::EvenOdd => "filled by the even-odd rule",
            Self::Union => "parts and holes are joined",
            Self::KeepShells => "parts are joined",
        }
    }
}

/// A closed ring: at least 3 distinct vertices, `[longitude_deg, latitude_deg]`, first vertex not
/// repeated at the end, no two neighbours equal, every value finite, latitude within ±90.
///
/// A planar ring round a pole that was written uncut ends 360° away from where it started. Then
/// [`Ring::winding_deg`] is ±360 and the closing edge runs from the last vertex to the first one shifted
/// by that much. A ring that says so by a jump between −180 and 180 at one latitude is held the same
/// way, the vertices after the jump shifted by one turn. Jumps that cancel, such as the two in the
/// rectangle −180 … 180 × −10 … 10, are no such thing: they are edges along a parallel, and the ring is
/// held as it was written. Of a ring that goes round, two vertices and its end are enough.
#[derive(Debug, Clone)]
pub struct Ring {
    vertices_deg: Vec<[f64; 2]>,
    winding_deg: f64,
    /// Position in the file of each vertex, ascending; empty where no position was dropped.
    file_vertices: Vec<usize>,
    /// Longitude in the file of each vertex; empty where none was shifted by a turn.
    written_longitudes_deg: Vec<f64>,
    /// Collapsed holes before it in the file, which are not among the polygon's rings.
    rings_dropped_before: usize,
    /// Parts of the region before its polygon in the file that are not among the region's.
    parts_dropped_before: usize,
}

/// Where in its file a ring's vertices stand is no part of what it is, nor in which turn.
impl PartialEq for Ring {
    fn eq(&self, other: &Self) -> bool {
        self.vertices_deg == other.vertices_deg && self.winding_deg == other.winding_deg
    }
}

impl Ring {
    /// A ring from vertices already known to satisfy the type's promises.
    pub(crate) fn from_checked(vertices_deg: Vec<[f64; 2]>, winding_deg: f64) -> Self {
        Self {
            vertices_deg,
            winding_deg,
            file_vertices: Vec::new(),
            written_longitudes_deg: Vec::new(),
            rings_dropped_before: 0,
            parts_dropped_before: 0,
        }
    }

    /// With this many more holes of its polygon left out before it.
    pub(crate) fn after_dropped(self, rings: usize) -> Self {
        Self {
            rings_dropped_before: self.rings_dropped_before + rings,
            ..self
        }
    }

    /// With this many more parts of its region left out before its polygon.
    pub(crate) fn after_dropped_parts(self, parts: usize) -> Self {
        Self {
            parts_dropped_before: self.parts_dropped_before + parts,
            ..self
        }
    }

    /// Position of the ring's polygon in its region's part of the file, for one that is number
    /// `polygon` here: parts without area are not among the polygons here but count there.
    #[must_use]
    pub fn file_polygon(&self, polygon: usize) -> usize {
        polygon + self.parts_dropped_before
    }

    /// Position of the ring in its polygon's part of the file, for a ring that is number `ring`
    /// here: collapsed holes are not among the rings here but count there.
    #[must_use]
    pub fn file_ring(&self, ring: usize) -> usize {
        ring + self.rings_dropped_before
    }

    /// With the position in the file of each vertex; none if none was dropped.
    pub(crate) fn with_file_vertices(self, file_vertices: Vec<usize>) -> Self {
        debug_assert!(file_vertices.is_empty() || file_vertices.len() == self.vertices_deg.len());
        Self {
            file_vertices,
            ..self
        }
    }

    /// With the longitude in the file of each vertex; none if none was shifted.
    pub(crate) fn with_written_longitudes(self, written_longitudes_deg: Vec<f64>) -> Self {
        debug_assert!(
            written_longitudes_deg.is_empty()
                || written_longitudes_deg.len() == self.vertices_deg.len()
        );
        Self {
            written_longitudes_deg,
            ..self
        }
    }

    /// A vertex's longitude to the last bit, in whichever turn the file has it.
    ///
    /// A whole turn cannot be added without rounding, and which vertices one is added to depends on
    /// where the ring starts and which way it goes. What a place on the body is taken from must
    /// not: of a ring that goes there and back over a pole, one last bit makes a lune.
    pub(crate) fn written_longitude_deg(&self, vertex: usize) -> f64 {
        let written = self.written_longitudes_deg.get(vertex).copied();
        written.unwrap_or_else(|| self.vertices_deg[vertex][0])
    }

    /// Position in the file's ring, from 0, of a vertex: repeated ones are not among the vertices
    /// here but count there. Of several at one place it is the last, which the edge starts from.
    #[must_use]
    pub fn file_vertex(&self, vertex: usize) -> usize {
        self.file_vertices.get(vertex).copied().unwrap_or(vertex)
    }

    /// Vertices in file order.
    #[must_use]
    pub fn vertices_deg(&self) -> &[[f64; 2]] {
        &self.vertices_deg
    }

    /// 0 for an ordinary ring; ±360 when the file's ring ends one turn away from its start.
    #[must_use]
    pub fn winding_deg(&self) -> f64 {
        self.winding_deg
    }

    /// Edges in file order, the closing edge last; its end carries [`Ring::winding_deg`].
    pub fn edges_deg(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let count = self.vertices_deg.len();
        (0..count).map(move |i| {
            let start = self.vertices_deg[i];
            let end = if i + 1 < count {
                self.vertices_deg[i + 1]
            } else {
                let first = self.vertices_deg[0];
                [first[0] + self.winding_deg, first[1]]
            };
            (start, end)
        })
    }
}

/// One shell and the holes cut out of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Outer ring, either winding.
    pub shell: Ring,
    /// Inner rings, either winding.
    pub holes: Vec<Ring>,
}

impl Polygon {
    /// Shell first, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        std::iter::once(&self.shell).chain(&self.holes)
    }
}

/// One feature of a file: everything that shares a name, a colour and an id.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Region {
    /// Index of the feature in its file, from 0.
    pub index: usize,
    /// `properties.name`, `NAME`, `id` … or `feature N`.
    pub name: String,
    /// Areal parts; at least one.
    pub polygons: Vec<Polygon>,
    /// What reading and repairs put right, left out or chose.
    pub warnings: Vec<RegionWarning>,
    /// What is made of rings that cross or lie over one another, where that is not refused.
    pub repaired: Option<Repair>,
    /// Which side of a ring round a pole is inside.
    pub inside: Inside,
}

impl Region {
    /// Vertices of all rings, closings not counted.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.rings().map(|ring| ring.vertices_deg.len()).sum()
    }

    /// Edges that span more than 180° of longitude as they stand, those along a pole left out.
    #[must_use]
    pub fn long_edge_count(&self) -> usize {
        let is_long = |(start, end): &([f64; 2], [f64; 2])| {
            let along_pole = start[1].abs() == 90.0 && start[1] == end[1];
            (end[0] - start[0]).abs() > 180.0 && !along_pole
        };
        self.rings()
            .flat_map(Ring::edges_deg)
            .filter(is_long)
            .count()
    }

    /// Shells and holes of all parts.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.polygons.iter().flat_map(Polygon::rings)
    }

    /// The same edge with its ring and vertex counted as the file counts.
    pub(crate) fn in_file(&self, place: EdgePlace) -> EdgePlace {
        let polygon = self.polygons.get(place.polygon);
        let ring = polygon.and_then(|polygon| polygon.rings().nth(place.ring));
        ring.map_or(place, |ring| EdgePlace {
            polygon: ring.file_polygon(place.polygon),
            ring: ring.file_ring(place.ring),
            vertex: ring.file_vertex(place.vertex),
        })
    }
}

/// A ring edge in its file; indices count from 0, repeated positions included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct EdgePlace {
    /// Areal part of the feature.
    pub polygon: usize,
    /// Ring of the polygon; 0 is the shell.
    pub ring: usize,
    /// Vertex that the edge starts at.
    pub vertex: usize,
}

impl fmt::Display for EdgePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            polygon,
            ring,
            vertex,
        } = self;
        write!(f, "polygon {polygon}, ring {ring}, vertex {vertex}")
    }
}
