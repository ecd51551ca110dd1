// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain on a uniform grid of longitude and latitude over the whole body, grown from a seed.

mod grid;
mod heights;

pub use grid::GridKind;
