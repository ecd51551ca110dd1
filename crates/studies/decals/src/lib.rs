// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `decals`: how finely must data be divided that lies on a globe, and which error is left?
//!
//! Pictures and lines are laid over a sphere, as Gebbie and Bailey do it. A decal is a grid of cells about its own corner,
//! which the vertex stage projects; a line is a chain of segments. They are divided by a fixed number, by a formula, or by
//! counted pixels. Texels say their own address. Pictures are held in `f64` against the triangles as drawn, and
//! against the exact projection. Gebbie and Bailey, "Fast Realistic Rendering of Global Worlds using Programmable
//! Graphics Hardware".

mod cases;
mod chapter;
mod divided;
mod draws;
mod interface;
mod judge;
mod metrics;
mod on_vulkan;
mod on_wgpu;
mod pictures;
mod place;
mod study;
#[cfg(test)]
mod tests;
mod view;

pub use study::DecalsStudy;

/// Name of the study.
pub const STUDY: &str = "decals";
