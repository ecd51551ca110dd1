// SPDX-License-Identifier: MIT OR Apache-2.0
//! Errors of blur by so many layers, without a device: a bar that moves across pixels against the exact integral over
//! time.
//!
//! Pixels; a bar 20 pixels long moves by 32 while the shutter is open, full scale 1. The reference is the
//! integral in closed form: of a point's coverage an interval of time, of a pixel's an integral of that.

use crate::blur::{BlurError, Moments, error_of};
use terrafill_results::SplitMix64;

const BAR_PX: f64 = 20.0;
/// How far the bar moves, pixels.
const MOTION_PX: f64 = 32.0;
/// Places of the bar between pixels that are averaged over, apart by the golden ratio, which meets no
/// grid.
const PHASES: u32 = 64;
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// Pixels that the trail may touch.
const PIXELS: u32 = 54;

/// What a layer shows of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) enum Filter {
    /// Its middle, covered or not.
    Point,
    /// The share that is covered.
    Box,
}

impl Filter {
    /// Of a pixel, the bar beginning at `start`.
    fn layer(self, pixel: u32, start: f64) -> f64 {
        let left = f64::from(pixel);
        match self {
            Self::Point => {
                let middle = left + 0.5;
                f64::from(u8::from(middle >= start && middle < start + BAR_PX))
            }
            Self::Box => ((left + 1.0).min(start + BAR_PX) - left.max(start)).max(0.0),
        }
    }

    /// Mean of the layers of all moments.
    fn exact(self, pixel: u32, start: f64) -> f64 {
        let left = f64::from(pixel);
        match self {
            Self::Point => covered(left + 0.5, start),
            // The integral over the pixel of what each of its points has.
            Self::Box => covered_until(left + 1.0, start) - covered_until(left, start),
        }
    }
}

/// Share of the time in which a point is covered.
fn covered(place: f64, start: f64) -> f64 {
    let reached = ((place - start - BAR_PX) / MOTION_PX).clamp(0.0, 1.0);
    let left = ((place - start) / MOTION_PX).clamp(0.0, 1.0);
    left - reached
}

/// Integral of [`covered`] from far to the left.
fn covered_until(place: f64, start: f64) -> f64 {
    let ramp = |from: f64| {
        // Integral of the clamped ramp that begins there.
        let along = (place - from) / MOTION_PX;
        let rising = along.clamp(0.0, 1.0);
        MOTION_PX * (0.5 * rising * rising + (along - 1.0).max(0.0))
    };
    ramp(start) - ramp(start + BAR_PX)
}

/// Odd multiples of 1/256 pixel, which devices' grids of places have, so that no edge meets a pixel's middle.
fn starts() -> impl Iterator<Item = f64> {
    (0..PHASES)
        .map(|phase| ((f64::from(phase) * GOLDEN).fract() * 128.0).floor() / 128.0 + 1.0 / 256.0)
}

/// Error of the mean of so many layers.
pub(super) fn blur_error(filter: Filter, moments: Moments, layers: u32) -> BlurError {
    let mut random = SplitMix64::new(3);
    let mut pairs = Vec::new();
    for start in starts() {
        for pixel in 0..PIXELS {
            let exact = filter.exact(pixel, start);
            if exact <= 0.0 {
                continue;
            }
            let moments = moments.all(layers, &mut random);
            let shown = moments
                .iter()
                .map(|moment| filter.layer(pixel, start + MOTION_PX * moment));
            pairs.push((shown.sum::<f64>() / f64::from(layers), exact));
        }
    }
    error_of(pairs.into_iter())
}

fn slope(filter: Filter, moments: Moments, layers: [u32; 2]) -> f64 {
    let [few, many] = layers.map(|layers| blur_error(filter, moments, layers).rms);
    (many / few).ln() / (f64::from(layers[1]) / f64::from(layers[0])).ln()
}

#[test]
fn the_integrals_are_those_of_many_moments() {
    for filter in [Filter::Point, Filter::Box] {
        for pixel in [0, 3, 20, 31, 33, 51] {
            let count = 100_000;
            let moments = (0..count).map(|i| (f64::from(i) + 0.5) / f64::from(count));
            let sum: f64 = moments
                .map(|t| filter.layer(pixel, 0.3 + MOTION_PX * t))
                .sum();
            let exact = filter.exact(pixel, 0.3);
            assert!(
                (sum / f64::from(count) - exact).abs() < 2e-5,
                "{filter:?} {pixel}"
            );
        }
    }
    // Negative control: another place of the bar.
    let moved = Filter::Box.exact(20, 0.3) - Filter::Box.exact(20, 1.3);
    assert!(moved.abs() > 1e-2);
}

#[test]
fn errors_fall_by_one_order_of_points_and_two_of_boxes_at_middles() {
    let near = |found: f64, expected: f64| (found - expected).abs() < 0.15;
    let [few, many] = [64, 256].map(|n| [n, 4 * n]);
    assert!(near(slope(Filter::Point, Moments::Middle, few), -1.0));
    assert!(near(slope(Filter::Point, Moments::End, few), -1.0));
    assert!(near(slope(Filter::Box, Moments::Middle, many), -2.0));
    // Negative controls: ends of parts lose the order, and random moments a half.
    assert!(near(slope(Filter::Box, Moments::End, many), -1.0));
    assert!(near(slope(Filter::Point, Moments::Random, few), -0.5));
}
