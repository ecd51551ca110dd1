// SPDX-License-Identifier: MIT OR Apache-2.0
//! The radius of the spiral's fan, held at a wanted number of pixels.
//!
//! `delay` is the frames from drawing to using a count: 0 uses it in the very next frame, 1 is the paper's, 2 or
//! 3 are what mapping a buffer back takes.

use std::f64::consts::PI;

/// A series that repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cycle {
    /// Frames until it repeats.
    pub(super) period: usize,
    /// From its lowest to its highest value.
    pub(super) peak_to_peak: f64,
}

/// The paper's: the radius grows by `step` where the fan showed too few pixels, else it shrinks. It never
/// settles.
///
/// - `start`: radius less the wanted one; no whole number of steps, or a count would be neither
/// - returns: radius less the wanted one, frame by frame
pub(super) fn constant_step(delay: usize, step: f64, start: f64, frames: usize) -> Vec<f64> {
    run(delay, start, frames, |now, old| {
        now - if old > 0.0 { step } else { -step }
    })
}

/// The logarithm of the radius changes by `gain / 2` times that of the wanted pixels over those counted. As pixels
/// grow with the square of the radius, that is `gain` times the logarithm of the wanted radius over the old one:
/// a linear loop, the same at every altitude.
///
/// - `start`: logarithm of the radius over the wanted one
/// - returns: the same, frame by frame
pub(super) fn logarithmic(delay: usize, gain: f64, start: f64, frames: usize) -> Vec<f64> {
    run(delay, start, frames, |now, old| now - gain * old)
}

/// The gain below which [`logarithmic`] settles: `2 sin(π / (4 delay + 2))`.
pub(super) fn stable_gain(delay: usize) -> f64 {
    2.0 * (PI / (4.0 * delay as f64 + 2.0)).sin()
}

/// The largest gain with which [`logarithmic`] does not overshoot: `dᵈ / (d + 1)^(d + 1)`.
pub(super) fn gain_without_overshoot(delay: usize) -> f64 {
    let d = delay as f64;
    d.powf(d) / (d + 1.0).powf(d + 1.0)
}

/// What the end of a series repeats; `None` where it does not within half of it.
pub(super) fn cycle(series: &[f64], tolerance: f64) -> Option<Cycle> {
    let half = series.len() / 2;
    let end = &series[half..];
    let repeats = |period: &usize| {
        let pairs = end.iter().zip(&end[*period..]);
        let mut differences = pairs.map(|(a, b)| (a - b).abs());
        differences.all(|difference| difference <= tolerance)
    };
    let period = (1..end.len() / 2).find(repeats)?;
    let high = end.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = end.iter().copied().fold(f64::INFINITY, f64::min);
    Some(Cycle {
        period,
        peak_to_peak: high - low,
    })
}

/// - `next`: from the value now and the one that the count is of
fn run(delay: usize, start: f64, frames: usize, next: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut series = vec![start];
    for frame in 0..frames {
        // Before there is a count, that of the first frame has to do.
        let old = series[frame.saturating_sub(delay)];
        series.push(next(series[frame], old));
    }
    series
}

#[test]
fn without_overshoot_it_takes_the_computed_frames_to_a_hundredth() {
    for (delay, gain, frames) in [(0, 1.0, 1), (1, 0.25, 10), (2, 0.148, 16), (3, 0.105, 23)] {
        let stated = gain_without_overshoot(delay);
        assert!((stated - gain).abs() < 1e-3, "{stated}");
        let series = logarithmic(delay, stated, 1.0, 400);
        assert!(series.iter().all(|&x| x > -1e-12), "{delay} overshoots");
        let found = series.iter().position(|&x| x <= 0.01);
        assert_eq!(found, Some(frames), "{delay}");
        // Negative control: with more it does.
        let more = logarithmic(delay, 1.2 * stated, 1.0, 400);
        assert!(more.iter().any(|&x| x < -1e-6), "{delay}");
    }
}
