// SPDX-License-Identifier: MIT OR Apache-2.0
//! A part of study `globes`: the tiled globe of StuCoSReC 2018, a Web Mercator map in tiles over the grid on the screen.
//!
//! - `tiles`: ways to lay tiles over a view, and which texel each pixel shows.
//! - `cells`: frames against the number of cells, the paper's only experiment.
//! - `choose`: tiles chosen by the grid's corners in each frame.
//! - `stage`: triangles split at ±180° by a geometry shader.
//! - `loading`: tiles that are files, read beside frames.
//! - `picture`: the Blue Marble in tiles.
//!
//! The study puts [`planned`] into its plan and [`SECTIONS`] into its chapter.

mod cells;
mod choose;
mod device;
mod loading;
mod mesh;
mod metrics;
mod options;
mod picture;
mod plan;
mod stage;
mod steps;
mod tile_set;
mod tiles;
mod truth;
mod views;

pub use cells::line::{Line, line};
pub use cells::{PUBLISHED_FPS, SECTION as FRAMES_BY_CELLS, published};
pub use metrics::{LATENCY_MS, LEVEL, LIMIT, LOADING, MERCATOR, SEAM, SPLIT_BY, TILES, TRANSFERS};
pub use plan::{pictured, planned};

use terrafill_lab::Section;
use terrafill_results::Metric;

/// What is measured of tiles, in the order of reports.
pub const METRICS: &[Metric] = &metrics::METRICS;

/// Sections of the study's chapter, in its order.
pub const SECTIONS: [Section<'static>; 6] = [
    tiles::SECTION,
    cells::SECTION,
    choose::SECTION,
    stage::SECTION,
    picture::SECTION,
    loading::SECTION,
];
