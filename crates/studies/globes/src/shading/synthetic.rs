// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layers of waves, for tests without data: their slopes are known, and no two places are alike.

use super::sources::{Picture, Sources};
use glam::DVec3;

/// Directions, lengths and phases of the waves: a golden-angle spiral of directions.
const WAVES: usize = 9;
const SIZE: [u32; 2] = [512, 256];

fn wave(i: usize) -> (DVec3, f64) {
    let at = i as f64 + 0.5;
    let z = 1.0 - 2.0 * at / WAVES as f64;
    let (sin, cos) = (at * 2.399_963_229_728_653).sin_cos();
    let across = (1.0 - z * z).sqrt();
    // From 3 to 11 waves round the body.
    let count = 3.0 + i as f64;
    (DVec3::new(across * cos, across * sin, z) * count, at)
}

/// Height, −1 … 1 about.
fn height(direction: DVec3) -> f64 {
    let waves = (0..WAVES).map(|i| {
        let (along, phase) = wave(i);
        (direction.dot(along) + phase).sin() / (3.0 + i as f64)
    });
    waves.sum()
}

/// 0 … 1, smooth.
fn step(from: f64, to: f64, at: f64) -> f64 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn turned(direction: DVec3) -> DVec3 {
    DVec3::new(direction.y, direction.z, direction.x)
}

/// All five.
pub(crate) fn sources() -> Sources {
    let land = |n| step(-0.1, 0.15, height(n));
    Sources {
        colour: Picture::of(SIZE, |n, _| {
            let land = land(n);
            [0.05 + 0.4 * land, 0.1 + 0.3 * land, 0.3 - 0.1 * land]
        }),
        elevation: Picture::of(SIZE, |n, _| [0.5 + 0.5 * height(n)]),
        clouds: Picture::of(SIZE, |n, _| [0.9 * step(0.1, 0.8, height(turned(n))); 3]),
        night: Picture::of(SIZE, |n, _| {
            let share = land(n) * step(0.1, 0.6, height(turned(turned(n))));
            [0.9 * share, 0.7 * share, 0.35 * share]
        }),
        water: Picture::of(SIZE, |n, _| [1.0 - land(n)]),
    }
}
