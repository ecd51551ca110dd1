// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies, regions, meshing and volumes: everything about shapes on an ellipsoid, in f64.
//!
//! No GPU, and no input or output beyond parsing. Angles are radians unless a name says `_deg`;
//! lengths are metres; positions are earth-centred earth-fixed (ECEF) unless a name says otherwise.

mod antimeridian;
mod body;
mod build;
mod collapsed;
mod crossings;
mod edge;
mod footprint;
mod geojson;
mod inside;
mod invariants;
mod lens;
mod level_of_detail;
mod mesh;
mod mesh_error;
mod outline;
mod overlaps;
mod pieces;
mod region;
mod repair;
mod shape_family;
mod snap;
mod stitch;
mod triangulate;
mod warning;

pub use body::{Ellipsoid, Geodetic};
pub use footprint::{
    ConeEdge, Footprint, FootprintError, FootprintMesher, MovingFootprint, SensorCone,
};
pub use geojson::{
    Reading, RegionFile, RegionFileError, RegionProblem, RegionProblemKind, parse_regions,
    printable, read_region_file, read_regions_as, wide_encoding,
};
pub use inside::{RingSide, SideChoice};
pub use invariants::InvariantViolation;
pub use level_of_detail::{
    LeftOutRings, SharedBoundaries, SimplifiedRegions, SimplifyError, ThinnedLevel,
};
pub use mesh::{Extent, MeshOptions, OrientedBox, RegionMesh, VolumeHeights, wrapped_deg};
pub use mesh_error::MeshError;
pub use pieces::NEARLY_OPPOSITE_RAD;
pub use region::{EdgePlace, EdgeRule, Inside, Polygon, Region, Repair, Ring, Unwrap};
pub use shape_family::ShapeFamily;
pub use terrafill_planar::{index_u32, nearest_f32};
pub use warning::{RegionWarning, WarningSubject};
