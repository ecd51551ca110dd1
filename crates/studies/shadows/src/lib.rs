// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `shadows`: shadow volumes of ships and docks under the sun, every optimisation with its error.
//!
//! After Yang & Jin (IV'06), whose only figure is a frame rate. Rays to the sun, in `f64` on the CPU, are the
//! reference. A volume's mask is the count of its triangles along the ray of each pixel, as a stencil would
//! hold it; devices draw the same volumes into a stencil. The casters are a procedural port, or a user's model.
//! Outlines by a stencil value are a part of the study with a crate of its own, `terrafill-outlines`.

mod ablation;
mod brought;
mod casting;
mod chapter;
mod counted;
mod device_map;
mod drawing;
mod eyes;
mod job;
mod lamps;
mod list;
mod loading;
mod maps;
mod metrics;
mod rivals;
mod shading;
mod silhouettes;
mod study;
mod tiling;
mod views;
mod way;
mod work;

pub use brought::model_warnings;
pub use study::ShadowsStudy;

/// Name of the study.
pub const STUDY: &str = "shadows";
