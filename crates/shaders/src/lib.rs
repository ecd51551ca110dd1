// SPDX-License-Identifier: MIT OR Apache-2.0
//! The WGSL sources, imported, validated and reflected.
