// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the textured cover reads of each region: twin of the fixed part of `TexturedRegion` in
//! `texture/cover.wgsl`; the constants of the routes follow it. A test holds the layouts together.

use bytemuck::{Pod, Zeroable};

/// A region as the textured cover sees it. Meridian axes: body axes turned about the polar axis
/// until the anchor's longitude is 0. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TexturedRegion {
    /// The region's anchor, a point of the body's surface.
    pub anchor_m: [f32; 3],
    /// What the probe writes for the region.
    pub id: f32,
    /// Eye minus anchor.
    pub eye_m: [f32; 3],
    /// Opacity, times the picture's own.
    pub alpha: f32,
    /// Step to the pixel on the right, in the image plane at distance 1.
    pub right: [f32; 3],
    /// The body's.
    pub equatorial_radius_m: f32,
    /// Step to the pixel below, in the image plane at distance 1.
    pub down: [f32; 3],
    /// The body's first eccentricity squared.
    pub eccentricity_squared: f32,
    /// u per radian of longitude and of latitude, and at the anchor.
    pub u: [f32; 3],
    /// Distance from the eye at which nothing is left of the fill.
    pub fade_end_m: f32,
    /// v as `u`.
    pub v: [f32; 3],
    /// 1 / the length of the fade.
    pub fade_per_m: f32,
    /// Of a pattern: metres that a texel should span, per metre of distance from the eye.
    pub texel_per_m: f32,
    /// The routes' constants start at a multiple of 16 bytes.
    pub padding: [f32; 3],
}

impl TexturedRegion {
    /// `vec4f` that the fixed part takes.
    pub const VECTORS: usize = size_of::<Self>() / 16;
}
