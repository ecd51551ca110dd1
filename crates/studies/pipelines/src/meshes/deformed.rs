// SPDX-License-Identifier: MIT OR Apache-2.0
//! A model that is deformed and drawn more than once: deformed in each drawing, or once, kept by transform feedback.

mod study;
mod way;

pub(crate) use study::group;
pub(crate) use way::DeformWay;
