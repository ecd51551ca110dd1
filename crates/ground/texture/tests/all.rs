// SPDX-License-Identifier: MIT OR Apache-2.0
//! Precision of positions in textures: one program for all tests that use the crate as others do.

mod charts;
mod choose;
mod choose_from_pixels;
mod naga_says;
mod position;
mod routes;
