// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a region cannot be meshed: what is wrong, where in the file.

use crate::geojson::feature_label;
use crate::{EdgePlace, NEARLY_OPPOSITE_RAD};

/// Why a region cannot be meshed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// Two edges of a region cross other than at a common vertex.
    #[error(
        "{}: the edge from {first} crosses the edge from {second} at longitude \
         {longitude_deg:.7}, latitude {latitude_deg:.7}", feature_label(*feature, name)
    )]
    SelfCrossing {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// The edge that comes first in the file.
        first: EdgePlace,
        /// The other.
        second: EdgePlace,
        /// Of the crossing.
        longitude_deg: f64,
        /// Of the crossing.
        latitude_deg: f64,
    },
    /// Two parts of a region or two holes of a part lie over one another, or a hole over what is outside its
    /// shell.
    #[error(
        "{}: {} at longitude {longitude_deg:.7}, latitude {latitude_deg:.7}",
        feature_label(*feature, name), overlap_label(*first, *second)
    )]
    Overlap {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// The ring that comes first in the file; vertex 0.
        first: EdgePlace,
        /// The other; vertex 0.
        second: EdgePlace,
        /// Of a place in the midst of what both cover.
        longitude_deg: f64,
        /// Of that place.
        latitude_deg: f64,
    },
    /// More crossings than are worth listing.
    #[error(
        "{}: {}{more} more crossings",
        feature_label(*feature, name), if *counted_all { "" } else { "over " }
    )]
    MoreCrossings {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// How many are not listed.
        more: usize,
        /// Whether `more` is all of them: the search ends when it has found far too many.
        counted_all: bool,
    },
    /// An edge between points opposite to within [`NEARLY_OPPOSITE_RAD`]: any plane through them holds the
    /// centre, or all but.
    #[error(
        "{}: the great-ellipse edge from {place} joins the opposite points {start:?} and {end:?}, \
         allowed: over {NEARLY_OPPOSITE_RAD:e} rad from opposite; put a vertex between them", feature_label(*feature, name)
    )]
    OppositeEnds {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// The edge.
        place: EdgePlace,
        /// Longitude and latitude of its start, degrees.
        start: [f64; 2],
        /// Longitude and latitude of its end, degrees.
        end: [f64; 2],
    },
    /// The rings cancel one another or have no width, if only by the rounding of their coordinates.
    #[error(
        "{}: the rings enclose no area{}", feature_label(*feature, name), long_edges_label(*long_edges)
    )]
    NoArea {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// Planar edges that span more than 180° of longitude: a ring round a pole that was written
        /// without its cut goes there and back.
        long_edges: usize,
    },
    /// A knob out of its range.
    #[error("{option} is {found}; allowed is {allowed}")]
    Option {
        /// Its name in [`crate::MeshOptions`].
        option: &'static str,
        /// Its value.
        found: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// A cap step so fine for the region's area that its mesh would fill the memory.
    #[error(
        "{}: cap_step_deg is {found_deg}, which takes about {vertices:.1e} vertices; allowed are {:.0e}",
        feature_label(*feature, name), crate::triangulate::MAX_LATTICE_POINTS
    )]
    CapStep {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// The step.
        found_deg: f64,
        /// About as many vertices would stand inside.
        vertices: f64,
    },
    /// A fault of this program, not of the file.
    #[error("{}: triangulation failed: {message}", feature_label(*feature, name))]
    Triangulation {
        /// Index in the file.
        feature: usize,
        /// Its name.
        name: String,
        /// What went wrong.
        message: String,
    },
}

impl MeshError {
    /// The edge to blame, where there is one.
    #[must_use]
    pub fn place(&self) -> Option<EdgePlace> {
        match self {
            Self::SelfCrossing { first, .. } | Self::Overlap { first, .. } => Some(*first),
            Self::OppositeEnds { place, .. } => Some(*place),
            Self::MoreCrossings { .. }
            | Self::NoArea { .. }
            | Self::CapStep { .. }
            | Self::Triangulation { .. }
            | Self::Option { .. } => None,
        }
    }

    /// Index of the feature, where one is to blame.
    #[must_use]
    pub fn feature(&self) -> Option<usize> {
        match self {
            Self::SelfCrossing { feature, .. }
            | Self::Overlap { feature, .. }
            | Self::MoreCrossings { feature, .. }
            | Self::OppositeEnds { feature, .. }
            | Self::NoArea { feature, .. }
            | Self::CapStep { feature, .. }
            | Self::Triangulation { feature, .. } => Some(*feature),
            Self::Option { .. } => None,
        }
    }
}

fn long_edges_label(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => "; 1 edge spans more than 180° of longitude".to_owned(),
        _ => format!("; {count} edges span more than 180° of longitude"),
    }
}

fn overlap_label(first: EdgePlace, second: EdgePlace) -> String {
    let polygon = first.polygon;
    let (other_polygon, other) = (second.polygon, second.ring);
    if polygon != other_polygon {
        format!("polygon {polygon} and polygon {other_polygon} overlap")
    } else if first.ring > 0 {
        format!(
            "polygon {polygon}, rings {} and {other} are holes over one another",
            first.ring
        )
    } else {
        format!("polygon {polygon}, ring {other} is a hole outside its shell")
    }
}
