// SPDX-License-Identifier: MIT OR Apache-2.0
//! One colour per region, the same in every picture.

use crate::{Frame, NO_REGION};

/// Colour of region `index`: hues a golden angle apart, so that neighbours in the file differ, in
/// three lightnesses.
#[must_use]
#[allow(
    clippy::cast_possible_truncation,
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

/// What a colour pass writes for a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colours {
    /// Its id in three channels, exact in 8-bit unorm: a picture to be judged.
    Ids,
    /// Its colour: a picture for people.
    Palette {
        /// 1: hides what lies under it.
        opacity: f32,
    },
}

impl Colours {
    /// RGBA of region `index`, 0 … 1.
    #[must_use]
    pub fn of(self, index: usize) -> [f32; 4] {
        let (rgb, alpha) = match self {
            Self::Ids => {
                let [r, g, b, ..] = (index as u64 + 1).to_le_bytes();
                ([r, g, b], 1.0)
            }
            Self::Palette { opacity } => (region_colour(index), opacity),
        };
        let [r, g, b] = rgb.map(|channel| f32::from(channel) / 255.0);
        [r, g, b, alpha]
    }
}

/// A picture of a frame's ids, RGB, row 0 at the top: regions in their colours on a grey surface.
#[must_use]
pub fn paint(frame: &Frame) -> Vec<u8> {
    let mut rgb = Vec::with_capacity(3 * frame.ids.len());
    // Neighbours mostly show the same region.
    let mut last = (NO_REGION, [0; 3]);
    for (&id, &is_surface) in frame.ids.iter().zip(&frame.surface) {
        let colour = match (id, is_surface) {
            (NO_REGION, true) => [92, 117, 148],
            (NO_REGION, false) => [5, 5, 10],
            (id, _) => {
                if id != last.0 {
                    last = (id, region_colour(id as usize - 1));
                }
                last.1
            }
        };
        rgb.extend_from_slice(&colour);
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::MAX_REGIONS;
    use crate::{Picture, ids_of};
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
    fn ids_travel_as_colours() {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "what an 8-bit unorm target stores"
        )]
        let stored = |rgba: [f32; 4]| rgba.map(|channel| (channel * 255.0).round() as u8);
        let indices = [0, 1, 254, 255, 256, 65_535, 65_536, MAX_REGIONS - 1];
        let rgba = |colours: Colours| -> Vec<u8> {
            indices
                .iter()
                .flat_map(|&i| stored(colours.of(i)))
                .collect()
        };
        let picture = |rgba: Vec<u8>| Picture {
            size: ImageSize::new(8, 1),
            depth: vec![1.0; rgba.len() / 4],
            rgba,
        };
        let expected = indices.map(|index| u32::try_from(index + 1).expect("24 bits"));
        assert_eq!(ids_of(&picture(rgba(Colours::Ids))), expected);
        // Negative control: colours for people are no ids, and below full opacity nor is their alpha.
        let palette = rgba(Colours::Palette { opacity: 0.5 });
        assert_ne!(ids_of(&picture(palette.clone())), expected);
        assert_eq!(palette[..4], [&region_colour(0)[..], &[128]].concat());
    }

    #[test]
    fn a_painted_frame_has_three_bytes_a_pixel() {
        let frame = Frame {
            size: ImageSize::new(3, 1),
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
