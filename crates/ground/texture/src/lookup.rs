// SPDX-License-Identifier: MIT OR Apache-2.0
//! A table of the arctangent on [0, 1], as a texture holds it and as a sampler reads it.
//!
//! Texel i holds `atan(i / (N − 1)) / (π / 4)`: aligned to both ends, so that the octants meet, and
//! scaled to [0, 1], so that normalized formats lose no range. A sampler's linear filter weighs in
//! steps of 2⁻⁸ on common hardware (Vulkan `subTexelPrecisionBits`, whose least allowed value is 4,
//! is 8 on every desktop driver and on software ones), which limits it whatever the format.
//! [`Filter::LinearExact`] loads two texels and interpolates in the shader instead.

use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;
use terrafill_core::nearest_f32;

/// How a texel stores its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TexelFormat {
    /// 8 bit, normalized.
    R8Unorm,
    /// 16 bit, normalized.
    R16Unorm,
    /// Half float.
    R16Float,
    /// Single float.
    R32Float,
}

impl TexelFormat {
    /// Every format.
    pub const ALL: [Self; 4] = [
        Self::R8Unorm,
        Self::R16Unorm,
        Self::R16Float,
        Self::R32Float,
    ];

    /// Name within a route's.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::R8Unorm => "r8",
            Self::R16Unorm => "r16",
            Self::R16Float => "r16f",
            Self::R32Float => "r32f",
        }
    }

    /// Bytes of a texel.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::R8Unorm => 1,
            Self::R16Unorm | Self::R16Float => 2,
            Self::R32Float => 4,
        }
    }

    /// Largest difference between a number in [0, 1] and what is stored for it.
    #[must_use]
    pub fn rounding(self) -> f64 {
        match self {
            Self::R8Unorm => 0.5 / 255.0,
            Self::R16Unorm => 0.5 / 65535.0,
            // Half a unit in the last place below 1.
            Self::R16Float => 2.0_f64.powi(-12),
            Self::R32Float => 2.0_f64.powi(-25),
        }
    }

    /// The bits that store `number`, 0 … 1, in the low bytes.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "rounded and within 0 … 65535"
    )]
    pub(crate) fn bits_of(self, number: f64) -> u32 {
        match self {
            Self::R8Unorm => (number * 255.0).round_ties_even() as u32,
            Self::R16Unorm => (number * 65535.0).round_ties_even() as u32,
            Self::R16Float => half_bits(number),
            Self::R32Float => nearest_f32(number).to_bits(),
        }
    }

    /// What a shader reads from such bits.
    fn decode(self, bits: u32) -> f32 {
        match self {
            Self::R8Unorm => nearest_f32(f64::from(bits) / 255.0),
            Self::R16Unorm => nearest_f32(f64::from(bits) / 65535.0),
            Self::R16Float => half_value(bits),
            Self::R32Float => f32::from_bits(bits),
        }
    }
}

/// Bits of the half float nearest to `number`, 0 … 1 (IEEE 754 binary16, ties to even).
#[allow(clippy::cast_possible_truncation, reason = "rounded and below 2^16")]
fn half_bits(number: f64) -> u32 {
    // Below 2⁻¹⁴ numbers are subnormal: all in units of 2⁻²⁴.
    let exponent = number.log2().floor().max(-14.0);
    let units = (number * (10.0 - exponent).exp2()).round_ties_even();
    // A significand that rounds up to 2048 carries into the exponent by itself.
    (units + (exponent + 14.0) * 1024.0) as u32
}

/// The number that half-float bits without sign stand for, infinities and NaN left out.
fn half_value(bits: u32) -> f32 {
    let exponent = bits >> 10;
    let fraction = f64::from(bits & 1023);
    let value = if exponent == 0 {
        fraction * 2.0_f64.powi(-24)
    } else {
        (1024.0 + fraction) * (f64::from(exponent) - 25.0).exp2()
    };
    nearest_f32(value)
}

/// How a number between texels is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// A sampler's linear filter, weights in steps of 2⁻⁸.
    Linear,
    /// Two loads and an interpolation in `f32`.
    LinearExact,
}

impl Filter {
    /// Every filter.
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Linear, Self::LinearExact];

    /// Name within a route's.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Linear => "linear",
            Self::LinearExact => "linear-exact",
        }
    }
}

/// How a device's linear sampler weighs, and what its answers miss of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampler {
    /// Whether weights are not rounded to steps of 2⁻⁸.
    pub weighs_exactly: bool,
    /// Lowest and highest difference of an answer from the interpolation by those weights: a filter that
    /// calculates in the format itself rounds there, to one side perhaps.
    pub off: [f64; 2],
}

impl Sampler {
    /// What is common on hardware: weights in steps of 2⁻⁸, and no other error.
    pub const COMMON: Self = Self {
        weighs_exactly: false,
        off: [0.0; 2],
    };

    /// The middle of what its answers miss, and the variance round it if they do so evenly.
    pub(crate) fn bias_and_variance(&self) -> (f64, f64) {
        let [low, high] = self.off;
        let half = 0.5 * (high - low);
        (0.5 * (low + high), half * half / 3.0)
    }
}

/// The arctangent's table: what is uploaded, and what reading it gives.
#[derive(Debug, Clone)]
pub struct LookupTable {
    format: TexelFormat,
    filter: Filter,
    sampler: Sampler,
    codes: Vec<u32>,
    values: Vec<f32>,
    /// Largest difference of neighbouring texels.
    steepest: f64,
}

impl LookupTable {
    /// A table of `texels` entries, at least 2.
    #[must_use]
    pub fn arctangent(texels: u16, format: TexelFormat, filter: Filter) -> Self {
        let last = f64::from(texels.max(2) - 1);
        let codes: Vec<u32> = (0..texels.max(2))
            .map(|i| format.bits_of((f64::from(i) / last).atan() / FRAC_PI_4))
            .collect();
        let values: Vec<f32> = codes.iter().map(|code| format.decode(*code)).collect();
        let steepest = values
            .windows(2)
            .map(|pair| f64::from(pair[1]) - f64::from(pair[0]))
            .fold(0.0, f64::max);
        Self {
            format,
            filter,
            sampler: Sampler::COMMON,
            codes,
            values,
            steepest,
        }
    }

    /// Entries; the texture is this wide and 1 high.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.values.len()
    }

    /// How a texel is stored.
    #[must_use]
    pub fn format(&self) -> TexelFormat {
        self.format
    }

    /// How it is read; only [`Filter::Linear`] needs a sampler.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The texture's bytes, little endian.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let size = self.format.bytes();
        self.codes
            .iter()
            .flat_map(|code| code.to_le_bytes().into_iter().take(size))
            .collect()
    }

    /// WGSL that declares the table at `binding` of `group`, and its sampler, where one is needed,
    /// at the binding after it.
    #[must_use]
    pub fn declarations(&self, group: u32, binding: u32) -> String {
        let mut text =
            format!("@group({group}) @binding({binding}) var route_table: texture_2d<f32>;\n");
        if self.filter == Filter::Linear {
            let next = binding + 1;
            let _ = writeln!(
                text,
                "@group({group}) @binding({next}) var route_sampler: sampler;"
            );
        }
        text
    }

    /// Texel number `index`; the nearest one there is for a number outside, NaN for NaN.
    ///
    /// The texture unit's answer outside is 0 or a clamped texel, as the API's robustness has it;
    /// no route reads there for finite offsets.
    #[must_use]
    pub(crate) fn load(&self, index: f32) -> f32 {
        if index.is_nan() {
            return f32::NAN;
        }
        self.values[self.clamped(f64::from(index))]
    }

    /// The table as this sampler reads it.
    #[must_use]
    pub fn on(self, sampler: Sampler) -> Self {
        Self { sampler, ..self }
    }

    /// The sampler that it is taken to be read by.
    pub(crate) fn sampler(&self) -> &Sampler {
        &self.sampler
    }

    /// A linear sampler's answer at texture coordinate `u`; edges clamped.
    ///
    /// In common: texel space in fixed point with 8 fractional bits, rounded to nearest (Direct3D 11.3
    /// functional specification §7.18.8).
    #[must_use]
    pub fn sample(&self, u: f32) -> f32 {
        if u.is_nan() {
            return f32::NAN;
        }
        let texels = nearest_f32(to_f64(self.values.len()));
        if self.sampler.weighs_exactly {
            let place = f64::from(u) * f64::from(texels) - 0.5;
            let left = place.floor();
            let [a, b] = [left, left + 1.0].map(|i| f64::from(self.values[self.clamped(i)]));
            let (bias, _) = self.sampler.bias_and_variance();
            return nearest_f32(a + (place - left) * (b - a) + bias);
        }
        let fixed = (f64::from(u * texels) * 256.0 + 0.5).floor() - 128.0;
        let left = (fixed / 256.0).floor();
        let weight = nearest_f32((fixed - left * 256.0) / 256.0);
        let (a, b) = (
            self.values[self.clamped(left)],
            self.values[self.clamped(left + 1.0)],
        );
        a + weight * (b - a)
    }

    /// Steepest change of a sample with its texture coordinate.
    #[must_use]
    pub(crate) fn slope(&self) -> f64 {
        self.steepest * to_f64(self.values.len())
    }

    /// How far another device's sampler may be from [`Self::sample`]: finer weights or truncated ones
    /// are off by half a step of them, and a filter that calculates in the format itself rounds once
    /// more. Mesa's software rasterizer does both: floats are filtered with `f32` weights, 8-bit
    /// texels in 8 bits, which made an error of 2.9e-3 rad out of 1.5e-3.
    #[must_use]
    pub(crate) fn sampler_freedom(&self) -> f64 {
        let own_format = match self.format {
            TexelFormat::R8Unorm | TexelFormat::R16Unorm => self.format.rounding(),
            TexelFormat::R16Float | TexelFormat::R32Float => 0.0,
        };
        self.steepest / 512.0 + own_format
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "clamped to the table first"
    )]
    fn clamped(&self, index: f64) -> usize {
        index.clamp(0.0, to_f64(self.values.len() - 1)) as usize
    }
}

/// A table's length, which fits in 16 bits.
fn to_f64(length: usize) -> f64 {
    u16::try_from(length).map_or(f64::from(u16::MAX), f64::from)
}
