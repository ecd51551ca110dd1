// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `globes`: which surface draws the body with which error in which time.
//!
//! Cases are surfaces through their knobs in a few views. A surface is judged by where its triangles put
//! each pixel on the body, in `f64`. Beside them stands the bare body, met by a ray for each pixel and judged
//! by the depth that the device wrote.

mod api;
#[cfg(test)]
mod arithmetic;
mod canvas;
mod chapter;
mod claims;
mod clock;
mod controllers;
mod counts;
mod error;
mod expected;
mod image;
mod list;
mod made;
mod metrics;
#[cfg(test)]
mod on_device;
mod opened;
mod projection;
mod shading;
mod sight;
mod study;
mod tiled;
mod wires;
mod zones;

pub use chapter::GlobesChapter;
pub use study::GlobesStudy;

/// Name of the study.
pub const STUDY: &str = "globes";
