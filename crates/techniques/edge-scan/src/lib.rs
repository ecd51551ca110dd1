// SPDX-License-Identifier: MIT OR Apache-2.0
//! The naive lookup, as users of globe engines build "screen-space polygons" themselves: one pass over the
//! drawn surface, in which every pixel tests every edge of every region whose box it is in.
//!
//! There are no volumes, no stencil and no tables. The cost of a pixel is the number of edges of the regions
//! around it. Pictures are approximate by nature ([`terrafill_contract::Technique::is_approximate`]): right
//! from afar, wrong where these errors can be seen:
//!
//! - A pixel's place comes from `f32` about the body's centre: half a metre. Outlines are degrees in `f32`: up to
//!   0.8 m.
//! - Angles come from the driver's arctangent, which WGSL allows an error of 4096 steps of `f32`. Mesa's is a
//!   polynomial: at 45° north, latitudes are off by some 20 m.
//! - Half floats are off by up to 7 km.

mod outline;
mod scan;
mod technique;

pub use technique::EdgeScanTechnique;

#[cfg(test)]
mod against_reference;
