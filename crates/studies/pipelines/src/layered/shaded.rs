// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes of shadows whose right answer is known, and what a picture of them is held against.
//!
//! A square of 1 × 1 is seen from straight above; a light's ray moves aside by its shear a unit of depth, so
//! that a level plane lies undistorted on every map. Depths grow towards the lights.

use super::listed::{Listed, numbers_of, rectangle};
use super::variance_bounds::{TAPS, light, moments};
use crate::draws::Looked;
use crate::images::square;
use crate::lights::LightColumns;
use crate::variance::{DepthFormat, Moments, gaussian};
use bytemuck::{Pod, Zeroable};
use std::f64::consts::TAU;
use terrafill_results::SplitMix64;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::nearest;

/// A side of terraces and of rough ground, texels of the map and pixels; terraces are of 8, blocks of rough ground of 16.
const GROUND: u32 = 256;
const TERRACE: u32 = 8;
const ROUGH: u32 = 128;
const BLOCK: u32 = 16;
/// Texels that a window reaches to either side.
const REACH: u32 = 2;
/// Depths of the plane and of the disc above it, and its radius.
const PLANE: f32 = 0.2;
const DISC: f32 = 0.7;
const RADIUS: f64 = 0.3;
const SIDES: u32 = 256;
/// Pixels a side under the disc: variances, and single texels, which many pixels share.
const DISC_PIXELS: u32 = 256;
const HARD_PIXELS: u32 = 1_024;
/// By how much the rays of each light move aside a unit of depth: edges meet texels at another place each.
pub(crate) const SHEARS: [[f64; 2]; 4] = [
    [0.297, 0.103],
    [-0.211, 0.251],
    [-0.107, -0.299],
    [0.239, -0.193],
];
/// Within this of an edge, texels, devices may cover a texel or not: vertices are snapped to 1/256, or 1/16 at worst.
const BAND_TEXELS: f64 = 1.0 / 32.0;
/// Above this share a pixel is lit, below the rest black.
const LIT: f32 = 0.99;

/// What is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shade {
    /// Level terraces that nothing shadows, their depths stored in a format.
    Terraces {
        moments: Moments,
        format: DepthFormat,
        least: Option<f32>,
    },
    /// Variance of rough ground.
    Rough { moments: Moments, sigma: f64 },
    /// Light of all lights on a plane under a disc.
    Disc {
        moments: Moments,
        texels: u32,
        least: Option<f32>,
    },
    /// The same by one texel a light.
    Hard { texels: u32 },
}

/// Twin of `Shaded` in `pipelines/shaded.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ShadedConstants {
    texels: u32,
    pixels: u32,
    shows: u32,
    moments: u32,
    least: f32,
    bias: f32,
    padding: [u32; 2],
}

/// What is wrong in a shaded picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct LayerErrors {
    /// Texels of maps that are not what rays along the light meet, and pixels that no rounding explains.
    pub(crate) wrong_texels: usize,
    pub(crate) wrong: usize,
    /// Pixels that rounding leaves open.
    pub(crate) open: usize,
    pub(crate) judged: usize,
    pub(crate) non_finite: usize,
    pub(crate) figures: Vec<(&'static str, f64)>,
}

/// Depths of squares in rows, and of the places that are looked up.
struct Squares {
    depths: Vec<f32>,
    receivers: Vec<f32>,
}

fn terraces(format: DepthFormat) -> Squares {
    let mut random = SplitMix64::new(7);
    let across = GROUND / TERRACE;
    let exact: Vec<f64> = (0..across * across)
        .map(|_| 0.1 + 0.9 * random.unit())
        .collect();
    let receiver = |pixel: u32| {
        let square = pixel / GROUND / TERRACE * across + pixel % GROUND / TERRACE;
        // Half a unit in the last place either way, as of a transformed position.
        let rounding = 1.0 + (2.0 * random.unit() - 1.0) * f64::from(f32::EPSILON) * 0.5;
        nearest(exact[square as usize] * rounding)
    };
    Squares {
        receivers: (0..GROUND * GROUND).map(receiver).collect(),
        depths: exact.iter().map(|depth| format.stored(*depth)).collect(),
    }
}

fn rough(sigma: f64) -> Squares {
    let mut random = SplitMix64::new(5);
    let across = ROUGH / BLOCK;
    // Near the end of the range, with room for the spread.
    let middles: Vec<f64> = (0..across * across)
        .map(|_| 0.85 + 0.1 * random.unit())
        .collect();
    let middle = |texel: u32| {
        let block = texel / ROUGH / BLOCK * across + texel % ROUGH / BLOCK;
        middles[block as usize]
    };
    let all = 0..ROUGH * ROUGH;
    let depth = |texel| nearest((middle(texel) + sigma * gaussian(&mut random)).min(1.0));
    Squares {
        depths: all.clone().map(depth).collect(),
        receivers: all
            .map(|texel| nearest(middle(texel) - 3.0 * sigma))
            .collect(),
    }
}

/// Corners of the disc's edge.
fn rim(corner: u32) -> [f64; 2] {
    let angle = TAU * f64::from(corner % SIDES) / f64::from(SIDES);
    // Even numbers of sides have opposite corners; the middle lies off every grid.
    [0.5 + RADIUS * angle.cos(), 0.5 + RADIUS * angle.sin()].map(|at| f64::from(nearest(at)))
}

fn disc() -> Vec<[f32; 4]> {
    let mut places = rectangle([-1.0; 2], [2.0; 2], PLANE).to_vec();
    for side in 0..SIDES {
        let corners = [[0.5; 2], rim(side), rim(side + 1)];
        places.extend(corners.map(|[x, y]| [nearest(x), nearest(y), DISC, 0.0]));
    }
    places
}

/// Whether the disc lies above a place of its own depth.
fn is_under(at: [f64; 2]) -> bool {
    let [x, y] = at.map(|along| along - 0.5);
    let away = x.hypot(y);
    // Far from the rim nothing more needs to be known; its sides lie within a thousandth of the circle.
    if (away - RADIUS).abs() > 1e-3 * RADIUS {
        return away < RADIUS;
    }
    let turned = y.atan2(x).rem_euclid(TAU) / TAU * f64::from(SIDES);
    #[allow(
        clippy::cast_possible_truncation,
        reason = "from 0 to the number of sides"
    )]
    let side = turned as u32;
    let (from, to) = (rim(side), rim(side + 1));
    let along = [to[0] - from[0], to[1] - from[1]];
    along[0] * (at[1] - from[1]) - along[1] * (at[0] - from[0]) >= 0.0
}

/// Where the ray of a light from a place of the plane meets the disc's depth.
fn above(shear: [f64; 2], place: [f64; 2]) -> [f64; 2] {
    let rise = f64::from(DISC) - f64::from(PLANE);
    [0, 1].map(|axis| place[axis] - shear[axis] * rise)
}

impl Shade {
    /// Texels and pixels a side.
    fn sides(self) -> [u32; 2] {
        match self {
            Self::Terraces { .. } => [GROUND; 2],
            Self::Rough { .. } => [ROUGH; 2],
            Self::Disc { texels, .. } => [texels, DISC_PIXELS],
            Self::Hard { texels } => [texels, HARD_PIXELS],
        }
    }

    fn shears(self) -> Vec<[f64; 2]> {
        match self {
            Self::Terraces { .. } | Self::Rough { .. } => vec![[0.0; 2]],
            Self::Disc { .. } | Self::Hard { .. } => SHEARS.to_vec(),
        }
    }

    fn moments(self) -> Moments {
        match self {
            Self::Terraces { moments, .. }
            | Self::Rough { moments, .. }
            | Self::Disc { moments, .. } => moments,
            Self::Hard { .. } => Moments::Published,
        }
    }

    fn least(self) -> Option<f32> {
        match self {
            Self::Terraces { least, .. } | Self::Disc { least, .. } => least,
            Self::Rough { .. } | Self::Hard { .. } => None,
        }
    }

    fn squares(self) -> Option<Squares> {
        match self {
            Self::Terraces { format, .. } => Some(terraces(format)),
            Self::Rough { sigma, .. } => Some(rough(sigma)),
            Self::Disc { .. } | Self::Hard { .. } => None,
        }
    }

    /// Of the picture.
    pub(crate) fn size(self) -> ImageSize {
        square(self.sides()[1])
    }

    /// What is drawn.
    pub(crate) fn scene(self) -> Listed {
        let [texels, pixels] = self.sides();
        let (places, values) = match self.squares() {
            Some(Squares { depths, receivers }) => {
                let across = depths.len().isqrt();
                let place = |(number, depth): (usize, &f32)| {
                    let at = |along: usize| along as f64 / across as f64;
                    let (column, row) = (number % across, number / across);
                    let (from, to) = ([at(column), at(row)], [at(column + 1), at(row + 1)]);
                    rectangle(from, to, *depth)
                };
                let places = depths.iter().enumerate().flat_map(place);
                (places.collect(), receivers)
            }
            None => (disc(), vec![PLANE; (pixels * pixels) as usize]),
        };
        let level = f64::from(PLANE);
        let layer = |shear: [f64; 2]| LightColumns::sheared([0.0; 2], shear, level);
        let constants = ShadedConstants {
            texels,
            pixels,
            shows: match self {
                Self::Rough { .. } => 0,
                Self::Terraces { .. } | Self::Disc { .. } => 1,
                Self::Hard { .. } => 2,
            },
            moments: match self.moments() {
                Moments::Published => 0,
                Moments::AboutHalf => 1,
                Moments::FromReceiver => 2,
            },
            least: self.least().unwrap_or(-1.0),
            bias: 0.5 * (DISC - PLANE),
            padding: [0; 2],
        };
        Listed {
            places,
            layers: self.shears().into_iter().map(layer).collect(),
            side: texels,
            size: self.size(),
            values,
            picture: "pipelines/shaded.wgsl",
            constants: bytemuck::bytes_of(&constants).to_vec(),
        }
    }

    /// Holds a picture and its maps against rays and against the same formula in `f64`.
    pub(crate) fn judge(self, looked: &Looked) -> LayerErrors {
        let squares = self.squares();
        let receivers = squares.as_ref().map_or(&[][..], |of| &of.receivers[..]);
        let mut found = match self {
            Self::Terraces { .. } => self.judge_terraces(looked, receivers),
            Self::Rough { .. } => self.judge_rough(looked, receivers),
            Self::Disc { .. } => self.judge_disc(looked),
            Self::Hard { .. } => self.judge_hard(looked),
        };
        found.wrong_texels = self.wrong_texels(&looked.depths, squares.as_ref());
        found
            .figures
            .push(("variance_non_finite", found.non_finite as f64));
        found
    }

    /// Texels whose depth is not that of what a ray along the light meets first.
    fn wrong_texels(self, depths: &[f32], squares: Option<&Squares>) -> usize {
        let side = self.sides()[0];
        let layers = self.shears();
        let each = (side * side) as usize;
        let missing = depths.len().abs_diff(each * layers.len());
        let wrong = depths.iter().enumerate().filter(|(number, depth)| {
            let texel = number % each;
            let (column, row) = (texel % side as usize, texel / side as usize);
            if let Some(squares) = squares {
                let across = squares.depths.len().isqrt();
                let wide = side as usize / across;
                return **depth != squares.depths[row / wide * across + column / wide];
            }
            let Some(shear) = layers.get(number / each) else {
                return true;
            };
            let covers = |off: [f64; 2]| {
                let at = [column, row].map(|along| along as f64 + 0.5);
                let at = [0, 1].map(|axis| (at[axis] + off[axis]) / f64::from(side));
                is_under(above(*shear, at))
            };
            let steps = [-BAND_TEXELS, 0.0, BAND_TEXELS];
            let ring = steps.iter().flat_map(|x| steps.map(|y| [*x, y]));
            let is = |of: f32| depth.to_bits() == of.to_bits();
            let is_disc = is(DISC);
            let is_known = is_disc || is(PLANE);
            !is_known || !ring.into_iter().any(|off| covers(off) == is_disc)
        });
        wrong.count() + missing
    }

    /// Depths of a window around a texel of a map, borders repeated.
    fn window(self, depths: &[f32], layer: usize, middle: [u32; 2]) -> [f32; TAPS] {
        let side = self.sides()[0];
        let depths = depths
            .get(layer * (side * side) as usize..)
            .unwrap_or_default();
        std::array::from_fn(|tap| {
            let off = [tap % 5, tap / 5].map(|off| u32::try_from(off).unwrap_or(0));
            let [x, y] = [0, 1].map(|axis| {
                (middle[axis] + off[axis])
                    .saturating_sub(REACH)
                    .min(side - 1)
            });
            let number = (y * side + x) as usize;
            depths.get(number).copied().unwrap_or(f32::NAN)
        })
    }

    /// The texel of a pixel, which no rounding changes: its middle lies half a pixel off every border.
    fn texel_of(self, pixel: u32) -> [u32; 2] {
        let [texels, pixels] = self.sides();
        [pixel % pixels, pixel / pixels].map(|along| (2 * along + 1) * texels / (2 * pixels))
    }

    /// Whether a pixel's window lies within one square, where the ground is of squares.
    fn is_inside(self, pixel: u32) -> bool {
        let (pixels, square) = match self {
            Self::Terraces { .. } => (GROUND, TERRACE),
            Self::Rough { .. } => (ROUGH, BLOCK),
            Self::Disc { .. } | Self::Hard { .. } => return true,
        };
        let place = [pixel % pixels, pixel / pixels].map(|along| along % square);
        place.iter().all(|at| (REACH..square - REACH).contains(at))
    }

    /// Pixels that are judged, each with what it shows; of those that are not finite only their number.
    fn shown(self, looked: &Looked) -> (LayerErrors, Vec<(u32, f32)>) {
        let all = (0..).zip(numbers_of(&looked.picture.rgba));
        let mut pixels: Vec<(u32, f32)> = all.filter(|(pixel, _)| self.is_inside(*pixel)).collect();
        let judged = pixels.len();
        pixels.retain(|(_, shown)| shown.is_finite());
        let found = LayerErrors {
            judged,
            non_finite: judged - pixels.len(),
            ..LayerErrors::default()
        };
        (found, pixels)
    }

    fn judge_terraces(self, looked: &Looked, receivers: &[f32]) -> LayerErrors {
        let (mut found, pixels) = self.shown(looked);
        let least = self.least().map(f64::from);
        let (mut dark, mut black, mut outside) = (0, 0, 0);
        for (pixel, shown) in pixels {
            let taps = self.window(&looked.depths, 0, self.texel_of(pixel));
            let allowed = light(&taps, receivers[pixel as usize], self.moments(), least);
            found.add(allowed, shown);
            dark += usize::from(shown < LIT);
            black += usize::from(shown < 1.0 - LIT);
            outside += usize::from(!(0.0..=1.0).contains(&shown));
        }
        let share = |count: usize| count as f64 / found.judged.max(1) as f64;
        found.figures = vec![
            ("variance_dark_share", share(dark)),
            ("variance_black_px", black as f64),
            ("variance_outside_share", share(outside)),
        ];
        found
    }

    fn judge_rough(self, looked: &Looked, receivers: &[f32]) -> LayerErrors {
        let (mut found, pixels) = self.shown(looked);
        let (mut relative, mut absolute, mut max) = (0.0, 0.0, 0.0_f64);
        for (pixel, shown) in pixels {
            let taps = self.window(&looked.depths, 0, self.texel_of(pixel));
            let offset = self.moments().offset(receivers[pixel as usize]);
            let [_, variance] = moments(&taps, offset);
            found.wrong += usize::from(!variance.allows(shown));
            let error = f64::from(shown) - variance.value;
            relative += (error / variance.value).powi(2);
            absolute += error * error;
            max = max.max(error.abs());
        }
        let count = (found.judged - found.non_finite).max(1) as f64;
        found.figures = vec![
            ("variance_relative_rms", (relative / count).sqrt()),
            ("variance_absolute_rms", (absolute / count).sqrt()),
            ("variance_absolute_max", max),
        ];
        found
    }

    fn judge_disc(self, looked: &Looked) -> LayerErrors {
        let (mut found, pixels) = self.shown(looked);
        let least = self.least().map(f64::from);
        for (pixel, shown) in pixels {
            let middle = self.texel_of(pixel);
            let mut shares = (0..SHEARS.len()).map(|layer| {
                let taps = self.window(&looked.depths, layer, middle);
                light(&taps, PLANE, self.moments(), least)
            });
            let product = shares.try_fold([1.0; 2], |[low, high], share| {
                let share = share?;
                Some([low * share[0], high * share[1]])
            });
            // Four products are rounded.
            let allowed = product.map(|[low, high]| [low * (1.0 - 1e-6), high * (1.0 + 1e-6)]);
            found.add(allowed, shown);
        }
        found
    }

    fn judge_hard(self, looked: &Looked) -> LayerErrors {
        let [texels, side] = self.sides();
        let (mut found, pixels) = self.shown(looked);
        let (mut differing, mut farthest) = (0, 0.0_f64);
        for (pixel, shown) in pixels {
            let middle = self.texel_of(pixel);
            let at = |along: u32| (f64::from(along) + 0.5) / f64::from(side);
            let place = [at(pixel % side), at(pixel / side)];
            let mut mask = 0_u32;
            for (number, shear) in (0_u32..).zip(SHEARS) {
                let layer = number * texels + middle[1];
                let depth = looked.depths.get((layer * texels + middle[0]) as usize);
                let is_lit = depth.is_some_and(|depth| *depth < DISC);
                mask |= u32::from(is_lit) << number;
                let on_disc = above(shear, place);
                if is_under(on_disc) == is_lit {
                    differing += 1;
                    let away = (on_disc[0] - 0.5).hypot(on_disc[1] - 0.5) - RADIUS;
                    farthest = farthest.max(away.abs() * f64::from(texels));
                }
            }
            found.wrong += usize::from(f64::from(shown) != f64::from(mask));
        }
        let area = f64::from(differing) / f64::from(side).powi(2) / SHEARS.len() as f64;
        let perimeter = TAU * RADIUS;
        found.figures = vec![
            ("hard_wrong_area", area),
            ("hard_area_share", area * f64::from(texels) / perimeter),
            ("hard_deviation_texels", farthest),
        ];
        found
    }
}

impl LayerErrors {
    fn add(&mut self, allowed: Option<[f64; 2]>, shown: f32) {
        let shown = f64::from(shown);
        match allowed {
            None => self.open += 1,
            Some([low, high]) => self.wrong += usize::from(shown < low || shown > high),
        }
    }
}

#[cfg(test)]
mod tests;
