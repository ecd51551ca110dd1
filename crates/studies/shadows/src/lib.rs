// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `shadows`: shadow volumes of ships and docks under the sun, every optimisation with its error.
//!
//! After Yang & Jin (IV'06), whose only figure is a frame rate. All of it is computed on the CPU in
//! `f64`: rays to the sun are the reference, and a volume's mask is the count of its triangles along
//! the ray of each pixel, as a stencil would hold it.

mod count;
mod near;
mod reference;
mod scissor;
mod view;

/// Name of the study.
pub const STUDY: &str = "shadows";
