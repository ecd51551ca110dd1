// SPDX-License-Identifier: MIT OR Apache-2.0
//! Geometry images: an irregular mesh of a closed surface made into a square of places, and drawn by every stage that
//! can fetch them.

mod study;
mod way;

pub(crate) use study::group;
pub(crate) use terrafill_shapes::square::{CellCut, rabbit_mesh};
pub(crate) use way::ImageWay;
