// SPDX-License-Identifier: MIT OR Apache-2.0
//! In which order cases are measured.
//!
//! Every block measures each case once, in an order of its own: a case that always followed the same
//! other one would be measured with that one's caches and clock rates. The order comes from the
//! run's seed, so that a run can be repeated.

use terrafill_results::SplitMix64;

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
