// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions as people write them: polygons with holes in degrees, and the rule for their edges.
//!
//! Longitude east positive, latitude geodetic, both in degrees exactly as read: nothing is wrapped,
//! reordered or subdivided here, so the reference renderer can judge from the same numbers that the
//! mesher starts from, without sharing any of its code.

use serde::{Deserialize, Serialize};

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

/// A closed ring: at least 3 distinct vertices, `[longitude_deg, latitude_deg]`, first vertex not
/// repeated at the end, no two neighbours equal, every value finite, latitude within ±90.
///
/// A planar ring round a pole that was written uncut ends 360° away from where it started; then
/// [`Ring::winding_deg`] is ±360 and the closing edge runs from the last vertex to the first one
/// shifted by that much.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    vertices_deg: Vec<[f64; 2]>,
    winding_deg: f64,
}

impl Ring {
    /// A ring from vertices already known to satisfy the type's promises.
    pub(crate) fn from_checked(vertices_deg: Vec<[f64; 2]>, winding_deg: f64) -> Self {
        Self {
            vertices_deg,
            winding_deg,
        }
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

/// One feature of a file: everything that shares a name, a colour and an id.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Index of the feature in its file, from 0.
    pub index: usize,
    /// `properties.name`, `NAME`, `id` … or `feature N`.
    pub name: String,
    /// Areal parts; at least one.
    pub polygons: Vec<Polygon>,
    /// What was normalised silently while reading: unclosed rings, repeated points …
    pub warnings: Vec<String>,
}

impl Region {
    /// Vertices of all rings, closings not counted.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.rings().map(|ring| ring.vertices_deg.len()).sum()
    }

    /// Shells and holes of all parts.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.polygons
            .iter()
            .flat_map(|polygon| std::iter::once(&polygon.shell).chain(&polygon.holes))
    }
}
