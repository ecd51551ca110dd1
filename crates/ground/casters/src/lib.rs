// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that cast shadows: readers, what is wrong with one, a procedural port, silhouettes and volumes.
//!
//! Metres, `f64`, ENU axes: x along the dock, y to land, z up from the sea at the origin. Nothing here
//! draws. Facing is one bit a plane, decided once ([`Facing`]), and every method reads that bit.
//! Sources: Aldridge & Woods (2004) and Kim, Kim & Turk (2008) for the directed count of an edge.

mod lamp;
mod mesh;
mod pieces;
mod policy;
mod port;
mod read;
mod silhouette;
mod verdict;
mod volume;
mod waterline;

pub use lamp::Reach;
pub use mesh::{Caster, ConvexPart, Mesh, MeshError};
pub use policy::{Policy, Prepared};
pub use port::{PortSize, hull, port, row};
pub use read::{ModelFile, ReadError, Reading, Up};
pub use silhouette::{EdgeTable, Facing, Side, by_hash, by_stack};
pub use verdict::{Verdict, verdict};
pub use volume::{Extent, Face, LightError, Volume, VolumeTriangle, sea_level_below};
pub use waterline::feet_below_sea;
