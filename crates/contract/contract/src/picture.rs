// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture read back from a device, and the region ids that its colours stand for.

use terrafill_scene::ImageSize;

/// Id of pixels that belong to no region. Region *i* of the scene has id *i* + 1.
pub const NO_REGION: u32 = 0;

/// Regions that [`crate::Colours::Ids`] can tell apart.
pub(crate) const MAX_REGIONS: usize = (1 << 24) - 1;

/// A picture read back.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Size of the others.
    pub size: ImageSize,
    /// Four bytes a pixel, row 0 at the top; alpha 0 where nothing was filled.
    pub rgba: Vec<u8>,
    /// Reversed depth, 0 where there is no surface.
    pub depth: Vec<f32>,
}

impl Picture {
    /// Its colours without alpha, three bytes a pixel.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        let mut rgb = Vec::with_capacity(self.rgba.len() / 4 * 3);
        for pixel in self.rgba.chunks_exact(4) {
            rgb.extend_from_slice(&pixel[..3]);
        }
        rgb
    }
}

/// Ids out of a picture drawn with [`crate::Colours::Ids`]; alpha 0 is the surface or the sky.
#[must_use]
pub fn ids_of(picture: &Picture) -> Vec<u32> {
    let id = |pixel: &[u8]| match pixel {
        [_, _, _, 0] => NO_REGION,
        [r, g, b, _] => u32::from_le_bytes([*r, *g, *b, 0]),
        _ => NO_REGION,
    };
    picture.rgba.chunks_exact(4).map(id).collect()
}
