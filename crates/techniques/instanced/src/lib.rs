// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes whose walls are instances, on wgpu.
//!
//! Every vertex is stored once, 12 bytes, and one index list serves both caps: the bottom is the top
//! seen from behind, at another height. A wall is an instance of a strip of four corners that the
//! vertex shader makes up; the instance's attributes are the positions of the edge's two ends. So
//! walls have no indices, nothing is stored for the bottom cap, and all geometry comes by attributes,
//! none from storage buffers. It costs the ends of edges twice: each end is stored with the edge before
//! it, with the edge after it, and as a vertex of the caps.

#[cfg(test)]
mod against_reference;
mod layout;
mod pipeline;
mod technique;
mod volumes;

pub use layout::instanced_bytes;
pub use technique::InstancedTechnique;
pub use volumes::InstancedBackend;
