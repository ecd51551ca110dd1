// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies, regions, meshing and volumes: everything about shapes on an ellipsoid, in f64.
//!
//! No GPU, and no input or output beyond parsing. Angles are radians unless a name says `_deg`;
//! lengths are metres; positions are earth-centred earth-fixed (ECEF) unless a name says otherwise.

mod body;
mod geojson;
mod mesh;
mod region;

pub use body::{Ellipsoid, Geodetic};
pub use geojson::{RegionFileError, RegionProblem, RegionProblemKind, parse_regions};
pub use mesh::{Extent, MeshOptions, OrientedBox, RegionMesh, VolumeHeights};
pub use region::{EdgeRule, Pole, Polygon, Region, Ring};
