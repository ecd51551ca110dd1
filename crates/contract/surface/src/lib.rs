// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contract of surfaces: what regions are filled on.
//!
//! A scene names a kind of surface and its parameters; [`open_surface`] finds the [`SurfaceKind`] and
//! opens a [`Surface`]. For each view the surface gives a [`SurfaceFrame`]: triangles relative to the
//! eye, as every renderer and the reference see them, and the heights between which they lie. The fill
//! sees only the depth that is left behind.
//!
//! A surface that leaves depth without triangles, such as a ray cast for each pixel, needs another form
//! of frame, in which the reference reads depth back. There is none yet.

mod blocks;
mod elevation;
mod ellipsoid;
mod kind;
mod mesh;
mod refining;
mod surface;

pub use blocks::SurfaceBlocks;
pub use elevation::read_elevation;
pub use ellipsoid::EllipsoidKind;
pub use kind::{Parameters, SurfaceKind, open_surface};
pub use mesh::SurfaceMesh;
pub use refining::{AsItIs, InBackground};
pub use surface::{
    HeightRange, PieceMemory, Refinement, Refining, Surface, SurfaceError, SurfaceFrame,
    SurfacePart,
};
