// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks of ground as layers of an array texture, as published, against everything else that can keep them.
//!
//! Texels of blocks are looked up by block and share of it, at borders too, and one block is written anew. The
//! reference finds the same texels by arithmetic of integers. Ground is drawn from its blocks, and rays
//! judge the pictures.

mod drawn;
mod keep;
mod on_vulkan;
mod on_wgpu;
mod queries;
mod study;

pub(crate) use drawn::drawn_groups;
pub(crate) use keep::Keep;
pub(crate) use study::group;
