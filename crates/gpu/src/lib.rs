// SPDX-License-Identifier: MIT OR Apache-2.0
//! wgpu device, surface pass, timing and read-back for the wgpu backends.
