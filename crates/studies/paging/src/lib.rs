// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `paging`: a texture of 8,192 × 8,192 texels over the whole Earth, kept in pages in a file. Frames of a flight
//! read the pages that they are about to show into a fixed number of slots on the device.
//!
//! After Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds using Programmable Graphics Hardware", "Large
//! Textures". Places on the texture: U eastwards from −180°, V southwards from the north pole, 0 … 1.

mod chapter;
mod figures;
mod flight;
mod judge;
mod metrics;
mod page_file;
mod path;
mod picture;
mod residency;
mod stage;
mod study;
mod texture;

pub use study::PagingStudy;

/// Name of the study.
pub const STUDY: &str = "paging";
