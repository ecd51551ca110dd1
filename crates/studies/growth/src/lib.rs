// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the cost of a mesh grows with its outline.

mod chapter;

pub use chapter::GrowthChapter;
