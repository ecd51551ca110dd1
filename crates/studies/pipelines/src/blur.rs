// SPDX-License-Identifier: MIT OR Apache-2.0
//! Motion blur by layers: which moments they show, how they become a picture, and how far that is from the truth.
//!
//! Moments are shares of the time in which the shutter is open; grey is from 0 to 1.

use terrafill_results::SplitMix64;

/// Which moments layers show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Moments {
    /// The middle of each part of the exposure.
    Middle,
    /// Its end, as published: the current pose is one of them.
    #[cfg(test)]
    End,
    /// Anywhere in each part.
    Stratified,
    /// Anywhere.
    #[cfg(test)]
    Random,
}

impl Moments {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::Middle, Self::End, Self::Stratified, Self::Random];

    pub(crate) fn all(self, layers: u32, random: &mut SplitMix64) -> Vec<f64> {
        let count = f64::from(layers);
        let moment = |layer: u32| match self {
            Self::Middle => (f64::from(layer) + 0.5) / count,
            #[cfg(test)]
            Self::End => (f64::from(layer) + 1.0) / count,
            Self::Stratified => (f64::from(layer) + random.unit()) / count,
            #[cfg(test)]
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

/// Moment of a layer of a resolve, the current pose first.
pub(crate) fn moment_of(layer: u32, layers: u32) -> f64 {
    1.0 - f64::from(layer) / f64::from(layers)
}
