// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a device may show of 25 depths: the published variance and light in `f64`, and by how much `f32` may be off.
//!
//! Bounds are those of sums in any order, with fused steps or without, and of divisions that are off by 2.5 units
//! in the last place, as interfaces allow.

use crate::variance::Moments;

/// A window of 5 × 5.
pub(crate) const TAPS: usize = 25;
/// Half a unit in the last place, relative.
const HALF: f64 = 5.960_464_477_539_063e-8;
/// What is flushed to 0 is smaller.
const FLUSHED: f64 = 1e-37;

/// A number and by how much it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) off: f64,
}

impl Bounded {
    pub(crate) fn allows(self, found: f32) -> bool {
        (f64::from(found) - self.value).abs() <= self.off
    }
}

/// Mean and variance of depths less an offset.
pub(crate) fn moments(taps: &[f32; TAPS], offset: f32) -> [Bounded; 2] {
    let less = taps.map(|tap| f64::from(tap) - f64::from(offset));
    let count = TAPS as f64;
    let mean = less.iter().sum::<f64>() / count;
    let magnitude = less.iter().map(|depth| depth.abs()).sum::<f64>() / count;
    let square = less.iter().map(|depth| depth * depth).sum::<f64>() / count;
    // Subtracting, dividing and 25 additions.
    let mean_off = (1.0 + 5.0 + count) * HALF * magnitude + FLUSHED;
    let square_off = (3.0 + 5.0 + count) * HALF * square + FLUSHED;
    let exact = less.iter().map(|depth| (depth - mean).powi(2)).sum::<f64>() / count;
    let off = square_off
        + 2.0 * mean.abs() * mean_off
        + mean_off * mean_off
        + 2.0 * HALF * (mean * mean + square);
    [
        Bounded {
            value: mean,
            off: mean_off,
        },
        Bounded { value: exact, off },
    ]
}

/// Between which shares of light a device may be; `None` where rounding leaves everything open.
///
/// - `least`: under the variance
pub(crate) fn light(
    taps: &[f32; TAPS],
    receiver: f32,
    way: Moments,
    least: Option<f64>,
) -> Option<[f64; 2]> {
    let offset = way.offset(receiver);
    let [mean, variance] = moments(taps, offset);
    let below = f64::from(receiver) - f64::from(offset);
    let gap = mean.value - below;
    let off = mean.off + 2.0 * HALF * (below.abs() + gap.abs());
    let [near, far] = [gap - off, gap + off];
    if far <= 0.0 {
        return Some([1.0; 2]);
    }
    let floor = least.unwrap_or(f64::NEG_INFINITY);
    let [low, high] = [-variance.off, variance.off].map(|off| (variance.value + off).max(floor));
    if low <= 0.0 {
        return None;
    }
    let share = |variance: f64, gap: f64| variance / (variance + gap * gap);
    let dark = share(low, far) * (1.0 - 10.0 * HALF);
    let lit = share(high, near.max(0.0)) * (1.0 + 10.0 * HALF);
    Some([dark, if near <= 0.0 { lit.max(1.0) } else { lit }])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_the_published_steps_and_not_other_depths() {
        let mut taps = [0.2_f32; TAPS];
        for (number, tap) in taps.iter_mut().enumerate().take(9) {
            *tap = 0.7 - 0.01 * number as f32;
        }
        let (mut first, mut second) = (0.0_f32, 0.0_f32);
        for tap in taps {
            first += tap / 25.0;
            second += tap * tap / 25.0;
        }
        let variance = second - first * first;
        let [mean, bounded] = moments(&taps, 0.0);
        assert!(
            mean.allows(first) && bounded.allows(variance),
            "{bounded:?} {variance}"
        );
        let gap = first - 0.2;
        let share = f64::from(variance / (variance + gap * gap));
        let [low, high] = light(&taps, 0.2, Moments::Published, None).expect("decided");
        assert!(
            low <= share && share <= high && high - low < 1e-4,
            "{low} {share} {high}"
        );
        // Negative controls: a tap more in shadow, and one that is off by a thousandth.
        taps[20] = 0.7;
        assert!(!moments(&taps, 0.0)[1].allows(variance));
        assert!(!mean.allows(first + 1e-3));
    }

    #[test]
    fn a_lit_plane_is_left_open_without_a_floor_and_lit_with_one() {
        let taps = [0.9_f32; TAPS];
        assert_eq!(light(&taps, 0.9, Moments::Published, None), None);
        let [low, high] = light(&taps, 0.9, Moments::Published, Some(1e-7)).expect("decided");
        assert!(low > 0.99 && high >= 1.0, "{low} {high}");
        assert_eq!(light(&taps, 0.95, Moments::Published, None), Some([1.0; 2]));
        // Negative control: what is in shadow.
        let [_, high] = light(&taps, 0.3, Moments::Published, Some(1e-7)).expect("decided");
        assert!(high < 1e-4, "{high}");
    }
}
