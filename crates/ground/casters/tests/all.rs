// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that cast shadows: one program for all tests that use the crate as others do.

mod cases;
mod fuzz_corpus;
mod properties;
