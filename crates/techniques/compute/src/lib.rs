// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes on wgpu whose caps and walls a compute pass makes: the geometry shader emulated.
//!
//! The device holds what a geometry shader would read (Cozzi, 2007): every vertex once, the
//! triangles of one cap, and the boundary. A compute pass turns each triangle into a top and a
//! bottom one and each boundary edge into two wall triangles, as indices over vertices that exist
//! twice only by number: 2·*vertex* on the top cap, 2·*vertex* + 1 on the bottom cap. Draws read
//! that list. It is made every frame or once, and may leave out, on the device, regions and
//! pieces that no pixel can show.

mod culling;
mod expansion;
mod layout;
mod pass;
mod pipeline;
mod technique;
mod variant;
mod volumes;

pub use expansion::Capacity;
pub use layout::{ComputeBytes, compute_bytes, placed_bytes};
pub use technique::ComputeTechnique;
pub use variant::{ComputeVariant, Expansion, GpuCulling, Transform};
pub use volumes::ComputeBackend;
