// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadow volumes extruded in geometry shaders, on Vulkan itself.
//!
//! A region's mesh is stored once, 12 bytes a vertex; the geometry shader makes caps and walls of it.
//! Which of its inputs stand for walls is what the techniques differ in. `vs-control` is the
//! vertex-shader algorithm from the same WGSL as the wgpu backend's, so that "geometry shader
//! against vertex shader" is read on one API, and "Vulkan against wgpu" on one algorithm. The
//! comparison is Cozzi's (2007), whose geometry shaders ran on the first hardware that had any.

mod extrusion;
mod layout;
mod listed;
mod neighbours;
mod pass;
mod ring_order;
mod strips;
mod technique;
mod variant;

pub use extrusion::{Extrusion, Indices};
pub use layout::{native_bytes, native_layouts};
pub use pass::NativeBackend;
pub use ring_order::walls_with_other_diagonal;
pub use strips::{StripCounts, strip_counts};
pub use technique::NativeTechnique;
pub use variant::NativeVariant;
