// SPDX-License-Identifier: MIT OR Apache-2.0
//! Heights grown from a seed: broad highs and lows, with ridges and valleys on them.
//!
//! Shares of the amplitude, −1 … 1, of places on a sphere. Value noise on a lattice through space
//! (Perlin and Hoffert, 1989) has no seam at ±180° and no pinch at the poles. Ridges are octaves of
//! noise folded where it changes its sign (Musgrave, 1993), each twice as fine and lower than the one before.
//!
//! Every machine must get the same bits, and the sine of one C library differs from another's in the
//! last one. Directions are therefore made by Bhaskara's rational sine, which four operations give. It
//! is off by up to 0.0016, which moves a hill and bends nothing: it is continuous and has the sine's
//! zeros and symmetries.

/// Lattice cells from the centre of the sphere to its surface, of the broad shape: highs and lows are
/// some 3,000 km across on a body like the Earth.
const BROAD_FREQUENCY: f64 = 2.0;
/// The same of the coarsest ridges.
const RIDGE_FREQUENCY: f64 = 5.0;
/// Octaves of ridges: the finest are 32 times as fine as the coarsest, some 40 km on the Earth.
const RIDGE_OCTAVES: u32 = 6;
/// Height of an octave over that of the one before: rougher than halves, so that slopes grow with detail.
const RIDGE_STRENGTH: f64 = 0.65;
/// Share of the height that is the broad shape's; the rest is that of the ridges.
const BROAD_SHARE: f64 = 0.35;
/// Value noise between 27 lattice points seldom comes near ±1; this much steeper, and cut off there, it
/// uses the whole range.
const CONTRAST: f64 = 1.6;

/// A planet's relief: shares of the amplitude by place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Relief {
    /// Another number is another planet.
    pub seed: u32,
}

impl Relief {
    /// Height as a share of the amplitude, −1 … 1.
    ///
    /// - `east`: half turns of longitude, any number of turns
    /// - `north`: half turns from the south pole, 0 … 1
    #[must_use]
    pub fn share(self, east: f64, north: f64) -> f64 {
        let from_axis = half_turn_sine(north);
        let direction = [
            from_axis * half_turn_sine(east + 0.5),
            from_axis * half_turn_sine(east),
            -half_turn_sine(north + 0.5),
        ];
        let broad = self.noise(0, direction.map(|c| c * BROAD_FREQUENCY));
        let (mut ridges, mut sum) = (0.0, 0.0);
        let (mut frequency, mut strength) = (RIDGE_FREQUENCY, 1.0);
        for octave in 1..=RIDGE_OCTAVES {
            let noise = self.noise(octave, direction.map(|c| c * frequency));
            ridges += strength * (1.0 - 2.0 * noise.abs());
            sum += strength;
            frequency *= 2.0;
            strength *= RIDGE_STRENGTH;
        }
        BROAD_SHARE * broad + (1.0 - BROAD_SHARE) * ridges / sum
    }

    /// Smooth, −1 … 1.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a few hundred at most, and whole"
    )]
    fn noise(self, octave: u32, place: [f64; 3]) -> f64 {
        let cell = place.map(|c| c.floor() as i32);
        let along: [f64; 3] = std::array::from_fn(|axis| {
            let t = place[axis] - place[axis].floor();
            t * t * (3.0 - 2.0 * t)
        });
        let value = (0..8).map(|corner| {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2 & 1];
            let weight: f64 = (0..3)
                .map(|axis| match step[axis] {
                    0 => 1.0 - along[axis],
                    _ => along[axis],
                })
                .product();
            weight * self.lattice(octave, std::array::from_fn(|axis| cell[axis] + step[axis]))
        });
        (value.sum::<f64>() * CONTRAST).clamp(-1.0, 1.0)
    }

    /// Uniform in −1 … 1 and independent of its neighbours, by the mixing of `SplitMix64` (Steele, Lea
    /// and Flood, 2014): whole numbers only.
    fn lattice(self, octave: u32, place: [i32; 3]) -> f64 {
        let numbers = [self.seed, octave].map(u64::from).into_iter();
        let numbers = numbers.chain(place.map(|c| u64::from(c.cast_unsigned())));
        let mixed = numbers.fold(0, |state: u64, number| {
            let mut z = (state ^ number).wrapping_add(0x9E37_79B9_7F4A_7C15);
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^ (z >> 31)
        });
        // The 53 bits that an f64 holds.
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Sine of half turns after Bhaskara I: `16 t (1 − t) / (5 − 4 t (1 − t))` in the first one.
fn half_turn_sine(half_turns: f64) -> f64 {
    let turned = half_turns.rem_euclid(2.0);
    let (sign, t) = if turned < 1.0 {
        (1.0, turned)
    } else {
        (-1.0, turned - 1.0)
    };
    let product = t * (1.0 - t);
    sign * 16.0 * product / (5.0 - 4.0 * product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_rational_sine_is_near_the_sine() {
        let worst = (-400..800).map(|i| {
            let t = f64::from(i) / 200.0;
            (half_turn_sine(t) - (t * PI).sin()).abs()
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 1.7e-3 && worst > 1e-3, "{worst}");
    }

    #[test]
    fn heights_are_what_they_were_to_the_last_bit() {
        let bits = |seed, east, north| Relief { seed }.share(east, north).to_bits();
        let found = [
            bits(1, 0.0, 0.5),
            bits(1, 0.3, 0.7),
            bits(2, 0.3, 0.7),
            bits(1, -0.99, 0.01),
            bits(1, 0.0, 1.0),
        ];
        assert_eq!(found, EXPECTED, "{found:#x?}");
    }

    const EXPECTED: [u64; 5] = [
        4_589_373_394_390_993_234,
        4_601_962_835_790_347_624,
        4_599_771_175_257_913_626,
        4_595_052_952_308_833_188,
        4_599_621_986_718_957_051,
    ];

    #[test]
    fn terrain_is_seamless_and_goes_high_and_low() {
        let heights = Relief { seed: 7 };
        let (mut lowest, mut highest, mut rising) = (1.0_f64, -1.0_f64, 0);
        for row in 0..=200 {
            let north = f64::from(row) / 200.0;
            // The same meridian from both sides, and all meridians at a pole.
            assert_eq!(heights.share(-1.0, north), heights.share(1.0, north));
            for column in 0..400 {
                let east = f64::from(column) / 200.0;
                let share = heights.share(east, north);
                assert!(share.abs() <= 1.0);
                let beside = heights.share(east + 1e-6, north);
                assert!((share - beside).abs() < 1e-3, "a cliff at {east}, {north}");
                rising += u32::from(beside > share);
                (lowest, highest) = (lowest.min(share), highest.max(share));
                if row == 0 {
                    assert_eq!(share, heights.share(0.0, north));
                }
            }
        }
        assert!(lowest < -0.7 && highest > 0.7, "{lowest} {highest}");
        assert!((30_000..50_000).contains(&rising), "{rising} of 80,400");
    }
}
