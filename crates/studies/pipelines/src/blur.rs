// SPDX-License-Identifier: MIT OR Apache-2.0
//! Motion blur by layers: a bar that moves across pixels, as a mean of so many moments, against the exact
//! integral over time.
//!
//! Pixels; a bar 20 pixels long moves by 32 while the shutter is open, full scale 1. The reference is the
//! integral in closed form: of a point's coverage an interval of time, of a pixel's an integral of that.

use terrafill_results::SplitMix64;

pub(crate) const BAR_PX: f64 = 20.0;
/// How far the bar moves, pixels.
pub(crate) const MOTION_PX: f64 = 32.0;
/// Places of the bar between pixels that are averaged over, apart by the golden ratio, which meets no
/// grid.
pub(crate) const PHASES: u32 = 64;
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// Pixels that the trail may touch.
pub(crate) const PIXELS: u32 = 54;

terrafill_results::named! {
    /// What a layer shows of a pixel.
    all pub(crate) enum Filter {
        /// Its middle, covered or not.
        Point = "point",
        /// The share that is covered.
        Box = "box",
    }
}

impl Filter {
    /// Of a pixel, the bar beginning at `start`.
    pub(crate) fn layer(self, pixel: u32, start: f64) -> f64 {
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
    pub(crate) fn exact(self, pixel: u32, start: f64) -> f64 {
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
    let [from, to] = times(place, start);
    to - from
}

/// When a point is covered first and last, of the time from 0 to 1.
fn times(place: f64, start: f64) -> [f64; 2] {
    let reached = ((place - start - BAR_PX) / MOTION_PX).clamp(0.0, 1.0);
    let left = ((place - start) / MOTION_PX).clamp(0.0, 1.0);
    [reached, left]
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

/// Which moments layers show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Moments {
    /// The middle of each part of the exposure.
    Middle,
    /// Its end, as published: the current pose is one of them.
    End,
    /// Anywhere in each part.
    #[cfg(test)]
    Stratified,
    /// Anywhere.
    Random,
}

impl Moments {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::Middle, Self::End, Self::Stratified, Self::Random];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Middle => "middle",
            Self::End => "end",
            #[cfg(test)]
            Self::Stratified => "stratified",
            Self::Random => "random",
        }
    }

    pub(crate) fn all(self, layers: u32, random: &mut SplitMix64) -> Vec<f64> {
        let count = f64::from(layers);
        let moment = |layer: u32| match self {
            Self::Middle => (f64::from(layer) + 0.5) / count,
            Self::End => (f64::from(layer) + 1.0) / count,
            #[cfg(test)]
            Self::Stratified => (f64::from(layer) + random.unit()) / count,
            Self::Random => random.unit(),
        };
        (0..layers).map(moment).collect()
    }
}

/// Errors of pixels of the trail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BlurError {
    pub(crate) rms: f64,
    pub(crate) max: f64,
}

/// Odd multiples of 1/256 pixel, which devices' grids of places have, so that no edge meets a pixel's middle.
pub(crate) fn starts() -> impl Iterator<Item = f64> {
    (0..PHASES)
        .map(|phase| ((f64::from(phase) * GOLDEN).fract() * 128.0).floor() / 128.0 + 1.0 / 256.0)
}

pub(crate) fn error_of(pairs: impl Iterator<Item = (f64, f64)>) -> BlurError {
    let (mut squares, mut count, mut max) = (0.0, 0.0, 0.0_f64);
    for (shown, exact) in pairs {
        let error = (shown - exact).abs();
        squares += error * error;
        count += 1.0;
        max = max.max(error);
    }
    BlurError {
        rms: (squares / count).sqrt(),
        max,
    }
}

terrafill_results::named! {
    /// How layers become a picture.
    all pub(crate) enum Resolve {
        /// As published: weights N − i for i from 1, 1 for the current pose, divided by the summed alpha.
        Published = "published",
        /// These weights over a background that is opaque.
        OverBackground = "over an opaque background",
        /// The same with weight N for the current pose.
        CurrentFirst = "current pose first",
    }
}

impl Resolve {
    /// Of a layer, the current pose first.
    pub(crate) fn weight(self, layer: u32, layers: u32) -> f64 {
        match (layer, self) {
            (0, Self::CurrentFirst) => f64::from(layers),
            (0, _) => 1.0,
            _ => f64::from(layers - layer),
        }
    }
}

/// Light of a trail that fades linearly with age: age is what is left of the time, its weight 2 (1 − age), of integral 1.
pub(crate) fn fading(place: f64, start: f64) -> f64 {
    let [from, to] = times(place, start);
    to * to - from * from
}

/// Moment of a layer of a resolve, the current pose first.
pub(crate) fn moment_of(layer: u32, layers: u32) -> f64 {
    1.0 - f64::from(layer) / f64::from(layers)
}
