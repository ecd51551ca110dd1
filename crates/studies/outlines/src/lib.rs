// SPDX-License-Identifier: MIT OR Apache-2.0
//! Outlines of many models, a part of study `shadows`: a stencil value for each model instead of a clear.
//!
//! By McGuire & Hughes (2004), as Yang & Jin (IV'06, 4.3) print it. A device draws each model with its value, then its
//! contour edges as thick strokes wherever the stencil has another one. Every pixel is held against `f64`, see `judge`.

mod contour;
mod fleet;
mod judge;
mod metrics;
mod on_wgpu;
mod plan;
mod section;
mod session;

pub use metrics::{
    MODELS, OUTLINE, OUTLINE_CPU_MS, OUTLINE_GPU_MS, SHADOW_CLEARS, SHADOW_CONTOUR_PX,
    SHADOW_OUTLINE_PX, SHADOW_OUTLINE_UNDECIDED_PX, SHADOW_OUTLINE_UNLIKE_PX, STROKE_PX,
};
pub use plan::planned;
pub use section::{SECTION, findings};
