// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vulkan on a device: one program for all tests that use the crate as others do.

mod culled_faces;
mod device;
mod direct;
mod volumes;
