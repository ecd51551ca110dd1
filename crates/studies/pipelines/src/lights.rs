// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows of several lights: their depth maps in one pass, as published, or in a pass each, and the picture.
//!
//! Every way must leave the same depths bit for bit and the same picture, whose pixels say which lights reach
//! them. The reference follows rays to each light in `f64`.

mod on_vulkan;
mod reference;
mod scene;
mod study;
mod way;

pub(crate) use on_vulkan::{LayerParts, OnVulkan};
pub(crate) use scene::LightColumns;
pub(crate) use study::groups;
pub(crate) use way::LightWay;
