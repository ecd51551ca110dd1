// SPDX-License-Identifier: MIT OR Apache-2.0
//! Variance shadows as published: the arithmetic of 25 taps in `f32`, and what a hard shadow's map misses.
//!
//! Moments of a window of 5 × 5 taps at lookup, no bias, no floor. The reference is the same formula in `f64` on
//! the same taps, by two passes.

use crate::variance::{DepthFormat, Moments, gaussian};
use terrafill_results::SplitMix64;
use terrafill_shapes::grid::nearest;

/// A window of 5 × 5.
const TAPS: usize = 25;
/// Windows of a case.
const WINDOWS: u32 = 20_000;
/// Above this share of light a pixel counts as lit, below its rest as black.
const LIT: f64 = 0.99;

/// No floor under the variance, as published: rounding may leave it below 0.
pub(super) const NO_FLOOR: f32 = f32::NEG_INFINITY;

/// Mean and variance of the taps less an offset, in the steps of the published loop.
fn moments(taps: &[f32; TAPS], offset: f32) -> [f32; 2] {
    let (mut first, mut second) = (0.0_f32, 0.0_f32);
    for tap in taps {
        let depth = tap - offset;
        first += depth / 25.0;
        second += depth * depth / 25.0;
    }
    [first, second - first * first]
}

/// Share of light, as published but for a floor under the variance.
fn light(taps: &[f32; TAPS], receiver: f32, way: Moments, floor: f32) -> f32 {
    let offset = way.offset(receiver);
    let [mean, variance] = moments(taps, offset);
    let gap = (receiver - offset) - mean;
    if gap > 0.0 {
        let variance = variance.max(floor);
        variance / (variance + gap * gap)
    } else {
        1.0
    }
}

/// Variance in `f64`, by the mean first.
fn exact_variance(taps: &[f32; TAPS]) -> f64 {
    let taps = taps.map(f64::from);
    let mean = taps.iter().sum::<f64>() / TAPS as f64;
    taps.iter().map(|tap| (tap - mean).powi(2)).sum::<f64>() / TAPS as f64
}

/// Error of the variance over many windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Of the variance, over the exact one.
    pub(super) relative_rms: f64,
    pub(super) absolute_rms: f64,
    pub(super) absolute_max: f64,
    pub(super) non_finite: u32,
}

/// Error of the variance of taps that spread by `sigma` about depths near 1.
pub(super) fn noise(way: Moments, sigma: f64) -> Noise {
    let mut random = SplitMix64::new(5);
    let (mut relative, mut absolute, mut max) = (0.0, 0.0, 0.0_f64);
    let mut non_finite = 0;
    for _ in 0..WINDOWS {
        // The last tenth of the range.
        let middle = 0.9 + 0.1 * random.unit();
        let taps: [f32; TAPS] =
            std::array::from_fn(|_| nearest(middle + sigma * gaussian(&mut random)));
        let receiver = nearest(middle + 3.0 * sigma);
        let [_, variance] = moments(&taps, way.offset(receiver));
        let exact = exact_variance(&taps);
        let error = f64::from(variance) - exact;
        if !error.is_finite() {
            non_finite += 1;
            continue;
        }
        relative += (error / exact).powi(2);
        absolute += error * error;
        max = max.max(error.abs());
    }
    let counted = f64::from(WINDOWS - non_finite);
    Noise {
        relative_rms: (relative / counted).sqrt(),
        absolute_rms: (absolute / counted).sqrt(),
        absolute_max: max,
        non_finite,
    }
}

/// Shares of pixels of a flat plane that nothing shadows, and which should all be lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LitPlane {
    /// With less than 0.99 of the light.
    pub(super) dark: f64,
    /// With less than 0.01.
    pub(super) black: f64,
    /// Outside of 0 to 1.
    pub(super) outside: f64,
    pub(super) non_finite: u32,
}

/// Light on a flat plane that faces the light: all taps have one depth, and the receiver its own
/// rounding.
pub(super) fn lit_plane(way: Moments, format: DepthFormat, floor: f32) -> LitPlane {
    let mut random = SplitMix64::new(7);
    let (mut dark, mut black, mut outside, mut non_finite) = (0_u32, 0_u32, 0_u32, 0_u32);
    for _ in 0..WINDOWS {
        let depth = 0.1 + 0.9 * random.unit();
        let taps = [format.stored(depth); TAPS];
        // Half a unit in the last place either way, as of a transformed position.
        let rounding = 1.0 + (2.0 * random.unit() - 1.0) * f64::from(f32::EPSILON) * 0.5;
        let receiver = nearest(depth * rounding);
        let share = light(&taps, receiver, way, floor);
        if !share.is_finite() {
            non_finite += 1;
            continue;
        }
        let share = f64::from(share);
        dark += u32::from(share < LIT);
        black += u32::from(share < 1.0 - LIT);
        outside += u32::from(!(0.0..=1.0).contains(&share));
    }
    let of = |count: u32| f64::from(count) / f64::from(WINDOWS);
    LitPlane {
        dark: of(dark),
        black: of(black),
        outside: of(outside),
        non_finite,
    }
}

/// Largest light where two occluders hide a place wholly: some taps see the upper one, the others the
/// lower. The right answer is 0.
///
/// - `gaps`: distance between the occluders over that from the lower one to the receiver
pub(super) fn bleeding(gaps: f64) -> f64 {
    let light = |upper: usize| {
        let share = upper as f64 / TAPS as f64;
        // From the receiver in units of its distance to the lower occluder.
        let mean = 1.0 + gaps * share;
        let variance = gaps * gaps * share * (1.0 - share);
        variance / (variance + mean * mean)
    };
    (0..=TAPS).map(light).fold(0.0, f64::max)
}

/// The supremum of [`bleeding`] over any number of taps.
pub(super) fn worst_bleeding(gaps: f64) -> f64 {
    (gaps / (gaps + 2.0)).powi(2)
}

/// What a hard shadow's map misses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HardShadow {
    /// Wrong area over perimeter times texel.
    pub(super) area_share: f64,
    /// Wrong area, as a share of the map.
    pub(super) wrong_area: f64,
    /// Largest distance of a wrong place from the shadow's edge, texels.
    pub(super) deviation_texels: f64,
}

/// Radius of the occluder in the map's plane, whose side is 1.
const RADIUS: f64 = 0.3;
/// Places of the occluder's middle that are averaged over.
const PLACES: u32 = 16;
/// Lines through each row of texels.
const LINES: u32 = 64;

/// A disc's shadow by a map of nearest texels, against the disc itself.
///
/// - `aside`: of where texels are sampled, in texels
pub(super) fn hard_shadow(texels: u32, aside: f64) -> HardShadow {
    let mut random = SplitMix64::new(11);
    let texel = 1.0 / f64::from(texels);
    let (mut wrong, mut farthest) = (0.0, 0.0_f64);
    for _ in 0..PLACES {
        let mut middle = || 0.5 + (random.unit() - 0.5) * 0.1;
        let (x, y) = (middle(), middle());
        // Half of what the disc covers of a line.
        let half = |line: f64| (RADIUS * RADIUS - (line - y).powi(2)).max(0.0).sqrt();
        for row in 0..texels {
            let first = f64::from(row) * texel;
            let sampled = half(first + (0.5 + aside) * texel);
            // Texels whose middles lie within.
            let start = ((x - sampled) / texel - 0.5 - aside).ceil() * texel;
            let end = ((x + sampled) / texel - 0.5 - aside).floor() * texel + texel;
            let shadow = if sampled > 0.0 && end > start {
                Some([start, end])
            } else {
                None
            };
            for line in 0..LINES {
                let at = first + (f64::from(line) + 0.5) / f64::from(LINES) * texel;
                let half = half(at);
                let disc = if half > 0.0 {
                    Some([x - half, x + half])
                } else {
                    None
                };
                wrong += difference(shadow, disc) * texel / f64::from(LINES);
                for end in shadow.into_iter().flatten() {
                    let away = ((end - x).powi(2) + (at - y).powi(2)).sqrt() - RADIUS;
                    farthest = farthest.max(away.abs() / texel);
                }
            }
        }
    }
    let wrong_area = wrong / f64::from(PLACES);
    let perimeter = std::f64::consts::TAU * RADIUS;
    HardShadow {
        area_share: wrong_area / (perimeter * texel),
        wrong_area,
        deviation_texels: farthest,
    }
}

/// Length of what only one of two intervals covers.
fn difference(a: Option<[f64; 2]>, b: Option<[f64; 2]>) -> f64 {
    let length = |of: Option<[f64; 2]>| of.map_or(0.0, |[start, end]| end - start);
    let both = a
        .zip(b)
        .map_or(0.0, |(a, b)| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0));
    length(a) + length(b) - 2.0 * both
}

#[test]
fn noise_is_that_of_sums_near_one_and_goes_with_the_receiver_subtracted() {
    let published = noise(Moments::Published, 1e-4);
    assert!(
        published.absolute_rms > 5e-8 && published.absolute_rms < 5e-7,
        "{published:?}"
    );
    for sigma in [1e-2, 1e-3, 1e-4] {
        let subtracted = noise(Moments::FromReceiver, sigma);
        assert!(subtracted.relative_rms <= 2e-6, "{sigma}: {subtracted:?}");
        assert_eq!(subtracted.non_finite, 0);
        // Negative control: without it the bound is missed.
        assert!(noise(Moments::Published, sigma).relative_rms > 2e-6);
    }
}

#[test]
fn a_lit_plane_has_black_pixels_without_a_floor() {
    let bare = lit_plane(Moments::Published, DepthFormat::F32, NO_FLOOR);
    assert!(bare.dark > 0.0 && bare.outside > 0.0, "{bare:?}");
    let floored = lit_plane(Moments::Published, DepthFormat::F32, 1e-7);
    assert_eq!(
        (floored.dark, floored.outside, floored.non_finite),
        (0.0, 0.0, 0)
    );
    // Negative control: what is in shadow stays dark under that floor.
    let occluded = light(&[0.5; TAPS], 0.9, Moments::Published, 1e-7);
    assert!(occluded < 1e-5, "{occluded}");
}

#[test]
fn light_bleeds_as_the_formula_says() {
    for gaps in [0.5, 1.0, 2.0, 5.0] {
        let (found, most) = (bleeding(gaps), worst_bleeding(gaps));
        assert!(
            found <= most && found > 0.97 * most,
            "{gaps}: {found} {most}"
        );
    }
    // Negative control: nothing bleeds without a second occluder.
    assert!(bleeding(0.0) <= 0.0);
}

#[test]
fn a_map_misses_a_quarter_of_a_texel_along_the_edge() {
    for texels in [256, 512] {
        let shadow = hard_shadow(texels, 0.0);
        assert!((shadow.area_share - 0.244).abs() < 0.01, "{shadow:?}");
        assert!(shadow.deviation_texels <= 0.71, "{shadow:?}");
        // Negative control: a map that is half a texel aside.
        assert!(hard_shadow(texels, 0.5).area_share > 0.3);
    }
}
