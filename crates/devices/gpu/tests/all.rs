// SPDX-License-Identifier: MIT OR Apache-2.0
//! wgpu on a device: one program for all tests that use the crate as others do.

mod common;
mod device;
mod evaluate;
mod footprint;
mod texture_positions_and_charts;
mod texture_routes;
mod textured;
mod volumes;
