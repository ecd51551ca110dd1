// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a user would take instead of shadow volumes, each in one pass over the drawn surface.
//!
//! - [`FLAT_MESH`]: the region's triangles at a stated height, the "original fill" that Cozzi
//!   (2007, 2.1.1) set out to replace. It hangs over the terrain or under it.
//! - [`DRAPED_MESH`]: the region cut along the surface's triangles as drawn in a view, on the
//!   CPU (2.1.2, first idea), and drawn a little nearer to the eye than the surface.
//! - [`MASK_TEXTURE`]: all regions drawn once into a texture over longitude and latitude, which
//!   a full-screen pass looks up by depth (2.1.2, second idea).
//!
//! Their pictures are approximate by nature: [`terrafill_contract::Technique::is_approximate`].

mod clip;
mod draped;
mod flat;
mod mask;
mod near;
mod technique;

pub use technique::{DRAPED_MESH, FLAT_MESH, MASK_TEXTURE, OverlayTechnique};

#[cfg(test)]
mod against_reference;
