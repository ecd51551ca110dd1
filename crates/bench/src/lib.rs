// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs cases and writes raw rows.
//!
//! For each scene and view: the reference judges once; every case draws a probe frame that is
//! compared with it; then all cases and the two baselines are timed in rounds, so that whatever
//! else the machine does falls on all of them alike. Every sample is kept and flushed.

mod cases;
mod environment;
mod group;
mod growth;
mod images;
mod options;
mod runner;
mod scenes;
mod summary;

pub use cases::{BenchCase, SceneGroup, Technique, group_cases};
pub use environment::environment;
pub use options::{BenchError, BenchOptions, Shard};
pub use runner::{BenchOutcome, run};
pub use scenes::open_scene;
