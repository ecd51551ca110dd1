// SPDX-License-Identifier: MIT OR Apache-2.0
//! Terrain as a quadtree of height tiles: near ground in small tiles, far ground in large ones, nothing
//! where nothing is seen.

mod bounds;
mod mesh;
mod select;
mod store;
mod tile;
mod tiles;
mod tree;

pub use tiles::TilesKind;
