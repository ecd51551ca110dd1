// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows of several lights: their depth maps in one pass, as published, or in a pass each, and the picture.
//!
//! Every way must leave the same depths bit for bit and the same picture, whose pixels say which lights reach
//! them. The reference follows rays to each light in `f64`.

mod cube;
mod on_vulkan;
mod reference;
mod scene;
mod soft;
mod study;
mod way;

pub(crate) use cube::cube_groups;
pub(crate) use on_vulkan::{LayerParts, OnVulkan};
pub(crate) use scene::LightColumns;
pub(crate) use soft::{ShadowFilter, soft_group};
pub(crate) use study::groups;
pub(crate) use way::LightWay;
