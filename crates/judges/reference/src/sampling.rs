// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colours out of a picture: linear within its levels and between them, in `f64`.
//!
//! Texel (i, j) has its centre at `u = (i + ½) / width`, `v = (j + ½) / height`, v downwards. Bytes
//! are decoded from sRGB before anything is averaged and encoded again at the end (IEC 61966-2-1),
//! as a device does with an sRGB texture.

use terrafill_contract::AddressMode;
use terrafill_scene::{MipChain, MipLevel};

/// Red, green and blue in linear light, and alpha; 0 to 1.
pub(crate) type Rgba = [f64; 4];

/// Reads colours from the levels of a picture.
pub(crate) struct Sampler<'a> {
    levels: &'a [MipLevel],
    linear: Vec<f64>,
}

/// `a` and `b` blended, `b` at 1.
pub(crate) fn mix(a: Rgba, b: Rgba, share: f64) -> Rgba {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

/// Linear light of an sRGB value, 0 to 1.
pub(crate) fn decoded(value: f64) -> f64 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB value of linear light, 0 to 1.
pub(crate) fn encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

impl<'a> Sampler<'a> {
    pub(crate) fn new(image: &'a MipChain) -> Self {
        Self {
            levels: image.levels(),
            linear: (0..=255).map(|i| decoded(f64::from(i) / 255.0)).collect(),
        }
    }

    /// The level of detail at which a footprint of so many texels of level 0 is one texel long.
    pub(crate) fn level(&self, footprint_texels: f64) -> f64 {
        let last = (self.levels.len() - 1) as f64;
        footprint_texels.max(1.0).log2().min(last)
    }

    /// Trilinear.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "levels are few and not negative"
    )]
    pub(crate) fn sample(&self, uv: [f64; 2], level: f64, address: [AddressMode; 2]) -> Rgba {
        let outside =
            |i: usize| address[i] == AddressMode::Transparent && !(0.0..=1.0).contains(&uv[i]);
        if outside(0) || outside(1) {
            return [0.0; 4];
        }
        let finer = level.floor();
        let at = |index: f64| {
            let index = (index as usize).min(self.levels.len() - 1);
            self.bilinear(&self.levels[index], uv, address)
        };
        mix(at(finer), at(finer + 1.0), level - finer)
    }

    fn bilinear(&self, level: &MipLevel, uv: [f64; 2], address: [AddressMode; 2]) -> Rgba {
        let (columns, x) = neighbours(uv[0], level.width, address[0]);
        let (rows, y) = neighbours(uv[1], level.height, address[1]);
        let texel = |column: f64, row: f64| self.texel(level, column, row);
        let upper = mix(texel(columns[0], rows[0]), texel(columns[1], rows[0]), x);
        let lower = mix(texel(columns[0], rows[1]), texel(columns[1], rows[1]), x);
        mix(upper, lower, y)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "whole numbers inside the level"
    )]
    fn texel(&self, level: &MipLevel, column: f64, row: f64) -> Rgba {
        let index = 4 * (row as usize * level.width as usize + column as usize);
        let byte = |i: usize| usize::from(level.rgba[index + i]);
        let colour = |i: usize| self.linear[byte(i)];
        [colour(0), colour(1), colour(2), byte(3) as f64 / 255.0]
    }
}

/// The two texels on either side of a coordinate, and the share of the second.
fn neighbours(coordinate: f64, count: u32, address: AddressMode) -> ([f64; 2], f64) {
    let count = f64::from(count);
    let position = match address {
        // Taken into one picture first: far away the half texel would be lost.
        AddressMode::Repeat => (coordinate - coordinate.floor()) * count - 0.5,
        AddressMode::ClampToEdge | AddressMode::Transparent => {
            coordinate.clamp(0.0, 1.0) * count - 0.5
        }
    };
    let first = position.floor();
    let inside = |index: f64| match address {
        AddressMode::Repeat => index.rem_euclid(count),
        AddressMode::ClampToEdge | AddressMode::Transparent => index.clamp(0.0, count - 1.0),
    };
    ([inside(first), inside(first + 1.0)], position - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLAMP: [AddressMode; 2] = [AddressMode::ClampToEdge; 2];
    const REPEAT: [AddressMode; 2] = [AddressMode::Repeat; 2];

    /// Red 0 and 255 in the upper row, green 0 and 255 in the lower.
    fn four() -> MipChain {
        let bytes = vec![
            0, 0, 0, 255, 255, 0, 0, 255, //
            0, 0, 0, 255, 0, 255, 0, 255,
        ];
        MipChain::new(2, 2, bytes).expect("four texels")
    }

    fn red_green(
        image: &MipChain,
        uv: [f64; 2],
        level: f64,
        address: [AddressMode; 2],
    ) -> [f64; 2] {
        let [r, g, _, _] = Sampler::new(image).sample(uv, level, address);
        [r, g]
    }

    #[test]
    fn centres_of_texels_are_exact_and_between_them_it_is_linear() {
        let image = four();
        let at = |uv| red_green(&image, uv, 0.0, CLAMP);
        assert_eq!(at([0.75, 0.25]), [1.0, 0.0]);
        assert_eq!(at([0.75, 0.75]), [0.0, 1.0]);
        assert_eq!(at([0.5, 0.25]), [0.5, 0.0]);
        assert_eq!(at([0.5, 0.5]), [0.25, 0.25]);
        // Beyond the edge: the edge, or the other side.
        assert_eq!(at([7.0, 0.25]), [1.0, 0.0]);
        assert_eq!(red_green(&image, [1.0, 0.25], 0.0, REPEAT), [0.5, 0.0]);
        assert_eq!(red_green(&image, [-8.25, 0.25], 0.0, REPEAT), [1.0, 0.0]);
    }

    #[test]
    fn between_levels_it_is_linear_and_the_last_is_the_mean() {
        let image = four();
        let [r0, _] = red_green(&image, [0.75, 0.25], 0.0, CLAMP);
        let [r1, g1] = red_green(&image, [0.75, 0.25], 1.0, CLAMP);
        let [half, _] = red_green(&image, [0.75, 0.25], 0.5, CLAMP);
        // A quarter of the light, as near as 8 bits of sRGB come.
        assert!((r1 - 0.25).abs() < 0.003 && r1 == g1, "{r1} {g1}");
        assert!((half - (r0 + r1) / 2.0).abs() < 1e-15);
        let sampler = Sampler::new(&image);
        assert_eq!(sampler.level(0.3), 0.0);
        assert!((sampler.level(2_f64.sqrt()) - 0.5).abs() < 1e-15);
        assert_eq!(sampler.level(1e30), 1.0);
    }

    #[test]
    fn outside_a_transparent_picture_is_nothing() {
        let image = four();
        let alpha = |uv| Sampler::new(&image).sample(uv, 0.0, [AddressMode::Transparent; 2])[3];
        assert_eq!([alpha([1.0, 0.0]), alpha([0.5, 0.5])], [1.0, 1.0]);
        assert_eq!([alpha([1.001, 0.5]), alpha([0.5, -0.001])], [0.0, 0.0]);
    }

    #[test]
    fn encoding_undoes_decoding() {
        for i in 0..=255 {
            let value = f64::from(i) / 255.0;
            assert!((encoded(decoded(value)) - value).abs() < 1e-6, "{i}");
        }
        assert!((decoded(0.5) - 0.214_041_14).abs() < 1e-8);
    }
}
