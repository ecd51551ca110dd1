// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes extruded in the vertex shader (wgpu).
