// SPDX-License-Identifier: MIT OR Apache-2.0
//! The random generator of runs, gates and reports: the same numbers from the same seed.

/// The generator of Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators".
#[derive(Debug, Clone)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Starts from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `limit`, by multiplication (Lemire, 2019); its bias of `limit` / 2⁶⁴ is nothing here.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the high half of the product is below `limit`"
    )]
    pub fn below(&mut self, limit: usize) -> usize {
        ((u128::from(self.next_u64()) * limit as u128) >> 64) as usize
    }

    /// From 0 to below 1, in steps of 2⁻⁵³.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (-53.0_f64).exp2()
    }

    /// The numbers below `count` in random order (Fisher and Yates, 1938).
    pub fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.below(last + 1));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_drawn_about_equally_often() {
        let mut random = SplitMix64::new(1);
        let mut drawn = [0_u32; 7];
        for _ in 0..70_000 {
            drawn[random.below(7)] += 1;
        }
        // Five standard deviations of a count with mean 10,000 are 463.
        assert!(drawn.iter().all(|&n| n.abs_diff(10_000) < 463), "{drawn:?}");
        let units: Vec<f64> = (0..70_000).map(|_| random.unit()).collect();
        assert!(units.iter().all(|unit| (0.0..1.0).contains(unit)));
        // Five standard deviations of a mean of so many.
        let mean = units.iter().sum::<f64>() / 70_000.0;
        assert!((mean - 0.5).abs() < 0.0055, "{mean}");
    }
}
