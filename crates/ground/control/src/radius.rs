// SPDX-License-Identifier: MIT OR Apache-2.0
//! The radius of the spiral's fan, held at a wanted number of pixels.
//!
//! `delay` is the frames from drawing to using a count: 0 uses it in the very next frame, 1 is the paper's, 2 or
//! 3 are what mapping a buffer back takes.

use std::f64::consts::PI;

/// A series that repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Frames until it repeats.
    pub period: usize,
    /// From its lowest to its highest value.
    pub peak_to_peak: f64,
}

/// The paper's: the radius grows by `step` where the fan showed too few pixels, else it shrinks. It never
/// settles.
///
/// - `start`: radius less the wanted one; no whole number of steps, or a count would be neither
/// - returns: radius less the wanted one, frame by frame
#[must_use]
pub fn constant_step(delay: usize, step: f64, start: f64, frames: usize) -> Vec<f64> {
    run(delay, start, frames, |now, old| {
        now - if old > 0.0 { step } else { -step }
    })
}

/// The radius changes by `gain` times the pixels that are missing.
///
/// - `pixels`: the fan's pixels at radius 1, which grow as its square
/// - returns: radius over the wanted one, frame by frame
#[must_use]
pub fn proportional(
    delay: usize,
    gain: f64,
    (pixels, wanted_px): (f64, f64),
    start: f64,
    frames: usize,
) -> Vec<f64> {
    let wanted = (wanted_px / pixels).sqrt();
    let series = run(delay, start * wanted, frames, |now, old| {
        // A radius below 0 shows what its absolute value does.
        (now + gain * (wanted_px - pixels * old * old)).max(0.0)
    });
    series.into_iter().map(|radius| radius / wanted).collect()
}

/// The logarithm of the radius changes by `gain / 2` times that of the wanted pixels over those counted. As pixels
/// grow with the square of the radius, that is `gain` times the logarithm of the wanted radius over the old one:
/// a linear loop, the same at every altitude.
///
/// - `start`: logarithm of the radius over the wanted one
/// - returns: the same, frame by frame
#[must_use]
pub fn logarithmic(delay: usize, gain: f64, start: f64, frames: usize) -> Vec<f64> {
    run(delay, start, frames, |now, old| now - gain * old)
}

/// The gain below which [`logarithmic`] settles: `2 sin(π / (4 delay + 2))`.
#[must_use]
pub fn stable_gain(delay: usize) -> f64 {
    2.0 * (PI / (4.0 * delay as f64 + 2.0)).sin()
}

/// The largest gain with which [`logarithmic`] does not overshoot: `dᵈ / (d + 1)^(d + 1)`.
#[must_use]
pub fn gain_without_overshoot(delay: usize) -> f64 {
    let d = delay as f64;
    d.powf(d) / (d + 1.0).powf(d + 1.0)
}

/// What the end of a series repeats; `None` where it does not within half of it.
#[must_use]
pub fn cycle(series: &[f64], tolerance: f64) -> Option<Cycle> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_steps_never_settle_and_swing_by_the_delay() {
        for delay in 0..4 {
            for step in [0.01, 0.3] {
                for start in [0.123, -3.21, 7.777] {
                    let series = constant_step(delay, step, start, 4000);
                    let found = cycle(&series, 1e-9).expect("it repeats");
                    let (odd, period) = ((2 * delay + 1) as f64, 4 * delay + 2);
                    eprintln!("delay {delay}, step {step}: {found:?}");
                    assert_eq!(found.period, period, "{delay} {step} {start}");
                    assert!((found.peak_to_peak - odd * step).abs() < 1e-9);
                }
            }
        }
        // Twin: a loop that settles has no swing.
        let still = cycle(&logarithmic(1, 0.25, 1.0, 4000), 1e-9).expect("it settles");
        assert!(still.period == 1 && still.peak_to_peak < 1e-9, "{still:?}");
    }

    #[test]
    fn the_logarithmic_loop_settles_below_its_limit_and_not_above() {
        for (delay, limit) in [(0, 2.0), (1, 1.0), (2, 0.618), (3, 0.445)] {
            let stated = stable_gain(delay);
            assert!((stated - limit).abs() < 1e-3, "{stated}");
            let end = |gain: f64| {
                let series = logarithmic(delay, gain, 1e-3, 6000);
                series[5000..]
                    .iter()
                    .fold(0.0, |most: f64, x| most.max(x.abs()))
            };
            let [below, above] = [0.99, 1.01].map(|share| end(share * stated));
            eprintln!(
                "delay {delay}: limit {stated:.4}; at 0.99 of it {below:.1e}, at 1.01 {above:.1e}"
            );
            assert!(
                below < 1e-6 && (above > 1.0 || above.is_nan()),
                "{delay} {below} {above}"
            );
        }
    }

    #[test]
    fn without_overshoot_it_takes_the_computed_frames_to_a_hundredth() {
        for (delay, gain, frames) in [(0, 1.0, 1), (1, 0.25, 10), (2, 0.148, 16), (3, 0.105, 23)] {
            let stated = gain_without_overshoot(delay);
            assert!((stated - gain).abs() < 1e-3, "{stated}");
            let series = logarithmic(delay, stated, 1.0, 400);
            assert!(series.iter().all(|&x| x > -1e-12), "{delay} overshoots");
            let found = series.iter().position(|&x| x <= 0.01);
            eprintln!("delay {delay}: {found:?} frames to 1 %, computed {frames}");
            assert_eq!(found, Some(frames), "{delay}");
            // Twin: with more it does.
            let more = logarithmic(delay, 1.2 * stated, 1.0, 400);
            assert!(more.iter().any(|&x| x < -1e-6), "{delay}");
        }
    }

    #[test]
    fn a_proportional_loop_tuned_at_one_altitude_breaks_at_a_quarter_of_it() {
        let wanted_px = PI * 50.0 * 50.0;
        // Pixels of a fan of radius 1 by altitude in km; the loop's gain is 2 γ √(P* · pixels).
        let pixels = |km: f64| PI * (935.3 * 6371.0 / km).powi(2);
        let gain = 0.5 / (2.0 * (wanted_px * pixels(100.0)).sqrt());
        for (km, settles) in [(100.0, true), (26.0, true), (24.0, false), (5.0, false)] {
            let series = proportional(0, gain, (pixels(km), wanted_px), 1.01, 4000);
            let end = series[3900..].iter().map(|x| (x - 1.0).abs());
            let off = end.fold(0.0, f64::max);
            eprintln!("{km} km: {off:.1e} off in the end");
            assert_eq!(off < 1e-6, settles, "{km} {off}");
        }
    }
}
