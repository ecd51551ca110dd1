// SPDX-License-Identifier: MIT OR Apache-2.0
//! Errors of blur by so many layers, without a device: against the integral over time, and against a trail that fades.

use crate::blur::{
    BlurError, Filter, MOTION_PX, Moments, PIXELS, Resolve, error_of, fading, moment_of, starts,
};
use terrafill_results::SplitMix64;

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

/// Of a pixel, from layers that show whether its middle is covered.
fn shown(resolve: Resolve, layers: u32, pixel: u32, start: f64) -> f64 {
    // Layers are white, so light is the sum of alpha.
    let (mut light, mut all) = (0.0, 0.0);
    for layer in 0..layers {
        let weight = resolve.weight(layer, layers);
        let moment = moment_of(layer, layers);
        light += weight * Filter::Point.layer(pixel, start + MOTION_PX * moment);
        all += weight;
    }
    match resolve {
        // What no layer covers is left as it was.
        Resolve::Published => f64::from(u8::from(light > 0.0)),
        _ => light / all,
    }
}

/// Error of a resolve of so many layers against a trail that fades linearly with age.
pub(super) fn resolve_error(resolve: Resolve, layers: u32) -> BlurError {
    let mut pairs = Vec::new();
    for start in starts() {
        for pixel in 0..PIXELS {
            let place = f64::from(pixel) + 0.5;
            let exact = fading(place, start);
            if exact <= 0.0 {
                continue;
            }
            pairs.push((shown(resolve, layers, pixel, start), exact));
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
    for filter in Filter::ALL {
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

#[test]
fn the_published_resolve_is_far_from_a_fading_trail() {
    for layers in [8, 32] {
        assert!(resolve_error(Resolve::Published, layers).rms > 0.4);
        assert!(resolve_error(Resolve::OverBackground, layers).rms < 0.2);
    }
    let [few, many] = [8, 32].map(|layers| resolve_error(Resolve::CurrentFirst, layers).rms);
    assert!(many < 0.5 * few, "{few} {many}");
}
