// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a way to shade is, and which layers it reads.

/// Name of this part in cases.
pub(crate) const PART: &str = "shading";
pub(crate) const KIND: &str = "spiral";

/// A way to shade, which pipelines are made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shading {
    pub(crate) removed: u32,
    pub(crate) by_angles: bool,
    /// Bumps are normals along ECEF axes, in place of shares of normal, tangent and binormal.
    pub(crate) is_object_space: bool,
    /// By which shares of tangent and binormal are multiplied.
    pub(crate) bump_scale: u32,
    pub(crate) fault: u32,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            removed: 0,
            by_angles: false,
            is_object_space: false,
            bump_scale: 1,
            fault: 0,
        }
    }
}

/// What a fragment looks up; numbers of bindings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layer {
    /// Colour, and water as its fourth.
    Base = 0,
    /// Shares of normal, tangent and binormal, and elevation.
    Bumps = 1,
    Clouds = 2,
    Night = 3,
    /// The bent normal itself.
    Bent = 4,
}

impl Layer {
    pub(super) const ALL: [Self; 5] = [
        Self::Base,
        Self::Bumps,
        Self::Clouds,
        Self::Night,
        Self::Bent,
    ];
}
