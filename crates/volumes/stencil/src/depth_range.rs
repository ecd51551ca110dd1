// SPDX-License-Identifier: MIT OR Apache-2.0
//! The range of the surface's depth in which a volume can lie at all.
//!
//! Where the surface is nearer than the volume or farther, every ray crosses the volume an
//! even number of times on either side. So its fragments may be dropped before they touch the
//! stencil. The range is that of the corners of a box that holds the volume, along the viewing
//! direction; with reversed depth the farthest corner gives the lower end.

/// Reversed depth, `0 ≤ low ≤ high ≤ 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthRange {
    /// At the farthest corner, or below.
    pub low: f32,
    /// At the nearest corner, or above.
    pub high: f32,
}

impl DepthRange {
    /// Every depth there is.
    pub const ANY: Self = Self {
        low: 0.0,
        high: 1.0,
    };
}
