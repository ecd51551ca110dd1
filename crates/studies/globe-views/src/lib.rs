// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the parts of study `globes` draw with: views of a globe, a canvas on wgpu, surfaces opened once. And what they
//! measure with: the watch of a frame's steps, and figures of a picture's pixels.

mod canvas;
mod clock;
mod fingerprint;
mod image;
mod metrics;
mod opened;
mod pixels;
mod view;

pub use canvas::{
    Canvas, Stages, no_triangles, texture, uniform, vertices, view_constants, write_layers, written,
};
pub use clock::{DRAW, FRAME, FrameWatch, MAKE, compared_in, draw, whole};
pub use fingerprint::{OTHER_TRIANGLES, fingerprint};
pub use image::write_png;
pub use metrics::{
    CELLS, GLOBE_DRAW_CPU_MS, GLOBE_DRAW_GPU_MS, GLOBE_MAKE_CPU_MS, GLOBE_TRIANGLES,
    GLOBE_UPLOAD_BYTES, GLOBE_UPLOAD_CPU_MS, GLOBE_VERTICES, GLOBE_WHOLE_CPU_MS,
    GLOBE_WHOLE_GPU_MS, METRICS, PATH, PICTURES, pixels,
};
pub use opened::{Opened, left_out, no_kind};
pub use pixels::{SNAPPED_PX, around, quantiles, shares};
pub use view::{Eye, ViewRow};

/// Name of the study that cases of all parts are of.
pub const STUDY: &str = "globes";
