// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact f64 CPU renderer and classifier: the only judge of error.
//!
//! Per pixel: the exact ray against the surface triangles as drawn, the hit's geodetic longitude
//! and latitude, and two inside tests that share no code. Where the two differ, the pixel is
//! reported as such, never decided in silence. Small, slow and obvious comes before fast; what
//! there is of indices is held against brute force in tests.
//!
//! A textured frame also says where each pixel's texels come from, and is painted: coordinates by the
//! placement's own formula, footprints in closed form, trilinear filtering.
//!
//! Shares no meshing, projection or fill code with what it judges: of a scene it reads body,
//! parsed rings, edge rule and camera, of a frame the surface's vertices. Meshes and plan it never
//! looks at.

mod backend;
mod extent;
mod great_ellipse;
mod locator;
mod map;
mod planar;
mod point;
mod sampling;
mod sides;
mod slabs;
mod surface;
mod texture;
#[cfg(test)]
mod validation;
mod validity;

pub use backend::{CloseLook, PLACES_PER_PX, ReferenceBackend, ReferenceFrame, ReferenceScene};
pub use locator::{Location, Locator};
pub use map::MapPicture;
pub use point::LocatorError;
pub use surface::SurfaceTriangles;
