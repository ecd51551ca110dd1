// SPDX-License-Identifier: MIT OR Apache-2.0
//! In which order cases are measured.
//!
//! Every block measures each case once, in an order of its own: a case that always followed the same
//! other one would be measured with that one's caches and clock rates. The order comes from the
//! run's seed, so that a run can be repeated.

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

    /// The numbers below `count` in random order (Fisher and Yates, 1938).
    pub fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.below(last + 1));
        }
        order
    }
}

/// Order of one block.
///
/// - `name`: of the group, so that groups of one size do not share their orders
pub(crate) fn block_order(
    seed: u64,
    name: &str,
    process: u32,
    block: u32,
    count: usize,
) -> Vec<usize> {
    // FNV-1a (Fowler, Noll and Vo, 1991).
    let bytes = name
        .bytes()
        .chain(process.to_le_bytes())
        .chain(block.to_le_bytes());
    let hash = bytes.fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    SplitMix64::new(hash).shuffled(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_block_measures_every_case_once_and_neighbours_change() {
        let mut neighbours = BTreeSet::new();
        for block in 0..20 {
            let order = block_order(7, "moon/globe", 0, block, 6);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4, 5]);
            neighbours.extend(order.windows(2).map(|pair| (pair[0], pair[1])));
        }
        assert!(neighbours.len() > 25, "{} of 30 pairs", neighbours.len());
        let [first, second] = [0, 1].map(|process| block_order(7, "a", process, 0, 9));
        assert_ne!(first, second, "processes have orders of their own");
        assert_eq!(first, block_order(7, "a", 0, 0, 9), "and can be repeated");
        assert_eq!(block_order(7, "a", 0, 0, 0), [0_usize; 0]);
    }
}
