// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the fuzz targets do with their bytes: build an input, run the code, judge the outcome.
//!
//! A library of its own so that libFuzzer's two programs (`fuzz_targets/`) and the replay under
//! nextest (`tests/fuzz_corpus.rs`) run the very same checks. A refusal is no find; a panic, a
//! broken invariant, a number that is not finite, or an answer that other arithmetic contradicts is.

pub mod area;
pub mod bytes;
pub mod geojson;
pub mod mesh;
pub mod reached;
