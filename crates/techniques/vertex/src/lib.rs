// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes extruded in the vertex shader, on wgpu.
//!
//! A region's mesh is extruded along the geodetic normal into a closed solid: two caps and the walls
//! along its boundary. Drawn into the stencil with depth-fail counting, the solid marks the surface
//! pixels inside it, and a screen-space pass colours them. The technique is Cozzi's (2007), after
//! Heidmann (1991) and Carmack's depth-fail variant (2000); this backend is its vertex-shader form,
//! in the layouts that the document used or considered and one that duplicates no vertex.

mod cache_order;
mod layout;
mod merged;
mod parts;
mod pass;
mod pipeline;
mod technique;
mod variant;
#[cfg(test)]
mod volume_invariants;

pub use cache_order::{CACHE_SIZE, acmr, cache_ordered};
pub use layout::{FLAG_BYTES, centric_shift_m, layout_bytes, shared_flag_bytes, variant_bytes};
pub use pass::{VertexBackend, VertexVolumes};
pub use technique::VertexTechnique;
pub use variant::{
    BOTTOM_PX, Bottom, Buffers, IndexOrder, Layout, Normals, VertexOrder, VertexSize,
    VertexVariant, Walls,
};
