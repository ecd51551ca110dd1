// SPDX-License-Identifier: MIT OR Apache-2.0
//! Height files and fields of heights: one program for all tests that use the crate as others do.

mod cases;
mod field;
mod fuzz_corpus;
mod properties;
mod readers;
