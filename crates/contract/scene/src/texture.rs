// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of a textured fill: where its texels come from, its mip levels, and where it lies.
//!
//! Texels are 8-bit sRGB (IEC 61966-2-1) with straight alpha, row 0 at the top: what a
//! `Rgba8UnormSrgb` texture holds, so a device and the reference decode the same bytes before they
//! filter. Levels are made here, once: drivers differ in how they shrink a picture, and a comparison
//! of texture coordinates must not see that. Angles in radians, lengths in metres.

use crate::data::{Folders, Verified};
use crate::{FileRead, RegionLoadError, SceneError};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Longest side of a picture, texels: what every device of WebGPU's default limits holds.
pub(crate) const MAX_SIDE_PX: u32 = 8192;

/// A picture and how regions are filled with it; checked.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneTexture {
    /// What a reader of a report must know: path of the file, or the checker's measures.
    pub source: String,
    /// Texels of all levels.
    pub image: MipChain,
    /// Whether regions share the picture or hold a copy each.
    pub share: TextureShare,
    /// Opacity, 0 to 1; times the picture's own.
    pub alpha: f64,
    /// Where the picture lies on the body.
    pub placement: TexturePlacement,
    /// Distances from the eye at which a fill begins to fade and where it is gone, metres.
    pub fade_m: Option<[f64; 2]>,
}

/// How many copies of the picture a device holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureShare {
    /// One for all regions.
    One,
    /// One for each region, as where regions have pictures of their own.
    Each,
}

impl TextureShare {
    /// Name in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::Each => "each",
        }
    }
}

/// What is seen beyond the edge of a picture that has a place of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// The picture again.
    Repeat,
    /// Nothing.
    Transparent,
}

impl Outside {
    /// Name in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Repeat => "repeat",
            Self::Transparent => "transparent",
        }
    }
}

/// Where a picture lies: `u` to the right and `v` down, from 0 to 1 over the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TexturePlacement {
    /// Over each region's own extent: `u = (λ − w) / (e − w)`, `v = (n − φ) / (n − s)`.
    Extents,
    /// At a place of its own, the same for all regions: a region that moves uncovers another part.
    /// With `x = (λ − λa) N cos φa` and `y = (φ − φa) M` metres east and north of the anchor,
    /// `u = ½ + (x cos θ − y sin θ) / width` and `v = ½ − (x sin θ + y cos θ) / height`.
    Anchor {
        /// Where the picture's middle lies, and which way is up.
        anchor: TextureAnchor,
        /// Width of the picture on the ground, metres.
        width_m: f64,
        /// Height of the picture on the ground, metres.
        height_m: f64,
        /// Beyond its edges.
        outside: Outside,
    },
    /// As [`TexturePlacement::Anchor`], repeated, with a size that follows the view: a texel spans
    /// 2ᵏ metres, and `k` is such that a pixel spans `texels_per_px` of them. The two whole levels
    /// next to `k` are blended by its fraction, so that no level appears at once.
    Pattern {
        /// Where the picture's middle lies, and which way is up.
        anchor: TextureAnchor,
        /// Texels that a pixel spans.
        texels_per_px: f64,
    },
}

/// The point that a picture's middle lies on, and its rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureAnchor {
    /// Geodetic longitude λa, radians.
    pub longitude_rad: f64,
    /// Geodetic latitude φa, radians.
    pub latitude_rad: f64,
    /// Direction of the picture's up, clockwise from north, radians.
    pub rotation_rad: f64,
}

/// A picture at every size from its own down to one texel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MipChain {
    levels: Vec<MipLevel>,
}

/// One size of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MipLevel {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a texel: sRGB red, green and blue, and straight alpha; row 0 at the top.
    pub rgba: Vec<u8>,
}

impl MipChain {
    /// Shrinks a picture by two until one texel is left.
    ///
    /// Texels are averaged in linear light, weighted by alpha, over the part of the level above
    /// that they cover: 2 × 2 texels, or three with the outer ones cut where the number is odd, as
    /// `⌊n / 2⌋` texels have to cover all n (NVIDIA, "Non-power-of-two mipmap creation", 2005). What
    /// is averaged is the level above before it was rounded to bytes.
    ///
    /// - returns: `None` unless `rgba` holds `width × height` texels and both are above 0
    #[must_use]
    pub fn new(width: u32, height: u32, rgba: Vec<u8>) -> Option<Self> {
        let texels = u64::from(width) * u64::from(height);
        if texels == 0 || rgba.len() as u64 != 4 * texels {
            return None;
        }
        let mut linear: Option<LinearLevel> = None;
        let mut levels = vec![MipLevel {
            width,
            height,
            rgba,
        }];
        while let Some(above) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
            let source = linear.take().unwrap_or_else(|| LinearLevel::of(above));
            let smaller = source.halved();
            levels.push(smaller.rounded());
            linear = Some(smaller);
        }
        Some(Self { levels })
    }

    /// From the picture itself, level 0, to one texel.
    #[must_use]
    pub fn levels(&self) -> &[MipLevel] {
        &self.levels
    }

    /// Columns and rows of level 0.
    #[must_use]
    pub fn size_px(&self) -> [u32; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// Bytes of all levels.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|l| l.rgba.len() as u64).sum()
    }
}

/// Red, green and blue in linear light times alpha, and alpha; 0 to 1.
struct LinearLevel {
    width: u32,
    height: u32,
    texels: Vec<[f32; 4]>,
}

/// Source texels that one texel of a halved row or column covers: the first, and each one's share.
type Taps = (usize, [f32; 3]);

impl LinearLevel {
    fn of(level: &MipLevel) -> Self {
        let texel = |bytes: &[u8]| {
            let alpha = f32::from(bytes[3]) / 255.0;
            let colour = |i: usize| LINEAR_OF_SRGB[usize::from(bytes[i])] * alpha;
            [colour(0), colour(1), colour(2), alpha]
        };
        Self {
            width: level.width,
            height: level.height,
            texels: level.rgba.par_chunks_exact(4).map(texel).collect(),
        }
    }

    fn halved(&self) -> Self {
        let columns = taps(self.width);
        let rows = taps(self.height);
        let stride = self.width as usize;
        let mut texels = vec![[0.0; 4]; columns.len() * rows.len()];
        let lines = texels.par_chunks_mut(columns.len()).zip(rows.par_iter());
        lines.for_each(|(line, (top, row_shares))| {
            for (texel, (left, column_shares)) in line.iter_mut().zip(&columns) {
                for (row, row_share) in row_shares.iter().enumerate() {
                    for (column, column_share) in column_shares.iter().enumerate() {
                        let share = row_share * column_share;
                        // A share of 0 may stand for a texel beyond the end.
                        if share > 0.0 {
                            let source = self.texels[(top + row) * stride + left + column];
                            for (sum, value) in texel.iter_mut().zip(source) {
                                *sum += share * value;
                            }
                        }
                    }
                }
            }
        });
        Self {
            width: (self.width / 2).max(1),
            height: (self.height / 2).max(1),
            texels,
        }
    }

    fn rounded(&self) -> MipLevel {
        let bytes = |[r, g, b, alpha]: &[f32; 4]| {
            let colour = |value: f32| {
                let straight = if *alpha > 0.0 { value / alpha } else { 0.0 };
                byte(srgb_of_linear(straight))
            };
            [colour(*r), colour(*g), colour(*b), byte(*alpha)]
        };
        let texels: Vec<[u8; 4]> = self.texels.par_iter().map(bytes).collect();
        MipLevel {
            width: self.width,
            height: self.height,
            rgba: texels.into_flattened(),
        }
    }
}

/// What each of `⌊count / 2⌋` texels covers of `count`.
fn taps(count: u32) -> Vec<Taps> {
    if count == 1 {
        return vec![(0, [1.0, 0.0, 0.0])];
    }
    let half = count / 2;
    (0..half)
        .map(|i| {
            let first = 2 * i as usize;
            if count.is_multiple_of(2) {
                return (first, [0.5, 0.5, 0.0]);
            }
            // Texel i covers from i·n/m to (i+1)·n/m with n = 2m + 1: i/m beyond the left end of
            // its first texel, 1 − (i+1)/m short of the right end of its third.
            let cut_left = i as f32 / half as f32;
            let in_third = (i + 1) as f32 / half as f32;
            let width = count as f32 / half as f32;
            (first, [1.0 - cut_left, 1.0, in_third].map(|w| w / width))
        })
        .collect()
}

#[allow(clippy::cast_possible_truncation, reason = "clamped to 0 … 255")]
fn byte(value: f32) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

/// Linear light of each 8-bit sRGB value.
static LINEAR_OF_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    let mut table = [0.0; 256];
    for (value, encoded) in table.iter_mut().zip(0_u16..) {
        let c = f32::from(encoded) / 255.0;
        *value = if c <= 0.040_45 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        };
    }
    table
});

fn srgb_of_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

/// A checker whose every cell has a colour of its own: red grows with the column, blue with the
/// row, and green alternates, so that an axis that is swapped or turned shows in one texel.
///
/// - `size`: texels of a side, a multiple of `cells`
/// - returns: `None` where it is none
#[must_use]
pub fn checker(size: u32, cells: u32) -> Option<MipChain> {
    let cell = size.checked_div(cells).filter(|&cell| cell > 0)?;
    let ramp = |index: u32| {
        // 30 to 230: 64 cells are three apart, and none is black or white.
        let value = 30 + 200 * index / (cells - 1).max(1);
        u8::try_from(value).unwrap_or(u8::MAX)
    };
    let texels: Vec<[u8; 4]> = (0..size)
        .flat_map(|y| (0..size).map(move |x| (x / cell, y / cell)))
        .map(|(column, row)| {
            let green = if (column + row) % 2 == 0 { 60 } else { 190 };
            [ramp(column), green, ramp(row), 255]
        })
        .collect();
    MipChain::new(size, size, texels.into_flattened())
}

/// Texels from one line of a hatch to the next at least: a line of one and a gap of three.
pub(crate) const MIN_HATCH_PERIOD: u32 = 4;

/// Diagonal lines, a quarter of their distance wide, with nothing between them: every side meets the
/// opposite one where the picture is repeated.
///
/// - `size`: texels of a side, a multiple of `lines`
/// - returns: `None` where it is none, or the lines are nearer than four texels
#[must_use]
pub(crate) fn hatch(size: u32, lines: u32) -> Option<MipChain> {
    let period = size.checked_div(lines)?;
    if period < MIN_HATCH_PERIOD || !size.is_multiple_of(lines) {
        return None;
    }
    let texels: Vec<[u8; 4]> = (0..size)
        .flat_map(|y| (0..size).map(move |x| x + y))
        .map(|diagonal| {
            let is_line = diagonal % period < period / MIN_HATCH_PERIOD;
            [20, 45, 110, if is_line { 255 } else { 0 }]
        })
        .collect();
    MipChain::new(size, size, texels.into_flattened())
}

/// Where a scene's picture comes from; checked.
pub(crate) enum ImageSource {
    /// A file of the data folder.
    File {
        path: String,
        sha256: String,
        how: String,
    },
    /// Made by [`checker`].
    Checker { size: u32, cells: u32 },
    /// Made by [`hatch`].
    Hatch { size: u32, lines: u32 },
}

impl ImageSource {
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File { path, .. } => path.clone(),
            Self::Checker { size, cells } => format!("checker {size}² of {cells}² cells"),
            Self::Hatch { size, lines } => format!("hatch {size}² of {lines} lines"),
        }
    }

    /// Reads or makes the picture of `scene`; of one that is read, its file too.
    ///
    /// # Errors
    /// [`SceneError::DataMissing`] if the file is not here, [`SceneError::Image`] if it is no
    /// picture.
    pub(crate) fn load(
        self,
        scene: &str,
        folders: Folders<'_>,
    ) -> Result<(MipChain, Option<FileRead>), SceneError> {
        let made = |picture: Option<MipChain>, kind: &str, message: String| {
            let picture = picture.ok_or_else(|| SceneError::Image {
                file: format!("{scene} ({kind})"),
                message,
            })?;
            Ok((picture, None))
        };
        match self {
            Self::Checker { size, cells } => {
                let problem = format!("{size} texels cannot be cut into {cells} cells");
                made(checker(size, cells), "checker", problem)
            }
            Self::Hatch { size, lines } => {
                let problem = format!("{size} texels cannot be cut into {lines} lines");
                made(hatch(size, lines), "hatch", problem)
            }
            Self::File { path, sha256, how } => {
                match folders.read(&path, &sha256).map_err(unreadable)? {
                    Verified::Bytes(bytes, sha256) => {
                        let picture = decode(&path, &bytes)?;
                        let file = FileRead {
                            path,
                            sha256,
                            warnings: Vec::new(),
                        };
                        Ok((picture, Some(file)))
                    }
                    Verified::Absent(why) => Err(SceneError::DataMissing {
                        scene: scene.to_owned(),
                        file: path,
                        sha256,
                        why,
                        how,
                    }),
                }
            }
        }
    }
}

fn unreadable(error: RegionLoadError) -> SceneError {
    SceneError::Regions(error)
}

fn decode(file: &str, bytes: &[u8]) -> Result<MipChain, SceneError> {
    let refuse = |message: String| SceneError::Image {
        file: file.to_owned(),
        message,
    };
    let picture = image::load_from_memory(bytes).map_err(|error| refuse(error.to_string()))?;
    let (width, height) = (picture.width(), picture.height());
    if width.max(height) > MAX_SIDE_PX {
        return Err(refuse(format!(
            "found {width}×{height} texels, allowed: up to {MAX_SIDE_PX} a side"
        )));
    }
    MipChain::new(width, height, picture.into_rgba8().into_raw()).ok_or_else(|| {
        refuse(format!(
            "found {width}×{height} texels, allowed: at least one"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Mean of a level in linear light, in f64, one value a channel.
    fn mean(level: &MipLevel) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for texel in level.rgba.chunks_exact(4) {
            for (sum, &value) in sums.iter_mut().zip(texel) {
                let c = f64::from(value) / 255.0;
                *sum += if c <= 0.04045 {
                    c / 12.92
                } else {
                    ((c + 0.055) / 1.055).powf(2.4)
                };
            }
        }
        sums.map(|sum| sum / f64::from(level.width * level.height))
    }

    #[test]
    fn a_hatch_is_lines_on_nothing_that_go_on_where_it_is_repeated() {
        let picture = hatch(64, 8).expect("eight texels from line to line");
        let texels = &picture.levels()[0].rgba;
        let alpha = |x: usize, y: usize| texels[4 * (64 * (y % 64) + x % 64) + 3];
        let filled = texels
            .chunks_exact(4)
            .filter(|texel| texel[3] == 255)
            .count();
        assert_eq!(filled, 64 * 64 / 4);
        for at in 0..64 {
            assert_eq!(alpha(63, at + 1), alpha(64, at), "across the edge");
        }
        // Negative controls: lines that are none, too near, or do not fit.
        assert_eq!(
            [hatch(64, 0), hatch(64, 32), hatch(64, 7)],
            [None, None, None]
        );
    }

    fn noise(width: u32, height: u32) -> MipChain {
        let mut state = 1_u32;
        let bytes = (0..4 * width * height).map(|i| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if i % 4 == 3 { 255 } else { (state >> 24) as u8 }
        });
        MipChain::new(width, height, bytes.collect()).expect("as many bytes as it needs")
    }

    /// How far any level's mean is from the picture's.
    fn mean_error(chain: &MipChain) -> f64 {
        let whole = mean(&chain.levels()[0]);
        let errors = chain.levels().iter().flat_map(|level| {
            let mean = mean(level);
            (0..3).map(move |i| (mean[i] - whole[i]).abs())
        });
        errors.fold(0.0, f64::max)
    }

    /// Half of an 8-bit step where sRGB is steepest in linear light, 2.27 a unit: what rounding
    /// alone can move the mean of a level of one texel by.
    const ROUNDING: f64 = 2.28 * 0.5 / 255.0;

    #[test]
    fn every_level_has_the_mean_of_the_picture_odd_sizes_too() {
        for (width, height) in [(64, 64), (37, 37), (45, 6), (1, 9), (7, 1), (255, 31)] {
            let chain = noise(width, height);
            let error = mean_error(&chain);
            assert!(error < ROUNDING, "{width}×{height}: {error}");
        }
        // Negative control: a row dropped, as a 2×2 box does where the number is odd.
        let mut chain = noise(37, 37);
        for texel in chain.levels[1].rgba[..4 * 18].chunks_exact_mut(4) {
            texel[..3].fill(255);
        }
        assert!(mean_error(&chain) > ROUNDING);
    }

    #[test]
    fn averages_are_of_light_and_not_of_bytes() {
        let black_and_white = vec![0, 0, 0, 255, 255, 255, 255, 255];
        let chain = MipChain::new(2, 1, black_and_white).expect("two texels");
        // Half the light of white is sRGB 188; half the bytes would be 128.
        assert_eq!(chain.levels()[1].rgba, [188, 188, 188, 255]);
        assert!(chain.size_px() == [2, 1] && chain.bytes() == 12);
    }

    #[test]
    fn colours_that_cannot_be_seen_do_not_bleed() {
        let red_and_nothing = vec![200, 0, 0, 255, 0, 255, 0, 0];
        let chain = MipChain::new(2, 1, red_and_nothing).expect("two texels");
        assert_eq!(chain.levels()[1].rgba, [200, 0, 0, 128]);
    }

    #[test]
    fn the_shares_of_an_odd_row_cover_it_evenly() {
        for count in [2, 3, 5, 8, 13, 255] {
            let mut covered = vec![0.0_f64; count as usize];
            for (first, shares) in taps(count) {
                let sum: f32 = shares.iter().sum();
                assert!((sum - 1.0).abs() < 1e-6, "{count}: {shares:?}");
                for (k, share) in shares.into_iter().enumerate().filter(|(_, s)| *s > 0.0) {
                    covered[first + k] += f64::from(share);
                }
            }
            let each = f64::from(count / 2) / f64::from(count);
            for share in covered {
                assert!((share - each).abs() < 1e-6, "{count}: {share} of {each}");
            }
        }
    }

    #[test]
    fn levels_halve_down_to_one_texel() {
        let chain = noise(37, 6);
        let sizes: Vec<[u32; 2]> = chain.levels().iter().map(|l| [l.width, l.height]).collect();
        assert_eq!(sizes, [[37, 6], [18, 3], [9, 1], [4, 1], [2, 1], [1, 1]]);
        assert!(MipChain::new(2, 2, vec![0; 15]).is_none());
        assert!(MipChain::new(0, 2, Vec::new()).is_none());
    }

    #[test]
    fn every_cell_of_the_checker_has_its_own_colour() {
        for cells in [2, 16, 64] {
            let chain = checker(128, cells).expect("divides");
            let level = &chain.levels()[0];
            let texels: Vec<[u8; 4]> = level.rgba.as_chunks().0.to_vec();
            let colours: BTreeSet<[u8; 4]> = texels.iter().copied().collect();
            assert_eq!(colours.len(), (cells * cells) as usize);
            // Turned about its diagonal it is another picture.
            let turned = (0..128 * 128).map(|i| texels[(i % 128) * 128 + i / 128]);
            assert_ne!(turned.collect::<Vec<_>>(), texels);
        }
    }

    #[test]
    fn a_file_that_is_no_picture_is_refused_with_its_name() {
        let error = decode("a.png", b"no picture")
            .expect_err("text")
            .to_string();
        assert!(error.starts_with("a.png: is no picture"), "{error}");
    }
}
