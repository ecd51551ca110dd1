// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain on a uniform grid of longitude and latitude over the whole body: elevation from files, or
//! a planet grown from a seed.

mod grid;

pub use grid::GridKind;
