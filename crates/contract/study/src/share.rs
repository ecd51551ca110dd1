// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which shard measures which group.
//!
//! A group is never divided: its cases, its baseline passes and its repeats are compared with each other,
//! so one machine measures all of them. Every shard computes the same shares from the same arguments.

use std::collections::BTreeMap;

/// How groups are shared among shards.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Share {
    /// By turns: as many groups to each, and another share for most groups when one is added.
    #[default]
    Turns,
    /// By a hash of the group's first case: a group stays where it is when others come and go.
    Hash,
    /// By how long groups took in an earlier run, seconds by the group's first case: the longest first,
    /// each to the shard with the least so far (Graham, 1969, at most 4/3 of the best). A group that the
    /// earlier run did not have counts as the mean of the others.
    Durations(BTreeMap<String, f64>),
}

impl Share {
    /// Of each group, named by its first case, the shard that measures it, from 1 to `count`.
    #[must_use]
    pub fn shards(&self, groups: &[String], count: usize) -> Vec<usize> {
        match self {
            Self::Turns => (0..groups.len()).map(|at| at % count + 1).collect(),
            Self::Hash => groups
                .iter()
                .map(|group| hashed(group, count) + 1)
                .collect(),
            Self::Durations(known) => balanced(groups, known, count),
        }
    }
}

/// Below `count` (FNV-1a; Fowler, Noll and Vo, 1991).
fn hashed(group: &str, count: usize) -> usize {
    let hash = group.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    // The low bits of FNV-1a are those of the last letters: names that end alike would share a shard.
    let mixed = hash ^ (hash >> 32);
    usize::try_from(mixed % count as u64).unwrap_or(0)
}

fn balanced(groups: &[String], known: &BTreeMap<String, f64>, count: usize) -> Vec<usize> {
    let found: Vec<f64> = groups
        .iter()
        .filter_map(|group| known.get(group).copied())
        .collect();
    let mean = match found.len() {
        0 => 1.0,
        some => found.iter().sum::<f64>() / some as f64,
    };
    let seconds = |at: usize| known.get(&groups[at]).copied().unwrap_or(mean);
    let mut order: Vec<usize> = (0..groups.len()).collect();
    order.sort_by(|&a, &b| {
        let longest_first = seconds(b).total_cmp(&seconds(a));
        longest_first.then_with(|| groups[a].cmp(&groups[b]))
    });
    let mut loads = vec![0.0; count];
    let mut shards = vec![0; groups.len()];
    for at in order {
        let least = (0..count).min_by(|&a, &b| f64::total_cmp(&loads[a], &loads[b]));
        let shard = least.unwrap_or(0);
        loads[shard] += seconds(at);
        shards[at] = shard + 1;
    }
    shards
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups(count: usize) -> Vec<String> {
        (0..count)
            .map(|group| format!("filling/scene-{group}/globe/a"))
            .collect()
    }

    #[test]
    fn long_groups_are_kept_apart_and_loads_are_even() {
        let groups = groups(7);
        let seconds = [60.0, 5.0, 50.0, 10.0, 40.0, 20.0, 15.0];
        let known: BTreeMap<String, f64> = groups.iter().cloned().zip(seconds).collect();
        let shards = Share::Durations(known).shards(&groups, 2);
        let load = |shard: usize| -> f64 {
            let of_shard = shards.iter().zip(seconds).filter(|(of, _)| **of == shard);
            of_shard.map(|(_, seconds)| seconds).sum()
        };
        assert_eq!([load(1), load(2)], [100.0, 100.0]);
        // Negative control: dealt out in turn, the same groups give uneven shards.
        let shards = Share::Turns.shards(&groups, 2);
        let first: f64 = shards
            .iter()
            .zip(seconds)
            .filter(|(of, _)| **of == 1)
            .map(|(_, s)| s)
            .sum();
        assert!((first - 165.0).abs() < 1e-9);
    }

    #[test]
    fn a_group_that_is_new_counts_as_the_mean() {
        let groups = groups(4);
        let known = [(groups[0].clone(), 30.0), (groups[1].clone(), 10.0)];
        let shards = Share::Durations(known.into()).shards(&groups, 2);
        // 30, then 20, 20 and 10: 40 on each.
        assert_eq!(shards[0], shards[1], "{shards:?}");
        assert_eq!(shards[2], shards[3], "{shards:?}");
        // Nothing known: each counts alike.
        let shards = Share::Durations(BTreeMap::new()).shards(&groups, 2);
        assert_eq!(shards.iter().filter(|shard| **shard == 1).count(), 2);
    }

    #[test]
    fn a_hashed_group_stays_where_it_is_when_others_come() {
        let (few, many) = (groups(6), groups(40));
        let before = Share::Hash.shards(&few, 3);
        let after = Share::Hash.shards(&many, 3);
        assert_eq!(before, after[..6]);
        for shard in 1..=3 {
            let count = after.iter().filter(|of| **of == shard).count();
            assert!((6..=22).contains(&count), "{count} of 40 in shard {shard}");
        }
    }

    #[test]
    fn every_group_has_one_shard() {
        let groups = groups(11);
        let some: BTreeMap<String, f64> = groups.iter().take(5).cloned().zip([3.0; 5]).collect();
        for share in [Share::Turns, Share::Hash, Share::Durations(some)] {
            for count in [1, 2, 5, 20] {
                let shards = share.shards(&groups, count);
                assert_eq!(shards.len(), groups.len());
                assert!(
                    shards.iter().all(|shard| (1..=count).contains(shard)),
                    "{share:?}"
                );
                assert_eq!(
                    shards,
                    share.shards(&groups, count),
                    "the same for every shard"
                );
            }
        }
    }
}
