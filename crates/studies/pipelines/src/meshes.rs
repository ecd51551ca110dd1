// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that are no terrain: bicubic patches divided by every stage, geometry images, and models that are deformed
//! and kept.

mod bezier;
mod deformed;
mod image;
mod picture;

pub(crate) use bezier::{Division, MAX_PATCH_CELLS, groups as patches, pot_mesh};
pub(crate) use deformed::{DeformWay, group as deformed};
pub(crate) use image::{CellCut, ImageWay, group as image};
pub(crate) use picture::size_of;
