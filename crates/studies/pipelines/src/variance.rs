// SPDX-License-Identifier: MIT OR Apache-2.0
//! How variance shadows sum depths, and how maps store them. Depths are from 0 to 1.

use terrafill_results::SplitMix64;
use terrafill_shapes::grid::nearest;

terrafill_results::named! {
    /// How moments are summed.
    all pub(crate) enum Moments {
        /// Of depths, as published.
        Published = "published",
        /// Of depths about the middle of their range.
        AboutHalf = "about one half",
        /// Of depths from the receiver's.
        FromReceiver = "receiver subtracted",
    }
}

impl Moments {
    /// What is subtracted from depths.
    pub(crate) fn offset(self, receiver: f32) -> f32 {
        match self {
            Self::Published => 0.0,
            Self::AboutHalf => 0.5,
            Self::FromReceiver => receiver,
        }
    }
}

/// By Box and Muller, mean 0 and spread 1.
pub(crate) fn gaussian(random: &mut SplitMix64) -> f64 {
    let (a, b) = (1.0 - random.unit(), random.unit());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// How a map stores depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DepthFormat {
    /// Whole numbers of so many bits.
    Bits(u32),
    F32,
}

impl DepthFormat {
    pub(crate) const ALL: [Self; 4] = [Self::Bits(8), Self::Bits(16), Self::Bits(24), Self::F32];

    pub(crate) fn name(self) -> String {
        match self {
            Self::Bits(bits) => format!("{bits} bits"),
            Self::F32 => "f32".to_owned(),
        }
    }

    pub(crate) fn stored(self, depth: f64) -> f32 {
        nearest(match self {
            Self::Bits(bits) => {
                let steps = f64::from(bits).exp2() - 1.0;
                (depth * steps).round() / steps
            }
            Self::F32 => depth,
        })
    }
}
