// SPDX-License-Identifier: MIT OR Apache-2.0
//! Depth: how a distance is stored in a depth buffer, and what of it comes back.
//!
//! Distances are along the viewing direction, metres, `f64`; stored depth in `[0, 1]`. Standard
//! and reversed depth are what a projection matrix makes of 1 / distance. Logarithmic depth is
//! written by the fragment shader as `log2(1 + distance) / log2(1 + far)` (Kemen 2009, "Logarithmic
//! depth buffer", with C = 1). Reversed depth gains only with float storage, whose fine steps near
//! 0 then meet the coarse ones of 1 / distance (Reed 2015, "Depth precision visualized").

use crate::operations::{ProgramBuilder, Value};
use crate::rounding::half_ulp;
use terrafill_core::nearest_f32;

/// How a distance becomes a depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DepthMapping {
    /// 0 at the near plane, 1 at the far plane or at infinity.
    Standard,
    /// 1 at the near plane, 0 at the far plane or at infinity.
    Reversed,
    /// In proportion to the logarithm of 1 m + distance; 1 at the far plane.
    Logarithmic,
}

/// How a depth is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DepthStorage {
    /// 24-bit normalised integer.
    Unorm24,
    /// 32-bit float.
    Float32,
}

impl DepthMapping {
    /// Every mapping.
    pub const ALL: [Self; 3] = [Self::Standard, Self::Reversed, Self::Logarithmic];

    /// Stable name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Reversed => "reversed",
            Self::Logarithmic => "logarithmic",
        }
    }
}

impl DepthStorage {
    /// Every storage.
    pub const ALL: [Self; 2] = [Self::Unorm24, Self::Float32];

    /// Stable name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unorm24 => "unorm24",
            Self::Float32 => "float32",
        }
    }
}

/// Why a depth format is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthFormatError {
    /// The near plane is not in front of the eye.
    #[error("near plane at {found} m, must be finite and above 0")]
    Near {
        /// What was given.
        found: f64,
    },
    /// The far plane is not behind the near plane.
    #[error("far plane at {found} m, must be beyond the near plane at {near} m")]
    Far {
        /// What was given.
        found: f64,
        /// The near plane.
        near: f64,
    },
    /// A logarithm has no end to be divided by.
    #[error("logarithmic depth needs a finite far plane")]
    EndlessLogarithm,
}

/// A depth buffer's mapping, storage and planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthFormat {
    mapping: DepthMapping,
    storage: DepthStorage,
    near_m: f64,
    far_m: f64,
}

/// Largest value of a 24-bit normalised integer.
const UNORM24_STEPS: f64 = 16_777_215.0;

impl DepthFormat {
    /// Checks the planes; `far_m` may be infinite, except for logarithmic depth.
    ///
    /// # Errors
    /// [`DepthFormatError`] where a plane is out of order.
    pub fn new(
        mapping: DepthMapping,
        storage: DepthStorage,
        near_m: f64,
        far_m: f64,
    ) -> Result<Self, DepthFormatError> {
        if !(near_m > 0.0 && near_m.is_finite()) {
            return Err(DepthFormatError::Near { found: near_m });
        }
        if far_m.is_nan() || far_m <= near_m {
            return Err(DepthFormatError::Far {
                found: far_m,
                near: near_m,
            });
        }
        if mapping == DepthMapping::Logarithmic && far_m.is_infinite() {
            return Err(DepthFormatError::EndlessLogarithm);
        }
        Ok(Self {
            mapping,
            storage,
            near_m,
            far_m,
        })
    }

    /// What this project draws with: reversed, 32-bit float, no far plane.
    ///
    /// # Errors
    /// [`DepthFormatError::Near`].
    pub fn reversed(near_m: f64) -> Result<Self, DepthFormatError> {
        Self::new(
            DepthMapping::Reversed,
            DepthStorage::Float32,
            near_m,
            f64::INFINITY,
        )
    }

    /// Stable name, such as `reversed-float32-infinite`.
    #[must_use]
    pub fn name(&self) -> String {
        let (mapping, storage) = (self.mapping.name(), self.storage.name());
        let far = if self.far_m.is_finite() {
            "finite"
        } else {
            "infinite"
        };
        format!("{mapping}-{storage}-{far}")
    }

    /// How a distance becomes a depth.
    #[must_use]
    pub fn mapping(&self) -> DepthMapping {
        self.mapping
    }

    /// How a depth is kept.
    #[must_use]
    pub fn storage(&self) -> DepthStorage {
        self.storage
    }

    /// Near plane, metres.
    #[must_use]
    pub fn near_m(&self) -> f64 {
        self.near_m
    }

    /// Far plane, metres; may be infinite.
    #[must_use]
    pub fn far_m(&self) -> f64 {
        self.far_m
    }

    /// Near over far; 0 without a far plane.
    #[must_use]
    pub fn near_over_far(&self) -> f64 {
        self.near_m / self.far_m
    }

    /// Depth of a distance, exact.
    #[must_use]
    pub fn depth(&self, distance_m: f64) -> f64 {
        let inverse = self.near_m / distance_m;
        let ratio = self.near_over_far();
        match self.mapping {
            DepthMapping::Standard => (1.0 - inverse) / (1.0 - ratio),
            DepthMapping::Reversed => (inverse - ratio) / (1.0 - ratio),
            DepthMapping::Logarithmic => (1.0 + distance_m).log2() / self.log2_far(),
        }
    }

    /// Distance of a depth, exact; infinite where nothing was drawn and no far plane is set.
    #[must_use]
    pub fn distance_m(&self, depth: f64) -> f64 {
        let ratio = self.near_over_far();
        match self.mapping {
            DepthMapping::Standard => self.near_m / ((1.0 - depth) + ratio * depth),
            DepthMapping::Reversed => self.near_m / (depth + ratio * (1.0 - depth)),
            DepthMapping::Logarithmic => (depth * self.log2_far()).exp2() - 1.0,
        }
    }

    /// `log2(1 + far)`.
    fn log2_far(&self) -> f64 {
        (1.0 + self.far_m).log2()
    }

    /// The depth as a shader reads it back from the buffer.
    ///
    /// Standard and reversed depth are taken as exact before they are stored: what the rasteriser
    /// adds depends on the triangle. Logarithmic depth is computed in `f32` by the fragment shader.
    #[must_use]
    pub fn stored(&self, distance_m: f64) -> f32 {
        let depth = match self.mapping {
            DepthMapping::Standard | DepthMapping::Reversed => self.depth(distance_m),
            DepthMapping::Logarithmic => {
                let scale = nearest_f32(1.0 / self.log2_far());
                f64::from((1.0 + nearest_f32(distance_m)).log2() * scale)
            }
        };
        self.quantized(depth)
    }

    /// Rounds to the nearest depth that the buffer can hold.
    #[must_use]
    pub fn quantized(&self, depth: f64) -> f32 {
        match self.storage {
            DepthStorage::Float32 => nearest_f32(depth),
            DepthStorage::Unorm24 => nearest_f32((depth * UNORM24_STEPS).round() / UNORM24_STEPS),
        }
    }

    /// Bound of `stored − depth` at a distance.
    #[must_use]
    pub fn stored_error(&self, distance_m: f64) -> f64 {
        let depth = self.depth(distance_m).abs();
        let storage = match self.storage {
            DepthStorage::Float32 => half_ulp(depth),
            // Half a step, and once more a float when it is read.
            DepthStorage::Unorm24 => 0.5 / UNORM24_STEPS + half_ulp(depth),
        };
        let written = match self.mapping {
            DepthMapping::Standard | DepthMapping::Reversed => 0.0,
            // 1 + distance rounded twice, log2 by 3 ULP (WGSL), scale and product.
            DepthMapping::Logarithmic => {
                let relative = 2.0 * half_ulp(1.0);
                let sum = relative / std::f64::consts::LN_2 / self.log2_far();
                sum + 6.0 * half_ulp(depth) + relative * depth
            }
        };
        storage + written
    }

    /// Variance of `stored − depth` at distances like this one, where every step is rounded correctly, as
    /// [`Self::stored`] does: what is to be expected, below [`Self::stored_error`], which holds on all
    /// devices.
    #[must_use]
    pub fn stored_variance(&self, distance_m: f64) -> f64 {
        let even = |half: f64| half * half / 3.0;
        let depth = self.depth(distance_m).abs();
        let storage = match self.storage {
            // A logarithm is an `f32` before it is stored.
            DepthStorage::Float32 if self.mapping == DepthMapping::Logarithmic => 0.0,
            DepthStorage::Float32 => even(half_ulp(depth)),
            // The grid of integers, and what the float that is read misses of its integer: nothing near 1,
            // where both grids fall together.
            DepthStorage::Unorm24 => {
                let integer = (depth * UNORM24_STEPS).round() / UNORM24_STEPS;
                let read = f64::from(self.quantized(depth)) - integer;
                even(0.5 / UNORM24_STEPS) + read * read
            }
        };
        let written = match self.mapping {
            DepthMapping::Standard | DepthMapping::Reversed => 0.0,
            DepthMapping::Logarithmic => {
                let sum = 1.0 + distance_m;
                let log2_per_m = 1.0 / (sum * std::f64::consts::LN_2);
                let summands = even(half_ulp(distance_m)) + even(half_ulp(sum));
                let logarithm = summands * log2_per_m * log2_per_m + even(half_ulp(sum.log2()));
                // The scale is one number, off by what it is off by.
                let scale = 1.0 / self.log2_far();
                let off = f64::from(nearest_f32(scale)) - scale;
                logarithm * scale * scale + (off * sum.log2()).powi(2) + even(half_ulp(depth))
            }
        };
        storage + written
    }

    /// Bound of the distance's error by storage alone, metres, at a distance: the step by the
    /// mapping's slope. Infinite where one step more is infinitely far.
    ///
    /// The distance from a depth by exact arithmetic is meant; what `f32` arithmetic adds is in
    /// `PositionRoute::residual`.
    #[must_use]
    pub fn residual_m(&self, distance_m: f64) -> f64 {
        let depth = self.depth(distance_m);
        let step = self.stored_error(distance_m);
        let error = |depth: f64| {
            let distance = self.distance_m(depth);
            // Beyond infinity the formula turns negative.
            if distance < 0.0 {
                f64::INFINITY
            } else {
                (distance - distance_m).abs()
            }
        };
        error(depth - step).max(error(depth + step))
    }

    /// Constants of [`Self::distance_steps`]: near, near / far, log2(1 + far) and 0.
    pub(crate) fn constants(&self) -> [f32; 4] {
        let logarithm = match self.mapping {
            DepthMapping::Logarithmic => nearest_f32(self.log2_far()),
            DepthMapping::Standard | DepthMapping::Reversed => 0.0,
        };
        [
            nearest_f32(self.near_m),
            nearest_f32(self.near_over_far()),
            logarithm,
            0.0,
        ]
    }

    /// Distance from a stored depth, from the constants in `slot`.
    ///
    /// Standard depth takes `1 − depth` first, which is exact above ½ (Sterbenz), and adds the far
    /// plane's share afterwards: `1 − (1 − near / far) · depth` would lose that share in rounding.
    pub(crate) fn distance_steps(
        &self,
        b: &mut ProgramBuilder,
        slot: usize,
        depth: Value,
    ) -> Value {
        let one = b.literal(1.0);
        match self.mapping {
            DepthMapping::Logarithmic => {
                let range = b.constant(4 * slot + 2);
                let exponent = b.multiply(depth, range);
                let power = b.power_of_two(exponent);
                b.subtract(power, one)
            }
            DepthMapping::Standard | DepthMapping::Reversed => {
                let inverse = self.inverse_distance_steps(b, slot, depth);
                let near = b.constant(4 * slot);
                b.divide(near, inverse)
            }
        }
    }

    /// Near over distance for a standard or reversed depth.
    fn inverse_distance_steps(&self, b: &mut ProgramBuilder, slot: usize, depth: Value) -> Value {
        let one = b.literal(1.0);
        let finite = self.far_m.is_finite();
        let rest = |b: &mut ProgramBuilder| b.subtract(one, depth);
        match (self.mapping == DepthMapping::Standard, finite) {
            (true, false) => rest(b),
            (true, true) => {
                let (rest, ratio) = (rest(b), b.constant(4 * slot + 1));
                b.fma(ratio, depth, rest)
            }
            (false, false) => depth,
            (false, true) => {
                let (rest, ratio) = (rest(b), b.constant(4 * slot + 1));
                b.fma(ratio, rest, depth)
            }
        }
    }
}
