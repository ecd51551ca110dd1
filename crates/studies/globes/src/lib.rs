// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `globes`: which surface draws the body with which error in which time.
//!
//! Cases are surfaces through their knobs in a few views. A surface is judged by where its triangles put
//! each pixel on the body, in `f64`. Beside them stands the bare body, met by a ray for each pixel and judged
//! by the depth that the device wrote.
//!
//! The tiled globe of 2018 is a part of the study with a crate of its own, `terrafill-tiled-globe`. What all parts draw
//! and time with is `terrafill-globe-views`.

mod api;
#[cfg(test)]
mod arithmetic;
mod chapter;
mod claims;
mod controllers;
mod counts;
mod cube;
mod error;
mod expected;
mod filled;
mod list;
mod made;
mod metrics;
mod projection;
mod shading;
mod sight;
mod study;
mod wires;
mod zones;

pub use chapter::GlobesChapter;
pub use study::GlobesStudy;

use terrafill_globe_views::STUDY;
