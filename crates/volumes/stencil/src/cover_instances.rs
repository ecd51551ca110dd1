// SPDX-License-Identifier: MIT OR Apache-2.0
//! Covers as instances of one draw: a rectangle each, and whose colour it brings.
//!
//! A scissor is state that is set anew for each cover; a rectangle of the same pixels is data. Its corners
//! lie on those of pixels, so that no pixel's centre is near an edge.

use crate::{FillPass, FillProgram, FillStep, VolumeList};
use bytemuck::{Pod, Zeroable};
use terrafill_core::nearest_f32;
use terrafill_plan::PixelRect;
use terrafill_scene::ImageSize;

/// One cover, as the vertex stage reads it: attributes 0 and 1 of `rectangle_main` in `vertex/cover.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CoverInstance {
    /// Left, bottom, right and top edge in clip space, where y goes up.
    pub edges: [f32; 4],
    /// Index of the volume whose colour it brings.
    pub volume: u32,
}

impl CoverInstance {
    /// Bytes from one to the next.
    pub const STRIDE: u64 = size_of::<Self>() as u64;

    /// Bytes of these, and zeros up to the next power of two of them: room for those of a view a little different,
    /// so that a flight seldom makes a buffer.
    #[must_use]
    pub fn bytes_with_room(instances: &[Self]) -> Vec<u8> {
        let mut bytes: Vec<u8> = bytemuck::cast_slice(instances).to_vec();
        bytes.resize(instances.len().next_power_of_two() * size_of::<Self>(), 0);
        bytes
    }

    /// The pixels of `rect`.
    #[must_use]
    pub fn new(rect: PixelRect, size: ImageSize, volume: u32) -> Self {
        let across =
            |pixels: u32| nearest_f32(2.0 * f64::from(pixels) / f64::from(size.width) - 1.0);
        let up = |pixels: u32| nearest_f32(1.0 - 2.0 * f64::from(pixels) / f64::from(size.height));
        Self {
            edges: [
                across(rect.left),
                up(rect.bottom),
                across(rect.right),
                up(rect.top),
            ],
            volume,
        }
    }
}

impl FillProgram {
    /// An instance for each rectangle of a cover that is a triangle over the screen, in the order of the steps.
    #[must_use]
    pub fn cover_instances(&self, list: &VolumeList) -> Vec<CoverInstance> {
        let mut instances = Vec::new();
        for step in self.passes.iter().flat_map(FillPass::steps) {
            if let FillStep::Cover(cover) = step {
                for &volume in cover.volumes {
                    let number = u32::try_from(volume).unwrap_or(u32::MAX);
                    let rects = list.cover_rects(volume, cover.scissor);
                    instances.extend(rects.map(|rect| CoverInstance::new(rect, list.size, number)));
                }
            }
        }
        instances
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_on_those_of_pixels_and_centres_well_inside() {
        // As a rasteriser finds them: clip space scaled to pixels in 32 bits.
        let pixels = |clip: f32, count: u32| (clip * 0.5 + 0.5) * count as f32;
        for size in [1, 3, 256, 1000, 1023, 4096, 16_384] {
            let image = ImageSize::new(size, size);
            for first in [0, 1, size / 3, size - 1] {
                let rect = PixelRect {
                    left: first,
                    top: first,
                    right: size,
                    bottom: first + 1,
                };
                let [left, bottom, right, top] = CoverInstance::new(rect, image, 7).edges;
                let found = [
                    pixels(left, size),
                    pixels(right, size),
                    pixels(-top, size),
                    pixels(-bottom, size),
                ];
                let wanted = [rect.left, rect.right, rect.top, rect.bottom];
                for (found, wanted) in found.into_iter().zip(wanted) {
                    let off = (f64::from(found) - f64::from(wanted)).abs();
                    assert!(off < 1.0 / 256.0, "{size} {rect:?}: off by {off}");
                }
                // Negative control: the rectangle of the next pixel is another one.
                let next = PixelRect {
                    bottom: rect.bottom + 1,
                    ..rect
                };
                assert_ne!(CoverInstance::new(next, image, 7).edges[1], bottom);
            }
        }
    }
}
