// SPDX-License-Identifier: MIT OR Apache-2.0
//! One colour per region, the same in every picture.

use crate::{Frame, NO_REGION, Picture};

/// Colour of region `index`: hues a golden angle apart, so that neighbours in the file differ, in
/// three lightnesses.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "channels are clamped to 0 … 255"
)]
pub fn region_colour(index: usize) -> [u8; 3] {
    let hue = (index as f64 * 0.618_033_988_749_895).fract() * 6.0;
    let lightness = [0.62, 0.50, 0.72][index % 3];
    let chroma = 0.55 * (1.0 - (2.0_f64 * lightness - 1.0).abs());
    let second = chroma * (1.0 - (hue % 2.0 - 1.0).abs());
    let (r, g, b) = match hue as u32 {
        0 => (chroma, second, 0.0),
        1 => (second, chroma, 0.0),
        2 => (0.0, chroma, second),
        3 => (0.0, second, chroma),
        4 => (second, 0.0, chroma),
        _ => (chroma, 0.0, second),
    };
    let base = lightness - chroma / 2.0;
    [r, g, b].map(|channel| ((channel + base) * 255.0).round().clamp(0.0, 255.0) as u8)
}

/// What a colour pass writes for region `index` in a picture for people.
#[must_use]
pub fn palette_rgba(index: usize) -> [f32; 4] {
    let [r, g, b] = region_colour(index);
    [r, g, b, 255].map(|channel| f32::from(channel) / 255.0)
}

/// What a colour pass writes for region `index` in a picture to be judged: its id in three
/// channels, exact in 8-bit unorm.
#[must_use]
pub fn id_rgba(index: usize) -> [f32; 4] {
    let [r, g, b, _] = (index as u64 + 1).to_le_bytes()[..4] else {
        return [0.0; 4];
    };
    [r, g, b, 255].map(|channel| f32::from(channel) / 255.0)
}

/// Regions that [`id_rgba`] can tell apart.
pub const MAX_REGIONS: usize = (1 << 24) - 1;

/// Ids out of a picture drawn with [`id_rgba`]; alpha 0 is the surface or the sky.
#[must_use]
pub fn ids_of(picture: &Picture) -> Vec<u32> {
    let id = |pixel: &[u8]| match pixel {
        [_, _, _, 0] => NO_REGION,
        [r, g, b, _] => u32::from_le_bytes([*r, *g, *b, 0]),
        _ => NO_REGION,
    };
    picture.rgba.chunks_exact(4).map(id).collect()
}

/// A picture of a frame's ids, RGB, row 0 at the top: regions in their colours on a grey surface.
#[must_use]
pub fn paint(frame: &Frame) -> Vec<u8> {
    let pixels = frame.ids.iter().zip(&frame.surface);
    pixels
        .flat_map(|(&id, &is_surface)| match (id, is_surface) {
            (NO_REGION, true) => [92, 117, 148],
            (NO_REGION, false) => [5, 5, 10],
            (id, _) => region_colour(id as usize - 1),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_scene::ImageSize;

    #[test]
    fn neighbours_differ_and_no_region_is_grey() {
        for index in 0..500 {
            let (a, b) = (region_colour(index), region_colour(index + 1));
            let distance: i32 = (0..3)
                .map(|i| (i32::from(a[i]) - i32::from(b[i])).abs())
                .sum();
            assert!(distance > 60, "{index}: {a:?} {b:?}");
        }
    }

    #[test]
    fn a_painted_frame_has_three_bytes_a_pixel() {
        let frame = Frame {
            size: ImageSize {
                width: 3,
                height: 1,
            },
            ids: vec![0, 0, 7],
            surface: vec![true, false, true],
            non_finite: 0,
            counters: None,
            texture: None,
        };
        let rgb = paint(&frame);
        assert_eq!(rgb.len(), 9);
        assert_eq!(rgb[6..], region_colour(6));
        assert_ne!(rgb[..3], rgb[3..6]);
    }
}
